#!/usr/bin/env python3
"""Smith and Hutton's turning flow: a steep front carried round a half circle, hardly diffused.

The front enters on the left of the bottom side and leaves on its right. Central differences
oscillate wildly here; with upwinding the solution must stay within the bounds of its data, and the
outlet must be the mirror image of the inlet but for the smearing of a scheme of first order.
"""

import numpy
from common import run, scatterd

CELLS = 80
INLET = "1 + tanh(10*(2*x + 1))"


def inlet(x):
    return 1 + numpy.tanh(10 * (2 * x + 1))


def solve(client, upwind):
    columns = numpy.arange(2 * CELLS + 1)  # the bottom side: the first row of the lattice
    return client.solve(
        cloud=scatterd.lattice([-1, 0], [1, 1], [2 * CELLS, CELLS], jitter=0.3, seed=3),
        velocity=["2*y*(1 - x^2)", "-2*x*(1 - y^2)"],
        diffusivity=1e-6,
        boundary=[
            scatterd.neumann("bottom", 0),
            scatterd.dirichlet("left", "1 - tanh(10)"),
            scatterd.dirichlet("right", "1 - tanh(10)"),
            scatterd.dirichlet("top", "1 - tanh(10)"),
            scatterd.dirichlet(columns[: CELLS + 1], INLET),
        ],
        operator={"scheme": "ips", "upwind": upwind},
    )


def main(client, plot, checks):
    central, upwind = (solve(client, name) for name in ("none", "cosine"))
    x = upwind.points[CELLS : 2 * CELLS + 1, 0]
    outlet = upwind.solution[CELLS : 2 * CELLS + 1]
    low, high = upwind.solution.min(), upwind.solution.max()
    print(f"central from {central.solution.min():.2f} to {central.solution.max():.2f}, ", end="")
    print(f"upwind from {low:.2e} to {high:.6f}; the data lie in [0, 2]")
    checks.below("below the bounds", -low, 1e-9)
    checks.below("above the bounds", high - 2, 1e-9)
    checks.below("rms error at the outlet", numpy.sqrt(numpy.mean((outlet - inlet(-x)) ** 2)), 0.2)
    if plot:
        scatterd.plot(upwind, file=plot, title="Smith and Hutton's turning flow, mu = 1e-6")


if __name__ == "__main__":
    run(main, __doc__)
