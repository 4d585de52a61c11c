"""Tokens: who may do what, how much of it, and what of others they see. Names of this service, pages
of other origins, listening beyond loopback. Needs no network."""

import base64
import contextlib
import hashlib
import json
import os
import pathlib
import re
import signal
import subprocess
import tempfile
import threading
import time
import unittest

import daemon

ASYNC = {"Prefer": "respond-async", "Content-Type": "application/json"}
OPEN = ["/healthz", "/readyz"]


def make_token(name, *limits):
    """A secret and its line, by the program itself."""
    done = subprocess.run([daemon.program(stub=True), "token", name, *limits], check=True,
                          capture_output=True, text=True, timeout=daemon.PATIENCE)
    secret = re.fullmatch(rf"secret of {name}: (sct_[0-9a-f]{{64}})\n", done.stderr).group(1)
    return secret, done.stdout


class TokenFile:
    """A file of tokens."""

    def __init__(self):
        self.directory = tempfile.TemporaryDirectory(prefix="access-test-")
        self.path = os.path.join(self.directory.name, "tokens")
        self.secret = {}
        self.write("")
        os.chmod(self.path, 0o600)

    def write(self, text):
        with open(self.path, "w", encoding="utf-8") as file:
            file.write(text)

    def add(self, name, *limits):
        self.secret[name], line = make_token(name, *limits)
        with open(self.path, "a", encoding="utf-8") as file:
            file.write(line)


def bearer(secret):
    return {"Authorization": f"Bearer {secret}"}


def basic(name, secret):
    return {"Authorization": "Basic " + base64.b64encode(f"{name}:{secret}".encode()).decode()}


class Guarded(daemon.Case):
    """A daemon with the tokens of `limits`."""

    limits = {"alice": [], "bob": []}

    @classmethod
    def setUpClass(cls):
        cls.file = TokenFile()
        cls.addClassCleanup(cls.file.directory.cleanup)
        for name, limits in cls.limits.items():
            cls.file.add(name, *limits)
        cls.options = [*cls.options, "--tokens", cls.file.path]
        super().setUpClass()

    def say(self, who, method, path, body=None, headers=None):
        """A request of somebody, None for nobody."""
        known = bearer(self.file.secret[who]) if who else {}
        return self.daemon.request(method, path, body, {**known, **(headers or {})})

    def submit(self, who, body, headers=None):
        return self.say(who, "POST", daemon.EXECUTE, body, {**ASYNC, **(headers or {})})

    def job(self, who, body):
        reply = self.submit(who, body)
        self.assertEqual(reply.status, 201, reply.body)
        return "/jobs/" + reply.json["jobID"]

    def end(self, who, job):
        return daemon.wait_until(
            lambda: self.say(who, "GET", job).json["status"] in ("successful", "failed"), job)


class Strangers(Guarded):
    options = ["--workers", "1"]

    def assert_stranger(self, reply, is_model=False):
        """The detail; errors of UM-Bridge have another form."""
        if is_model:
            self.assertEqual((reply.status, reply.json["error"]["type"]), (401, "Unauthorized"))
        problem = None if is_model else self.assert_problem(reply, 401, "token")
        challenges = reply.headers.get_all("WWW-Authenticate")
        self.assertEqual(len(challenges), 2)
        self.assertTrue(challenges[0].startswith("Bearer realm="))
        self.assertTrue(challenges[1].startswith("Basic realm="))
        return reply.json["error"]["message"] if is_model else problem["detail"]

    def test_every_route_but_two_wants_a_token(self):
        routes = subprocess.run([daemon.program(stub=True), "--print-routes"], check=True,
                                capture_output=True, text=True).stdout.splitlines()
        self.assertGreater(len(routes), 20)
        for line in routes:
            method, path = line.replace("{}", "solve").split()
            with self.subTest(line):
                reply = self.daemon.request(method, path)
                if path in OPEN:
                    self.assertEqual(reply.status, 200)
                else:
                    # paths of UM-Bridge are those with a capital
                    self.assert_stranger(reply, is_model=path[1:2].isupper())
        self.assert_stranger(self.get("/no/such/path"))
        self.assert_stranger(self.request("PUT", "/jobs"))

    def test_both_ways_in(self):
        secret = self.file.secret["alice"]
        for headers in (bearer(secret), basic("alice", secret),
                        {"Authorization": f"bEARER   {secret}"}):
            self.assertEqual(self.daemon.request("GET", "/jobs", None, headers).status, 200)

    def test_the_refusal_never_says_what_was_wrong(self):
        secret, other = self.file.secret["alice"], self.file.secret["bob"]
        told = set()
        for headers in (bearer("x"), bearer(""), bearer(secret[:-1]), bearer(secret + "0"),
                        bearer(secret.upper()), bearer(hashlib.sha256(secret.encode()).hexdigest()),
                        basic("alice", "x"), basic("alice", ""), basic("nobody", "x"),
                        basic("alice", other), basic("bob", secret), basic("", secret),
                        basic("nobody", secret), {"Authorization": "Basic ???"},
                        {"Authorization": "Basic " + base64.b64encode(b"alice").decode()},
                        {"Authorization": "Basic " + base64.b64encode(
                            f"alice:{secret}\0".encode()).decode()},
                        {"Authorization": f"Digest {secret}"}, {"Authorization": secret},
                        {"Authorization": "Basic"}, {"Authorization": ""},
                        {"Authorization": f"Bearer {secret}, Bearer {secret}"},
                        {"Authorization": "Bearer " + "x" * 5000}):
            with self.subTest(str(headers)[:60]):
                told.add(self.assert_stranger(
                    self.daemon.request("GET", "/jobs", None, headers)))
        self.assertEqual(len(told), 1)

    def test_a_body_is_not_taken_from_a_stranger(self):
        with self.daemon.raw() as plain:
            plain.sendall(b"POST /data HTTP/1.1\r\nHost: a\r\nContent-Type: application/json\r\n"
                          b"Content-Length: 100000000\r\n\r\n")
            reply = daemon.read_all(plain)
        self.assertTrue(reply.startswith(b"HTTP/1.1 401 "), reply)
        self.assertIn(b"Connection: close", reply)

    def test_a_preflight_needs_none(self):
        self.assertEqual(self.request("OPTIONS", daemon.EXECUTE).status, 204)

    def test_the_log_knows_the_name_and_not_the_secret(self):
        secret = self.file.secret["alice"]
        self.daemon.request("GET", "/jobs", None,
                            {**basic("alice", secret), "X-Request-Id": "named"})
        self.daemon.wait_for_log(r"id=named .*token=alice")
        self.daemon.request("GET", "/jobs", None, {**bearer("wrong-one"), "X-Request-Id": "unnamed"})
        line = self.daemon.wait_for_log(r"id=unnamed .*").group(0)
        self.assertIn("status=401", line)
        log = "\n".join(self.daemon.log)
        encoded = basic("alice", secret)["Authorization"].split()[1]
        for text in (secret, encoded, "wrong-one"):
            self.assertNotIn(text, log)

    def test_the_dashboard_asks_for_a_password(self):
        page = {"Accept": "text/html"}
        self.assertEqual(self.daemon.request("GET", "/", None, page).status, 401)
        known = basic("alice", self.file.secret["alice"])
        reply = self.daemon.request("GET", "/", None, {**page, **known})
        self.assertEqual((reply.status, reply.type), (200, "text/html; charset=utf-8"))


class Owners(Guarded):
    options = ["--workers", "2", "--callback-hosts", "127.0.0.1:9"]

    def test_a_job_is_there_for_its_owner_only(self):
        job = self.job("alice", "abc")
        self.end("alice", job)
        strange = "/jobs/" + 32 * "0"
        for method, path in (("GET", ""), ("HEAD", ""), ("GET", "/results"),
                             ("GET", "/results/solution"), ("GET", "/events"), ("DELETE", "")):
            with self.subTest(method + path):
                theirs = self.say("bob", method, job + path)
                nothing = self.say("bob", method, strange + path)
                self.assertEqual(theirs.status, 404)
                self.assertEqual(theirs.body.replace(job.encode()[6:], b""),
                                 nothing.body.replace(strange.encode()[6:], b""))
        self.assertEqual(self.say("alice", "GET", job + "/results").body, b"abc")
        self.assertEqual(self.say("alice", "DELETE", job).status, 200)
        self.assertEqual(self.say("bob", "GET", job).status, 404)
        self.assertEqual(self.say("alice", "GET", job + "/results").status, 410)

    def test_lists(self):
        mine, theirs = self.job("alice", "list a"), self.job("bob", "list b")

        def listed(who, query=""):
            return {"/jobs/" + job["jobID"]
                    for job in self.say(who, "GET", "/jobs?limit=1000" + query).json["jobs"]}
        for query in ("", "&status=accepted,running,successful", "&processID=solve",
                      "&minDuration=0"):
            self.assertNotIn(theirs, listed("alice", query))
            self.assertNotIn(mine, listed("bob", query))
        self.assertIn(mine, listed("alice"))
        self.assertIn(theirs, listed("bob"))

    def test_requests_of_a_batch(self):
        reply = self.say("alice", "POST", "/processes/batch/execution", "batch 3 x", ASYNC)
        self.assertEqual(reply.status, 201, reply.body)
        batch = reply.json["jobID"]
        self.end("alice", "/jobs/" + batch)
        parts = self.say("alice", "GET", f"/jobs?parent={batch}").json["jobs"]
        self.assertEqual(len(parts), 3)
        self.assertEqual(self.say("bob", "GET", f"/jobs?parent={batch}").status, 400)
        for part in parts:
            self.assertEqual(self.say("alice", "GET", "/jobs/" + part["jobID"]).status, 200)
            self.assertEqual(self.say("bob", "GET", "/jobs/" + part["jobID"]).status, 404)
        self.assertEqual(self.say("bob", "GET", f"/jobs/{batch}/results/0").status, 404)
        self.assertEqual(self.say("bob", "GET", f"/jobs/{batch}/results").status, 404)

    def test_keys_of_retries_are_each_ones_own(self):
        key = {"Idempotency-Key": "first"}
        mine = self.submit("alice", "key one", key).json["jobID"]
        theirs = self.submit("bob", "key two", key)
        self.assertEqual(theirs.status, 201)
        self.assertNotEqual(theirs.json["jobID"], mine)
        self.assertEqual(self.submit("alice", "key one", key).json["jobID"], mine)
        self.assertEqual(self.submit("alice", "key two", key).status, 422)

    def test_equal_requests_of_others_are_computed(self):
        first = self.job("alice", "equal")
        self.end("alice", first)
        again = self.job("alice", "equal")
        self.end("alice", again)
        self.assertIn("answered with", self.say("alice", "GET", again).json["message"])
        theirs = self.job("bob", "equal")
        self.end("bob", theirs)
        told = self.say("bob", "GET", theirs).json
        self.assertNotIn("answered with", told["message"])
        self.assertEqual(told["attempts"], 1)

    def test_data(self):
        body, kind = json.dumps([1, 2, 3]), {"Content-Type": "application/json"}
        mine = self.say("alice", "POST", "/data", body, kind)
        self.assertEqual(mine.status, 201, mine.body)
        path = "/data/" + mine.json["id"]
        self.assertEqual(self.say("alice", "POST", "/data", body, kind).status, 200)
        for method in ("GET", "HEAD", "DELETE"):
            self.assertEqual(self.say("bob", method, path).status, 404)
        # uploading the same bytes tells nothing of what others have, and gives nothing of it
        plain = "/data/" + hashlib.sha256(body.encode()).hexdigest()
        self.assertEqual(self.say("bob", "GET", plain).status, 404)
        theirs = self.say("bob", "POST", "/data", body, kind)
        self.assertEqual(theirs.status, 201)
        self.assertNotEqual(theirs.json["id"], mine.json["id"])
        self.assertEqual(self.say("bob", "DELETE", "/data/" + theirs.json["id"]).status, 204)
        self.assertEqual(self.say("alice", "GET", path).json, [1, 2, 3])
        self.assertEqual(self.say("alice", "DELETE", path).status, 204)


class References(Guarded):
    """Values by href, with the worker that computes."""

    stub = False
    options = ["--workers", "2"]

    def apply(self, who, href, headers=None):
        body = {"inputs": {"cloud": {"lattice": {"lower": [0, 0], "upper": [1, 1],
                                                 "cells": [4, 4]}},
                           "field": {"href": href}}, "outputs": {"value": {}}}
        return self.say(who, "POST", "/processes/apply/execution", json.dumps(body),
                        {"Content-Type": "application/json", **(headers or {})})

    def test_data_and_results_of_others(self):
        kept = self.say("alice", "POST", "/data", json.dumps([1.5] * 25),
                        {"Content-Type": "application/json"}).json
        path = "/data/" + kept["id"]
        self.assertEqual(self.apply("alice", path).status, 200)
        made = self.apply("alice", path, {"Prefer": "respond-async"}).json["jobID"]
        self.end("alice", "/jobs/" + made)
        result = f"/jobs/{made}/results/value"
        self.assertEqual(self.apply("alice", result).status, 200)
        for href in (path, kept["href"], result):
            with self.subTest(href):
                theirs = self.apply("bob", href)
                missing = self.apply("bob", href.replace(kept["id"], 64 * "0")
                                     .replace(made, 32 * "0"))
                self.assertEqual((theirs.status, missing.status), (400, 400), theirs.body)
                self.assertEqual(theirs.body.replace(kept["id"].encode(), b"")
                                 .replace(made.encode(), b""),
                                 missing.body.replace(64 * b"0", b"").replace(32 * b"0", b""))
                waiting = self.apply("bob", href, {"Prefer": "respond-async"})
                self.assertEqual(waiting.status, 400)

    def test_outputs_by_reference(self):
        body = {"inputs": {"cloud": {"lattice": {"lower": [0], "upper": [1], "cells": [5]}},
                           "field": 1},
                "outputs": {"value": {"transmissionMode": "reference"}}}
        reply = self.say("alice", "POST", "/processes/apply/execution", json.dumps(body),
                         {"Content-Type": "application/json"})
        path = "/data/" + reply.json["value"]["href"].rsplit("/", 1)[1]
        self.assertEqual(self.say("alice", "GET", path).status, 200)
        self.assertEqual(self.say("bob", "GET", path).status, 404)

    def test_points_of_a_token(self):
        self.file.add("carol", "points=100")
        self.daemon.process.send_signal(signal.SIGHUP)
        self.daemon.wait_for_log(r"event=tokens .*3 of them")
        for prefer in ({}, {"Prefer": "respond-async"}):
            for cells, status in ((9, 200), (10, 400)):
                body = {"inputs": {"cloud": {"lattice": {"lower": [0, 0], "upper": [1, 1],
                                                         "cells": [cells, cells]}}, "field": 1},
                        "outputs": {"value": {}}}
                reply = self.say("carol", "POST", "/processes/apply/execution", json.dumps(body),
                                 {"Content-Type": "application/json", **prefer})
                self.assertEqual(reply.status, 201 if prefer and status == 200 else status,
                                 reply.body)


class Limits(Guarded):
    limits = {"few": ["jobs=2"], "short": ["seconds=0.3"], "small": ["body-bytes=1000"],
              "poor": ["data-bytes=50", "job-bytes=50000"], "slow": ["rate=0.5", "burst=3"], "free": [],
              "watcher": ["streams=2"], "deaf": ["streams=0"]}
    options = ["--workers", "4"]

    def test_jobs(self):
        jobs = [self.job("few", f"sleep 600 {k}") for k in range(2)]
        refused = self.submit("few", "third")
        self.assert_problem(refused, 429, "jobs of the token")
        self.assertGreaterEqual(int(refused.headers["Retry-After"]), 1)
        self.assert_problem(self.say("few", "POST", daemon.EXECUTE, "x",
                                     {"Content-Type": "application/json"}), 429)
        self.assertEqual(self.submit("free", "others go on").status, 201)
        self.assertEqual(self.say("few", "DELETE", jobs[0]).status, 200)
        daemon.wait_until(lambda: self.submit("few", "third").status == 201, "room")
        self.assertEqual(self.say("few", "DELETE", jobs[1]).status, 200)

    def test_requests_of_a_batch_count(self):
        daemon.wait_until(lambda: self.submit("few", "now").status == 201, "room")
        reply = self.say("few", "POST", "/processes/batch/execution", "batch 3 x", ASYNC)
        self.assert_problem(reply, 429, "jobs of the token")

    def test_executions_that_are_no_jobs_count(self):
        replies = []

        def execute():
            replies.append(self.say("few", "POST", daemon.EXECUTE, "sleep 60",
                                    {"Content-Type": "application/json"}).status)
        daemon.wait_until(lambda: not [j for j in self.say("few", "GET", "/jobs?status=accepted,"
                                       "running").json["jobs"]], "no jobs")
        threads = [threading.Thread(target=execute) for _ in range(3)]
        for thread in threads:
            thread.start()
        daemon.wait_until(lambda: replies, "a refusal")
        with self.daemon.waking():
            for thread in threads:
                thread.join()
        self.assertEqual(sorted(replies), [200, 200, 429])

    def test_seconds(self):
        reply = self.say("short", "POST", daemon.EXECUTE, "sleep 600",
                         {"Content-Type": "application/json"})
        self.assert_problem(reply, 504, "0.3 s")
        job = self.job("short", "sleep 600")
        self.end("short", job)
        self.assert_problem(self.say("short", "GET", job + "/results"), 504, "0.3 s",
                            "seconds of the token")

    def test_body(self):
        kind = {"Content-Type": "application/json"}
        self.assertEqual(self.say("small", "POST", daemon.EXECUTE, b"x" * 1000, kind).status, 200)
        self.assert_problem(self.say("small", "POST", daemon.EXECUTE, b"x" * 1001, kind), 413,
                            "1000")
        head = (f"POST {daemon.EXECUTE} HTTP/1.1\r\nHost: a\r\nContent-Type: application/json\r\n"
                f"Authorization: Bearer {self.file.secret['small']}\r\n"
                "Transfer-Encoding: chunked\r\n\r\n").encode()
        with self.daemon.raw() as plain:
            plain.sendall(head + b"3e9\r\n" + b"x" * 1001 + b"\r\n0\r\n\r\n")
            reply = daemon.read_all(plain)
        self.assertTrue(reply.startswith(b"HTTP/1.1 413 "), reply[:200])
        self.assertEqual(self.say("free", "POST", daemon.EXECUTE, b"x" * 1001, kind).status, 200)

    def test_data(self):
        kind = {"Content-Type": "application/json"}
        first = json.dumps("a" * 30)
        self.assertEqual(self.say("poor", "POST", "/data", first, kind).status, 201)
        self.assert_problem(self.say("poor", "POST", "/data", json.dumps("b" * 30), kind), 507,
                            "of the token")
        self.assertEqual(self.say("poor", "POST", "/data", first, kind).status, 200)
        self.assertEqual(self.say("free", "POST", "/data", json.dumps("b" * 30), kind).status, 201)

    def test_stored_jobs(self):
        def submit(k):
            reply = self.submit("poor", f"sleep 60 {k}".ljust(20000))
            return reply.status if reply.status != 201 else "/jobs/" + reply.json["jobID"]
        jobs = [submit(1), submit(2)]
        self.assertEqual(submit(3), 507)
        self.assertEqual(self.submit("free", "others go on".ljust(60000)).status, 201)
        for job in jobs:
            self.assertEqual(self.say("poor", "DELETE", job).status, 200)
        last = daemon.wait_until(lambda: self.submit("poor", "x".ljust(20000)).status == 201,
                                 "room again")
        self.assertTrue(last)

    def watch(self, who, job):
        """An event stream that stays open, and its connection."""
        connection = self.daemon.connect()
        self.addCleanup(connection.close)
        connection.request("GET", job + "/events", headers=bearer(self.file.secret[who]))
        stream = connection.getresponse()
        self.assertEqual(stream.status, 200)
        return connection, stream

    def test_streams(self):
        job, other = self.job("watcher", "sleep 60"), self.job("free", "sleep 60 other")
        streams = [self.watch("watcher", job) for _ in range(2)]
        refused = self.say("watcher", "GET", job + "/events")
        self.assert_problem(refused, 429, "2 event streams", "above 2", "streams of the token")
        self.assertGreaterEqual(int(refused.headers["Retry-After"]), 1)
        self.assertEqual(self.say("watcher", "GET", job).status, 200)  # only streams
        others = [self.watch("free", other) for _ in range(5)]
        streams[0][1].close()
        streams[0][0].close()
        daemon.wait_until(lambda: self.say("watcher", "HEAD", job + "/events").status == 200,
                          "room for a stream")
        self.watch("watcher", job)
        self.assertEqual(self.say("watcher", "GET", job + "/events").status, 429)
        # one that ends with its job is counted no more
        self.assertEqual(self.say("watcher", "DELETE", job).status, 200)
        self.assertIn(b"dismissed", streams[1][1].read())
        again = self.job("watcher", "sleep 60 again")
        daemon.wait_until(lambda: self.say("watcher", "HEAD", again + "/events").status == 200,
                          "room for a stream")
        for who, which in (("watcher", again), ("free", other)):
            self.assertEqual(self.say(who, "DELETE", which).status, 200)
        for _, stream in others:
            self.assertIn(b"dismissed", stream.read())

    def test_no_streams_at_all(self):
        job = self.job("deaf", "soon over")
        self.end("deaf", job)
        self.assert_problem(self.say("deaf", "GET", job + "/events"), 429, "streams of the token")
        self.assertEqual(self.say("deaf", "GET", job + "/results").status, 200)

    def test_rate(self):
        began = time.monotonic()
        for _ in range(3):
            self.assertEqual(self.say("slow", "GET", "/conformance").status, 200)
        replies = [self.say("slow", "GET", "/conformance")]
        while replies[-1].status == 200:
            replies.append(self.say("slow", "GET", "/conformance"))
        refused = replies[-1]
        self.assert_problem(refused, 429)
        self.assertLessEqual(len(replies) - 1, 0.5 * (time.monotonic() - began) + 0.1)
        self.assertIn(int(refused.headers["Retry-After"]), (1, 2))
        self.assertEqual(self.say("free", "GET", "/conformance").status, 200)
        self.assertEqual(self.get("/healthz").status, 200)
        daemon.wait_until(lambda: self.say("slow", "GET", "/conformance").status == 200, "patience")


class Reload(Guarded):
    options = ["--workers", "1"]

    def reload(self):
        before = len(self.daemon.log)
        self.daemon.process.send_signal(signal.SIGHUP)

        def told():
            return [line for line in self.daemon.log[before:]
                    if "event=tokens" in line or "event=reload" in line]
        return daemon.wait_until(told, "a line of the log")[-1]

    def status(self, who):
        return self.say(who, "GET", "/jobs").status

    def test_tokens_come_and_go_and_what_cannot_be_read_changes_nothing(self):
        text = pathlib.Path(self.file.path).read_text(encoding="utf-8")
        old = dict(self.file.secret)
        self.file.add("dave")
        self.assertEqual(self.status("dave"), 401)
        self.assertIn("3 of them", self.reload())
        self.assertEqual(self.status("dave"), 200)
        self.file.write(text.splitlines()[0] + "\n")
        self.assertIn("1 of them", self.reload())
        self.assertEqual([self.status(who) for who in ("alice", "bob", "dave")], [200, 401, 401])
        self.file.write(text + "\nmallory sha256:12\n")
        line = self.reload()
        self.assertRegex(line, r":4: .*digest")
        self.assertEqual([self.status(who) for who in ("alice", "bob")], [200, 401])
        os.unlink(self.file.path)
        self.assertIn("cannot read", self.reload())
        self.assertEqual(self.status("alice"), 200)
        self.file.write(text)
        os.chmod(self.file.path, 0o666)
        self.assertIn("written by others", self.reload())
        os.chmod(self.file.path, 0o600)
        self.assertIn("2 of them", self.reload())
        # a second secret beside the first, then instead of it
        secret, line = make_token("alice")
        digest = line.split()[1]
        first, rest = text.split("\n", 1)
        self.file.write(f"{first} {digest}\n{rest}")
        self.reload()
        self.assertEqual(self.daemon.request("GET", "/jobs", None, bearer(secret)).status, 200)
        self.assertEqual(self.status("alice"), 200)
        self.file.write(f"{line}{rest}")
        self.reload()
        self.assertEqual(self.daemon.request("GET", "/jobs", None, bearer(secret)).status, 200)
        self.assertEqual(self.status("alice"), 401)
        self.file.secret = old
        self.file.write(text)
        self.reload()

    def test_connections_and_requests_outlive_it(self):
        replies = []
        thread = threading.Thread(target=lambda: replies.append(self.say(
            "alice", "POST", daemon.EXECUTE, "sleep 60", {"Content-Type": "application/json"})))
        thread.start()
        daemon.wait_until(lambda: "busy\"} 1" in self.say("bob", "GET", "/metrics").body.decode(),
                          "a busy worker")
        self.reload()
        with self.daemon.waking():
            thread.join()
        self.assertEqual(replies[0].status, 200)


class Files(unittest.TestCase):
    """What the daemon says of a file at its start."""

    def start(self, text, mode=0o600):
        with tempfile.TemporaryDirectory() as directory:
            path = os.path.join(directory, "tokens")
            with open(path, "w", encoding="utf-8") as file:
                file.write(text)
            os.chmod(path, mode)
            return subprocess.run(
                [daemon.program(stub=True), "--listen", "127.0.0.1:0", "--data-dir",
                 directory, "--tokens", path, "--workers", "1"],
                capture_output=True, text=True, check=False, timeout=daemon.PATIENCE)

    def test_bad_ones(self):
        digest = "sha256:" + 64 * "a"
        for text, line, word in [
                ("# nothing\n", None, "no token"), (f"\nalice\n", 2, "no sha256"),
                (f"alice {digest[:-1]}\n", 1, "63 characters"),
                (f"alice sha256:{64 * 'A'}\n", 1, "needs 64 of 0-9 and a-f"),
                (f"alice {digest} colour=red\n", 1, "colour=red"),
                (f"alice {digest} jobs=-1\n", 1, "integer from 0"),
                (f"alice {digest} jobs=1.5\n", 1, "1.5"),
                (f"alice {digest} streams=-2\n", 1, "integer from 0"), (f"alice {digest} rate=0\n", 1, "rate"),
                (f"alice {digest} seconds=\n", 1, "seconds"),
                (f"10.0.0.1 {digest}\n", 1, "a letter"), (f"local {digest}\n", 1, "local"),
                (f"a:b {digest}\n", 1, "name"), (f"{33 * 'a'} {digest}\n", 1, "name"),
                (f"alice {digest}\nalice sha256:{64 * 'b'}\n", 2, "twice"),
                (f"alice {digest}\nbob {digest}\n", 2, "secret of alice"),
                ("alice " + 5 * (digest + " "), 1, "more than 4")]:
            with self.subTest(text[:40]):
                done = self.start(text)
                self.assertEqual(done.returncode, 1)
                self.assertIn(word, done.stderr)
                if line:
                    self.assertIn(f"tokens:{line}: ", done.stderr)

    def test_one_that_others_may_write(self):
        done = self.start("alice sha256:" + 64 * "a", 0o620)
        self.assertEqual(done.returncode, 1)
        self.assertIn("mode 620", done.stderr)

    def test_one_that_is_not_there(self):
        done = subprocess.run([daemon.program(stub=True), "--listen", "127.0.0.1:0", "--tokens",
                               "/no/such/file"], capture_output=True, text=True, check=False,
                              timeout=daemon.PATIENCE)
        self.assertEqual(done.returncode, 1)
        self.assertIn("/no/such/file", done.stderr)

    def test_a_reload_during_the_start_waits_for_its_end(self):
        file = TokenFile()
        self.addCleanup(file.directory.cleanup)
        file.add("alice")
        pipe = file.path + ".pipe"
        os.mkfifo(pipe, 0o600)
        process = subprocess.Popen(
            [daemon.program(stub=True), "--listen", "127.0.0.1:0", "--data-dir",
             file.directory.name, "--tokens", pipe, "--workers", "1"], stderr=subprocess.PIPE,
            text=True)
        self.addCleanup(process.kill)

        def opened():  # once the daemon waits at its end
            with contextlib.suppress(OSError):
                return os.open(pipe, os.O_WRONLY | os.O_NONBLOCK)
        end = daemon.wait_until(opened, "it reads the file")
        text = pathlib.Path(file.path).read_bytes()
        os.rename(file.path, pipe)
        process.send_signal(signal.SIGHUP)
        os.write(end, text)
        os.close(end)
        lines = iter(process.stderr.readline, "")
        self.assertTrue(any("event=listening" in line for line in lines))
        self.assertTrue(any("event=tokens" in line for line in lines))
        process.terminate()
        process.communicate(timeout=daemon.PATIENCE)
        self.assertEqual(process.returncode, 0)

    def test_one_that_others_may_read_is_complained_of(self):
        file = TokenFile()
        self.addCleanup(file.directory.cleanup)
        file.add("alice")
        os.chmod(file.path, 0o644)
        running = daemon.Daemon("--tokens", file.path, "--workers", "1")
        self.addCleanup(running.stop)
        running.wait_for_log("event=tokens .*may be read by everybody")

    def test_the_command(self):
        secret, line = make_token("alice", "jobs=3", "rate=2.5")
        digest = hashlib.sha256(secret.encode()).hexdigest()
        self.assertEqual(line, f"alice sha256:{digest} jobs=3 rate=2.5\n")
        self.assertNotEqual(make_token("alice")[0], secret)
        for words in ([], ["1a"], ["a b"], ["alice", "jobs"], ["alice", "jobs=x"],
                      ["alice", "sha256:" + 64 * "a"]):
            done = subprocess.run([daemon.program(stub=True), "token", *words], check=False,
                                  capture_output=True, text=True)
            self.assertEqual((done.returncode, done.stdout), (2, ""), words)


class Names(daemon.Case):
    """Without tokens, on loopback: only its own names."""

    options = ["--hosts", "solve.example other.example:99", "--public-url", "http://pde.example/x",
               "--workers", "1"]

    def test_own_names(self):
        for host in ("localhost", "LOCALHOST:1", "a.localhost", "127.0.0.1", "127.8.9.1:80",
                     "[::1]", "[::1]:80", "[::ffff:127.0.0.1]", "solve.example", "Solve.Example:8",
                     "other.example", "pde.example", "localhost."):
            self.assertEqual(self.get("/healthz", Host=host).status, 200, host)
        self.assertTrue(self.exchange(b"GET /healthz HTTP/1.0\r\n\r\n").startswith(b"HTTP/1.1 200"))

    def test_others(self):
        for host in ("evil.example", "localhost.evil.example", "evillocalhost", "xsolve.example",
                     "solve.example.evil", "10.0.0.1", "[fe80::1]", "127.0.0.1.evil.example",
                     "pde.example.evil", "pde.exampl", "pd", "127.1", "0"):
            self.assert_problem(self.get("/healthz", Host=host), 421, host)


class Pages(daemon.Case):
    """Pages of other origins, without tokens."""

    options = ["--workers", "1", "--cors-origins", "https://friend.example"]

    def post(self, **headers):
        return self.execute("x", **headers)

    def test_own(self):
        own = f"http://{self.daemon.address}"
        self.assertEqual(self.post(Origin=own).status, 200)
        self.assertEqual(self.post(Origin="https://friend.example").status, 200)
        # behind a proxy that changes Host
        self.assertEqual(self.post(Origin="https://proxy", Sec_Fetch_Site="same-origin").status,
                         200)

    def test_others(self):
        own = f"http://{self.daemon.address}"
        for origin in ("https://evil.example", "null", own + "0", own[:-1], own + ".evil", "http",
                       "http://localhost", ""):
            with self.subTest(origin):
                if origin:
                    self.assert_problem(self.post(Origin=origin), 403, "Origin")
        self.assert_problem(self.post(Origin="https://evil.example", Sec_Fetch_Site="cross-site"),
                            403)
        for method, path in (("DELETE", "/jobs/x"), ("POST", "/data")):
            self.assert_problem(self.request(method, path, "x", {"Origin": "https://evil.example"}),
                                403)
        self.assertEqual(self.request("POST", "/Evaluate", "x",
                                      {"Origin": "https://evil.example"}).status, 403)
        self.assertEqual(self.get("/healthz", Origin="https://evil.example").status, 200)


class Listening(unittest.TestCase):
    """Beyond loopback only with tokens, or if the operator says so."""

    def start(self, *options):
        directory = tempfile.TemporaryDirectory()
        self.addCleanup(directory.cleanup)
        process = subprocess.Popen(
            [daemon.program(stub=True), "--data-dir", directory.name, "--workers", "1", *options],
            stderr=subprocess.PIPE, text=True)
        self.addCleanup(process.stderr.close)
        self.addCleanup(process.wait)
        self.addCleanup(process.kill)
        return process

    def test_refused(self):
        for address in ("0.0.0.0:0", "[::]:0"):
            process = self.start("--listen", address)
            text = process.communicate(timeout=daemon.PATIENCE)[1]
            self.assertEqual(process.returncode, 1, text)
            for word in (address[:-1], "scatterd token NAME", "127.0.0.1", "allow-anonymous 1"):
                self.assertIn(word, text)

    def serve(self, *options):
        """The port of a daemon on all addresses."""
        process = self.start("--listen", "0.0.0.0:0", *options)
        for line in process.stderr:
            found = re.search(r"event=listening address=0\.0\.0\.0:(\d+)", line)
            if found:
                threading.Thread(target=process.stderr.read, daemon=True).start()
                return int(found.group(1))
        raise AssertionError("it ended")

    def ask(self, port, host):
        connection = daemon.http.client.HTTPConnection("127.0.0.1", port, timeout=daemon.PATIENCE)
        try:
            connection.request("GET", "/healthz", headers={"Host": host})
            return connection.getresponse().status
        finally:
            connection.close()

    def test_allowed(self):
        port = self.serve("--allow-anonymous", "1", "--hosts", "me.example")
        self.assertEqual([self.ask(port, host) for host in
                          ("10.1.2.3", "[fe80::1]:5", "me.example", "localhost", "evil.example")],
                         [200, 200, 200, 200, 421])

    def test_with_tokens(self):
        file = TokenFile()
        self.addCleanup(file.directory.cleanup)
        file.add("alice")
        port = self.serve("--tokens", file.path)
        self.assertEqual(self.ask(port, "any.example"), 200)


class Watchers(Guarded):
    options = ["--workers", "1", "--open-metrics", "1"]

    def test_metrics_without_a_token(self):
        self.assertEqual(self.get("/metrics").status, 200)
        self.assertEqual(self.get("/jobs").status, 401)


class Leaks(Guarded):
    """What strangers and owners can learn of the machine from refusals."""

    limits = {"alice": ["rate=1000"], "few": ["jobs=0", "body-bytes=10", "data-bytes=1"]}
    options = ["--workers", "1", "--seconds", "0.5", "--fetch-hosts", "127.0.0.1:9"]
    stub = False

    def replies(self):
        kind = {"Content-Type": "application/json"}
        apply, echo = "/processes/apply/execution", "/processes/echo/execution"
        href = json.dumps({"inputs": {"cloud": {"href": "http://127.0.0.1:9/x"}, "field": 1}})
        pause = json.dumps({"inputs": {"message": "", "pause": 9}})
        for who in (None, "alice", "few"):
            for method, path, body, headers in [
                    ("GET", "/nothing", None, {}), ("GET", "/%zz", None, {}),
                    ("PUT", "/jobs", None, {}), ("GET", "/jobs?limit=x", None, {}),
                    ("GET", "/jobs", None, {"Accept": "image/png"}),
                    ("GET", "/assets/../../etc/passwd", None, {}),
                    ("GET", "/data/../jobs.db", None, {}), ("GET", "/jobs/..%2flock", None, {}),
                    ("GET", "/processes/..%2f..%2fx", None, {}), ("POST", apply, "{", kind),
                    ("POST", apply, "{}", {"Content-Type": "text/plain"}),
                    ("POST", apply, "x" * 20, kind), ("POST", apply, href, kind),
                    ("POST", apply, href, ASYNC), ("POST", echo, pause, kind),
                    ("POST", "/data", "{", kind), ("POST", "/data", "[1,2]", kind),
                    ("POST", "/Evaluate", "{}", kind), ("POST", "/processes/x/execution", "", kind),
                    ("DELETE", "/jobs/x", None, {}), ("DELETE", "/data/x", None, {}),
                    ("POST", apply, "{}", {**kind, "Origin": "http://evil"}),
                    ("GET", "/healthz", None, {"X": 20000 * "x"})]:
                yield self.say(who, method, path, body, headers)
        yield self.daemon.request("GET", "/x" * 20000)

    def test_no_paths_and_no_versions(self):
        version = subprocess.run([daemon.program(stub=False), "--version"], check=True,
                                 capture_output=True, text=True).stdout.split()[1]
        secrets = (self.daemon.directory, self.file.path, self.file.secret["alice"], version,
                   "microhttpd", "sqlite", "jobs.db", "/usr/", "/home/", "/proc/", "root:")
        seen = set()
        for reply in self.replies():
            text = reply.body.decode() + str(reply.headers)
            seen.add(reply.status)
            for word in secrets:
                self.assertNotIn(word, text.replace("/data/../jobs.db", ""))
            self.assertIsNone(reply.headers["Server"])
        self.assertGreaterEqual(seen, {400, 401, 403, 404, 405, 406, 413, 414, 415, 429, 431, 504})


class After(unittest.TestCase):
    """Jobs keep their owner over a restart."""

    def test_restart(self):
        file = TokenFile()
        self.addCleanup(file.directory.cleanup)
        for name in ("alice", "bob"):
            file.add(name, "jobs=1")
        first = daemon.Daemon("--tokens", file.path, "--workers", "1")
        self.addCleanup(first.stop)
        first.wait_ready()
        made = first.request("POST", daemon.EXECUTE, "sleep 600",
                             {**ASYNC, **bearer(file.secret["alice"])}).json["jobID"]
        first.stop(keep=True)
        second = daemon.Daemon("--tokens", file.path, "--workers", "2", directory=first.directory)
        self.addCleanup(second.stop)
        second.wait_ready()

        def ask(who, method="GET", path="/jobs/" + made, body=None, headers=None):
            return second.request(method, path, body,
                                  {**bearer(file.secret[who]), **(headers or {})}).status
        self.assertEqual([ask("alice"), ask("bob")], [200, 404])
        self.assertEqual(ask("alice", "POST", daemon.EXECUTE, "more", ASYNC), 429)
        self.assertEqual(ask("bob", "POST", daemon.EXECUTE, "more", ASYNC), 201)
        self.assertEqual(ask("alice", "DELETE"), 200)


if __name__ == "__main__":
    unittest.main()
