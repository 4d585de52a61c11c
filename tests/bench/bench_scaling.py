#!/usr/bin/env python3
"""The model of scaling.md beside a cluster.

    bench_scaling.py                                   what it predicts, as a table
    bench_scaling.py BENCH_RANKS 2 1e6 ilu 1 2 4 8     measured for these numbers of ranks, and predicted

Latency (s), bandwidth (bytes/s) and costs of a rank are options, with the values of scaling.md.
The command that starts ranks is $MPIEXEC (mpiexec).
"""
import argparse
import json
import math
import os
import shlex
import subprocess

# CPU seconds of a point: rows, set-up, one iteration. Measured with one rank, see scaling.md.
COSTS = {(2, "ilu"): (1.2e-6, 0.4e-6, 77e-9), (2, "amg"): (1.2e-6, 3.1e-6, 326e-9),
         (3, "ilu"): (2.9e-6, 0.4e-6, 145e-9), (3, "amg"): (2.9e-6, 3.3e-6, 363e-9)}
PLACES = {2: 0.06e-6, 3: 0.06e-6}  # of a point of the whole: the curve and the numbers, on each rank
WIDTH = 2.1                        # support, in spacings
REDUCTIONS, EXCHANGES = 4, 2       # of one iteration of BiCGStab
LEVEL_EXCHANGES = 6                # of one multigrid cycle, on each of its levels
NEIGHBOURS = {2: 7, 3: 20}         # parts that a part exchanges with


def halo(dim, points, ranks):
    """Points in the halo of a part, at most."""
    side = (points / ranks) ** (1 / dim)
    return 0 if ranks == 1 else (side + 2 * WIDTH) ** dim - side ** dim


def iterations(dim, points, preconditioner, ranks):
    if preconditioner == "amg":
        return 7 if dim == 2 else 13
    alone = 0.55 * points ** 0.5 if dim == 2 else 0.64 * points ** (1 / 3)
    return alone * (1.15 if ranks > 1 else 1)


def seconds(dim, points, preconditioner, ranks, latency, bandwidth):
    rows, setup, step = COSTS[dim, preconditioner]
    own, ghosts = points / ranks, halo(dim, points, ranks)
    steps = math.log2(ranks)
    neighbours = min(NEIGHBOURS[dim], ranks - 1)
    exchange = neighbours * latency + 8 * ghosts / bandwidth
    levels = math.log(max(own, 8), 4) if preconditioner == "amg" else 0
    one = (step * own + EXCHANGES * exchange * (1 + LEVEL_EXCHANGES * levels) +
           REDUCTIONS * 2 * steps * latency)
    whole = PLACES[dim] * points + 8 * points / bandwidth * (ranks > 1)
    parallel = (rows + setup) * own + rows * ghosts * 0.1
    return {"parallel": parallel + iterations(dim, points, preconditioner, ranks) * one,
            "whole": whole}


def predict(arguments):
    print("| d | n | preconditioner | ranks | halo of a part | seconds | of it replicated "
          "| efficiency | without what is replicated |\n" + "|---" * 9 + "|")
    for dim, points, preconditioner in ((2, 1e6, "ilu"), (2, 1e6, "amg"), (2, 1e8, "amg"),
                                        (3, 1e6, "ilu"), (3, 1e6, "amg"), (3, 1e8, "amg")):
        for ranks in (1, 4, 16, 64, 256, 1024):
            first = seconds(dim, points, preconditioner, 1, arguments.latency, arguments.bandwidth)
            t = seconds(dim, points, preconditioner, ranks, arguments.latency, arguments.bandwidth)
            total = sum(t.values())
            print(f"| {dim} | {points:.0e} | {preconditioner} | {ranks} "
                  f"| {halo(dim, points, ranks):.0f} | {total:.3g} | {t['whole'] / total:.0%} "
                  f"| {sum(first.values()) / total / ranks:.0%} "
                  f"| {first['parallel'] / t['parallel'] / ranks:.0%} |")


def measure(arguments):
    dim, points, preconditioner = int(arguments.dim), float(arguments.points), arguments.preconditioner
    launcher = shlex.split(os.environ.get("MPIEXEC", "mpiexec"))
    print("| ranks | iterations | rows | set-up | iteration | gathering | predicted in all |\n"
          + "|---" * 7 + "|")
    for ranks in arguments.ranks:
        done = subprocess.run([*launcher, "-n", str(ranks), arguments.program, str(dim),
                               str(points), preconditioner], stdout=subprocess.PIPE, check=True)
        lines = [json.loads(line) for line in done.stdout.splitlines()]
        most = {key: max(line[key] for line in lines)
                for key in ("rows", "setup", "solve", "exchange")}
        predicted = sum(seconds(dim, points, preconditioner, ranks, arguments.latency,
                                arguments.bandwidth).values())
        print(f"| {ranks} | {lines[0]['iterations']} | {most['rows']:.3g} | {most['setup']:.3g} "
              f"| {most['solve']:.3g} | {most['exchange']:.3g} | {predicted:.3g} |")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--latency", type=float, default=2e-6)
    parser.add_argument("--bandwidth", type=float, default=1e10)
    parser.add_argument("program", nargs="?")
    parser.add_argument("dim", nargs="?", default="2")
    parser.add_argument("points", nargs="?", default="1e6")
    parser.add_argument("preconditioner", nargs="?", default="ilu")
    parser.add_argument("ranks", nargs="*", type=int, default=[1, 2, 4])
    arguments = parser.parse_args()
    (measure if arguments.program else predict)(arguments)


if __name__ == "__main__":
    main()
