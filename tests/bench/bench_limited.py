#!/usr/bin/env python3
"""Errors, bounds and cost of the ways to upwind: bench_limited.py PATH/TO/scatterd

Prints the Markdown table of lib/README.md (limited.h): Smith and Hutton's flow, a step carried at an
angle, a smooth field turned about a corner; lsmps of degree 2 on jittered clouds."""

import json
import math
import subprocess
import sys
import tempfile

UPWINDS = ("none", "exact", "cosine", "limited")
OUTLET = {  # published, x = 0.1, 0.2 .. 0.9
    1e-3: (1.999, 2.000, 1.985, 1.841, 0.951, 0.154, 0.001, 0, 0),
    1e-6: (2.000, 2.000, 1.999, 1.964, 1.000, 0.036, 0.001, 0, 0),
}
WAVE = "sin(3*x + 0.5)*cos(2*y)"
SOURCE = ("-y*(3*cos(3*x + 0.5)*cos(2*y) + 0.5*y) + x*(0.5*x - 2*sin(3*x + 0.5)*sin(2*y))"
          f" + 13*mu*{WAVE}")


def solve(inputs):
    with tempfile.NamedTemporaryFile("w", suffix=".json") as body:
        json.dump({"inputs": inputs}, body)
        body.flush()
        done = subprocess.run([sys.argv[1], "run", "--process", "solve", body.name],
                              capture_output=True, text=True, check=True)
    return {name: value["value"] if isinstance(value, dict) else value
            for name, value in json.loads(done.stdout).items()}


def lattice(lower, upper, cells, jitter):
    return {"lattice": {"lower": lower, "upper": upper, "cells": cells, "jitter": jitter, "seed": 1}}


def smith_hutton(n, jitter, mu, upwind):
    outside = {"type": "dirichlet", "value": "1 - tanh(10)"}
    result = solve({
        "cloud": lattice([-1, 0], [1, 1], [2 * n, n], jitter), "diffusivity": mu,
        "velocity": ["2*y*(1 - x^2)", "-2*x*(1 - y^2)"], "operator": {"upwind": upwind},
        "boundary": [{"on": "bottom", "type": "neumann", "value": 0},
                     {"on": list(range(n + 1)), "type": "dirichlet", "value": "1 + tanh(10*(2*x + 1))"},
                     *({"on": side, **outside} for side in ("left", "right", "top"))]})
    found = [result["solution"][n + n * k // 10] for k in range(1, 10)]
    return max(abs(a - b) for a, b in zip(found, OUTLET[mu])), result


def skew(n, jitter, mu, upwind):
    u, v = math.cos(math.radians(35)), math.sin(math.radians(35))
    step = f"{u}*y - {v}*x >= -1e-12"
    result = solve({
        "cloud": lattice([0, 0], [1, 1], [n, n], jitter), "diffusivity": mu, "velocity": [u, v],
        "operator": {"upwind": upwind}, "exact": step,
        "boundary": [{"on": "right", "type": "neumann", "value": 0},
                     {"on": "top", "type": "neumann", "value": 0},
                     {"on": "left", "type": "dirichlet", "value": step},
                     {"on": "bottom", "type": "dirichlet", "value": step}]})
    return result["norms"]["l1"], result


def turning(n, jitter, mu, upwind):
    wave = f"{WAVE} + 0.5*x*y"
    result = solve({
        "cloud": lattice([0, 0], [1, 1], [n, n], jitter), "diffusivity": mu, "velocity": ["-y", "x"],
        "parameters": {"mu": mu}, "operator": {"upwind": upwind}, "source": SOURCE, "exact": wave,
        "boundary": [{"on": "boundary", "type": "dirichlet", "value": wave}]})
    return result["norms"]["l2"], result


def cell(error, result):
    """Error; bounds; back-substitutions; milliseconds to assemble, factor and solve."""
    bounds, d = result["diagnostics"]["bounds"], result["diagnostics"]["solver"]
    seconds = result["report"]["seconds"]
    spent = " + ".join(f"{1e3 * seconds[name]:.0f}" for name in ("assemble", "factor", "solve"))
    return (f"{error:.2g}; {bounds['min']:.3f} to {bounds['max']:.3f}; {d['iterations']} it; "
            f"{spent} ms")


def main():
    print("| case | cells | alpha | mu |", " | ".join(UPWINDS), "|\n|---|---|---|---|" + "---|" * 4)
    for case, n, jitter, mu in (
            (smith_hutton, 80, 0.4, 1e-3), (smith_hutton, 40, 0.4, 1e-6),
            (smith_hutton, 80, 0.4, 1e-6), (smith_hutton, 160, 0, 1e-6),
            (skew, 40, 0.4, 1e-5), (skew, 80, 0.4, 1e-5),
            (turning, 40, 0.4, 1e-1), (turning, 40, 0.4, 1e-3),
            (turning, 40, 0.4, 1e-6), (turning, 80, 0.4, 1e-6)):
        cells = (cell(*case(n, jitter, mu, upwind)) for upwind in UPWINDS)
        print(f"| {case.__name__} | {n} | {jitter} | {mu:g} |", " | ".join(cells), "|", flush=True)


if __name__ == "__main__":
    main()
