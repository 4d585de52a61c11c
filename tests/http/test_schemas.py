#!/usr/bin/env python3
"""Every example against a running daemon, whose answers keep the schemas it serves."""

import json
import pathlib
import sys
import unittest

import cbor2
from jsonschema import Draft4Validator

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.dont_write_bytecode = True
sys.path[:0] = [str(ROOT / "schemas"), str(ROOT / "clients/python"), str(ROOT / "tests/http")]
import build  # noqa: E402  (found by the line above)
from daemon import Daemon  # noqa: E402
from scatterd import wire  # noqa: E402

JSON, CBOR, PROBLEM = "application/json", "application/cbor", "application/problem+json"
# Examples whose solution is a polynomial that the operator is exact for, or nodally exact.
EXACT = (
    "all-fields boundary-value-by-point-of-the-cloud later-entry-wins neumann-normal-by-point "
    "neumann-on-listed-lattice-points neumann-own-normal no-boundary-but-reaction one-dimension "
    "operator-every-member posted posted-groups-normals posted-line posted-line-flat robin "
    "scheme-ips scheme-ipsn scheme-lsmps scheme-mps scheme-ps three-dimensions time-dependent-data"
).split()


def setUpModule():
    global daemon, connection
    daemon = Daemon(stub=False)
    unittest.addModuleCleanup(stop)
    daemon.wait_ready()
    connection = daemon.connect()
    unittest.addModuleCleanup(connection.close)


def stop():
    """Stops the daemon, which must have come through all of it unharmed."""
    status, log = daemon.stop(), "\n".join(daemon.log)
    assert status == 0 and "Sanitizer" not in log and "runtime error" not in log, log


def exchange(method, path, body=None, content_type=JSON, accept=f"{JSON}, {PROBLEM}"):
    """(status, media type, body) of an answer."""
    connection.request(method, path, body, {"Content-Type": content_type, "Accept": accept})
    answer = connection.getresponse()
    return answer.status, answer.headers["Content-Type"], answer.read()


def get(path):
    status, _, body = exchange("GET", path)
    return status, json.loads(body)


def post(process, body):
    """(status, document) of an execution."""
    status, media, answer = exchange("POST", f"/processes/{process}/execution", body)
    return status, media, json.loads(answer)


def examples(kind):
    """(process, file name, document) of every example that is `ok` or `bad`."""
    for path in sorted((ROOT / "schemas/examples").glob(f"*.{kind}-*.json")):
        yield path.name.split(".")[0], path.name, json.loads(path.read_text(encoding="utf-8"))


def closed(schema):
    """The schema with every object closed that names its members: nothing undocumented."""
    if isinstance(schema, list):
        return [closed(item) for item in schema]
    if not isinstance(schema, dict):
        return schema
    made = {key: closed(value) for key, value in schema.items()}
    if isinstance(schema.get("properties"), dict):
        made.setdefault("additionalProperties", False)
    return made


def complaints(schema, document):
    """What is wrong with a document, members that its schema does not know included."""
    found = Draft4Validator(closed(build.inline(schema))).iter_errors(document)
    return [f"{'/'.join(map(str, error.absolute_path))}: {error.message[:200]}" for error in found]


def wanted_outputs(process, request):
    """Names of the outputs that must be in the result document of a request."""
    outputs = build.process(process)["outputs"]
    return list(request.get("outputs") or build.names_required(outputs))


def built(document):
    """A document as build.py makes it, with the daemon's address put in."""
    return json.loads(json.dumps(document).replace("{B}", f"http://{daemon.address}"))


def without_times(result):
    """A result but for what differs from run to run: its report, and the seconds of table rows."""
    kept = {name: value for name, value in result.items() if name != "report"}
    for row in kept.get("table", []):
        del row["seconds"]
    return kept


def skip_what_is_missing(test, result):
    """A daemon may be built without PETSc."""
    if isinstance(result, dict) and "needs PETSc" in result.get("detail", ""):
        test.skipTest(result["detail"])


class Documents(unittest.TestCase):
    def test_served_as_built(self):
        version = get("/processes/echo")[1]["version"]
        names = {"landing.json": "/", "conformance.json": "/conformance", "openapi.json": "/api"}
        for name, document in build.documents(version).items():
            path = names.get(name, "/" + name.removesuffix(".json"))
            with self.subTest(path):
                self.assertEqual(get(path), (200, built(document)))

    def test_health_keeps_its_schema(self):
        for path in ("/healthz", "/readyz"):
            status, document = get(path)
            self.assertEqual(status, 200)
            self.assertEqual(complaints(build.load("health.json"), document), [])


class Examples(unittest.TestCase):
    def test_good_ones_are_answered_and_results_keep_their_schema(self):
        for process, name, request in examples("ok"):
            with self.subTest(name):
                status, _, result = post(process, json.dumps(request))
                if process == "batch":
                    self.assertEqual(status, 201, result)
                    self.check_batch(result)
                    continue
                skip_what_is_missing(self, result)
                self.assertEqual(status, 200, result)
                if request.get("response") == "raw":
                    continue
                self.assertEqual(complaints(build.result_schema(process), result), [])
                self.assertEqual(set(wanted_outputs(process, request)) - set(result), set())

    def check_batch(self, info):
        """A batch becomes a job, whose documents keep their schemas as well."""
        self.assertEqual(complaints(build.load("status-info.json"), info), [])
        path = f"/jobs/{info['jobID']}"
        while info["status"] in ("accepted", "running"):
            connection.request("GET", path, headers={"Prefer": "wait=50"})
            info = json.loads(connection.getresponse().read())
        self.assertEqual((info["status"], info["message"]),
                         ("successful", f"{info['parts']} requests successful, 0 not"))
        self.assertEqual(complaints(build.load("status-info.json"), info), [])
        self.assertEqual(complaints(build.load("job-list.json"), get("/jobs")[1]), [])
        status, document = get(path + "/results")
        self.assertEqual((status, len(document["results"])), (200, info["parts"]))
        for entry in document["results"]:
            self.assertEqual(complaints(build.load("batch-entry.json"), entry), [])
            self.assertIn("results", entry)

    def test_solutions_that_the_operators_hold_exactly_are_exact(self):
        for case in EXACT:
            with self.subTest(case):
                path = ROOT / f"schemas/examples/solve.ok-{case}.json"
                result = post("solve", path.read_text(encoding="utf-8"))[2]
                self.assertLess(result["norms"]["value"]["linf_all"], 1e-11)

    def test_raw_gives_the_bare_value(self):
        request = {"inputs": {"message": "bare"}, "outputs": {"message": {}}, "response": "raw"}
        self.assertEqual(post("echo", json.dumps(request))[2], "bare")

    def test_good_ones_have_the_same_results_in_cbor(self):
        for process, name, request in examples("ok"):
            if process == "batch":
                continue
            with self.subTest(name):
                path = f"/processes/{process}/execution"
                status, media, body = exchange("POST", path, cbor2.dumps(request), CBOR, CBOR)
                if media == PROBLEM:
                    skip_what_is_missing(self, json.loads(body))
                self.assertEqual((status, media), (200, CBOR))
                binary = json.loads(wire.to_json(wire.from_cbor(body)))
                text = post(process, json.dumps(request))[2]
                if request.get("response") != "raw":
                    binary, text = without_times(binary), without_times(text)
                self.assertEqual(binary, text)

    def test_bad_ones_are_refused_where_they_are_wrong(self):
        for process, name, case in examples("bad"):
            with self.subTest(name, why=case["why"]):
                body = case["text"] if "text" in case else json.dumps(case["request"])
                status, media, problem = post(process, body)
                self.assertEqual((status, media), (case["status"], PROBLEM), problem)
                self.assertEqual(complaints(build.load("problem.json"), problem), [])
                pointers = [error["pointer"] for error in problem.get("errors", [])]
                self.assertIn(case["pointer"], pointers, problem)

    def test_bad_ones_are_refused_in_cbor_too(self):
        for process, name, case in examples("bad"):
            if "request" not in case:
                continue
            with self.subTest(name, why=case["why"]):
                path = f"/processes/{process}/execution"
                body = cbor2.dumps(case["request"])
                status, _, answer = exchange("POST", path, body, CBOR, f"{CBOR}, {PROBLEM}")
                self.assertEqual(status, case["status"], answer)


if __name__ == "__main__":
    unittest.main()
