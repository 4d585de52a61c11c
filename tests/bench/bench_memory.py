"""Peak memory of runs beside the estimate that admits them: bench_memory.py PATH/TO/scatterd [--quick]

Each run is a process of its own (`scatterd run`), its peak the largest resident size the kernel saw.
Prints a Markdown table. The estimate is server/answer/estimate.c's, from the report of the run.
"""

import json
import subprocess
import sys
import tempfile

CELLS = {1: (10000, 100000, 1000000), 2: (100, 300, 700), 3: (15, 30, 45)}
OPERATORS = ({"scheme": "lsmps", "degree": 2}, {"scheme": "lsmps", "degree": 3}, {"scheme": "mps"}, {"scheme": "ips"})


def lattice(dim, cells):
    return {"lattice": {"lower": [0] * dim, "upper": [1] * dim, "cells": [cells] * dim, "jitter": 0.2, "seed": 1}}


def requests(quick):
    """(name, process, request) of each run."""
    for dim, sizes in CELLS.items():
        for cells in sizes[:1] if quick else sizes:
            cloud = lattice(dim, cells)
            where = f"{dim}-D {cells}"
            boundary = [{"on": "boundary", "type": "dirichlet", "value": "x"}]
            for operator in OPERATORS:
                name = operator["scheme"] + str(operator.get("degree", ""))
                solve = {"cloud": cloud, "operator": operator, "diffusivity": 1, "boundary": boundary}
                yield f"solve {where} {name}", "solve", {"inputs": solve}
            solve = {"cloud": cloud, "diffusivity": 1, "boundary": boundary}
            velocity = dict(solve, velocity=[1] * dim, reaction=1, source="x")
            yield f"solve {where} velocity", "solve", {"inputs": velocity}
            time = {"method": "crank-nicolson", "end": 4e-6, "step": 1e-6}
            yield f"solve {where} in time", "solve", {"inputs": dict(solve, initial="x", time=time)}
            time = {"method": "forward-euler", "end": 4e-14, "step": 1e-14, "save": [1e-14, 2e-14, 3e-14, 4e-14]}
            yield f"solve {where} explicit", "solve", {"inputs": dict(solve, initial="x", time=time)}
            yield f"apply {where}", "apply", {"inputs": {"cloud": cloud, "field": "x*x"}}
            yield f"diagnose {where}", "diagnose", {"inputs": {"cloud": cloud}}


# A child inherits the peak of the process that forks it, so a small one does.
WAIT = """
import os, sys
child = os.fork()
if not child:
    os.execv(sys.argv[1], sys.argv[1:])
_, status, usage = os.wait4(child, 0)
print(usage.ru_maxrss * 1024)
sys.exit(os.waitstatus_to_exitcode(status))
"""


def run(program, process, request):
    """Reply (or the text of the problem), peak in bytes."""
    with tempfile.NamedTemporaryFile("w", suffix=".json") as body, tempfile.NamedTemporaryFile(suffix=".json") as out:
        json.dump(request, body)
        body.flush()
        done = subprocess.run([sys.executable, "-S", "-c", WAIT, program, "run", "--process", process,
                               "-o", out.name, body.name], capture_output=True, text=True, check=False)
        return (json.load(out) if done.returncode == 0 else done.stderr), int(done.stdout)


if __name__ == "__main__":
    print("| run | points | peak (MB) | estimate (MB) | estimate / peak | factor (MB) |\n|---|---|---|---|---|---|")
    for name, process, request in requests("--quick" in sys.argv):
        reply, peak = run(sys.argv[1], process, request)
        if isinstance(reply, str):
            print(f"| {name} | failed: {reply[:200]}")
            continue
        report = reply["report"]["value"]
        points = len(next(v for v in reply.values() if isinstance(v, list)))
        estimate = report.get("memory_estimate_bytes", 0)
        solver = reply.get("diagnostics", {}).get("value", {}).get("solver", {})
        print(f"| {name} | {points} | {peak / 1e6:.1f} | {estimate / 1e6:.1f} | {estimate / peak:.2f} "
              f"| {solver.get('peak_bytes', 0) / 1e6:.1f} |", flush=True)
