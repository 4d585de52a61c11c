"""Workers that crash, hang or eat memory; clients that leave; a full queue; stopping."""

import json
import os
import pathlib
import signal
import threading
import time
import unittest

import daemon

HEAD = f"POST {daemon.EXECUTE} HTTP/1.1\r\nHost: a\r\nContent-Type: application/json\r\n".encode()


def post(body):
    return HEAD + b"Content-Length: %d\r\n\r\n%s" % (len(body), body)


def is_dead(pid):
    """Is there no such process, or is it a zombie (of whoever adopted it)?"""
    try:
        stat = pathlib.Path(f"/proc/{pid}/stat").read_text()
    except (FileNotFoundError, ProcessLookupError):
        return True
    return stat.rsplit(")", 1)[1].split()[0] in "ZX"


class Background:
    """Requests that run while a test goes on."""

    def __init__(self, case, *bodies):
        self.replies = [None] * len(bodies)
        self.threads = [threading.Thread(target=self._run, args=(case, k, body))
                        for k, body in enumerate(bodies)]
        for thread in self.threads:
            thread.start()

    def _run(self, case, k, body):
        self.replies[k] = case.execute(body)

    def wait(self):
        for thread in self.threads:
            thread.join(daemon.PATIENCE)
        return self.replies


class Case(daemon.Case):
    """Helpers, for a daemon with one worker."""

    def assert_alive(self):
        self.assertEqual(self.execute("alive").body, b"alive")

    def assert_one_worker(self):
        """One worker in the end and no zombie; a killed one may still be on its way out."""
        daemon.wait_until(lambda: len(daemon.children(self.daemon.pid)) == 1, "one worker")


class TimeLimit(Case):
    options = ["--workers", "1", "--seconds", "3"]

    def test_answer(self):
        self.assert_problem(self.execute("sleep 600"), 504, "seconds", "3 s")
        self.assert_alive()
        self.assert_one_worker()

    def test_answer_tells_the_phase(self):
        self.assert_problem(self.execute("phase factor 0.5 600"), 504, "in phase factor")

    def test_nothing_leaks(self):
        def faults():
            for body in ("abort", "sleep 60", "memory", "x" * 100000, "big 1000000", "problem"):
                self.execute(body)
            for data in (post(b"sleep 60"), post(b"abort"), HEAD, b"garbage\r\n\r\n"):
                with self.daemon.raw() as plain:
                    plain.sendall(data)
            self.assert_alive()

        def settled():
            return (len(daemon.children(self.daemon.pid)) == 1 and
                    not any("memfd" in what or "deleted" in what
                            for what in daemon.descriptors(self.daemon.pid).values()) and
                    sum(what.startswith("socket:")
                        for what in daemon.descriptors(self.daemon.pid).values()) == 2)
        faults()
        daemon.wait_until(settled, "one worker, and the sockets of listener and worker")
        before = len(daemon.descriptors(self.daemon.pid))
        for _ in range(3):
            faults()
        daemon.wait_until(settled, "one worker, and the sockets of listener and worker")
        self.assertEqual(len(daemon.descriptors(self.daemon.pid)), before)
        worker = daemon.children(self.daemon.pid)[0]
        daemon.wait_until(lambda: sorted(daemon.descriptors(worker)) == [0, 1, 2, 3],
                          "a worker with nothing but its socket")


class Faults(Case):
    options = ["--workers", "1", "--log-level", "debug"]

    def test_crash(self):
        for _ in range(3):
            problem = self.assert_problem(self.execute("abort"), 500, "worker died")
            self.assertIn("log", problem["detail"])
            self.assert_alive()
        self.daemon.wait_for_log(r"level=error event=worker-exit worker=\d+ signal=6")
        self.assert_one_worker()

    def test_exit(self):
        self.assert_problem(self.execute("exit 3"), 500, "worker died")
        self.daemon.wait_for_log(r"level=error event=worker-exit worker=\d+ code=3")
        self.assert_alive()
        self.assert_one_worker()

    def test_killed_from_outside(self):
        running = Background(self, "sleep 60")
        self.daemon.wait_busy()
        os.kill(daemon.children(self.daemon.pid)[0], signal.SIGKILL)
        self.assert_problem(running.wait()[0], 500, "worker died")
        self.assert_alive()
        idle = daemon.children(self.daemon.pid)[0]
        os.kill(idle, signal.SIGKILL)
        daemon.wait_until(lambda: idle not in daemon.children(self.daemon.pid), "its end")
        self.assert_alive()

    def test_memory(self):
        self.assert_problem(self.execute("memory"), 422, "memory-bytes")
        self.assert_alive()

    def test_terminal_signals_do_not_reach_workers(self):
        running = Background(self, "sleep 60")
        self.daemon.wait_busy()
        worker = daemon.children(self.daemon.pid)[0]
        os.kill(worker, signal.SIGTERM)
        os.kill(worker, signal.SIGINT)
        with self.daemon.waking():
            reply = running.wait()[0]
        self.assertEqual(reply.status, 200)

    def test_client_that_leaves(self):
        self.assert_alive()
        self.assert_one_worker()
        worker = daemon.wait_until(lambda: daemon.children(self.daemon.pid), "a worker")[0]
        with self.daemon.raw() as plain:
            plain.sendall(post(b"sleep 60"))
            self.daemon.wait_busy()
        daemon.wait_until(lambda: worker not in daemon.children(self.daemon.pid),
                          "the worker to be killed")
        self.daemon.wait_for_log(r"status=0 in=8 .* end=aborted")
        self.assert_alive()

    def test_client_that_leaves_the_queue(self):
        running = Background(self, "sleep 60")
        self.daemon.wait_busy()
        with self.daemon.raw() as plain:
            plain.sendall(post(b"abort"))
            self.daemon.wait_for_metric("scatterd_queue_length", 1)
        self.daemon.wait_for_metric("scatterd_queue_length", 0)
        with self.daemon.waking():
            self.assertEqual(running.wait()[0].status, 200)
        self.assert_alive()

    def test_client_that_leaves_its_body(self):
        for cut in (1, 50, len(HEAD), len(HEAD) + 20, len(post(b"abort")) - 1):
            with self.daemon.raw() as plain:
                plain.sendall(post(b"abort")[:cut])
        self.assert_alive()


def solve(cells):
    """A request to solve Poisson's equation on a lattice, by factors: in 3-D that is slow."""
    return json.dumps({"inputs": {
        "cloud": {"lattice": {"lower": [0] * len(cells), "upper": [1] * len(cells),
                              "cells": cells}},
        "diffusivity": 1, "source": 1, "solver": {"method": "direct"},
        "boundary": [{"on": "boundary", "type": "dirichlet", "value": 0}]}})


class SlowSolve(daemon.Case):
    """The real worker, in the middle of a solve that takes seconds."""
    stub = False
    options = ["--workers", "1", "--seconds", "4"]  # enough to be in some phase by then

    def test_time_limit(self):
        problem = self.assert_problem(self.execute(solve([40, 40, 40])), 504,
                                      "4 s", "in phase")
        self.assertRegex(problem["detail"], "in phase [a-z ]+ after")
        small = {"inputs": {"message": "alive"}}
        reply = self.execute(json.dumps(small), "/processes/echo/execution")
        self.assertEqual(reply.json["message"], "alive")


@unittest.skipIf(daemon.is_sanitized(), "the sanitizer needs all address space for itself")
class LargeSolve(daemon.Case):
    stub = False
    options = ["--workers", "1", "--memory-bytes", "450MiB"]

    def test_memory_limit(self):
        self.assert_problem(self.execute(solve([1900000])), 422, str(450 << 20))
        self.daemon.wait_for_log(r"status=422 .* points=1900001")


@unittest.skipIf(daemon.is_sanitized(), "the sanitizer needs all address space for itself")
class LargeFactors(daemon.Case):
    """Memory that runs out inside a factorisation, where the BLAS would wait for its own forever."""
    stub = False
    options = ["--workers", "1", "--memory-bytes", "300MiB"]

    def test_memory_limit(self):
        self.assert_problem(self.execute(solve([40, 40, 40])), 422, str(300 << 20))
        small = self.execute(solve([4, 4, 4]))
        self.assertEqual(small.status, 200, small.body)


class Hog(daemon.Case):
    options = ["--workers", "1", "--memory-bytes", "512MiB"]

    @unittest.skipIf(daemon.is_sanitized(), "the sanitizer needs all address space for itself")
    def test_memory_limit(self):
        for _ in range(2):
            self.assert_problem(self.execute("hog"), 422, "memory-bytes", str(512 << 20))
            self.assertEqual(self.execute("alive").body, b"alive")
        workers = daemon.children(self.daemon.pid)
        self.assertEqual(len(workers), 1)


class Queue(daemon.Case):
    options = ["--workers", "2", "--queue", "3"]

    def test_more_than_workers_and_queue_hold(self):
        daemon.wait_until(lambda: self.get("/readyz").json["workers"] == 2, "both workers")
        running = Background(self, *["sleep 60"] * 9)
        daemon.wait_until(lambda: sum(r is not None for r in running.replies) == 4, "refusals")
        with self.daemon.waking():
            replies = running.wait()
        self.assertEqual(sorted(reply.status for reply in replies), [200] * 5 + [503] * 4)
        for reply in replies:
            if reply.status == 503:
                self.assert_problem(reply, 503, "queue")
                self.assertGreaterEqual(int(reply.headers["Retry-After"]), 1)


class Recycling(daemon.Case):
    options = ["--recycle", "5"]

    def test_workers_are_replaced(self):
        before = set(daemon.children(self.daemon.pid))
        for k in range(20):
            self.assertEqual(self.execute(str(k)).body, str(k).encode())
        after = set(daemon.children(self.daemon.pid))
        self.assertNotEqual(before, after)
        self.assertNotIn("level=error", "\n".join(self.daemon.log))


class NoQueue(daemon.Case):
    options = ["--workers", "1", "--queue", "0"]

    def test_only_free_workers(self):
        self.assertEqual(self.execute("alive").status, 200)
        running = Background(self, "sleep 60", "sleep 60")
        daemon.wait_until(lambda: any(running.replies), "a refusal")
        with self.daemon.waking():
            replies = running.wait()
        self.assertEqual(sorted(reply.status for reply in replies), [200, 503])


class Ending(unittest.TestCase):

    def start(self, *options):
        d = daemon.Daemon(*options)
        self.addCleanup(d.stop)
        d.wait_ready()
        return d

    def ask(self, d, body):
        """A socket on which a request was sent that runs by now."""
        plain = d.raw()
        self.addCleanup(plain.close)
        plain.sendall(post(body))
        d.wait_busy()
        return plain

    def test_running_requests_end(self):
        d = self.start("--workers", "1")
        plain = self.ask(d, b"sleep 60")
        with d.raw() as idle:
            os.kill(d.pid, signal.SIGTERM)
            self.assertEqual(daemon.read_all(idle), b"")
        with d.waking():
            with self.assertRaises(ConnectionError):
                daemon.wait_until(lambda: d.request("GET", "/healthz") and False, "refusal")
            reply = daemon.read_all(plain)
        self.assertTrue(reply.startswith(b"HTTP/1.1 200 "), reply)
        self.assertIn(b"Connection: close", reply)
        self.assertEqual(d.stop(), 0)

    def test_requests_beyond_the_grace_get_an_answer(self):
        d = self.start("--workers", "1", "--grace-seconds", "0.3")
        plain = self.ask(d, b"sleep 60")
        os.kill(d.pid, signal.SIGTERM)
        reply = daemon.read_all(plain)
        self.assertTrue(reply.startswith(b"HTTP/1.1 503 "), reply)
        self.assertIn(b"Retry-After:", reply)
        self.assertEqual(d.stop(), 0)

    def test_second_signal(self):
        d = self.start("--workers", "1", "--grace-seconds", "1000")
        plain = self.ask(d, b"sleep 60")
        os.kill(d.pid, signal.SIGTERM)
        d.wait_for_log("event=stopping")
        os.kill(d.pid, signal.SIGINT)
        self.assertTrue(daemon.read_all(plain).startswith(b"HTTP/1.1 503 "))
        self.assertEqual(d.stop(), 0)

    def test_workers_die_with_a_killed_daemon(self):
        d = self.start("--workers", "3")
        plain = self.ask(d, b"sleep 60")
        workers = daemon.children(d.pid)
        self.assertEqual(len(workers), 3)
        self.assertEqual(d.stop(signal.SIGKILL), -signal.SIGKILL)
        for worker in workers:
            daemon.wait_until(lambda: is_dead(worker), "the worker to die")
        self.assertEqual(daemon.read_all(plain), b"")


class CrashLoop(unittest.TestCase):

    def test_workers_that_cannot_live_are_started_ever_more_slowly(self):
        began = time.monotonic()
        d = daemon.Daemon("--workers", "1", environment={"SCATTERD_STUB_DIES": "1"})
        self.addCleanup(d.stop)
        self.assertEqual(d.request("GET", "/healthz").status, 200)
        d.wait_for_log("event=worker-exit")
        time.sleep(2)
        deaths = sum("event=worker-exit" in line for line in d.log)
        # delays of 0.1, 0.2, 0.4, 0.8, 1.6 s ... 5 s
        self.assertLess(deaths, 8 + (time.monotonic() - began) / 5)
        reply = d.request("GET", "/readyz")
        self.assertEqual(reply.status, 503)
        self.assertTrue(reply.headers["Retry-After"])
        self.assertEqual(d.stop(), 0)


if __name__ == "__main__":
    unittest.main()
