#!/usr/bin/env python3
"""Direct solves, ours beside SciPy's in the same run.

usage: bench_solve.py BENCH_SOLVE [NAME...]    (NAMEs of CASES below; default: all)

For each case the matrix of a Laplacian on a jittered cloud is solved by every row of our table that
makes sense, by scipy.sparse.linalg.spsolve and splu (SuperLU, the orderings it has). CPU seconds of
one thread, the best of three; memory is the resident growth of a process that does nothing else.
"""
import json
import multiprocessing
import os
import resource
import subprocess
import sys
import tempfile
import time

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
import scipy.sparse.linalg

from cloud_matrix import cloud_matrix, write

# name: cells, dimension, radius in spacings, our methods, SciPy's orderings
CASES = {
    "100-2d": (11, 2, 2.1, ["klu", "umfpack"], ["COLAMD", "MMD_AT_PLUS_A"]),
    "1e3-2d": (33, 2, 2.1, ["klu", "umfpack"], ["COLAMD", "MMD_AT_PLUS_A"]),
    "1e4-2d": (99, 2, 2.1, ["auto", "klu"], ["COLAMD", "MMD_AT_PLUS_A"]),
    "1e5-2d": (315, 2, 2.1, ["auto"], ["COLAMD", "MMD_AT_PLUS_A"]),
    "1e3-3d": (11, 3, 1.75, ["klu", "umfpack"], ["COLAMD", "MMD_AT_PLUS_A"]),
    "24e3-3d": (30, 3, 1.75, ["auto"], ["MMD_AT_PLUS_A"]),
}


def resident():
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3


def splu_once(a, b, ordering):
    """Seconds of splu and of its solve."""
    options = {"SymmetricMode": True} if ordering != "COLAMD" else {}
    t = [time.process_time()]
    lu = scipy.sparse.linalg.splu(
        a, permc_spec=ordering, diag_pivot_thresh=0.001 if options else None, options=options
    )
    t.append(time.process_time())
    lu.solve(b)
    t.append(time.process_time())
    return t[1] - t[0], t[2] - t[1]


def scipy_splu(a, b, ordering, out):
    before, begin, runs = resident(), time.process_time(), []
    while len(runs) < 3 or (time.process_time() - begin < 1 and len(runs) < 100):
        runs.append(splu_once(a, b, ordering))
        if len(runs) == 1:
            grown = resident() - before
        if time.process_time() - begin > 60:
            break
    out.put((min(r[0] for r in runs), min(r[1] for r in runs), grown))


def scipy_spsolve(a, b, _, out):
    before, seconds = resident(), []
    for _ in range(3):
        t = time.process_time()
        scipy.sparse.linalg.spsolve(a, b, use_umfpack=False)
        seconds.append(time.process_time() - t)
        if seconds[0] > 20:
            break
    out.put((min(seconds), 0.0, resident() - before))


def alone(function, a, b, ordering):
    """Runs in a process of its own, for its memory."""
    out = multiprocessing.Queue()
    process = multiprocessing.Process(target=function, args=(a, b, ordering, out))
    process.start()
    result = out.get()
    process.join()
    return result


def line(what, factor, solve, megabytes, total):
    print(
        f"  {what:28s} {factor:10.5f} {solve:10.6f} {megabytes:8.1f} MB"
        f" {(factor + solve) / total:7.2f} x",
        flush=True,
    )


def run(program, name, folder):
    cells, dim, radius, methods, orderings = CASES[name]
    a = cloud_matrix(cells, dim, radius=radius)
    b = a @ np.random.default_rng(1).uniform(-1, 1, a.shape[0])
    path = os.path.join(folder, name)
    write(path, a, b)
    print(f"{name}: {a.shape[0]} rows, {a.nnz / a.shape[0]:.1f} entries a row")
    print("  what                         analyse+factor solve    memory   total / ours")
    total = None
    for method in methods:
        answer = subprocess.run(
            [program, path, str(dim), method], check=True, capture_output=True, text=True
        )
        r = json.loads(answer.stdout)
        total = total or r["analyse_factor"] + r["solve"]
        line(f"{r['method']} {r['ordering']}", r["analyse_factor"], r["solve"], r["megabytes"], total)
    csc = a.tocsc()
    line("scipy spsolve", *alone(scipy_spsolve, csc, b, None), total)
    for ordering in orderings:
        line(f"scipy splu {ordering}", *alone(scipy_splu, csc, b, ordering), total)


def main():
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    with tempfile.TemporaryDirectory() as folder:
        for name in sys.argv[2:] or CASES:
            run(sys.argv[1], name, folder)


if __name__ == "__main__":
    main()
