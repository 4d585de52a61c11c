"""Pictures of results, by matplotlib."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy
from numpy.typing import ArrayLike

from .lattice import lattice_points
from .result import Result

if TYPE_CHECKING:
    from matplotlib.axes import Axes

FIELDS = ("solution", "laplacian", "value", "number_density", "neighbours", "velocity")
DOTS_UP_TO = 1500  #: more points than this are not drawn over the colours
LINES = ("#31688e", "#d1495b", "#4a7c59", "#c98a1b", "#7b4b94")
WIDE = (2.1, 0.7)  #: a triangle beyond this edge and area, in spacings, may bridge a hole
GAPING = (4.0, 3.0, 2.0)  #: one beyond these edges and this area does


def plot(
    result: Result,
    field: str | ArrayLike | None = None,
    *,
    points: ArrayLike | None = None,
    file: str | None = None,
    title: str | None = None,
    label: str | None = None,
    axes: "Axes | None" = None,
) -> "Axes":
    """Draws a field on its cloud: a line in 1-D, colours in 2-D, coloured points in 3-D.

    Args:
        result: of solve, apply or diagnose.
        field: name of an output, or values [n]; by default the solution, or the first field there
            is. Of a vector [n][d] the length is drawn.
        points: [n][d]; by default those of the result or of its request.
        file: where to save the picture (.png, .pdf, .svg).
        title: text above the picture.
        label: text beside the colours or the axis; by default the name of the field.
        axes: where to draw; by default a new figure.

    Returns:
        The axes, for what you want to add.
    """
    x = points_of(result) if points is None else numpy.asarray(points, dtype=float)
    x = x.reshape(len(x), -1)
    values, name = field_of(result, field)
    if len(values) != len(x):
        raise ValueError(f"field has {len(values)} values for {len(x)} points")
    if axes is None:
        axes = new_axes(x.shape[1], screen=file is None)
    draw = {1: draw_line, 2: draw_plane, 3: draw_space}[x.shape[1]]
    draw(axes, x, values, name if label is None else label)
    if title:
        axes.set_title(title)
    if file:
        axes.figure.savefig(file, dpi=150, bbox_inches="tight")
    return axes


def points_of(result: Result) -> numpy.ndarray:
    """Points of a result, or those its request gave."""
    for name in ("points", "particles"):
        if name in result:
            return result[name]
    cloud = result.request_inputs.get("cloud", {})
    cloud = cloud.get("value", cloud)
    if "points" in cloud:
        return numpy.asarray(cloud["points"], dtype=float)
    if "lattice" in cloud:
        return lattice_points(cloud)
    raise ValueError("the result has no points; give them as points=")


def field_of(result: Result, field: str | ArrayLike | None) -> tuple[numpy.ndarray, str]:
    """Values [n] to draw and their name."""
    if field is None:
        field = next((name for name in FIELDS if name in result), None)
        if field is None:
            raise ValueError("the result has no field to draw; name one as field=")
    name = field if isinstance(field, str) else ""
    if name and name not in result:
        raise ValueError(f"the result has no {name!r}, only {', '.join(result)}")
    values = numpy.asarray(result[field] if isinstance(field, str) else field, dtype=float)
    if values.ndim == 2:
        return numpy.linalg.norm(values, axis=1), f"|{name}|" if name else ""
    return values, name


def new_axes(dim: int, screen: bool) -> "Axes":
    """Axes of a figure of their own; without a screen where a file is all that is wanted."""
    if screen:
        from matplotlib import pyplot

        figure = pyplot.figure(layout="constrained")
    else:
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure

        figure = Figure(figsize=(6.4, 4.8), layout="constrained")
        FigureCanvasAgg(figure)
    return figure.add_subplot(projection="3d" if dim == 3 else None)


def draw_line(axes: "Axes", x: numpy.ndarray, values: numpy.ndarray, name: str) -> None:
    order = numpy.argsort(x[:, 0])
    marker = "." if len(x) <= 200 else ""
    colour = LINES[len(axes.lines) % len(LINES)]
    axes.plot(x[order, 0], values[order], color=colour, marker=marker, linewidth=1.5, label=name)
    axes.grid(alpha=0.3)
    axes.set(xlabel="x", ylabel=name if len(axes.lines) == 1 else "")
    if len(axes.lines) > 1:
        axes.legend()


def draw_plane(axes: "Axes", x: numpy.ndarray, values: numpy.ndarray, name: str) -> None:
    triangles = triangulation(x)
    if triangles is None:
        colours = axes.scatter(x[:, 0], x[:, 1], c=values, s=12, cmap="viridis")
    else:
        colours = axes.tripcolor(triangles, values, shading="gouraud", cmap="viridis")
        if numpy.ptp(values) > 0:
            axes.tricontour(triangles, values, levels=10, colors="white", linewidths=0.5, alpha=0.5)
    if triangles is not None and len(x) <= DOTS_UP_TO:
        axes.plot(x[:, 0], x[:, 1], ".", color="black", markersize=1.5, alpha=0.35)
    beside = axes.inset_axes([1.03, 0, 0.04, 1])  # as high as the cloud, however flat
    axes.figure.colorbar(colours, cax=beside, label=name)
    axes.set(xlabel="x", ylabel="y", aspect="equal")


def triangulation(x: numpy.ndarray) -> Any:
    """Delaunay triangles of a planar cloud but for those outside it; None if there are none."""
    from matplotlib.tri import Triangulation

    try:
        made = Triangulation(x[:, 0], x[:, 1])
    except (RuntimeError, ValueError):
        return None
    outside = bridging(x, made)
    if outside.all():
        return None
    made.set_mask(outside)
    return made


def bridging(x: numpy.ndarray, made: Any) -> numpy.ndarray:
    """Which triangles cover what the cloud does not: Delaunay's fill the hull, so also holes and the
    bays of an L.

    A triangle is measured by the spacing s around it, the median over its corners of the median
    length of their edges, so that a cloud may be graded. It is wide if its longest edge is longer
    than WIDE[0] s and its area larger than WIDE[1] s^2. Strewn points have some that are, and
    slivers along the hull have a long edge and no area; both stay. It gapes if its longest edge is
    longer than GAPING[0] times the least of the three medians too (a corner from which a fan of
    triangles spreads over a hole has a large one), and wider than GAPING[1:]. What gapes goes, and
    what is wide and hangs together with it; one gap alone is none.
    """
    corners = made.triangles
    sides = numpy.linalg.norm(x[corners] - x[numpy.roll(corners, 1, axis=1)], axis=2)
    longest, area = sides.max(axis=1), areas(x, corners)
    around = edge_medians(len(x), corners, sides)[corners]
    s, least = numpy.median(around, axis=1), around.min(axis=1)
    wide = (longest > WIDE[0] * s) & (area > WIDE[1] * s**2)
    gaping = (longest > numpy.maximum(GAPING[0] * least, GAPING[1] * s)) & (
        area > GAPING[2] * least * s
    )
    gaping &= beside(made, wide | gaping)
    while True:
        more = wide & ~gaping & beside(made, gaping)
        if not more.any():
            return gaping
        gaping = gaping | more


def beside(made: Any, which: numpy.ndarray) -> numpy.ndarray:
    """Triangles with a neighbour among these."""
    there = made.neighbors  # -1 where there is none
    return ((there >= 0) & which[there]).any(axis=1)


def edge_medians(points: int, corners: numpy.ndarray, sides: numpy.ndarray) -> numpy.ndarray:
    """Median length of the edges at each point [n], each counted once for each triangle at it;
    infinite at a point of no triangle."""
    ends = numpy.concatenate([corners, numpy.roll(corners, 1, axis=1)]).ravel()
    lengths = numpy.concatenate([sides, sides]).ravel()
    order = numpy.lexsort((lengths, ends))
    start = numpy.searchsorted(ends[order], numpy.arange(points + 1))
    middle = (start[:-1] + start[1:] - 1) // 2
    found = lengths[order][numpy.maximum(middle, 0)]
    return numpy.where(numpy.diff(start) > 0, found, numpy.inf)


def areas(x: numpy.ndarray, corners: numpy.ndarray) -> numpy.ndarray:
    a, b = (x[corners[:, k]] - x[corners[:, 0]] for k in (1, 2))
    return numpy.abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]) / 2


def draw_space(axes: "Axes", x: numpy.ndarray, values: numpy.ndarray, name: str) -> None:
    shown = ~nearest_octant(x)
    size = min(60.0, max(1.0, 9000.0 / len(x) ** (2 / 3)))  # dots that nearly touch
    colours = axes.scatter(
        *x[shown].T, c=values[shown], s=size, cmap="viridis", linewidths=0, depthshade=False
    )
    colours.set_clim(values.min(), values.max())
    axes.figure.colorbar(colours, ax=axes, label=name, shrink=0.7, pad=0.1)
    axes.set(xlabel="x", ylabel="y", zlabel="z")
    axes.set_box_aspect(numpy.where(numpy.ptp(x, axis=0) > 0, numpy.ptp(x, axis=0), 1))


def nearest_octant(x: numpy.ndarray) -> numpy.ndarray:
    """Points in the eighth of the box next to the eye, left out to show what is inside."""
    middle = (x.min(axis=0) + x.max(axis=0)) / 2
    return (x[:, 0] > middle[0]) & (x[:, 1] < middle[1]) & (x[:, 2] > middle[2])


def label_decades(axes: "Axes") -> None:
    """Ticks within the decades of a logarithmic y axis that spans few of them."""
    from matplotlib.ticker import FuncFormatter, LogLocator

    low, high = axes.get_ylim()
    if high / low < 500:
        axes.yaxis.set_major_locator(LogLocator(subs=range(1, 10) if high / low < 10 else (1, 2, 5)))
        axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
