"""What a worker that a body has taken over can reach: nothing."""

import pathlib
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
                     "limit", "trace"):
            with self.subTest(what):
                self.assertIn(self.attempt(what),
                              ("Operation not permitted", "Permission denied"))

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
