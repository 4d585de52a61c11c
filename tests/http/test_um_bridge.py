#!/usr/bin/env python3
"""http.um_bridge: the protocol of UM-Bridge 1.0, its errors in their order, and the derivatives:
gradient and Jacobian against differences of Evaluate, and against each other."""

import itertools
import json
import math
import os
import pathlib
import random
import sys
import unittest

sys.dont_write_bytecode = True
import daemon  # noqa: E402
import test_access as access  # noqa: E402

SCHEMAS = pathlib.Path(__file__).resolve().parents[2] / "schemas"

LINE = {"lattice": {"lower": [0], "upper": [1], "cells": [24], "jitter": 0.3, "seed": 3}}
SQUARE = {"lattice": {"lower": [0, 0], "upper": [1, 1], "cells": [9, 9], "jitter": 0.3, "seed": 5}}
CUBE = {"lattice": {"lower": [0] * 3, "upper": [1] * 3, "cells": [5] * 3, "jitter": 0.2, "seed": 2}}


class Model:
    """The model with a config, as a client has it."""

    def __init__(self, case, config):
        self.case, self.config = case, config

    def ask(self, operation, **members):
        body = json.dumps({"name": "solve", "config": self.config, **members})
        reply = self.case.request("POST", "/" + operation, body)
        self.case.assertEqual(reply.status, 200, reply.body)
        return reply.json

    def evaluate(self, vectors):
        return self.ask("Evaluate", input=vectors)["output"]

    def gradient(self, out, into, vectors, sens):
        return self.ask("Gradient", outWrt=out, inWrt=into, input=vectors, sens=sens)["output"]

    def jacobian(self, out, into, vectors, vec):
        return self.ask("ApplyJacobian", outWrt=out, inWrt=into, input=vectors, vec=vec)["output"]

    def sizes(self):
        return (self.ask("InputSizes")["inputSizes"], self.ask("OutputSizes")["outputSizes"])

    def differences(self, into, vectors, vec):
        """All outputs' derivatives along vec: differences of sixth order."""
        h, weights = 4e-3, ((1, 3 / 4), (2, -3 / 20), (3, 1 / 60))
        total = None
        for (step, weight), side in itertools.product(weights, (1, -1)):
            moved = [list(v) for v in vectors]
            moved[into] = [x + side * step * h * v for x, v in zip(moved[into], vec)]
            part = [[side * weight * y / h for y in vector] for vector in self.evaluate(moved)]
            total = part if total is None else [
                [a + b for a, b in zip(x, y)] for x, y in zip(total, part)]
        return total


def dot(a, b):
    return math.fsum(x * y for x, y in zip(a, b))


def norm(vector):
    return math.sqrt(dot(vector, vector))


class Derivatives(daemon.Case):
    stub = False
    worst = {"differences": 0.0, "identity": 0.0}

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        seed = int(os.environ.get("SCATTERD_SEED", random.randrange(2**31)))
        print(f"um_bridge: SCATTERD_SEED={seed}")
        cls.random = random.Random(seed)

    @classmethod
    def tearDownClass(cls):
        print(f"worst relative error: {cls.worst}")
        super().tearDownClass()

    def check(self, config, vectors, tolerance=1e-8):
        """Every pair of output and input vectors along random directions."""
        model = Model(self, config)
        ins, outs = model.sizes()
        self.assertEqual([len(v) for v in vectors], ins)
        for into, n in enumerate(ins):
            vec = [self.random.uniform(-1, 1) for _ in range(n)]
            by_steps = model.differences(into, vectors, vec)
            for out, m in enumerate(outs):
                with self.subTest(out=out, into=into):
                    sens = [self.random.uniform(-1, 1) for _ in range(m)]
                    change = model.jacobian(out, into, vectors, vec)
                    gradient = model.gradient(out, into, vectors, sens)
                    self.compare(change, by_steps[out], tolerance)
                    self.identity(dot(sens, change), dot(gradient, vec), sens, change,
                                  gradient, vec)

    def compare(self, change, expected, tolerance):
        error = norm([a - b for a, b in zip(change, expected)]) / max(1e-3, norm(expected))
        self.worst["differences"] = max(self.worst["differences"], error)
        self.assertLess(error, tolerance)

    def identity(self, left, right, sens, change, gradient, vec):
        scale = max(norm(sens) * norm(change), norm(gradient) * norm(vec), 1e-9)
        error = abs(left - right) / scale
        self.worst["identity"] = max(self.worst["identity"], error)
        self.assertLess(error, 1e-12)

    def outputs(self, dim):
        """Each kind; l1 and linf of points where no corner (a sign, another largest) is near."""
        return {"probe": {"type": "values", "at": [[0.31, 0.62, 0.47][:dim], [0.8] * dim]},
                "some": {"type": "values", "on": [5, 9, 0]}, "mean": "mean",
                "l1": {"type": "l1", "on": "boundary"}, "l2": {"type": "l2", "on": "interior"},
                "linf": {"type": "linf", "on": [7]}}

    def everything(self, cloud, dim, upwind="none", scheme="ips", **more):
        """A problem whose every datum depends on the parameters, not always linearly."""
        letters = "xyz"[:dim]
        boundary = [{"on": "boundary", "type": "dirichlet", "value": "wall*(1 + x) + wall^2"},
                    {"on": "right", "type": "robin", "coefficient": "1 + film^2",
                     "value": "film + 0.5*wall"}]
        if dim > 1:
            boundary.append({"on": "bottom", "type": "neumann", "value": "flux*sin(x)"})
        velocity = ["speed*(1 + 0.5*x)", "cos(turn)*speed", "turn"][:dim]
        config = {
            "cloud": cloud, "diffusivity": f"mu*(1 + 0.3*{letters[-1]}) + 0.1*mu*speed^2",
            "velocity": velocity, "source": "1 + heat*x + heat^3", "reaction": "0.5 + decay*x",
            "boundary": boundary, "operator": {"scheme": scheme, "upwind": upwind},
            "parameters": {"mu": 0.7, "speed": 2.0, "turn": 0.4, "heat": 1.1, "decay": 0.3,
                           "wall": 0.6, "flux": 0.8, "film": 0.9, "fixed": 3},
            "inputs": [["mu", "speed", "turn"], ["heat", "decay", "wall", "flux", "film"]],
            "outputs": self.outputs(dim), **more}
        return config, [[0.7, 2.0, 0.4], [1.1, 0.3, 0.6, 0.8, 0.9]]

    def test_steady(self):
        for cloud, dim in ((LINE, 1), (SQUARE, 2), (CUBE, 3)):
            for upwind in ("none", "exact", "cosine"):
                with self.subTest(dim=dim, upwind=upwind):
                    self.check(*self.everything(cloud, dim, upwind))

    def test_steady_other_schemes(self):
        for scheme, upwind in (("lsmps", "none"), ("lsmps", "exact"), ("mps", "cosine"),
                               ("ps", "none"), ("ipsn", "exact")):
            with self.subTest(scheme=scheme, upwind=upwind):
                self.check(*self.everything(SQUARE, 2, upwind, scheme))

    def transient(self, cloud, dim, method, upwind, varies):
        step = 2e-4 if method == "forward-euler" else 5e-3
        config, vectors = self.everything(cloud, dim, upwind)
        config["time"] = {"method": method, "end": 11.3 * step, "step": step,
                          "save": [2.6 * step, 2.9 * step]}
        config["initial"] = "cos(3*x) + start*x + start^2"
        config["parameters"]["start"] = 0.4
        config["inputs"].append(["start"])
        if varies:
            config["velocity"][0] = "speed*(1 + 0.5*x)*(1 + t)"
            config["diffusivity"] = "mu*(1 + 20*t*x)"
            config["source"] = "heat*cos(50*t)"
            config["boundary"][0]["value"] = "wall*(1 + x)*exp(-10*t)"
            config["boundary"][1]["coefficient"] = "1 + film^2 + t"
        return config, [*vectors, [0.4]]

    def test_in_time(self):
        methods = ("forward-euler", "backward-euler", "crank-nicolson", "bdf2")
        for (cloud, dim), method in itertools.product(((LINE, 1), (SQUARE, 2)), methods):
            with self.subTest(dim=dim, method=method):
                upwind = "cosine" if dim == 2 else "none"
                self.check(*self.transient(cloud, dim, method, upwind, varies=False))

    def test_in_time_with_data_that_vary(self):
        for method in ("forward-euler", "backward-euler", "crank-nicolson", "bdf2"):
            with self.subTest(method=method):
                self.check(*self.transient(LINE, 1, method, "cosine", varies=True))

    def test_posted_points_keep_their_numbers(self):
        places = [(k + self.random.uniform(-0.2, 0.2)) / 31 for k in range(1, 31)]
        self.random.shuffle(places)
        config = {"cloud": {"points": [[x] for x in [*places, 0, 1]]}, "diffusivity": "a",
                  "source": [math.sin(k) for k in range(32)], "parameters": {"a": 2, "b": 1},
                  "boundary": [{"on": [30, 31], "type": "dirichlet", "value": "b*x"}],
                  "outputs": [{"type": "values", "on": [31, 3, 30]}, "mean"]}
        model = Model(self, config)
        out = model.evaluate([[2, 1]])
        self.assertEqual((out[0][0], out[0][2]), (1.0, 0.0))
        self.check(config, [[2.0, 1.0]])

    def test_a_parameter_that_nothing_names(self):
        config = {"cloud": SQUARE, "diffusivity": 1, "source": 1, "parameters": {"idle": 1},
                  "boundary": [{"on": "boundary", "type": "dirichlet", "value": 0}]}
        model = Model(self, config)
        self.assertEqual(model.gradient(0, 0, [[5]], [1]), [0])
        self.assertEqual(model.jacobian(0, 0, [[5]], [1]), [0])

    def test_known_derivative(self):
        """mu phi'' = 0, phi(0) = 0, phi(1) = wall: phi = wall x; with a source s, phi(1/2) =
        wall / 2 + s / (8 mu), whose derivatives are known."""
        config = {"cloud": {"lattice": {"lower": [0], "upper": [1], "cells": [20]}},
                  "diffusivity": "mu", "source": "s", "parameters": {"mu": 1, "s": 1, "wall": 1},
                  "boundary": [{"on": "boundary", "type": "dirichlet", "value": "wall*x"}],
                  "outputs": [{"type": "values", "at": [[0.5]]}]}
        model = Model(self, config)
        mu, s, wall = 0.7, 1.3, 0.4
        out = model.evaluate([[mu, s, wall]])[0][0]
        self.assertAlmostEqual(out, wall / 2 + s / (8 * mu), places=12)
        gradient = model.gradient(0, 0, [[mu, s, wall]], [2])
        for got, want in zip(gradient, (-s / (8 * mu**2), 1 / (8 * mu), 0.5)):
            self.assertAlmostEqual(got, 2 * want, places=11)

    def test_norms(self):
        config = {"cloud": LINE, "diffusivity": 1, "source": "8*a", "parameters": {"a": 1},
                  "boundary": [{"on": "boundary", "type": "dirichlet", "value": "-a"}],
                  "outputs": [{"type": "values"}, "mean", "l1", "l2", "linf"]}
        phi, mean, l1, l2, linf = Model(self, config).evaluate([[1.5]])
        n = len(phi)
        self.assertAlmostEqual(mean[0], sum(phi) / n, places=13)
        self.assertAlmostEqual(l1[0], sum(map(abs, phi)) / n, places=13)
        self.assertAlmostEqual(l2[0], math.sqrt(dot(phi, phi) / n), places=13)
        self.assertEqual(linf[0], max(map(abs, phi)))

    def test_a_place_between_points_is_read_linearly(self):
        config = {"cloud": SQUARE, "diffusivity": 1,
                  "boundary": [{"on": "boundary", "type": "dirichlet", "value": "1 + 2*x - 3*y"}],
                  "outputs": [{"type": "values", "at": [[0.123, 0.777], [0, 1], [1, 0.5]]}]}
        out = Model(self, config).evaluate([[]])[0]
        for got, want in zip(out, (1 + 0.246 - 2.331, -2, 1.5)):
            self.assertAlmostEqual(got, want, places=12)

    def test_memory_of_a_march_is_limited(self):
        config, vectors = self.transient(SQUARE, 2, "backward-euler", "none", varies=False)
        config["time"] = {"method": "backward-euler", "end": 1, "step": 1e-7}
        body = {"name": "solve", "outWrt": 0, "inWrt": 0, "input": vectors, "sens": [1, 1],
                "config": config}
        reply = self.request("POST", "/Gradient", json.dumps(body))
        self.assertEqual(reply.status, 500, reply.body)
        self.assertEqual(reply.json["error"]["type"], "InvalidOutput")
        self.assertIn("steps", reply.json["error"]["message"])


class Protocol(daemon.Case):
    stub = False

    def post(self, operation, body, **headers):
        body = body if isinstance(body, (str, bytes)) else json.dumps(body)
        return self.request("POST", "/" + operation, body, headers)

    def assert_error(self, reply, kind, *words, status=400):
        self.assertEqual(reply.status, status, reply.body)
        self.assertEqual(reply.type, "application/json")
        self.assertEqual(set(reply.json), {"error"})
        self.assertEqual(set(reply.json["error"]), {"type", "message"})
        self.assertEqual(reply.json["error"]["type"], kind, reply.body)
        for word in words:
            self.assertIn(word, reply.json["error"]["message"])

    def test_info(self):
        reply = self.get("/Info")
        self.assertEqual(reply.json, {"protocolVersion": 1.0, "models": ["solve"]})
        self.assertIn(b'"protocolVersion":1.0', reply.body)
        self.assertEqual(self.request("HEAD", "/").status, 200)
        self.assertEqual(self.get("/TestShMem").status, 404)
        self.assertEqual(self.post("TestShMem", {}).status, 404)

    def test_replies_have_no_extra_members(self):
        self.assertEqual(self.post("ModelInfo", {"name": "solve"}).json, {
            "support": {"Evaluate": True, "Gradient": True, "ApplyJacobian": True,
                        "ApplyHessian": False}})
        self.assertEqual(self.post("InputSizes", {"name": "solve"}).json, {"inputSizes": [2, 2]})
        self.assertEqual(self.post("OutputSizes", {"name": "solve", "config": {}}).json,
                         {"outputSizes": [1, 1, 1]})
        reply = self.post("Evaluate", {"name": "solve", "input": [[0, 0], [0, 0]], "config": {}})
        self.assertEqual(list(reply.json), ["output"])
        self.assertEqual([len(v) for v in reply.json["output"]], [1, 1, 1])

    def test_content_type_does_not_matter(self):
        body = {"name": "solve", "input": [[0, 0], [0, 0]]}
        for headers in ({}, {"Content_Type": "text/plain"}, {"Content_Type": "application/cbor"},
                        {"Accept": "text/html"}):
            self.assertEqual(self.post("Evaluate", body, **headers).status, 200, headers)

    def test_the_default_config_is_the_schema_file(self):
        config = json.loads((SCHEMAS / "um-bridge" / "default.json").read_text())
        vectors = [[0.1, 0.5], [1, 0.25]]
        explicit = self.post("Evaluate", {"name": "solve", "input": vectors, "config": config})
        default = self.post("Evaluate", {"name": "solve", "input": vectors})
        self.assertEqual(explicit.body, default.body)

    def test_a_solve_request_is_a_config(self):
        inputs = {"cloud": LINE, "diffusivity": "a", "source": "b", "parameters": {"a": 1, "b": 2},
                  "boundary": [{"on": "boundary", "type": "dirichlet", "value": 0}]}
        whole = {"name": "solve", "input": [[2, 3]], "config": {"inputs": inputs}}
        flat = {"name": "solve", "input": [[2, 3]], "config": {**inputs, "inputs": ["a", "b"]}}
        swapped = {"name": "solve", "input": [[3, 2]], "config": {**inputs, "inputs": ["b", "a"]}}
        reply = self.post("Evaluate", whole)
        self.assertEqual(reply.status, 200, reply.body)
        self.assertEqual(reply.body, self.post("Evaluate", flat).body)
        self.assertEqual(reply.body, self.post("Evaluate", swapped).body)
        solution = self.execute(json.dumps({"inputs": {**inputs, "parameters": {"a": 2, "b": 3}},
                                            "outputs": {"solution": {}}})).json["solution"]
        self.assertAlmostEqual(reply.json["output"][0][0], sum(solution) / len(solution), places=14)

    def test_errors_come_in_their_order(self):
        """Of several mistakes the model's name counts first, then the feature, then the input."""
        self.assert_error(self.post("ApplyHessian", {"name": "other", "input": 1}), "ModelNotFound")
        self.assert_error(self.post("ApplyHessian", {"name": "solve", "input": 1}),
                          "UnsupportedFeature")
        self.assert_error(self.post("Evaluate", {"name": "solve", "input": 1}), "InvalidInput")
        for operation in ("ModelInfo", "InputSizes", "OutputSizes", "Evaluate", "Gradient",
                          "ApplyJacobian", "ApplyHessian"):
            self.assert_error(self.post(operation, {"name": "other"}), "ModelNotFound")
            self.assert_error(self.post(operation, {}), "ModelNotFound")
            self.assert_error(self.post(operation, {"name": 7}), "ModelNotFound")

    def test_invalid_input(self):
        good = {"name": "solve", "input": [[0, 0], [0, 0]], "outWrt": 0, "inWrt": 0, "sens": [1]}
        bad = [({"input": [[0, 0]]}, "/input"), ({"input": [[0, 0], [0]]}, "/input/1"),
               ({"input": [0, 0]}, "/input"), ({"input": [[0, 0], [0, "a"]]}, "/input/1/1"),
               ({"input": None}, "/input"), ({"input": []}, "/input"), ({"input": {}}, "/input"),
               ({"outWrt": 3}, "/outWrt"), ({"outWrt": -1}, "/outWrt"), ({"inWrt": 2}, "/inWrt"),
               ({"inWrt": 0.5}, "/inWrt"), ({"sens": [1, 2]}, "/sens"), ({"sens": 1}, "/sens"),
               ({"sens": []}, "/sens"), ({"config": 3}, "/config")]
        for change, pointer in bad:
            with self.subTest(change=change):
                self.assert_error(self.post("Gradient", {**good, **change}), "InvalidInput", pointer)
        for absent in ("input", "outWrt", "inWrt", "sens"):
            body = {key: value for key, value in good.items() if key != absent}
            self.assert_error(self.post("Gradient", body), "InvalidInput", "/" + absent, "missing")
        for text in ("", "{", "[1]", "NaN", b"\xff"):
            with self.subTest(text=text):
                reply = self.post("Evaluate", text)
                self.assert_error(reply, "InvalidInput")

    def test_invalid_config(self):
        good = {"cloud": LINE, "diffusivity": "a", "parameters": {"a": 1}, "inputs": ["a"],
                "boundary": [{"on": "boundary", "type": "dirichlet", "value": 0}]}
        bad = [({"inputs": ["b"]}, "/config/inputs/0"), ({"inputs": ["a", "a"]}, "/config/inputs/1"),
               ({"inputs": [["a"], 3]}, "/config/inputs/1"), ({"inputs": "a"}, "/config/inputs"),
               ({"outputs": []}, "/config/outputs"), ({"outputs": "mean"}, "/config/outputs"),
               ({"outputs": ["median"]}, "/config/outputs/0"),
               ({"outputs": {"m": {"type": "median"}}}, "/config/outputs/m/type"),
               ({"outputs": [{"type": "mean", "at": [[0.5]]}]}, "/config/outputs/0/at"),
               ({"outputs": [{"at": [[0.5, 1]]}]}, "/config/outputs/0/at"),
               ({"outputs": [{"at": [[7]]}]}, "/config/outputs/0"),
               ({"outputs": [{"on": "nowhere"}]}, "/config/outputs/0/on"),
               ({"outputs": [{"on": []}]}, "/config/outputs/0/on"),
               ({"outputs": [{"of": 1}]}, "/config/outputs/0/of"),
               ({"diffusivity": "q"}, "/config/diffusivity"), ({"colour": 1}, "/config/colour"),
               ({"parameters": {"a": "1"}}, "/config/parameters/a"),
               ({"cloud": None}, "/config/cloud")]
        for change, pointer in bad:
            with self.subTest(change=change):
                body = {"name": "solve", "input": [[1]], "config": {**good, **change}}
                self.assert_error(self.post("Evaluate", body), "InvalidInput", pointer)

    def test_a_solve_that_fails(self):
        config = {"cloud": SQUARE, "diffusivity": 1, "parameters": {"a": 1},
                  "boundary": [{"on": "boundary", "type": "neumann", "value": "a"}]}
        for operation, more in (("Evaluate", {}), ("Gradient", {"sens": [1]}),
                                ("ApplyJacobian", {"vec": [1]})):
            body = {"name": "solve", "input": [[1]], "config": config, "outWrt": 0, "inWrt": 0}
            self.assert_error(self.post(operation, {**body, **more}), "InvalidOutput", "singular",
                              status=500)

    def test_an_expression_without_derivative(self):
        config = {"cloud": LINE, "diffusivity": 1, "source": "sqrt(a)", "parameters": {"a": 1},
                  "boundary": [{"on": "boundary", "type": "dirichlet", "value": 0}]}
        body = {"name": "solve", "input": [[0]], "config": config, "outWrt": 0, "inWrt": 0,
                "sens": [1]}
        self.assertEqual(self.post("Evaluate", body).status, 200)
        self.assert_error(self.post("Gradient", body), "InvalidOutput", "derivative", status=500)

    def test_an_upwinding_with_corners(self):
        config = {"cloud": SQUARE, "diffusivity": 0.1, "velocity": ["a", 0], "source": 1,
                  "parameters": {"a": 1}, "operator": {"scheme": "ips", "upwind": "limited"},
                  "boundary": [{"on": "boundary", "type": "dirichlet", "value": 0}]}
        body = {"name": "solve", "input": [[2]], "config": config, "outWrt": 0, "inWrt": 0}
        self.assertEqual(self.post("Evaluate", body).status, 200)
        for operation, more in (("Gradient", {"sens": [1]}), ("ApplyJacobian", {"vec": [1]})):
            self.assert_error(self.post(operation, {**body, **more}), "UnsupportedFeature",
                              "limited")

    def test_a_cloud_by_reference(self):
        points = [[k / 20] for k in range(21)]
        kept = self.request("POST", "/data", json.dumps({"points": points}),
                            {"Content_Type": "application/json"}).json
        config = {"cloud": {"href": kept["href"]}, "diffusivity": "a", "source": 1,
                  "parameters": {"a": 1},
                  "boundary": [{"on": [0, 20], "type": "dirichlet", "value": 0}],
                  "outputs": [{"type": "values", "on": [10]}]}
        body = {"name": "solve", "input": [[2]], "config": config}
        reply = self.post("Evaluate", body)
        self.assertEqual(reply.status, 200, reply.body)
        self.assertAlmostEqual(reply.json["output"][0][0], 1 / 16, places=12)
        config["cloud"]["href"] += "0"
        self.assert_error(self.post("Evaluate", body), "InvalidInput", "/config/cloud/href")

    def test_not_a_process(self):
        listed = [process["id"] for process in self.get("/processes").json["processes"]]
        self.assertNotIn("um-bridge", " ".join(listed))
        self.assertEqual(self.get("/processes/um-bridge").status, 404)
        self.assertEqual(self.execute("{}", "/processes/um-bridge%2FEvaluate/execution").status, 404)


class Faults(daemon.Case):
    """What becomes of a worker is told in UM-Bridge's form."""
    options = ["--workers", "1", "--seconds", "1"]

    def test_faults(self):
        for body in ("abort", "sleep 5", "memory", "hog"):
            reply = self.request("POST", "/Evaluate", body)
            self.assertEqual(reply.status, 500, reply.body)
            self.assertEqual(reply.json["error"]["type"], "InvalidOutput")
            self.daemon.wait_ready()


OPERATIONS = ("ModelInfo", "InputSizes", "OutputSizes", "Evaluate", "Gradient", "ApplyJacobian",
              "ApplyHessian")


class Refusing:
    """What keeps a request from its model is told in UM-Bridge's form, too: its clients read the
    body as JSON and look for "error", whatever the status."""

    def assert_refused(self, reply, status, kind, *words):
        self.assertEqual((reply.status, reply.type), (status, "application/json"), reply.body)
        self.assertEqual(set(reply.json), {"error"}, reply.body)
        self.assertEqual(set(reply.json["error"]), {"type", "message"})
        self.assertEqual(reply.json["error"]["type"], kind)
        for word in words:
            self.assertIn(word, reply.json["error"]["message"])
        if status in (429, 503):
            self.assertGreaterEqual(int(reply.headers["Retry-After"]), 1)


class Tokens(Refusing, access.Guarded):
    limits = {"alice": [], "none": ["jobs=0"], "slow": ["rate=0.01", "burst=1"],
              "small": ["body-bytes=200"]}
    options = ["--workers", "1"]
    stub = False
    body = json.dumps({"name": "solve", "input": [[0, 0], [0, 0]], "config": {}})

    def test_strangers(self):
        wrong = access.basic("alice", "x")
        for method, path in (("GET", "/Info"), *(("POST", "/" + name) for name in OPERATIONS)):
            for headers in ({}, wrong, {"Accept": "application/problem+json"}):
                with self.subTest(path=path, headers=headers):
                    reply = self.daemon.request(method, path, self.body if method == "POST" else
                                                None, headers)
                    self.assert_refused(reply, 401, "Unauthorized", "token")
                    challenges = reply.headers.get_all("WWW-Authenticate")
                    self.assertEqual([text.split()[0] for text in challenges], ["Bearer", "Basic"])
        self.assert_problem(self.get("/jobs"), 401, "token")

    def test_both_ways_in(self):
        """A client that knows URLs only, http://alice:SECRET@HOST, sends HTTP Basic."""
        secret = self.file.secret["alice"]
        for headers in (access.basic("alice", secret), access.bearer(secret)):
            info = self.daemon.request("GET", "/Info", None, headers)
            self.assertEqual(info.json["models"], ["solve"])
            reply = self.daemon.request("POST", "/Evaluate", self.body, headers)
            self.assertEqual(reply.status, 200, reply.body)
            self.assertEqual([len(v) for v in reply.json["output"]], [1, 1, 1])

    def test_limits_of_a_token(self):
        self.assert_refused(self.say("none", "POST", "/Evaluate", self.body), 429,
                            "TooManyRequests", "jobs of the token")
        self.assertEqual(self.say("slow", "GET", "/Info").status, 200)
        for method, path in (("GET", "/Info"), ("POST", "/Evaluate")):
            self.assert_refused(self.say("slow", method, path, self.body), 429, "TooManyRequests",
                                "rate of the token")

    def test_bodies(self):
        long = self.body.ljust(201)
        self.assert_refused(self.say("small", "POST", "/Evaluate", long), 413, "InvalidInput",
                            "201 bytes", "at most 200")
        pieces = self.say("small", "POST", "/Evaluate", iter([long.encode()]))
        self.assert_refused(pieces, 413, "InvalidInput", "200 bytes")
        self.assertEqual(self.say("small", "POST", "/Evaluate", self.body).status, 200)

    def test_pages_of_others(self):
        reply = self.say("alice", "POST", "/Evaluate", self.body, {"Origin": "http://evil.example"})
        self.assert_refused(reply, 403, "Forbidden", "Origin")

    def test_methods(self):
        reply = self.say("alice", "GET", "/Evaluate")
        self.assert_refused(reply, 405, "InvalidInput", "POST")
        self.assertEqual(reply.headers["Allow"], "POST, OPTIONS")
        self.assert_problem(self.say("alice", "GET", "/TestShMem"), 404)


class Heads(Refusing, daemon.Case):
    """Refusals before anybody asks what a request means."""
    options = ["--workers", "1", "--body-bytes", "1000", "--queue", "1"]

    def test_heads(self):
        self.assert_refused(self.request("POST", "/Evaluate", 1001 * "x"), 413, "InvalidInput",
                            "1001 bytes")
        reply = self.request("POST", "/Evaluate", "x", {"X": 20000 * "x"})
        self.assert_refused(reply, 431, "InvalidInput", "header-bytes")
        reply = self.request("POST", "/Evaluate", "x", {"Transfer-Encoding": "gzip"})
        self.assert_refused(reply, 501, "InvalidOutput", "Transfer-Encoding")

    def test_a_full_queue(self):
        head = b"POST /Evaluate HTTP/1.1\r\nHost: a\r\nContent-Length: 8\r\n\r\n"
        with self.daemon.raw() as first, self.daemon.raw() as second:
            for plain, gauge in ((first, 'scatterd_workers{state="busy"} 1'),
                                 (second, "scatterd_queue_length 1")):
                plain.sendall(head + b"sleep 60")
                daemon.wait_until(lambda: gauge in self.get("/metrics").body.decode(), gauge)
            self.assert_refused(self.request("POST", "/Evaluate", "x"), 503, "ServiceUnavailable",
                                "limit: queue")


class Names(Refusing, daemon.Case):
    options = ["--workers", "1", "--hosts", "solve.example"]

    def test_names_of_others(self):
        reply = self.request("GET", "/Info", headers={"Host": "evil.example"})
        self.assert_refused(reply, 421, "Forbidden", "evil.example")


if __name__ == "__main__":
    unittest.main()
