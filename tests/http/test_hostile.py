"""What is no HTTP, too much of it, or HTTP in odd ways."""

import contextlib
import os
import random
import socket
import subprocess
import threading
import unittest

import daemon

GET = b"GET /healthz HTTP/1.1\r\nHost: a\r\n"
LAST = GET + b"Connection: close\r\n\r\n"
HEAD = f"POST {daemon.EXECUTE} HTTP/1.1\r\nHost: a\r\nContent-Type: application/json\r\n".encode()


class Hostile(daemon.Case):

    def assert_alive(self):
        self.assertEqual(self.execute("alive").body, b"alive")

    def test_garbage(self):
        for data in (b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03", b"\r\n\r\n\r\n\r\n",
                     b"GET\r\n\r\n", b"GET / HTTP/9.9\r\n\r\n", b"HELO there\r\n\r\n",
                     b"GET / HTTP/1.1\nHost: a\n\n", b"\0" * 1000, b"GET / HTTP/1.1\r\n: x\r\n\r\n",
                     b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n"):
            with self.subTest(data), self.daemon.raw() as plain:
                plain.sendall(data)
                plain.shutdown(socket.SHUT_WR)
                self.assertNotRegex(daemon.read_all(plain), rb"^HTTP/1\.1 5(?!0[15])")
        self.assert_alive()

    def test_garbage_is_logged(self):
        self.exchange(b"GET / HTTP/9.9\r\nHost: a\r\n\r\n")
        self.daemon.wait_for_log(r"event=http message=.*505")

    def test_random_bytes_and_mutations(self):
        seed = int(os.environ.get("SCATTERD_SEED") or random.randrange(1 << 32))
        print(f"http.hostile: SCATTERD_SEED={seed}", flush=True)
        source = random.Random(seed)
        good = HEAD + b"Content-Length: 5\r\n\r\nabcde"
        clients = []
        for _ in range(300):
            data = bytearray(good)
            for _ in range(source.randrange(1, 6)):
                data[source.randrange(len(data))] = source.randrange(256)
            clients.append((bytes(data), self.daemon.raw()))
            clients[-1][1].sendall(data)
            clients[-1][1].shutdown(socket.SHUT_WR)
        for data, plain in clients:
            with self.subTest(data), plain:
                self.assertNotRegex(daemon.read_all(plain), rb"^HTTP/1\.1 5(?!0[15])")
        self.assert_alive()

    def test_headers_that_others_read_differently(self):
        """None of them makes a request of what follows, which may be a body."""
        for line in (b"Content-Length:\r\n 44", b"Content-Length: \r\n\t44", b"A: b\r\n c",
                     b"A:   b\r\n c", b"Transfer-Encoding : chunked", b"A\t: b", b": x", b":",
                     b"A: b\0c", b"A: b\r\n: x\r\nContent-Length: 44", b"Host : b",
                     b"Content-Len: 4\r\n gth", b"A: b\r\n: x"):
            for more in (b"", b"Z: z\r\n"):
                with self.subTest(line, more=more):
                    reply = self.exchange(HEAD + line + b"\r\n" + more + b"\r\n" +
                                          b"GET /smuggled HTTP/1.1\r\nHost: a\r\n\r\n")
                    self.assertRegex(reply, rb"^HTTP/1\.1 400 ")
                    self.assertIn(b"Connection: close", reply)
                    self.assertNotIn(b"404", reply)
        self.assert_alive()

    def test_headers_of_all_sizes(self):
        """However its buffer has to grow, a good header is taken as one."""
        with contextlib.closing(self.daemon.connect()) as connection:
            for size in range(0, 15000, 331):
                fields = {f"X-{k}": "x" * (size // 20) for k in range(20)}
                connection.request("GET", "/healthz", headers={"A": "", "B": " \t b ", **fields})
                with connection.getresponse() as response:
                    self.assertEqual(response.status, 200, response.read())
                    response.read()

    def test_long_header(self):
        for data in (GET + b"A: " + b"x" * 20000 + b"\r\n\r\n",
                     GET + b"".join(b"A%d: %050d\r\n" % (k, k) for k in range(300)) + b"\r\n"):
            reply = self.exchange(data.replace(b"Host: a", b"Host: a\r\nConnection: close"))
            self.assertTrue(reply.startswith(b"HTTP/1.1 431 "), reply[:100])
            self.assertIn(b"application/problem+json", reply)
        self.assert_alive()

    def test_header_bomb(self):
        reply = self.exchange(GET + b"A: " + b"x" * 10000000)
        self.assertRegex(reply, rb"^HTTP/1\.1 431 ")
        reply = self.exchange(GET + b"A: b\r\n" * 1000000)
        self.assertRegex(reply, rb"^HTTP/1\.1 431 ")
        self.assert_alive()

    def test_long_target(self):
        reply = self.exchange(b"GET /" + b"x" * 10000 + b" HTTP/1.1\r\nHost: a\r\n"
                              b"Connection: close\r\n\r\n")
        self.assertTrue(reply.startswith(b"HTTP/1.1 414 "), reply[:100])
        self.assertIn(b"application/problem+json", reply)
        reply = self.exchange(b"GET /" + b"x" * 1000000 + b" HTTP/1.1\r\nHost: a\r\n\r\n")
        self.assertRegex(reply, rb"^HTTP/1\.1 414 ")
        self.assert_alive()

    def test_pipelining(self):
        post = HEAD + b"Content-Length: 3\r\n\r\nabc"
        reply = self.exchange(post + GET + b"\r\n" + post + post + LAST)
        self.assertEqual(reply.count(b"HTTP/1.1 200 OK"), 5)
        self.assertEqual(reply.count(b"\r\n\r\nabc"), 3)
        self.assertEqual(reply.count(b'{"status":"ok"}'), 2)

    def test_pipelining_deep(self):
        reply = self.exchange((GET + b"\r\n") * 2000 + LAST)
        self.assertEqual(reply.count(b"HTTP/1.1 200 OK"), 2001)

    def test_field_injection(self):
        reply = self.exchange(b"GET /healthz HTTP/1.1\r\nHost: a\r\nX-Request-Id: a\rX: y\r\n"
                              b"Connection: close\r\n\r\n")
        self.assertNotIn(b"X: y", reply)


class Many(daemon.Case):
    options = ["--connections", "300", "--queue", "300"]

    def test_parallel_connections(self):
        connections = [self.daemon.raw() for _ in range(200)]
        for k, plain in enumerate(connections):
            body = b"sleep 0.01" if k % 10 == 0 else b"%d" % k
            plain.sendall(HEAD + b"Content-Length: %d\r\nConnection: close\r\n\r\n%s" %
                          (len(body), body))
        for k, plain in enumerate(connections):
            reply = daemon.read_all(plain)
            self.assertTrue(reply.startswith(b"HTTP/1.1 200 "), reply)
            self.assertTrue(reply.endswith(b"sleep 0.01" if k % 10 == 0 else b"%d" % k))
            plain.close()

    def test_threads_with_keep_alive(self):
        wrong = []

        def client(name):
            connection = self.daemon.connect()
            for k in range(50):
                body = f"{name} {k}"
                connection.request("POST", daemon.EXECUTE, body,
                                   {"Content-Type": "application/json"})
                reply = daemon.Reply(connection.getresponse())
                if (reply.status, reply.body) != (200, body.encode()):
                    wrong.append((body, reply.status, reply.body))
            connection.close()

        threads = [threading.Thread(target=client, args=(k,)) for k in range(20)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(wrong, [])

    def test_more_connections_than_allowed(self):
        idle = [self.daemon.raw() for _ in range(400)]
        daemon.wait_until(lambda: len(daemon.descriptors(self.daemon.pid)) > 300, "300 connections")
        for plain in idle:
            plain.close()
        self.assertEqual(self.execute("alive").body, b"alive")


def own_address():
    """An address of this machine that is not loopback, "" if it has none."""
    told = subprocess.run(["hostname", "-I"], check=False, capture_output=True, text=True).stdout
    return next((word for word in told.split() if "." in word), "")


@unittest.skipIf(not own_address(), "this machine has no address but loopback")
class PerAddress(daemon.Case):
    options = ["--connections-per-address", "5", "--allow-anonymous", "1", "--listen", "0.0.0.0:0"]

    def knock(self):
        plain = socket.create_connection((own_address(), self.daemon.port))
        plain.settimeout(daemon.PATIENCE)
        return plain

    def test_those_of_this_machine_are_not_counted(self):
        idle = [self.daemon.raw() for _ in range(20)]
        self.assertEqual(self.get("/healthz").status, 200)
        for plain in idle:
            plain.close()

    def test_one_address_gets_no_more(self):
        held = []

        def hold():
            """One more that serves; those that closed may be counted for a moment still."""
            plain = self.knock()
            with contextlib.suppress(ConnectionError):
                plain.sendall(GET + b"\r\n")
                if plain.recv(1000).startswith(b"HTTP/1.1 200 "):
                    held.append(plain)
                    return True
            plain.close()
            return False
        for _ in range(5):
            daemon.wait_until(hold, "a connection that serves")
        with self.knock() as sixth:
            self.assertEqual(daemon.read_all(sixth), b"")
        for plain in held:
            plain.close()
        daemon.wait_until(hold, "room again")
        held[-1].close()


if __name__ == "__main__":
    unittest.main()
