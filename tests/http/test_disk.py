#!/usr/bin/env python3
"""http.disk: calls on the data directory fail, each in its turn: write, read, fsync, rename, open,
ftruncate, unlink, by ourselves or by SQLite (fault_shim.c), while the daemon serves and while it
starts. It goes on or says why it cannot start; what it accepted ends as it should, or has failed
and says why; nothing is lost. SCATTERD_EVERY=1 takes each call and each errno, not only some."""

import contextlib
import errno
import http.client
import itertools
import os
import shutil
import signal
import subprocess
import sys
import time
import unittest

sys.dont_write_bytecode = True
import daemon  # noqa: E402
import faults as ordered  # noqa: E402
from accounting import LARGE, account, ended, submit, work  # noqa: E402

EVERY = os.environ.get("SCATTERD_EVERY")
ERRORS = {"write": (errno.ENOSPC, errno.EIO, 0), "sync": (errno.EIO, errno.ENOSPC),
          "open": (errno.EMFILE, errno.EACCES, errno.ENOSPC), "rename": (errno.EIO, errno.ENOSPC),
          "read": (errno.EIO,), "truncate": (errno.EIO,), "unlink": (errno.EIO,)}
ORDERS = [(kind, error) for kind, errors in ERRORS.items() for error in
          (errors if EVERY else errors[:1])]
OPTIONS = ["--workers", "3", "--spool-bytes", "64KiB", "--job-attempts", "100",
           "--reuse-results", "0"]
class Case(unittest.TestCase):
    def setUp(self):
        self.faults = ordered.Faults()
        self.addCleanup(self.faults.close)
        self.addCleanup(shutil.rmtree, self.faults.directory, True)

    @contextlib.contextmanager
    def afresh(self, **what):
        """A subtest with a directory of its own; whatever becomes of it, nothing is left."""
        with self.subTest(**what):
            self.doCleanups()
            self.setUp()
            yield

    def start(self):
        server = daemon.Daemon(*OPTIONS, directory=self.faults.directory,
                               environment=self.faults.environment)
        self.addCleanup(lambda: server.process.poll() is None and server.stop())
        return server

    def assert_well(self, server):
        self.assertIsNone(server.process.poll(), "\n".join(server.log[-20:]))
        log = "\n".join(server.log)
        self.assertNotIn("Sanitizer", log)
        self.assertNotIn("runtime error", log)


class Serving(Case):
    def each(self, kind, error):
        """The n-th call fails, for every n that there is, or a choice of them."""
        server = self.start()
        server.wait_ready()
        accepted, failed = {}, 0
        tries = 0
        for n in itertools.count(0, 1 if EVERY or kind != "write" else 3):
            self.faults.fail(kind, error, after=n, times=1)
            mine = {}
            work(server, mine)
            hit = self.faults.hits(kind)
            self.faults.clear()
            failed += account(server, mine, True)
            accepted |= mine
            self.assert_well(server)
            tries += hit
            if not hit:
                break
        self.assertTrue(work(server, accepted), "not well after the last fault")
        kept = {job: body for job, body in accepted.items()
                if ended(server, job).json["status"] == "successful"}
        server.stop(signal.SIGKILL, keep=True)
        server = self.start()
        account(server, kept, False)
        self.assertEqual(server.stop(keep=True), 0)
        return tries, len(accepted), failed

    def test_each_call(self):
        for kind, error in ORDERS:
            with self.afresh(kind=kind, error=errno.errorcode.get(error, "short")):
                tries, accepted, failed = self.each(kind, error)
                print(f"{kind} {errno.errorcode.get(error, 'short')}: {tries} calls failed, "
                      f"{accepted} jobs accepted, {failed} of them failed with a reason, "
                      "none lost", flush=True)
                self.assertTrue(tries > 0 or kind in ("read", "truncate"))  # which SQLite may save

    def test_all_calls_for_a_while(self):
        """Everything fails; afterwards all is as before."""
        server = self.start()
        server.wait_ready()
        accepted = {}
        self.assertTrue(work(server, accepted))
        for kind, error in ORDERS:
            if error == 0:
                continue  # half a write is a write
            with self.subTest(kind=kind):
                mine = {}
                late = submit(server, mine, f"sleep 0.3 {kind}" + LARGE)
                self.faults.fail(kind, error)
                for _ in range(3):
                    work(server, mine)
                self.assertEqual(server.request("GET", "/healthz").status, 200)
                self.assertEqual(server.request("GET", "/metrics").status, 200)
                time.sleep(0.5)
                self.faults.clear()
                self.assertIsNotNone(late)
                account(server, mine, True)
                accepted |= mine
                self.assertTrue(work(server, accepted))
                self.assert_well(server)
        account(server, accepted, True)
        self.assertEqual(server.stop(keep=True), 0)


class Starting(Case):
    """Accepted jobs, results and uploads of an earlier daemon bear a start that fails."""

    def before(self):
        server = self.start()
        server.wait_ready()
        accepted, waiting = {}, {}
        self.assertTrue(work(server, accepted))
        account(server, accepted, False)
        for k in range(3):
            submit(server, waiting, f"sleep 0.2 waits {k}" + LARGE)
            submit(server, waiting, f"sleep 0.2 waits too {k}")
        upload = server.request("POST", "/data", "[3, 1, 4]",
                                {"Content-Type": "application/json"})
        self.assertEqual(upload.status, 201, upload.body)
        server.stop(signal.SIGKILL, keep=True)
        return accepted | waiting, upload.headers["Location"]

    def attempt(self, kind, error, n):
        """Starts with the n-th call failing; whether one did."""
        self.faults.fail(kind, error, after=n, times=1)
        with contextlib.suppress(AssertionError):
            server = self.start()
            self.assertEqual(server.request("GET", "/healthz").status, 200)
            hit = self.faults.hits(kind)
            self.faults.clear()
            server.stop(signal.SIGKILL, keep=True)
            return hit
        hit = self.faults.hits(kind)
        self.assertGreater(hit, 0, "it does not start")
        self.faults.clear()
        return hit

    def test_each_call(self):
        for kind, error in ORDERS:
            with self.afresh(kind=kind, error=errno.errorcode.get(error, "short")):
                accepted, data = self.before()
                tries = 0
                for n in itertools.count(0, 1 if EVERY else 2):
                    hit = self.attempt(kind, error, n)
                    tries += hit
                    if not hit:
                        break
                server = self.start()
                account(server, accepted, False)
                path = "/" + data.split("/", 3)[3] if "://" in data else data
                self.assertEqual(server.request("GET", path).status, 200)
                self.assertEqual(server.stop(keep=True), 0)
                print(f"start, {kind} {errno.errorcode.get(error, 'short')}: {tries} calls failed, "
                      f"{len(accepted)} jobs and an upload kept", flush=True)


MOUNTED = "SCATTERD_TMPFS"  # set in the run of this file that may mount


class ReallyFull(unittest.TestCase):
    """A file system of 4 MB that fills up."""

    def setUp(self):
        if os.environ.get(MOUNTED):
            return
        if subprocess.run(["unshare", "-rm", "true"], capture_output=True).returncode != 0:
            self.skipTest("no file system may be mounted here (unshare -rm)")
        self.skipTest("runs in a namespace of its own, below")

    def test_full(self):
        directory = os.environ[MOUNTED]
        server = daemon.Daemon(*OPTIONS, "--data-bytes", "1GiB", directory=directory)
        self.addCleanup(lambda: server.process.poll() is None and server.stop())
        server.wait_ready()
        reserve = os.path.join(directory, "reserve")
        with open(reserve, "wb") as file:
            file.write(bytes(300000))
        accepted, refused = {}, 0
        for k in range(200):
            before = len(accepted)
            submit(server, accepted, f"fills {k}" + 100000 * " ")
            refused += len(accepted) == before
        print(f"{len(accepted)} accepted, {refused} refused by a full disk")
        self.assertGreater(len(accepted), 5)
        self.assertGreater(refused, 5)
        os.unlink(reserve)  # how a job ended takes some room to be stored; until then it is not over
        failures = account(server, accepted, True)
        print(f"{failures} of {len(accepted)} failed with 507")
        filler = os.path.join(directory, "filler")
        with contextlib.suppress(OSError), open(filler, "wb") as file:
            while True:
                file.write(b"\0" * 4096)
                file.flush()
        full = server.request("POST", daemon.EXECUTE, "no room" + LARGE,
                              {"Content-Type": "application/json", "Prefer": "respond-async"})
        self.assertEqual(full.status, 507, full.body)
        self.assertEqual(server.request("POST", daemon.EXECUTE, "sync",
                                        {"Content-Type": "application/json"}).body, b"sync")
        self.assertEqual(server.request("GET", "/healthz").status, 200)
        server.stop(signal.SIGKILL, keep=True)  # and restarts while it is full
        with contextlib.suppress(AssertionError):
            daemon.Daemon(*OPTIONS, directory=directory).stop(signal.SIGKILL, keep=True)
        os.unlink(filler)
        server = daemon.Daemon(*OPTIONS, directory=directory)
        self.assertEqual(account(server, accepted, True), failures)
        self.assertLess(failures, len(accepted))
        for job in list(accepted)[: len(accepted) // 2]:
            self.assertEqual(server.request("DELETE", f"/jobs/{job}").status, 200)
        again = {}
        self.assertIsNotNone(submit(server, again, "room again" + LARGE))
        self.assertEqual(account(server, again, False), 0)
        self.assertEqual(server.stop(keep=True), 0)


class InNamespace(unittest.TestCase):
    def test_full(self):
        if os.environ.get(MOUNTED):
            self.skipTest("this is it")
        script = ('d=$(mktemp -d) && mount -t tmpfs -o size=4m full "$d" && '
                  f'{MOUNTED}="$d" exec "$0" "$@"')
        command = ["unshare", "-rm", "sh", "-c", script, sys.executable, __file__, "ReallyFull"]
        if subprocess.run(["unshare", "-rm", "sh", "-c", "mount -t tmpfs none /mnt"],
                          capture_output=True).returncode != 0:
            self.skipTest("no file system may be mounted here (unshare -rm)")
        run = subprocess.run(command, capture_output=True, text=True)
        print(run.stdout)
        self.assertEqual(run.returncode, 0, run.stdout + run.stderr)


if __name__ == "__main__":
    unittest.main()
