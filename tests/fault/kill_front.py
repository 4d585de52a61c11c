#!/usr/bin/env python3
"""fault.kill_front: the daemon is killed (-9) at random moments, again and again, while jobs are
submitted, run, dismissed and values are uploaded; then all of it is accounted for.

    SCATTERD=build-release/server/scatterd tests/fault/kill_front.py 200

Every job that was accepted (201) ends with the right result, everything that was dismissed (200)
stays dismissed, every upload (201) can be read; and as each submission is repeated with its
Idempotency-Key until it is accepted, there are exactly as many jobs as submissions: none twice.
SCATTERD_SEED=17 repeats a run. Exit status 0 if nothing is lost.
"""

import hashlib
import http.client
import itertools
import json
import os
import pathlib
import random
import signal
import sys
import threading
import time

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "http"))
import daemon  # noqa: E402

SEED = int(os.environ.get("SCATTERD_SEED", time.time_ns() % 1000000))
OPTIONS = ["--workers", "2", "--job-attempts", "1000", "--job-queue", "100000",
           "--log-level", "error", "--log-level", "info"]
CLIENTS = 4
LISTED = 1000  # jobs of one page


def echo(value, size):
    """A job that gives back what it was sent; returns the body and a check of the results."""
    text = f"{value} " + size * "x"
    return ("/processes/echo/execution", {"inputs": {"message": text}},
            lambda results: results["message"] == text)


def constant(value, cells):
    """Laplace's equation with the same value on all of the boundary."""
    body = {"inputs": {
        "cloud": {"lattice": {"lower": [0, 0], "upper": [1, 1], "cells": [cells, cells]}},
        "diffusivity": 1, "boundary": [{"on": "boundary", "type": "dirichlet", "value": value}]},
        "outputs": {"solution": {}}}
    return ("/processes/solve/execution", body,
            lambda results: all(abs(u - value) < 1e-9 * (1 + abs(value))
                                for u in results["solution"]))


def batch(value):
    """Three solves in one."""
    body = {"inputs": {"request": {"process": "solve", **constant(0, 5)[1]},
                       "parameters": {"a": [value, value + 1, value + 2]}}}
    body["inputs"]["request"]["inputs"]["boundary"][0]["value"] = "a"

    def check(results):
        text = json.dumps(results)
        return all(f"{value + k}" in text for k in range(3))
    return "/processes/batch/execution", body, check


def any_job(generator, value):
    return generator.choice([lambda: echo(value, 10), lambda: echo(value, 30000),
                             lambda: constant(value, 6), lambda: constant(value, 40),
                             lambda: batch(value)])()


class Daemon:
    """The daemon of the moment."""

    def __init__(self):
        self.starts = itertools.count()
        self.server = self.start()
        self.longest_start = 0

    def start(self, **more):
        """Every other one keeps everything by its second thread."""
        aside = "0" if next(self.starts) % 2 == 0 else "1MiB"
        return daemon.Daemon(*OPTIONS, "--aside-bytes", aside, stub=False, **more)

    def kill(self):
        self.server.stop(signal.SIGKILL, keep=True)
        began = time.monotonic()
        self.server = self.start(directory=self.server.directory)
        self.longest_start = max(self.longest_start, time.monotonic() - began)


class Client(threading.Thread):
    """Works until it is stopped, and keeps what it was promised."""

    def __init__(self, number, moment):
        super().__init__()
        self.generator = random.Random(SEED + number)
        self.number, self.moment = number, moment
        self.jobs, self.dismissed, self.uploads = {}, set(), {}
        self.repeated = 0
        self.stopped = False
        self.failure = None

    def ask(self, method, path, body=None, headers=None):
        """One request, until there is an answer."""
        for attempt in range(10000):
            try:
                reply = self.moment.server.request(method, path, body, headers)
                self.repeated += attempt > 0
                return reply
            except (OSError, http.client.HTTPException):
                time.sleep(0.01)
        raise AssertionError("no answer")

    def submit(self, count):
        value = 1000 * count + self.number
        path, body, check = any_job(self.generator, value)
        headers = {"Content-Type": "application/json", "Prefer": "respond-async",
                   "Idempotency-Key": f"{self.number}-{count}"}
        reply = self.ask("POST", path, json.dumps(body), headers)
        assert reply.status == 201, (reply.status, reply.body)
        self.jobs[reply.json["jobID"]] = check
        if self.generator.random() < 0.1:
            job = reply.json["jobID"]
            reply = self.ask("DELETE", f"/jobs/{job}")
            assert reply.status in (200, 410), (reply.status, reply.body)
            self.dismissed.add(job)

    def upload(self, count):
        text = json.dumps([self.number, count])
        reply = self.ask("POST", "/data", text, {"Content-Type": "application/json"})
        assert reply.status in (200, 201), (reply.status, reply.body)
        self.uploads["/data/" + hashlib.sha256(text.encode()).hexdigest()] = text

    def run(self):
        try:
            count = 0
            while not self.stopped:
                count += 1
                if count % 4 == 0:
                    self.upload(count)
                else:
                    self.submit(count)
                time.sleep(self.generator.uniform(0, 0.05))
        except Exception as failure:  # told by the main thread
            self.failure = failure


def account(server, clients):
    """What is lost, as lines of text."""
    lost = []
    for client in clients:
        for job, check in client.jobs.items():
            info = daemon.wait_until(
                lambda: (lambda i: i["status"] not in ("accepted", "running") and i)(
                    server.request("GET", f"/jobs/{job}", headers={"Prefer": "wait=30"}).json),
                f"the end of {job}", 300)
            wanted = "dismissed" if job in client.dismissed else "successful"
            if info["status"] != wanted:
                lost.append(f"{job} is {info['status']}, not {wanted}: {info['message']}")
            elif wanted == "successful":
                reply = server.request("GET", f"/jobs/{job}/results")
                if reply.status != 200 or not check(reply.json):
                    lost.append(f"{job}: {reply.status} {reply.body[:200]}")
        for path, text in client.uploads.items():
            reply = server.request("GET", path)
            if reply.status != 200 or reply.body.decode() != text:
                lost.append(f"{path}: {reply.status}")
    return lost


def jobs_listed(server):
    total, offset = 0, 0
    while True:
        page = len(server.request("GET", f"/jobs?limit={LISTED}&offset={offset}").json["jobs"])
        total, offset = total + page, offset + page
        if page < LISTED:
            return total


def wait_for_work(clients, generator):
    """Until some more jobs are accepted, and a moment; soon at times, in the middle of a start."""
    def accepted():
        return sum(len(client.jobs) for client in clients)
    wanted, end = accepted() + generator.choice([0, 2, 10]), time.monotonic() + 20
    while accepted() < wanted and time.monotonic() < end:
        time.sleep(0.002)
    time.sleep(generator.choice([0, 0.01, 0.1]) * generator.random())


def main(kills):
    print(f"SCATTERD_SEED={SEED}", flush=True)
    generator = random.Random(SEED)
    moment = Daemon()
    clients = [Client(k, moment) for k in range(CLIENTS)]
    for client in clients:
        client.start()
    try:
        for k in range(kills):
            wait_for_work(clients, generator)
            moment.kill()
            if k % 20 == 19:
                print(f"{k + 1} kills, {sum(len(c.jobs) for c in clients)} jobs", flush=True)
    finally:
        for client in clients:
            client.stopped = True
        for client in clients:
            client.join()
    failures = [client.failure for client in clients if client.failure]
    lost = account(moment.server, clients)
    jobs = sum(len(client.jobs) for client in clients)
    listed = jobs_listed(moment.server)
    status = moment.server.stop()
    print(f"{kills} kills: {jobs} jobs accepted ({sum(len(c.dismissed) for c in clients)} of them "
          f"dismissed), {sum(len(c.uploads) for c in clients)} uploads, "
          f"{sum(c.repeated for c in clients)} requests repeated; {len(lost)} lost, "
          f"{listed - jobs} too many; a start took {moment.longest_start:.2f} s at most")
    for line in [*lost, *failures]:
        print(line)
    return 0 if not lost and not failures and listed == jobs and status == 0 and jobs else 1


if __name__ == "__main__":
    sys.exit(main(int(sys.argv[1]) if len(sys.argv) > 1 else 200))
