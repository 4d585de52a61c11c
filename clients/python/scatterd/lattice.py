"""Coordinates of a lattice cloud, as the service makes them, for those who want them without it."""

from __future__ import annotations

import numpy

GOLDEN = numpy.uint64(0x9E3779B97F4A7C15)


def splitmix64(z: numpy.ndarray) -> numpy.ndarray:
    """The finaliser of SplitMix64 (Steele, Lea and Flood 2014) on unsigned 64-bit numbers."""
    z = (z ^ (z >> numpy.uint64(30))) * numpy.uint64(0xBF58476D1CE4E5B9)
    z = (z ^ (z >> numpy.uint64(27))) * numpy.uint64(0x94D049BB133111EB)
    return z ^ (z >> numpy.uint64(31))


def uniform(seed: int, count: int) -> numpy.ndarray:
    """`count` numbers in [0, 1), number m being a function of seed and m alone."""
    with numpy.errstate(over="ignore"):
        places = numpy.arange(1, count + 1, dtype=numpy.uint64) * GOLDEN
        mixed = splitmix64(numpy.uint64(seed) + places)
    return (mixed >> numpy.uint64(11)) * 2.0**-53


def lattice_points(cloud: dict) -> numpy.ndarray:
    """Coordinates [n][d] of a cloud made by `lattice`, x fastest; bit for bit the service's."""
    box = cloud["lattice"]
    lower, upper = (numpy.asarray(box[key], dtype=float) for key in ("lower", "upper"))
    cells = numpy.asarray(box["cells"]).astype(int)
    dim = len(cells)
    index = numpy.indices(tuple(cells[::-1] + 1)).reshape(dim, -1)[::-1].T
    points = lower + (upper - lower) * index / cells
    points = numpy.where(index == cells, upper, points)
    inner = numpy.all((index > 0) & (index < cells), axis=1)
    chi = uniform(int(box.get("seed", 0)), int(inner.sum()) * dim).reshape(-1, dim)
    points[inner] += box.get("jitter", 0) * (chi - 0.5) * ((upper - lower) / cells)
    return points
