"""Huang, Sheu, Ishikawa and Yamaguchi 2011: Tables 1 to 5, Figures 1, 3, 5, 6, 8 and 9."""

from __future__ import annotations

import math

import numpy

from . import draw
from .parts import Item, Table, ask, quick

PRINTED = "%.3e"
RATE = "%.4f"
UPWIND_3 = {"upwind": "published", "gamma_scale": math.sqrt(0.5)}
UPWIND_4 = {"upwind": "published", "gamma_scale": 4}
WIDE = {name: {"kernel": name, "radius": 2.05} for name in ("bell", "rational", "spiky")}
MESHES = {
    "table 1": (4, 6, 8, 10),
    "table 2": (10, 20, 30, 40, 50),
    "table 3": (60, 70, 80, 90, 100),
    "table 5": (8, 16, 32, 64, 70, 80, 90, 100),
}
# Schemes that the paper compares with, as it cites them.
OTHERS = {
    "DWMA": (3.685e-2, 5.812e-2, 4.993e-2, 2.106e-2),
    "CDS": (9.060e-1, 5.618e-1, 2.873e-1, 9.493e-2),
    "SCHOS": (4.248e-1, 1.670e-1, 3.365e-2, 3.151e-3),
}


# --- Tables ------------------------------------------------------------------------------------


def rates(cells, values):
    """Orders of convergence by the spacing; none for the first row."""
    cells, values = numpy.asarray(cells, float), numpy.asarray(values, float)
    found = numpy.log(values[:-1] / values[1:]) / numpy.log(cells[1:] / cells[:-1])
    return [math.nan, *found]


def printed_rates(study, where):
    column = next(c for c in study.reference.columns if c["where"] == where)
    return [math.nan, *column.get("rates", [math.nan] * (len(study.table) - 1))]


def side_by_side(id, title, studies):
    """A table of pairs of columns, the paper's and ours.

    studies: (heading, study, member, name of the paper's column or None for no rates).
    """
    first = studies[0][1]
    table = Table(id, title, ["mesh"], [[mesh(first, row)] for row in first.table])
    for heading, study, member, where in studies:
        ours = study.column(member)
        append(table, f"{heading}, paper", study.column(f"paper.{member}"), PRINTED)
        corrected = next((c["corrected"] for c in study.reference.columns
                          if "corrected" in c and c["member"] == member), None)
        if corrected is not None:
            append(table, f"{heading}, paper corrected", corrected, PRINTED)
        append(table, heading, ours, PRINTED)
        if where:
            append(table, f"rate, {heading}, paper", printed_rates(study, where), RATE)
            append(table, f"rate, {heading}", rates(study.column("cells"), ours), RATE)
    return table


def mesh(study, row):
    points = row.cells + 1 if study.reference["case"] == "laplace" else row.cells
    return f"{points}x{points}"


def append(table, name, values, format):
    table.columns.append(name)
    table.formats[name] = format
    for row, value in zip(table.rows, values):
        row.append(float(value))


def kernels(case, meshes, **parameters):
    asks = {name: ask(case, meshes, operator=own, **parameters) for name, own in WIDE.items()}
    return {**asks, "center": ask(case, meshes, **parameters)}


def table_of_kernels(id, title, rate=None):
    def make(found):
        studies = [(name, found[name], "l2", None) for name in WIDE]
        return [side_by_side(id, title, [*studies, ("center", found["center"], "l2", rate)])]
    return make


def table_3(found):
    return [side_by_side("h11-table-3", "L2 norms, mu = 1e-2",
                         [("center", found["center"], "l2", None),
                          ("upwind", found["upwind"], "l2", "Table 3, upwind")])]


def table_4(found):
    return [side_by_side("h11-table-4", "Gartland problem, L2 norms",
                         [("center", found["center"], "l2", None),
                          ("upwind", found["upwind"], "l2", "Table 4, upwind")])]


def table_5(found):
    table = side_by_side("h11-table-5", "Gartland problem, maximum norms",
                         [("center", found["center"], "linf_all", "Table 5, center"),
                          ("upwind", found["upwind"], "linf_all", "Table 5, upwind"),
                          ("upwind, L2", found["upwind"], "l2", "Table 5, upwind, L2 norm")])
    for name, values in OTHERS.items():
        append(table, f"{name}, paper", [*values, *[math.nan] * 4], PRINTED)
    return [table]


# --- Figures -----------------------------------------------------------------------------------


def lattice_data(id, title, fields):
    """A table of fields on the points they share: not for the page."""
    points = next(iter(fields.values())).points
    names = ["x", "y", *fields]
    rows = numpy.column_stack([points, *(result.solution for result in fields.values())])
    return Table(id, title, names, rows.tolist(), shown=False)


def center_kernel(q):
    s = math.sqrt(2)
    z = 512 * s - 745
    a, c, d, e = (480 * s - 705) / z, (1515 - 960 * s) / z, -210 / z, (480 * s - 600) / z
    return numpy.where(q < 1, a + c * q**2 + d * q**3 + e * q**4, 0)


def kernel_slope(q):
    s = math.sqrt(2)
    z = 512 * s - 745
    c, d, e = (1515 - 960 * s) / z, -210 / z, (480 * s - 600) / z
    return numpy.where(q < 1, 2 * c * q + 3 * d * q**2 + 4 * e * q**3, 0)


def figure_1_data(found):
    q = numpy.linspace(-1, 1, 81)
    rows = numpy.column_stack([q, center_kernel(abs(q))])
    return [Table("h11-figure-1", "Center-type kernel, r_e = 1", ["r/r_e", "w"], rows.tolist(),
                  shown=False)]


def figure_1(figure, found):
    q = numpy.linspace(-1, 1, 201)
    left = figure.add_subplot(1, 2, 1)
    left.plot(q, center_kernel(abs(q)), color=draw.BLUE)
    left.set(xlabel="$r/r_e$", ylabel="$w\\,r_e$", title="(a) along a line")
    left.grid(alpha=0.3)
    side = numpy.linspace(-1, 1, 61)
    x, y = numpy.meshgrid(side, side)
    right = draw.space(figure, (1, 2, 2), "(b) in the plane", "$w\\,r_e$")
    right.plot_surface(x, y, center_kernel(numpy.hypot(x, y)), cmap="viridis", linewidth=0)


def figure_2(figure, found):
    """W = w + B of eqs. 23-28 for u = v = 1, h = r_e / 2, on the line along u."""
    axes = figure.add_subplot()
    q = numpy.linspace(-1, 1, 401)
    for k, (peclet, values) in enumerate(upwind_kernels(q).items()):
        axes.plot(q, values, color=draw.SHADES[k], label=f"Pe = {peclet:g}")
    axes.set(xlabel="$r/r_e$ along the velocity (upstream is left)", ylabel="$W\\,r_e$")
    axes.grid(alpha=0.3)
    axes.legend()


def upwind_kernels(q):
    def beta(gamma):
        return 1 / math.tanh(gamma) - 1 / gamma if gamma > 0 else 0.0
    step = center_kernel(0.5) / kernel_slope(0.5)
    return {pe: center_kernel(abs(q))
            - beta(pe / 2) * step * kernel_slope(abs(q)) * numpy.sign(q)
            for pe in (0, 0.01, 0.1, 1, 10)}


def figure_2_data(found):
    q = numpy.linspace(-1, 1, 81)
    found = upwind_kernels(q)
    rows = numpy.column_stack([q, *found.values()])
    names = ["r/r_e", *(f"W at Pe {pe:g}" for pe in found)]
    return [Table("h11-figure-2", "Upwind-type kernel", names, rows.tolist(), shown=False)]


def smooth_exact(x, y, mu):
    return numpy.expm1((x - 1) / mu) * numpy.expm1((y - 1) / mu) / numpy.expm1(-1 / mu) ** 2


def figure_3_data(found):
    table = lattice_data("h11-figure-3", "Solution at mu = 1e4", found)
    table.columns.append("exact")
    for row in table.rows:
        row.append(float(smooth_exact(row[0], row[1], 1e4)))
    return [table]


def figure_3(figure, found):
    result = found["predicted"]
    x, y = result.points.T
    draw.surface(figure, (1, 2, 1), "exact", result.points, smooth_exact(x, y, 1e4))
    draw.surface(figure, (1, 2, 2), "predicted", result.points, result.solution)


def figure_5_data(found):
    return [lattice_data("h11-figure-5", "Smith-Hutton problem, mu = 1e-4", found)]


def figure_5(figure, found):
    titles = {"center": "(a) center-type", "upwind": "(b) upwind-type"}
    for k, (name, title) in enumerate(titles.items()):
        low = f"least value {found[name].solution.min():.1e}"
        draw.surface(figure, (1, 2, k + 1), f"{title}\n{low}", found[name].points,
                     found[name].solution, view=(32, -62))


def figure_6_data(found):
    profiles = [found[name].table[0].profile for name in found]
    rows = numpy.column_stack([profiles[0]["x"], *(profile["value"] for profile in profiles)])
    return [Table("h11-figure-6", "Smith-Hutton problem along y = 0.5", ["x", *found],
                  rows.tolist(), shown=False),
            bounds_table("h11-figure-6-bounds", found)]


def bounds_table(id, found):
    rows = [[name, row.bounds["min"], row.bounds["max"]]
            for name, study in found.items() for row in study.table]
    return Table(id, "Smallest and largest value (of the data: 4e-9 and 2)",
                 ["kernel", "min", "max"], rows, {"min": "%.2e", "max": "%.7g"})


def figure_6(figure, found):
    left, right = figure.subplots(1, 2)
    styles = {"center": (draw.RED, "-"), "upwind": (draw.BLUE, "-"), "exact": (draw.GREEN, "--"),
              "cosine": (draw.GOLD, ":")}
    names = {"center": "center-type", "upwind": "upwind-type (published)",
             "exact": "upwind by eqs. 23-28 (exact)", "cosine": "upwind cosine"}
    for section, axes in (("profile", left), ("outlet", right)):
        for name, study in found.items():
            line = study.table[0][section]
            colour, style = styles[name]
            axes.plot(line["x"], line["value"], style, color=colour, label=names[name])
        axes.set(xlabel="x", ylabel="$\\phi$")
        axes.grid(alpha=0.3)
    left.set_title("along y = 0.5")
    right.set_title("along the outlet, y = 0")
    left.set_xticks([-1, -0.5, 0, 0.5, 1])
    foot = left.inset_axes([0.13, 0.5, 0.25, 0.42])
    for name in ("center", "upwind"):
        line = found[name].table[0].profile
        foot.plot(line["x"], line["value"], color=styles[name][0])
    foot.set(xlim=(0.3, 0.9), ylim=(-0.015, 0.05))
    foot.tick_params(labelsize=7)
    foot.grid(alpha=0.3)
    draw.legend_below(figure, right)


def figure_8_data(found):
    rows = [[f"{row.mu:g}", name, row.bounds["min"], row.bounds["max"]]
            for name in ("published", "exact", "none") for row in found[name].table]
    table = Table("h11-figure-8", "Smallest and largest value (of the data: 0 and 1)",
                  ["mu", "upwind", "min", "max"], rows, {"min": "%.1e", "max": "%.4f"})
    fields = {"mu 1e-3": found["a"], "mu 1e-5": found["b"]}
    return [table, lattice_data("h11-figure-8-fields", "Skew problem, upwind published", fields)]


def figure_8(figure, found):
    for k, (name, mu) in enumerate((("a", "10^{-3}"), ("b", "10^{-5}"))):
        title = f"({name}) $\\mu = {mu}$"
        draw.surface(figure, (1, 2, k + 1), title, found[name].points, found[name].solution,
                     view=(32, -115))


def gartland_exact(x, y, mu):
    b = 1 / (2 * mu)
    root = math.sqrt(math.pi**2 + b * b)
    c = math.pi**2 / (root + b)
    layer = 2 * (numpy.exp((root + b) * (x - 1)) - numpy.exp(-c * x - root - b))
    decay = numpy.exp(-c * x) - numpy.exp((root + b) * (x - 1) - c)
    return numpy.sin(math.pi * y) * (layer + decay) / -math.expm1(-2 * root)


def figure_9_data(found):
    table = lattice_data("h11-figure-9", "Gartland problem, mu = 1e-2, 100 cells", found)
    table.columns.append("exact")
    for row in table.rows:
        row.append(float(gartland_exact(row[0], row[1], 1e-2)))
    return [table]


def figure_9(figure, found):
    result = found["predicted"]
    axes = figure.add_subplot(1, 2, 1)
    x, y, values = draw.on_lattice(result.points, result.solution)
    fine = numpy.meshgrid(numpy.linspace(0.8, 1, 401), numpy.linspace(0, 1, 401))
    levels = numpy.linspace(0.1, 1.9, 10)
    exact = axes.contour(*fine, gartland_exact(*fine, 1e-2), levels, colors="black", linewidths=1)
    axes.clabel(exact, levels[:5], fontsize=8, fmt="%.1f")
    axes.contour(x, y, values, levels, colors=draw.RED, linewidths=1, linestyles="dashed")
    axes.plot([], [], color="black", linewidth=1, label="exact")
    axes.plot([], [], color=draw.RED, linewidth=1, linestyle="dashed", label="predicted")
    axes.set(xlabel="x", ylabel="y", title="(a) contours of $\\phi$", xlim=(0.8, 1), ylim=(0, 1))
    axes.legend(loc="center left", fontsize=8, ncols=2)
    draw.surface(figure, (1, 2, 2), "(b) predicted", result.points, result.solution,
                 view=(30, -125))


def smith_hutton(upwind):
    return ask("smith-hutton", (40,), operator={"upwind": upwind})


ITEMS = [
    quick("h11-table-1", "Table 1: Laplace equation, L2 norms",
          "The meshes count points. bell, rational and spiky agree in every digit; the paper's center "
          "column has kernel constants of single precision and is off in the third digit on fine "
          "meshes, so what double precision gives stands beside it. The paper's rates take "
          "ln(7/5), ln(9/7) and ln(11/9) for the ratio of the spacings; by the spacings, 1/4, 1/6, "
          "1/8 and 1/10, the order is 6, not \"due possibly to machine error\": on harmonic functions "
          "the nine-point stencil is of sixth order.",
          kernels("laplace", MESHES["table 1"]),
          table_of_kernels("h11-table-1", "Laplace equation, L2 norms", "Table 1, center")),
    quick("h11-table-2", "Table 2: mu = 1e4, L2 norms",
          "The center column is near rounding, so no digits can agree: below 5e-14 is as good. At 10 "
          "cells the truncation error of eqs. 5 and 7 alone is 1.53e-13, above the printed number. "
          "Rational at 20 cells is 4.3527e-4, printed 4.352e-4. A second program, in numpy and with "
          "another solver, gives both numbers as scatterd does.",
          kernels("smooth", MESHES["table 2"], mu=1e4),
          table_of_kernels("h11-table-2", "mu = 1e4, L2 norms")),
    quick("h11-table-3", "Table 3: mu = 1e-2, L2 norms",
          "The upwind column is made with upwind `published`, gamma_scale 1/sqrt 2. Last digits that "
          "cannot be had: center at 90 and 100 cells (7.8273e-3, 6.2625e-3) and upwind at 100 cells "
          "(5.7874e-3); a second program, in numpy and with another solver, gives them as scatterd "
          "does.",
          {"center": ask("smooth", MESHES["table 3"]),
           "upwind": ask("smooth", MESHES["table 3"], operator=UPWIND_3)},
          table_3),
    quick("h11-table-4", "Table 4: Gartland problem, L2 norms",
          "Upwind `published`, gamma_scale 4. The exact solution has l = sqrt(pi^2 + 1/(4 mu^2)): the "
          "paper lacks the root.",
          {"center": ask("gartland", MESHES["table 3"]),
           "upwind": ask("gartland", MESHES["table 3"], operator=UPWIND_4)},
          table_4),
    quick("h11-table-5", "Table 5: Gartland problem, maximum norms",
          "The paper's DWMA, CDS and SCHOS are other authors' schemes, for comparison.",
          {"center": ask("gartland", MESHES["table 5"]),
           "upwind": ask("gartland", MESHES["table 5"], operator=UPWIND_4)},
          table_5),
    Item("h11-figure-1", "Figure 1: center-type kernel", "Drawn from eq. 19.", {}, figure_1_data,
         figure_1),
    Item("h11-figure-2", "Figure 2: upwind-type kernel",
         "Drawn from eqs. 23-28, along the direction of the velocity.", {}, figure_2_data, figure_2,
         size=(6.4, 4.2)),
    Item("h11-figure-3", "Figure 3: solution at mu = 1e4",
         "The caption says Pe = 1e-3; the text, and u h / mu at 10 cells, say 1e-5.",
         {"predicted": ask("smooth", (10,), kind="field", mu=1e4)}, figure_3_data, figure_3),
    Item("h11-figure-5", "Figure 5: Smith-Hutton problem, mu = 1e-4, h = 1/40",
         "The center-type solution has wiggles behind the front, the upwind-type one none.",
         {name: ask("smith-hutton", (40,), kind="field", operator={"upwind": upwind})
          for name, upwind in (("center", "none"), ("upwind", "published"))},
         figure_5_data, figure_5),
    quick("h11-figure-6", "Figure 6: Smith-Hutton problem along y = 0.5",
          "`published` damps just enough here; the scheme as derived in eqs. 23-28 (upwind exact) "
          "keeps the bounds too, and is more diffusive. The outlet stands beside it.",
          {"center": smith_hutton("none"), "upwind": smith_hutton("published"),
           "exact": smith_hutton("exact"), "cosine": smith_hutton("cosine")},
          figure_6_data, figure_6),
    quick("h11-figure-8", "Figure 8: skew problem, 21 x 21 points",
          "\"No oscillatory solution is found\": `published` over- and undershoots by up to 2 per "
          "cent at 45 degrees (the paper does not print its angle), against 7 per cent of the "
          "center-type kernel; `exact` keeps the bounds.",
          {**{name: ask("skew", (20,), operator={"upwind": name}, mu=(1e-3, 1e-5))
              for name in ("published", "exact", "none")},
           "a": ask("skew", (20,), kind="field", mu=1e-3),
           "b": ask("skew", (20,), kind="field", mu=1e-5)},
          figure_8_data, figure_8),
    Item("h11-figure-9", "Figure 9: Gartland problem, mu = 1e-2", "Upwind `published`, 100 cells.",
         {"predicted": ask("gartland", (100,), kind="field", operator=UPWIND_4)},
         figure_9_data, figure_9),
]
