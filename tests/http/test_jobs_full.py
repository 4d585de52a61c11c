#!/usr/bin/env python3
"""http.jobs_full: the disk fills up, and is emptied again (disk_full.c): 507, a healthy daemon,
nothing accepted is lost."""

import os
import pathlib
import sys
import tempfile
import unittest

sys.dont_write_bytecode = True
import daemon  # noqa: E402

DIRECTORY = tempfile.mkdtemp(prefix="daemon-test-")
FLAG = pathlib.Path(DIRECTORY, "full")
PRELOAD = os.environ["SCATTERD_DISK_SHIM"]


@unittest.skipIf(daemon.is_sanitized(), "the sanitizer must be loaded first")
class Full(daemon.Case):
    @classmethod
    def setUpClass(cls):
        cls.daemon = daemon.Daemon("--workers", "2", "--spool-bytes", "1MiB", directory=DIRECTORY,
                                   environment={"LD_PRELOAD": PRELOAD,
                                                "SCATTERD_DISK_FULL": str(FLAG),
                                                "SCATTERD_DISK_DATA": DIRECTORY + "/data"})
        cls.daemon.wait_ready()

    def tearDown(self):
        FLAG.unlink(missing_ok=True)

    def submit(self, body):
        return self.execute(body, Prefer="respond-async")

    def status(self, job):
        return self.get(f"/jobs/{job}", Prefer="wait=20").json

    def test_submission(self):
        FLAG.touch()
        for _ in range(3):
            self.assert_problem(self.submit("no room"), 507, "full")
            self.assert_problem(self.submit("no room" + 20000 * " "), 507, "full")
        self.assertEqual(self.execute("synchronous").body, b"synchronous")
        self.assertEqual(self.get("/healthz").status, 200)
        self.assert_problem(self.execute(b"x" * (2 << 20)), 507)
        FLAG.unlink()
        reply = self.submit("room again")
        self.assertEqual(reply.status, 201)
        self.assertEqual(self.status(reply.json["jobID"])["status"], "successful")

    def test_result(self):
        job = self.submit("sleep 0.7" + 20000 * " ").json["jobID"]
        daemon.wait_until(lambda: self.get(f"/jobs/{job}").json["status"] == "running", "its run")
        FLAG.touch()
        self.assertEqual(self.execute("sleep 1").status, 200)
        self.assertEqual(self.get("/healthz").status, 200)
        FLAG.unlink()
        self.assertEqual(self.status(job)["status"], "failed")
        self.assert_problem(self.get(f"/jobs/{job}/results"), 507, "result")

    def test_a_small_result_is_stored_later(self):
        job = self.submit("sleep 0.7").json["jobID"]
        daemon.wait_until(lambda: self.get(f"/jobs/{job}").json["status"] == "running", "its run")
        FLAG.touch()
        self.assertEqual(self.execute("sleep 1").status, 200)
        FLAG.unlink()
        self.assertEqual(self.status(job)["status"], "successful")
        self.assertEqual(self.get(f"/jobs/{job}/results").body, b"sleep 0.7")

    def test_the_end_is_stored_later(self):
        job = self.submit("big 100000").json["jobID"]
        self.status(job)
        FLAG.touch()
        reply = self.request("DELETE", f"/jobs/{job}")
        self.assertIn(reply.status, (200, 507))
        FLAG.unlink()
        daemon.wait_until(lambda: self.request("DELETE", f"/jobs/{job}").status in (200, 410),
                          "room to dismiss it")
        self.assertEqual(self.get(f"/jobs/{job}").json["status"], "dismissed")


if __name__ == "__main__":
    unittest.main()
