"""Bodies: how they arrive, how large they may be, how slowly; framing."""

import os
import time
import unittest

import daemon

HEAD = f"POST {daemon.EXECUTE} HTTP/1.1\r\nHost: a\r\nContent-Type: application/json\r\n".encode()
CHUNKED = HEAD + b"Transfer-Encoding: chunked\r\n"
CLOSE = b"Connection: close\r\n\r\n"
LIMIT = 300000


def chunks(*parts):
    return b"".join(b"%x\r\n%s\r\n" % (len(part), part) for part in parts) + b"0\r\n\r\n"


class Bodies(daemon.Case):
    options = ["--body-bytes", str(LIMIT), "--spool-bytes", "100000"]

    def assert_refused(self, reply, status):
        self.assertTrue(reply.startswith(b"HTTP/1.1 %d " % status), reply)
        self.assertIn(b"\r\nContent-Type: application/problem+json\r\n", reply)
        self.assertIn(b"\r\nConnection: close\r\n", reply)
        self.assertIn(b'"status":%d' % status, reply)

    def test_chunked(self):
        reply = self.exchange(CHUNKED + CLOSE + chunks(b"abc", b"defg"))
        self.assertTrue(reply.startswith(b"HTTP/1.1 200 "), reply)
        self.assertTrue(reply.endswith(b"\r\n\r\nabcdefg"), reply)

    def test_byte_by_byte(self):
        data = CHUNKED + CLOSE + chunks(b"abc", b"defg")
        with self.daemon.raw() as plain:
            for byte in data:
                plain.sendall(bytes([byte]))
            reply = daemon.read_all(plain)
        self.assertTrue(reply.endswith(b"\r\n\r\nabcdefg"), reply)

    def test_memory_and_file_give_the_same(self):
        for size in (99999, 100000, 100001, 250000, LIMIT):
            body = os.urandom(size)
            self.assertEqual(self.execute(body).body, body)

    def test_too_large_by_its_length(self):
        self.assert_problem(self.execute(b"x" * (LIMIT + 1)), 413, "body-bytes")
        reply = self.exchange(HEAD + b"Content-Length: 1000000000000\r\n\r\n")
        self.assert_refused(reply, 413)

    def test_too_large_as_it_comes(self):
        reply = self.exchange(CHUNKED + b"\r\n" + chunks(*[b"x" * 1000] * 500))
        self.assert_refused(reply, 413)

    def test_refusal_arrives_while_the_client_still_sends(self):
        body = b"x" * 20000000
        for head in (HEAD + b"Content-Length: %d\r\n\r\n" % len(body), CHUNKED + b"\r\n"):
            sent = body if head.startswith(HEAD + b"Content-Length") else chunks(body)
            self.assert_refused(self.exchange(head + sent), 413)

    def test_refused_before_the_body_is_sent(self):
        reply = self.exchange(HEAD.replace(b"json", b"pdf") + b"Expect: 100-continue\r\n"
                              b"Content-Length: 100\r\n\r\n")
        self.assert_refused(reply, 415)

    def test_expect_continue(self):
        with self.daemon.raw() as plain:
            plain.sendall(HEAD + b"Expect: 100-continue\r\nContent-Length: 3\r\n" + CLOSE)
            self.assertEqual(plain.recv(25), b"HTTP/1.1 100 Continue\r\n\r\n")
            plain.sendall(b"abc")
            self.assertTrue(daemon.read_all(plain).endswith(b"\r\n\r\nabc"))

    def test_two_lengths(self):
        length, coding = b"Content-Length: 3\r\n", b"Transfer-Encoding: chunked\r\n"
        for fields in (length + length, length + coding, coding + coding):
            self.assert_refused(self.exchange(HEAD + fields + b"\r\nabc"), 400)

    def test_unknown_transfer_coding(self):
        reply = self.exchange(HEAD + b"Transfer-Encoding: gzip, chunked\r\n\r\n")
        self.assert_refused(reply, 501)

    def test_bad_length(self):
        for length in (b"x", b"-1", b"1.5", b"99999999999999999999999"):
            reply = self.exchange(HEAD + b"Content-Length: " + length + b"\r\n\r\n")
            self.assertRegex(reply, rb"^HTTP/1\.1 4(00|13) ")

    def test_bad_chunks(self):
        for data in (b"zz\r\nabc\r\n0\r\n\r\n", b"3\r\nabcd\r\n0\r\n\r\n", b"-1\r\n"):
            reply = self.exchange(CHUNKED + CLOSE + data)
            self.assertRegex(reply, rb"^(HTTP/1\.1 400 |$)")
        self.assertEqual(self.execute("alive").body, b"alive")

    def test_large_reply(self):
        size = 50000000
        reply = self.execute(f"big {size}")
        self.assertEqual(reply.status, 200)
        self.assertEqual(reply.body, b"x" * size)

    def test_keep_alive_after_each_kind_of_reply(self):
        connection = self.daemon.connect()
        headers = {"Content-Type": "application/json"}
        for body in (b"abc", b"big 1000000", b"problem", b"", b"x" * 200000, b"abc"):
            connection.request("POST", daemon.EXECUTE, body, headers)
            reply = daemon.Reply(connection.getresponse())
            self.assertIn(reply.status, (200, 422))
            self.assertIsNone(reply.headers["Connection"])
        connection.close()

    def test_client_that_reads_nothing(self):
        with self.daemon.raw() as plain:
            plain.sendall(HEAD + b"Content-Length: 12\r\n\r\nbig 50000000")
            time.sleep(0.2)
        self.assertEqual(self.execute("alive").body, b"alive")


class Slow(daemon.Case):
    options = ["--receive-seconds", "3", "--idle-seconds", "3", "--receive-rate", "1000"]

    def assert_times_out(self, *pieces, pause=0.3):
        """Sends pieces with pauses; a 408 comes and the connection is closed."""
        with self.daemon.raw() as plain:
            try:
                for piece in pieces:
                    plain.sendall(piece)
                    time.sleep(pause)
            except (BrokenPipeError, ConnectionResetError):
                pass
            reply = daemon.read_all(plain)
        return reply

    def test_silent_body(self):
        reply = self.assert_times_out(HEAD + b"Content-Length: 5\r\n\r\nabc")
        self.assertTrue(reply.startswith(b"HTTP/1.1 408 "), reply)
        self.assertIn(b"application/problem+json", reply)

    def test_dripping_body(self):
        pieces = [HEAD + b"Content-Length: 50\r\n\r\n"] + [b"x"] * 50
        reply = self.assert_times_out(*pieces)
        self.assertTrue(reply.startswith(b"HTTP/1.1 408 "), reply)

    def test_dripping_header(self):
        reply = self.assert_times_out(b"GET / HTTP/1.1\r\n", *[b"A: b\r\n"] * 30)
        self.assertTrue(reply.startswith(b"HTTP/1.1 408 "), reply)

    def test_idle_connections_are_closed(self):
        with self.daemon.raw() as plain:
            self.assertEqual(daemon.read_all(plain), b"")
        with self.daemon.raw() as plain:
            plain.sendall(b"GET /healthz HTTP/1.1\r\nHost: a\r\n\r\n")
            self.assertTrue(daemon.read_all(plain).endswith(b'{"status":"ok"}'))

    def test_a_running_request_has_its_time(self):
        self.assertEqual(self.execute("sleep 7").status, 200)


class Spool(daemon.Case):
    options = ["--spool-bytes", "0"]

    def test_spool_has_no_name(self):
        with self.daemon.raw() as plain:
            plain.sendall(HEAD + b"Content-Length: 2000\r\n\r\n" + b"x" * 1000)

            def in_file():
                return any(what.startswith(self.daemon.data + "/#") or "/spool-" in what
                           for what in daemon.descriptors(self.daemon.pid).values())
            daemon.wait_until(in_file, "a body in the data directory")
            self.assertEqual(set(os.listdir(self.daemon.data)) - daemon.STORE, set())
        daemon.wait_until(lambda: not in_file(), "the body to go with its client")


if __name__ == "__main__":
    unittest.main()
