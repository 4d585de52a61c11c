#!/usr/bin/env python3
"""How long small requests wait while large bodies and results are taken in and kept.

    SCATTERD=... bench_stall.py [--store postgres] [MEGABYTES [ROUNDS]]

One client asks /healthz every 2 ms, another one solves on 11 x 11 points 25 times a second, each over
a connection of its own in a process of its own. A row is what they wait while a third one does, over
and over: nothing; an upload of MEGABYTES (100) to /data, which is removed again; a job whose request
and result are that large, which is dismissed when it is done; an upload that comes while such a job
is at work. The rows take turns, ROUNDS (4) times 5 s each, so that what else the machine does meets
all of them. The last column is how many of the large ones were done in that time. With --store postgres
all is in a PostgreSQL server that is started for it.
"""

import contextlib
import json
import multiprocessing
import os
import pathlib
import sys
import time

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "http"))
import daemon  # noqa: E402
import postgres  # noqa: E402

SECONDS = 5
SOLVE = json.dumps({"inputs": {
    "cloud": {"lattice": {"lower": [0, 0], "upper": [1, 1], "cells": [10, 10]}},
    "diffusivity": 1, "source": 1,
    "boundary": [{"on": "boundary", "type": "dirichlet", "value": 0}]},
    "outputs": {"solution": {}}})
JSON = {"Content-Type": "application/json"}


# ---- The small ones ----

def ask(server, method, path, body, pause, told, stop):
    """Asks every `pause` seconds; the (time, latency) of each goes to a pipe at the end."""
    found, connection, due = [], server.connect(), time.monotonic()
    while not stop.is_set():
        time.sleep(max(0, due - time.monotonic()))
        began = time.monotonic()
        connection.request(method, path, body, JSON)
        reply = connection.getresponse()
        reply.read()
        assert reply.status == 200, reply.status
        due = max(due + pause, began)  # what fell due meanwhile has waited with this one
        found.append((began, time.monotonic() - began))
    told.send(found)


def watch(server):
    """Starts both; call what is returned to stop them and get what they found."""
    stop, ends = multiprocessing.Event(), []
    for what in (("GET", "/healthz", None, 0.002), ("POST", daemon.EXECUTE, SOLVE, 0.04)):
        here, there = multiprocessing.Pipe(False)
        multiprocessing.Process(target=ask, args=(server, *what, there, stop), daemon=True).start()
        ends.append(here)

    def finish():
        stop.set()
        return [end.recv() for end in ends]
    return finish


# ---- The large ones ----

class Large:
    def __init__(self, server, size):
        self.server, self.size, self.count = server, size, 0
        self.head = b"\x93NUMPY\x01\x00" + b"%c\x00" % 118 + (
            "{'descr': '<f8', 'fortran_order': False, 'shape': (%d,), }" % (size // 8)
        ).ljust(117).encode() + b"\n"
        self.values = bytes(size // 8 * 8)

    def fresh(self, many):
        """Bytes that are not known yet."""
        self.count += 1
        return b"%08d" % self.count + many[8:]

    def upload(self):
        reply = self.server.request("POST", "/data", self.head + self.fresh(self.values),
                                    {"Content-Type": "application/x-npy"})
        assert reply.status == 201, reply.body
        self.server.request("DELETE", "/data/" + reply.json["id"])

    def job(self, between=None):
        body = b'{"inputs": {"message": "' + self.fresh(b"x" * self.size) + b'"}}'
        reply = self.server.request("POST", "/processes/echo/execution", body,
                                    JSON | {"Prefer": "respond-async"})
        assert reply.status == 201, reply.body
        job = "/jobs/" + reply.json["jobID"]
        if between is not None:
            between()
        reply = self.server.request("GET", job, headers={"Prefer": "wait=60"})
        assert reply.json["status"] == "successful", reply.body
        self.server.request("DELETE", job)

    def both(self):
        self.job(self.upload)

    def nothing(self):
        time.sleep(0.1)


# ---- The rows ----

def measure(server, work, rows):
    """SECONDS of it, and what is still to be done then."""
    finish, end = watch(server), time.monotonic() + SECONDS
    done = 0
    while time.monotonic() < end:
        work()
        done += 1
    for row, found in zip(rows, finish()):
        row.extend(latency for _, latency in found)
    return done


def line(name, rows, done):
    cells = [name]
    for row in rows:
        row.sort()
        cells += [f"{1e3 * row[len(row) // 2]:.2f}", f"{1e3 * row[len(row) * 99 // 100]:.1f}",
                  f"{1e3 * row[-1]:.0f}", f"{sum(latency > 0.1 for latency in row)} of {len(row)}"]
    print("| " + " | ".join([*cells, str(done)]) + " |", flush=True)


def main(megabytes, rounds):
    server = daemon.Daemon("--workers", "3", "--reuse-results", "0", stub=False)
    try:
        server.wait_ready()
        large = Large(server, megabytes * 1000000)
        works = {"nothing": large.nothing, "uploads": large.upload, "jobs": large.job,
                 "both": large.both}
        rows, done = {name: ([], []) for name in works}, dict.fromkeys(works, 0)
        for _ in range(rounds):
            for name, work in works.items():
                done[name] += measure(server, work, rows[name])
        print(f"{megabytes} MB, {rounds} rounds, load {os.getloadavg()[0]:.1f}\n"
              "| beside | /healthz 50 %, ms | 99 % | longest | above 100 ms | "
              "solve 50 %, ms | 99 % | longest | above 100 ms | large ones |\n" + "|---" * 10 + "|")
        for name in works:
            line(name, rows[name], "" if name == "nothing" else done[name])
    finally:
        server.stop()


if __name__ == "__main__":
    arguments = sys.argv[1:]
    if arguments[:2] == ["--store", "postgres"]:
        os.environ["SCATTERD_TEST_STORE"] = "postgres"
        daemon._server = postgres.Server()
        arguments = arguments[2:]
    with contextlib.suppress(KeyboardInterrupt):
        main(int(arguments[0]) if arguments else 100, int(arguments[1]) if len(arguments) > 1 else 4)
