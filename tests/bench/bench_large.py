#!/usr/bin/env python3
"""Large solves: every solver of the library from 1e4 to 1e6 points, SciPy's ways in the same run.

    bench_large.py BENCH_STENCIL [--cases 2:1e4 2:1e5 2:1e6 3:1e4 3:1e5 3:1e6] [--plot FILE.png]

Poisson's equation on jittered lattices, as in bench_pipeline.py, whose discretisation SciPy gets. A
line is a solver at a size: seconds of the processor of the whole pipeline and of its solve (analysis,
factors or preconditioner, iterations to a relative residual of 1e-10), iterations, memory of the
process at its peak beyond what it had before the solve, error of the solution. SciPy: splu with
MMD_AT_PLUS_A in symmetric mode; bicgstab with spilu. A solver is left out where it would take longer
than anyone waits (LIMITS).
"""

import argparse
import json
import multiprocessing
import os
import pathlib
import re
import subprocess
import time

os.environ.update(OPENBLAS_NUM_THREADS="1", OMP_NUM_THREADS="1")

import numpy as np  # noqa: E402  (threads are counted when it is loaded)
from scipy.sparse.linalg import LinearOperator, bicgstab, spilu  # noqa: E402
from scipy.spatial import cKDTree  # noqa: E402

from bench_pipeline import assemble, by_splu, weights_of  # noqa: E402
from bench_search import jittered_lattice, scipy_lists  # noqa: E402

CASES = ["2:1e4", "2:3e4", "2:1e5", "2:3e5", "2:1e6", "3:1e4", "3:3e4", "3:1e5", "3:3e5", "3:1e6"]
OURS = {"direct": ["direct"], "ilu": ["iterative", "ilu"], "amg": ["iterative", "amg"],
        "auto": ["auto"]}
LIMITS = {("direct", 2): 4e5, ("direct", 3): 4e4, ("ilu", 2): 4e5,
          ("SciPy splu", 2): 2e5, ("SciPy splu", 3): 1.5e4,
          ("SciPy bicgstab", 2): 2e5, ("SciPy bicgstab", 3): 4e4}
PARTS = ("order", "search", "lists", "assemble", "factor", "solve")


def ours(program, dim, points, arguments):
    line = [program, str(dim), str(points), "1", "1", "1", "lsmps", "2", *arguments]
    said = json.loads(subprocess.run(line, check=True, capture_output=True, text=True).stdout)
    return {"points": said["points"], "total": sum(said[part] for part in PARTS),
            "solve": said["factor"] + said["solve"], "iterations": said["iterations"],
            "megabytes": said["peak"] - said["peak_before"], "l2": said["l2"],
            "how": f"{said['method']} {said['preconditioner']}".strip()}


def by_bicgstab(a, b, count):
    factors = spilu(a.tocsc(), drop_tol=1e-4, fill_factor=10)
    m = LinearOperator(a.shape, factors.solve)
    phi, failed = bicgstab(a, b, tol=1e-10, atol=0, M=m, maxiter=1000, callback=count)
    return phi if failed == 0 else phi * np.nan


def peak_megabytes():
    """Of this process; getrusage would know of whoever started it, too."""
    status = pathlib.Path("/proc/self/status").read_text()
    return int(re.search(r"VmHWM:\s*(\d+)", status)[1]) / 1024


def scipy_here(dim, points, way, pipe):
    begin = time.process_time()
    x, h = jittered_lattice(dim, points)
    exact = np.sin(np.pi * x).prod(1)
    centres = np.flatnonzero(((x > 0) & (x < 1)).all(1))
    begin = time.process_time()
    lists = scipy_lists(cKDTree(x, balanced_tree=False, compact_nodes=False), 2.1 * h)
    counts, indices, weight = weights_of(x, centres, lists, 2.1 * h)
    a, b = assemble(len(x), centres, counts, indices, weight), dim * np.pi**2 * exact[centres]
    before, middle, iterations = peak_megabytes(), time.process_time(), []
    phi = by_splu(a.tocsc(), b) if way == "SciPy splu" else by_bicgstab(a, b, iterations.append)
    end = time.process_time()
    pipe.send({"points": len(x), "total": end - begin, "solve": end - middle,
               "iterations": len(iterations), "megabytes": peak_megabytes() - before,
               "l2": float(np.sqrt(np.mean((phi - exact[centres])**2))), "how": ""})


def scipys(dim, points, way):
    """In a process of its own, whose peak of memory is its own."""
    here, there = multiprocessing.Pipe()
    process = multiprocessing.get_context("spawn").Process(
        target=scipy_here, args=(dim, points, way, there))
    process.start()
    there.close()
    found = here.recv()
    process.join()
    return found


def plot(rows, path):
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    quantities = (("total", "whole pipeline, CPU s"), ("iterations", "iterations"),
                  ("megabytes", "memory of the solve, MB"))
    figure, axes = plt.subplots(2, 3, figsize=(13, 8), sharex=True)
    for line, dim in zip(axes, (2, 3)):
        for axis, (key, label) in zip(line, quantities):
            for k, name in enumerate(dict.fromkeys(row["solver"] for row in rows)):
                mine = [row for row in rows if row["dim"] == dim and row["solver"] == name]
                if mine and max(row[key] for row in mine) > 0:
                    axis.plot([row["points"] for row in mine], [max(row[key], 1e-3) for row in mine],
                              "o--" if name.startswith("SciPy") else "o-", color=f"C{k}",
                              label=name, linewidth=3 if name == "auto" else 1.5,
                              alpha=0.5 if name == "auto" else 1)
            axis.set(xscale="log", yscale="log", title=f"{dim}-D: {label}")
            axis.grid(alpha=0.3)
            if axis in axes[1]:
                axis.set_xlabel("points")
    handles, names = axes[0][0].get_legend_handles_labels()
    figure.tight_layout(rect=(0, 0.05, 1, 1))
    figure.legend(handles, names, loc="lower center", ncol=len(names))
    figure.savefig(path, dpi=110)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("program")
    parser.add_argument("--cases", nargs="+", default=CASES)
    parser.add_argument("--plot")
    options = parser.parse_args()
    rows = []
    print("dim  points  solver          | total s  solve s  iterations      MB       l2  by")
    for case in options.cases:
        dim, points = int(case.split(":")[0]), round(float(case.split(":")[1]))
        for name in (*OURS, "SciPy splu", "SciPy bicgstab"):
            if points > LIMITS.get((name, dim), 2e6):
                continue
            found = (ours(options.program, dim, points, OURS[name]) if name in OURS
                     else scipys(dim, points, name))
            rows.append({"dim": dim, "solver": name, **found})
            print(f"{dim:3d} {found['points']:7d}  {name:15s} | {found['total']:7.3f}"
                  f" {found['solve']:8.3f} {found['iterations']:11d} {found['megabytes']:7.0f}"
                  f" {found['l2']:8.1e}  {found['how']}", flush=True)
    if options.plot:
        plot(rows, options.plot)


if __name__ == "__main__":
    main()
