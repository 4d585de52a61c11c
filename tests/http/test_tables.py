#!/usr/bin/env python3
"""http.tables: Tables 1 to 5 of Huang et al. 2011 through POST /processes/solve/execution, every
exact solution posted as an expression. What is expected of each number, and which four of the
paper's last digits cannot be had, is said in tests/verify/verify_huang2011.c."""

import json
import math
import pathlib
import sys
import unittest

sys.dont_write_bytecode = True
import daemon  # noqa: E402

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parents[1] / "clients" / "python"))
from scatterd import Client  # noqa: E402

TABLES = json.loads((HERE.parent / "reference" / "h11-tables.json").read_text())

LAPLACE = "atan((x - 2) / (y - 2))"
SMOOTH = "expm1((x - 1)/mu) * expm1((y - 1)/mu) / (expm1(-1/mu) * expm1(-1/mu))"
# eq. 34 arranged so that no exponent is positive, b = 1/(2 mu), l = sqrt(pi^2 + b^2)
GARTLAND = ("sin(pi*y) * (2*(exp((b + l)*(x - 1)) - exp((b - l)*x - (b + l)))"
            " + exp((b - l)*x) - exp((b + l)*x - 2*l)) / -expm1(-2*l)")


def gartland_parameters(mu):
    b = 1 / (2 * mu)
    return {"b": b, "l": math.sqrt(math.pi**2 + b * b)}


class Tables(daemon.Case):
    stub = False

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.client = Client(f"http://{cls.daemon.address}")

    def norms(self, cells, exact, mu, velocity, parameters=None, **operator):
        result = self.client.solve(
            cloud={"lattice": {"lower": [0, 0], "upper": [1, 1], "cells": [cells, cells]}},
            velocity=velocity, diffusivity=mu, parameters=parameters or {"mu": mu},
            boundary=[{"on": "boundary", "type": "dirichlet", "value": exact}], exact=exact,
            operator={"scheme": "mps", "kernel": "center", "radius": 2, **operator},
            outputs=["norms"])
        return result["norms"]

    def as_printed(self, got, printed, what):
        unit = 10.0 ** (math.floor(math.log10(printed)) - 3)
        self.assertLess(abs(got - printed), unit, f"{what}: got {got:.6e}, printed {printed:.3e}")

    def column(self, table, name, cells, printed, norm="l2", **problem):
        for n, value in zip(cells, printed):
            self.as_printed(self.norms(n, **problem)[norm], value, f"{table}, {name}, {n} cells")

    def kernels(self, table, cells, columns, **problem):
        for kernel in ("bell", "rational", "spiky"):
            self.column(table, kernel, cells, columns[kernel], kernel=kernel, radius=2.05,
                        number_density="reference", **problem)

    def test_table_1(self):
        t = TABLES["table1_laplace"]
        cells = [n - 1 for n in t["points_per_side"]]
        problem = dict(exact=LAPLACE, mu=1, velocity=[0, 0])
        self.kernels("Table 1", cells, t, **problem)
        self.column("Table 1", "center", cells, t["center_in_double_precision"], **problem)

    def test_table_2(self):
        t = TABLES["table2_smooth_mu_1e4"]
        problem = dict(exact=SMOOTH, mu=1e4, velocity=[1, 1])
        self.kernels("Table 2", t["cells"], t, **problem)
        for n in t["cells"]:
            # 10 cells: the truncation error of the scheme, 1.53e-13
            self.assertLess(self.norms(n, **problem)["l2"], 1.6e-13 if n == 10 else 5e-14)

    def test_table_3(self):
        t = TABLES["table3_smooth_mu_1e-2"]
        problem = dict(exact=SMOOTH, mu=1e-2, velocity=[1, 1])
        self.column("Table 3", "center", t["cells"], t["center"], **problem)
        self.column("Table 3", "upwind", t["cells"], t["upwind_published"], upwind="published",
                    gamma_scale=t["gamma_scale"], **problem)

    def test_tables_4_and_5(self):
        problem = dict(exact=GARTLAND, mu=1e-2, velocity=[1, 0],
                       parameters=gartland_parameters(1e-2))
        t4, t5 = TABLES["table4_gartland_mu_1e-2"], TABLES["table5_gartland_mu_1e-2"]
        upwind = dict(upwind="published", gamma_scale=t4["gamma_scale"])
        self.column("Table 4", "center", t4["cells"], t4["center"], **problem)
        self.column("Table 4", "upwind", t4["cells"], t4["upwind_published"], **upwind, **problem)
        self.column("Table 5", "center", t5["cells"], t5["center_max"], "linf_all", **problem)
        self.column("Table 5", "upwind", t5["cells"], t5["upwind_published_max"], "linf_all",
                    **upwind, **problem)
        self.column("Table 5", "upwind l2", t5["cells"], t5["upwind_published_rms"], **upwind,
                    **problem)


if __name__ == "__main__":
    unittest.main()
