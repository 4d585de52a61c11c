#!/usr/bin/env python3
"""Gartland's boundary layer: u . grad phi = mu lap phi with u = (1, 0) on the unit square.

The solution falls from its crest to 0 within a layer of width mu at x = 1. Solved on jittered
clouds of two sizes by least squares of degree 2; the error must fall with the square of the
spacing.
"""

import math

from common import run, scatterd

MU = 0.01
EXACT = "exp(x/(2*mu)) * sin(pi*y) * (2*exp(-1/(2*mu))*sinh(l*x) + sinh(l*(1 - x))) / sinh(l)"
PARAMETERS = {"mu": MU, "l": math.hypot(math.pi, 1 / (2 * MU))}


def solve(client, cells):
    return client.solve(
        cloud=scatterd.lattice([0, 0], [1, 1], cells, jitter=0.3, seed=1),
        parameters=PARAMETERS,
        velocity=[1, 0],
        diffusivity="mu",
        boundary=[scatterd.dirichlet("boundary", EXACT)],
        operator={"scheme": "lsmps", "degree": 2, "radius": 2.1},
        exact=EXACT,
    )


def main(client, plot, checks):
    coarse, fine = (solve(client, cells) for cells in (60, 120))
    order = math.log2(coarse.norms.l2 / fine.norms.l2)
    print(f"l2 error with 60 cells a side {coarse.norms.l2:.3e}, with 120 {fine.norms.l2:.3e}")
    seconds = fine.report.seconds.total
    print(f"observed order {order:.2f}; {len(fine.points)} points took {seconds:.2f} s")
    checks.below("l2 error, 120 cells a side", fine.norms.l2, 4e-3)
    checks.below("linf error, 120 cells a side", fine.norms.linf, 6e-2)
    checks.below("order short of 2", 2 - order, 0.2)
    if plot:
        scatterd.plot(fine, file=plot, title=f"Gartland's layer, mu = {MU}")


if __name__ == "__main__":
    run(main, __doc__)
