#!/usr/bin/env python3
"""The iterative solver through the daemon: what it tells, its limits, its fallback, its absence."""
import json
import unittest

import daemon


def solve(cells, solver, **inputs):
    return json.dumps({"inputs": {
        "cloud": {"lattice": {"lower": [0] * len(cells), "upper": [1] * len(cells), "cells": cells,
                              "jitter": 0.3}},
        "diffusivity": 1, "source": "3*pi^2*sin(pi*x)*sin(pi*y)*sin(pi*z)", "solver": solver,
        "boundary": [{"on": "boundary", "type": "dirichlet", "value": 0}], **inputs},
        "outputs": {"solution": {}, "diagnostics": {}}})


class Iterative(daemon.Case):
    stub = False
    options = ["--workers", "1"]

    def setUp(self):
        super().setUp()
        probe = self.execute(solve([4, 4, 4], {"method": "iterative"}))
        if probe.status == 200:
            return
        self.assert_problem(probe, 400, "needs PETSc")
        self.assertEqual(probe.json["errors"][0]["pointer"], "/inputs/solver/method")
        self.skipTest("the daemon has no PETSc")

    def result(self, cells, solver, **inputs):
        reply = self.execute(solve(cells, solver, **inputs))
        self.assertEqual(reply.status, 200, reply.body)
        outputs = {key: value.get("value", value) if isinstance(value, dict) else value
                   for key, value in reply.json.items()}
        return outputs["solution"], outputs["diagnostics"]["solver"]

    def assert_close(self, one, other, tolerance):
        self.assertEqual(len(one), len(other))
        self.assertLess(max(abs(a - b) for a, b in zip(one, other)), tolerance)

    def test_agrees_with_factors_and_tells_its_history(self):
        exact, direct = self.result([14, 14, 14], {"method": "direct"})
        self.assertNotIn("krylov", direct)
        for preconditioner in ("ilu", "amg"):
            found, told = self.result([14, 14, 14], {"method": "iterative", "tolerance": 1e-9,
                                                     "preconditioner": preconditioner})
            self.assert_close(found, exact, 1e-7)
            self.assertEqual((told["method"], told["krylov"], told["preconditioner"]),
                             ("iterative", "bicgstab", preconditioner))
            self.assertLessEqual(told["relative_residual"], 1e-9)
            self.assertAlmostEqual(told["history"]["residual"][0], 1)
            self.assertEqual(len(told["history"]["residual"]), told["iterations"] + 1)
            self.assertNotIn("fallback", told)
            self.assertNotIn("reciprocal_condition", told)

    def test_same_bits_twice(self):
        request = {"method": "iterative", "preconditioner": "amg"}
        self.assertEqual(self.result([10, 10, 10], request), self.result([10, 10, 10], request))

    def test_auto_iterates_where_it_pays(self):
        self.assertEqual(self.result([18, 18, 18], {})[1]["method"], "iterative")
        self.assertNotEqual(self.result([8, 8, 8], {})[1]["method"], "iterative")

    def test_iterations_run_out(self):
        exact = self.result([14, 14, 14], {"method": "direct"})[0]
        found, told = self.result([14, 14, 14], {"method": "iterative", "max_iterations": 2})
        self.assert_close(found, exact, 1e-12)
        self.assertEqual(told["method"], "umfpack")
        self.assertIn("after 2 iterations", told["fallback"])

    def test_in_time(self):
        time = {"end": 0.01, "step": 0.001, "method": "bdf2"}
        exact = self.result([10, 10, 10], {"method": "direct"}, time=time, initial=0)[0]
        found, told = self.result([10, 10, 10], {"method": "iterative"}, time=time, initial=0)
        self.assert_close(found, exact, 1e-8)
        self.assertEqual(told["method"], "iterative")

    def test_a_job_tells_its_residuals(self):
        body = solve([36, 36, 36], {"method": "iterative", "preconditioner": "ilu"})
        job = self.execute(body, Prefer="respond-async").json["jobID"]
        text = self.get(f"/jobs/{job}/events").body.decode()
        told = [json.loads(line.split(":", 1)[1])["residual"] for line in text.splitlines()
                if line.startswith("data:") and '"residual":' in line]
        self.assertTrue(told, text)
        self.assertLess(told[-1], 1)
        self.assertGreater(min(told), 0)

    def test_undetermined_problems_are_named_as_ever(self):
        flux = [{"on": "boundary", "type": "neumann", "value": 0}]
        reply = self.execute(solve([8, 8, 8], {"method": "iterative"}, boundary=flux))
        self.assert_problem(reply, 422, "determined up to a constant")


class NoRoom(daemon.Case):
    """A worker whose address space PETSc would eat up."""
    stub = False
    options = ["--workers", "1", "--memory-bytes", "512MiB"]

    @unittest.skipIf(daemon.is_sanitized(), "the sanitizer needs all address space for itself")
    def test_is_told(self):
        reply = self.execute(solve([4, 4, 4], {"method": "iterative"}))
        self.assertIn(reply.status, (400, 422), reply.body)
        self.assertRegex(reply.json["detail"], "PETSc")
        self.assertEqual(self.execute(solve([18, 18, 18], {})).status, 200)


if __name__ == "__main__":
    unittest.main()
