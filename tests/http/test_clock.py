#!/usr/bin/env python3
"""http.clock: somebody sets the time of day by hours, forward and back. Nothing expires that has
time left, what has none goes, nothing hangs, deadlines and waits keep their length.

http.clock.postgres: the same of a daemon whose store is shared; of two of them whose clocks differ
by hours; and of the clock of their database."""

import datetime
import http.server
import os
import re
import shutil
import signal
import sys
import threading
import time
import unittest

sys.dont_write_bytecode = True
import daemon  # noqa: E402
import faults as ordered  # noqa: E402
import postgres  # noqa: E402

HOURS = 3600
STEPS = (3 * HOURS, -5 * HOURS)
LEASE = 9  # who stands still for as long loses what it runs, as it should; a beat comes every 3 s
FINAL = ("successful", "failed", "dismissed")


def steps_seen(server, step):
    """How often the log tells of a step of the clock of so many seconds, give or take a moment."""
    told = (re.search(r"event=clock .*set by (-?\d+) s", line) for line in list(server.log))
    return sum(found is not None and abs(int(found[1]) - step) < 60 for found in told)


class Case(unittest.TestCase):
    def setUp(self):
        self.faults = ordered.Faults()
        self.addCleanup(self.faults.close)
        self.addCleanup(shutil.rmtree, self.faults.directory, True)

    def start(self, *options, **how):
        how = {"directory": self.faults.directory, "environment": self.faults.environment, **how}
        server = daemon.Daemon("--workers", "2", "--reuse-results", "0", *options, **how)
        self.addCleanup(lambda: server.process.poll() is None and server.stop())
        server.wait_ready()
        return server

    def submit(self, server, body):
        reply = server.request("POST", daemon.EXECUTE, body,
                               {"Content-Type": "application/json", "Prefer": "respond-async"})
        self.assertEqual(reply.status, 201, reply.body)
        return reply.json["jobID"]

    def end_of(self, server, job):
        return daemon.wait_until(
            lambda: (lambda info: info if info["status"] in FINAL else None)(server.request(
                "GET", f"/jobs/{job}", headers={"Prefer": "wait=30"}).json), f"the end of {job}")

    def have_done(self, server, body):
        """A job that is successful by now; who comes late may not find it any more."""
        reply = server.request("POST", daemon.EXECUTE, body, {
            "Content-Type": "application/json", "Prefer": "respond-async, wait=30"})
        self.assertEqual((reply.status, reply.body), (200, body.encode()))
        return reply.headers["Content-Location"].split("/")[-2]

    def stream(self, server, job):
        """The events of a job as they come."""
        connection = server.connect()
        self.addCleanup(connection.close)
        connection.request("GET", f"/jobs/{job}/events", headers={"Last-Event-ID": "1"})
        return connection.getresponse()

    def set_clock(self, server, seconds):
        """And lets it be seen."""
        self.faults.set_clock(seconds)
        server.wait_taken_in()

    def assert_followed(self, server, step):
        """What expires was moved with the clock, if it goes by that at all."""
        if not daemon.shares_store():
            daemon.wait_until(lambda: steps_seen(server, step) > 0, "the shift")
        self.assertFalse(daemon.shares_store() and any("event=clock" in line for line in server.log))

    def upload(self, server, body):
        reply = server.request("POST", "/data", body, {"Content-Type": "application/json"})
        self.assertIn(reply.status, (200, 201), reply.body)
        return "/data/" + reply.headers["Location"].rsplit("/", 1)[1]


class Expiry(Case):
    def test_what_has_time_left_stays(self):
        options = ("--result-seconds", str(HOURS), "--data-seconds", str(HOURS))
        server = self.start(*options)
        job, data = self.submit(server, "stays"), self.upload(server, "[1, 2]")
        self.assertEqual(self.end_of(server, job)["status"], "successful")
        clock = 0
        for step in STEPS:
            clock += step
            self.faults.set_clock(clock)
            self.assertEqual(server.request("GET", data).status, 200)
            self.assertEqual(server.request("GET", f"/jobs/{job}/results").body, b"stays")
            self.assert_followed(server, step)
            server.stop(signal.SIGKILL, keep=True)
            server = self.start(*options)
            self.assertEqual(server.request("GET", data).status, 200)
            self.assertEqual(server.request("GET", f"/jobs/{job}/results").body, b"stays")
        self.assertEqual(server.stop(keep=True), 0)

    def test_what_has_none_left_goes(self):
        for clock in STEPS:
            with self.subTest(clock=clock):
                self.faults.set_clock(0)
                server = self.start("--result-seconds", "3", "--data-seconds", "3")
                job, data = self.have_done(server, "goes"), self.upload(server, "[3, 4]")
                self.faults.set_clock(clock)
                daemon.wait_until(lambda: server.request("GET", f"/jobs/{job}").status == 404,
                                  "the end of a result")
                daemon.wait_until(lambda: server.request("GET", data).status == 404,
                                  "the end of an upload")
                self.assertEqual(server.stop(keep=True), 0)

    @unittest.skipIf(daemon.shares_store(), "nothing is written then")
    def test_while_the_disk_is_full(self):
        server = self.start("--result-seconds", str(HOURS))
        job = self.submit(server, "stays")
        self.end_of(server, job)
        self.faults.fail("write", 28)
        self.faults.set_clock(3 * HOURS)
        time.sleep(1.5)
        self.assertEqual(server.request("GET", "/healthz").status, 200)
        self.faults.clear()
        daemon.wait_until(lambda: any("event=clock" in line for line in server.log), "the shift")
        self.assertEqual(server.request("GET", f"/jobs/{job}/results").body, b"stays")
        self.assertEqual(server.stop(keep=True), 0)


class Waiting(Case):
    def test_jobs_and_those_who_watch(self):
        server = self.start("--heartbeat-seconds", "0.5")
        for step in STEPS:
            with self.subTest(step=step):
                self.faults.set_clock(0)
                job = self.submit(server, f"phase half 0.5 600 {step}")
                stream = self.stream(server, job)
                while b"half" not in stream.readline():
                    pass
                self.set_clock(server, step)
                with server.waking():
                    rest = stream.read().decode()
                ids = [int(line.split(":")[1]) for line in rest.splitlines()
                       if line.startswith("id:")]
                self.assertEqual(ids, sorted(ids))
                self.assertIn("successful", rest)
                again = server.request("GET", f"/jobs/{job}/events",
                                       headers={"Last-Event-ID": "1"})
                self.assertIn(b"successful", again.body)
                info = self.end_of(server, job)
                self.assertLessEqual(info["created"], info["updated"])
                self.assertLessEqual(info["started"], info["finished"])

    def test_a_client_that_returns_after_a_step_back(self):
        server = self.start()
        job = self.submit(server, "phase half 0.5 600")
        stream = self.stream(server, job)
        last = None
        while last is None or b"half" not in line:
            line = stream.readline()
            if line.startswith(b"id:"):
                last = line.split(b":")[1].strip().decode()
        stream.close()
        self.set_clock(server, -5 * HOURS)
        with server.waking():
            self.end_of(server, job)
        reply = server.request("GET", f"/jobs/{job}/events", headers={"Last-Event-ID": last})
        self.assertIn(b"successful", reply.body)

    def test_waits_and_deadlines_keep_their_length(self):
        server = self.start("--seconds", "2", "--receive-seconds", "2", "--idle-seconds", "1000")
        job = self.submit(server, "sleep 600")
        daemon.wait_until(lambda: server.request("GET", f"/jobs/{job}").json["status"] == "running",
                          "its run")
        for step in (*STEPS, 0):
            with self.subTest(step=step):
                kept = server.connect()
                self.addCleanup(kept.close)
                kept.request("GET", "/healthz")
                kept.getresponse().read()
                timer = threading.Timer(0.5, self.faults.set_clock, (step,))
                timer.start()
                began = time.monotonic()
                info = server.request("GET", f"/jobs/{job}", headers={"Prefer": "wait=2"}).json
                self.assertEqual(info["status"], "running")
                self.assertGreater(time.monotonic() - began, 1.9)
                began = time.monotonic()
                reply = server.request("POST", daemon.EXECUTE, "sleep 60",
                                       {"Content-Type": "application/json"})
                self.assertEqual(reply.status, 504, reply.body)
                self.assertGreater(time.monotonic() - began, 1.9)
                kept.request("GET", "/healthz")  # idle, but not for hours
                self.assertEqual(kept.getresponse().status, 200)
                timer.join()
        self.assertEqual(server.request("DELETE", f"/jobs/{job}").status, 200)

    def test_a_subscriber_is_called_again(self):
        calls = []

        class Subscriber(http.server.BaseHTTPRequestHandler):
            def do_POST(self):
                self.rfile.read(int(self.headers["Content-Length"]))
                calls.append(time.monotonic())
                self.send_response(503 if len(calls) == 1 else 204)
                self.end_headers()

            def log_message(self, *_):
                pass

        host = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Subscriber)
        threading.Thread(target=host.serve_forever, daemon=True).start()
        self.addCleanup(host.server_close)
        self.addCleanup(host.shutdown)
        address = f"127.0.0.1:{host.server_port}"
        server = self.start("--callback-hosts", address)
        for step in STEPS:
            with self.subTest(step=step):
                calls.clear()
                self.faults.set_clock(0)
                server.request("GET", "/healthz")
                self.submit(server, f"call http://{address}/{step}")
                daemon.wait_until(lambda: len(calls) >= 1, "the first call")
                self.faults.set_clock(step)
                daemon.wait_until(lambda: len(calls) >= 2, "the second call")


@unittest.skipUnless(daemon.shares_store(), "one daemon is alone with its store")
class Shared(Case):
    """Two daemons on one store: the clock of the first is set, that of the second is right."""

    def start_two(self, *options):
        """With the clock of the first as it is at the moment."""
        url = daemon.database(os.path.basename(self.faults.directory))
        return self.start(*options, store=url), self.start(*options, store=url, directory=None,
                                                           environment=None)

    def assert_now(self, text):
        when = datetime.datetime.fromisoformat(text.replace("Z", "+00:00")).timestamp()
        self.assertLess(abs(when - time.time()), daemon.PATIENCE)

    def test_clocks_that_differ(self):
        for clock in STEPS:
            with self.subTest(clock=clock):
                self.faults.set_clock(clock)
                both = self.start_two("--result-seconds", str(HOURS), "--data-seconds", str(HOURS))
                made = [(self.submit(server, f"at {k} {clock}"), self.upload(server, f"[{k}]"))
                        for k, server in enumerate(both)]
                for job, data in made:
                    info = self.end_of(both[0], job)
                    for date in ("created", "started", "finished", "updated"):
                        self.assert_now(info[date])
                    for server in both:
                        self.assertEqual(server.request("GET", data).status, 200)
                        self.assertEqual(server.request("GET", f"/jobs/{job}/results").status, 200)
                for server in both:
                    self.assertEqual(server.stop(keep=server is both[0]), 0)

    def test_what_has_no_time_left_goes(self):
        for clock in STEPS:
            with self.subTest(clock=clock):
                self.faults.set_clock(clock)
                both = self.start_two("--result-seconds", "3", "--data-seconds", "3")
                job, data = self.have_done(both[0], "goes"), self.upload(both[0], "[3, 4]")
                for server in both:
                    for path in (f"/jobs/{job}", data):
                        daemon.wait_until(lambda s=server, p=path:
                                          s.request("GET", p).status == 404, "its end")
                for server in both:
                    self.assertEqual(server.stop(keep=server is both[0]), 0)

    def test_nobody_takes_what_a_daemon_runs_whose_clock_is_set(self):
        self.faults.set_clock(0)
        both = self.start_two("--lease-seconds", str(LEASE))
        jobs = [self.submit(server, f"sleep 600 {k}") for k, server in enumerate(2 * both)]
        for clock in (*STEPS, 0, *STEPS):
            self.faults.set_clock(clock)
            time.sleep(2)
        with both[0].waking(), both[1].waking():
            for job in jobs:
                info = self.end_of(both[1], job)
                self.assertEqual((info["status"], info["attempts"]), ("successful", 1), info)


@unittest.skipUnless(daemon.shares_store(), "no database")
@unittest.skipIf(daemon.is_sanitized(), "the shim would bring the sanitizer into the database")
class Database(Case):
    """The clock that all daemons go by is set."""

    def setUp(self):
        super().setUp()
        os.chmod(self.faults.path, 0o666)  # the server is somebody else
        environment = {**self.faults.environment, "SCATTERD_FAULTS_BELOW": "/nowhere"}
        self.server = postgres.Server("fsync=off", environment=environment)
        self.addCleanup(self.server.stop)
        url = self.server.database("clock")
        self.both = [self.start("--lease-seconds", str(LEASE), store=url, directory=None,
                                environment=None) for _ in range(2)]

    def clock(self):
        return float(self.server.sql("SELECT extract(epoch FROM clock_timestamp())")[0])

    def test_nobody_takes_what_others_run(self):
        jobs = [self.submit(server, f"sleep 600 {k}") for k, server in enumerate(2 * self.both)]
        for k in range(6):
            self.faults.set_clock((k + 1) * 3 * HOURS)
            for server in self.both:
                daemon.wait_until(lambda s=server, n=k + 1: steps_seen(s, 3 * HOURS) == n,
                                  f"step {k}")
        self.assertGreater(self.clock(), time.time() + 17 * HOURS)
        with self.both[0].waking(), self.both[1].waking():
            for job in jobs:
                info = self.end_of(self.both[0], job)
                self.assertEqual((info["status"], info["attempts"]), ("successful", 1), info)

    def test_what_a_dead_one_ran_is_taken_when_it_is_set_back(self):
        jobs = [self.submit(self.both[0], f"sleep 600 {k}") for k in range(4)]
        daemon.wait_until(lambda: len(self.server.sql(
            "SELECT DISTINCT holder FROM jobs WHERE state = 1", "clock")) == 2, "both at work")
        self.both[0].stop(signal.SIGKILL)
        self.faults.set_clock(-5 * HOURS)
        with self.both[1].waking():
            for job in jobs:
                daemon.wait_until(
                    lambda j=job: self.both[1].request("GET", f"/jobs/{j}").json["status"]
                    == "successful", "the end of a job", 2 * daemon.PATIENCE)
        self.assertLess(self.clock(), time.time() - 4 * HOURS)


if __name__ == "__main__":
    unittest.main()
