#!/usr/bin/env python3
"""Large jobs by mpiexec: the answers of ranks, what one process does alone, and the ways to end."""
import json
import os
import pathlib
import shutil
import signal
import time
import unittest

import daemon

MPIEXEC = "mpiexec --allow-run-as-root --oversubscribe --mca mpi_yield_when_idle 1 --bind-to none"
SOURCE = "3*pi^2*sin(pi*x)*sin(pi*y)*sin(pi*z)"


def solve(cells, outputs=("solution", "norms", "report"), **inputs):
    return {"inputs": {
        "cloud": {"lattice": {"lower": [0] * len(cells), "upper": [1] * len(cells), "cells": cells,
                              "jitter": 0.3}},
        "diffusivity": 1, "source": SOURCE if len(cells) == 3 else "13*sin(3*x+1)*cos(2*y)",
        "exact": "sin(pi*x)*sin(pi*y)*sin(pi*z)" if len(cells) == 3 else "sin(3*x+1)*cos(2*y)",
        "boundary": [{"on": "boundary", "type": "dirichlet", "value":
                      "0" if len(cells) == 3 else "sin(3*x+1)*cos(2*y)"}], **inputs},
        "outputs": {name: {} for name in outputs}}


def options(ranks, *more):
    return ["--executor", "mpi", "--executor-points", "1000", "--ranks", str(ranks),
            "--mpiexec", MPIEXEC, "--workers", "2", "--reuse-results", "0", *more]


def ranks_of(directory):
    """Process ids of ranks on runs in a directory."""
    found = []
    for entry in pathlib.Path("/proc").iterdir():
        if not entry.name.isdigit():
            continue
        try:
            words = (entry / "cmdline").read_bytes().split(b"\0")
            state = (entry / "stat").read_text().rsplit(")", 1)[1].split()[0]
        except OSError:
            continue
        if len(words) > 2 and words[1] == b"rank" and words[2].startswith(directory.encode()):
            if state != "Z":
                found.append(int(entry.name))
    return found


class Runs:
    """How to ask a daemon, of a Case or a Daemon of one's own."""

    @staticmethod
    def submit(where, request, **headers):
        reply = where.request("POST", daemon.EXECUTE, json.dumps(request), {
            "Content-Type": "application/json", "Prefer": "respond-async", **headers})
        assert reply.status == 201, reply.body
        return reply.json["jobID"]

    @staticmethod
    def status(where, job):
        return where.request("GET", f"/jobs/{job}").json

    @classmethod
    def ended(cls, where, job, seconds=120):
        def is_over():
            now = cls.status(where, job)
            return now if now["status"] in ("successful", "failed", "dismissed") else None
        return daemon.wait_until(is_over, f"end of {job}", seconds)

    @classmethod
    def results(cls, where, job):
        now = cls.ended(where, job)
        assert now["status"] == "successful", now
        reply = where.request("GET", f"/jobs/{job}/results")
        assert reply.status == 200, reply.body
        return {key: value.get("value", value) if isinstance(value, dict) else value
                for key, value in reply.json.items()}


def largest_difference(one, other):
    assert len(one) == len(other)
    return max(abs(a - b) for a, b in zip(one, other))


def why_not():
    """Why it cannot run here, or None."""
    if shutil.which("mpiexec") is None:
        return "no mpiexec"
    probe = daemon.Daemon("--workers", "1", stub=False)
    try:
        probe.wait_ready()
        reply = probe.request("POST", daemon.EXECUTE, json.dumps(
            solve([4, 4, 4], solver={"method": "iterative"})), {"Content-Type": "application/json"})
        return None if reply.status == 200 else "the daemon has no PETSc"
    finally:
        probe.stop()


class Agreement(unittest.TestCase):
    """The same request on 1, 2 and 4 ranks, and on a worker."""

    requests = {
        "2-D": solve([40, 40]),
        "3-D": solve([12, 12, 12], ("solution", "norms", "report", "diagnostics")),
        "convection": solve([40, 40], velocity=["50*y", "-50*x"], source=1, exact=0,
                            operator={"scheme": "lsmps", "upwind": "cosine"}),
        "amg": solve([40, 40], solver={"method": "iterative", "preconditioner": "amg"}),
    }

    def test_agrees(self):
        alone = self.all_on("--workers", "2")
        for ranks in (1, 2, 4):
            together = self.all_on(*options(ranks))
            for name, found in together.items():
                with self.subTest(ranks=ranks, request=name):
                    self.check(found, alone[name], ranks)

    def all_on(self, *words):
        one = daemon.Daemon(*words, stub=False)
        try:
            one.wait_ready()
            jobs = {name: Runs.submit(one, request) for name, request in self.requests.items()}
            return {name: Runs.results(one, job) for name, job in jobs.items()}
        finally:
            self.assertEqual(one.stop(), 0)

    def check(self, found, alone, ranks):
        self.assertLess(largest_difference(found["solution"], alone["solution"]), 1e-7)
        self.assertAlmostEqual(found["norms"]["l2"], alone["norms"]["l2"], delta=1e-7)
        self.assertEqual(found["report"]["ranks"]["count"], ranks)
        self.assertNotIn("reason", found["report"]["ranks"])
        self.assertEqual(found["report"]["ranks"]["halo"] > 0, ranks > 1)
        self.assertNotIn("ranks", alone["report"])
        if "diagnostics" in alone:
            for member in ("matrix", "widened", "fallback", "loose", "spacing", "neighbours"):
                self.assertEqual(found["diagnostics"][member], alone["diagnostics"][member])
            self.assertIn("bicgstab", found["diagnostics"]["solver"]["krylov"])


class Mpi(daemon.Case):
    stub = False
    options = options(2)

    def submit(self, request):
        return Runs.submit(self.daemon, request)

    def results(self, job):
        return Runs.results(self.daemon, job)

    def assert_nothing_left(self):
        daemon.wait_until(lambda: not ranks_of(self.daemon.data), "the end of all ranks")
        daemon.wait_until(lambda: not os.listdir(f"{self.daemon.data}/runs"), "empty runs")

    def test_forms_are_those_of_any_job(self):
        job = self.submit(solve([40, 40]))
        exact = self.results(job)["solution"]
        csv = self.get(f"/jobs/{job}/results/solution", Accept="text/csv")
        self.assertEqual(csv.status, 200)
        self.assertEqual(len(csv.body.split()), len(exact) + 1)
        self.assert_nothing_left()

    def test_posted_points_without_spacing(self):
        points = [[(i + 0.3 * ((7 * i + 3 * j) % 5 - 2) / 5) / 40, (j + 0.1 * ((i * j) % 3)) / 40]
                  for j in range(41) for i in range(41)]
        rim = [k for k, (x, y) in enumerate(points)
               if k % 41 in (0, 40) or k // 41 in (0, 40)]
        request = solve([1, 1], cloud={"points": points, "groups": {"rim": rim}},
                        boundary=[{"on": "rim", "type": "dirichlet", "value": "x*y"}], source=0,
                        exact="x*y")
        found = self.results(self.submit(request))
        sync = self.execute(json.dumps(request)).json
        self.assertLess(largest_difference(found["solution"], sync["solution"]), 1e-7)

    def test_small_jobs_stay_on_workers(self):
        self.assertNotIn("ranks", self.results(self.submit(solve([10, 10])))["report"])

    def test_what_is_not_shared_says_why(self):
        reasons = {
            "march": (solve([40, 40], initial=0, time={"end": 0.01, "step": 0.005}), "march in time"),
            "direct": (solve([40, 40], solver={"method": "direct"}), "direct solver"),
            "limited": (solve([40, 40], velocity=[1, 1], operator={"upwind": "limited"}), "limited"),
        }
        for name, (request, reason) in reasons.items():
            with self.subTest(name):
                told = self.results(self.submit(request))["report"]["ranks"]
                self.assertEqual(told["count"], 1)
                self.assertIn(reason, told["reason"])

    def test_values_by_reference_go_to_a_worker(self):
        points = json.dumps([[i / 40, j / 40] for j in range(41) for i in range(41)])
        kept = self.request("POST", "/data", points, {"Content-Type": "application/json"})
        self.assertEqual(kept.status, 201, kept.body)
        rim = [k for k in range(41 * 41) if k % 41 in (0, 40) or k // 41 in (0, 40)]
        request = solve([1, 1], cloud={"points": {"href": kept.headers["Location"]},
                                       "groups": {"rim": rim}},
                        boundary=[{"on": "rim", "type": "dirichlet", "value": 0}])
        found = self.results(self.submit(request))
        self.assertEqual(len(found["solution"]), 41 * 41)
        self.assertNotIn("ranks", found["report"])

    def test_failures_are_told_as_by_a_worker(self):
        request = solve([40, 40], boundary=[{"on": "boundary", "type": "neumann", "value": 0}])
        job = self.submit(request)
        self.assertEqual(Runs.ended(self.daemon, job)["status"], "failed")
        sync = self.execute(json.dumps(request))
        told = self.get(f"/jobs/{job}/results")
        self.assertEqual((told.status, told.json["detail"]), (sync.status, sync.json["detail"]))
        self.assert_nothing_left()

    def large(self):
        """One that takes long enough to be looked at."""
        return self.submit(solve([900, 900], ("norms",), solver={
            "method": "iterative", "preconditioner": "ilu", "tolerance": 1e-13,
            "max_iterations": 100000}))

    def wait_running(self, job):
        daemon.wait_until(lambda: Runs.status(self.daemon, job)["status"] == "running", "a run")
        daemon.wait_until(lambda: len(ranks_of(self.daemon.data)) == 2, "two ranks")

    def test_cancel_ends_all_ranks_within_a_second(self):
        job = self.large()
        self.wait_running(job)
        daemon.wait_until(lambda: Runs.status(self.daemon, job)["progress"] > 10, "progress")
        self.assertEqual(self.request("DELETE", f"/jobs/{job}").status, 200)
        begun = time.monotonic()
        daemon.wait_until(lambda: not ranks_of(self.daemon.data), "the end of all ranks")
        print(f"all ranks gone after {time.monotonic() - begun:.2f} s")
        self.assert_nothing_left()
        self.assertGreater(len(self.results(self.submit(solve([40, 40])))["solution"]), 0)

    def test_dead_rank_is_a_failed_attempt(self):
        job = self.large()
        for attempt in (1, 2, 3):
            self.wait_running(job)
            died = ranks_of(self.daemon.data)
            os.kill(died[-1], signal.SIGKILL)
            daemon.wait_until(lambda: not set(died) & set(ranks_of(self.daemon.data)),
                              f"the end of attempt {attempt}")
        now = Runs.ended(self.daemon, job)
        self.assertEqual(now["status"], "failed")
        self.assertIn("3 attempts", now["message"])
        self.assert_nothing_left()


class Limits(unittest.TestCase):
    def run_one(self, words, request):
        one = daemon.Daemon(*options(2, *words), stub=False)
        try:
            one.wait_ready()
            job = Runs.submit(one, request)
            now = Runs.ended(one, job)
            told = one.request("GET", f"/jobs/{job}/results")
            daemon.wait_until(lambda: not ranks_of(one.data), "the end of all ranks")
            return now, told
        finally:
            self.assertEqual(one.stop(), 0)

    def test_seconds(self):
        now, told = self.run_one(["--job-seconds", "2"], solve([700, 700], ("norms",), solver={
            "method": "iterative", "preconditioner": "ilu", "tolerance": 1e-13,
            "max_iterations": 100000}))
        self.assertEqual((now["status"], told.status), ("failed", 504), now)
        self.assertIn("job-seconds", told.json["detail"])

    def test_shared_memory_estimate_admits_more(self):
        """What is too much for one worker may be shared."""
        words = ["--memory-bytes", "800MiB"]
        request = solve([80, 80, 80], ("norms", "report"))
        one = daemon.Daemon(*options(4, *words), stub=False)
        try:
            one.wait_ready()
            sync = one.request("POST", daemon.EXECUTE, json.dumps(request),
                               {"Content-Type": "application/json"})
            self.assertEqual(sync.status, 422, sync.body[:300])
            reply = one.request("POST", daemon.EXECUTE, json.dumps(request), {
                "Content-Type": "application/json", "Prefer": "respond-async"})
            self.assertEqual(reply.status, 201, reply.body)
            one.request("DELETE", f"/jobs/{reply.json['jobID']}")
        finally:
            self.assertEqual(one.stop(), 0)


class Restart(unittest.TestCase):
    def test_the_daemon_takes_its_ranks_with_it(self):
        one = daemon.Daemon(*options(2), stub=False)
        one.wait_ready()
        job = Runs.submit(one, solve([500, 500], ("norms",)))
        daemon.wait_until(lambda: len(ranks_of(one.data)) == 2, "two ranks")
        one.stop(signal.SIGKILL, keep=True)
        daemon.wait_until(lambda: not ranks_of(one.data), "the end of all ranks")
        other = daemon.Daemon(*options(2), stub=False, directory=one.directory)
        try:
            self.assertIn("norms", Runs.results(other, job))
            self.assertEqual(os.listdir(f"{other.data}/runs"), [])
        finally:
            self.assertEqual(other.stop(), 0)

    def test_missing_program_is_said_at_the_start(self):
        with self.assertRaisesRegex(AssertionError, "no program nothing-like-mpiexec"):
            daemon.Daemon("--executor", "mpi", "--mpiexec", "nothing-like-mpiexec -x", stub=False)


if __name__ == "__main__":
    REASON = why_not()
    if REASON:
        print(f"skipped: {REASON}")
        raise SystemExit(77)
    unittest.main()
