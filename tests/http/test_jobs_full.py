#!/usr/bin/env python3
"""http.jobs_full: the disk fills up, and is emptied again (fault_shim.c): 507, a healthy daemon,
nothing accepted is lost."""

import errno
import sys
import unittest

sys.dont_write_bytecode = True
import daemon  # noqa: E402
import faults as ordered  # noqa: E402


class Full(daemon.Case):
    @classmethod
    def setUpClass(cls):
        cls.faults = ordered.Faults()
        cls.daemon = daemon.Daemon("--workers", "2", "--spool-bytes", "1MiB",
                                   directory=cls.faults.directory,
                                   environment=cls.faults.environment)
        cls.addClassCleanup(cls.daemon.stop)
        cls.addClassCleanup(cls.faults.close)
        cls.daemon.wait_ready()

    def tearDown(self):
        self.faults.clear()

    def fill(self):
        self.faults.fail("write", errno.ENOSPC)

    def run_into_it(self, body):
        """A job whose run ends when the disk is full."""
        job = self.submit(body).json["jobID"]
        daemon.wait_until(lambda: self.get(f"/jobs/{job}").json["status"] == "running", "its run")
        self.fill()
        with self.daemon.waking():
            self.daemon.wait_busy(0)
            daemon.wait_until(lambda: self.faults.hits("write") > 0, "an attempt to keep its result")
        self.assertEqual(self.execute("served").body, b"served")
        self.assertEqual(self.get("/healthz").status, 200)
        self.faults.clear()
        return job

    def submit(self, body):
        return self.execute(body, Prefer="respond-async")

    def status(self, job):
        return self.get(f"/jobs/{job}", Prefer="wait=20").json

    def test_submission(self):
        self.fill()
        for _ in range(3):
            self.assert_problem(self.submit("no room"), 507, "full")
            self.assert_problem(self.submit("no room" + 20000 * " "), 507, "full")
        self.assertEqual(self.execute("synchronous").body, b"synchronous")
        self.assertEqual(self.get("/healthz").status, 200)
        self.assert_problem(self.execute(b"x" * (2 << 20)), 507)
        self.faults.clear()
        reply = self.submit("room again")
        self.assertEqual(reply.status, 201)
        self.assertEqual(self.status(reply.json["jobID"])["status"], "successful")

    def test_result(self):
        job = self.run_into_it("sleep 600" + 20000 * " ")
        self.assertEqual(self.status(job)["status"], "failed")
        self.assert_problem(self.get(f"/jobs/{job}/results"), 507, "result")

    def test_a_small_result_is_stored_later(self):
        job = self.run_into_it("sleep 600")
        self.assertEqual(self.status(job)["status"], "successful")
        self.assertEqual(self.get(f"/jobs/{job}/results").body, b"sleep 600")

    def test_the_end_is_stored_later(self):
        job = self.submit("big 100000").json["jobID"]
        self.status(job)
        self.fill()
        reply = self.request("DELETE", f"/jobs/{job}")
        self.assertIn(reply.status, (200, 507))
        self.faults.clear()
        daemon.wait_until(lambda: self.request("DELETE", f"/jobs/{job}").status in (200, 410),
                          "room to dismiss it")
        self.assertEqual(self.get(f"/jobs/{job}").json["status"], "dismissed")

    def test_a_dismissal_that_cannot_be_stored_is_asked_for_again(self):
        job = self.submit("sleep 600 and again").json["jobID"]
        daemon.wait_until(lambda: self.get(f"/jobs/{job}").json["status"] == "running", "its run")
        self.fill()
        for _ in range(3):
            self.assert_problem(self.request("DELETE", f"/jobs/{job}"), 507)
        self.faults.clear()
        daemon.wait_until(lambda: self.request("DELETE", f"/jobs/{job}").status in (200, 410),
                          "room to dismiss it")
        self.assertEqual(self.get(f"/jobs/{job}").json["status"], "dismissed")


if __name__ == "__main__":
    unittest.main()
