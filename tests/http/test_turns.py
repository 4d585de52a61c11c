#!/usr/bin/env python3
"""http.turns: requests, replies of workers and ends of calls that the front finds together, in one turn
of its loop, in any order: it is stopped while they come, and so are its workers. Whatever comes of
that, every client is answered, every job ends by itself, and who subscribed is called.

SCATTERD_SEED=17 repeats a run, as far as the kernel does; SCATTERD_ROUNDS=1000 makes it longer."""

import contextlib
import os
import random
import signal
import sys
import threading
import time
import unittest

sys.dont_write_bytecode = True
import daemon  # noqa: E402
import test_callbacks  # noqa: E402

SEED = int(os.environ.get("SCATTERD_SEED", time.time_ns() % 1000000))
ROUNDS = int(os.environ.get("SCATTERD_ROUNDS", 100))
HOST = test_callbacks.RECEIVER.host
OVER = ("successful", "failed", "dismissed")
JSON = {"Content-Type": "application/json"}
ASYNC = JSON | {"Prefer": "respond-async"}
PAUSES = (0, 0, 0.0005, 0.002, 0.01)  # any will do


class Client(threading.Thread):
    """One request on a connection of its own, which is there already. One that leaves does not wait
    for the reply."""

    def __init__(self, server, request, leaves):
        super().__init__()
        self.request, self.leaves, self.reply, self.wrong = request, leaves, None, None
        self.connection = server.connect()
        self.connection.connect()

    def run(self):
        with contextlib.closing(self.connection):
            try:
                self.connection.request(*self.request)
                if not self.leaves:
                    self.reply = daemon.Reply(self.connection.getresponse())
            except Exception as why:  # noqa: BLE001: told by the test
                self.wrong = why


class Turns(unittest.TestCase):
    def setUp(self):
        print(f"http.turns: SCATTERD_SEED={SEED}", flush=True)
        self.random = random.Random(SEED)
        self.server = daemon.Daemon("--workers", "3", "--reuse-results", "0", "--heartbeat-seconds",
                                    "1", "--job-attempts", "2", "--callback-hosts", HOST)
        self.addCleanup(lambda: self.server.process.poll() is None and self.server.stop())
        self.server.wait_ready()
        self.count = 0
        self.accepted = {}  # job to body

    # ---- What is asked for ----

    def body(self):
        self.count += 1
        k = self.count
        return self.random.choice([
            f"x {k}", f"x {k}", f"call http://{HOST}/turn{k}", f"call http://{HOST}/turn{k}",
            f"sleep 0.03 {k}", f"batch 1 x {k}", f"batch 3 x {k}", f"batch 3 sleep 0.05 {k}",
            f"abort {k}", "bad", f"large {k}" + 70000 * " ", f"large {k}" + 3000000 * " "])

    def request_of_some_kind(self):
        job = self.random.choice([*self.accepted][-30:] or ["none"])
        kinds = [(45, ("POST", daemon.EXECUTE, self.body(), ASYNC)),
                 (7, ("POST", daemon.EXECUTE, self.body(), JSON | {"Prefer": "respond-async, wait=1"})),
                 (5, ("POST", daemon.EXECUTE, f"synchronous {self.count}", JSON)),
                 (8, ("GET", "/jobs", None, {})),
                 (6, ("GET", f"/jobs/{job}", None, {})),
                 (4, ("GET", f"/jobs/{job}", None, {"Prefer": "wait=1"})),
                 (6, ("GET", f"/jobs/{job}/events", None, {})),
                 (4, ("GET", f"/jobs/{job}/results", None, {})),
                 (6, ("DELETE", f"/jobs/{job}", None, {})),
                 (4, ("POST", "/data", f"[{self.count}]" + 2000000 * " ", JSON)),
                 (5, ("GET", "/healthz", None, {}))]
        return self.random.choices([request for _, request in kinds], [share for share, _ in kinds])[0]

    # ---- A turn ----

    def maybe(self, share):
        return self.random.random() < share

    def disturb(self):
        """The front or its workers stand still, or go on, between two requests."""
        if self.maybe(0.6):
            os.kill(self.server.pid, signal.SIGSTOP)
        time.sleep(self.random.choice(PAUSES))
        if self.maybe(0.3):
            self.server.signal_workers(signal.SIGCONT)
            time.sleep(self.random.choice(PAUSES))
        if self.maybe(0.4):
            os.kill(self.server.pid, signal.SIGCONT)

    def send(self, clients):
        if self.maybe(0.5):
            self.server.signal_workers(signal.SIGSTOP)
        try:
            for client in clients:
                client.start()
                self.disturb()
        finally:
            self.server.signal_workers(signal.SIGCONT)
            os.kill(self.server.pid, signal.SIGCONT)

    def note_reply(self, client):
        method, _, body, _ = client.request
        self.assertIsNone(client.wrong, client.request)
        if client.leaves:
            return
        reply = client.reply
        self.assertTrue(reply.status < 500 or method == "GET" or body.startswith("abort"),
                        (client.request, reply.status, reply.body[:300]))
        if reply.status == 201 and "jobID" in reply.json:
            self.accepted[reply.json["jobID"]] = body

    def one_round(self):
        clients = [Client(self.server, self.request_of_some_kind(), self.maybe(0.07))
                   for _ in range(self.random.randint(1, 7))]
        self.send(clients)
        for client in clients:
            client.join(daemon.PATIENCE)
            self.assertFalse(client.is_alive(), client.request)
            self.note_reply(client)
        self.assertIsNone(self.server.process.poll(), "\n".join(self.server.log[-40:]))

    def wait_until_all_are_over(self):
        def unfinished():
            return self.server.request("GET", "/jobs?status=accepted,running").json["jobs"]
        try:
            daemon.wait_until(lambda: not unfinished(), "all jobs to be over", 60)
        except AssertionError:
            self.fail(unfinished())

    # ---- What came of it ----

    def judge(self, job, body):
        info = self.server.request("GET", f"/jobs/{job}").json
        word = body.split()[0]
        if word == "abort":
            self.assertIn(info["status"], ("failed", "dismissed"), info)
        else:
            self.assertIn(info["status"], ("successful", "dismissed"), (body[:50], info))
        if word == "batch":
            parts = self.server.request("GET", f"/jobs?parent={job}").json["jobs"]
            self.assertEqual(len(parts), int(body.split()[1]))
            ends = OVER if info["status"] == "dismissed" else ("successful",)
            self.assertTrue({part["status"] for part in parts} <= {*ends}, (info, parts))
        elif info["status"] == "successful":
            result = self.server.request("GET", f"/jobs/{job}/results")
            self.assertEqual(result.body.decode(), body)
            if word == "call":
                path = "/" + body.rsplit("/", 1)[1]
                daemon.wait_until(lambda: test_callbacks.RECEIVER.at(path), f"a call of {path}")

    def test_any_order(self):
        for _ in range(ROUNDS):
            self.one_round()
            self.wait_until_all_are_over()
        for job, body in self.accepted.items():
            self.judge(job, body)
        self.assertEqual(self.server.stop(), 0)
        log = "\n".join(self.server.log)
        self.assertNotIn("Sanitizer", log)
        self.assertNotIn("runtime error", log)


if __name__ == "__main__":
    unittest.main()
