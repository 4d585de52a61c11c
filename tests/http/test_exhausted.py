#!/usr/bin/env python3
"""http.exhausted: descriptors, processes and memory files run out, for the front or for workers, in
each call in its turn or for a while. The daemon answers or closes, does not spin, loses nothing it
accepted, and is well when there is enough again. SCATTERD_EVERY=1 takes every call."""

import contextlib
import errno
import http.client
import itertools
import os
import resource
import shutil
import signal
import sys
import unittest

sys.dont_write_bytecode = True
import daemon  # noqa: E402
import faults as ordered  # noqa: E402
from accounting import LARGE, REFUSALS, account, submit, work  # noqa: E402

EVERY = os.environ.get("SCATTERD_EVERY")
OPTIONS = ["--workers", "3", "--spool-bytes", "64KiB", "--job-attempts", "100",
           "--reuse-results", "0"]
JSON = {"Content-Type": "application/json"}
ORDERS = [("memfd", errno.EMFILE, "front"), ("memfd", errno.ENOMEM, "workers"),
          ("map", errno.ENOMEM, "workers"),
          ("fork", errno.EAGAIN, "front"), ("pair", errno.EMFILE, "front"),
          ("accept", errno.EMFILE, "front"), ("accept", errno.ENOMEM, "front"),
          ("watch", errno.ENOSPC, "front")]


class Case(unittest.TestCase):
    def setUp(self):
        self.faults = ordered.Faults()
        self.addCleanup(self.faults.close)
        self.addCleanup(shutil.rmtree, self.faults.directory, True)
        self.server = None

    def start(self, *options, before=None):
        self.server = daemon.Daemon(*OPTIONS, *options, directory=self.faults.directory,
                                    environment=self.faults.environment, before=before)
        server = self.server
        self.addCleanup(lambda: server.process.poll() is None and server.stop())
        return server

    def assert_well(self):
        """It has not ended, and does everything."""
        self.assertIsNone(self.server.process.poll(), "\n".join(self.server.log[-20:]))
        log = "\n".join(self.server.log)
        self.assertNotIn("Sanitizer", log)
        self.assertNotIn("runtime error", log)
        accepted = {}
        self.assertTrue(work(self.server, accepted))
        self.assertEqual(account(self.server, accepted, False), 0)


class EachCall(Case):
    def one(self, kind, error, where, n, accepted):
        """The n-th call fails while everything is asked for; whether one did."""
        refusals = REFUSALS + ((422,) if (kind, where) == ("map", "workers") else ())  # memory-bytes
        self.faults.fail(kind, error, after=n, times=1, where=where)
        mine = {}
        with contextlib.suppress(OSError, http.client.HTTPException):  # it may close
            work(self.server, mine, refusals)
        if kind in ("fork", "pair"):  # asked for where a worker is needed
            before = set(daemon.children(self.server.pid))
            for worker in before:
                os.kill(worker, signal.SIGKILL)
            daemon.wait_until(lambda: len(set(daemon.children(self.server.pid)) - before) == 3,
                              "workers")
        hit = self.faults.hits(kind, where)
        self.faults.clear()
        account(self.server, mine, True, refusals)
        accepted |= mine
        return hit

    def test_each(self):
        for kind, error, where in ORDERS:
            with self.subTest(kind=kind, where=where):
                self.doCleanups()
                self.setUp()
                self.start().wait_ready()
                accepted, tries = {}, 0
                for n in itertools.count(0, 1 if EVERY else 2):
                    hit = self.one(kind, error, where, n, accepted)
                    tries += hit
                    if not hit:
                        break
                self.assert_well()
                self.assertEqual(self.server.stop(keep=True), 0)
                print(f"{where}, {kind} {errno.errorcode[error]}: {tries} calls failed, "
                      f"{len(accepted)} jobs accepted, none lost", flush=True)
                self.assertGreater(tries, 0)


class ForAWhile(Case):
    def test_each(self):
        """All calls of a kind fail; who is connected is answered, and the daemon stays calm."""
        for kind, error, where in ORDERS:
            with self.subTest(kind=kind, where=where):
                self.doCleanups()
                self.setUp()
                self.start("--queue", "2").wait_ready()
                kept = self.server.connect()
                self.addCleanup(kept.close)
                kept.request("GET", "/healthz")
                kept.getresponse().read()
                accepted = {}
                submit(self.server, accepted, f"sleep 0.5 {kind}" + LARGE)
                self.faults.fail(kind, error, where=where)
                self.server.signal_workers(signal.SIGKILL)
                for _ in range(3):
                    with self.server.raw() as plain:
                        plain.sendall(b"GET /healthz HTTP/1.1\r\nHost: a\r\n\r\n")
                self.server.assert_calm(2)
                kept.request("GET", "/healthz")
                self.assertEqual(kept.getresponse().status, 200)
                self.faults.clear()
                may_fail = (kind, where) == ("map", "workers")
                account(self.server, accepted, may_fail, (422,))
                self.assert_well()
                self.assertEqual(self.server.stop(keep=True), 0)

    def test_the_first_connection(self):
        """Nobody is connected, and nobody can be."""
        self.start().wait_ready()
        self.faults.fail("accept", errno.EMFILE)
        with self.server.raw() as plain:
            plain.sendall(b"GET /healthz HTTP/1.1\r\nHost: a\r\nConnection: close\r\n\r\n")
            self.server.assert_calm(2)
            self.faults.clear()
            self.assertIn(b"200 OK", daemon.read_all(plain))
        self.assert_well()

    def test_no_process(self):
        """Without any worker: 503 beyond the queue, not ready, and well later."""
        self.start("--queue", "1").wait_ready()
        self.faults.fail("fork", errno.EAGAIN)
        self.server.signal_workers(signal.SIGKILL)
        daemon.wait_until(lambda: self.server.request("GET", "/readyz").status == 503, "no worker")
        self.assertEqual(self.server.request("GET", "/healthz").status, 200)
        waiting = self.server.connect()
        self.addCleanup(waiting.close)
        waiting.request("POST", daemon.EXECUTE, "waits", JSON)
        daemon.wait_until(lambda: self.server.request("POST", daemon.EXECUTE, "too many", JSON)
                          .status == 503, "a full queue")
        self.server.assert_calm(2)
        self.faults.clear()
        self.assertEqual(waiting.getresponse().read(), b"waits")
        self.assert_well()


class FullQueue(Case):
    def test_refusals_do_not_wait_for_checks(self):
        """While all workers are busy, who finds no place in the queue of jobs is told at once."""
        self.server = server = daemon.Daemon("--workers", "2", "--job-queue", "2",
                                             directory=self.faults.directory)
        self.addCleanup(server.stop)
        daemon.wait_until(lambda: server.request("GET", "/readyz").json.get("workers") == 2, "both")
        with contextlib.ExitStack() as stack:
            def send(body, prefer):
                connection = stack.enter_context(contextlib.closing(server.connect()))
                connection.request("POST", daemon.EXECUTE, body, JSON | {"Prefer": prefer})
                return connection
            busy = [send("sleep 60", "wait=10") for _ in range(2)]
            daemon.wait_until(lambda: b'scatterd_workers{state="busy"} 2' in
                              server.request("GET", "/metrics").body, "busy workers")
            first = [send(f"{k}", "respond-async") for k in range(2)]
            daemon.wait_until(lambda: b"scatterd_jobs_room 0" in
                              server.request("GET", "/metrics").body, "no place left")
            reply = server.request("POST", daemon.EXECUTE, "too many",
                                   JSON | {"Prefer": "respond-async"})
            self.assertEqual(reply.status, 429)
            self.assertIn(b'scatterd_workers{state="busy"} 2',
                          server.request("GET", "/metrics").body)
            with server.waking():
                self.assertEqual([c.getresponse().status for c in busy + first],
                                 [200, 200, 201, 201])


class Descriptors(Case):
    def test_a_limit_too_low_is_told(self):
        few = lambda: resource.setrlimit(resource.RLIMIT_NOFILE, (64, 64))
        with self.assertRaisesRegex(AssertionError, "connections: got 1000, which needs"):
            self.start(before=few)

    def test_more_clients_than_connections(self):
        few = lambda: resource.setrlimit(resource.RLIMIT_NOFILE, (240, 240))
        self.start("--connections", "40", "--receive-seconds", "3", before=few).wait_ready()
        with contextlib.ExitStack() as stack:
            for _ in range(400):
                plain = stack.enter_context(self.server.raw())
                plain.sendall(b"GET /healthz HTTP/1.1\r\nHost: a\r\n")
            self.server.assert_calm(2)
        daemon.wait_until(lambda: self.answers(), "an answer")
        self.assert_well()

    def answers(self):
        with contextlib.suppress(OSError, http.client.HTTPException):
            return self.server.request("GET", "/healthz").status == 200

    def test_none_left(self):
        """The limit is where the daemon stands: not one more can be opened."""
        self.start().wait_ready()
        accepted = {}
        kept = [self.server.connect() for _ in range(3)]
        for connection in kept:
            self.addCleanup(connection.close)
            connection.request("GET", "/healthz")
            connection.getresponse().read()
        for k in range(6):
            submit(self.server, accepted, f"sleep 0.3 {k}" + LARGE)
        most = max(daemon.descriptors(self.server.pid)) + 1
        before = resource.prlimit(self.server.pid, resource.RLIMIT_NOFILE)
        resource.prlimit(self.server.pid, resource.RLIMIT_NOFILE, (most, before[1]))
        for connection in kept:
            connection.request("POST", daemon.EXECUTE, "now", JSON)
            reply = connection.getresponse()
            self.assertIn(reply.status, (200, 500, 503, 507), reply.read())
            reply.read()
        with self.server.raw():
            self.server.assert_calm(2)
        resource.prlimit(self.server.pid, resource.RLIMIT_NOFILE, before)
        self.assertEqual(account(self.server, accepted, False), 0)
        self.assert_well()


if __name__ == "__main__":
    unittest.main()
