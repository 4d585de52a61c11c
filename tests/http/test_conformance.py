#!/usr/bin/env python3
"""http.conformance: OGC API - Processes - Part 1: Core 1.0 (OGC 18-062r2), requirement by
requirement: each test names in its first line the ones it proves. The callback class is proved by
http.callbacks, the documents of /api and /processes by http.schemas, HTTP itself by http.front.
Last, OWSLib drives a solve from discovery to results."""

import datetime
import email
import json
import sys
import time
import unittest
import urllib.parse

sys.dont_write_bytecode = True
import daemon  # noqa: E402

RELATION = "http://www.opengis.net/def/rel/ogc/1.0/"
EXCEPTION = "http://www.opengis.net/def/exceptions/ogcapi-processes-1/1.0/"
CLASS = "http://www.opengis.net/spec/ogcapi-processes-1/1.0/conf/"
ECHO = "/processes/echo/execution"
LATTICE = {"lattice": {"lower": [0, 0], "upper": [1, 1], "cells": [4, 4]}}
SOLVE = {"cloud": LATTICE, "diffusivity": 1, "exact": "x",
         "boundary": [{"on": "boundary", "type": "dirichlet", "value": "x"}]}
TERMINAL = {"successful", "failed", "dismissed"}


class Conformance(daemon.Case):
    stub = False
    options = ["--workers", "3"]

    def post(self, path, request, **headers):
        return self.execute(json.dumps(request), path, **headers)

    def echo(self, inputs, prefer=None, **members):
        headers = {"Prefer": prefer} if prefer else {}
        return self.post(ECHO, {"inputs": {"message": "hello", **inputs}, **members}, **headers)

    def submit(self, inputs=None, **members):
        reply = self.echo(inputs or {}, "respond-async", **members)
        self.assertEqual(reply.status, 201, reply.body)
        return reply.json["jobID"]

    def finish(self, job):
        return daemon.wait_until(
            lambda: (lambda info: info if info["status"] in TERMINAL else None)(
                self.get(f"/jobs/{job}", Prefer="wait=30").json), f"the end of {job}")

    def at(self, address):
        """GET of an absolute link of ours."""
        parts = urllib.parse.urlsplit(address)
        self.assertEqual((parts.scheme, parts.netloc), ("http", self.daemon.address), address)
        return self.get(parts.path + ("?" + parts.query if parts.query else ""))

    def assert_exception(self, reply, status, kind):
        self.assertEqual(self.assert_problem(reply, status)["type"], EXCEPTION + kind)


class Core(Conformance):
    def test_landing_page(self):
        """/req/core/landingpage-op, /req/core/landingpage-success"""
        reply = self.get("/")
        self.assertEqual((reply.status, reply.type), (200, "application/json"))
        found = {link["rel"]: link for link in reply.json["links"]}
        for relation in ("service-desc", "service-doc", RELATION + "conformance",
                         RELATION + "processes", RELATION + "job-list"):
            self.assertIn(relation, found)
        for link in reply.json["links"]:
            self.assertTrue(link["type"])
            self.assertEqual(self.at(link["href"]).status, 200)

    def test_api_definition(self):
        """/req/core/api-definition-op, /req/core/api-definition-success, /req/oas30/oas-definition-1,
        /req/oas30/oas-definition-2, /req/oas30/oas-impl, /req/oas30/completeness"""
        reply = self.get("/api", Accept="application/vnd.oai.openapi+json;version=3.0")
        self.assertEqual((reply.status, reply.type),
                         (200, "application/vnd.oai.openapi+json;version=3.0"))
        document = reply.json
        self.assertRegex(document["openapi"], r"^3\.0\.")
        for path in ("/", "/conformance", "/processes", "/processes/{processID}", "/jobs",
                     "/processes/{processID}/execution", "/jobs/{jobID}", "/jobs/{jobID}/results"):
            self.assertIn(path, document["paths"])
        self.assertIn("delete", document["paths"]["/jobs/{jobID}"])
        self.assertEqual(self.get("/api", Accept="text/html").status, 200)

    def test_conformance(self):
        """/req/core/conformance-op, /req/core/conformance-success"""
        reply = self.get("/conformance")
        self.assertEqual(reply.status, 200)
        self.assertLessEqual({CLASS + name for name in (
            "core", "json", "oas30", "ogc-process-description", "job-list", "dismiss", "callback")},
            set(reply.json["conformsTo"]))

    def test_process_list(self):
        """/req/core/process-list, /req/core/process-list-success, /req/core/pl-limit-definition,
        /req/core/pl-limit-response, /req/core/pl-links"""
        reply = self.get("/processes")
        self.assertEqual(reply.status, 200)
        self.assertIn("echo", [process["id"] for process in reply.json["processes"]])
        for process in reply.json["processes"]:
            self.assertTrue(process["id"] and process["version"])
        self.assertEqual(len(self.get("/processes?limit=2").json["processes"]), 2)
        self.assertTrue(all({"href", "rel", "type"} <= set(link) for link in reply.json["links"]))

    def test_process(self):
        """/req/core/process, /req/core/process-success, /req/core/process-exception/no-such-process,
        /req/ogc-process-description/json-encoding, /req/ogc-process-description/inputs-def,
        /req/ogc-process-description/input-def, /req/ogc-process-description/outputs-def,
        /req/ogc-process-description/output-def"""
        echo = self.get("/processes/echo")
        self.assertEqual(echo.status, 200)
        self.assertEqual(list(echo.json["inputs"])[0], "message")
        self.assertEqual(set(echo.json["outputs"]), {"message", "pause", "values"})
        self.assertEqual(set(echo.json["jobControlOptions"]),
                         {"sync-execute", "async-execute", "dismiss"})
        for one in [*echo.json["inputs"].values(), *echo.json["outputs"].values()]:
            self.assertIsInstance(one["schema"], dict)
            self.assertNotIn("$ref", json.dumps(one["schema"]))
        self.assert_exception(self.get("/processes/none"), 404, "no-such-process")
        self.assert_exception(self.post("/processes/none/execution", {}), 404, "no-such-process")

    def test_execute_inputs(self):
        """/req/core/process-execute-op, /req/core/process-execute-request,
        /req/core/process-execute-inputs, /req/core/process-execute-input-validation,
        /req/core/process-execute-input-array, /req/core/process-execute-input-inline-object,
        /req/core/process-execute-input-inline-binary"""
        self.assertEqual(self.echo({"values": [3, 1, 2]}).json["values"], [3, 1, 2])
        self.assertEqual(self.echo({"blob": "a,b\n1,2\n"}).status, 200)
        qualified = {**SOLVE, "cloud": {"value": LATTICE}}
        for inputs in (SOLVE, qualified):
            self.assertEqual(self.post("/processes/solve/execution", {"inputs": inputs}).status, 200)
        for inputs in ({"message": 3}, {"values": "x"}, {"values": ["x"]}, {"pause": 61},
                       {"unknown": 1}):
            problem = self.assert_problem(self.echo(inputs), 400)
            self.assertTrue(problem["errors"][0]["pointer"].startswith("/inputs/"))
        for body in ("", "{", "[]", "{}", '{"inputs":[]}'):
            self.assert_problem(self.execute(body, ECHO), 400)

    def test_sync_document(self):
        """/req/core/process-execute-sync-document, /req/core/process-execute-default-outputs,
        /req/core/process-execute-default-execution-mode"""
        for members in ({}, {"response": "document"}):
            reply = self.echo({"values": [1]}, **members)
            self.assertEqual((reply.status, reply.type), (200, "application/json"))
            self.assertIsNone(reply.headers["Link"])
            self.assertIsNone(reply.headers["Location"])
            self.assertEqual(reply.json["message"], "hello")
        reply = self.echo({"values": [1]}, outputs={"values": {}})
        self.assertEqual(reply.json, {"values": [1]})
        norms = self.post("/processes/solve/execution",
                          {"inputs": SOLVE, "outputs": {"norms": {}}}).json["norms"]
        self.assertIn("linf", norms["value"])

    def test_sync_raw(self):
        """/req/core/process-execute-sync-raw-value-one,
        /req/core/process-execute-sync-raw-value-multi"""
        reply = self.echo({}, outputs={"message": {}}, response="raw")
        self.assertEqual((reply.status, reply.json), (200, "hello"))
        request = {"inputs": {"message": "a", "values": [1]}, "response": "raw",
                   "outputs": {"message": {}, "values": {}}}
        reply = self.post(ECHO, request, Accept="multipart/related")
        self.assertTrue(reply.type.startswith("multipart/related"), reply.type)
        message = email.message_from_bytes(b"Content-Type: " + reply.type.encode() + b"\r\n\r\n"
                                           + reply.body)
        self.assertEqual(len(message.get_payload()), 2)
        self.assertEqual(self.post(ECHO, request).json, {"message": "a", "values": [1]})

    def test_execution_mode(self):
        """/req/core/process-execute-auto-execution-mode, /rec/core/process-execute-honor-prefer,
        /rec/core/process-execute-preference-applied"""
        self.assertEqual(self.echo({}).status, 200)
        self.assertEqual(self.echo({}, "respond-async").status, 201)
        batch = {"inputs": {"requests": [{"process": "echo", "inputs": {"message": "x"}}]}}
        self.assertEqual(self.post("/processes/batch/execution", batch).status, 201)
        reply = self.echo({}, 'a=1, respond-async;b="c,d", return=representation')
        self.assertEqual(reply.headers["Preference-Applied"], "respond-async, return=representation")

    def test_async(self):
        """/req/core/process-execute-success-async, /req/core/job, /req/core/job-success,
        /req/core/job-exception-no-such-job"""
        reply = self.echo({"pause": 0.5}, "respond-async")
        self.assertEqual((reply.status, reply.type), (201, "application/json"))
        location, info = reply.headers["Location"], reply.json
        self.assertEqual((info["type"], info["processID"]), ("process", "echo"))
        self.assertIn(info["status"], ("accepted", "running"))
        self.assertNotIn(None, info.values())
        self.assertEqual([link["href"] for link in info["links"] if link["rel"] == "monitor"],
                         [location])
        end = time.monotonic() + daemon.PATIENCE
        while info["status"] not in TERMINAL and time.monotonic() < end:
            reply = self.at(location)
            info = reply.json
            self.assertEqual((reply.status, info["jobID"]), (200, location.rsplit("/", 1)[1]))
            self.assertEqual(RELATION + "results" in [link["rel"] for link in info["links"]],
                             info["status"] == "successful")
            time.sleep(0.05)
        self.assertEqual((info["status"], info["progress"]), ("successful", 100))
        self.assert_exception(self.get("/jobs/none"), 404, "no-such-job")

    def test_results(self):
        """/req/core/job-results, /req/core/job-results-async-document,
        /req/core/job-results-async-raw-value-one, /req/core/job-results-async-raw-value-multi"""
        for members in ({}, {"outputs": {"message": {}}}, {"response": "raw",
                                                           "outputs": {"message": {}}}):
            job = self.submit({"values": [1, 2]}, **members)
            link = {one["rel"]: one for one in self.finish(job)["links"]}[RELATION + "results"]
            synchronous = self.echo({"values": [1, 2]}, **members)
            reply = self.at(link["href"])
            self.assertEqual((reply.status, reply.type, reply.json),
                             (200, synchronous.type, synchronous.json))
        job = self.submit({"values": [1]}, response="raw", outputs={"message": {}, "values": {}})
        self.finish(job)
        reply = self.get(f"/jobs/{job}/results", Accept="multipart/related")
        self.assertTrue(reply.type.startswith("multipart/related"), reply.type)
        self.assertEqual(self.get(f"/jobs/{job}/results/values").json, [1])
        self.assertEqual(self.get(f"/jobs/{job}/results/none").status, 404)

    def test_results_exceptions(self):
        """/req/core/job-results-exception/no-such-job,
        /req/core/job-results-exception/results-not-ready, /req/core/job-results-failed"""
        self.assert_exception(self.get("/jobs/none/results"), 404, "no-such-job")
        job = self.submit({"pause": 20})
        self.assert_exception(self.get(f"/jobs/{job}/results"), 404, "result-not-ready")
        self.request("DELETE", f"/jobs/{job}")
        singular = {**SOLVE, "boundary": [{"on": "boundary", "type": "neumann", "value": 0}]}
        request = {"inputs": singular}
        synchronous = self.post("/processes/solve/execution", request)
        self.assert_problem(synchronous, 422)
        job = self.post("/processes/solve/execution", request,
                        Prefer="respond-async").json["jobID"]
        self.assertEqual(self.finish(job)["status"], "failed")
        problem = self.assert_problem(self.get(f"/jobs/{job}/results"), 422)
        self.assertEqual(problem["detail"], synchronous.json["detail"])


class Representations(Conformance):
    def test_json(self):
        """/req/json/definition"""
        for path in ("/", "/conformance", "/processes", "/processes/echo", "/jobs"):
            for accept in ({}, {"Accept": "*/*"}, {"Accept": "application/json"}):
                reply = self.get(path, **accept)
                self.assertEqual((reply.status, reply.type), (200, "application/json"))
                self.assertIsInstance(reply.json, dict)

    def test_problems(self):
        """/req/oas30/exceptions-codes"""
        self.assertEqual(self.get("/jobs/none").type, "application/problem+json")
        plain = self.get("/jobs/none", Accept="application/json")
        self.assertEqual((plain.status, plain.type), (404, "application/json"))
        both = self.get("/jobs/none", Accept="application/json, application/problem+json")
        self.assertEqual(both.type, "application/problem+json")


class JobList(Conformance):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        self = cls()
        cls.jobs = [self.submit({"pause": 0}) for _ in range(3)]
        cls.slow = self.submit({"pause": 1.2})
        cls.running = self.submit({"pause": 60})
        for job in [*cls.jobs, cls.slow]:
            self.finish(job)

    def listed(self, query):
        reply = self.get(f"/jobs?{query}")
        self.assertEqual(reply.status, 200, reply.body)
        return [job["jobID"] for job in reply.json["jobs"]]

    def test_list(self):
        """/req/job-list/job-list-op, /req/job-list/job-list-success"""
        reply = self.get("/jobs")
        self.assertEqual((reply.status, reply.type), (200, "application/json"))
        self.assertEqual({job["jobID"] for job in reply.json["jobs"]},
                         {*self.jobs, self.slow, self.running})
        for job in reply.json["jobs"]:
            self.assertLessEqual({"type", "jobID", "status", "processID", "links"}, set(job))

    def test_type(self):
        """/req/job-list/type-definition, /req/job-list/type-response"""
        self.assertEqual(len(self.listed("type=process")), 5)
        self.assert_problem(self.get("/jobs?type=other"), 400)

    def test_process_id(self):
        """/req/job-list/processID-mandatory, /req/job-list/processID-definition,
        /req/job-list/processid-response"""
        self.assertEqual(len(self.listed("processID=echo")), 5)
        self.assertEqual(self.listed("processID=solve"), [])
        self.assertEqual(len(self.listed("processID=solve,echo")), 5)

    def test_status(self):
        """/req/job-list/status-definition, /req/job-list/status-response"""
        self.assertEqual(self.listed("status=running"), [self.running])
        self.assertEqual(set(self.listed("status=successful")), {*self.jobs, self.slow})
        self.assertEqual(len(self.listed("status=successful,running")), 5)
        self.assert_problem(self.get("/jobs?status=other"), 400)

    def test_datetime(self):
        """/req/job-list/datetime-definition, /req/job-list/datetime-response"""
        created = self.get(f"/jobs/{self.slow}").json["created"]
        self.assertIn(self.slow, self.listed(f"datetime={created}"))
        self.assertEqual(set(self.listed(f"datetime={created}/..")), {self.slow, self.running})
        self.assertEqual(set(self.listed(f"datetime=../{created}")), {*self.jobs, self.slow})
        self.assert_problem(self.get("/jobs?datetime=never"), 400)

    def test_duration(self):
        """/req/job-list/duration-definition, /req/job-list/duration-response"""
        def seconds(job):
            began, ended = (datetime.datetime.fromisoformat(info[name].replace("Z", "+00:00"))
                            for info in [self.get(f"/jobs/{job}").json]
                            for name in ("started", "finished"))
            return (ended - began).total_seconds()
        spent = {job: seconds(job) for job in (*self.jobs, self.slow)}
        self.assertGreater(spent[self.slow], 1)  # others too, if the machine stood still
        self.assertIn(self.slow, self.listed("minDuration=1&maxDuration=1000"))
        self.assertEqual(set(self.listed("maxDuration=1&status=successful")),
                         {job for job in spent if spent[job] <= 1})
        self.assertEqual(set(self.listed("minDuration=1&status=successful")),
                         {job for job in spent if spent[job] >= 1})

    def test_limit(self):
        """/req/job-list/limit-definition, /req/job-list/limit-response, /req/job-list/links,
        /rec/job-list/next-1"""
        seen, address = [], f"http://{self.daemon.address}/jobs?limit=2"
        while address:
            page = self.at(address).json
            self.assertLessEqual(len(page["jobs"]), 2)
            seen += [job["jobID"] for job in page["jobs"]]
            links = {link["rel"]: link for link in page["links"]}
            self.assertIn("self", links)
            address = links["next"]["href"] if "next" in links else None
        self.assertEqual((len(seen), len(set(seen))), (5, 5))
        for limit in ("0", "-1", "x", "10001"):
            self.assert_problem(self.get(f"/jobs?limit={limit}"), 400)


class Dismiss(Conformance):
    def test_running(self):
        """/req/dismiss/job-dismiss-op, /req/dismiss/job-dismiss-success"""
        job = self.submit({"pause": 60})
        reply = self.request("DELETE", f"/jobs/{job}")
        self.assertEqual((reply.status, reply.type), (200, "application/json"))
        self.assertEqual((reply.json["jobID"], reply.json["status"]), (job, "dismissed"))
        self.assertEqual(self.get(f"/jobs/{job}").json["status"], "dismissed")
        self.assert_problem(self.get(f"/jobs/{job}/results"), 410)
        self.assert_problem(self.request("DELETE", f"/jobs/{job}"), 410)

    def test_finished(self):
        """/req/dismiss/job-dismiss-success"""
        job = self.submit()
        self.finish(job)
        self.assertEqual(self.request("DELETE", f"/jobs/{job}").json["status"], "dismissed")
        self.assert_problem(self.get(f"/jobs/{job}/results"), 410)

    def test_unknown(self):
        """/req/core/job-exception-no-such-job"""
        self.assert_exception(self.request("DELETE", "/jobs/none"), 404, "no-such-job")


class Forms(Conformance):
    def test_npy(self):
        job = self.post("/processes/solve/execution", {"inputs": SOLVE},
                        Prefer="respond-async").json["jobID"]
        self.finish(job)
        values = self.get(f"/jobs/{job}/results/solution").json
        reply = self.get(f"/jobs/{job}/results/solution", Accept="application/x-npy")
        self.assertEqual((reply.status, reply.type), (200, "application/x-npy"))
        self.assertEqual(reply.body[:6], b"\x93NUMPY")
        self.assertEqual(len(values), 25)

    def test_batch(self):
        request = {"inputs": {**{"cloud": LATTICE}, "parameters": {"b": [1, 2, 3]}, "request": {
            "inputs": {"diffusivity": 1, "exact": "x + b", "boundary": [
                {"on": "boundary", "type": "dirichlet", "value": "x + b"}]},
            "outputs": {"solution": {}}}}}
        job = self.post("/processes/batch/execution", request).json["jobID"]
        self.assertEqual(self.finish(job)["status"], "successful")
        document = self.get(f"/jobs/{job}/results").json
        first = [entry["results"]["solution"][0] for entry in document["results"]]
        self.assertEqual([round(value, 12) for value in first], [1, 2, 3])
        reply = self.get(f"/jobs/{job}/results", Accept="application/x-ndjson")
        entries = [json.loads(line) for line in reply.body.splitlines()]
        self.assertEqual(sorted(entry["index"] for entry in entries), [0, 1, 2])
        bad = {"inputs": {**request["inputs"], "parameters": {"c": [1]}}}
        problem = self.assert_problem(self.post("/processes/batch/execution", bad), 400)
        self.assertTrue(problem["errors"][0]["pointer"].startswith("/inputs/request"), problem)


class Owslib(Conformance):
    """OWSLib of Debian 12 (0.27) knows the resources of Processes, and posts by its http_post."""

    def test_solve_end_to_end(self):
        try:
            from owslib.ogcapi.processes import Processes
            from owslib.util import http_post
        except ImportError:
            self.skipTest("needs python3-owslib")
        service = Processes(f"http://{self.daemon.address}/")
        self.assertIn("service-desc", [link["rel"] for link in service.links])
        self.assertIn("/jobs", service.api()["paths"])
        self.assertIn(CLASS + "job-list", service.conformance()["conformsTo"])
        self.assertIn("solve", [process["id"] for process in service.processes()["processes"]])
        described = service.process("solve")
        self.assertIn("cloud", described["inputs"])
        execute, = [link["href"] for link in described["links"] if link["rel"].endswith("execute")]
        body = {"inputs": SOLVE, "outputs": {"solution": {}}}
        answer = http_post(execute, body)
        self.assertEqual((answer.status_code, len(answer.json()["solution"])), (200, 25))
        answer = http_post(execute, body, headers={"Prefer": "respond-async"})
        self.assertEqual(answer.status_code, 201)
        job = answer.json()["jobID"]
        daemon.wait_until(lambda: service._request(f"jobs/{job}")["status"] == "successful", "it")
        results = service._request(f"jobs/{job}/results")
        self.assertEqual(results["solution"][-1], 1)


if __name__ == "__main__":
    unittest.main()
