#!/usr/bin/env python3
"""Heat equation on a jittered cloud, against its exact solution.

A decaying wave over a saddle, phi = exp(-8 pi^2 t) sin(2 pi x) sin(2 pi y) + 4x(x - 1) - 4y(y - 1)
+ (x - 1/2)(y - 1/2), marched to t = 0.02 and recorded on the way.
"""

import numpy
from common import run, scatterd

EXACT = (
    "exp(-8*pi^2*t) * sin(2*pi*x) * sin(2*pi*y) + 4*x*(x - 1) - 4*y*(y - 1) + (x - 0.5)*(y - 0.5)"
)
TIMES = [0.0025, 0.005, 0.01, 0.02]


def exact(points, t):
    x, y = points.T
    waves = numpy.sin(2 * numpy.pi * points).prod(axis=1)
    decayed = numpy.exp(-8 * numpy.pi**2 * t) * waves
    return decayed + 4 * x * (x - 1) - 4 * y * (y - 1) + (x - 0.5) * (y - 0.5)


def main(client, plot, checks):
    result = client.solve(
        cloud=scatterd.lattice([0, 0], [1, 1], 64, jitter=0.3, seed=16),
        diffusivity=1,
        boundary=[scatterd.dirichlet("boundary", EXACT)],
        initial=EXACT,
        time={"method": "crank-nicolson", "end": TIMES[-1], "step": 2.5e-4, "save": TIMES},
        operator={"scheme": "lsmps"},
        exact=EXACT,
    )
    for t, solution in zip(result.history.t, result.history.solution):
        error = solution - exact(result.points, t)
        checks.below(f"rms error at t = {t:g}", numpy.sqrt(numpy.mean(error**2)), 1e-3)
    checks.below("l2 error as the service has it", result.norms.l2, 1e-3)
    if plot:
        scatterd.plot(result, file=plot, title=f"Heat equation, t = {TIMES[-1]}")


if __name__ == "__main__":
    run(main, __doc__)
