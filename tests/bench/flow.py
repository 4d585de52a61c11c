#!/usr/bin/env python3
"""Cavity and step against their references, the runs that are too long for the test suite.

    flow.py BENCH_FLOW [--out DIR] [--only PATTERN] [--table | --markdown]

runs the cases below with bench_flow, one after the other, keeps each result as DIR/NAME.json (a
case whose file is there is not run again), and prints one row per case. With --table nothing is
run; --markdown prints the table of lib/README.md from what is there. Needs numpy and scipy. tests/README.md has the figures.
"""
import argparse
import fnmatch
import json
import os
import subprocess
import sys

import numpy as np
from scipy.interpolate import CubicSpline

HERE = os.path.dirname(os.path.abspath(__file__))
REFERENCE = json.load(open(os.path.join(HERE, "..", "reference", "flow.json")))


def cases():
    """Name and arguments of every run, those that something must hold of first."""
    meshes = {
        "cavity-20": ["cavity", "cells=20"],
        "cavity-40": ["cavity", "cells=40"],
        "cavity-40g": ["cavity", "cells=40", "clustering=0.3"],
        "step-17": ["step", "cells=17"],
        "step-17g": ["step", "cells=17", "clustering=0.3"],
    }
    large = {"cavity-80": ["cavity", "cells=80"], "step-26g": ["step", "cells=26", "clustering=0.3"]}
    for scheme in ("ips", "ps"):
        for name, words in {**meshes, **large}.items():
            yield f"{name}-{scheme}-points", words, scheme, "points"
    for scheme in ("ips", "ps"):
        for name, words in meshes.items():
            yield f"{name}-{scheme}-mirror", words, scheme, "mirror"
    for scheme in ("ipsn", "lsmps"):
        for name, words in meshes.items():
            yield f"{name}-{scheme}-points", words, scheme, "points"
    yield from others()


def others():
    """Longer times, higher Reynolds numbers, and meshes that no table names."""
    yield "cavity-30-ips-points", ["cavity", "cells=30"], "ips", "points"
    yield "cavity-60-ips-points", ["cavity", "cells=60"], "ips", "points"
    yield "cavity-30g-ips-points", ["cavity", "cells=30", "clustering=0.2"], "ips", "points"
    yield "step-22g-ips-points", ["step", "cells=22", "clustering=0.2"], "ips", "points"
    for scheme in ("ips", "ps"):
        for reynolds, end in ((400, 60), (1000, 80)):
            words = ["cavity", "cells=80", f"reynolds={reynolds}", f"end={end}"]
            yield f"cavity-80-{scheme}-re{reynolds}", words, scheme, "points"
        for reynolds, length in ((50, 12), (200, 14), (400, 24)):
            words = ["step", "cells=17", f"reynolds={reynolds}", f"downstream={length}", "end=100"]
            yield f"step-17-{scheme}-re{reynolds}", words, scheme, "points"
        yield f"cavity-40-{scheme}-t100", ["cavity", "cells=40", "end=100"], scheme, "points"
    for scheme in ("ipsn", "lsmps"):
        for name, words in (("cavity-80", ["cavity", "cells=80"]),
                            ("step-26g", ["step", "cells=26", "clustering=0.3"])):
            yield f"{name}-{scheme}-points", words, scheme, "points"


def difference(section, s, value):
    """Root mean square of a profile less the reference, at the places of the profile."""
    inner = slice(1, len(section["s"]) - 1)
    x, u = np.array(section["s"][inner]), np.array(section["value"][inner])
    keep = (x >= s[0]) & (x <= s[-1])
    return float(np.sqrt(np.mean((u - CubicSpline(s, value)(x))[keep] ** 2)))


def against_ghia(section, s, value):
    """The same at the places of Ghia's tables, whose spacing is too wide to interpolate in."""
    u = CubicSpline(section["s"], section["value"])(s)
    return float(np.sqrt(np.mean((u - value) ** 2)))


def in_time(result):
    """Root mean square of circulation(t) less the reference's where that has values."""
    known, h = REFERENCE["cavity"]["history"], result["history"]
    got = np.interp(known["t"], h["t"], h["circulation"])
    return float(np.sqrt(np.mean((got - known["circulation"]) ** 2)))


def errors(result, reynolds):
    """What a row says of a result besides its cost."""
    if "step_height" in result:
        row = {"reattachment": result.get("reattachment")}
        if reynolds == 100:
            known = REFERENCE["step"]
            parts = [difference(section, known["y"], u) for section, u in zip(result["u"], known["u"])]
            row["rms"] = float(np.sqrt(np.mean(np.square(parts))))
        return row
    v = result["vortex"]
    row = {"Q": v["circulation"], "x": v["x"], "y": v["y"]}
    if reynolds == 100:
        known = REFERENCE["cavity"]
        row["dQ%"] = 100 * (v["circulation"] / known["circulation"] - 1)
        row["rms_u"] = difference(result["u"][0], known["s"], known["u"])
        row["rms_v"] = difference(result["v"][0], known["s"], known["v"])
        row["rms_Q(t)"] = in_time(result)
    ghia = REFERENCE["ghia"].get(str(reynolds))
    if ghia:
        row["ghia_u"] = against_ghia(result["u"][0], ghia["y"][::-1], np.array(ghia["u"][::-1]))
        row["ghia_v"] = against_ghia(result["v"][0], ghia["x"][::-1], np.array(ghia["v"][::-1]))
    return row


def cloud(result):
    """The worst that the cloud was after the first tenth of the run; `empty` on average over the
    second half."""
    h, first = result["history"], len(result["history"]["t"]) // 10
    later = {k: np.array(v[first:]) for k, v in h.items()}
    return {
        "empty": float(np.mean(h["empty"][len(h["empty"]) // 2:])),
        "empty_max": float(later["empty"].max()),
        "nearest_1": float(later["nearest_1"].min()),
        "particles/cells": float((later["particles"] / result["cells"]).max()),
        "least": float((later["particles"] / result["cells"]).min()),
        "div": float(later["divergence"].max()),
    }


def show(name, result, reynolds):
    row = {**errors(result, reynolds), **cloud(result)}
    cost = (f"steps {result['steps']} cpu {result['cpu']:.1f} s "
            f"{result['microseconds_per_particle_step']:.2f} us")
    text = " ".join(f"{k}={v:.4g}" for k, v in row.items() if v is not None)
    print(f"{name:26s} {text} {cost}", flush=True)


def cell(path):
    """Errors of a result in a word, for a table; a dash where there is none."""
    if not os.path.exists(path):
        return "-"
    with open(path, encoding="utf-8") as text:
        row = errors(json.load(text), 100)
    if "reattachment" in row:
        return f"{row['reattachment']:.2f}, {row['rms']:.4f}"
    return f"{row['dQ%']:+.1f} %, {row['rms_u']:.4f}, {row['rms_v']:.4f}"


def markdown(folder):
    """Cases down, schemes and walls across."""
    columns = [("ips", "points"), ("ps", "points"), ("ips", "mirror"), ("ps", "mirror"),
               ("ipsn", "points"), ("lsmps", "points")]
    print("| case | " + " | ".join(f"{s}, {w}" for s, w in columns) + " |")
    print("|---" * (len(columns) + 1) + "|")
    for name in ("cavity-20", "cavity-40", "cavity-80", "cavity-40g", "step-17", "step-17g", "step-26g"):
        cells = [cell(os.path.join(folder, f"{name}-{s}-{w}.json")) for s, w in columns]
        print(f"| {name} | " + " | ".join(cells) + " |")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("bench")
    parser.add_argument("--out", default="flow-results")
    parser.add_argument("--only", default="*")
    parser.add_argument("--table", action="store_true")
    parser.add_argument("--markdown", action="store_true")
    args = parser.parse_args()
    if args.markdown:
        return markdown(args.out)
    os.makedirs(args.out, exist_ok=True)
    for name, words, scheme, walls in cases():
        if not fnmatch.fnmatch(name, args.only):
            continue
        path = os.path.join(args.out, name + ".json")
        if not os.path.exists(path):
            if args.table:
                continue
            run = subprocess.run([args.bench, *words, f"scheme={scheme}", f"walls={walls}"],
                                 capture_output=True, text=True)
            if run.returncode != 0:
                print(f"{name:26s} failed: {run.stderr.strip()}", flush=True)
                continue
            with open(path + ".part", "w", encoding="utf-8") as out:
                out.write(run.stdout)
            os.rename(path + ".part", path)
        reynolds = next((int(w.split("=")[1]) for w in words if w.startswith("reynolds=")), 100)
        with open(path, encoding="utf-8") as text:
            show(name, json.load(text), reynolds)


if __name__ == "__main__":
    sys.exit(main())
