#!/usr/bin/env python3
"""Flow around a hole: an irregular cloud of our own, with its own boundary groups and normals.

The potential of a uniform stream around a disc, phi = x (1 + R^2 / r^2), is harmonic, and no flow
crosses the rim: d phi / dn = 0 there. The outer square holds phi itself. The velocity is the
gradient of the solution, taken by the process `apply`.
"""

import numpy
from common import run, scatterd

RADIUS = 0.4
CELLS = 48
OPERATOR = {"scheme": "lsmps", "degree": 4}
EXACT = "x * (1 + R^2 / (x^2 + y^2))"
VELOCITY = ["1 + R^2*(y^2 - x^2) / (x^2 + y^2)^2", "-2*R^2*x*y / (x^2 + y^2)^2"]


def rim(spacing):
    """Points round the disc, and the normals there: out of the fluid, to the centre."""
    count = round(2 * numpy.pi * RADIUS / spacing)
    angle = 2 * numpy.pi * numpy.arange(count) / count
    outward = -numpy.column_stack([numpy.cos(angle), numpy.sin(angle)])
    return -RADIUS * outward, outward


def square(spacing):
    """Points round the square [-1, 1]^2."""
    side = -1 + spacing * numpy.arange(CELLS)
    one = numpy.ones(CELLS)
    return numpy.vstack(
        [
            numpy.column_stack(pair)
            for pair in ((side, -one), (one, side), (-side, one), (-one, -side))
        ]
    )


def inside(spacing):
    """Points scattered between disc and square, some way off both: every other row of a lattice
    shifted by half a step, and all moved at random."""
    row = numpy.arange(-1 + spacing, 1, spacing * 0.9)
    x, y = numpy.meshgrid(numpy.arange(-1, 1, spacing), row)
    x[1::2] += spacing / 2
    points = numpy.column_stack([x.ravel(), y.ravel()])
    points += 0.15 * spacing * numpy.random.default_rng(5).uniform(-1, 1, points.shape)
    off_square = numpy.abs(points).max(axis=1) < 1 - 0.5 * spacing
    off_disc = numpy.hypot(*points.T) > RADIUS + 0.6 * spacing
    return points[off_square & off_disc]


def geometry():
    """The cloud: groups rim and square; the rest is fluid."""
    spacing = 2 / CELLS
    circle, normals = rim(spacing)
    frame, fluid = square(spacing), inside(spacing)
    ends = numpy.cumsum([len(circle), len(frame)])
    return scatterd.cloud(
        numpy.vstack([circle, frame, fluid]),
        groups={"rim": numpy.arange(ends[0]), "square": numpy.arange(ends[0], ends[1])},
        normals={"rim": normals},
    )


def main(client, plot, checks):
    cloud, parameters = geometry(), {"R": RADIUS}
    flow = client.solve(
        cloud=cloud,
        parameters=parameters,
        diffusivity=1,
        boundary=[scatterd.dirichlet("square", EXACT), scatterd.neumann("rim", 0)],
        operator=OPERATOR,
        exact=EXACT,
    )
    slope = client.apply(
        cloud=cloud,
        parameters=parameters,
        field=flow.solution,
        operator=OPERATOR,
        exact_gradient=VELOCITY,
    )
    speed = numpy.linalg.norm(slope.gradient, axis=1)
    print(f"{len(flow.points)} points, {flow.diagnostics.neighbours.mean:.1f} neighbours each")
    checks.below("l2 error of the potential", flow.norms.l2, 1.5e-3)
    checks.below("linf error of the potential, rim included", flow.norms.linf_all, 1e-2)
    checks.below("l2 error of the velocity", slope.norms.gradient.l2, 6e-3)
    checks.below("top speed away from 2", abs(speed.max() - 2), 4e-2)
    if plot:
        scatterd.plot(flow, speed, file=plot, label="speed", title="A stream around a hole")


if __name__ == "__main__":
    run(main, __doc__)
