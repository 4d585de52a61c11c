#!/usr/bin/env python3
"""http.jobs: jobs with a worker that does what its body says (stub_answer.c): accepted, queued,
watched, ended, dismissed, expired. The standard's own words are tested by http.conformance."""

import contextlib
import datetime
import json
import os
import pathlib
import re
import signal
import sys
import threading
import time
import unittest

sys.dont_write_bytecode = True
import daemon  # noqa: E402

RELATION = "http://www.opengis.net/def/rel/ogc/1.0/"
EXCEPTION = "http://www.opengis.net/def/exceptions/ogcapi-processes-1/1.0/"
TERMINAL = {"successful", "failed", "dismissed"}


class Jobs(daemon.Case):
    """Helpers. Equal requests are answered with one result, so no two tests of a class send the same."""

    def submit(self, body, path=daemon.EXECUTE, prefer="respond-async", **headers):
        reply = self.execute(body, path, Prefer=prefer, **headers)
        self.assertEqual(reply.status, 201, reply.body)
        return reply.json["jobID"]

    def status(self, job, **headers):
        reply = self.get(f"/jobs/{job}", **headers)
        self.assertEqual(reply.status, 200, reply.body)
        return reply.json

    def finish(self, job):
        return daemon.wait_until(
            lambda: (lambda info: info if info["status"] in TERMINAL else None)(
                self.status(job, Prefer="wait=20")), f"the end of job {job}")

    def wait_for(self, job, state):
        return daemon.wait_until(
            lambda: (lambda info: info if info["status"] == state else None)(self.status(job)),
            f"job {job} to be {state}")

    @contextlib.contextmanager
    def waiting(self, job):
        """A long poll that the daemon holds by now; gives what returns what is told in the end."""
        with contextlib.closing(self.daemon.connect()) as connection:
            connection.request("GET", f"/jobs/{job}", headers={"Prefer": "wait=30"})
            self.daemon.wait_taken_in()
            yield lambda: json.loads(connection.getresponse().read())

    def results(self, job, **headers):
        return self.get(f"/jobs/{job}/results", **headers)

    def dismiss(self, job):
        return self.request("DELETE", f"/jobs/{job}")

    def links(self, info):
        return {link["rel"]: link for link in info["links"]}

    def files(self):
        return self.daemon.files()


class Submission(Jobs):
    options = ["--workers", "2"]

    def test_created(self):
        reply = self.execute("x", Prefer="respond-async")
        info = reply.json
        self.assertEqual((reply.status, reply.type), (201, "application/json"))
        self.assertEqual(reply.headers["Location"],
                         f"http://{self.daemon.address}/jobs/{info['jobID']}")
        self.assertEqual(reply.headers["Preference-Applied"], "respond-async")
        self.assertEqual(info["status"], "accepted")
        self.assertEqual((info["processID"], info["type"]), ("solve", "process"))
        self.assertIn("created", info)
        for absent in ("started", "finished", "expires"):
            self.assertNotIn(absent, info)  # left out, never null
        self.assertIn("monitor", self.links(info))
        self.assertNotIn(RELATION + "results", self.links(info))
        done = self.finish(info["jobID"])
        self.assertEqual((done["status"], done["progress"]), ("successful", 100))
        self.assertIn(RELATION + "results", self.links(done))
        self.assertNotIn("monitor", self.links(done))
        self.assertLessEqual(done["created"], done["started"])
        self.assertLessEqual(done["started"], done["finished"])
        self.assertLess(done["finished"], done["expires"])
        self.assertEqual(self.results(info["jobID"]).body, b"x")

    def test_preferences(self):
        for prefer in ('respond-async', 'RESPOND-ASYNC', 'handling=lenient, respond-async; x="a,b"',
                       'unknown; a=1, other="x, y", respond-async'):
            with self.subTest(prefer):
                reply = self.execute("preferences", Prefer=prefer)
                self.assertEqual(reply.status, 201)
                self.assertEqual(reply.headers["Preference-Applied"], "respond-async")
        reply = self.execute("x", Prefer="respond-async, return=minimal, priority=7")
        self.assertEqual(reply.headers["Preference-Applied"],
                         "respond-async, return=minimal, priority=7")
        self.assertEqual(set(reply.json), {"processID", "type", "jobID", "status", "links"})
        self.assertEqual(self.status(reply.json["jobID"])["priority"], 7)
        reply = self.execute("x", Prefer="respond-async, return=representation, priority=99")
        self.assertEqual(reply.headers["Preference-Applied"], "respond-async, return=representation")
        self.assertEqual(reply.json["priority"], 5)

    def test_wait_gives_the_results(self):
        reply = self.execute("waited for", Prefer="respond-async, wait=20")
        self.assertEqual((reply.status, reply.body), (200, b"waited for"))
        self.assertEqual(reply.headers["Preference-Applied"], "wait=20")
        self.assertEqual(self.execute("waited for", Prefer="respond-async, wait=99999999999999999999")
                         .headers["Preference-Applied"], "wait=60")
        self.assertIsNone(reply.headers["Link"])
        self.assertRegex(reply.headers["Content-Location"], r"/jobs/[0-9a-f]{32}/results$")
        reply = self.execute("problem", Prefer="respond-async, wait=20")
        self.assert_problem(reply, 422, "singular")

    def test_wait_may_be_too_short(self):
        for wait in (1, 4, 16, 60):  # until one has begun by then, which is told
            reply = self.execute("sleep 600", Prefer=f"respond-async, wait={wait}")
            self.assertEqual(reply.status, 201)
            self.assertEqual(reply.headers["Preference-Applied"], f"respond-async, wait={wait}")
            self.assertEqual(self.dismiss(reply.json["jobID"]).status, 200)
            if reply.json["status"] == "running":
                break
        self.assertEqual(reply.json["status"], "running")

    def test_wait_minimal_gives_the_status(self):
        reply = self.execute("minimal", Prefer="respond-async, wait=20, return=minimal")
        self.assertEqual((reply.status, reply.json["status"]), (201, "successful"))

    def test_refused_by_the_check(self):
        daemon.wait_until(lambda: not self.get("/jobs?status=accepted,running").json["jobs"],
                          "the end of all jobs, whose files go")
        before = self.get("/jobs?limit=1000").json["jobs"]
        files = self.files()
        reply = self.execute("bad", Prefer="respond-async")
        self.assert_problem(reply, 422, "singular")
        self.assertIsNone(reply.headers["Location"])
        self.assertEqual(len(self.get("/jobs?limit=1000").json["jobs"]), len(before))
        self.assertEqual(self.files(), files)

    def test_refused_by_the_header(self):
        reply = self.request("POST", "/processes/none/execution", "{}", {"Prefer": "respond-async"})
        self.assertEqual(self.assert_problem(reply, 404)["type"], EXCEPTION + "no-such-process")
        self.assert_problem(self.execute("x", Prefer="respond-async", Content_Type="text/html"), 415)

    def test_failures(self):
        for body, status, words in (("problem", 422, ["singular"]), ("memory", 422, ["memory-bytes"])):
            with self.subTest(body):
                job = self.submit(body)
                info = self.finish(job)
                self.assertEqual(info["status"], "failed")
                self.assertIn(words[0], info["message"])
                self.assertIn(RELATION + "exceptions", self.links(info))
                self.assertNotIn(RELATION + "results", self.links(info))
                self.assert_problem(self.results(job), status, *words)
                plain = self.results(job, Accept="application/json")
                self.assertEqual((plain.status, plain.type), (status, "application/json"))

    def test_a_worker_that_dies_is_tried_again(self):
        job = self.submit("abort")
        info = self.finish(job)
        self.assertEqual((info["status"], info["attempts"]), ("failed", 3))
        self.assert_problem(self.results(job), 500, "3 attempts")
        self.assertEqual(sum("waits again" in line["text"] for line in info["log"]), 2, info["log"])
        self.assertTrue(any("runs, attempt 3" in line["text"] for line in info["log"]), info["log"])

    def test_files_go(self):
        job = self.submit("big 100000" + 20000 * " ")  # what is small stands in the store
        self.finish(job)
        self.assertEqual(len(self.results(job).body), 100000)
        self.assertEqual([name for name in self.files() if name.startswith(job)], [job + ".result"])
        self.dismiss(job)
        self.assertEqual([name for name in self.files() if name.startswith(job)], [])

    def test_codings(self):
        job = self.submit("packed", Content_Encoding="gzip")
        self.finish(job)
        self.assertEqual(self.results(job).headers["Content-Encoding"], "gzip")
        self.assert_problem(self.results(job, Accept_Encoding="identity;q=0"), 406)

    def test_methods(self):
        job = self.submit("x")
        for path in ("/jobs", f"/jobs/{job}", f"/jobs/{job}/results", f"/jobs/{job}/events"):
            with self.subTest(path):
                reply = self.request("PUT", path)
                self.assert_problem(reply, 405)
                self.assertIn("GET", reply.headers["Allow"])
        self.assertIn("DELETE", self.request("OPTIONS", f"/jobs/{job}").headers["Allow"])
        head = self.request("HEAD", f"/jobs/{job}")
        self.assertEqual((head.status, head.body), (200, b""))

    def test_no_such_job(self):
        for path in ("/jobs/none", "/jobs/" + 300 * "0", "/jobs/none%2Fresults", "/jobs/none/results", "/jobs/none/results/x", "/jobs/none/events"):
            with self.subTest(path):
                problem = self.assert_problem(self.get(path), 404)
                self.assertEqual(problem["type"], EXCEPTION + "no-such-job")
        self.assertEqual(self.assert_problem(self.dismiss("none"), 404)["type"],
                         EXCEPTION + "no-such-job")


class Ending(Jobs):
    options = ["--workers", "2"]

    def test_results_of_a_running_job(self):
        job = self.submit("sleep 600")
        self.wait_for(job, "running")
        reply = self.results(job)
        self.assertEqual(self.assert_problem(reply, 404)["type"], EXCEPTION + "result-not-ready")
        reply = self.get(f"/jobs/{job}/results/x")
        self.assertEqual(self.assert_problem(reply, 404)["type"], EXCEPTION + "result-not-ready")
        self.dismiss(job)

    def test_dismiss_kills_the_run(self):
        job = self.submit("sleep 60")
        self.wait_for(job, "running")
        workers = daemon.children(self.daemon.pid)
        reply = self.dismiss(job)
        self.assertEqual((reply.status, reply.json["status"]), (200, "dismissed"))
        daemon.wait_until(lambda: set(workers) - set(daemon.children(self.daemon.pid)),
                          "the end of a worker")
        self.assert_problem(self.results(job), 410)
        self.assert_problem(self.dismiss(job), 410)
        self.assertEqual(self.status(job)["status"], "dismissed")
        self.daemon.wait_ready()

    def test_dismiss_a_waiting_job(self):
        first = self.submit("sleep 60")
        self.wait_for(first, "running")
        second = self.submit("waits")
        self.assertEqual(self.dismiss(second).json["status"], "dismissed")
        self.assertNotIn("started", self.status(second))
        self.dismiss(first)

    def test_dismiss_a_successful_job(self):
        job = self.submit("done")
        self.finish(job)
        self.assertEqual(self.dismiss(job).json["status"], "dismissed")
        self.assert_problem(self.results(job), 410)
        self.assert_problem(self.dismiss(job), 410)

    def test_dismiss_tells_who_waits(self):
        job = self.submit("sleep 60")
        self.wait_for(job, "running")
        with self.waiting(job) as told:
            self.dismiss(job)
            self.assertEqual(told()["status"], "dismissed")


class Limited(Jobs):
    options = ["--workers", "2", "--job-seconds", "3"]

    def test_time(self):
        job = self.submit("phase factor 0.5 600")
        self.assertEqual(self.finish(job)["status"], "failed")
        self.assert_problem(self.results(job), 504, "factor", "job-seconds")


class Expiring(Jobs):
    options = ["--workers", "2", "--result-seconds", "2"]

    def test_expiry(self):
        reply = self.execute("expires", Prefer="respond-async, wait=20")
        self.assertEqual((reply.status, reply.body), (200, b"expires"))  # and who is late has a 404
        job = reply.headers["Content-Location"].split("/")[-2]
        daemon.wait_until(lambda: self.get(f"/jobs/{job}").status == 404, "its expiry")
        self.assertEqual([name for name in self.files() if name.startswith(job)], [])


class Watching(Jobs):
    options = ["--workers", "2", "--heartbeat-seconds", "0.3", "--streams", "3",
               "--wait-seconds", "30"]

    def events(self, job, after=None, enough=None):
        """Events of a job: (id, event, data); heartbeats as (None, None, None). Until it is enough,
        or to its end, which it comes to once the stream is there."""
        connection = self.daemon.connect()
        connection.request("GET", f"/jobs/{job}/events",
                           headers={"Last-Event-ID": str(after)} if after is not None else {})
        reply = connection.getresponse()
        self.assertEqual((reply.status, reply.headers["Content-Type"]), (200, "text/event-stream"))
        found, event = [], {}
        with contextlib.nullcontext() if enough else self.daemon.waking():
            for line in reply:
                text = line.decode().rstrip("\n")
                if text:
                    name, _, value = text.partition(": ")
                    event[name] = value
                    continue
                data = json.loads(event["data"]) if "data" in event else None
                found.append((int(event["id"]) if data else None, event.get("event"), data))
                event = {}
                if enough and enough(found):
                    break
        connection.close()
        return found

    def test_etag(self):
        job = self.submit("etag")
        self.finish(job)
        reply = self.get(f"/jobs/{job}")
        tag = reply.headers["ETag"]
        self.assertRegex(tag, r'^"[0-9a-f]+"$')
        for known in (tag, f'"other", {tag}', f"W/{tag}", "*"):
            again = self.get(f"/jobs/{job}", If_None_Match=known)
            self.assertEqual((again.status, again.body), (304, b""))
            self.assertEqual(again.headers["Content-Length"], str(len(reply.body)))
        self.assertEqual(self.get(f"/jobs/{job}", If_None_Match='"other"').status, 200)
        self.assertEqual(self.get(f"/jobs/{job}", If_None_Match=tag, Prefer="wait=5").status, 304)

    def test_long_poll_ends_with_the_job(self):
        job = self.submit("sleep 600 job")
        self.wait_for(job, "running")
        with self.waiting(job) as told, self.daemon.waking():
            self.assertEqual(told()["status"], "successful")

    def test_long_poll_ends_with_its_time(self):
        job = self.submit("sleep 600 time")
        self.wait_for(job, "running")
        reply = self.get(f"/jobs/{job}", Prefer="wait=1")
        self.assertEqual(reply.headers["Preference-Applied"], "wait=1")
        self.assertEqual(reply.json["status"], "running")
        self.dismiss(job)

    def test_long_poll_with_a_tag_ends_with_any_change(self):
        job = self.submit("phase factor 0.42 600")
        daemon.wait_until(lambda: self.status(job).get("phase") == "factor", "the phase")
        tag = self.get(f"/jobs/{job}").headers["ETag"]
        self.assertEqual(self.get(f"/jobs/{job}", If_None_Match=tag, Prefer="wait=1").status, 304)
        info = self.status(job, If_None_Match='"old"', Prefer="wait=5")
        self.assertEqual((info["status"], info["phase"], info["progress"]), ("running", "factor", 42))
        self.dismiss(job)

    def test_a_client_that_leaves(self):
        job = self.submit("sleep 600 left")
        for path in (f"/jobs/{job}", f"/jobs/{job}/events"):
            with self.daemon.raw() as plain:
                plain.sendall(f"GET {path} HTTP/1.1\r\nHost: a\r\nPrefer: wait=5\r\n\r\n".encode())
                self.daemon.wait_taken_in()
        with self.daemon.waking():
            self.assertEqual(self.finish(job)["status"], "successful")

    def test_events(self):
        job = self.submit("phase factor 0.25 600 events")
        found = [event for event in self.events(job, after=1) if event[1]]
        ids = [event[0] for event in found]
        self.assertEqual(ids, sorted(set(ids)))
        self.assertEqual(found[-1][1:2], ("status",))
        self.assertEqual(found[-1][2]["status"], "successful")
        self.assertIn(("phase", "factor"), [(event[1], event[2].get("phase")) for event in found])
        self.assertIn(("progress", 25), [(event[1], event[2]["progress"]) for event in found])

    def test_residuals(self):
        job = self.submit("residual 1.25e-3")
        daemon.wait_until(lambda: self.status(job).get("residual") == 1.25e-3, "the residual")
        found = [event for event in self.events(job, after=1) if event[1] == "residual"]
        self.assertEqual([event[2] for event in found],
                         [{"progress": 75, "phase": "solve", "residual": 1.25e-3}])
        self.assertNotIn("residual", self.status(job))

    def test_events_resume(self):
        job = self.submit("phase factor 0.25 600 resume")
        daemon.wait_until(lambda: self.status(job)["progress"] == 25, "progress")
        everything = [event for event in self.events(job, after=1) if event[1]]
        self.assertEqual([event[1] for event in everything[-1:]], ["status"])
        last = everything[-1][0]
        reply = self.get(f"/jobs/{job}/events", Last_Event_ID=str(last))
        self.assertEqual((reply.status, reply.body), (204, b""))
        self.assertEqual([event[1] for event in self.events(job, after=everything[0][0])], ["status"])

    def test_events_resume_in_the_middle(self):
        job = self.submit("phase factor 0.25 600 middle")
        daemon.wait_until(lambda: self.status(job)["progress"] == 25, "progress")
        connection = self.daemon.connect()
        connection.request("GET", f"/jobs/{job}/events", headers={"Last-Event-ID": "1"})
        reply = connection.getresponse()
        first = []
        while len(first) < 3:
            line = reply.readline().decode()
            if line.startswith("id: "):
                first.append(int(line[4:]))
        connection.close()
        rest = [event[0] for event in self.events(job, after=first[1]) if event[0]]
        self.assertEqual(rest[0], first[2])

    def test_heartbeats(self):
        job = self.submit("sleep 600 beats")
        self.events(job, enough=lambda found: [event[1] for event in found].count(None) == 2)
        self.dismiss(job)

    def test_streams_are_limited(self):
        job = self.submit("sleep 60")
        open_streams = []
        for _ in range(3):
            connection = self.daemon.connect()
            connection.request("GET", f"/jobs/{job}/events")
            open_streams.append((connection, connection.getresponse()))
        reply = self.get(f"/jobs/{job}/events")
        self.assert_problem(reply, 503, "streams")
        self.assertTrue(reply.headers["Retry-After"])
        for connection, response in open_streams:
            response.close()
            connection.close()
        daemon.wait_until(lambda: self.request("HEAD", f"/jobs/{job}/events").status == 200,
                          "room for a stream")
        self.dismiss(job)

    def test_events_of_a_job_that_is_over(self):
        job = self.submit("over")
        self.finish(job)
        found = self.events(job)
        self.assertEqual([(event[1], event[2]["status"]) for event in found],
                         [("status", "successful")])
        self.assert_problem(self.get(f"/jobs/{job}/events", Accept="text/html"), 406)


class Listing(Jobs):
    options = ["--workers", "2"]

    def list(self, query=""):
        reply = self.get(f"/jobs{query}")
        self.assertEqual(reply.status, 200, reply.body)
        return reply.json

    def ids(self, query=""):
        return [info["jobID"] for info in self.list(query)["jobs"]]

    def seconds(self, info):
        began, ended = (datetime.datetime.fromisoformat(info[name].replace("Z", "+00:00"))
                        for name in ("started", "finished"))
        return (ended - began).total_seconds()

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        self = cls()
        cls.good = [self.submit(f"good {k}") for k in range(4)]
        cls.failed = self.submit("problem")
        cls.echo = self.submit("x", "/processes/echo/execution")
        cls.slow = self.submit("sleep 2.2")  # and others, if the machine stood still
        for job in [*cls.good, cls.failed, cls.echo, cls.slow]:
            self.finish(job)
        cls.spent = {job: self.seconds(self.status(job)) for job in [*cls.good, cls.failed, cls.echo,
                                                                     cls.slow]}
        cls.all = [cls.slow, cls.echo, cls.failed, *reversed(cls.good)]

    def test_newest_first(self):
        self.assertEqual(self.ids(), self.all)

    def test_pages(self):
        found, path, pages = [], "/jobs?limit=3&status=successful,failed", 0
        while path:
            page = self.get(path).json
            found += [info["jobID"] for info in page["jobs"]]
            links = {link["rel"]: link for link in page["links"]}
            self.assertTrue(all(link["type"] == "application/json" for link in links.values()))
            self.assertEqual("prev" in links, pages > 0)
            path = links["next"]["href"].split(self.daemon.address)[1] if "next" in links else None
            pages += 1
        self.assertEqual((found, pages), (self.all, 3))
        last = self.list("?limit=3&offset=6")
        previous = {link["rel"]: link["href"] for link in last["links"]}["prev"]
        self.assertIn("offset=3", previous)
        self.assertNotIn("next", {link["rel"] for link in self.list("?limit=7")["links"]})
        self.assertEqual(self.ids("?offset=100"), [])

    def test_filters(self):
        self.assertEqual(self.ids("?status=failed"), [self.failed])
        self.assertEqual(self.ids("?status=failed,running"), [self.failed])
        self.assertEqual(self.ids("?processID=echo"), [self.echo])
        self.assertEqual(self.ids("?processID=echo,solve"), self.all)
        self.assertEqual(self.ids("?processID=unknown"), [])
        self.assertEqual(self.ids("?type=process"), self.all)
        self.assertGreater(self.spent[self.slow], 2)
        self.assertEqual(self.ids("?minDuration=2"), [job for job in self.all if self.spent[job] >= 2])
        self.assertEqual(self.ids("?maxDuration=1"), [job for job in self.all if self.spent[job] <= 1])
        self.assertEqual(self.ids("?minDuration=1000&maxDuration=2000&status=failed"), [])

    def test_filters_given_once_for_each(self):
        """As OpenAPI writes arrays in a query by default; the links have them in one."""
        self.assertEqual(self.ids("?status=failed&status=running"), [self.failed])
        self.assertEqual(self.ids("?processID=echo&type=process&processID=solve"), self.all)
        links = self.get("/jobs?limit=1&status=failed&status=successful").json["links"]
        self.assertTrue(all(link["href"].endswith("&status=failed,successful") for link in links))

    def test_datetime(self):
        created = self.status(self.failed)["created"]
        self.assertIn(self.failed, self.ids(f"?datetime={created}"))
        self.assertIn(self.failed, self.ids(f"?datetime={created}/.."))
        self.assertNotIn(self.good[0], self.ids(f"?datetime={created}/.."))
        self.assertIn(self.good[0], self.ids(f"?datetime=../{created}"))
        self.assertNotIn(self.slow, self.ids(f"?datetime=../{created}"))
        self.assertEqual(self.ids("?datetime=2001-01-01T00:00:00Z/2001-01-02T00:00:00%2B01:00"), [])
        self.assertEqual(self.ids(f"?datetime={self.status(self.good[0])['created'][:10]}/"), self.all)

    def test_malformed(self):
        for query in ("limit=0", "limit=10001", "limit=x", "limit=", "limit=1.5", "offset=-1",
                      "offset=x", "type=job", "type=", "status=done", "status=", "status=failed,",
                      "processID=", "datetime=yesterday", "datetime=2026-13-01T00:00:00Z",
                      "datetime=2026-01-01T00:00:00Z/2025-01-01T00:00:00Z", "datetime=", "datetime=..",
                      "datetime=2026-01-01T00:00:00Z/x", "minDuration=x", "minDuration=-1",
                      "maxDuration=1.5", "maxDuration=", "parent=none",
                      "datetime=2026-02-30T00:00:00Z", "limit=1&limit=2", "minDuration=1&minDuration=2",
                      "status=failed&status=done", "processID=echo&processID=" + 600 * "x"):
            with self.subTest(query):
                self.assert_problem(self.get(f"/jobs?{query}"), 400, query.split("=")[0])

    def test_not_acceptable(self):
        self.assert_problem(self.get("/jobs", Accept="text/csv"), 406)


class Queueing(Jobs):
    options = ["--workers", "2", "--job-queue", "4", "--memory-budget", "1GiB"]

    def setUp(self):
        self.blocker = self.submit("sleep 60")
        self.wait_for(self.blocker, "running")

    def tearDown(self):
        for info in self.get("/jobs?limit=1000&status=accepted,running").json["jobs"]:
            self.dismiss(info["jobID"])

    def test_full(self):
        for k in range(4):
            self.submit(f"waits {k}")
        reply = self.execute("one more", Prefer="respond-async")
        self.assert_problem(reply, 429, "job-queue")
        self.assertGreaterEqual(int(reply.headers["Retry-After"]), 1)
        self.assertEqual(self.execute("synchronous").status, 200)  # a worker is kept
        self.dismiss(self.blocker)
        daemon.wait_until(lambda: self.execute("x", Prefer="respond-async").status == 201, "room")

    def test_priority(self):
        low = self.submit("sleep 0.05 low", prefer="respond-async, priority=1")
        usual = self.submit("sleep 0.05 usual")
        high = self.submit("sleep 0.05 high", prefer="respond-async, priority=9")
        self.dismiss(self.blocker)
        started = {job: self.finish(job)["started"] for job in (low, usual, high)}
        self.assertLess(started[high], started[usual])
        self.assertLess(started[usual], started[low])

    def test_too_large(self):
        reply = self.execute("needs 2e9", Prefer="respond-async")
        self.assert_problem(reply, 422, "2000000000", "memory-budget")
        self.assertEqual(self.execute("needs 1e9", Prefer="respond-async").status, 201)


class InOneTurn(Jobs):
    """The front looks for jobs in the same turn of its loop in which one is accepted."""
    options = ["--workers", "2"]

    @staticmethod
    def facts(process):
        """State of a process, and how often it has waited for something."""
        text = pathlib.Path(f"/proc/{process}/status").read_text(encoding="ascii")
        return (re.search(r"State:\s+(\w)", text)[1],
                int(re.search(r"\nvoluntary_ctxt_switches:\s+(\d+)", text)[1]))

    def let_finish(self, workers):
        """They run until they wait for the front again, which is stopped."""
        before = [self.facts(worker)[1] for worker in workers]
        self.daemon.signal_workers(signal.SIGCONT)
        daemon.wait_until(lambda: all(self.facts(worker)[0] == "S" and self.facts(worker)[1] > waited
                                      for worker, waited in zip(workers, before)), "their replies")

    def submit_and_look(self, body):
        """The job; what is known of it was looked for as soon as it was."""
        front, workers = self.daemon.pid, daemon.children(self.daemon.pid)
        with contextlib.closing(self.daemon.connect()) as submits, \
                contextlib.closing(self.daemon.connect()) as looks:
            looks.request("GET", "/healthz")
            looks.getresponse().read()
            self.daemon.signal_workers(signal.SIGSTOP)
            try:
                submits.request("POST", daemon.EXECUTE, body, {"Content-Type": "application/json",
                                                               "Prefer": "respond-async"})
                self.daemon.wait_busy()  # a worker has the check of it
                os.kill(front, signal.SIGSTOP)
                self.let_finish(workers)
                looks.request("GET", "/jobs")
            finally:
                self.daemon.signal_workers(signal.SIGCONT)
                os.kill(front, signal.SIGCONT)
            looks.getresponse().read()
            return json.loads(submits.getresponse().read())["jobID"]

    def test_it_starts(self):
        for k in range(10):  # which comes first in a turn is the kernel's choice
            self.wait_for(self.submit_and_look(f"x {k}"), "successful")


class Memory(Jobs):
    options = ["--workers", "3", "--memory-budget", "1GiB"]

    def spans(self, bodies):
        """(start, end) of the runs of jobs, in order of start."""
        infos = [self.finish(job) for job in [self.submit(body) for body in bodies]]
        self.assertEqual({info["status"] for info in infos}, {"successful"})
        return sorted((info["started"], info["finished"]) for info in infos)

    def test_large_ones_run_one_after_the_other(self):
        spans = self.spans(f"needs 6e8 0.2 #{k}" for k in range(4))
        for before, after in zip(spans, spans[1:]):
            self.assertLessEqual(before[1], after[0])

    def test_small_ones_run_together(self):
        jobs = [self.submit(f"needs 4e8 600 #{k}") for k in range(2)]
        for job in jobs:
            self.wait_for(job, "running")
        with self.daemon.waking():
            spans = sorted((info["started"], info["finished"]) for info in map(self.finish, jobs))
        self.assertLess(spans[1][0], spans[0][1])


class Retries(Jobs):
    options = ["--workers", "2"]

    def test_idempotency_key(self):
        first = self.execute("keyed", Prefer="respond-async", Idempotency_Key="a-1")
        again = self.execute("keyed", Prefer="respond-async", Idempotency_Key="a-1")
        self.assertEqual((first.status, again.status), (201, 201))
        self.assertEqual(first.headers["Location"], again.headers["Location"])
        other = self.execute("another", Prefer="respond-async", Idempotency_Key="a-1")
        self.assert_problem(other, 422, "Idempotency-Key")
        self.assertNotEqual(self.submit("keyed", Idempotency_Key="a-2"), first.json["jobID"])
        for key in ("", 300 * "x"):
            self.assert_problem(self.execute("x", Prefer="respond-async", Idempotency_Key=key), 400,
                                "Idempotency-Key")

    def test_idempotency_key_at_the_same_time(self):
        found = []
        threads = [threading.Thread(target=lambda: found.append(
            self.submit("together", Idempotency_Key="b"))) for _ in range(12)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual((len(found), len(set(found))), (12, 1))

    def test_equal_requests(self):
        for body in ("equal", "equal" + 20000 * " "):
            with self.subTest(len(body)):
                self.check_equal_requests(body)

    def check_equal_requests(self, body):
        first = self.submit(body)
        self.finish(first)
        second = self.submit(body)
        info = self.finish(second)
        self.assertNotEqual(first, second)
        self.assertIn(first, info["message"])
        self.assertEqual(info["attempts"], 0)
        self.dismiss(first)
        self.assertEqual(self.results(second).body, body.encode())
        third = self.submit(body, Cache_Control="no-cache")
        self.assertEqual(self.finish(third)["attempts"], 1)
        other = self.submit(body, "/processes/apply/execution")
        self.assertEqual(self.finish(other)["attempts"], 1)

    def test_echo_is_not_answered_from_the_store(self):
        for _ in range(2):
            job = self.submit("again", "/processes/echo/execution")
            self.assertEqual(self.finish(job)["attempts"], 1)


class Restart(unittest.TestCase):
    """A daemon that ends, and one that takes up what it left."""

    OPTIONS = ["--workers", "2", "--job-attempts", "2"]

    def start(self, directory=None, *options):
        started = daemon.Daemon(*self.OPTIONS, *options, directory=directory)
        started.wait_ready()
        self.addCleanup(lambda: started.process.poll() is None and started.stop())
        return started

    def submit(self, server, body):
        reply = server.request("POST", daemon.EXECUTE, body, {"Prefer": "respond-async"})
        self.assertEqual(reply.status, 201, reply.body)
        return reply.json["jobID"]

    def status(self, server, job, **headers):
        return server.request("GET", f"/jobs/{job}", headers=headers).json

    def test_stop_and_kill(self):
        for how in (daemon.signal.SIGTERM, daemon.signal.SIGKILL):
            with self.subTest(how):
                first = self.start()
                done = self.submit(first, "done" + 20000 * " ")
                self.status(first, done, Prefer="wait=60")
                running = self.submit(first, "sleep 600")
                daemon.wait_until(lambda: self.status(first, running)["status"] == "running", "run")
                waiting = self.submit(first, "waiting")
                first.stop(how, keep=True)
                second = self.start(first.directory)
                with second.waking():
                    for job in (done, running, waiting):
                        info = self.status(second, job, Prefer="wait=60")
                        self.assertEqual(info["status"], "successful", info)
                self.assertEqual(self.status(second, running)["attempts"],
                                 2 if how == daemon.signal.SIGKILL else 1)
                self.assertEqual(second.request("GET", f"/jobs/{done}/results").body.strip(),
                                 b"done")
                self.assertEqual(second.files(), [f"{done}.result"])
                self.assertEqual(second.stop(), 0)

    def test_attempts_are_limited(self):
        server = self.start()
        job = self.submit(server, "sleep 60")
        for attempt in (1, 2):
            daemon.wait_until(lambda: [self.status(server, job)[key] for key in
                                       ("status", "attempts")] == ["running", attempt], "run")
            time.sleep(0.1)
            server.stop(daemon.signal.SIGKILL, keep=True)
            server = self.start(server.directory)
        info = self.status(server, job, Prefer="wait=60")
        self.assertEqual((info["status"], info["attempts"]), ("failed", 2))
        reply = server.request("GET", f"/jobs/{job}/results")
        self.assertEqual(reply.status, 500)
        self.assertIn("2 attempts", reply.json["detail"])

    def test_one_daemon_at_a_time(self):
        first = self.start()
        with self.assertRaisesRegex(AssertionError, "another daemon"):
            daemon.Daemon(directory=first.directory)
        self.assertEqual(first.request("GET", "/healthz").status, 200)

    @unittest.skipIf(daemon.shares_store(), "no files are left in a database")
    def test_leftovers_go(self):
        first = self.start()
        first.stop(keep=True)
        folder = pathlib.Path(first.data, "jobs")
        for name in ("x.request", 32 * "0" + ".result", 32 * "0" + ".request.draft"):
            (folder / name).write_text("left by a crash")
        second = self.start(first.directory)
        self.assertEqual(list(folder.iterdir()), [])
        second.stop()

    def test_private(self):
        server = self.start()
        self.submit(server, "private")
        for path in pathlib.Path(server.data).rglob("*"):
            self.assertEqual(path.stat().st_mode & 0o077, 0, path)
        self.assertEqual(pathlib.Path(server.data).stat().st_mode & 0o777, 0o700)

    def test_streams_and_waits_end_with_the_daemon(self):
        server = self.start()
        job = self.submit(server, "sleep 60")
        connections = []
        for path in (f"/jobs/{job}/events", f"/jobs/{job}"):
            connection = server.connect()
            connection.request("GET", path, headers={"Prefer": "wait=50"})
            connections.append(connection)
        server.wait_taken_in()
        server.process.send_signal(daemon.signal.SIGTERM)
        for connection in connections:
            reply = connection.getresponse()
            self.assertEqual(reply.status, 200)
            self.assertIn(job.encode(), reply.read())
        self.assertEqual(server.process.wait(daemon.PATIENCE), 0)


class Batches(Jobs):
    options = ["--workers", "3"]

    def test_children(self):
        job = self.submit("batch 5 sleep 0.1")
        info = self.finish(job)
        self.assertEqual((info["status"], info["parts"], info["progress"]), ("successful", 5, 100))
        parts = self.get(f"/jobs?parent={job}").json["jobs"]
        self.assertEqual([part["status"] for part in parts], 5 * ["successful"])
        bodies = {self.results(part["jobID"]).body.decode() for part in parts}
        self.assertEqual(bodies, {f"sleep 0.1 #{k}" for k in range(5)})
        self.assertNotIn(parts[0]["jobID"], [one["jobID"] for one in self.get("/jobs").json["jobs"]])

    def test_progress_is_the_sum(self):
        job = self.submit("batch 4 phase half 0.5 60")
        daemon.wait_until(lambda: self.status(job)["progress"] == 25, "two of four at a half")
        parts = self.get(f"/jobs?parent={job}&status=running").json["jobs"]
        self.assertEqual([part["progress"] for part in parts], [50, 50])
        self.dismiss(parts[0]["jobID"])
        daemon.wait_until(lambda: self.status(job)["progress"] == 50, "one ended, two at a half")
        self.assertEqual(self.dismiss(job).json["status"], "dismissed")
        parts = self.get(f"/jobs?parent={job}").json["jobs"]
        self.assertEqual({part["status"] for part in parts}, {"dismissed"})

    def test_results_as_a_document(self):
        job = self.submit('batch 3 "')  # bodies that are JSON: " #0 and so on are not, "" is
        self.finish(job)
        document = self.results(job)
        self.assertEqual((document.status, document.type), (200, "application/json"))
        text = document.body.decode()
        self.assertTrue(text.startswith('{"results":[{"index":0,"jobID":"'), text)
        self.assertTrue(text.endswith('" #2}]}'), text)
        self.assertEqual(self.get(f"/jobs/{job}/results/1").body, b'" #1')
        for item in ("3", "-1", "x", "1x"):
            self.assert_problem(self.get(f"/jobs/{job}/results/{item}"), 404, "batch")

    def test_results_by_line(self):
        job = self.submit("batch 6 sleep 600")
        self.assertEqual(self.assert_problem(self.results(job), 404)["type"],
                         EXCEPTION + "result-not-ready")
        connection = self.daemon.connect()
        connection.request("GET", f"/jobs/{job}/results",
                           headers={"Accept": "application/x-ndjson"})
        reply = connection.getresponse()
        self.assertEqual(reply.headers["Content-Type"], "application/x-ndjson")
        parts = f"/jobs?parent={job}&status=successful"
        daemon.wait_until(lambda: self.daemon.wake() or self.get(parts).json["jobs"], "the first")
        first = reply.readline().decode()
        self.assertEqual(self.status(job)["status"], "running")  # it came before the end
        with self.daemon.waking():
            lines = [first, *(line.decode() for line in reply)]
        self.assertEqual(sorted(line.split(",")[0] for line in lines),
                         [f'{{"index":{k}' for k in range(6)])
        for line in lines:
            self.assertRegex(line, r'"status":"successful","results":sleep 600 #\d}\n$')
        connection.close()

    def test_results_that_failed(self):
        job = self.submit("batch 1 sleep 60")
        daemon.wait_until(lambda: self.get(f"/jobs?parent={job}&status=running").json["jobs"], "it")
        other = self.submit("batch 2 problem")
        self.finish(other)
        reply = self.get(f"/jobs/{other}/results", Accept="application/x-ndjson")
        self.assert_problem(reply, 422, "none of the 2")
        part = self.get(f"/jobs?parent={other}").json["jobs"][0]["jobID"]
        self.assert_problem(self.results(part), 422, "singular")
        self.dismiss(job)

    def test_many(self):
        job = self.submit("batch 300 x")
        lines = self.get(f"/jobs/{job}/results", Accept="application/x-ndjson").body.splitlines()
        self.assertEqual(len({line.split(b",")[0] for line in lines}), 300)
        self.assertEqual(self.results(job).body.count(b'"successful"'), 300)

    def test_of_one(self):
        """Begins and ends with its part, often within one turn of the front's loop."""
        jobs = [self.submit(f"batch 1 one {k}") for k in range(50)]
        self.assertEqual([self.wait_for(job, "successful")["progress"] for job in jobs], 50 * [100])

    def test_all_fail(self):
        job = self.submit("batch 2 problem")
        self.assertEqual(self.finish(job)["status"], "failed")
        self.assert_problem(self.results(job), 422, "none of the 2")


if __name__ == "__main__":
    unittest.main()
