"""Hwang, Ng and Sheu 2016: Figures 1 to 19, and the statements made of them."""

from __future__ import annotations

import math

import numpy

from ..plotting import points_of
from . import draw
from .parts import Item, Table, ask, quick

ALPHAS = (0.1, 0.3, 0.5)
MANY_ALPHAS = (0, 0.05, 0.1, 0.2, 0.3, 0.4, 0.5)
PHIS = (2.0, 0.5, -0.5, -2.0)
STEPS = (0.25, 0.5, 1)  # C_D
SCHEMES = ("ps", "ips", "lsmps")
IN_TIME = ("ps", "ips", "ipsn", "lsmps")
AXES = "uvw"
# Per dimension: meshes and clouds of the operator statistics, and which meshes are a sample; mesh and
# clouds of those against alpha; meshes and clouds of the errors in time, and a sample; the paper's
# mesh for these.
OPERATOR = {1: ((8, 16, 32, 64, 128, 256), 50), 2: ((8, 16, 32, 64, 128, 256), 10),
            3: ((8, 16, 32, 64), 3)}
OPERATOR_SAMPLE = {1: (8, 16, 32, 64), 2: (8, 16, 32), 3: (8, 16)}
AGAINST_ALPHA = {1: (128, 50), 2: (128, 5), 3: (64, 2)}
TIME = {1: ((16, 32, 64, 128), 10), 2: ((16, 32, 64, 128), 3), 3: ((8, 16, 32), 2)}
TIME_SAMPLE = {1: (16, 32), 2: (16,), 3: (8,)}
PAPER_MESH = {1: 128, 2: 64, 3: 32}
TIMES = {1: (0.01, 0.02, 0.05, 0.1, 0.5), 2: (0.005, 0.01, 0.02, 0.05, 0.2),
         3: (0.005, 0.01, 0.02, 0.05, 0.1)}
FIGURES = {  # numbers of the figures of operator statistics, operator error, errors in time
    1: ("3 and 4", "5", "7"), 2: ("8", "13", "14"), 3: ("16", "18", "19")}


def scheme(name):
    return {"scheme": name}


def rows_with(study, **values):
    """Rows of a study with these values, in order."""
    return [row for row in study.table
            if all(math.isclose(row[name], value, abs_tol=1e-12) for name, value in values.items())]


# --- Figure 1: three points ---------------------------------------------------------------------


def three_point_asks():
    return {f"{name} {phi:g}": ask("three-point", operator=scheme(name), phi=phi,
                                   alpha=tuple(k / 20 for k in range(11)))
            for name in ("ps", "ips") for phi in PHIS}


def three_point_table(found):
    table = Table("h16-three-point", "Laplacian at x = 0 and its reality factor",
                  ["phi*", "alpha", "exact", "PS", "IPS", "reality PS", "reality PS, eq. 33a",
                   "reality IPS", "reality IPS, eq. 33b"], [],
                  {name: "%.6f" for name in ("exact", "PS", "IPS", "reality PS", "reality IPS",
                                             "reality PS, eq. 33a", "reality IPS, eq. 33b")})
    for phi in PHIS:
        pairs = zip(found[f"ps {phi:g}"].table, found[f"ips {phi:g}"].table)
        for k, (ps, ips) in enumerate(pairs):
            if k % 2 == 0:
                table.rows.append([phi, ps.alpha, ps.exact_laplacian, ps.laplacian, ips.laplacian,
                                   ps.get("reality_factor"), ps.reality_factor_ps_series,
                                   ips.get("reality_factor"), ips.reality_factor_ips])
    return [table]


def figure_1(figure, found):
    left, right = figure.subplots(1, 2)
    for k, phi in enumerate(PHIS):
        colour = draw.SHADES[k]
        ps, ips = (found[f"{name} {phi:g}"] for name in ("ps", "ips"))
        alpha = ps.column("alpha")
        left.plot(alpha, ps.column("exact_laplacian"), color=colour, label=f"$\\phi^*$ = {phi:g}")
        left.plot(alpha, ps.column("laplacian"), "o", color=colour, markerfacecolor="none")
        left.plot(alpha, ips.column("laplacian"), "+", color=colour)
        right.plot(alpha, ps.column("reality_factor"), "o", color=colour, markerfacecolor="none",
                   label=f"PS, $\\phi^*$ = {phi:g}")
        right.plot(alpha, ps.column("reality_factor_ps_series"), "--", color=colour, linewidth=1)
    right.plot(alpha, ips.column("reality_factor"), "+-", color="black", label="IPS, every $\\phi^*$")
    left.plot([], [], "o", color="black", markerfacecolor="none", label="PS")
    left.plot([], [], "+", color="black", label="IPS")
    right.plot([], [], "--", color="black", linewidth=1, label="eq. 33a")
    left.set(xlabel="$\\alpha$", ylabel="$\\phi_{xx}$ at x = 0", title="(a) Laplacian (lines: exact)")
    right.set(xlabel="$\\alpha$", ylabel="reality factor", title="(b) over the exact one",
              ylim=(-2, 3))
    for axes in (left, right):
        axes.grid(alpha=0.3)
        axes.legend(fontsize=8, loc="lower left")


# --- Figure 2: one cloud in one dimension -------------------------------------------------------


def one_cloud(kind, name, cells, dim=1):
    return ask(f"sine-{dim}d", (cells,), kind=kind, operator=scheme(name), seed=1, seeds=1)


def figure_2_asks():
    asks = {f"{name} {n}": one_cloud("field", name, n) for name in ("ps", "ips") for n in (8, 16)}
    return {**asks, **{f"cloud {n}": one_cloud("diagnose", "ps", n) for n in (8, 16)}}


def figure_2_lines(found, n):
    """x, PS and IPS normalised, and what eq. 36 makes of PS."""
    x = points_of(found[f"ps {n}"])[:, 0]
    k = 2 * math.pi
    velocity = found[f"cloud {n}"].artificial_velocity[:, 0]
    estimate = (velocity * k * numpy.cos(k * x) - k * k * numpy.sin(k * x)) / k**2
    inside = slice(1, -1)  # the points that carry the equation
    ps, ips = (found[f"{name} {n}"].laplacian / k**2 for name in ("ps", "ips"))
    return x[inside], ps[inside], ips[inside], estimate[inside]


def figure_2_data(found):
    rows = [[n, *row] for n in (8, 16) for row in zip(*figure_2_lines(found, n))]
    names = ["n_C", "x", "PS", "IPS", "PS by eq. 36"]
    return [Table("h16-figure-2", "Laplacian over (2 pi)^2", names, rows, shown=False)]


def figure_2(figure, found):
    left, right = figure.subplots(1, 2)
    x = numpy.linspace(0, 1, 201)
    for axes in (left, right):
        axes.plot(x, -numpy.sin(2 * math.pi * x), color="black", linewidth=1, label="exact")
    for n, shade in ((8, draw.GOLD), (16, draw.BLUE)):
        x, ps, ips, estimate = figure_2_lines(found, n)
        left.plot(x, ps, "o--", color=shade, markerfacecolor="none", label=f"PS, $n_C$ = {n}")
        left.plot(x, ips, "+-", color=shade, label=f"IPS, $n_C$ = {n}")
        right.plot(x, ps, "o", color=shade, markerfacecolor="none", label=f"PS, $n_C$ = {n}")
        right.plot(x, estimate, "x--", color=shade, label=f"eq. 36, $n_C$ = {n}")
    left.set(title="(a) PS and IPS")
    right.set(title="(b) PS and its estimate by eq. 36")
    for axes in (left, right):
        axes.set(xlabel="x", ylabel="Laplacian$/(2\\pi)^2$")
        axes.grid(alpha=0.3)
        axes.legend(fontsize=8)


# --- Statistics of the operators ----------------------------------------------------------------


def operator_asks(dim, meshes=None, schemes=SCHEMES):
    clouds = OPERATOR[dim][1]
    return {name: ask(f"sine-{dim}d", meshes or OPERATOR[dim][0], operator=scheme(name),
                      alpha=ALPHAS, seeds=clouds) for name in schemes}


def against_alpha_asks(dim):
    mesh, clouds = AGAINST_ALPHA[dim]
    return {f"{name} alpha": ask(f"sine-{dim}d", (mesh,), operator=scheme(name), alpha=MANY_ALPHAS,
                                 seeds=clouds) for name in SCHEMES}


def shear(row, dim):
    """Root mean square of tau_xy; none in one dimension."""
    return row.effective_diffusivity["rms_deviation"][dim] if dim > 1 else None


def operator_table(dim):
    def make(found):
        names = ["alpha", "n_C", "Re_u", "Re_u / alpha", "1 - mean tau_xx", "rms (1 - tau_xx)"]
        table = Table(f"h16-operator-{dim}d", f"Operators on jittered clouds in {dim}-D, means over "
                      f"{OPERATOR[dim][1]} clouds", names + (["rms tau_xy"] if dim > 1 else [])
                      + [f"error {name}" for name in SCHEMES], [])
        for rows in zip(*(found[name].table for name in SCHEMES)):
            ips = rows[1]
            tensor = ips.effective_diffusivity
            row = [ips.alpha, ips.cells, ips.cell_reynolds[0], ips.cell_reynolds[0] / ips.alpha,
                   1 - tensor["mean"][0], tensor["rms_deviation"][0]]
            table.rows.append(row + ([shear(ips, dim)] if dim > 1 else [])
                              + [one.l2 for one in rows])
        return [table]
    return make


def alpha_table(dim):
    def make(found):
        mesh = AGAINST_ALPHA[dim][0]
        names = ["alpha", "Re_u", "1 - mean tau_xx", "rms (1 - tau_xx)", "rms tau_xy",
                 *(f"error {name}" for name in SCHEMES)]
        table = Table(f"h16-alpha-{dim}d", f"Operators against alpha, n_C = {mesh}", names, [],
                      shown=False)
        for rows in zip(*(found[f"{name} alpha"].table for name in SCHEMES)):
            tensor = rows[1].effective_diffusivity
            table.rows.append([rows[1].alpha, rows[1].cell_reynolds[0], 1 - tensor["mean"][0],
                               tensor["rms_deviation"][0], shear(rows[1], dim),
                               *(one.l2 for one in rows)])
        return [table]
    return make


def over_meshes(axes, study, value, style="o-", label="{alpha}"):
    """A line per alpha of value(row) over the meshes."""
    for k, alpha in enumerate(ALPHAS):
        rows = rows_with(study, alpha=alpha)
        axes.plot([row.cells for row in rows], [value(row) for row in rows], style,
                  color=draw.SHADES[2 * k], label=label.format(alpha=f"$\\alpha$ = {alpha}"))


def statistics_figure(dim):
    """Cell Reynolds number, normal and shear part of the effective diffusivity over the meshes."""
    def make(figure, found):
        ips = found["ips"]
        panels = figure.subplots(1, 3 if dim > 1 else 2)
        for k, marker in zip(range(dim), ("o-", "s--", "^:")):
            over_meshes(panels[0], ips, lambda row, k=k: row.cell_reynolds[k], marker,
                        "{alpha}" if k == 0 else "_")
        over_meshes(panels[1], ips, lambda row: 1 - row.effective_diffusivity["mean"][0])
        over_meshes(panels[1], ips, lambda row: row.effective_diffusivity["rms_deviation"][0],
                    "s--", "_")
        components = f" ({', '.join(AXES[:dim])})" if dim > 1 else ""
        panels[0].set_title(f"(a) cell Reynolds number{components}")
        panels[1].set_title("(b) $1-\\tau_{xx}$: mean (—), rms (- -)")
        if dim > 1:
            over_meshes(panels[2], ips, lambda row: shear(row, dim), "s--")
            panels[2].set_title("(c) $\\tau_{xy}$: rms")
        for axes in panels:
            draw.logarithmic(axes, OPERATOR[dim][0], xlabel="$n_C$")
        draw.legend_below(figure, panels[0])
    return make


def velocity_figure(figure, found):
    left, right = figure.subplots(1, 2)
    over_meshes(left, found["ips"], lambda row: row.cell_reynolds[0] * row.cells)
    over_meshes(right, found["ips"], lambda row: row.cell_reynolds[0])
    left.set_title("(a) artificial velocity $V_N$")
    right.set_title("(b) artificial cell Reynolds number")
    for axes in (left, right):
        draw.logarithmic(axes, OPERATOR[1][0], xlabel="$n_C$")
    draw.legend_below(figure, left)


def diffusivity_figure(figure, found):
    axes = figure.add_subplot()
    over_meshes(axes, found["ips"], lambda row: row.effective_diffusivity["mean"][0], "o-",
                "{alpha}, mean")
    over_meshes(axes, found["ips"],
                lambda row: 1 - row.effective_diffusivity["rms_deviation"][0], "s--",
                "{alpha}, 1 - rms deviation")
    axes.axhline(0.96, color="black", linewidth=1, linestyle=":", label="the paper's 4 %")
    axes.set(xscale="log", xlabel="$n_C$", ylabel="effective diffusivity of IPS")
    axes.set_xticks(OPERATOR[1][0], [str(n) for n in OPERATOR[1][0]])
    axes.minorticks_off()
    axes.grid(alpha=0.3)
    axes.legend(fontsize=8, loc="center left", bbox_to_anchor=(1.02, 0.5))


def error_figure(dim):
    """Error of the Laplacian over the meshes (alpha = 0.3) and over alpha."""
    def make(figure, found):
        left, right = figure.subplots(1, 2)
        for name in SCHEMES:
            colour, marker, label = draw.SCHEMES[name]
            rows = rows_with(found[name], alpha=0.3)
            left.plot([row.cells for row in rows], [row.l2 for row in rows], marker + "-",
                      color=colour, label=label)
            study = found[f"{name} alpha"]
            right.plot(study.column("alpha"), study.column("l2"), marker + "-", color=colour,
                       label=label)
        draw.logarithmic(left, OPERATOR[dim][0], xlabel="$n_C$", ylabel="error of the Laplacian",
                         title="(a) $\\alpha$ = 0.3")
        right.set(yscale="log", xlabel="$\\alpha$", ylabel="error of the Laplacian",
                  title=f"(b) $n_C$ = {AGAINST_ALPHA[dim][0]}")
        right.grid(alpha=0.3)
        left.legend()
    return make


def against_alpha_figure(figure, found):
    """Figure 17."""
    axes = figure.add_subplot()
    study = found["ips alpha"]
    alpha = study.column("alpha")
    lines = {
        "$Re_u$ of PS": (study.column("cell_reynolds.0"), draw.RED, "o-"),
        "$1-\\tau_{xx}$, mean": (1 - study.column("effective_diffusivity.mean.0"), draw.BLUE, "s-"),
        "$1-\\tau_{xx}$, rms": (study.column("effective_diffusivity.rms_deviation.0"), draw.BLUE,
                                "s--"),
        "$\\tau_{xy}$, rms": (study.column("effective_diffusivity.rms_deviation.3"), draw.GREEN,
                              "^--"),
    }
    for label, (values, colour, style) in lines.items():
        axes.plot(alpha[1:], values[1:], style, color=colour, label=label)
    axes.set(yscale="log", xlabel="$\\alpha$", title="$n_C$ = 64, 3-D")
    axes.grid(alpha=0.3)
    axes.legend()


# --- Figures 9 to 12: the Laplacian in the plane ------------------------------------------------


def plane_asks():
    return {f"{name} {n}": one_cloud("field", name, n, dim=2) for name in ("ps", "ips")
            for n in (8, 16)}


def plane_data(id, name):
    def make(found):
        rows = [[n, *point, value] for n in (8, 16)
                for point, value in zip(points_of(found[f"{name} {n}"]).tolist(),
                                        found[f"{name} {n}"].laplacian.tolist())]
        return [Table(id, f"Laplacian by {name.upper()}", ["n_C", "x", "y", "laplacian"], rows,
                      shown=False)]
    return make


def plane_figure(name):
    def make(figure, found):
        for k, n in enumerate((8, 16)):
            result = found[f"{name} {n}"]
            draw.rough_surface(figure, (1, 2, k + 1), f"({'ab'[k]}) $n_C$ = {n}", points_of(result),
                               result.laplacian, "$\\nabla^2\\phi$")
    return make


def exact_plane(x, y):
    return -8 * math.pi**2 * numpy.sin(2 * math.pi * x) * numpy.sin(2 * math.pi * y)


def figure_9_data(found):
    side = numpy.linspace(0, 1, 33)
    x, y = (a.ravel() for a in numpy.meshgrid(side, side))
    rows = numpy.column_stack([x, y, exact_plane(x, y)])
    return [Table("h16-figure-9", "Exact Laplacian", ["x", "y", "laplacian"], rows.tolist(),
                  shown=False)]


def figure_9(figure, found):
    x, y = numpy.meshgrid(numpy.linspace(0, 1, 65), numpy.linspace(0, 1, 65))
    axes = draw.space(figure, (1, 1, 1), "", "$\\nabla^2\\phi$")
    axes.plot_surface(x, y, exact_plane(x, y), cmap="viridis", linewidth=0)


def figure_10_data(found):
    rows = [[n, *point] for n in (8, 16) for point in points_of(found[f"ps {n}"]).tolist()]
    return [Table("h16-figure-10", "Particles", ["n_C", "x", "y"], rows, shown=False)]


def figure_10(figure, found):
    for axes, n in zip(figure.subplots(1, 2), (8, 16)):
        axes.plot(*points_of(found[f"ps {n}"]).T, "o", color=draw.BLUE, markersize=4)
        axes.set(xlabel="x", ylabel="y", aspect="equal", title=f"$n_C$ = {n}, $\\alpha$ = 0.3")


# --- The heat equation --------------------------------------------------------------------------


def fine_times(dim):
    """Times on a logarithmic scale, the paper's last at the end."""
    return tuple(float(f"{t:.3g}") for t in numpy.geomspace(TIMES[dim][0] / 10, TIMES[dim][-1], 25))


def in_time(dim, name, meshes, clouds=None, **parameters):
    clouds = clouds or TIME[dim][1]
    return ask(f"diffusion-{dim}d", meshes, operator=scheme(name), seeds=clouds, **parameters)


def time_asks(dim):
    mesh = (PAPER_MESH[dim],)
    times, few = fine_times(dim), 2 if dim < 3 else 1
    asks = {f"n {name}": in_time(dim, name, TIME[dim][0][1:], few, times=times)
            for name in ("ps", "ips")}
    asks |= {f"alpha {name}": in_time(dim, name, mesh, few, times=times, alpha=(0.1, 0.2, 0.3, 0.4, 0.5))
             for name in ("ps", "ips")}
    return asks | {f"C_D {name}": in_time(dim, name, mesh, 1, times=times, diffusion_number=STEPS)
                   for name in ("ps", "ips")}


def time_figure_data(dim):
    def make(found):
        rows = []
        for key, study in found.items():
            what, name = key.split(" ")
            member = {"n": "cells", "alpha": "alpha", "C_D": "diffusion_number"}[what]
            for row in study.table:
                rows += [[name, what, row[member], t, error]
                         for t, error in zip(row.history["t"], row.history["l2"])]
        columns = ["scheme", "varies", "value", "t", "error"]
        return [Table(f"h16-time-{dim}d-figure", "Error against time", columns, rows, shown=False)]
    return make


def time_figure(dim):
    panels = {"n": ("cells", "$n_C$"), "alpha": ("alpha", "$\\alpha$"),
              "C_D": ("diffusion_number", "$C_D$")}

    def make(figure, found):
        for letter, axes, (what, (member, label)) in zip(
                "abc", figure.subplots(1, 3, sharey=True), panels.items()):
            for name, style in (("ps", "--"), ("ips", "-")):
                for k, row in enumerate(found[f"{what} {name}"].table):
                    width = 3 - k if what == "C_D" else 1.5  # lines that fall together
                    axes.plot(row.history["t"], row.history["l2"], style, color=draw.SHADES[k],
                              linewidth=width,
                              label=f"{row[member]:g}" if name == "ips" else "_")
            axes.set(xscale="log", yscale="log", xlabel="t", ylabel="error (root mean square)",
                     title=f"({letter}) effect of {label}")
            axes.grid(alpha=0.3)
            axes.legend(title=label, fontsize=8, loc="upper center", bbox_to_anchor=(0.5, -0.16),
                        ncols=5, handlelength=1.2, columnspacing=1)
            axes.label_outer()
        figure.suptitle("PS dashed, IPS drawn through", fontsize=10)
    return make


def time_table_asks(dim, meshes=None):
    return {name: in_time(dim, name, meshes or TIME[dim][0]) for name in IN_TIME}


def time_table(dim):
    def make(found):
        columns = ["n_C", "scheme", *(f"t = {t:g}" for t in TIMES[dim])]
        table = Table(f"h16-time-{dim}d", f"Error in time, alpha = 0.3, C_D = 1, means over "
                      f"{TIME[dim][1]} clouds", columns, [],
                      {name: "%.2e" for name in columns[2:]} | {"n_C": "%d"})
        for rows in zip(*(found[name].table for name in IN_TIME)):
            for name, row in zip(IN_TIME, rows):
                table.rows.append([row.cells, name, *row.history["l2"]])
        return [table]
    return make


def figure_6_asks():
    asks = {f"ps {n}": ask("diffusion-1d", (n,), kind="field", operator=scheme("ps"), seed=1)
            for n in (32, 64, 128)}
    return {**asks, "ips 128": ask("diffusion-1d", (128,), kind="field", operator=scheme("ips"),
                                   seed=1)}


def figure_6_data(found):
    rows = [[key.split()[0], int(key.split()[1]), t, x, value] for key, result in found.items()
            for t, values in zip(result.history.t, result.history.solution)
            for x, value in zip(result.points[:, 0], values)]
    return [Table("h16-figure-6", "Solution in time", ["scheme", "n_C", "t", "x", "phi"], rows,
                  shown=False)]


def figure_6(figure, found):
    left, right = figure.subplots(1, 2, sharey=True)
    x = numpy.linspace(0, 1, 201)
    for k, t in enumerate(TIMES[1]):
        exact = math.exp(-4 * math.pi**2 * t) * numpy.sin(2 * math.pi * x) + x
        for axes in (left, right):
            axes.plot(x, exact, color="black", linewidth=0.8, label="_" if k else "exact")
        for axes, keys in ((left, ("ps 32", "ps 64", "ps 128")), (right, ("ps 128", "ips 128"))):
            for key, style, colour in zip(keys, (":", "--", "-"), (draw.GOLD, draw.GREEN, draw.RED)):
                result = found[key]
                colour = draw.BLUE if key.startswith("ips") else colour
                axes.plot(result.points[:, 0], result.history.solution[k], style, color=colour,
                          label="_" if k else key.replace("ips", "IPS").replace("ps", "PS"))
    left.set(title="(a) PS on three meshes", ylabel="$\\phi$")
    right.set(title="(b) PS and IPS, $n_C$ = 128")
    for axes in (left, right):
        axes.set(xlabel="x")
        axes.grid(alpha=0.3)
        axes.legend(fontsize=8)


def figure_15_asks():
    return {name: ask("diffusion-2d", (64,), kind="field", operator=scheme(name), end=0.02, seed=1)
            for name in ("ps", "ips")}


def exact_2d(x, y, t):
    wave = numpy.sin(2 * math.pi * x) * numpy.sin(2 * math.pi * y)
    rest = 4 * x * (x - 1) - 4 * y * (y - 1) + (x - 0.5) * (y - 0.5)
    return math.exp(-8 * math.pi**2 * t) * wave + rest


def figure_15_data(found):
    x, y = found["ps"].points.T
    rows = numpy.column_stack([x, y, exact_2d(x, y, 0.02), found["ps"].solution,
                               found["ips"].solution])
    return [Table("h16-figure-15", "Solution at t = 0.02", ["x", "y", "exact", "PS", "IPS"],
                  rows.tolist(), shown=False)]


def figure_15(figure, found):
    points = found["ps"].points
    fields = {"(a) exact": exact_2d(*points.T, 0.02), "(b) PS": found["ps"].solution,
              "(c) IPS": found["ips"].solution}
    levels = numpy.linspace(-1, 1, 21)
    for axes, (title, values) in zip(figure.subplots(1, 3), fields.items()):
        axes.tricontour(*points.T, values, levels, cmap="viridis", linewidths=1.2)
        axes.set(xlabel="x", ylabel="y", aspect="equal", title=title)
        axes.label_outer()


# --- Statements ---------------------------------------------------------------------------------

# The two finest meshes that tell.
FINE = {1: (128, 256), 2: (64, 128), 3: (32, 64)}


def statement_asks(dims=(1, 2, 3)):
    return {f"{name} {dim}": question for dim in dims
            for name, question in operator_asks(dim, FINE[dim], ("ps", "ips")).items()}


def in_time_statement_asks(dims=(1, 2, 3)):
    return {f"{key} {dim}": question for dim in dims for key, question in time_asks(dim).items()}


def yes(holds):
    return "yes" if holds else "no"


def pairs(found, name, dim):
    """Rows of both meshes by alpha."""
    return {alpha: rows_with(found[f"{name} {dim}"], alpha=alpha) for alpha in ALPHAS}


def exponent(rows):
    """Of n_C in the error."""
    coarse, fine = rows
    return math.log(fine.l2 / coarse.l2) / math.log(fine.cells / coarse.cells)


def of_cell_reynolds(found, dim):
    rows = pairs(found, "ips", dim)
    ratios = [fine.cell_reynolds[0] / coarse.cell_reynolds[0] for coarse, fine in rows.values()]
    values = ", ".join(f"{fine.cell_reynolds[0] / alpha:.2f} alpha at {alpha}"
                       for alpha, (_, fine) in rows.items())
    return [f"cell Reynolds number in {dim}-D does not depend on n_C",
            yes(all(abs(ratio - 1) < 0.03 for ratio in ratios)),
            f"Re_u = {values}; twice n_C: " + ", ".join(f"x {ratio:.3f}" for ratio in ratios)]


def of_ps(found, dim):
    power = exponent(pairs(found, "ps", dim)[0.3])
    return [f"error of the PS Laplacian grows with n_C in {dim}-D", yes(power > 0.9),
            f"n_C^{power:.2f}"]


def of_ips(found, dim):
    power = exponent(pairs(found, "ips", dim)[0.3])
    return [f"error of the IPS Laplacian does not depend on n_C in {dim}-D, n_C large",
            yes(abs(power) < 0.1), f"n_C^{power:.2f}"]


def of_diffusivity(found, alpha):
    tensor = pairs(found, "ips", 1)[alpha][1].effective_diffusivity
    return [f"effective diffusivity off by less than 4 % in 1-D, alpha = {alpha}",
            yes(1 - tensor["mean"][0] < 0.04),
            f"mean {100 * (1 - tensor['mean'][0]):.1f} %, root mean square "
            f"{100 * tensor['rms_deviation'][0]:.1f} %"]


def of_shear(found, dim):
    row = pairs(found, "ips", dim)[0.3][1]
    mean, deviation = (row.effective_diffusivity[name][0] for name in ("mean", "rms_deviation"))
    part = shear(row, dim)
    return [f"shear part of the diffusivity dominates the normal part in {dim}-D, alpha = 0.3",
            f"over the mean: {yes(part > 1.5 * (1 - mean))}; point by point: "
            f"{yes(part > 1.5 * deviation)}",
            f"rms tau_xy {part:.4f}; 1 - tau_xx: mean {1 - mean:.4f}, rms {deviation:.4f}"]


def statements(found):
    """Of the operators, in the dimensions that were asked for."""
    dims = [dim for dim in (1, 2, 3) if f"ips {dim}" in found]
    rows = [make(found, dim) for make in (of_cell_reynolds, of_ps, of_ips) for dim in dims]
    rows += [of_diffusivity(found, alpha) for alpha in ALPHAS if 1 in dims]
    rows += [of_shear(found, dim) for dim in dims if dim > 1]
    return [Table("h16-statements", "Statements of the paper about the operators",
                  ["statement", "holds", "found"], rows)]


def largest(row):
    return max(row.history["l2"])


def of_accuracy(found, dim):
    """IPS against PS in all runs of the figure, at all times."""
    ratios = [ips / ps for what in ("n", "alpha", "C_D") for rows in
              zip(found[f"{what} ps {dim}"].table, found[f"{what} ips {dim}"].table)
              for ps, ips in zip(*(row.history["l2"] for row in rows))]
    return [f"IPS is more accurate than PS in {dim}-D, all n_C, alpha, C_D and times",
            yes(max(ratios) < 1), f"error of IPS over that of PS: {min(ratios):.1e} to "
            f"{max(ratios):.2f}"]


def of_step(found, dim, name):
    rows = found[f"C_D {name} {dim}"].table
    short, whole = largest(rows[0]), largest(rows[-1])
    return [f"error of {name.upper()} in {dim}-D changes by less than 10 % with the time step",
            yes(abs(whole / short - 1) < 0.1),
            f"largest error {short:.2e} at C_D = {STEPS[0]}, {whole:.2e} at C_D = {STEPS[-1]}"]


def of_spacing(found, dim):
    rows = found[f"n ips {dim}"].table
    errors = ", ".join(f"{largest(row):.1e} at {row.cells}" for row in rows)
    gain = largest(rows[-2]) / largest(rows[-1])
    return [f"a denser cloud may not make IPS more accurate in {dim}-D", yes(gain < 2),
            f"largest error: {errors}"]


def time_statements(found):
    dims = [dim for dim in (1, 2, 3) if f"n ips {dim}" in found]
    rows = [of_accuracy(found, dim) for dim in dims]
    rows += [of_step(found, dim, name) for dim in dims for name in ("ps", "ips")]
    rows += [of_spacing(found, dim) for dim in dims]
    return [Table("h16-time-statements", "Statements of the paper about the errors in time",
                  ["statement", "holds", "found"], rows)]


# --- All ----------------------------------------------------------------------------------------


def operator_items(dim):
    """Statistics and errors of the operators in one dimension of space."""
    statistics, errors, _ = FIGURES[dim]
    asks = operator_asks(dim)
    items = [Item(f"h16-operator-{dim}d",
                  f"Figure{'s' if dim == 1 else ''} {statistics}: operators in {dim}-D",
                  "Statistics of the interior points; `error` is the root mean square error of the "
                  "Laplacian. tau_xy is that of eq. 22b, the entry of the symmetric tensor. lsmps "
                  "(degree 2), which the paper does not have, converges where IPS stalls.",
                  asks, operator_table(dim), statistics_figure(dim), size=(9 if dim == 1 else 12, 4),
                  sample=operator_asks(dim, OPERATOR_SAMPLE[dim])),
             Item(f"h16-error-{dim}d", f"Figure {errors}: error of the Laplacian in {dim}-D",
                  "lsmps is ours, for comparison.",
                  {**asks, **against_alpha_asks(dim)}, alpha_table(dim), error_figure(dim))]
    return items


def time_items(dim):
    figure = FIGURES[dim][2]
    return [Item(f"h16-time-{dim}d-figure", f"Figure {figure}: error in time in {dim}-D",
                 "PS dashed, IPS drawn through. The paper's time step leaves out that the bound is "
                 "the least over the points.",
                 time_asks(dim), time_figure_data(dim), time_figure(dim), size=(12, 4.6)),
            Item(f"h16-time-{dim}d", f"Error in time in {dim}-D, and what cures it",
                 "PS and IPS act like a diffusivity below 1, so their errors stall; ipsn (IPS "
                 "times d over the trace of its effective diffusivity) takes that bias away, and "
                 "lsmps converges.",
                 time_table_asks(dim), time_table(dim),
                 sample=time_table_asks(dim, TIME_SAMPLE[dim]))]


ITEMS = [
    Item("h16-statements", "What the paper says of its operators",
         "Holds is worked out from what was found, on the two finest meshes.", statement_asks(),
         statements, sample=statement_asks((1, 2))),
    Item("h16-time-statements", "What the paper says of its errors in time",
         "From the runs of Figures 7, 14 and 19. In 3-D the paper, too, says that the error of IPS "
         "falls with longer steps.", in_time_statement_asks(), time_statements,
         sample=in_time_statement_asks((1,))),
    quick("h16-three-point", "Figure 1: three points",
          "Eq. 33b is exact, not a series: 1 - alpha^2 (3 - alpha)/4 for every phi*. Eq. 33a is good "
          "for small alpha only; phi* = -0.5 at alpha = 0.5 has the exact Laplacian 0.",
          three_point_asks(), three_point_table, figure_1),
    Item("h16-figure-2", "Figure 2: Laplacian in 1-D, alpha = 0.3",
         "One cloud (another than the paper's). PS is its artificial velocity, as eq. 36 says.",
         figure_2_asks(), figure_2_data, figure_2),
    Item("h16-figure-3", "Figure 3: artificial velocity and cell Reynolds number in 1-D", "",
         {"ips": operator_asks(1)["ips"]}, lambda found: [], velocity_figure),
    Item("h16-figure-4", "Figure 4: effective diffusivity in 1-D",
         "\"Less than 4 % for alpha <= 0.5\" does not hold: see the statements.",
         {"ips": operator_asks(1)["ips"]}, lambda found: [], diffusivity_figure, size=(8.4, 4.2)),
    *operator_items(1),
    Item("h16-figure-6", "Figure 6: solution of the heat equation in 1-D, alpha = 0.3",
         "t = 0.01, 0.02, 0.05, 0.1 and 0.5. One cloud per mesh.", figure_6_asks(), figure_6_data,
         figure_6),
    *time_items(1),
    *operator_items(2),
    Item("h16-figure-9", "Figure 9: exact Laplacian in 2-D", "", {}, figure_9_data, figure_9,
         size=(5.5, 4.2)),
    Item("h16-figure-10", "Figure 10: particles", "", plane_asks(), figure_10_data, figure_10),
    Item("h16-figure-11", "Figure 11: Laplacian by PS", "", plane_asks(),
         plane_data("h16-figure-11", "ps"), plane_figure("ps")),
    Item("h16-figure-12", "Figure 12: Laplacian by IPS", "", plane_asks(),
         plane_data("h16-figure-12", "ips"), plane_figure("ips")),
    *time_items(2),
    Item("h16-figure-15", "Figure 15: solution at t = 0.02 in 2-D, n_C = 64, alpha = 0.3", "",
         figure_15_asks(), figure_15_data, figure_15, size=(12, 4)),
    *operator_items(3),
    Item("h16-figure-17", "Figure 17: against alpha in 3-D", "", against_alpha_asks(3),
         lambda found: [], against_alpha_figure, size=(6.4, 4.2)),
    *time_items(3),
]
