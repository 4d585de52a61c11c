#!/usr/bin/env python3
"""http.executor_commands: executor slurm with stand-ins for its three commands, where a cluster would
be in the way: many runs at once, and no process for a command."""

import errno
import os
import pathlib
import shutil
import sys
import tempfile
import unittest

sys.dont_write_bytecode = True
import daemon  # noqa: E402
import faults as ordered  # noqa: E402

ASYNC = {"Content-Type": "application/json", "Prefer": "respond-async"}
COMMANDS = {  # of jobs that wait for ever
    "sbatch": 'for word; do case $word in --job-name=*) name=${word#*=};; esac; done\n'
              'echo $$ > "$CLUSTER/$name"; echo "$name" >> "$CLUSTER/submitted"; echo $$\n',
    "squeue": 'for word; do case $word in --name=*) names=${word#*=};; esac; done\nIFS=,\n'
              'for name in $names; do read id < "$CLUSTER/$name" && echo "$id|PENDING|$name"; done\n'
              'echo $names >> "$CLUSTER/asked"\n',
    "scancel": 'echo "$*" >> "$CLUSTER/cancelled"\n',
}


class Case(unittest.TestCase):
    def setUp(self):
        self.cluster = pathlib.Path(tempfile.mkdtemp(prefix="cluster-"))
        self.addCleanup(shutil.rmtree, self.cluster)
        for name, text in COMMANDS.items():
            command = self.cluster / "bin" / name
            command.parent.mkdir(exist_ok=True)
            command.write_text("#!/bin/sh\n" + text)
            command.chmod(0o755)

    def start(self, *options, environment=None, **more):
        path = f"{self.cluster / 'bin'}:{os.environ['PATH']}"
        server = daemon.Daemon("--executor", "slurm", "--executor-points", "0", "--workers", "2",
                               *options, environment={"PATH": path, "CLUSTER": str(self.cluster)}
                               | (environment or {}), **more)
        self.addCleanup(lambda: server.process.poll() is None and server.stop())
        server.wait_ready()
        return server

    def submit(self, server, body):
        reply = server.request("POST", daemon.EXECUTE, body, ASYNC)
        self.assertEqual(reply.status, 201, reply.body)
        return reply.json["jobID"]

    def said(self, name):
        """The lines that a command has written so far."""
        file = self.cluster / name
        return file.read_text().splitlines() if file.exists() else []

    def wait_for_slurm(self, server, job):
        server.wait_for_log(f"event=submitted .*{job} is Slurm job")

    def test_many(self):
        """More than one answer of squeue has room for: none is taken for lost."""
        count = 300
        server = self.start("--executor-jobs", f"{count}", "--job-queue", "1000")
        jobs = [self.submit(server, f"waits {k}") for k in range(count)]
        for job in jobs:
            self.wait_for_slurm(server, job)
        begun = len(self.said("asked"))
        daemon.wait_until(lambda: len(self.said("asked")) > begun + 13, "more than 10 s of answers")
        states = {state: len(server.request("GET", f"/jobs?status={state}&limit=1000").json["jobs"])
                  for state in ("accepted", "failed")}
        self.assertEqual(states, {"accepted": count, "failed": 0})
        self.assertEqual(len(self.said("submitted")), count)
        asked = {name for line in self.said("asked")[begun:] for name in line.split()}
        self.assertEqual(asked, {f"scatterd-{job}" for job in jobs})

    def test_new_ones_all_the_time(self):
        """Those that were there before are asked for all the same."""
        server = self.start()
        first = self.submit(server, "waits")
        self.wait_for_slurm(server, first)
        begun = len(self.said("asked")) + 1  # the question of this moment may be under way
        for k in range(5):
            self.wait_for_slurm(server, self.submit(server, f"waits {k}"))
            asked = len(self.said("asked"))
            daemon.wait_until(lambda: len(self.said("asked")) > asked, "a question")  # noqa: B023
        for line in self.said("asked")[begun:]:
            self.assertIn(first, line)

    def test_no_process_for_a_cancellation(self):
        if daemon.is_sanitized():
            self.skipTest("the shell of the stand-ins does not run with AddressSanitizer preloaded")
        faults = ordered.Faults()
        self.addCleanup(faults.close)
        self.addCleanup(shutil.rmtree, faults.directory, True)
        server = self.start(directory=faults.directory, environment=faults.environment)
        job = self.submit(server, "waits")
        self.wait_for_slurm(server, job)
        faults.fail("fork", errno.EAGAIN)
        self.assertEqual(server.request("DELETE", f"/jobs/{job}").status, 200)
        daemon.wait_until(lambda: faults.hits("fork") > 0, "a failure")
        self.assertEqual(self.said("cancelled"), [])
        faults.clear()
        daemon.wait_until(lambda: self.said("cancelled"), "scancel")
        self.assertIn(job, self.said("cancelled")[0])
        daemon.wait_until(lambda: not os.listdir(f"{server.data}/runs"), "the end of the run")


if __name__ == "__main__":
    unittest.main()
