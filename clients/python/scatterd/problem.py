"""Pieces of a request: clouds and boundary conditions."""

from __future__ import annotations

from typing import Any, Mapping, Sequence, Union

import numpy
from numpy.typing import ArrayLike

Field = Union[float, str, ArrayLike]  #: number, expression, or one value per point
Points = Union[str, Sequence[int], numpy.ndarray]  #: name of a group, numbers, or a mask [n]


def lattice(
    lower: ArrayLike, upper: ArrayLike, cells: ArrayLike, jitter: float = 0, seed: int = 0
) -> dict:
    """A lattice cloud on the box from `lower` to `upper` (length) with `cells` cells per side.

    A number stands for the same in every dimension: lattice([0, 0], [1, 1], 64). Inner points are
    moved at random by up to jitter / 2 steps, the same way for the same seed. Points are numbered
    x fastest; groups left, right, bottom, top, back, front, boundary and interior exist.
    """
    sides = [numpy.atleast_1d(side) for side in (lower, upper, cells)]
    lower, upper, cells = (side.tolist() for side in numpy.broadcast_arrays(*sides))
    box = {"lower": lower, "upper": upper, "cells": cells, "jitter": jitter, "seed": seed}
    return {"lattice": box}


def cloud(
    points: ArrayLike,
    groups: Mapping[str, Points] | None = None,
    normals: Mapping[str, ArrayLike] | None = None,
    spacing: float | None = None,
) -> dict:
    """A cloud of `points` [n][d], or [n] in one dimension (length).

    `groups` names sets of points, by numbers or masks [n]; `normals` gives groups their outward
    normal, [d] or one per point of the group [m][d]; `spacing` (length) is the unit of support
    radii, by default the median distance to the nearest neighbour.
    """
    points = numpy.asarray(points, dtype=float)
    made: dict[str, Any] = {"points": points[:, None] if points.ndim == 1 else points}
    if groups:
        made["groups"] = {name: numbers(group) for name, group in groups.items()}
    if normals:
        made["normals"] = {name: numpy.asarray(n, dtype=float) for name, n in normals.items()}
    if spacing is not None:
        made["spacing"] = float(spacing)
    return made


def numbers(points: Points) -> Any:
    """Point numbers of a group: a name stays, a mask becomes numbers."""
    if isinstance(points, str):
        return points
    array = numpy.asarray(points)
    if array.dtype == bool:
        return numpy.flatnonzero(array).astype(numpy.int32)
    return array if array.size else []


def dirichlet(on: Points, value: Field) -> dict:
    """phi = value on a group or points."""
    return {"on": numbers(on), "type": "dirichlet", "value": value}


def neumann(on: Points, value: Field, normal: ArrayLike | None = None) -> dict:
    """d phi / dn = value (phi / length); `normal` by default that of the group."""
    return with_normal({"on": numbers(on), "type": "neumann", "value": value}, normal)


def robin(
    on: Points, coefficient: Field, value: Field, normal: ArrayLike | None = None
) -> dict:
    """coefficient phi + d phi / dn = value, coefficient in 1 / length."""
    entry = {"on": numbers(on), "type": "robin", "coefficient": coefficient, "value": value}
    return with_normal(entry, normal)


def with_normal(entry: dict, normal: ArrayLike | None) -> dict:
    return entry if normal is None else {**entry, "normal": numpy.asarray(normal, dtype=float)}
