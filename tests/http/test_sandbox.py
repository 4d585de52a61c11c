"""What a worker that a body has taken over can reach: nothing."""

import contextlib
import pathlib
import socket
import unittest

import daemon


@unittest.skipIf(daemon.is_sanitized(), "AddressSanitizer needs what the sandbox forbids")
class Sandbox(daemon.Case):
    options = ["--workers", "1"]

    def attempt(self, what):
        reply = self.execute(f"try {what}")
        self.assertEqual(reply.status, 200)
        return reply.body.decode()

    def test_files_sockets_and_processes_are_refused(self):
        for what in ("open", "create", "stat", "socket", "local", "process", "program", "kill",
                     "signal", "owner", "blocking", "affinity", "code", "limit", "trace"):
            with self.subTest(what):
                self.assertIn(self.attempt(what),
                              ("Operation not permitted", "Permission denied"))

    def test_its_files_of_memory_are_bounded_too(self):
        self.assertEqual(self.attempt("grow"), "File too large")

    def test_threads_are_not(self):
        self.assertEqual(self.attempt("thread"), "done")

    def test_the_kernel_says_so(self):
        self.attempt("thread")
        for worker in daemon.children(self.daemon.pid):
            status = dict(line.split(":\t", 1) for line in
                          pathlib.Path(f"/proc/{worker}/status").read_text().splitlines()
                          if ":\t" in line)
            self.assertEqual(status["NoNewPrivs"], "1")
            self.assertEqual(status["Seccomp"], "2")  # 2: a filter is in force


class Given(daemon.Case):
    """What a worker is given to read it cannot write."""
    options = ["--workers", "1"]

    def attempt(self, request):
        job = self.execute(request, Prefer="respond-async").json["jobID"]
        daemon.wait_until(lambda: self.get(f"/jobs/{job}").json["status"] == "successful",
                          "its end")
        return self.execute(f"given /jobs/{job}/results/all").body

    def test_what_is_small_is_sealed(self):
        self.assertEqual(self.attempt("big 100"), b"Operation not permitted")

    def test_what_is_large_is_open_for_reading_only(self):
        self.assertEqual(self.attempt("big 100000"), b"Bad file descriptor")


class Lies(daemon.Case):
    """What a worker that a body has taken over may say to the front: it is killed for it."""
    options = ["--workers", "1", "--seconds", "4"]

    def test_lies(self):
        self.execute("before")
        before = len(daemon.descriptors(self.daemon.pid))
        for what in ("unsealed", "short", "stream", "status", "page", "ready", "kind", "piece",
                     "two"):
            with self.subTest(what):
                reply = self.execute(f"lie {what}")
                self.assertEqual(reply.status, 500, reply.body)
                self.assertEqual(self.execute("truth").body, b"truth")
        daemon.wait_until(lambda: len(daemon.descriptors(self.daemon.pid)) <= before,
                          "all descriptors that came with them are closed")

    def test_two_wishes_at_once(self):
        reply = self.execute("wish http://127.0.0.1:9/never")  # refused at once: no fetch-hosts
        self.assertEqual(reply.status, 504)
        with socket.create_server(("127.0.0.1", 0)) as silent:
            host = f"127.0.0.1:{silent.getsockname()[1]}"
            other = daemon.Daemon("--workers", "1", "--fetch-hosts", host, "--fetch-private-hosts",
                                  host)
            self.addCleanup(other.stop)
            reply = other.request("POST", daemon.EXECUTE, f"wish http://{host}/never",
                                  {"Content-Type": "application/json"})
            self.assertEqual(reply.status, 500, reply.body)

    def test_checkpoints_that_come_too_fast_are_not_kept(self):
        reply = self.execute("checkpoints 600", Prefer="respond-async")
        job = reply.json["jobID"]
        def kept():
            return list(pathlib.Path(self.daemon.data).rglob(f"{job}.checkpoint"))
        size = daemon.wait_until(kept, "a checkpoint")[0].stat().st_size
        self.assertEqual(size, 1)
        with self.daemon.waking():
            daemon.wait_until(lambda: self.get(f"/jobs/{job}").json["status"] == "successful",
                              "its end")

    def test_one_that_talks_without_end_takes_no_turn_of_others(self):
        with contextlib.closing(self.daemon.connect()) as connection:
            connection.request("POST", daemon.EXECUTE, "lie flood",
                               {"Content-Type": "application/json"})
            for _ in range(20):
                self.assertEqual(self.get("/healthz").status, 200)
            self.assertEqual(connection.getresponse().status, 504)


@unittest.skipIf(daemon.is_sanitized(), "AddressSanitizer needs what the sandbox forbids")
class Solving(daemon.Case):
    """The real worker finds all it needs inside, with threads too."""
    stub = False
    options = ["--workers", "1", "--threads", "2"]

    def test_a_solve_with_two_threads(self):
        reply = self.execute(
            '{"inputs": {"cloud": {"lattice": {"lower": [0, 0], "upper": [1, 1], "cells": [60, 60],'
            '"jitter": 0.3}}, "diffusivity": 1, "source": "sin(x)", "boundary":'
            '[{"on": "boundary", "type": "dirichlet", "value": 0}]}, "outputs": {"report": {}}}')
        self.assertEqual(reply.status, 200, reply.body)
        self.assertEqual(reply.json["report"]["value"]["threads"], 2)


if __name__ == "__main__":
    unittest.main()
