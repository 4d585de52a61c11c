#!/usr/bin/env python3
"""http.backup: scatterd-backup copies the data directory of a daemon that is being used; a daemon
started on the copy has every job and object that was there when the copying began."""

import os
import pathlib
import subprocess
import sys
import threading
import unittest

sys.dont_write_bytecode = True
import daemon  # noqa: E402

BACKUP = pathlib.Path(__file__).parents[2] / "server/packaging/scatterd-backup"
DEFERRED = {"Prefer": "respond-async"}


def body_of(count):
    return f"job {count}" + (count % 2) * 20000 * " "  # in the row; in a file


class Backup(unittest.TestCase):

    def submit(self, server, count):
        reply = server.request("POST", daemon.EXECUTE, body_of(count), DEFERRED)
        self.assertEqual(reply.status, 201, reply.body)
        return reply.json["jobID"]

    def keep_busy(self, server, stop):
        count = 1000
        while not stop.is_set():
            job = self.submit(server, count)
            if count % 3 == 0:
                server.request("DELETE", f"/jobs/{job}")
            count += 1

    def back_up(self, server, target):
        return subprocess.run([BACKUP, server.data, target], check=False, capture_output=True,
                              text=True)

    def start_on(self, copy):
        server = daemon.Daemon("--workers", "2", directory=copy)
        server.wait_ready()
        return server

    def test_a_copy_of_a_busy_daemon_is_whole(self):
        server = daemon.Daemon("--workers", "2")
        server.wait_ready()
        copy = server.directory + "-copy"
        os.mkdir(copy)
        jobs = {self.submit(server, count): body_of(count) for count in range(20)}
        stored = server.request("POST", "/data", "[1, 2, 3]", {"Content-Type": "application/json"})
        stop = threading.Event()
        busy = threading.Thread(target=self.keep_busy, args=(server, stop))
        busy.start()
        done = self.back_up(server, os.path.join(copy, "data"))
        again = self.back_up(server, os.path.join(copy, "data"))
        stop.set()
        busy.join()
        server.stop()
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertEqual(again.returncode, 1)
        self.assertIn("is there already", again.stderr)

        restored = self.start_on(copy)
        for job, body in jobs.items():
            info = restored.request("GET", f"/jobs/{job}", headers={"Prefer": "wait=60"})
            self.assertEqual(info.json.get("status"), "successful", info.body)
            reply = restored.request("GET", f"/jobs/{job}/results")
            self.assertEqual((reply.status, reply.body.decode()), (200, body))
        value = restored.request("GET", stored.headers["Location"])
        self.assertEqual((value.status, value.json), (200, [1, 2, 3]))
        self.assertEqual(restored.stop(), 0)


if __name__ == "__main__":
    unittest.main()
