#!/usr/bin/env python3
"""A small solve over HTTP: one connection, kept alive, one request at a time.

    SCATTERD=... bench_http.py BENCH_ANSWER [SECONDS]

The request is that of bench_answer: jittered points posted with a group, three expressions, all
default outputs; 100 and 400 points; as JSON and as CBOR with typed arrays, whole documents both
ways. Milliseconds: median and 95 % of the round trip as a client sees it; of the worker's own
report, total; of the bare library on the same problem (bench_answer), and what is above it.
"""

import json
import re
import statistics
import subprocess
import sys
import pathlib
import time

HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE.parent / "http"), str(HERE.parents[1] / "clients/python")]
import daemon  # noqa: E402  (found by the line above)
from bench_search import jittered_lattice  # noqa: E402
from scatterd import wire  # noqa: E402


def problem(side):
    """The request of bench_answer for side x side points."""
    x, _ = jittered_lattice(2, side * side)
    wall = [k for k, p in enumerate(x) if not ((p > 0) & (p < 1)).all()]
    return {"inputs": {
        "cloud": {"points": x, "groups": {"wall": wall}}, "velocity": [1, "x"],
        "diffusivity": 0.1, "source": "2*x+x-0.2", "exact": "x^2+y",
        "boundary": [{"on": "wall", "type": "dirichlet", "value": "x^2+y"}]}}


def request(body, media):
    head = (f"POST {daemon.EXECUTE} HTTP/1.1\r\nHost: a\r\nContent-Type: {media}\r\n"
            f"Accept: {media}\r\nContent-Length: {len(body)}\r\n\r\n")
    return head.encode() + body


def ask(plain, data):
    """Sends a request and returns the body of its reply."""
    plain.sendall(data)
    reply = plain.recv(1 << 20)
    head, _, body = reply.partition(b"\r\n\r\n")
    assert head.startswith(b"HTTP/1.1 200 "), reply
    size = int(re.search(rb"(?i)content-length: (\d+)", head).group(1))
    while len(body) < size:
        body += plain.recv(1 << 20)
    return body


def bare_library(bench_answer):
    """Points to milliseconds of the bare library."""
    said = subprocess.run([bench_answer], check=True, capture_output=True, text=True).stdout
    return {int(n): float(us) / 1e3
            for n, us in re.findall(r"(\d+) points.*?bare library\s+([\d.]+)", said)}


def measure(running, data, decode, seconds):
    """Round trips and the worker's own totals, milliseconds, sorted."""
    times, totals = [], []
    with running.raw() as plain:
        for _ in range(20):
            ask(plain, data)
        end = time.perf_counter() + seconds
        while time.perf_counter() < end:
            began = time.perf_counter()
            body = ask(plain, data)
            times.append(1e3 * (time.perf_counter() - began))
            totals.append(1e3 * decode(body)["report"]["value"]["seconds"]["total"])
    return sorted(times), sorted(totals)


def main():
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    seconds = float(sys.argv[2]) if len(sys.argv) > 2 else 5
    bare = bare_library(sys.argv[1])
    running = daemon.Daemon("--recycle", "1000000000", stub=False)
    print("points format  request bytes |  median    95 %  solves/s |  worker    bare   above bare")
    try:
        running.wait_ready()
        for side in (10, 20):
            for form, encode, decode in (("json", wire.to_json, json.loads),
                                         ("cbor", wire.to_cbor, wire.from_cbor)):
                body = encode(problem(side))
                times, totals = measure(running, request(body, f"application/{form}"), decode,
                                        seconds)
                n, median = side * side, statistics.median(times)
                print(f"{n:6d} {form:6} {len(body):14d} | {median:7.3f} "
                      f"{times[len(times) * 95 // 100]:7.3f} {1e3 / statistics.mean(times):9.0f} | "
                      f"{statistics.median(totals):7.3f} {bare[n]:7.3f} {median - bare[n]:12.3f}",
                      flush=True)
    finally:
        running.stop()


if __name__ == "__main__":
    main()
