#!/usr/bin/env python3
"""http.limited: upwind `limited` through the daemon, by `study` and `solve`: published outlet
profiles, bounds, the history of its iteration, and a problem where it stagnates."""

import pathlib
import sys
import unittest

sys.dont_write_bytecode = True
import daemon  # noqa: E402

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "clients" / "python"))
import scatterd  # noqa: E402

# Outlet of Smith and Hutton's flow at x = 0, 0.1 .. 1, by diffusivity.
OUTLET = {
    1e-1: [1.989, 1.402, 1.146, 0.946, 0.775, 0.621, 0.480, 0.349, 0.227, 0.111, 0],
    1e-3: [2.000, 1.999, 2.000, 1.985, 1.841, 0.951, 0.154, 0.001, 0.000, 0.000, 0],
    1e-6: [2.000, 2.000, 2.000, 1.999, 1.964, 1.000, 0.036, 0.001, 0.000, 0.000, 0],
}
LIMITED = {"scheme": "lsmps", "upwind": "limited"}
FEW = 60  # back-substitutions
SLACK = 1e-6


class Limited(daemon.Case):
    stub = False

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.client = scatterd.Client(f"http://{cls.daemon.address}", format="json")
        cls.addClassCleanup(cls.client.close)

    def whirl(self, mu, **inputs):
        """A step turned about the middle of the square."""
        return self.client.solve(
            scatterd.lattice([0, 0], [1, 1], 24, jitter=0.5, seed=6), diffusivity=mu,
            velocity=["0.5 - y", "x - 0.5"], boundary=[scatterd.dirichlet("boundary", "x > 0.5")],
            operator=LIMITED, **inputs)

    def assert_within(self, bounds, low, high):
        self.assertGreaterEqual(bounds["min"], low - SLACK)
        self.assertLessEqual(bounds["max"], high + SLACK)

    def test_smith_hutton_has_the_published_outlet(self):
        for alpha in (0, 0.4):
            table = self.client.study("smith-hutton", [80], operator=LIMITED, parameters={
                "mu": list(OUTLET), "alpha": alpha, "seed": 3}).table
            self.assertEqual(len(table), len(OUTLET))
            for row, published in zip(table, OUTLET.values()):
                with self.subTest(alpha=alpha, mu=row.mu):
                    for x, value, expected in zip(row.outlet["x"][::8], row.outlet["value"][::8],
                                                  published):
                        self.assertAlmostEqual(value, expected, delta=0.03, msg=f"x = {x}")
                    self.assert_within(row.bounds, 0, 2)
                    self.assertLess(row.iterations, FEW)

    def test_skew_keeps_its_bounds(self):
        for scheme in ("ps", "ips", "lsmps"):
            for theta in (20, 45, 70):
                table = self.client.study(
                    "skew", operator={"scheme": scheme, "upwind": "limited"},
                    parameters={"mu": [1e-3, 1e-5, 1e-9], "theta": theta, "alpha": 0.5}).table
                for row in table:
                    self.assert_within(row.bounds, 0, 1)
                    self.assertLess(row.iterations, FEW)

    def test_history_of_the_iteration(self):
        solver = self.whirl(1e-3).diagnostics.solver
        self.assertEqual(len(solver.residual_history), solver.iterations)
        self.assertEqual(solver.residual_history[-1], solver.residual)
        self.assertLessEqual(solver.residual, 1e-8)
        self.assertGreater(min(solver.residual_history[:-1]), 1e-8)
        self.assertLess(self.whirl(1e-3, solver={"tolerance": 1e-3}).diagnostics.solver.iterations,
                        solver.iterations)

    def test_stagnation_is_a_problem(self):
        with self.assertRaises(scatterd.ScatterdError) as caught:
            self.whirl(1e-3, solver={"max_iterations": 5})
        self.assertEqual(caught.exception.status, 422)
        self.assertIn("back-substitution 5", caught.exception.detail)

    def test_in_time_bounds_hold_and_every_step_is_counted(self):
        for method in ("backward-euler", "crank-nicolson", "bdf2", "forward-euler"):
            with self.subTest(method):
                limit = {"diffusion_number": 0.9} if method == "forward-euler" else {"step": 0.01}
                result = self.whirl("1e-3*(1 + t)", initial="x > 0.5 && y > 0.5",
                                    time={"method": method, "end": 0.2, "save": [0.1, 0.2], **limit})
                if method != "bdf2":  # promises no bounds
                    self.assert_within(result.diagnostics.bounds, 0, 1)
                if method == "forward-euler":
                    continue
                solver = result.diagnostics.solver
                self.assertLess(solver.iterations_most, FEW)
                self.assertGreaterEqual(solver.iterations_total, 20 * 2)
                self.assertGreaterEqual(solver.iterations_most, solver.iterations)


if __name__ == "__main__":
    unittest.main(verbosity=2)
