#!/usr/bin/env python3
"""Everything at once, for a long time, against one daemon on two workers.

    SCATTERD=build-release/server/scatterd tests/bench/soak.py MINUTES [FILE]

Small solves, large ones, uploads that are read back and used, jobs followed by event streams, jobs
that are cancelled, clients that vanish in a request or in a reply, slow ones, bad input, and now and
then a burst of more than the queues hold. Each kind is a thread (or a few) that checks its answers.
Memory and descriptors of the front and of the workers are looked at all along; afterwards all must
be back where it was.

Prints latencies by kind, refusals and how soon they came, memory and descriptors over time (as CSV
to FILE). Exit status 0 if every answer was right and nothing grew: after a tenth of the time to warm
up, the trend (Theil and Sen) over the rest may not add 5 % or 4 MiB of memory, nor 3 descriptors.
Times are told, not judged. SCATTERD_SEED=17 repeats the choices of a run.
"""

import collections
import contextlib
import http.client
import itertools
import json
import os
import pathlib
import random
import selectors
import signal
import socket
import statistics
import struct
import sys
import threading
import time

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "http"))
import daemon  # noqa: E402

SEED = int(os.environ.get("SCATTERD_SEED", time.time_ns() % 1000000))
QUEUE, JOB_QUEUE, STREAMS = 16, 20, 50
OPTIONS = ["--workers", "2", "--queue", str(QUEUE), "--job-queue", str(JOB_QUEUE),
           "--streams", str(STREAMS), "--seconds", "100", "--receive-seconds", "6",
           "--idle-seconds", "10", "--result-seconds", "100", "--data-seconds", "100",
           "--reuse-results", "0"]
SOLVE = "/processes/solve/execution"
JSON = {"Content-Type": "application/json"}
LATER = JSON | {"Prefer": "respond-async"}


def laplace(value, cells, dim=2, **inputs):
    """Laplace's equation whose solution is `value` everywhere."""
    return json.dumps({"inputs": {
        "cloud": {"lattice": {"lower": [0] * dim, "upper": [1] * dim, "cells": [cells] * dim}},
        "diffusivity": 1, "boundary": [{"on": "boundary", "type": "dirichlet", "value": value}],
        **inputs}, "outputs": {"solution": {}}})


def is_constant(results, value, count):
    u = results["solution"]
    return len(u) == count and max(map(abs, (x - value for x in u))) < 1e-8 * (1 + abs(value))


class Wrong(Exception):
    """An answer that should not have been given."""


def expect(condition, what):
    if not condition:
        raise Wrong(what)


class Kind(threading.Thread):
    """A client that does the same thing over and over."""

    pause = 0.05
    copies = 1

    def __init__(self, run, number):
        super().__init__(daemon=True)
        self.run_, self.server = run, run.server
        self.random = random.Random(f"{SEED} {type(self).__name__} {number}")
        self.connection = None

    @property
    def name_(self):
        return type(self).__name__.lower()

    def ask(self, method, path, body=None, headers=None, statuses=(200,), count=True):
        """One request on a kept connection; a refusal for lack of room is counted, and waited out
        as it says."""
        while not self.run_.stopping.is_set():
            if self.connection is None:
                self.connection = self.server.connect()
            began = time.monotonic()
            try:
                self.connection.request(method, path, body, headers or {})
                reply = daemon.Reply(self.connection.getresponse())
            except (http.client.RemoteDisconnected, ConnectionError):  # idle for too long
                self.connection = None
                continue
            if reply.headers.get("Connection") == "close":
                self.connection.close()
                self.connection = None
            took = time.monotonic() - began
            if reply.status in (429, 503) and reply.status not in statuses:
                expect("Retry-After" in reply.headers, f"{reply.status} without Retry-After")
                self.run_.refused(reply.status, took)
                self.run_.stopping.wait(self.random.uniform(0.2, 0.6))
                continue
            expect(reply.status in statuses, f"{method} {path}: {reply.status} {reply.body[:300]}")
            if count:
                self.run_.answered(self.name_, took)
            return reply
        raise InterruptedError

    def run(self):
        for turn in itertools.count():
            if self.run_.stopping.is_set():
                return
            try:
                self.step(turn)
            except InterruptedError:
                return
            except Exception as error:
                self.run_.failed(self.name_, error)
                self.connection = None
            self.run_.stopping.wait(self.random.uniform(0, 2 * self.pause))


class Small(Kind):
    pause, copies = 0.02, 2

    def step(self, turn):
        reply = self.ask("POST", SOLVE, laplace(turn, 10), JSON)
        expect(is_constant(reply.json, turn, 121), "another solution")


class Large(Kind):
    pause = 1

    def step(self, turn):
        reply = self.ask("POST", SOLVE, laplace(turn, 120), JSON)
        expect(is_constant(reply.json, turn, 121 * 121), "another solution")


class Volume(Kind):
    pause = 2

    def step(self, turn):
        reply = self.ask("POST", SOLVE, laplace(turn, 14, 3, solver={"method": "direct"}), JSON)
        expect(is_constant(reply.json, turn, 15 ** 3), "another solution")


class Upload(Kind):
    pause = 0.3

    def step(self, turn):
        count = self.random.choice([100, 20000])
        text = json.dumps([[self.random.random(), self.random.random()] for _ in range(count)])
        reply = self.ask("POST", "/data", text, JSON, (200, 201))
        path = "/data/" + reply.headers["Location"].rsplit("/", 1)[1]
        expect(self.ask("GET", path).body.decode() == text, "other bytes")
        body = {"inputs": {"cloud": {"points": {"href": path}}}, "outputs": {"neighbours": {}}}
        reply = self.ask("POST", "/processes/diagnose/execution", json.dumps(body), JSON,
                         (200, 422))  # random points may be too lonely
        expect(reply.status == 422 or len(reply.json["neighbours"]) == count, "another count")
        if turn % 2:
            self.ask("DELETE", path, statuses=(200, 204), count=False)


class Job(Kind):
    pause, copies = 0.1, 2

    def step(self, turn):
        cells = self.random.choice([8, 60])
        job = self.ask("POST", SOLVE, laplace(turn, cells), LATER, (201,)).json["jobID"]
        events = self.ask("GET", f"/jobs/{job}/events", statuses=(200, 204), count=False).body
        expect(events == b"" or b'"successful"' in events, events[-300:])
        reply = self.ask("GET", f"/jobs/{job}/results", count=False)
        expect(is_constant(reply.json, turn, (cells + 1) ** 2), "another solution")


class Cancel(Kind):
    pause = 0.5

    def step(self, turn):
        body = laplace(turn, 40, 3, solver={"method": "direct"})
        job = self.ask("POST", SOLVE, body, LATER, (201,), count=False).json["jobID"]
        self.run_.stopping.wait(self.random.uniform(0, 1))
        self.ask("DELETE", f"/jobs/{job}")
        expect(self.ask("GET", f"/jobs/{job}", count=False).json["status"] == "dismissed", "not so")
        self.ask("GET", f"/jobs/{job}/results", statuses=(410,), count=False)


class Batch(Kind):
    pause = 2

    def step(self, turn):
        body = json.loads(laplace("a", 8))
        body = {"inputs": {"request": {"process": "solve", **body},
                           "parameters": {"a": list(range(10))}}}
        job = self.ask("POST", "/processes/batch/execution", json.dumps(body), LATER, (201,))
        job = job.json["jobID"]
        info = self.ask("GET", f"/jobs/{job}", headers={"Prefer": "wait=15"}, count=False).json
        while info["status"] in ("accepted", "running"):
            info = self.ask("GET", f"/jobs/{job}", headers={"Prefer": "wait=15"}, count=False).json
        expect(info["status"] == "successful", info)
        self.ask("GET", f"/jobs/{job}/results", count=False)


class Watch(Kind):
    """Looks as monitoring and the dashboard do."""
    pause = 0.5

    def step(self, turn):
        for path in ("/healthz", "/jobs?limit=20", "/metrics", "/processes"):
            self.ask("GET", path)


class Bad(Kind):
    pause = 0.05

    def step(self, turn):
        path, body, headers, statuses = self.random.choice([
            (SOLVE, "{", JSON, (400,)), (SOLVE, "{}", JSON, (400,)),
            (SOLVE, "[" * 100, JSON, (413,)),
            (SOLVE, laplace(1, 5).replace("diffusivity", "viscosity"), JSON, (400,)),
            (SOLVE, laplace("1 +", 5), JSON, (400,)),
            (SOLVE, laplace(1, 5).replace("dirichlet", "neumann"), JSON, (400, 422)),
            (SOLVE, b"\x1f\x8bno gzip at all", JSON | {"Content-Encoding": "gzip"}, (400,)),
            (SOLVE, "x", {"Content-Type": "text/plain"}, (415,)),
            (SOLVE, b"\xa1\x66inputs\x9f\xff", {"Content-Type": "application/cbor"}, (400,)),
            ("/processes/none/execution", "{}", JSON, (404,)),
            ("/nowhere", "{}", JSON, (404,)), ("/healthz", "{}", JSON, (405,))])
        reply = self.ask("POST", path, body, headers, statuses)
        expect(reply.type == "application/problem+json" and reply.json["status"] == reply.status,
               "no problem")


def leave(plain):
    """Closes with a reset instead of a farewell."""
    plain.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
    plain.close()


class Vanish(Kind):
    """Goes away in the middle of a request, of its work, of its reply, of an event stream."""
    pause = 0.1

    def step(self, turn):
        body = laplace(turn, self.random.choice([10, 100])).encode()
        request = (f"POST {SOLVE} HTTP/1.1\r\nHost: a\r\nContent-Type: application/json\r\n"
                   f"Content-Length: {len(body)}\r\n\r\n").encode() + body
        plain = self.server.raw()
        how = self.random.randrange(4)
        with contextlib.suppress(OSError):
            if how == 0:
                plain.sendall(request[:self.random.randrange(len(request))])
            elif how == 1:
                plain.sendall(request)
                self.run_.stopping.wait(self.random.uniform(0, 0.1))
            elif how == 2:
                plain.sendall(request)
                plain.recv(100)
            else:
                self.leave_events(plain)
        (leave if turn % 2 else socket.socket.close)(plain)
        self.run_.answered(self.name_, 0)

    def leave_events(self, plain):
        job = self.ask("POST", SOLVE, laplace(1, 60), LATER, (201,), count=False).json["jobID"]
        plain.sendall(f"GET /jobs/{job}/events HTTP/1.1\r\nHost: a\r\n\r\n".encode())
        plain.recv(50)


class Slow(Kind):
    """Sends too slowly, or reads slowly."""
    pause = 0.5

    def step(self, turn):
        if turn % 2:
            self.read_slowly(turn)
        else:
            self.send_slowly()

    def send_slowly(self):
        with self.server.raw() as plain, contextlib.suppress(BrokenPipeError, ConnectionError):
            plain.sendall(f"POST {SOLVE} HTTP/1.1\r\nHost: a\r\nContent-Type: application/json\r\n"
                          "Content-Length: 100000\r\n\r\n{".encode())
            began = time.monotonic()
            reply = daemon.read_all(plain)
            expect(reply == b"" or reply.startswith(b"HTTP/1.1 408 "), reply[:100])
            self.run_.answered(self.name_, time.monotonic() - began)

    def read_slowly(self, turn):
        body = laplace(turn, 200)
        with self.server.raw() as plain:
            plain.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
            plain.sendall((f"POST {SOLVE} HTTP/1.1\r\nHost: a\r\nContent-Type: application/json\r\n"
                           f"Content-Length: {len(body)}\r\nConnection: close\r\n\r\n{body}")
                          .encode())
            data = plain.recv(1000)
            while data and not self.run_.stopping.is_set():
                time.sleep(0.05)
                part = plain.recv(20000)
                if not part:
                    break
                data += part
            if not self.run_.stopping.is_set():
                expect(data[9:12] in (b"200", b"503"), data[:100])
                self.run_.answered("slow reader", 0)


class Bare:
    """A server that answers whatever it is asked at once, in a process of its own: what of the time
    of a refusal is that of the machine."""

    def __init__(self):
        listener = socket.create_server(("127.0.0.1", 0), backlog=1024)
        listener.settimeout(1)
        self.port = listener.getsockname()[1]
        self.parent = os.getpid()
        self.pid = os.fork()
        if self.pid == 0:
            self.serve(listener)
            os._exit(0)
        listener.close()

    def serve(self, listener):
        while os.getppid() == self.parent:
            with contextlib.suppress(OSError):  # nobody came, or has gone
                plain = listener.accept()[0]
                with plain:
                    plain.recv(65536)
                    plain.sendall(b"HTTP/1.1 503 Bare\r\n\r\n")

    def raw(self):
        return socket.create_connection(("127.0.0.1", self.port), 60)

    def stop(self):
        os.kill(self.pid, signal.SIGKILL)
        os.waitpid(self.pid, 0)


class Burst(Kind):
    """More at once than the queue holds: each gets its answer, or a refusal at once."""
    pause = 8

    def step(self, turn):
        later = turn % 2 == 1
        count = 10 * JOB_QUEUE if later else 4 * QUEUE
        replies = self.all_at_once(self.server, count, laplace(turn, 50), later)
        for _, seconds in self.all_at_once(self.run_.bare, count, laplace(turn, 50), later):
            self.run_.answered("(bare server)", seconds)
        statuses = collections.Counter(status for status, _ in replies)
        allowed = {201, 429, 503} if later else {200, 503}
        expect(set(statuses) <= allowed, f"burst: {dict(statuses)}")
        for status, seconds in replies:
            if status in (429, 503):
                self.run_.refused(status, seconds)
            else:
                self.run_.answered("burst jobs" if later else "burst", seconds)

    def all_at_once(self, server, count, body, later):
        """Status and seconds until the first byte of each reply."""
        prefer = "Prefer: respond-async\r\n" if later else ""
        request = (f"POST {SOLVE} HTTP/1.1\r\nHost: a\r\nContent-Type: application/json\r\n{prefer}"
                   f"Content-Length: {len(body)}\r\nConnection: close\r\n\r\n{body}").encode()
        replies = []
        with selectors.DefaultSelector() as selector, contextlib.ExitStack() as stack:
            for _ in range(count):
                plain = stack.enter_context(server.raw())
                began = time.monotonic()
                plain.sendall(request)
                selector.register(plain, selectors.EVENT_READ, began)
                replies += self.take(selector, 0)
            end = time.monotonic() + 60
            while selector.get_map() and time.monotonic() < end:
                replies += self.take(selector, 1)
            expect(not selector.get_map(), "requests without an answer")
        return replies

    @staticmethod
    def take(selector, patience):
        found = []
        for key, _ in selector.select(patience):
            head = key.fileobj.recv(12)
            found.append((int(head[9:12] or 0), time.monotonic() - key.data))
            selector.unregister(key.fileobj)
        return found


KINDS = (Small, Large, Volume, Upload, Job, Cancel, Batch, Watch, Bad, Vanish, Slow, Burst)


def memory(pid):
    """Proportional share of memory of a process (MiB)."""
    with contextlib.suppress(OSError):
        for line in pathlib.Path(f"/proc/{pid}/smaps_rollup").read_text().splitlines():
            if line.startswith("Pss:"):
                return int(line.split()[1]) / 1024
    return 0


class Run:
    """One daemon, its clients, and what came of them."""

    def __init__(self, minutes):
        self.bare = Bare()  # before there are threads
        self.server = daemon.Daemon(*OPTIONS, stub=False)
        self.server.wait_ready()
        self.seconds = 60 * minutes
        self.stopping = threading.Event()
        self.lock = threading.Lock()
        self.times = collections.defaultdict(list)
        self.refusals = collections.defaultdict(list)
        self.errors = collections.Counter()
        self.samples, self.log = [], []

    def answered(self, kind, seconds):
        with self.lock:
            self.times[kind].append(seconds)

    def refused(self, status, seconds):
        with self.lock:
            self.refusals[status].append(seconds)

    def failed(self, kind, error):
        with self.lock:
            self.errors[f"{kind}: {type(error).__name__}: {error}"[:400]] += 1

    def read_log(self):
        """Keeps what is an error, forgets the rest."""
        lines = self.server.log[:]
        del self.server.log[:len(lines)]
        self.log += [line for line in lines if "level=error" in line or "anitizer" in line]

    def sample(self, began):
        self.read_log()
        workers = daemon.children(self.server.pid)
        self.samples.append({
            "s": time.monotonic() - began, "front": memory(self.server.pid),
            "workers": sum(map(memory, workers)),
            "descriptors": len(daemon.descriptors(self.server.pid)),
            "store": sum(path.stat().st_size for path in
                         pathlib.Path(self.server.data).glob("jobs.db*")) / 2 ** 20})

    def drive(self):
        began = time.monotonic()
        clients = [kind(self, k) for kind in KINDS for k in range(kind.copies)]
        for client in clients:
            client.start()
        while time.monotonic() - began < self.seconds and self.server.process.poll() is None:
            self.sample(began)
            time.sleep(min(2, self.seconds / 50))
        self.stopping.set()
        for client in clients:
            client.join(90)
            if client.is_alive():
                self.failed(client.name_, Wrong("does not come to an end"))
            if client.connection is not None:
                client.connection.close()

    def settle(self, base):
        """Afterwards: no connection, no request, no job, the descriptors of the beginning."""
        def is_over():
            counts = self.server.request("GET", "/jobs?status=accepted,running").json["jobs"]
            return not counts and len(daemon.descriptors(self.server.pid)) <= base
        try:
            daemon.wait_until(is_over, "quiet, and the descriptors of the beginning", 120)
        except AssertionError as error:
            self.failed("end", error)


def trend(samples, what):
    """Growth over all samples by the median of slopes (Theil and Sen), and the median."""
    points = [(s["s"], s[what]) for s in samples]
    points = points[:: max(1, len(points) // 400)]
    slopes = [(b[1] - a[1]) / (b[0] - a[0]) for a, b in itertools.combinations(points, 2)]
    span = points[-1][0] - points[0][0]
    return statistics.median(slopes) * span, statistics.median(p[1] for p in points)


def judge(run):
    """Prints what grew; the number of things that should not have."""
    faults = 0
    kept = run.samples[len(run.samples) // 10:]
    for what, unit, least in (("front", "MiB", 4), ("workers", "MiB", 16), ("descriptors", "", 3)):
        grown, middle = trend(kept, what)
        values = [s[what] for s in kept]
        bad = grown > max(least, 0.05 * middle)
        faults += bad
        print(f"| {what} | {middle:.1f} {unit} | {min(values):.1f} to {max(values):.1f} | "
              f"{grown:+.2f} {unit} |{' GROWS' if bad else ''}")
    return faults


def percentiles(times):
    times = sorted(times)
    return [1e3 * times[min(len(times) - 1, int(p * len(times)))] for p in (0.5, 0.95, 0.99, 1)]


def tell(run):
    print("| kind | answers | 50 % | 95 % | 99 % | most (ms) |\n|---|---|---|---|---|---|")
    for kind, times in sorted(run.times.items()):
        soon = f" {100 * sum(t <= 0.1 for t in times) / len(times):.2f} % within 100 ms"
        print(f"| {kind} | {len(times)} | " + " | ".join(f"{t:.1f}" for t in percentiles(times)) + " |"
              + (soon if kind == "(bare server)" else ""))
    for status, times in sorted(run.refusals.items()):
        soon = sum(t <= 0.1 for t in times) / len(times)
        print(f"| refused {status} | {len(times)} | "
              + " | ".join(f"{t:.1f}" for t in percentiles(times)) + f" | {100 * soon:.2f} % within 100 ms")
    for error, count in run.errors.most_common(20):
        print(f"WRONG, {count} times: {error}")


def write_csv(path, samples):
    with open(path, "w") as file:
        file.write(",".join(samples[0]) + "\n")
        for sample in samples:
            file.write(",".join(f"{value:.6g}" for value in sample.values()) + "\n")


def main(minutes, path=None):
    print(f"SCATTERD_SEED={SEED}, {minutes:g} minutes, {os.cpu_count()} processors, load "
          f"{os.getloadavg()[0]:.1f}", flush=True)
    run = Run(minutes)
    base = len(daemon.descriptors(run.server.pid)) + 2  # what is opened once: libcurl, a directory
    run.drive()
    print(f"load at the end {os.getloadavg()[0]:.1f}")
    ended = run.server.process.poll()
    if ended is not None:
        run.failed("daemon", Wrong(f"it ended with {ended}: " + "\n".join(run.log[-10:])))
    else:
        run.settle(base)
    tell(run)
    print("| | median | range | trend |\n|---|---|---|---|")
    grows = judge(run) if minutes >= 5 else 0
    if path:
        write_csv(path, run.samples)
    status = run.server.stop()
    run.bare.stop()
    run.read_log()
    print(f"{sum(map(len, run.times.values()))} answers, {sum(run.errors.values())} wrong, "
          f"{sum(map(len, run.refusals.values()))} refused, {len(run.log)} errors in the log, "
          f"exit status {status}")
    for line in run.log[:10]:
        print(line)
    return 0 if not run.errors and not grows and status == 0 and run.times else 1


if __name__ == "__main__":
    sys.exit(main(float(sys.argv[1]) if len(sys.argv) > 1 else 30,
                  sys.argv[2] if len(sys.argv) > 2 else None))
