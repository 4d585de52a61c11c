#!/usr/bin/env python3
"""http.flow: the process `flow`: cavity, step and a domain of one's own; what it hands out belongs
together, snapshots can be posted to diagnose and apply, a job that is killed goes on where it was."""

import json
import math
import pathlib
import signal
import sys
import unittest

sys.dont_write_bytecode = True
import daemon  # noqa: E402

FLOW = "/processes/flow/execution"
BOX = {"lower": [0, 0], "upper": [2, 1]}
CHANNEL = {
    "fluid": [BOX],
    "solid": [{"lower": [0.6, 0.4], "upper": [0.9, 0.6]}],
    "sides": [
        {"type": "inflow", "from": [0, 0], "to": [0, 1], "velocity": ["6*m*y*(1-y)", 0], "scalar": 1},
        {"type": "outflow", "from": [2, 0], "to": [2, 1]},
    ],
    "spacing": 0.1,
}


def profile(section, axis, value):
    return list(zip(section[axis], section[value]))


class Flow(daemon.Case):
    stub = False

    def flow(self, **inputs):
        reply = self.execute(json.dumps({"inputs": inputs}), FLOW)
        self.assertEqual(reply.status, 200, reply.body[:500])
        return {name: value.get("value", value) if isinstance(value, dict) else value
                for name, value in reply.json.items()}

    def post(self, process, **inputs):
        reply = self.execute(json.dumps({"inputs": inputs}), f"/processes/{process}/execution")
        self.assertEqual(reply.status, 200, reply.body[:500])
        return reply.json

    def test_cavity(self):
        result = self.flow(case="cavity", cells=20, end=6, save=[3, 6], operator={"scheme": "ips"})
        self.assertEqual(len(result["particles"]), 400)
        self.assertEqual(result["summary"]["cells"], 400)
        self.assertEqual(result["history"]["t"][-1], 6)
        self.assertLess(max(result["history"]["divergence"]), 1e-10)
        self.assertAlmostEqual(result["vortex"]["circulation"], 0.1, delta=0.006)
        self.assertEqual([shot["t"] for shot in result["snapshots"]], [3, 6])
        self.assertEqual(result["snapshots"][1]["particles"], result["particles"])
        self.assertNotIn("reattachment", result)
        u = profile(result["profiles"]["u"], "y", "u")
        self.assertEqual((u[0], u[-1]), ((0, 0), (1, 1)))
        self.assertEqual(len(u), 22)
        stream = result["mesh"]["stream"]
        self.assertAlmostEqual(-min(map(min, stream)), result["vortex"]["circulation"], delta=1e-3)

    def test_step(self):
        result = self.flow(case="step", cells=8, end=12, downstream=6, grading={"clustering": 0.3})
        self.assertTrue(1.5 < result["reattachment"] < 3.5, result["reattachment"])
        mesh = result["mesh"]
        for line in (0, 5, -1):  # what flows in flows through every vertical line
            flux = mesh["stream"][-1][line] - mesh["stream"][0][line]
            self.assertAlmostEqual(flux, 1, delta=1e-9)
        solid = [p for p in result["particles"] if p[0] < 0 and p[1] < 0.942]
        self.assertEqual(solid, [])
        self.assertEqual([s["x"] for s in result["profiles"]["sections"]], [0.5, 1, 2, 3, 4, 6])
        self.assertGreater(result["summary"]["inserted"], 0)

    def test_domain_with_a_scalar(self):
        result = self.flow(domain=CHANNEL, viscosity=0.02, end=6, parameters={"m": 1},
                           scalar={"diffusivity": 0.01})
        for x, y in result["particles"]:
            self.assertFalse(0.6 < x < 0.9 and 0.4 < y < 0.6)
        self.assertEqual(len(result["scalar"]), len(result["particles"]))
        self.assertGreater(result["history"]["scalar"][-1], 0.8)  # it has come through
        self.assertLess(max(result["scalar"]), 1.1)  # fits overshoot a little at a front
        self.assertEqual(sum(map(sum, result["mesh"]["fluid"])), result["summary"]["cells"])

    def test_means_do_not_depend_on_units(self):
        """A step ends where the means begin: rounding must not count it in one unit of length only."""
        case = self.flow(case="cavity", cells=10, end=2)
        for size in (1, 1e-3, 1e6):
            square = {"fluid": [{"lower": [0, 0], "upper": [size, size]}], "spacing": size / 10,
                      "sides": [{"type": "wall", "from": [0, size], "to": [size, size],
                                 "velocity": [1, 0]}]}
            other = self.flow(domain=square, viscosity=size / 100, end=2 * size)
            for name in ("circulation", "x", "y"):
                self.assertAlmostEqual(other["vortex"][name] / size, case["vortex"][name], delta=1e-9)

    def test_schemes_differ(self):
        got = {scheme: self.flow(case="cavity", cells=12, end=4, operator={"scheme": scheme})
               ["vortex"]["circulation"] for scheme in ("ps", "ips", "ipsn", "lsmps")}
        self.assertEqual(len(set(got.values())), 4)
        for scheme, value in got.items():
            self.assertAlmostEqual(value, 0.098, delta=0.02, msg=scheme)

    def test_a_snapshot_is_a_cloud(self):
        """The linear function x: ips knows that its Laplacian is 0, ps sees its artificial
        velocity, which diagnose has said."""
        result = self.flow(case="cavity", cells=16, end=4)
        points = result["particles"] + result["wall_points"]
        inside = range(len(result["particles"]))
        cloud = {"points": points, "spacing": 1 / 16}
        x = [p[0] for p in points]
        laplacian = {scheme: self.post("apply", cloud=cloud, field=x, operator={"scheme": scheme})
                     ["laplacian"] for scheme in ("ps", "ips")}
        told = self.post("diagnose", cloud=cloud, operator={"scheme": "ps"})["artificial_velocity"]
        rms = {scheme: math.sqrt(sum(v[k] ** 2 for k in inside) / len(inside))
               for scheme, v in laplacian.items()}
        self.assertLess(rms["ips"], 1e-9)
        self.assertGreater(rms["ps"], 0.3)
        for k in inside:
            self.assertAlmostEqual(laplacian["ps"][k], told[k][0], delta=1e-9)

    def test_an_end_that_is_never_reached(self):
        reply = self.execute(json.dumps({"inputs": {"case": "cavity", "cells": 8, "end": 1e9}}), FLOW)
        self.assertEqual(reply.status, 422, reply.body[:300])
        self.assertEqual(reply.json["errors"][0]["pointer"], "/inputs/end")
        self.assertIn("needs steps of about", reply.json["detail"])

    def test_particles_as_vtp(self):
        body = {"inputs": {"case": "cavity", "cells": 8, "end": 0.2}}
        reply = self.execute(json.dumps(body), FLOW, Accept="application/vnd.vtk.vtp+xml")
        self.assertEqual(reply.status, 200, reply.body[:300])
        self.assertIn(b"PolyData", reply.body)
        self.assertIn(b'Name="velocity"', reply.body)


class Jobs(unittest.TestCase):
    def request(self, server, body):
        return server.request("POST", FLOW, json.dumps(body), {
            "Prefer": "respond-async", "Content-Type": "application/json"})

    def results(self, server, job):
        def ended():
            info = server.request("GET", f"/jobs/{job}", headers={"Prefer": "wait=10"}).json
            return info if info["status"] in ("successful", "failed") else None
        info = daemon.wait_until(ended, "the end of the job", 240)
        self.assertEqual(info["status"], "successful", info)
        return server.request("GET", f"/jobs/{job}/results").json

    def test_a_killed_run_goes_on_where_it_was(self):
        body = {"inputs": {"case": "cavity", "cells": 28, "end": 60, "save": [1]},
                "outputs": {"particles": {}, "history": {}, "summary": {}, "snapshots": {}}}
        options = ("--workers", "1", "--seconds", "300", "--reuse-results", "0")
        server = daemon.Daemon(*options, stub=False)
        job = self.request(server, body).json["jobID"]
        daemon.wait_until(lambda: list(pathlib.Path(server.data).rglob(f"{job}.checkpoint")),
                          "a state that is kept")
        server.stop(signal.SIGKILL, keep=True)
        server = daemon.Daemon(*options, stub=False, directory=server.directory)
        try:
            got = self.results(server, job)
            whole = self.results(server, self.request(server, body).json["jobID"])
            resumed = got["summary"]["value"].pop("resumed", None)
            self.assertIsNotNone(resumed)
            self.assertGreater(resumed, 0)
            self.assertEqual(got, whole)  # to the last bit
        finally:
            self.assertEqual(server.stop(), 0)


if __name__ == "__main__":
    unittest.main()
