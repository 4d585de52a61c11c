#!/usr/bin/env python3
"""The search beside SciPy's cKDTree, in one run on one machine.

    bench_search.py BUILD/tests/bench/bench_search [--points 1e4 1e5 1e6] [--threads 1]
                    [--order lattice|random|curve]

Jittered lattices (0.3), radius 2.1 spacings. SciPy: build the tree, query_pairs (each pair once,
as an array), both directions, sorted into compressed rows by scipy.sparse: the fastest way there
is to the same lists. Seconds are the processor's (SciPy's always, ours with one thread), best of
several. "linear" is the time per point relative to the smallest cloud.
"""

import argparse
import subprocess
import time

import numpy as np
from scipy.sparse import coo_matrix
from scipy.spatial import cKDTree


def jittered_lattice(dim, points, jitter=0.3):
    """A cloud of the same kind as the program's, and its spacing."""
    side = round(points ** (1 / dim))
    h = 1 / (side - 1)
    axes = np.meshgrid(*[np.arange(side)] * dim, indexing="ij")
    x = np.stack(axes[::-1], -1).reshape(-1, dim)
    inside = ((x > 0) & (x < side - 1)).all(1)
    x = x * h
    x[inside] += jitter * h * (np.random.default_rng(1).random((inside.sum(), dim)) - 0.5)
    return x, h


def ordered(x, order):
    """The cloud in an order as good as the program's."""
    return np.random.default_rng(2).permutation(x) if order == "random" else x


def best_of(repeats, work):
    """Least seconds of several runs, and the last result."""
    least = np.inf
    for _ in range(repeats):
        start = time.process_time()
        result = work()
        least = min(least, time.process_time() - start)
    return least, result


def scipy_lists(tree, radius):
    """Compressed rows of neighbours."""
    i, j = tree.query_pairs(radius, output_type="ndarray").astype(np.int32).T
    row, column = np.concatenate((i, j)), np.concatenate((j, i))
    return coo_matrix((np.ones(len(row), np.int8), (row, column)), shape=(tree.n, tree.n)).tocsr()


def measure_scipy(dim, points, order, repeats):
    """Seconds of build and lists, neighbours per point."""
    x, h = jittered_lattice(dim, points)
    x = ordered(x, order)
    build, tree = best_of(repeats, lambda: cKDTree(x, balanced_tree=False, compact_nodes=False))
    lists, rows = best_of(repeats, lambda: scipy_lists(tree, 2.1 * h))
    nearest, _ = best_of(1, lambda: tree.query(x, 2))
    return build, lists, nearest, rows.nnz / len(x)


def measure(program, dim, points, threads, order, repeats):
    """Numbers that the program prints."""
    line = [program, str(dim), str(points), "2.1", str(threads), str(repeats), order]
    return map(float, subprocess.run(line, check=True, capture_output=True, text=True).stdout.split())


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("program")
    parser.add_argument("--points", type=float, nargs="+", default=[1e4, 1e5, 1e6])
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--order", choices=("lattice", "random", "curve"), default="lattice")
    options = parser.parse_args()
    print("dim       n neighb. |   order   build   lists nearest s | lists ns/pt linear |"
          "   SciPy: build   lists nearest s | ratio build+lists, nearest")
    for dim in (2, 3):
        first = None
        for points in options.points:
            repeats = max(3, min(30, int(1e6 / points)))
            n, neighbours, build, lists, nearest, order = measure(
                options.program, dim, points, options.threads, options.order, repeats)
            s_build, s_lists, s_nearest, s_neighbours = measure_scipy(
                dim, points, options.order, 1 if points > 2e5 else 3)
            assert abs(neighbours - s_neighbours) < 0.05 * neighbours
            each = (build + lists) / n
            first = first or each
            print(f"{dim:3d} {n:7.0f} {neighbours:7.2f} | {order:7.4f} {build:7.4f} {lists:7.4f} "
                  f"{nearest:7.4f}   | {1e9 * lists / n:11.1f} {each / first:6.2f} |"
                  f"  {s_build:13.4f} {s_lists:7.4f} {s_nearest:7.4f}   |"
                  f" {(s_build + s_lists) / (build + lists):6.1f}x {s_nearest / nearest:6.1f}x")


if __name__ == "__main__":
    main()
