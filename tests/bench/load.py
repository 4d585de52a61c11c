#!/usr/bin/env python3
"""How many small requests a second: wrk (Debian package wrk) against a daemon of its own.

    SCATTERD=build-release/server/scatterd tests/bench/load.py [SECONDS]

Rows: GET /healthz, which the front answers alone, and a solve on 11 x 11 points, which goes through a
worker, each over 1, 8 and 64 connections: requests per second, latencies, and how many answers were
none of the 2xx (503: more waited than the queue holds).
"""

import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "http"))
import daemon  # noqa: E402

SOLVE = {"inputs": {
    "cloud": {"lattice": {"lower": [0, 0], "upper": [1, 1], "cells": [10, 10]}},
    "diffusivity": 1, "source": 1,
    "boundary": [{"on": "boundary", "type": "dirichlet", "value": 0}]},
    "outputs": {"solution": {}}}
POST = 'wrk.method = "POST"\nwrk.body = [[%s]]\nwrk.headers["Content-Type"] = "application/json"\n'


def found(pattern, text):
    match = re.search(pattern, text)
    return match.group(1) if match else "0"


def measure(server, path, connections, seconds, script=None):
    command = ["wrk", "-t", "1", "-c", str(connections), "-d", f"{seconds}s", "--latency"]
    command += ["-s", script] if script else []
    text = subprocess.run([*command, f"http://127.0.0.1:{server.port}{path}"], check=True,
                          capture_output=True, text=True).stdout
    cells = [path, connections, found(r"Requests/sec: +(\S+)", text), found(r"50% +(\S+)", text),
             found(r"99% +(\S+)", text), found(r"Non-2xx or 3xx responses: (\d+)", text)]
    print("| " + " | ".join(map(str, cells)) + " |", flush=True)


def main(seconds):
    server = daemon.Daemon("--workers", "2", "--log-level", "info", stub=False)
    server.wait_ready()
    with tempfile.NamedTemporaryFile("w", suffix=".lua") as script:
        script.write(POST % json.dumps(SOLVE))
        script.flush()
        print(f"load {os.getloadavg()[0]:.1f}\n| path | connections | requests/s | 50 % | 99 % | "
              "not 2xx |\n|---|---|---|---|---|---|")
        for connections in (1, 8, 64):
            measure(server, "/healthz", connections, seconds)
        for connections in (1, 8, 64):
            measure(server, daemon.EXECUTE, connections, seconds, script.name)
    assert server.stop() == 0


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 10)
