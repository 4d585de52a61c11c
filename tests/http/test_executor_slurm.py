#!/usr/bin/env python3
"""Large jobs as jobs of Slurm: their states, ends and limits, and daemons that come and go."""
import json
import os
import signal
import time
import unittest

import daemon
import slurm
import test_executor_mpi as mpi
from test_executor_mpi import Runs, solve

CLUSTER = None
SLOW = {"method": "iterative", "preconditioner": "ilu", "tolerance": 1e-13, "max_iterations": 100000}


def options(*more):
    return ["--executor", "slurm", "--executor-points", "1000", "--ranks", "2",
            "--mpiexec", mpi.MPIEXEC, "--workers", "2", "--reuse-results", "0", *more]


def start(*more, **named):
    one = daemon.Daemon(*options(*more), stub=False, environment=CLUSTER.environment, **named)
    one.wait_ready()
    return one


def brief(log):
    return "\n".join(line for line in log if "event=request" not in line)


def jobs_of(job):
    """Numbers and states in Slurm of one of our jobs."""
    return {number: state for number, (state, name) in CLUSTER.jobs().items()
            if name == f"scatterd-{job}"}


def wait_for_state(job, *states):
    return daemon.wait_until(lambda: [number for number, state in jobs_of(job).items()
                                      if state in states], f"{states} in Slurm", 60)


class Slurm(unittest.TestCase):
    more = []

    def setUp(self):
        self.daemon = start(*self.more)

    def tearDown(self):
        files = os.listdir(f"{self.daemon.data}/runs")
        self.assertEqual(self.daemon.stop(), 0, brief(self.daemon.log))
        self.assertEqual(files, [])

    def submit(self, request):
        return Runs.submit(self.daemon, request)

    def status(self, job):
        return Runs.status(self.daemon, job)

    def large(self):
        return self.submit(solve([700, 700], ("norms", "report"), solver=SLOW))

    def assert_no_ranks(self):
        daemon.wait_until(lambda: not mpi.ranks_of(self.daemon.data), "the end of all ranks")


class States(Slurm):
    def test_agrees_with_a_worker(self):
        request = solve([40, 40])
        job = self.submit(request)
        found = Runs.results(self.daemon, job)
        sync = self.daemon.request("POST", daemon.EXECUTE, json.dumps(request),
                                   {"Content-Type": "application/json"}).json
        self.assertLess(mpi.largest_difference(found["solution"], sync["solution"]), 1e-7)
        self.assertEqual(found["report"]["ranks"]["count"], 2)
        self.assertGreater(found["report"]["memory_peak_bytes"], 1 << 20)
        self.assertEqual(len(jobs_of(job)), 1)
        self.assertRegex("\n".join(self.daemon.log), f"job {job} is Slurm job [0-9]+")

    def test_other_processes_run_there_too(self):
        reply = self.daemon.request("POST", "/processes/diagnose/execution", json.dumps(
            {"inputs": {"cloud": {"lattice": {"lower": [0, 0], "upper": [1, 1], "cells": [40, 40]}}}}),
            {"Content-Type": "application/json", "Prefer": "respond-async"})
        self.assertEqual(reply.status, 201, reply.body)
        job = reply.json["jobID"]
        told = Runs.results(self.daemon, job)["report"]["ranks"]
        self.assertEqual(told["count"], 1)
        self.assertIn("not run in parallel", told["reason"])
        self.assertEqual(len(jobs_of(job)), 1)

    def test_waiting_running_cancelled(self):
        """A full node: accepted. Then it runs, and is dismissed."""
        block = CLUSTER.ask("sbatch", "--parsable", "--ntasks=4", "--output=/dev/null",
                            "--wrap", "sleep 600")
        daemon.wait_until(lambda: CLUSTER.jobs()[int(block)][0] == "RUNNING", "a full node", 60)
        waits, runs = self.large(), self.large()
        for job in (waits, runs):
            wait_for_state(job, "PENDING")
            daemon.wait_until(lambda: "Slurm" in self.status(job)["message"], "a word of Slurm")
            self.assertEqual(self.status(job)["status"], "accepted")
        self.assertEqual(self.daemon.request("DELETE", f"/jobs/{waits}").status, 200)
        wait_for_state(waits, "CANCELLED")
        CLUSTER.ask("scancel", block)
        daemon.wait_until(lambda: self.status(runs)["status"] == "running", "a run", 60)
        daemon.wait_until(lambda: self.status(runs)["progress"] > 10, "progress", 60)
        wait_for_state(runs, "RUNNING")
        begun = time.monotonic()
        self.assertEqual(self.daemon.request("DELETE", f"/jobs/{runs}").status, 200)
        self.assert_no_ranks()
        print(f"all ranks gone after {time.monotonic() - begun:.2f} s")
        wait_for_state(runs, "CANCELLED")
        daemon.wait_until(lambda: not os.listdir(f"{self.daemon.data}/runs"), "empty runs")

    def test_cancelled_by_somebody_else(self):
        job = self.large()
        number = wait_for_state(job, "RUNNING", "PENDING")[0]
        CLUSTER.ask("scancel", str(number))
        now = Runs.ended(self.daemon, job)
        self.assertEqual(now["status"], "failed")
        self.assertIn(f"Slurm job {number} was cancelled", now["message"])
        self.assert_no_ranks()


class Seconds(Slurm):
    more = ["--job-seconds", "2"]

    def test_time_limit(self):
        job = self.large()
        self.assertEqual(Runs.ended(self.daemon, job)["status"], "failed")
        told = self.daemon.request("GET", f"/jobs/{job}/results")
        self.assertEqual(told.status, 504)
        self.assertIn("job-seconds", told.json["detail"])
        self.assert_no_ranks()
        wait_for_state(job, "CANCELLED", "TIMEOUT")


class Refused(Slurm):
    more = ["--sbatch", "sbatch --partition=nowhere"]

    def test_refused_by_slurm(self):
        job = self.large()
        now = Runs.ended(self.daemon, job)
        self.assertEqual(now["status"], "failed")
        self.assertIn("Slurm does not take the job", now["message"])
        self.assertIn("partition", now["message"])


class Restart(unittest.TestCase):
    """The daemon is killed; Slurm goes on."""

    def go_on(self, meanwhile):
        one = start()
        self.addCleanup(one.stop)
        job = Runs.submit(one, solve([250, 250], ("norms", "report"), solver=SLOW))
        wait_for_state(job, "RUNNING")
        daemon.wait_until(lambda: len(mpi.ranks_of(one.data)) == 2, "two ranks")
        one.stop(signal.SIGKILL, keep=True)
        meanwhile(one, job)
        other = start(directory=one.directory)
        try:
            found = Runs.results(other, job)
            self.assertEqual(found["report"]["ranks"]["count"], 2)
            self.assertEqual(len(jobs_of(job)), 1, "it was submitted twice")
            self.assertEqual(os.listdir(f"{other.data}/runs"), [])
        finally:
            self.assertEqual(other.stop(), 0)

    def test_while_it_runs(self):
        self.go_on(lambda one, job: self.assertTrue(mpi.ranks_of(one.data)))

    def test_when_it_is_over_meanwhile(self):
        self.go_on(lambda one, job: wait_for_state(job, "COMPLETED"))

    def test_before_its_number_was_noted(self):
        self.go_on(lambda one, job: os.unlink(f"{one.data}/runs/{job}/slurm"))

    def test_stop_leaves_it(self):
        one = start()
        self.addCleanup(one.stop)
        job = Runs.submit(one, solve([250, 250], ("norms",), solver=SLOW))
        wait_for_state(job, "RUNNING")
        self.assertEqual(one.stop(keep=True), 0)
        other = start(directory=one.directory)
        try:
            self.assertIn("norms", Runs.results(other, job))
            self.assertEqual(len(jobs_of(job)), 1)
        finally:
            self.assertEqual(other.stop(), 0)

    def test_controller_away(self):
        """No answer from Slurm is no end of a job."""
        self.addCleanup(CLUSTER.start_controller)
        one = start()
        try:
            job = Runs.submit(one, solve([450, 450], ("norms",), solver=SLOW))
            daemon.wait_until(lambda: Runs.status(one, job)["status"] == "running", "a run", 60)
            CLUSTER.stop_controller()
            daemon.wait_until(  # squeue takes its time to give up; the run may end before
                lambda: any("squeue: " in line for line in list(one.log))
                or Runs.status(one, job)["status"] != "running", "a daemon that goes on", 200)
            self.assertIn(Runs.status(one, job)["status"], ("running", "successful"))
            CLUSTER.start_controller()
            self.assertIn("norms", Runs.results(one, job))
        finally:
            self.assertEqual(one.stop(), 0)


if __name__ == "__main__":
    REASON = mpi.why_not()
    try:
        CLUSTER = slurm.Cluster() if REASON is None else None
    except slurm.NotHere as why:
        REASON = str(why)
    if REASON:
        print(f"skipped: {REASON}")
        raise SystemExit(77)
    try:
        unittest.main()
    finally:
        CLUSTER.stop()
