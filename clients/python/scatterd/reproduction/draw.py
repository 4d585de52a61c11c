"""Drawing, shared by the figures of both papers."""

from __future__ import annotations

from typing import Any

import numpy

from ..plotting import label_decades

BLUE, RED, GREEN, GOLD, PURPLE = "#31688e", "#d1495b", "#4a7c59", "#c98a1b", "#7b4b94"
SCHEMES = {
    "ps": (RED, "o", "PS"),
    "ips": (BLUE, "s", "IPS"),
    "ipsn": (GREEN, "^", "ipsn"),
    "lsmps": (GOLD, "D", "lsmps"),
}
SHADES = ("#440154", "#3b528b", "#21918c", "#5ec962", "#c2a500", "#d1495b")


def new(size: tuple[float, float]) -> Any:
    """A figure that needs no screen."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=size, layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def space(figure: Any, place: tuple, title: str, label: str, view: tuple = (28, -60)) -> Any:
    axes = figure.add_subplot(*place, projection="3d")
    axes.set(xlabel="x", ylabel="y", zlabel=label, title=title)
    axes.view_init(*view)
    axes.set_box_aspect((1, 1, 0.75), zoom=0.84)
    return axes


def on_lattice(points: numpy.ndarray, values: numpy.ndarray) -> tuple:
    """x, y and values of a lattice as planes."""
    columns = len(numpy.unique(points[:, 0]))
    return tuple(array.reshape(-1, columns) for array in (points[:, 0], points[:, 1], values))


def surface(figure: Any, place: tuple, title: str, points: numpy.ndarray, values: numpy.ndarray,
            view: tuple = (28, -60)) -> Any:
    """A field on a lattice as a surface."""
    axes = space(figure, place, title, "$\\phi$", view)
    x, y, z = on_lattice(points, values)
    axes.plot_surface(x, y, z, rcount=45, ccount=90, cmap="viridis", linewidth=0.15,
                      edgecolor="#00000050")
    axes.set_box_aspect((numpy.ptp(x), numpy.ptp(y), 0.75), zoom=0.84 / numpy.ptp(x) ** 0.15)
    if numpy.ptp(x) > 1:
        axes.xaxis.labelpad = 12
        axes.set_xticks([-1, -0.5, 0, 0.5, 1])
        axes.set_yticks([0, 0.5, 1])
        axes.set_zticks([0, 1, 2])
    return axes


def rough_surface(figure: Any, place: tuple, title: str, points: numpy.ndarray,
                  values: numpy.ndarray, label: str, limits: tuple | None = None) -> Any:
    """A field on a cloud without order as a surface of triangles."""
    axes = space(figure, place, title, label)
    axes.plot_trisurf(*points.T, values, cmap="viridis", linewidth=0.15, edgecolor="#00000050")
    if limits:
        axes.set_zlim(*limits)
    return axes


def logarithmic(axes: Any, ticks: Any, **names: str) -> None:
    """Both axes logarithmic, with a tick per mesh."""
    axes.set(xscale="log", yscale="log", **names)
    axes.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
    axes.minorticks_off()
    label_decades(axes)
    axes.grid(alpha=0.3)


def legend_below(figure: Any, axes: Any) -> None:
    """One legend for all panels, below them."""
    handles, labels = axes.get_legend_handles_labels()
    figure.legend(handles, labels, loc="upper center", bbox_to_anchor=(0.5, 0), ncols=len(labels))
