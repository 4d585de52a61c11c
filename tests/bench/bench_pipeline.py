#!/usr/bin/env python3
"""Poisson's equation on jittered clouds, all of it, beside the same in SciPy in the same run.

    bench_pipeline.py BENCH_STENCIL [--cases 2:1e4 2:1e5 2:1e6- 3:1e4 3:3e4 3:1e5- 3:1e6-]

A case is DIM:POINTS; a minus sign leaves out the solve. Both discretise -lap phi = dim pi^2 phi on
jittered lattices (0.3) by weighted least squares of degree 2 within 2.1 spacings, with the same
weights, and eliminate the boundary; "l2" is the error of the solution. SciPy: cKDTree.query_pairs
to compressed rows; normal equations of all points at once (products over the pairs summed by row,
numpy.linalg.solve on the stack); scipy.sparse; splu with MMD_AT_PLUS_A in symmetric mode, which is
its fastest way here, and beside it spsolve as it comes. Seconds of the processor, one thread, the best of several runs;
"per point" is the time of a point relative to that of the first case of the dimension.
"""

import argparse
import itertools
import json
import os
import subprocess
import time

os.environ.update(OPENBLAS_NUM_THREADS="1", OMP_NUM_THREADS="1")

import numpy as np  # noqa: E402  (threads are counted when it is loaded)
import scipy.sparse as sparse  # noqa: E402
from scipy.sparse.linalg import splu, spsolve  # noqa: E402
from scipy.spatial import cKDTree  # noqa: E402

from bench_search import jittered_lattice, scipy_lists  # noqa: E402

CASES = ["2:1e4", "2:1e5", "2:1e6-", "3:1e4", "3:3e4", "3:1e5-", "3:1e6-"]
CHUNK = 50000  # points whose pairs are in memory at a time
SLOW = 20      # seconds of splu beyond which spsolve is not waited for
OURS = {"neighbours": ["order", "search", "lists"], "rows": ["assemble"],
        "solve": ["factor", "solve"]}


class Watch:
    """Seconds of the processor by phase."""

    def __init__(self):
        self.seconds, self.last = {}, time.process_time()

    def lap(self, phase):
        now = time.process_time()
        self.seconds[phase] = now - self.last
        self.last = time.process_time()


# ---- SciPy ----

def basis_of(r):
    """Taylor's polynomials of degree 2 without constant [pairs][unknowns], and what lap is of them."""
    dim = r.shape[1]
    pairs = list(itertools.combinations_with_replacement(range(dim), 2))
    half = [0.5 if a == b else 1 for a, b in pairs]
    columns = [r[:, a] for a in range(dim)]
    columns += [f * r[:, a] * r[:, b] for f, (a, b) in zip(half, pairs)]
    return np.stack(columns, 1), np.array([0.0] * dim + [float(a == b) for a, b in pairs])


def weights_of(x, centres, lists, radius):
    """Weights of lap at the centres, in the order of their pairs: l_j = W_j p_j . A^-1 c / r_e^2."""
    pieces = []
    for first in range(0, len(centres), CHUNK):
        rows = lists[centres[first:first + CHUNK]]
        owner = np.repeat(centres[first:first + CHUNK], np.diff(rows.indptr))
        r = (x[rows.indices] - x[owner]) / radius
        square = np.einsum("ka,ka->k", r, r)
        w = (1 / np.sqrt(square) - 1) / square
        p, wanted = basis_of(r)
        u = p.shape[1]
        a = np.empty((rows.shape[0], u, u))
        for i in range(u):
            wp = w * p[:, i]
            for j in range(i, u):
                a[:, i, j] = a[:, j, i] = np.add.reduceat(wp * p[:, j], rows.indptr[:-1])
        c = np.linalg.solve(a, np.broadcast_to(wanted, (len(a), u))[..., None])[..., 0]
        spread = np.repeat(c, np.diff(rows.indptr), axis=0)
        pieces.append((rows, w * np.einsum("ku,ku->k", p, spread) / radius**2))
    indices = np.concatenate([rows.indices for rows, _ in pieces])
    counts = np.concatenate([np.diff(rows.indptr) for rows, _ in pieces])
    return counts, indices, np.concatenate([weight for _, weight in pieces])


def assemble(n, centres, counts, indices, weight):
    """-lap on the unknowns."""
    number = np.full(n, -1)
    number[centres] = np.arange(len(centres))
    column, row = number[indices], np.repeat(np.arange(len(centres)), counts)
    keep = column >= 0
    off = sparse.csr_matrix((-weight[keep], (row[keep], column[keep])), (len(centres),) * 2)
    return off + sparse.diags(np.add.reduceat(weight, np.cumsum(counts) - counts))


def by_splu(a, b):
    factors = splu(a, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.001,
                   options={"SymmetricMode": True})
    return factors.solve(b)


def solve(watch, a, b):
    """The solution, by two ways."""
    a = a.tocsc()
    watch.lap("assembly")
    phi = by_splu(a, b)
    watch.lap("solve")
    if watch.seconds["solve"] < SLOW:
        spsolve(a, b, use_umfpack=False)
        watch.lap("spsolve")
    return phi


def scipy_once(x, h, with_solve):
    """Seconds by phase, and the error."""
    watch = Watch()
    dim = x.shape[1]
    tree = cKDTree(x, balanced_tree=False, compact_nodes=False)
    lists = scipy_lists(tree, 2.1 * h)
    watch.lap("neighbours")
    exact = np.sin(np.pi * x).prod(1)
    centres = np.flatnonzero(((x > 0) & (x < 1)).all(1))
    watch.last = time.process_time()
    counts, indices, weight = weights_of(x, centres, lists, 2.1 * h)
    watch.lap("stencils")
    a = assemble(len(x), centres, counts, indices, weight)
    b = dim * np.pi**2 * exact[centres]
    watch.lap("assembly")
    if not with_solve:
        return watch.seconds, 0
    assembly = watch.seconds["assembly"]
    phi = solve(watch, a, b)
    watch.seconds["assembly"] += assembly
    return watch.seconds, np.sqrt(np.mean((phi - exact[centres])**2))


def measure_scipy(dim, points, with_solve, repeats):
    x, h = jittered_lattice(dim, points)
    runs = [scipy_once(x, h, with_solve) for _ in range(repeats)]
    best = {phase: min(run[0][phase] for run in runs) for phase in runs[0][0]}
    return {"neighbours": best["neighbours"], "rows": best["stencils"] + best["assembly"],
            "solve": best.get("solve", 0), "spsolve": best.get("spsolve", 0), "l2": runs[0][1]}


# ---- ours ----

def measure(program, dim, points, with_solve, repeats):
    line = [program, str(dim), str(points), "1", str(repeats), str(int(with_solve)), "lsmps", "2"]
    said = json.loads(subprocess.run(line, check=True, capture_output=True, text=True).stdout)
    found = {phase: sum(said[part] for part in parts) for phase, parts in OURS.items()}
    return {**found, "l2": said["l2"], "points": said["points"]}


def row(found, ours):
    """Seconds by phase and in all, or how many times those of ours."""
    seconds = [found[phase] for phase in OURS]
    seconds.append(sum(seconds))
    if found is ours:
        return " ".join(f"{s:10.4f}" for s in seconds)
    compared = [s / mine if mine else 0 for s, mine in zip(seconds, map(float, row(ours, ours).split()))]
    with_spsolve = seconds[-1] - found["solve"] + found["spsolve"]
    compared.append(with_spsolve / sum(ours[phase] for phase in OURS) if found["spsolve"] else 0)
    return (" ".join(f"{s:10.4f}" for s in seconds) + f" {found['l2']:8.1e} |          "
            + " ".join(f"{ratio:9.1f}x" if ratio else f"{'-':>10}" for ratio in compared))


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("program")
    parser.add_argument("--cases", nargs="+", default=CASES)
    options = parser.parse_args()
    head = " ".join(f"{phase:>10}" for phase in (*OURS, "total"))
    print(f"dim       n | {head} us/point per point       l2 | SciPy {head}       l2 |"
          f" / ours {head}    spsolve")
    first = {}
    for case in options.cases:
        dim, points = int(case.split(":")[0]), round(float(case.split(":")[1].rstrip("-")))
        with_solve = not case.endswith("-")
        repeats = max(1, min(5, round(3e5 / points)))
        ours = measure(options.program, dim, points, with_solve, max(3, repeats))
        theirs = measure_scipy(dim, points, with_solve, repeats)
        each = (ours["neighbours"] + ours["rows"]) / ours["points"]
        first.setdefault(dim, each)
        print(f"{dim:3d} {ours['points']:7d} | {row(ours, ours)} {1e6 * each:8.3f}"
              f" {each / first[dim]:9.2f} {ours['l2']:8.1e} |       {row(theirs, ours)}", flush=True)


if __name__ == "__main__":
    main()
