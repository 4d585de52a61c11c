#!/usr/bin/env python3
"""http.jobs_kill9: the daemon is killed at random moments while jobs come in and run; every job it
accepted (201) ends with its result. SCATTERD_SEED=17 repeats a run, SCATTERD_KILLS=20 is longer."""

import http.client
import os
import random
import signal
import sys
import threading
import time
import unittest

sys.dont_write_bytecode = True
import daemon  # noqa: E402

SEED = int(os.environ.get("SCATTERD_SEED", time.time_ns() % 1000000))
KILLS = int(os.environ.get("SCATTERD_KILLS", 6))


class Client(threading.Thread):
    """Submits jobs until it is stopped; keeps what was accepted."""

    def __init__(self, name):
        super().__init__(name=name)
        self.accepted = {}
        self.server = None
        self.stopped = False

    def run(self):
        count = 0
        while not self.stopped:
            server = self.server
            body = f"job {self.name} {count}" + (count % 2) * 20000 * " "  # small and large ones
            count += 1
            try:
                reply = server.request("POST", daemon.EXECUTE, body, {"Prefer": "respond-async"})
                if reply.status == 201:
                    self.accepted[reply.json["jobID"]] = body
            except (OSError, http.client.HTTPException, ValueError):
                time.sleep(0.02)  # killed: an answer that did not come binds nobody


class Kill9(unittest.TestCase):

    def start(self, directory=None):
        return daemon.Daemon("--workers", "3", "--job-attempts", "1000", "--log-level", "error",
                             "--log-level", "info", directory=directory)

    def wait_for_more(self, clients):
        def accepted():
            return sum(len(client.accepted) for client in clients)
        before = accepted()
        daemon.wait_until(lambda: accepted() > before + 1, "two more jobs accepted")

    def test_no_accepted_job_is_lost(self):
        print(f"SCATTERD_SEED={SEED}")
        generator = random.Random(SEED)
        server = self.start()
        clients = [Client(str(k)) for k in range(3)]
        for client in clients:
            client.server = server
            client.start()
        try:
            for kill in range(KILLS):
                if kill % 2 == 1:  # the others may come before it is up
                    self.wait_for_more(clients)
                time.sleep(generator.uniform(0.05, 0.8))
                server.stop(signal.SIGKILL, keep=True)
                server = self.start(server.directory)
                for client in clients:
                    client.server = server
        finally:
            for client in clients:
                client.stopped = True
            for client in clients:
                client.join()
        accepted = {job: body for client in clients for job, body in client.accepted.items()}
        print(f"{KILLS} kills, {len(accepted)} jobs accepted")
        self.addCleanup(server.stop, signal.SIGKILL)
        self.assertGreater(len(accepted), KILLS)
        for job, body in accepted.items():
            info = server.request("GET", f"/jobs/{job}", headers={"Prefer": "wait=60"}).json
            self.assertEqual(info.get("status"), "successful", info)
            reply = server.request("GET", f"/jobs/{job}/results")
            self.assertEqual((reply.status, reply.body.decode()), (200, body))
        self.assertEqual(server.stop(), 0)


if __name__ == "__main__":
    unittest.main()
