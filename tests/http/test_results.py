#!/usr/bin/env python3
"""http.results: every form of a result, sync and stored: the same numbers, read by numpy, csv, VTK
and the standard library's multipart parser."""

import csv
import email.parser
import email.policy
import io
import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

import numpy

sys.dont_write_bytecode = True
import daemon  # noqa: E402

try:
    import vtkmodules.util.numpy_support as vtk_numpy
    from vtkmodules.vtkIOXML import vtkXMLPolyDataReader
except ImportError:
    vtk_numpy = None

VTP = "application/vnd.vtk.vtp+xml"


def lattice(dim):
    return {"lattice": {"lower": [0] * dim, "upper": [1] * dim, "cells": [6, 5, 4][:dim],
                        "jitter": 0.2, "seed": 5}}


def requests():
    """(process, request) whose outputs have a value per point, in 1, 2 and 3 dimensions."""
    for dim in (1, 2, 3):
        boundary = [{"on": "boundary", "type": "dirichlet", "value": "x"}]
        solve = {"cloud": lattice(dim), "diffusivity": 1, "boundary": boundary, "exact": "x"}
        yield "solve", {"inputs": solve}
        yield "apply", {"inputs": {"cloud": lattice(dim), "field": "x*x + 1"}}
        yield "diagnose", {"inputs": {"cloud": lattice(dim)}}


# Outputs with a value per point, in the order of the document.
FIELDS = {"solve": ["solution"], "apply": ["value", "gradient", "laplacian"],
          "diagnose": ["neighbours", "number_density", "artificial_velocity",
                       "effective_diffusivity"]}
COMPONENTS = {1: ["xx"], 2: ["xx", "yy", "xy"], 3: ["xx", "yy", "zz", "xy", "xz", "yz"]}


def columns_of(name, values, dim):
    """Names of the CSV columns of an output."""
    if name == "effective_diffusivity":
        return [f"{name}_{part}" for part in COMPONENTS[dim]]
    if values.ndim == 1 or values.shape[1] == 1:
        return [name]
    return [f"{name}_{axis}" for axis in "xyz"[:dim]]


class Results(daemon.Case):
    stub = False
    options = ["--workers", "2"]

    def run_sync(self, process, body, **headers):
        return self.execute(json.dumps(body), f"/processes/{process}/execution", **headers)

    def document(self, process, body):
        reply = self.run_sync(process, body)
        self.assertEqual(reply.status, 200, reply.body)
        return {name: numpy.array(value) for name, value in reply.json.items()
                if isinstance(value, list)}

    def points(self, dim):
        solve = {"inputs": {"cloud": lattice(dim), "diffusivity": 1, "boundary": [
            {"on": "boundary", "type": "dirichlet", "value": 0}]}, "outputs": {"points": {}}}
        return self.document("solve", solve)["points"]

    def job(self, process, body):
        """Path of the results of a job."""
        reply = self.run_sync(process, body, Prefer="respond-async")
        self.assertEqual(reply.status, 201, reply.body)
        path = "/jobs/" + reply.json["jobID"]
        info = daemon.wait_until(lambda: (lambda now: now if "finished" in now else None)(
            self.get(path, Prefer="wait=30").json), "its end")
        self.assertEqual(info["status"], "successful", info)
        return path + "/results"

    def all_ways(self, process, body, accept):
        """The replies of a synchronous execution and of a job's results."""
        yield self.run_sync(process, body, Accept=accept)
        yield self.get(self.job(process, body), Accept=accept)

    def test_csv(self):
        for process, body in requests():
            expected = self.document(process, body)
            dim = len(body["inputs"]["cloud"]["lattice"]["lower"])
            for reply in self.all_ways(process, body, "text/csv"):
                with self.subTest(process=process, dim=dim):
                    self.assertEqual((reply.status, reply.type.split(";")[0]), (200, "text/csv"))
                    rows = list(csv.reader(io.StringIO(reply.body.decode())))
                    table = numpy.array([[float(x) for x in row] for row in rows[1:]])
                    names = list("xyz"[:dim])
                    columns = [self.points(dim)]
                    for name in FIELDS[process]:
                        names += columns_of(name, expected[name], dim)
                        columns.append(expected[name].reshape(len(table), -1))
                    self.assertEqual(rows[0], names)
                    numpy.testing.assert_array_equal(table, numpy.hstack(columns))

    def test_vtp(self):
        if vtk_numpy is None:
            self.skipTest("python3-vtk9 is not installed")
        for process, body in requests():
            expected = self.document(process, body)
            dim = len(body["inputs"]["cloud"]["lattice"]["lower"])
            for accept in (VTP, "model/vnd.vtk"):
                reply = self.run_sync(process, body, Accept=accept)
                with self.subTest(process=process, dim=dim, accept=accept):
                    self.assertEqual((reply.status, reply.type), (200, VTP))
                    self.check_vtp(reply.body, process, dim, expected)

    def check_vtp(self, data, process, dim, expected):
        with tempfile.NamedTemporaryFile(suffix=".vtp") as file:
            file.write(data)
            file.flush()
            reader = vtkXMLPolyDataReader()
            reader.SetFileName(file.name)
            reader.Update()
        poly = reader.GetOutput()
        points = vtk_numpy.vtk_to_numpy(poly.GetPoints().GetData())
        numpy.testing.assert_array_equal(points[:, :dim], self.points(dim))
        self.assertFalse(points[:, dim:].any())
        n = len(points)
        self.assertEqual((poly.GetNumberOfVerts(), poly.GetNumberOfCells()), (n, n))
        self.assertEqual([poly.GetCell(k).GetPointId(0) for k in range(n)], list(range(n)))
        fields = poly.GetPointData()
        self.assertEqual([fields.GetArrayName(k) for k in range(fields.GetNumberOfArrays())],
                         FIELDS[process])
        for name in FIELDS[process]:
            array = fields.GetArray(name)
            got = vtk_numpy.vtk_to_numpy(array)
            want = expected[name]
            if want.ndim == 2 and want.shape[1] == dim and dim > 1 and name != "effective_diffusivity":
                self.assertEqual(array.GetNumberOfComponents(), 3)
                self.assertFalse(got[:, dim:].any())
                got = got[:, :dim]
            numpy.testing.assert_array_equal(got.reshape(want.shape), want)
            self.assertEqual(array.GetRange(0), (got.reshape(n, -1)[:, 0].min(),
                                                 got.reshape(n, -1)[:, 0].max()))

    def test_one_output(self):
        for process, body in requests():
            expected = self.document(process, body)
            path = self.job(process, body)
            for name in FIELDS[process]:
                with self.subTest(process=process, name=name):
                    stored = self.get(f"{path}/{name}", Accept="application/x-npy")
                    raw = self.run_sync(process, {**body, "outputs": {name: {}}, "response": "raw"},
                                        Accept="application/x-npy")
                    self.assertEqual(stored.body, raw.body)
                    array = numpy.load(io.BytesIO(stored.body))
                    numpy.testing.assert_array_equal(array, expected[name])
                    self.assertEqual(array.dtype, "int32" if name == "neighbours" else "float64")
                    self.assertEqual(self.get(f"{path}/{name}").json, expected[name].tolist())
                    part = self.get(f"{path}/{name}", Accept="application/x-npy",
                                    Range="bytes=128-135")
                    self.assertEqual((part.status, part.body), (206, stored.body[128:136]))
            self.assertEqual(self.get(path + "/report", Accept="application/x-npy").status, 406)
            self.assertEqual(self.get(path + "/nothing").status, 404)

    def test_multipart(self):
        _, body = list(requests())[4]
        body = {**body, "outputs": {"value": {"format": {"mediaType": "application/x-npy"}},
                                    "gradient": {}}, "response": "raw"}
        for reply in self.all_ways("apply", body, "multipart/related"):
            self.assertEqual(reply.status, 200, reply.body)
            head = f"Content-Type: {reply.type}\r\n\r\n".encode()
            message = email.parser.BytesParser(policy=email.policy.HTTP).parsebytes(head + reply.body)
            parts = {part["Content-ID"]: part for part in message.iter_parts()}
            self.assertEqual(set(parts), {"<value>", "<gradient>"})
            gradient = json.loads(parts["<gradient>"].get_payload(decode=True))
            self.assertEqual(len(gradient[0]), 2)
            self.assertEqual(parts["<value>"].get_content_type(), "application/x-npy")
        plain = self.run_sync("apply", body)
        self.assertEqual(plain.type, "application/json")
        self.assertEqual(plain.json["gradient"], gradient)
        self.assertEqual(plain.json["value"]["encoding"], "base64")

    def test_references_of_a_job(self):
        _, body = list(requests())[1]
        body = {**body, "outputs": {"value": {"transmissionMode": "reference"}, "gradient": {}}}
        path = self.job("apply", body)
        result = self.get(path).json
        self.assertTrue(result["value"]["href"].endswith(path + "/value"))
        self.assertEqual(len(self.get(path + "/value").json), len(result["gradient"]))
        body = {**body, "outputs": {"value": {"transmissionMode": "reference"}}, "response": "raw"}
        reply = self.get(self.job("apply", body))
        self.assertEqual(reply.status, 204)
        self.assertIn('rel="value"', reply.headers["Link"])

    def test_not_acceptable_before_the_work(self):
        _, body = list(requests())[1]
        only = {**body, "outputs": {"report": {}}}
        self.assert_problem(self.run_sync("apply", only, Accept=VTP), 406, "application/json")
        self.assert_problem(self.run_sync("apply", body, Accept="application/x-npy"), 406)
        self.assert_problem(self.run_sync("echo", {"inputs": {"message": "m"}}, Accept="text/csv"), 406)

    def test_too_large_is_refused_with_the_estimate(self):
        cloud = {"lattice": {"lower": [0, 0, 0], "upper": [1, 1, 1], "cells": [110, 110, 110]}}
        body = {"inputs": {"cloud": cloud, "diffusivity": 1, "solver": {"method": "direct"}, "boundary": [
            {"on": "boundary", "type": "dirichlet", "value": 0}]}}
        for prefer in ("", "respond-async"):
            self.assert_problem(self.run_sync("solve", body, Prefer=prefer), 422, "memory")


class CommandLine(unittest.TestCase):
    """`scatterd run`: the same forms by the ending of a file, inputs from files beside the request."""

    def run_request(self, folder, request, out):
        (folder / "request.json").write_text(json.dumps(request))
        return subprocess.run(
            [daemon.program(stub=False), "run", "--process", "apply", "-o", str(folder / out),
             str(folder / "request.json")], capture_output=True, text=True, check=False)

    def test_files(self):
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            points = numpy.random.default_rng(11).random((30, 2))
            numpy.save(folder / "points.npy", points)
            numpy.savetxt(folder / "field.csv", points[:, 0], header="phi")
            request = {"inputs": {"cloud": {"href": "points.npy"}, "field": {"href": "field.csv"}},
                       "outputs": {"gradient": {}}}
            self.assertEqual(self.run_request(folder, request, "out.csv").returncode, 0)
            table = numpy.loadtxt(folder / "out.csv", delimiter=",", skiprows=1)
            numpy.testing.assert_array_equal(table[:, :2], points)
            numpy.testing.assert_allclose(table[:, 2:], [[1, 0]] * 30, atol=1e-9)
            self.assertEqual(self.run_request(folder, request, "out.vtp").returncode, 0)
            self.assertIn(b"<PolyData>", (folder / "out.vtp").read_bytes())
            request["response"] = "raw"
            self.assertEqual(self.run_request(folder, request, "out.npy").returncode, 0)
            numpy.testing.assert_array_equal(numpy.load(folder / "out.npy"), table[:, 2:])

    def test_problems(self):
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            for href, word in (("none.npy", "No such file"), ("http://a/b", "another host")):
                request = {"inputs": {"cloud": {"href": href}, "field": 1}}
                done = self.run_request(folder, request, "out.json")
                self.assertEqual(done.returncode, 1)
                self.assertIn(word, done.stderr)
            request = {"inputs": {"cloud": lattice(2), "field": 1}}
            self.assertEqual(self.run_request(folder, request, "out.npy").returncode, 1)


if __name__ == "__main__":
    unittest.main()
