#!/usr/bin/env python3
"""http.openapi: GET /api against the daemon, both ways. Its route table and the document name the
same methods and paths; the sources use no field, argument or status that the document lacks;
traffic of every operation is recorded and validated by packages from npm (openapi/validate.mjs),
and what the document promises is seen in it. The document itself passes the official schema of
OpenAPI 3.0 and Redocly's recommended rules.

Needs `.ci/install tests`, which fetches the packages.
"""

import contextlib
import gzip
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import threading
import unittest

sys.dont_write_bytecode = True
import daemon  # noqa: E402

HERE = pathlib.Path(__file__).resolve().parent
SKIPPED = 77  # what ctest takes for "skipped"
ROOT = HERE.parents[1]
FRONT = ROOT / "server" / "front"
EXAMPLES = ROOT / "schemas" / "examples"
sys.path.insert(0, str(ROOT / "schemas"))
import openapi as source  # noqa: E402

LATTICE = {"lattice": {"lower": [0, 0], "upper": [1, 1], "cells": [6, 6]}}
SMALL = {"inputs": {"cloud": LATTICE, "diffusivity": 1, "source": 1, "boundary": [
    {"on": "boundary", "type": "dirichlet", "value": 0}]}}
SINGULAR = {"inputs": {**SMALL["inputs"], "boundary": [
    {"on": "boundary", "type": "neumann", "value": 1}]}}
MODEL = {"name": "solve", "input": [[0, 0], [0, 0]], "config": {}}

# Documented answers that this test cannot bring about, and why.
NOT_SEEN = {
    "500": "takes a crash of the worker or of the store (http.faults, http.jobs.full)",
    "507": "takes a full disk (http.jobs.full)",
    "408": "takes the patience of a slow client (http.faults)",
}

EVERYWHERE = source.OF_EVERY_REQUEST + source.OF_EVERY_CHANGE

RARE = {
    ("/data", "post", "422"): "takes an upload beyond the memory of a worker",
    ("/data", "post", "504"): "takes an upload that is read for longer than the time limit",
}


def echo(pause, message="hello"):
    return {"inputs": {"message": message, "pause": pause}}


def refuse(constant):
    """NaN and the like are no JSON."""
    raise ValueError(constant)


class Recorder:
    """Talks to a daemon and keeps what was said."""

    def __init__(self, server):
        self.server, self.pairs, self.lock = server, [], threading.Lock()

    def __call__(self, method, path, body=None, headers=None, keep=True):
        fields = {"Accept": "*/*", **(headers or {})}
        data = json.dumps(body).encode() if isinstance(body, (dict, list)) else body
        if data is not None:
            fields.setdefault("Content-Type", "application/json")
        sent = gzip.compress(data) if fields.get("Content-Encoding") == "gzip" else data
        connection = self.server.connect(60)
        try:
            connection.putrequest(method, path, skip_host="Host" in fields,
                                  skip_accept_encoding=True)
            for name, value in fields.items():
                connection.putheader(name, value)
            if sent is not None:
                connection.putheader("Content-Length", str(len(sent)))
            connection.endheaders(sent)
            reply = daemon.Reply(connection.getresponse())
        finally:
            connection.close()
        if keep:
            self.keep(method, path, fields, data, reply)
        return reply

    def keep(self, method, path, fields, data, reply):
        request = {"method": method, "path": path, "headers": fields}
        response = {"status": reply.status, "headers": dict(reply.headers)}
        for part, kind, text in ((request, fields.get("Content-Type"), data),
                                 (response, reply.type, reply.body)):
            if kind and "json" in kind and "ndjson" not in kind and text and (
                    "Content-Encoding" not in part["headers"] or part is request):
                with contextlib.suppress(ValueError):
                    body = json.loads(text, parse_constant=refuse)
                    json.dumps(body, allow_nan=False)  # 1e400 is infinite
                    part["body"] = body
        with self.lock:
            self.pairs.append({"request": request, "response": response})


def execute(say, body, process="solve", **headers):
    named = {name.replace("_", "-"): value for name, value in headers.items()}
    return say("POST", f"/processes/{process}/execution", body, named)


# --- What is said ------------------------------------------------------------------------------


def talk_of_service(say):
    for path in ("/", "/api", "/conformance", "/processes", "/processes/solve", "/healthz",
                 "/readyz", "/metrics", "/Info", "/jobs", "/assets/nothing"):
        for method in ("GET", "HEAD", "OPTIONS", "PUT"):
            say(method, path)
    say("GET", "/api", headers={"Accept": "text/html"})
    say("GET", "/", headers={"Accept": "text/html", "Accept-Encoding": "gzip"})
    page = say("GET", "/", headers={"Accept": "text/html"})
    if page.headers["ETag"]:
        for method in ("GET", "HEAD"):
            say(method, "/", headers={"Accept": "text/html", "If-None-Match": page.headers["ETag"]})
    for name in re.findall(r'"/assets/([^"]+)"', page.body.decode()):
        for method in ("GET", "HEAD"):
            asset = say(method, f"/assets/{name}", headers={"Accept-Encoding": "gzip"})
            say(method, f"/assets/{name}", headers={"If-None-Match": asset.headers["ETag"]})
    say("HEAD", "/assets/nothing")
    for path in ("/", "/api", "/conformance", "/processes", "/processes/solve", "/jobs"):
        for method in ("GET", "HEAD"):
            say(method, path, headers={"Accept": "image/png"})
    for method in ("GET", "HEAD"):
        say(method, "/processes/nothing")
        say(method, "/no/such/path")
    say("GET", "/processes?limit=1", headers={"X-Request-Id": "me", "Origin": "http://a.example"})
    say("GET", "/processes?limit=0")
    say("OPTIONS", "/processes/solve/execution", headers={"Origin": "http://a.example"})
    say("GET", "/jobs?status=" + "a" * 20000)
    say("GET", "/healthz", headers={"X-Request-Id": "a" * 25000})
    say("GET", "/%zz")
    say("POST", "/Evaluate", None, {"Transfer-Encoding": "gzip"})
    large(say)


def large(say):
    """A body that is announced, never sent."""
    connection = say.server.connect(60)
    fields = {"Accept": "*/*", "Content-Type": "application/json"}
    connection.putrequest("POST", "/processes/solve/execution", skip_accept_encoding=True)
    for name, value in fields.items():
        connection.putheader(name, value)
    connection.putheader("Content-Length", str(1 << 40))
    connection.endheaders()
    reply = daemon.Reply(connection.getresponse())
    say.keep("POST", "/processes/solve/execution", fields, None, reply)
    connection.close()


def talk_of_examples(say):
    for path in sorted(EXAMPLES.glob("*.json")):
        process, kind = path.name.split(".")[0], path.name.split(".")[1].split("-")[0]
        example = json.loads(path.read_text())
        body = example if kind == "ok" else example.get("request", example.get("text"))
        execute(say, body.encode() if isinstance(body, str) else body, process)


def talk_of_execution(say):
    raw = {**SMALL, "outputs": {"solution": {}}, "response": "raw"}
    for accept in (*source.RESULTS, "application/problem+json, application/json"):
        execute(say, raw, Accept=accept)
    execute(say, SMALL, Accept="multipart/related")
    both = {**SMALL, "outputs": {"solution": {}, "points": {}}, "response": "raw"}
    execute(say, both, Accept="multipart/related")
    execute(say, SMALL, Accept="image/png")
    execute(say, SMALL, Content_Encoding="gzip", Accept_Encoding="gzip")
    execute(say, SMALL, Content_Encoding="brotli")
    execute(say, SMALL, Content_Type="text/plain")
    execute(say, b"{", Content_Type="application/json")
    execute(say, SMALL, "nothing")
    execute(say, SINGULAR)
    execute(say, SINGULAR, Accept="application/json")
    execute(say, echo(60), "echo")  # beyond the time limit
    say("POST", "/processes/solve/execution")
    say("POST", "/processes/solve/execution", b"", {"Content-Type": "application/cbor"})


def talk_of_models(say):
    direction = {**MODEL, "outWrt": 0, "inWrt": 0}
    for path, more in (("ModelInfo", {}), ("InputSizes", {}), ("OutputSizes", {}), ("Evaluate", {}),
                       ("Gradient", {**direction, "sens": [1]}), ("ApplyHessian", {}),
                       ("ApplyJacobian", {**direction, "vec": [1, 0]})):
        say("POST", f"/{path}", {**MODEL, **more})
        say("POST", f"/{path}", {**MODEL, **more}, {"Content-Type": "text/plain"})
        say("POST", f"/{path}", {**MODEL, **more, "name": "other"})
        say("POST", f"/{path}", b"no JSON")
        say("OPTIONS", f"/{path}")
        say("GET", f"/{path}")
    flat = {**SINGULAR["inputs"], "parameters": {"a": 1}, "inputs": ["a"], "outputs": ["mean"]}
    for path, more in (("Evaluate", {}), ("Gradient", {"sens": [1]}),
                       ("ApplyJacobian", {"vec": [1]})):
        say("POST", f"/{path}", {**direction, "input": [[1]], "config": flat, **more})
    flat["boundary"] = SMALL["inputs"]["boundary"]
    flat["outputs"] = {"some": {"type": "values", "at": [[0.3, 0.3]]}, "mean": "mean",
                       "edge": {"type": "l2", "on": "boundary"}}
    say("POST", "/Evaluate", {**MODEL, "input": [[1]], "config": flat})


def talk_of_data(say):
    text = json.dumps({"points": [[0.1 * k, 0.0] for k in range(9)]}).encode()
    kept = say("POST", "/data", text).json
    say("POST", "/data", text)
    say("POST", "/data", text, {"Content-Type": "text/csv"})
    say("POST", "/data", text, {"Content-Encoding": "gzip"})
    say("POST", "/data", b"1,2\n3,4\n", {"Content-Type": "text/csv"})
    say("POST", "/data", b"{")
    say("POST", "/data", text, {"Content-Type": "image/png"})
    say("POST", "/data", text, {"Accept": "image/png"})
    say("POST", "/data", None)
    say("OPTIONS", "/data")
    path = f"/data/{kept['id']}"
    etag = f'"{kept["id"]}"'
    say("OPTIONS", path)
    for method in ("GET", "HEAD"):
        say(method, path)
        say(method, path, headers={"Accept": "image/png"})
        say(method, path, headers={"If-None-Match": etag})
        say(method, path, headers={"Range": "bytes=0-9", "If-Range": etag})
        say(method, path, headers={"Range": "bytes=99999999-"})
        say(method, "/data/nothing")
    body = {"inputs": {**SMALL["inputs"], "cloud": {"href": kept["href"]}}}
    execute(say, body)
    array = say("POST", "/data", b"[1,2,3]").json
    slow = submitted(say, {"inputs": {"message": "", "pause": 60, "values": {
        "href": array["href"]}}}, "echo")
    say("DELETE", f"/data/{array['id']}")
    say("DELETE", slow)
    say("DELETE", path)
    say("DELETE", path)


def talk_of_batches(say):
    body = {"inputs": {"requests": [{"process": "echo", **echo(0)}, {"process": "solve", **SMALL}]}}
    job = submitted(say, body, "batch")
    over(say, job)
    for accept in ("application/json", "application/x-ndjson", "image/png"):
        say("GET", job + "/results", headers={"Accept": accept})
    say("GET", job + "/results/0")
    say("GET", job + "/results/9")
    say("GET", f"/jobs?parent={job.removeprefix('/jobs/')}")
    execute(say, {"inputs": {}}, "batch")


def submitted(say, body, process="solve", **headers):
    """The path of a new job."""
    prefer = ", ".join(["respond-async", *filter(None, [headers.pop("Prefer", "")])])
    reply = execute(say, body, process, Prefer=prefer, **headers)
    return "/jobs/" + reply.json["jobID"]


def over(say, job):
    while (info := say("GET", job, headers={"Prefer": "wait=30"}).json)["status"] in (
            "accepted", "running"):
        pass
    return info


def talk_of_jobs(say):
    done = submitted(say, SMALL, Idempotency_Key="one")
    execute(say, SMALL, Prefer="respond-async", Idempotency_Key="one")
    execute(say, {**SMALL, "more": 1}, Prefer="respond-async", Idempotency_Key="one")
    execute(say, SMALL, Prefer="respond-async, wait=20, priority=7", Cache_Control="no-cache")
    execute(say, SMALL, Prefer="respond-async, return=minimal")
    execute(say, {"inputs": {}}, Prefer="respond-async")
    over(say, done)
    tag = say("GET", done).headers["ETag"]
    for method in ("GET", "HEAD"):
        say(method, done, headers={"If-None-Match": tag})
        say(method, done)
        for accept in (*source.RESULTS, "multipart/related", "image/png"):
            say(method, done + "/results", headers={"Accept": accept})
            say(method, done + "/results/solution", headers={"Accept": accept})
            for span in ("bytes=0-9", "bytes=99999999-"):
                say(method, done + "/results/solution", headers={"Accept": accept, "Range": span})
                say(method, done + "/results", headers={"Accept": accept, "Range": span})
        say(method, done + "/results", headers={"Accept-Encoding": "gzip"})
        say(method, done + "/results/nothing")
        say(method, done, headers={"Accept": "image/png"})
    for path in ("", "/events", "/results", "/results/solution"):
        say("OPTIONS", done + path)
    talk_of_references(say)
    talk_of_failures(say)
    talk_of_running(say)
    talk_of_lists(say)


def talk_of_references(say):
    everywhere = {**SMALL, "response": "raw", "outputs": {
        "solution": {"transmissionMode": "reference"}}}
    execute(say, everywhere, Prefer="respond-async, wait=20")
    job = submitted(say, everywhere)
    over(say, job)
    for method in ("GET", "HEAD"):
        say(method, job + "/results")
        say(method, job + "/results/solution")
    document = submitted(say, {**everywhere, "response": "document"})
    over(say, document)
    say("GET", document + "/results")


def talk_of_failures(say):
    failed = submitted(say, SINGULAR)
    over(say, failed)
    slow = submitted(say, echo(59), "echo")  # beyond the time limit
    over(say, slow)
    for method in ("GET", "HEAD"):
        for job in (failed, slow):
            say(method, job + "/results")
            say(method, job + "/results/solution")
        for path in ("", "/events", "/results", "/results/solution"):
            say(method, "/jobs/nothing" + path)
    say("DELETE", "/jobs/nothing")
    execute(say, SINGULAR, Prefer="respond-async, wait=20")


def talk_of_running(say):
    job = submitted(say, echo(5), "echo")
    for method in ("GET", "HEAD"):
        say(method, job + "/results")
        say(method, job + "/results/message")
        say(method, job + "/events", headers={"Accept": "image/png"})
    say("GET", job, headers={"Prefer": "wait=1"})
    events = say("GET", job + "/events")
    last = re.findall(rb"id: (\d+)", events.body)[-1].decode()
    for method in ("GET", "HEAD"):
        say(method, job + "/events", headers={"Last-Event-ID": last})
        say(method, job + "/events")
    say("DELETE", job)
    say("DELETE", job)
    for method in ("GET", "HEAD"):
        say(method, job + "/results")
        say(method, job + "/results/message")


def talk_of_lists(say):
    for query in ("limit=2", "limit=1&offset=1", "type=process", "processID=solve,echo",
                  "status=successful,failed", "datetime=2020-01-01T00:00:00Z/..", "minDuration=0",
                  "maxDuration=100"):
        for method in ("GET", "HEAD"):
            say(method, "/jobs?" + query)
    for query in ("limit=0", "offset=-1", "type=x", "status=x", "datetime=x", "minDuration=x",
                  "maxDuration=x", "parent=x", "processID="):
        say("GET", "/jobs?" + query)


def talk_under_pressure(say):
    """A daemon with two workers, and room for one request and two jobs that wait."""
    threads = [threading.Thread(target=execute, args=(say, echo(6), "echo")) for _ in range(3)]
    for thread in threads:
        thread.start()
    daemon.wait_until(lambda: say("GET", "/readyz", keep=False).status == 503, "a full queue")
    execute(say, SMALL)
    say("GET", "/readyz")
    say("POST", "/Evaluate", MODEL)
    for thread in threads:
        thread.join()
    for _ in range(5):
        execute(say, echo(60), "echo", Prefer="respond-async")


def talk_of_strangers(say):
    say("GET", "/healthz", headers={"Host": "elsewhere.example"})
    for path in ("/processes/solve/execution", "/data", "/Evaluate"):
        say("POST", path, b"{}", {"Origin": "https://elsewhere.example"})
    say("DELETE", "/jobs/nothing", headers={"Origin": "https://elsewhere.example"})


# --- The tests ---------------------------------------------------------------------------------


def plain(path):
    """A path of the document as the daemon prints it."""
    return re.sub(r"\{[^}]*\}", "{}", path)


class OpenApi(daemon.Case):
    stub = False
    options = ["--seconds", "8", "--job-seconds", "8", "--cors-origins", "*", "--workers", "2"]
    pressed = ["--workers", "2", "--queue", "1", "--job-queue", "2", "--seconds", "20",
               "--hosts", ""]

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        say = cls.say = Recorder(cls.daemon)
        cls.api = say("GET", "/api").json
        for talk in (talk_of_service, talk_of_examples, talk_of_execution, talk_of_models,
                     talk_of_jobs, talk_of_data, talk_of_batches):
            talk(say)
        second = daemon.Daemon(*cls.pressed, stub=False)
        second.wait_ready()
        pressed = Recorder(second)
        talk_under_pressure(pressed)
        talk_of_strangers(pressed)
        status = second.stop()
        assert status == 0, second.log
        say.pairs += pressed.pairs + cls.guarded()
        cls.verdict = cls.validate()

    @classmethod
    def guarded(cls):
        """What is said to a daemon that wants tokens."""
        with tempfile.TemporaryDirectory() as room:
            path = pathlib.Path(room) / "tokens"
            made = subprocess.run([daemon.program(stub=False), "token", "me", "rate=0.1", "burst=3"],
                                  capture_output=True, text=True, check=True)
            path.write_text(made.stdout)
            third = daemon.Daemon("--tokens", str(path), "--workers", "1", stub=False)
            third.wait_ready()
            say = Recorder(third)
            for _ in range(5):
                say("GET", "/jobs", headers={"Authorization": "Bearer " + made.stderr.split()[-1]})
            say("GET", "/jobs")
            say("POST", "/processes/solve/execution", SMALL)
            third.stop()
        return say.pairs

    @classmethod
    def validate(cls):
        node = shutil.which("node")
        with tempfile.TemporaryDirectory() as room:
            document, traffic = pathlib.Path(room) / "api.json", pathlib.Path(room) / "traffic.json"
            document.write_text(json.dumps(cls.api))
            traffic.write_text(json.dumps(cls.say.pairs))
            done = subprocess.run([node, HERE / "openapi" / "validate.mjs", document, traffic],
                                  capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        return json.loads(done.stdout)

    def operations(self):
        """(path, method, operation) of the document."""
        for path, item in self.api["paths"].items():
            for method in ("get", "head", "post", "delete", "options"):
                if method in item:
                    yield path, method, item[method]

    def test_routes_and_paths_are_the_same(self):
        printed = subprocess.run([daemon.program(stub=False), "--print-routes"],
                                 capture_output=True, text=True, check=True).stdout
        routes = {tuple(line.split(" ")) for line in printed.splitlines()}
        documented = {(method.upper(), plain(path)) for path, method, _ in self.operations()
                      if method not in ("head", "options")}
        self.assertEqual(documented, routes)
        for path, item in self.api["paths"].items():
            self.assertIn("options", item, path)
            self.assertEqual("get" in item, "head" in item, path)

    def test_the_document_is_valid(self):
        self.assertEqual([line for line in self.verdict["document"]
                          if "ApplyHessian" not in line], [])  # it has no good answer indeed

    def test_the_traffic_is_valid(self):
        self.assertGreater(len(self.say.pairs), 400)
        self.assertEqual(self.verdict["traffic"][:20], [])

    def test_every_documented_answer_is_seen(self):
        seen = {tuple(entry) for entry in self.verdict["seen"]}
        statuses = {status for _, _, status in seen}
        missing = set()
        for path, method, operation in self.operations():
            if path.startswith("/assets/") and ("/assets/{asset}", "get", "200") not in seen:
                continue  # built without the dashboard
            for status in operation["responses"]:
                if status in NOT_SEEN or (path, method, status) in seen:
                    continue
                if status in EVERYWHERE and status in statuses:
                    continue  # the same code for all: once is enough
                missing.add((path, method, status))
        if ("/", "get", "304") not in seen:
            missing -= {("/", "get", "304"), ("/", "head", "304")}  # without the dashboard
        missing -= set(RARE)
        self.assertEqual(sorted(missing), [])
        self.assertEqual(set(RARE) & seen, set(), "seen after all: to be taken out of RARE")

    def test_every_parameter_and_header_is_seen(self):
        used = set(self.verdict["used"])
        for parameter in self.api["components"]["parameters"].values():
            if parameter["name"] == "asset" and "path asset" not in used:
                continue  # built without the dashboard
            self.assertIn(f"{parameter['in']} {parameter['name']}", used)
        with_dashboard = "answer Content-Security-Policy" in used
        for name in self.api["components"]["headers"]:
            if not with_dashboard and name in ("Content-Security-Policy", "Referrer-Policy",
                                               "X-Content-Type-Options"):
                continue
            self.assertIn(f"answer {name}", used)

    def test_sources_use_nothing_that_is_not_documented(self):
        fields = {name.lower() for name in self.api["components"]["headers"]}
        taken = {p["name"].lower() for p in self.api["components"]["parameters"].values()}
        of_http = {"accept", "content-type", "host", "transfer-encoding", "content-length",
                   "authorization", "sec-fetch-site"}
        for path in sorted(FRONT.rglob("*.c")):
            text = path.read_text()
            for name in re.findall(r'exchange_add\([^,]*, "([A-Za-z-]+)"', text):
                self.assertIn(name.lower(), fields, path.name)
            for name in re.findall(r'(?:http_field|http_argument|[^_]field)\([^,]*, "([A-Za-z-]+)"',
                                   text):
                self.assertIn(name.lower(), taken | of_http, path.name)
            for status in re.findall(r"exchange_refuse\([^,]*, ([1-5]\d\d)", text):
                self.assertIn(status, {*source.FAILURES, "405"}, path.name)


if __name__ == "__main__":
    if shutil.which("node") is None or not (HERE / "openapi" / "node_modules").is_dir():
        print("node or its packages are missing: `.ci/install tests`")
        sys.exit(SKIPPED)
    unittest.main()
