#!/usr/bin/env python3
"""The Python client against a running daemon."""

import json
import os
import pathlib
import subprocess
import sys
import tempfile
import threading
import unittest
import urllib.request

import numpy

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.dont_write_bytecode = True
sys.path[:0] = [str(ROOT / "clients/python"), str(ROOT / "tests/http")]
import scatterd  # noqa: E402  (found by the line above)
from daemon import Daemon  # noqa: E402

SQUARE = scatterd.lattice([0, 0], [1, 1], 8, jitter=0.3, seed=4)


def setUpModule():
    global url
    daemon = Daemon(stub=False)
    unittest.addModuleCleanup(daemon.stop)
    daemon.wait_ready()
    url = f"http://{daemon.address}"


class Files(unittest.TestCase):
    """What the client saves is, byte for byte, what the service sends."""

    ENDINGS = {".vtp": "application/vnd.vtk.vtp+xml", ".csv": "text/csv"}

    def served(self, process, inputs, outputs, media):
        body = json.dumps({"inputs": inputs, "outputs": {name: {} for name in outputs}})
        request = urllib.request.Request(
            f"{url}/processes/{process}/execution", body.encode(),
            {"Content-Type": "application/json", "Accept": media})
        with urllib.request.urlopen(request) as reply:
            return reply.read()

    def table(self, data):
        rows = data.decode().splitlines()
        return rows[0], [[float(x) for x in row.split(",")] for row in rows[1:]]

    def test_saved_is_served(self):
        with scatterd.Client(url) as client, tempfile.TemporaryDirectory() as folder:
            diagnosis = client.diagnose(SQUARE)
            names = [name for name in diagnosis if name not in ("summary", "report")]
            for ending, media in self.ENDINGS.items():
                file = pathlib.Path(folder) / ("saved" + ending)
                diagnosis.save(str(file))
                served = self.served("diagnose", {"cloud": SQUARE}, names, media)
                if ending == ".csv":
                    self.assertEqual(self.table(file.read_bytes()), self.table(served))
                else:
                    mark = b'encoding="raw">\n_'
                    self.assertEqual(file.read_bytes().split(mark, 1)[1],
                                     served.split(mark, 1)[1])

    def test_arrays(self):
        with scatterd.Client(url) as client, tempfile.TemporaryDirectory() as folder:
            result = client.apply(SQUARE, "x")
            result.save(folder + "/all.npz")
            result.save(folder + "/one.npy", "gradient")
            result.save(folder + "/all.json")
            numpy.testing.assert_array_equal(numpy.load(folder + "/one.npy"), result.gradient)
            numpy.testing.assert_array_equal(numpy.load(folder + "/all.npz")["value"], result.value)
            with open(folder + "/all.json", encoding="utf-8") as file:
                self.assertEqual(json.load(file)["gradient"], result.gradient.tolist())
            for name, output in (("/x.npy", None), ("/x.txt", None), ("/x.csv", "nothing")):
                with self.assertRaises(ValueError):
                    result.save(folder + name, output)

    def test_uploaded(self):
        points = numpy.random.default_rng(7).random((40, 2))
        with scatterd.Client(url) as client:
            direct = client.apply(scatterd.cloud(points), "x*y")
            for value in (points, numpy.asfortranarray(points), scatterd.cloud(points)):
                there = client.upload(value)
                again = client.apply(there, "x*y")
                numpy.testing.assert_array_equal(again.gradient, direct.gradient)


class Formats(unittest.TestCase):
    def clients(self):
        for format in ("json", "cbor"):
            with self.subTest(format=format), scatterd.Client(url, format=format) as client:
                yield client

    def test_plane_is_solved_exactly(self):
        for client in self.clients():
            result = client.solve(
                cloud=SQUARE,
                diffusivity="1 + x",
                source=-1,
                boundary=[scatterd.dirichlet("boundary", "a*x")],
                parameters={"a": 1},
                exact="x",
            )
            self.assertEqual(result.solution.shape, (81,))
            self.assertEqual(result.points.shape, (81, 2))
            self.assertLess(result.norms.linf, 1e-12)
            self.assertLess(numpy.abs(result.solution - result.points[:, 0]).max(), 1e-12)

    def test_both_formats_give_the_same_bits(self):
        results = [client.apply(SQUARE, "sin(3*x)*y") for client in self.clients()]
        for name in ("value", "gradient", "laplacian"):
            first, second = (result[name] for result in results)
            self.assertEqual(first.shape, second.shape)
            self.assertEqual(first.tobytes(), second.tobytes(), name)

    def test_arrays_go_in(self):
        points = scatterd.lattice_points(SQUARE)
        rim = (points == 0).any(axis=1) | (points == 1).any(axis=1)
        for client in self.clients():
            result = client.solve(
                cloud=scatterd.cloud(points, groups={"rim": rim}),
                velocity=numpy.ones_like(points),
                diffusivity=numpy.ones(len(points)),
                source=numpy.full(len(points), 2.0),
                boundary=[scatterd.dirichlet("rim", points[rim].sum(axis=1))],
                exact=points.sum(axis=1),
            )
            self.assertTrue(numpy.array_equal(result.points, points))
            self.assertLess(result.norms.linf_all, 1e-11)

    def test_float32_and_single_points_go_in(self):
        points = numpy.linspace(0, 1, 9, dtype=numpy.float32)
        for client in self.clients():
            result = client.solve(
                scatterd.cloud(points),
                diffusivity=1,
                boundary=[scatterd.dirichlet([0, 8], numpy.array([1, 2], dtype=numpy.float32))],
            )
            self.assertLess(numpy.abs(result.solution - 1 - points).max(), 1e-12)

    def test_history_is_rows_by_time(self):
        for client in self.clients():
            result = client.solve(
                cloud=scatterd.lattice(0, 1, 16),
                diffusivity=1,
                boundary=[scatterd.dirichlet("boundary", 0)],
                initial="sin(pi*x)",
                time={"end": 0.1, "step": 0.01, "save": [0.05, 0.1]},
            )
            self.assertEqual(result.history.t.tolist(), [0.05, 0.1])
            self.assertEqual(result.history.solution.shape, (2, 17))
            self.assertTrue(numpy.array_equal(result.history.solution[1], result.solution))

    def test_large_json_bodies_travel_compressed(self):
        points = scatterd.lattice_points(scatterd.lattice([0, 0], [1, 1], 60))
        with scatterd.Client(url, format="json") as client:
            result = client.diagnose(scatterd.cloud(points), outputs=["neighbours"])
        self.assertEqual(set(result), {"neighbours"})
        self.assertEqual(result.neighbours.shape, (61 * 61,))


class Service(unittest.TestCase):
    def test_lattices_are_the_same_on_both_sides(self):
        for cells, jitter, seed in (([9], 0.5, 1), ([5, 7], 0.3, 2**53 - 1), ([3, 4, 5], 0.9, 0)):
            cloud = scatterd.lattice([-1] * len(cells), [2] * len(cells), cells, jitter, seed)
            with self.subTest(cells=cells), scatterd.Client(url) as client:
                boundary = [scatterd.dirichlet("boundary", 0)]
                result = client.solve(cloud, 1, boundary=boundary, outputs=["points"])
                points = scatterd.lattice_points(cloud)
                self.assertEqual(result.points.tobytes(), points.tobytes())

    def test_errors_point_to_the_culprits(self):
        with scatterd.Client(url) as client:
            with self.assertRaises(scatterd.ScatterdError) as caught:
                client.solve(SQUARE, "1 +", operator={"scheme": "sph"})
        error = caught.exception
        self.assertEqual(error.status, 400)
        pointers = {pointer for pointer, _ in error.errors}
        self.assertEqual(pointers, {"/inputs/diffusivity", "/inputs/operator/scheme"})
        self.assertIn("/inputs/operator/scheme: ", str(error))

    def test_not_a_number_is_found_in_both_formats(self):
        points = numpy.array([[0.0], [numpy.nan], [1.0]])
        for format in ("json", "cbor"):
            with self.subTest(format=format), scatterd.Client(url, format=format) as client:
                with self.assertRaisesRegex(scatterd.ScatterdError, "/inputs/cloud/points/1/0"):
                    client.diagnose({"points": points})

    def test_unknown_processes_are_refused(self):
        with scatterd.Client(url) as client:
            with self.assertRaises(scatterd.ScatterdError) as caught:
                client.execute("guess", {})
        self.assertEqual(caught.exception.status, 404)

    def test_processes_are_listed_and_described(self):
        with scatterd.Client(url) as client:
            names = [process["id"] for process in client.processes()]
            self.assertEqual(names, ["solve", "apply", "diagnose", "study", "flow", "echo", "batch"])
            self.assertIn("cloud", client.process("solve")["inputs"])

    def test_unix_sockets_serve_as_well(self):
        local = Daemon(stub=False, unix=True)
        self.addCleanup(local.stop)
        local.wait_ready()
        for format in ("json", "cbor"):
            with scatterd.Client(f"unix:{local.socket}", format=format) as client:
                self.assertEqual(client.echo("x", values=[1, 2]).values.tolist(), [1, 2])
                self.assertEqual(client.processes()[0]["id"], "solve")

    def test_threads_share_a_client(self):
        found = {}
        with scatterd.Client(url) as client:

            def run(k):
                found[k] = client.echo(f"message {k}", values=[k]).message
                client.close()

            threads = [threading.Thread(target=run, args=(k,)) for k in range(8)]
            for thread in threads:
                thread.start()
            for thread in threads:
                thread.join()
        self.assertEqual(found, {k: f"message {k}" for k in range(8)})


class Readme(unittest.TestCase):
    def test_quick_start_runs_as_printed(self):
        text = (ROOT / "clients/python/README.md").read_text(encoding="utf-8")
        program = text.split("```python\n")[1].split("```")[0]
        self.assertIn("http://127.0.0.1:8480", program)
        environment = {**os.environ, "PYTHONPATH": str(ROOT / "clients/python")}
        with tempfile.TemporaryDirectory() as folder:
            done = subprocess.run(
                [sys.executable, "-B", "-c", program.replace("http://127.0.0.1:8480", url)],
                cwd=folder,
                env=environment,
                capture_output=True,
                text=True,
                check=False,
            )
            self.assertEqual((done.returncode, done.stderr), (0, ""))
            highest, neighbours, seconds = map(float, done.stdout.split())
            self.assertTrue(0.9 < highest <= 1.001 and neighbours > 5 and seconds > 0)
            self.assertTrue(pathlib.Path(folder, "layer.png").exists())


class Command(unittest.TestCase):
    def run_command(self, *arguments):
        environment = {
            **os.environ,
            "PYTHONPATH": str(ROOT / "clients/python"),
            "SCATTERD_URL": url,
        }
        command = [sys.executable, "-B", "-m", "scatterd", *arguments]
        return subprocess.run(command, env=environment, capture_output=True, text=True, check=False)

    def test_request_to_picture_and_arrays(self):
        request = ROOT / "schemas/examples/solve.ok-jittered.json"
        with tempfile.TemporaryDirectory() as folder:
            picture, arrays = (str(pathlib.Path(folder, name)) for name in ("a.png", "a.npz"))
            done = self.run_command("solve", str(request), "--plot", picture, "--output", arrays)
            self.assertEqual((done.returncode, done.stderr), (0, ""))
            self.assertIn("norms.l2", done.stdout)
            self.assertEqual(pathlib.Path(picture).read_bytes()[:4], b"\x89PNG")
            with numpy.load(arrays) as saved:
                self.assertEqual(saved["solution"].shape, (17 * 17,))

    def test_refusals_are_readable(self):
        example = ROOT / "schemas/examples/solve.bad-operator-radius-large.json"
        case = json.loads(example.read_text(encoding="utf-8"))
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder, "request.json")
            file.write_text(json.dumps(case["request"]))
            done = self.run_command("solve", str(file))
        self.assertEqual(done.returncode, 1)
        self.assertIn("/inputs/operator/radius: ", done.stderr)
        self.assertNotIn("Traceback", done.stderr)

    def test_processes(self):
        done = self.run_command("processes")
        self.assertEqual(done.returncode, 0)
        self.assertRegex(done.stdout, r"(?m)^solve +\w")


class Guarded(unittest.TestCase):
    """A service that wants a token, over TLS with a certificate of its own."""

    @classmethod
    def setUpClass(cls):
        room = tempfile.TemporaryDirectory()
        cls.addClassCleanup(room.cleanup)
        cls.pem, key = f"{room.name}/pem", f"{room.name}/key"
        subprocess.run(["openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt",
                        "ec_paramgen_curve:prime256v1", "-nodes", "-days", "2", "-subj", "/CN=me",
                        "-addext", "subjectAltName=IP:127.0.0.1", "-keyout", key, "-out", cls.pem],
                       check=True, capture_output=True)
        made = subprocess.run([os.environ["SCATTERD"], "token", "me"], check=True,
                              capture_output=True, text=True)
        cls.token = made.stderr.split()[-1]
        pathlib.Path(room.name, "tokens").write_text(made.stdout)
        cls.daemon = Daemon("--tokens", f"{room.name}/tokens", "--tls-certificate", cls.pem,
                            "--tls-key", key, stub=False)
        cls.addClassCleanup(cls.daemon.stop)
        cls.url = f"https://{cls.daemon.address}"

    def test_token_and_certificate(self):
        with scatterd.Client(self.url, token=self.token, ca=self.pem) as client:
            self.assertEqual(client.echo("x")["message"], "x")
            kept = client.upload(numpy.ones(81))
            job = client.submit("apply", {"cloud": SQUARE, "field": kept})
            self.assertEqual(len(job.wait().result()["value"]), 81)

    def test_refusals(self):
        with scatterd.Client(self.url, ca=self.pem) as client:
            with self.assertRaises(scatterd.ScatterdError) as refused:
                client.echo("x")
            self.assertEqual(refused.exception.status, 401)
        with scatterd.Client(self.url, token=self.token) as client:  # a stranger's certificate
            with self.assertRaises(scatterd.UnreachableError):
                client.echo("x")

    def test_command(self):
        environment = {**os.environ, "PYTHONPATH": str(ROOT / "clients/python"),
                       "SCATTERD_URL": self.url, "SCATTERD_CA": self.pem}
        words = [sys.executable, "-m", "scatterd", "processes"]
        for extra, more, status in (([], {"SCATTERD_TOKEN": self.token}, 0),
                                    (["--token", self.token, "--ca", self.pem], {}, 0), ([], {}, 1)):
            done = subprocess.run([*words, *extra], env={**environment, **more}, check=False,
                                  capture_output=True, text=True)
            self.assertEqual(done.returncode, status, done.stderr)


if __name__ == "__main__":
    unittest.main()
