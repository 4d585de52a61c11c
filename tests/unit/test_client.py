#!/usr/bin/env python3
"""The Python client without a daemon: numbers on the wire, pieces of requests, errors, pictures."""

import gzip
import http.server
import io
import itertools
import json
import os
import pathlib
import random
import struct
import sys
import tempfile
import threading
import unittest
from contextlib import redirect_stderr, redirect_stdout

import numpy

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.dont_write_bytecode = True
sys.path.insert(0, str(ROOT / "clients/python"))
import scatterd  # noqa: E402  (found by the line above)
from scatterd import command, plotting, typed_array, wire  # noqa: E402

try:
    import cbor2
except ImportError:
    cbor2 = None

SEED = int(os.environ.get("SCATTERD_SEED", random.randrange(2**32)))


def doubles(count):
    """Doubles of every size, from their bits, finite."""
    numbers = random.Random(SEED)
    made = []
    while len(made) < count:
        (value,) = struct.unpack("<d", struct.pack("<Q", numbers.getrandbits(64)))
        if numpy.isfinite(value):
            made.append(value)
    return numpy.array(made)


class TypedArrays(unittest.TestCase):
    def test_every_tag_is_read(self):
        for tag, name in typed_array.TYPES.items():
            with self.subTest(tag=tag):
                numbers = numpy.array([0, 1, 100], dtype=name)
                read = typed_array.decode(tag, numbers.tobytes())
                self.assertEqual(read.tolist(), [0, 1, 100])
                self.assertTrue(read.dtype.isnative)

    def test_layout_is_that_of_rfc_8746(self):
        tagged = typed_array.encode(numpy.array([1.0]), lambda tag, content: (tag, content))
        self.assertEqual(tagged, (86, bytes.fromhex("000000000000f03f")))
        tagged = typed_array.encode(numpy.array([[1, 2]], dtype="i4"), lambda *both: both)
        self.assertEqual(tagged, (40, [[1, 2], (78, bytes.fromhex("0100000002000000"))]))

    def test_shapes_in_both_orders(self):
        flat = numpy.arange(6.0)
        rows = typed_array.decode(40, [[2, 3], flat])
        columns = typed_array.decode(1040, [[2, 3], flat])
        self.assertEqual(rows.tolist(), [[0, 1, 2], [3, 4, 5]])
        self.assertEqual(columns.tolist(), [[0, 2, 4], [1, 3, 5]])

    def test_other_tags_are_left_alone(self):
        self.assertIsNone(typed_array.decode(1, 0))

    @unittest.skipIf(cbor2 is None, "needs cbor2")
    def test_arrays_survive_cbor(self):
        for name in ("f8", "f4", "i4", "i8", "u1", ">f8", ">i4"):
            for shape in ((12,), (4, 3), (2, 3, 2), (0,), (0, 2)):
                with self.subTest(name=name, shape=shape):
                    array = numpy.arange(numpy.prod(shape), dtype=name).reshape(shape)
                    read = wire.from_cbor(wire.to_cbor({"a": array}))["a"]
                    self.assertEqual(read.shape, shape)
                    self.assertTrue(numpy.array_equal(read, array))

    @unittest.skipIf(cbor2 is None, "needs cbor2")
    def test_slices_and_columns_are_sent_in_row_order(self):
        array = numpy.arange(24.0).reshape(4, 6)
        for view in (array[::2, ::3], array.T, array[:, 1], numpy.asfortranarray(array)):
            self.assertTrue(numpy.array_equal(wire.from_cbor(wire.to_cbor(view)), view))

    @unittest.skipIf(cbor2 is None, "needs cbor2")
    def test_doubles_survive_cbor_bit_for_bit(self):
        array = doubles(1000)
        read = wire.from_cbor(wire.to_cbor(array))
        self.assertEqual(read.tobytes(), array.tobytes(), f"seed {SEED}")


class Json(unittest.TestCase):
    def test_doubles_survive_bit_for_bit(self):
        array = doubles(1000)
        read = wire.to_numpy(json.loads(wire.to_json(array)))
        self.assertEqual(read.tobytes(), array.tobytes(), f"seed {SEED}")

    def test_large_bodies_are_compressed(self):
        body, headers = wire.encode({"a": numpy.zeros(50000)}, "json")
        self.assertEqual(headers["Content-Encoding"], "gzip")
        self.assertEqual(len(json.loads(gzip.decompress(body))["a"]), 50000)
        _, headers = wire.encode({"a": 1}, "json")
        self.assertNotIn("Content-Encoding", headers)

    def test_lists_become_arrays_where_they_are_numbers(self):
        lists = {"a": [[1, 2], [3, 4]], "b": ["x"], "c": [1, None], "d": [[1], [2, 3]]}
        read = wire.to_numpy(lists)
        self.assertEqual(read["a"].shape, (2, 2))
        self.assertEqual(read["b"], ["x"])
        self.assertTrue(numpy.isnan(read["c"][1]))
        self.assertEqual([row.tolist() for row in read["d"]], [[1], [2, 3]])

    def test_what_cannot_be_sent_is_named(self):
        with self.assertRaisesRegex(TypeError, "set cannot be sent"):
            wire.to_json({"a": {1, 2}})


class Pieces(unittest.TestCase):
    def test_lattice_spreads_numbers(self):
        box = scatterd.lattice([0, 0], 1, 4)["lattice"]
        self.assertEqual((box["lower"], box["upper"], box["cells"]), ([0, 0], [1, 1], [4, 4]))
        self.assertEqual(scatterd.lattice(0, 2, 8)["lattice"]["cells"], [8])

    def test_cloud_takes_lines_and_masks(self):
        made = scatterd.cloud([0.0, 0.5, 1.0], groups={"ends": [True, False, True], "none": []})
        self.assertEqual(made["points"].shape, (3, 1))
        ends = numpy.array([True, False, True])
        made = scatterd.cloud([0, 0.5, 1], groups={"ends": ends}, normals={"ends": [[-1], [1]]})
        self.assertEqual(made["groups"]["ends"].tolist(), [0, 2])
        self.assertEqual(made["normals"]["ends"].shape, (2, 1))
        self.assertNotIn("spacing", made)

    def test_conditions(self):
        self.assertEqual(
            scatterd.robin("left", 2, "x"),
            {"on": "left", "type": "robin", "coefficient": 2, "value": "x"},
        )
        self.assertEqual(scatterd.neumann([1], 0, normal=[0, 1])["normal"].tolist(), [0, 1])
        self.assertNotIn("normal", scatterd.neumann("left", 0))
        self.assertEqual(scatterd.dirichlet(numpy.array([2, 3]), 1)["on"].tolist(), [2, 3])

    def test_lattice_points_run_x_fastest_and_keep_the_boundary(self):
        cloud = scatterd.lattice([0, 0], [1, 3], [2, 3], jitter=0.4, seed=9)
        points = scatterd.lattice_points(cloud)
        self.assertEqual(points.shape, (12, 2))
        self.assertEqual(points[:3].tolist(), [[0, 0], [0.5, 0], [1, 0]])
        inner = points[[4, 7]]
        self.assertTrue((numpy.abs(inner - [[0.5, 1], [0.5, 2]]) <= [0.1, 0.2]).all())
        self.assertFalse((inner == [[0.5, 1], [0.5, 2]]).any())

    def test_results_are_attributes_and_items(self):
        document = {"solution": [1, 2], "norms": {"value": {"l2": 0.5}}, "message": "x"}
        result = scatterd.Result(document)
        self.assertEqual(result.norms.l2, result["norms"]["l2"])
        self.assertIsInstance(result.solution, numpy.ndarray)
        self.assertEqual(result.message, "x")
        self.assertIn("solution", dir(result))
        self.assertEqual(scatterd.Result({"values": [3]}).values.tolist(), [3])
        with self.assertRaisesRegex(AttributeError, "no 'gradient'.*solution, norms"):
            result.gradient


class Server:
    """A server of fixed answers, one after the other; `seen` holds the requests."""

    def __init__(self, *answers):
        remaining, seen = list(answers), []

        class Handler(http.server.BaseHTTPRequestHandler):
            protocol_version = "HTTP/1.1"

            def do_POST(self):
                body = self.rfile.read(int(self.headers.get("Content-Length", 0)))
                seen.append((self.path, dict(self.headers), body, self.client_address))
                status, media, content = remaining.pop(0)
                if status is None:  # hang up
                    self.close_connection = True
                    return
                self.send_response(status)
                self.send_header("Content-Type", media)
                self.send_header("Content-Length", str(len(content)))
                self.end_headers()
                self.wfile.write(content)

            do_GET = do_POST

            def log_message(self, *_):
                pass

        self.seen = seen
        self.server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler)
        self.url = f"http://127.0.0.1:{self.server.server_port}"

    def __enter__(self):
        threading.Thread(target=self.server.serve_forever, daemon=True).start()
        return self

    def __exit__(self, *_):
        self.server.shutdown()
        self.server.server_close()


ECHO = (200, "application/json", b'{"message":"x"}')


class Wire(unittest.TestCase):
    def client(self, server, **options):
        made = scatterd.Client(server.url, format="json", **options)
        self.addCleanup(made.close)
        return made

    def test_connection_is_kept(self):
        with Server(ECHO, ECHO) as server:
            client = self.client(server, token="secret")
            self.assertEqual(client.echo("x").message, "x")
            client.echo("x", values=[1])
            (path, headers, body, first), (_, _, second_body, second) = server.seen
        self.assertEqual(first, second)
        self.assertEqual(path, "/processes/echo/execution")
        self.assertEqual(headers["Authorization"], "Bearer secret")
        self.assertEqual(json.loads(body), {"inputs": {"message": "x"}})
        self.assertEqual(json.loads(second_body)["inputs"]["values"], [1])

    def test_a_kept_connection_that_died_is_opened_anew(self):
        with Server(ECHO, (None, "", b""), ECHO) as server:
            client = self.client(server)
            client.echo("x")
            self.assertEqual(client.echo("x").message, "x")
            self.assertEqual(len(server.seen), 3)

    def test_a_fresh_connection_that_dies_is_not_tried_again(self):
        with Server((None, "", b""), ECHO) as server:
            with self.assertRaises(scatterd.UnreachableError):
                self.client(server).echo("x")
            self.assertEqual(len(server.seen), 1)

    def test_outputs_are_named(self):
        with Server(ECHO) as server:
            self.client(server).diagnose({"points": [[0]]}, outputs=["summary"])
            body = json.loads(server.seen[0][2])
        self.assertEqual(body["outputs"], {"summary": {"transmissionMode": "value"}})
        self.assertEqual(set(body["inputs"]), {"cloud"})

    def test_problems_name_the_culprits(self):
        problem = {
            "type": "about:blank",
            "title": "Bad input",
            "status": 400,
            "detail": "/inputs/cloud/points/3: is NaN",
            "errors": [{"pointer": "/inputs/cloud/points/3", "detail": "is NaN"}],
        }
        answer = (400, "application/problem+json", json.dumps(problem).encode())
        with Server(answer) as server:
            with self.assertRaises(scatterd.ScatterdError) as caught:
                self.client(server).echo("x")
        error = caught.exception
        self.assertEqual((error.status, error.title), (400, "Bad input"))
        self.assertEqual(error.errors, [("/inputs/cloud/points/3", "is NaN")])
        self.assertEqual(str(error), "400 Bad input\n  /inputs/cloud/points/3: is NaN")

    def test_answers_of_strangers_are_errors_too(self):
        with Server((502, "text/html", b"<h1>Bad gateway</h1>")) as server:
            with self.assertRaisesRegex(scatterd.ScatterdError, "502.*Bad gateway"):
                self.client(server).echo("x")

    def test_nobody_there_says_how_to_start_one(self):
        with Server() as server:
            url = server.url
        with self.assertRaisesRegex(scatterd.UnreachableError, "Start one with: scatterd"):
            scatterd.Client(url).echo("x")
        self.assertTrue(issubclass(scatterd.UnreachableError, ConnectionError))

    def test_silence_ends_at_the_timeout(self):
        import socket

        with socket.create_server(("127.0.0.1", 0)) as silent:
            client = scatterd.Client(f"http://127.0.0.1:{silent.getsockname()[1]}", timeout=0.2)
            with self.assertRaisesRegex(scatterd.UnreachableError, "no answer within 0.2 s"):
                client.echo("x")

    def test_addresses_are_checked_at_once(self):
        for url in ("127.0.0.1:8480", "ftp://x", "http://"):
            with self.subTest(url), self.assertRaises(ValueError):
                scatterd.Client(url)


class Pictures(unittest.TestCase):
    def picture(self, result, **options):
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder, "picture.png")
            axes = scatterd.plot(result, file=str(file), **options)
            self.assertEqual(file.read_bytes()[:4], b"\x89PNG")
        return axes

    def result(self, cells):
        cloud = scatterd.lattice([0] * len(cells), [1] * len(cells), cells, jitter=0.3)
        points = scatterd.lattice_points(cloud)
        return scatterd.Result({"points": points, "solution": points.sum(axis=1)})

    def test_every_dimension(self):
        for cells in ([10], [6, 6], [3, 3, 3]):
            with self.subTest(cells=cells):
                self.picture(self.result(cells), title="sum")

    def test_points_of_the_request_and_vectors(self):
        cloud = scatterd.lattice([0, 0], [1, 1], 4)
        result = scatterd.Result({"gradient": numpy.ones((25, 2))}, {"cloud": cloud})
        axes = self.picture(result, field="gradient")
        self.assertEqual(axes.child_axes[0].get_ylabel(), "|gradient|")

    def test_holes_stay_open(self):
        points = self.result([20, 20]).points - 0.5
        points = points[numpy.hypot(*points.T) > 0.3]
        made = plotting.triangulation(points)
        centres = points[made.get_masked_triangles()].mean(axis=1)
        self.assertGreater(numpy.hypot(*centres.T).min(), 0.19)
        self.assertGreater(len(centres), 400)

    def shown(self, points):
        """Area of the triangles that are drawn, and how many are not."""
        made = plotting.triangulation(points)
        hidden = numpy.zeros(len(made.triangles), bool) if made.mask is None else made.mask
        return plotting.areas(points, made.triangles[~hidden]).sum(), hidden.sum()

    def test_bays_and_holes_are_not_filled(self):
        for cells, jitter in itertools.product((20, 40, 80), (0, 0.3, 0.6)):
            with self.subTest(cells=cells, jitter=jitter):
                cloud = scatterd.lattice([0, 0], [1, 1], [cells, cells], jitter=jitter)
                points = scatterd.lattice_points(cloud)
                bay = points[~(points > 0.5 + 0.1 / cells).all(axis=1)]
                self.assertAlmostEqual(self.shown(bay)[0], 0.75, delta=0.03)
        for rings in (6, 10, 20):
            with self.subTest(rings=rings):
                radii = numpy.linspace(0.5, 1, rings + 1)
                angles = numpy.linspace(0, 2 * numpy.pi, 10 * rings, endpoint=False)
                ring = numpy.multiply.outer(radii, numpy.exp(1j * angles)).ravel()
                area = self.shown(numpy.column_stack([ring.real, ring.imag]))[0]
                self.assertAlmostEqual(area / (0.75 * numpy.pi), 1, delta=0.03)

    def test_strewn_points_in_an_l_leave_the_bay_open(self):
        points = numpy.random.default_rng(5).random((4000, 2))
        area = self.shown(points[~(points > 0.5).all(axis=1)])[0]
        self.assertAlmostEqual(area, 0.75, delta=0.03)

    def test_uniform_and_graded_clouds_are_drawn_whole(self):
        axis = numpy.linspace(0, 1, 31)
        stretched = {"one": (axis, axis), "squares": (axis**2, axis**2), "thin": (axis**4, axis),
                     "geometric": ((1.15 ** (30 * axis) - 1) / (1.15**30 - 1),) * 2}
        for name, (x, y) in stretched.items():
            with self.subTest(name):
                area, hidden = self.shown(numpy.stack(numpy.meshgrid(x, y), -1).reshape(-1, 2))
                self.assertEqual(hidden, 0)
                self.assertAlmostEqual(area, 1)
        for jitter in (0.3, 0.6, 0.9):
            with self.subTest(jitter=jitter):
                cloud = scatterd.lattice([0, 0], [1, 1], [30, 30], jitter=jitter)
                self.assertEqual(self.shown(scatterd.lattice_points(cloud))[1], 0)

    def test_points_on_a_line_in_the_plane(self):
        points = numpy.column_stack([numpy.arange(5.0), numpy.zeros(5)])
        self.picture(scatterd.Result({"points": points, "solution": points[:, 0]}))

    def test_particles_are_drawn_by_how_fast_they_are(self):
        particles = numpy.random.default_rng(1).random((50, 2))
        self.picture(scatterd.Result({"particles": particles, "velocity": particles}))

    def test_a_field_that_is_not_there(self):
        with self.assertRaisesRegex(ValueError, "no 'artificial_velocity', only .*solution"):
            self.result([10]).plot("artificial_velocity")

    def test_lengths_must_agree(self):
        with self.assertRaisesRegex(ValueError, "3 values for 11 points"):
            scatterd.plot(self.result([10]), [1, 2, 3])


class Command(unittest.TestCase):
    def test_where_options_of_the_connection_stand(self):
        def parsed(*words):
            options = command.parser().parse_args(words)
            return options.url, options.timeout
        self.assertEqual(parsed("processes"), (None, 600))
        self.assertEqual(parsed("--url", "http://a", "processes"), ("http://a", 600))
        self.assertEqual(parsed("processes", "--url", "http://b"), ("http://b", 600))
        self.assertEqual(parsed("--url", "http://a", "--timeout", "5", "processes", "--url",
                                "http://b"), ("http://b", 5))

    def run_command(self, *arguments):
        out, err = io.StringIO(), io.StringIO()
        with redirect_stdout(out), redirect_stderr(err):
            status = command.main(list(arguments))
        return status, out.getvalue(), err.getvalue()

    def test_result_is_shown_written_and_drawn(self):
        points = [[0], [0.5], [1]]
        document = {"solution": [1.5, 2, 3], "points": points, "norms": {"value": {"l2": 0.25}}}
        answer = (200, "application/json", json.dumps(document).encode())
        with tempfile.TemporaryDirectory() as folder, Server(answer, answer) as server:
            here = pathlib.Path(folder)
            (here / "request.json").write_text('{"inputs": {}}')
            shared = ("solve", str(here / "request.json"), "--url", server.url, "--format", "json")
            status, out, err = self.run_command(
                *shared, "--plot", str(here / "a.png"), "--output", str(here / "a.npz")
            )
            self.assertEqual((status, err), (0, ""))
            self.assertRegex(out, r"norms\.l2 +0\.25")
            self.assertTrue((here / "a.png").exists())
            with numpy.load(here / "a.npz") as arrays:
                self.assertEqual(arrays["solution"].tolist(), [1.5, 2, 3])
                self.assertEqual(arrays["norms.l2"], 0.25)
            self.run_command(*shared, "--output", str(here / "a.json"))
            written = json.loads((here / "a.json").read_text())
            self.assertEqual(written["points"], points)

    def test_failures_are_one_line_and_status_1(self):
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder, "request.json")
            for text, message in (("{", "no JSON"), ("[]", "needs an object")):
                file.write_text(text)
                status, _, err = self.run_command("solve", str(file))
                self.assertEqual(status, 1)
                self.assertIn(message, err)
            status, _, err = self.run_command("solve", str(file), "--output", "x.txt")
            self.assertEqual(status, 1)
            self.assertIn(".npz", err)
            status, _, err = self.run_command("solve", str(pathlib.Path(folder, "none.json")))
            self.assertEqual(status, 1)


if __name__ == "__main__":
    print(f"seed {SEED}", file=sys.stderr)
    unittest.main()
