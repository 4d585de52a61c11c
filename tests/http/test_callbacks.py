#!/usr/bin/env python3
"""http.callbacks: subscribers are called, signed, again and again if need be, and only if allowed.
/req/callback/job-callback."""

import base64
import hashlib
import hmac
import http.server
import json
import sys
import threading
import unittest

sys.dont_write_bytecode = True
import daemon  # noqa: E402

KEY = "a key of the test"


class Receiver(http.server.ThreadingHTTPServer):
    """Keeps what it is sent; answers each path with the statuses listed for it, then 204."""

    daemon_threads = True

    def __init__(self):
        super().__init__(("127.0.0.1", 0), Handler)
        self.got = []
        self.statuses = {}
        threading.Thread(target=self.serve_forever, daemon=True).start()

    @property
    def host(self):
        return f"127.0.0.1:{self.server_port}"

    def at(self, path):
        return [one for one in self.got if one[0] == path]


class Handler(http.server.BaseHTTPRequestHandler):
    def do_POST(self):
        body = self.rfile.read(int(self.headers["Content-Length"]))
        self.server.got.append((self.path, self.headers, body))
        waiting = self.server.statuses.get(self.path, [])
        status = waiting.pop(0) if waiting else 204
        self.send_response(status)
        if 300 <= status < 400:
            self.send_header("Location", f"http://{self.server.host}/elsewhere")
        self.send_header("Content-Length", "0")
        self.end_headers()

    def log_message(self, *_):
        pass


RECEIVER = Receiver()


class Callbacks(daemon.Case):
    options = ["--workers", "2", "--callback-hosts", f"hooks.example, {RECEIVER.host}",
               "--callback-key", KEY, "--callback-attempts", "2"]

    def submit(self, body):
        reply = self.execute(body, Prefer="respond-async")
        self.assertEqual(reply.status, 201, reply.body)
        return reply.json["jobID"]

    def called(self, path, count=1):
        return daemon.wait_until(lambda: len(RECEIVER.at(path)) >= count and RECEIVER.at(path),
                                 f"{count} calls of {path}")

    def log(self, job):
        return [line["text"] for line in self.get(f"/jobs/{job}").json["log"]]

    def test_success(self):
        job = self.submit(f"call http://{RECEIVER.host}/success")
        (_, headers, body), = self.called("/success")
        self.assertEqual(body, self.get(f"/jobs/{job}/results").body)
        self.assertEqual(headers["Content-Type"], "application/json")
        self.assertEqual(headers["webhook-id"], f"{job}-successUri")
        signed = f"{headers['webhook-id']}.{headers['webhook-timestamp']}.".encode() + body
        expected = base64.b64encode(hmac.new(KEY.encode(), signed, hashlib.sha256).digest())
        self.assertEqual(headers["webhook-signature"], "v1," + expected.decode())
        daemon.wait_until(lambda: "successUri: attempt 1, answered 204" in self.log(job), "its log")

    def test_failure(self):
        job = self.submit(f"fail http://{RECEIVER.host}/failed")
        (_, _, body), = self.called("/failed")
        info = json.loads(body)
        self.assertEqual((info["jobID"], info["status"]), (job, "failed"))

    def test_again(self):
        RECEIVER.statuses["/again"] = [500]
        job = self.submit(f"call http://{RECEIVER.host}/again")
        first, second = self.called("/again", 2)
        self.assertEqual(first[1]["webhook-id"], second[1]["webhook-id"])
        daemon.wait_until(lambda: "successUri: attempt 2, answered 204" in self.log(job), "its log")
        self.assertIn("successUri: attempt 1, answered 500; again in 1 s", self.log(job))

    def test_given_up_and_no_redirects(self):
        RECEIVER.statuses["/moved"] = [302, 307]
        job = self.submit(f"call http://{RECEIVER.host}/moved")
        self.called("/moved", 2)
        daemon.wait_until(
            lambda: "successUri: attempt 2, answered 307; given up" in self.log(job), "its log")
        self.assertEqual(RECEIVER.at("/elsewhere"), [])

    def test_nobody_listens(self):
        job = self.submit("call http://hooks.example/x")
        daemon.wait_until(lambda: any("given up" in line for line in self.log(job)), "the end")

    def test_not_allowed(self):
        for uri in ("http://other.example/", f"http://{RECEIVER.host}.evil.example/",
                    f"http://{RECEIVER.host}@evil.example/", "ftp://hooks.example/", "/x",
                    "http://hooks.example:81/", f"http://evil.example\\@{RECEIVER.host}/"):
            with self.subTest(uri):
                reply = self.execute(f"call {uri}", Prefer="respond-async")
                problem = self.assert_problem(reply, 400, "callback-hosts")
                self.assertEqual(problem["errors"][0]["pointer"], "/subscriber/successUri")


class Restart(unittest.TestCase):
    def test_a_call_that_is_due_is_made_by_the_next_daemon(self):
        options = ["--workers", "2", "--callback-hosts", RECEIVER.host]
        RECEIVER.statuses["/later"] = [503]
        first = daemon.Daemon(*options)
        first.wait_ready()
        first.request("POST", daemon.EXECUTE, f"call http://{RECEIVER.host}/later",
                      {"Prefer": "respond-async"})
        daemon.wait_until(lambda: RECEIVER.at("/later"), "the first call")
        first.stop(daemon.signal.SIGKILL, keep=True)
        second = daemon.Daemon(*options, directory=first.directory)
        daemon.wait_until(lambda: len(RECEIVER.at("/later")) >= 2, "the second call")
        self.assertEqual(second.stop(), 0)


class Off(daemon.Case):
    def test_off_by_default(self):
        reply = self.execute(f"call http://{RECEIVER.host}/off", Prefer="respond-async")
        self.assert_problem(reply, 400, "callback-hosts")


if __name__ == "__main__":
    unittest.main()
