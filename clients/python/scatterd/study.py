"""Results of process study: a table with a row per mesh."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Iterator

import numpy

from .plotting import label_decades, new_axes
from .result import Result

if TYPE_CHECKING:
    from matplotlib.axes import Axes

COLOURS = ("#31688e", "#d1495b", "#4a7c59", "#7b4b94", "#c98a1b", "#333333")
MARKERS = "os^Dv*"


class Study(Result):
    """Outputs of process study: table, reference, requests, report."""

    def column(self, name: str) -> numpy.ndarray:
        """A member of all rows, NaN where a row lacks it: column("l2"), column("paper.l2"),
        column("cell_reynolds.0")."""
        return numpy.array([member(row, name) for row in self["table"]])

    def series(self) -> Iterator[tuple[str, list[int]]]:
        """Rows by the value of the parameter that varies, with a label; all rows if none does."""
        varied = next((k for k, v in self.given_parameters().items() if numpy.ndim(v) == 1
                       and k in self["table"][0]), None)
        if varied is None:
            yield "", list(range(len(self["table"])))
            return
        values = self.column(varied)
        for value in dict.fromkeys(values):
            yield f"{varied} = {value:g}", numpy.flatnonzero(values == value).tolist()

    def given_parameters(self) -> dict:
        """Parameters of the request."""
        return self.request_inputs.get("parameters", {})

    def plot(
        self,
        norm: str = "l2",
        *,
        file: str | None = None,
        title: str | None = None,
        label: str | None = None,
        axes: "Axes | None" = None,
    ) -> "Axes":
        """Draws a norm over the meshes on logarithmic axes, each step with its slope, and what the
        paper printed beside it.

        Args:
            norm: member of the rows: l1, l2, linf, linf_all.
            file: where to save the picture (.png, .pdf, .svg).
            title: text above the picture; by default that of the case.
            label: name of the line; by default the value of the parameter that varies, or the
                scheme.
            axes: where to draw; by default a new figure.
        """
        if axes is None:
            axes = new_axes(2, screen=file is None)
        cells, values = self.column("cells"), self.column(norm)
        if not numpy.isfinite(values).any():
            raise ValueError(f"the rows have no {norm}")
        for name, rows in self.series():
            draw_line(axes, cells[rows], values[rows], label or name or norm)
        draw_printed(axes, cells, self.column(f"paper.{norm}"))
        axes.set(xscale="log", yscale="log", xlabel="cells per unit of length", ylabel=norm)
        ticks = sorted(set(cells))
        axes.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
        axes.minorticks_off()
        label_decades(axes)
        axes.grid(alpha=0.3)
        axes.legend()
        axes.set_title(title or self["reference"]["title"] if "reference" in self else title or "")
        if file:
            axes.figure.savefig(file, dpi=150, bbox_inches="tight")
        return axes


def member(row: Any, name: str) -> float:
    """Number at a dotted name within a row."""
    for key in name.split("."):
        if isinstance(row, numpy.ndarray):
            row = row[int(key)] if int(key) < len(row) else numpy.nan
        else:
            row = row.get(key, numpy.nan) if isinstance(row, dict) else numpy.nan
    return float(row) if numpy.ndim(row) == 0 else numpy.nan


def draw_line(axes: "Axes", cells: numpy.ndarray, values: numpy.ndarray, label: str) -> None:
    k = sum(1 for line in axes.lines if line.get_linestyle() == "-")
    colour = COLOURS[k % len(COLOURS)]
    axes.plot(cells, values, color=colour, marker=MARKERS[k % len(MARKERS)], label=label)
    for a in range(len(cells) - 1):
        slope = numpy.log(values[a] / values[a + 1]) / numpy.log(cells[a + 1] / cells[a])
        if numpy.isfinite(slope):
            middle = numpy.sqrt(cells[a] * cells[a + 1]), numpy.sqrt(values[a] * values[a + 1])
            axes.annotate(f"{slope:.2f}", middle, (0, 6), textcoords="offset points",
                          fontsize=8, color=colour, ha="left")


def draw_printed(axes: "Axes", cells: numpy.ndarray, values: numpy.ndarray) -> None:
    if numpy.isfinite(values).any():
        axes.plot(cells, values, "o", markersize=11, markerfacecolor="none",
                  markeredgecolor="#888888", linestyle="none", label="paper")
