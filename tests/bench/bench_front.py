#!/usr/bin/env python3
"""What front and worker process add to a request: one connection, kept alive, one request at a time.

    SCATTERD=... SCATTERD_STUB=... bench_front.py [SECONDS]

Rows: a fixed reply of the front; an echo through a worker that does nothing (front, both sockets,
both memory files); the same through the real worker; a solve of about 100 and 400 points, with the
time that answer() itself says it took.
"""

import json
import pathlib
import statistics
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "http"))
import daemon  # noqa: E402


def solve(cells):
    return json.dumps({"inputs": {
        "cloud": {"lattice": {"lower": [0, 0], "upper": [1, 1], "cells": [cells, cells]}},
        "diffusivity": 1, "source": 1,
        "boundary": [{"on": "boundary", "type": "dirichlet", "value": 0}]}})


def request(method, path, body=""):
    return (f"{method} {path} HTTP/1.1\r\nHost: a\r\nContent-Type: application/json\r\n"
            f"Content-Length: {len(body)}\r\n\r\n{body}").encode()


def ask(plain, data):
    """Sends a request and returns the body of its reply."""
    plain.sendall(data)
    reply = plain.recv(1 << 20)
    head, _, body = reply.partition(b"\r\n\r\n")
    assert head.startswith(b"HTTP/1.1 200 "), reply
    size = int(head.lower().partition(b"content-length:")[2].split(b"\r\n")[0])
    while len(body) < size:
        body += plain.recv(1 << 20)
    return body


def measure(name, running, data, seconds):
    times, inside = [], []
    with running.raw() as plain:
        ask(plain, data)
        end = time.perf_counter() + seconds
        while time.perf_counter() < end:
            began = time.perf_counter()
            body = ask(plain, data)
            times.append(time.perf_counter() - began)
            if b'"report"' in body:
                inside.append(json.loads(body)["report"]["value"]["seconds"]["total"])
    times.sort()
    print(f"{name:28} {1e3 * statistics.median(times):8.3f} ms median "
          f"{1e3 * times[len(times) * 99 // 100]:8.3f} ms 99 % {len(times) / sum(times):8.0f}/s"
          + (f" {1e3 * statistics.median(inside):8.3f} ms in answer()" if inside else ""))


def main():
    seconds = float(sys.argv[1]) if len(sys.argv) > 1 else 3
    options = ["--recycle", "1000000000"]
    echo = request("POST", "/processes/echo/execution", '{"inputs":{"message":"hello"}}')
    stub, real = daemon.Daemon(*options, stub=True), daemon.Daemon(*options, stub=False)
    try:
        stub.wait_ready(), real.wait_ready()
        measure("fixed reply", stub, request("GET", "/healthz"), seconds)
        measure("echo, worker of the tests", stub, echo, seconds)
        measure("echo", real, echo, seconds)
        for cells in (9, 19):
            data = request("POST", daemon.EXECUTE, solve(cells))
            measure(f"solve, {(cells + 1) ** 2} points", real, data, seconds)
    finally:
        stub.stop(), real.stop()


if __name__ == "__main__":
    main()
