#!/usr/bin/env python3
"""http.phases: a worker is killed in each phase of its work. Who waits for the answer gets a 500 that
names the phase, and the next request is served; a job runs again, up to its attempts."""

import json
import shutil
import sys
import unittest

sys.dont_write_bytecode = True
import daemon  # noqa: E402
import faults as ordered  # noqa: E402

ATTEMPTS = 3
STEADY = {"inputs": {
    "cloud": {"lattice": {"lower": [0, 0], "upper": [1, 1], "cells": [8, 8]}},
    "diffusivity": 1, "source": 1, "solver": {"method": "direct"},
    "boundary": [{"on": "boundary", "type": "dirichlet", "value": 0}]}}
MOVING = {"inputs": STEADY["inputs"] | {"initial": 0, "time": {"end": 0.1, "step": 0.01}}}
REQUESTS = {"search": STEADY, "stencil": STEADY, "assemble": STEADY, "factor": STEADY,
            "solve": STEADY, "march": MOVING, "encode": STEADY, "reply": STEADY}


class Phases(daemon.Case):
    stub = False

    @classmethod
    def setUpClass(cls):
        cls.faults = ordered.Faults(stub=False)
        cls.addClassCleanup(cls.faults.close)
        cls.addClassCleanup(shutil.rmtree, cls.faults.directory, True)
        cls.daemon = daemon.Daemon("--workers", "2", "--job-attempts", str(ATTEMPTS),
                                   "--reuse-results", "0", stub=False,
                                   directory=cls.faults.directory,
                                   environment=cls.faults.environment)
        cls.addClassCleanup(cls.daemon.stop)
        cls.daemon.wait_ready()

    def tearDown(self):
        self.faults.clear()

    def ask(self, request, path=daemon.EXECUTE, **headers):
        return self.execute(json.dumps(request), path, **headers)

    def submit(self, request):
        reply = self.ask(request, Prefer="respond-async")
        self.assertEqual(reply.status, 201, reply.body)
        return reply.json["jobID"]

    def end_of(self, job):
        return self.get(f"/jobs/{job}", Prefer="wait=60").json

    def test_somebody_waits(self):
        for phase, request in REQUESTS.items():
            with self.subTest(phase=phase):
                self.faults.kill_in(phase)
                self.assert_problem(self.ask(request), 500, "worker died",
                                    *([f"in phase {phase}"] if phase != "reply" else []))
                self.assertEqual(self.faults.kills_left(), 0)
                self.assertEqual(self.ask(request).status, 200)

    def test_a_job_runs_again(self):
        for phase, request in REQUESTS.items():
            if phase == "reply":
                continue  # its check replies, too: below
            with self.subTest(phase=phase):
                self.faults.kill_in(phase, ATTEMPTS - 1)
                job = self.submit(request)
                info = self.end_of(job)
                self.assertEqual((info["status"], info["progress"]), ("successful", 100), info)
                self.assertEqual(self.faults.kills_left(), 0)
                self.assertEqual(self.get(f"/jobs/{job}/results").status, 200)

    def test_a_job_that_kills_every_worker(self):
        for phase, request in REQUESTS.items():
            if phase == "reply":
                continue
            with self.subTest(phase=phase):
                self.faults.kill_in(phase, 1000)
                job = self.submit(request)
                self.assertEqual(self.end_of(job)["status"], "failed")
                self.assertEqual(self.faults.kills_left(), 1000 - ATTEMPTS)
                self.faults.clear()
                self.assert_problem(self.get(f"/jobs/{job}/results"), 500, f"in phase {phase}",
                                    f"{ATTEMPTS} attempts")
                self.assertEqual(self.ask(request).status, 200)

    def test_checks_renderings_and_uploads(self):
        job = self.submit(STEADY)
        self.assertEqual(self.end_of(job)["status"], "successful")
        for ask in (lambda: self.ask(STEADY, Prefer="respond-async"),
                    lambda: self.get(f"/jobs/{job}/results", Accept="text/csv"),
                    lambda: self.request("POST", "/data", "[[1, 2]]",
                                         {"Content-Type": "application/json"})):
            self.faults.kill_in("reply")
            self.assert_problem(ask(), 500, "worker died")
            reply = ask()
            self.assertIn(reply.status, (200, 201))
            if "/jobs/" in reply.headers.get("Location", ""):
                self.end_of(reply.json["jobID"])  # its run would be killed in the next turn

    def test_values_that_nobody_waits_for_any_more(self):
        href = self.request("POST", "/data", "[[0.5, 0.5], [0, 0], [1, 0], [0, 1], [1, 1]]",
                            {"Content-Type": "application/json"}).headers["Location"]
        applied = {"inputs": {"cloud": {"points": {"href": href}}, "field": "x"},
                   "outputs": {"value": {"transmissionMode": "reference"}}}
        for word in ("fetch", "keep"):
            with self.subTest(word=word):
                self.faults.kill_in(word)
                reply = self.ask(applied, "/processes/apply/execution")
                self.assert_problem(reply, 500, "worker died")
                self.assertEqual(self.ask(applied, "/processes/apply/execution").status, 200)


if __name__ == "__main__":
    unittest.main()
