#!/usr/bin/env python3
"""What jobs cost, with the real worker.

    SCATTERD=... SCATTERD_STUB=... bench_jobs.py [--store postgres] [COUNT [KILLS]]

With --store postgres the jobs are in a PostgreSQL server that is started for it, in a temporary
directory, with fsync on; the first row is then measured with two daemons on one store as well.

Rows: COUNT (10 000) small solves submitted over four connections while none may finish before the
last is in (a batch lane blocked by a long job), then run, with the front's memory at both ends; the
same number kept over KILLS (20) kill -9 at random moments; the time to cancel a 3-D factorisation,
until its worker has gone; a small synchronous solve on an idle daemon and on one whose job queue is
full and answers 429.
"""

import http.client
import json
import os
import pathlib
import random
import signal
import statistics
import sys
import threading
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "http"))
import daemon  # noqa: E402
import postgres  # noqa: E402

EXECUTE = "/processes/solve/execution"
HEADERS = {"Content-Type": "application/json", "Prefer": "respond-async"}


def solve(cells, value=0, source=1):
    return json.dumps({"inputs": {
        "cloud": {"lattice": {"lower": [0] * len(cells), "upper": [1] * len(cells),
                              "cells": cells}},
        "diffusivity": 1, "source": source,
        "boundary": [{"on": "boundary", "type": "dirichlet", "value": value}]},
        "outputs": {"solution": {}}})


def long_solve():
    """A 3-D factorisation of many seconds."""
    request = json.loads(solve([44, 44, 44]))
    request["inputs"]["solver"] = {"method": "direct"}
    return json.dumps(request)


def resident(pid):
    for line in pathlib.Path(f"/proc/{pid}/status").read_text().splitlines():
        if line.startswith("VmRSS"):
            return int(line.split()[1]) / 1024
    return 0


def processor_time(pid):
    """Seconds that a process has taken so far."""
    fields = pathlib.Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def jobs(server, state):
    """Number of jobs in a state."""
    reply = server.request("GET", f"/jobs?limit=10000&status={state}").json
    return len(reply["jobs"])


def submit_all(server, bodies, accepted):
    """Submits bodies over four connections; what was accepted goes into a dictionary."""
    def work(mine):
        connection = server.connect()
        for k, body in mine:
            while k not in accepted:
                try:
                    connection.request("POST", EXECUTE, body, HEADERS)
                    reply = connection.getresponse()
                    text = reply.read()
                except (OSError, http.client.HTTPException):
                    connection.close()
                    if stop.is_set():
                        return
                    time.sleep(0.02)
                    connection = server.connect()
                    continue
                if reply.status == 201:
                    accepted[k] = json.loads(text)["jobID"]
                elif reply.status in (429, 503):
                    time.sleep(0.05)
                else:
                    raise AssertionError(text)
        connection.close()

    stop = threading.Event()
    items = list(enumerate(bodies))
    threads = [threading.Thread(target=work, args=(items[k::4],)) for k in range(4)]
    for thread in threads:
        thread.start()
    return threads, stop


def wait_running(server, job):
    daemon.wait_until(lambda: server.request("GET", f"/jobs/{job}").json["status"] == "running",
                      "a long job to run", 60)


def rates(count):
    server = daemon.Daemon("--workers", "2", "--job-queue", str(count + 10), "--log-level", "error",
                           "--log-level", "info", stub=False)
    server.wait_ready()
    empty = resident(server.pid)
    first = server.request("POST", EXECUTE, long_solve(), HEADERS).json["jobID"]
    wait_running(server, first)
    accepted = {}
    taken = processor_time(server.pid)
    began = time.perf_counter()
    threads, _ = submit_all(server, [solve([8, 8], k) for k in range(count)], accepted)
    for thread in threads:
        thread.join()
    seconds = time.perf_counter() - began
    full = resident(server.pid)
    server.request("DELETE", f"/jobs/{first}")
    began = time.perf_counter()
    while jobs(server, "accepted,running") > 0:
        time.sleep(0.5)
    ran = time.perf_counter() - began
    taken = processor_time(server.pid) - taken
    print(f"{count} jobs: {len(accepted) / seconds:.0f}/s submitted (4 connections), "
          f"{len(accepted) / ran:.0f}/s completed (1 worker of 2 runs jobs)")
    print(f"processor time of the front: {1e3 * taken / count:.2f} ms per job")
    print(f"memory of the front: {empty:.1f} MiB empty, {full:.1f} MiB with {count} jobs waiting, "
          f"{resident(server.pid):.1f} MiB when they are done")
    assert jobs(server, "successful") == min(count, 10000)
    server.stop()


def kills(count, times):
    seed = int(os.environ.get("SCATTERD_SEED", time.time_ns() % 1000000))
    generator = random.Random(seed)
    options = ["--workers", "2", "--job-queue", str(count + 10), "--job-attempts", "1000"]
    server = daemon.Daemon(*options, stub=False)
    accepted = {}

    class Moving:  # the daemon of the moment
        def connect(self):
            return server.connect()

    threads, _ = submit_all(Moving(), [solve([8, 8], k, 2) for k in range(count)], accepted)
    starts = []
    for _ in range(times):
        time.sleep(generator.uniform(0.1, 3))
        server.stop(signal.SIGKILL, keep=True)
        began = time.perf_counter()
        server = daemon.Daemon(*options, stub=False, directory=server.directory)
        starts.append(time.perf_counter() - began)
    for thread in threads:
        thread.join()
    while jobs(server, "accepted,running") > 0:
        time.sleep(0.5)
    lost = 0
    for job in accepted.values():
        lost += server.request("GET", f"/jobs/{job}").json.get("status") != "successful"
    print(f"{times} kills -9 (SCATTERD_SEED={seed}): {len(accepted)} accepted, {lost} lost, start "
          f"takes {max(starts):.2f} s at most")
    server.stop()


def cancel():
    server = daemon.Daemon("--workers", "2", stub=False)
    server.wait_ready()
    times = []
    for _ in range(5):
        job = server.request("POST", EXECUTE, long_solve(), HEADERS).json["jobID"]
        daemon.wait_until(lambda: server.request("GET", f"/jobs/{job}").json.get("phase")
                          in ("factor", "solve"), "the factorisation", 60)
        time.sleep(0.5)
        info = server.request("GET", f"/jobs/{job}").json
        assert info["status"] == "running", info
        workers = set(daemon.children(server.pid))
        began = time.perf_counter()
        server.request("DELETE", f"/jobs/{job}")
        while workers <= set(daemon.children(server.pid)):
            time.sleep(0.001)
        times.append(time.perf_counter() - began)
    print(f"cancel in phase {info['phase']} of 44^3 points: {1e3 * max(times):.0f} ms at most "
          f"until the worker has gone, of {len(times)}")
    server.stop()


def latency(server, seconds):
    connection = server.connect()
    times = []
    end = time.perf_counter() + seconds
    while time.perf_counter() < end:
        began = time.perf_counter()
        connection.request("POST", EXECUTE, solve([10, 10]), {"Content-Type": "application/json"})
        reply = connection.getresponse()
        reply.read()
        assert reply.status == 200
        times.append(1e3 * (time.perf_counter() - began))
    connection.close()
    times.sort()
    return statistics.median(times), times[len(times) * 95 // 100]


def full_queue():
    server = daemon.Daemon("--workers", "2", "--job-queue", "100", stub=False)
    server.wait_ready()
    idle = latency(server, 5)
    accepted = {}
    threads, stop = submit_all(server, [long_solve()] + [solve([60, 60], k) for k in range(100000)],
                               accepted)
    refused = lambda: server.request("POST", EXECUTE, solve([5, 5], -1), HEADERS).status == 429
    daemon.wait_until(refused, "a full queue", 60)
    busy = latency(server, 5)
    print(f"small synchronous solve: median {idle[0]:.2f} ms, 95 % {idle[1]:.2f} ms when idle; "
          f"median {busy[0]:.2f} ms, 95 % {busy[1]:.2f} ms with a full job queue")
    stop.set()
    server.stop(signal.SIGKILL)
    for thread in threads:
        thread.join()


def statements():
    """What a statement takes, and a transaction that writes."""
    server = daemon.Daemon("--workers", "2", stub=False)
    server.wait_ready()
    job = server.request("POST", EXECUTE, solve([5, 5]), HEADERS).json["jobID"]
    connection = server.connect()
    times = {path: [] for path in ("/healthz", f"/jobs/{job}")}
    for _ in range(1000):
        for path, seconds in times.items():
            began = time.perf_counter()
            connection.request("GET", path)
            connection.getresponse().read()
            seconds.append(time.perf_counter() - began)
    plain, asked = (1e3 * statistics.median(seconds) for seconds in times.values())
    print(f"GET: {plain:.3f} ms of /healthz, {asked:.3f} ms of a job's status")
    server.stop()


def pair(count):
    """As rates(), by two daemons on one store."""
    url = daemon.database("pair")
    options = ["--workers", "2", "--job-queue", str(count + 10), "--lease-seconds", "10"]
    both = [daemon.Daemon(*options, stub=False, store=url) for _ in range(2)]
    for server in both:
        server.wait_ready()
    accepted = {}
    began = time.perf_counter()
    threads, _ = submit_all(both[0], [solve([8, 8], k) for k in range(count)], accepted)
    for thread in threads:
        thread.join()
    while jobs(both[1], "accepted,running") > 0:
        time.sleep(0.2)
    print(f"two daemons: {count} jobs submitted to one, {count / (time.perf_counter() - began):.0f}/s "
          f"submitted and completed by both")
    for server in both:
        server.stop()


if __name__ == "__main__":
    arguments = sys.argv[1:]
    if arguments[:2] == ["--store", "postgres"]:
        os.environ["SCATTERD_TEST_STORE"] = "postgres"
        daemon._server = postgres.Server()
        arguments = arguments[2:]
    COUNT = int(arguments[0]) if arguments else 10000
    statements()
    rates(COUNT)
    if daemon.shares_store():
        pair(COUNT)
    kills(COUNT, int(arguments[1]) if len(arguments) > 1 else 20)
    cancel()
    full_queue()
