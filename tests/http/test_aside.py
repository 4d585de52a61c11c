#!/usr/bin/env python3
"""http.aside: what is large is kept by a second thread (clerk.h). An fsync of a large file stands
still for as long as a test likes (fault_shim.c); meanwhile everybody else is served, and what became
of the large one is right whatever happens to it, to its client, to equal ones and to the daemon."""

import concurrent.futures
import errno
import http.client
import json
import os
import re
import shutil
import signal
import sys
import time
import unittest

sys.dont_write_bytecode = True
import daemon  # noqa: E402
import faults as ordered  # noqa: E402

MEGABYTE = 1000000
HELD = 2 * MEGABYTE  # files from here on wait; those of SQLite stay below it
JSON = {"Content-Type": "application/json"}
LATER = JSON | {"Prefer": "respond-async"}


def large(word, size=3 * MEGABYTE):
    return f'["{word}"' + (size - len(word) - 4) * " " + "]"


class Case(unittest.TestCase):
    options = []
    stub = True

    def setUp(self):
        self.faults = ordered.Faults(self.stub)
        self.addCleanup(self.faults.close)
        self.addCleanup(shutil.rmtree, self.faults.directory, True)
        self.pool = concurrent.futures.ThreadPoolExecutor(8)
        self.addCleanup(self.pool.shutdown)
        self.start()

    def start(self):
        self.server = server = daemon.Daemon(
            "--workers", "2", "--reuse-results", "0", *self.options, stub=self.stub,
            directory=self.faults.directory, environment=self.faults.environment)
        self.addCleanup(lambda: server.process.poll() is None and server.stop())
        self.addCleanup(self.faults.clear)  # comes first, so that it can stop
        server.wait_ready()
        self.faults.hold(HELD)

    def get(self, path, **headers):
        return self.server.request("GET", path, headers=headers)

    def upload(self, body, kind="application/json"):
        return self.server.request("POST", "/data", body, {"Content-Type": kind})

    def submit(self, body, **headers):
        return self.server.request("POST", daemon.EXECUTE, body, LATER | headers)

    def later(self, call, *arguments, **named):
        """Begins it in a thread."""
        return self.pool.submit(call, *arguments, **named)

    def wait_held(self, count):
        daemon.wait_until(lambda: self.faults.held() >= count, f"{count} fsyncs that wait")

    def wait_checked(self, count, process="data"):
        """So many bodies have passed a worker's check: whatever comes next has begun."""
        def count_of():
            text = self.get("/metrics").body.decode()
            found = re.search(r'scatterd_runs_total\{process="%s",work="check",end="reply"\} (\d+)'
                              % process, text)
            return found is not None and int(found[1]) >= count
        daemon.wait_until(count_of, f"{count} checked bodies")

    def send(self, path, body, headers=""):
        """Sends a request; returns the socket."""
        plain = self.server.raw()
        self.addCleanup(plain.close)
        plain.sendall((f"POST {path} HTTP/1.1\r\nHost: a\r\nContent-Type: application/json\r\n"
                       f"{headers}Content-Length: {len(body)}\r\n\r\n{body}").encode())
        return plain

    def close(self, plain):
        """Its client vanishes, and the daemon knows."""
        plain.close()
        self.server.wait_for_log(r"event=request .*end=aborted")

    def leave(self, path, body, headers=""):
        """Sends a request and vanishes when its bytes are being kept."""
        plain = self.send(path, body, headers)
        self.wait_held(1)
        self.close(plain)

    def data(self):
        """Files under /data, finished or not."""
        return sorted(os.listdir(os.path.join(self.server.data, "data")))

    def assert_serves(self):
        """Everybody else is answered while something is held."""
        held = self.faults.held()
        self.assertEqual(self.get("/healthz").status, 200)
        self.assertEqual(self.server.request("POST", daemon.EXECUTE, "small", JSON).body, b"small")
        self.assertIn(self.upload("[1, 2]").status, (200, 201))
        job = self.submit("small job").json["jobID"]
        self.assertEqual(self.get(f"/jobs/{job}", Prefer="wait=60").json["status"], "successful")
        self.assertEqual(self.faults.held(), held)

    def assert_done(self, job, body):
        self.assertEqual(self.get(f"/jobs/{job}", Prefer="wait=60").json["status"], "successful")
        self.assertEqual(self.get(f"/jobs/{job}/results").body.decode(), body)

    def stop(self):
        """It ends well, and nothing is left half done."""
        self.faults.clear()
        self.assertEqual(self.server.stop(keep=True), 0)
        log = "\n".join(self.server.log)
        self.assertNotIn("Sanitizer", log)
        for folder in ("data", "jobs"):
            names = os.listdir(os.path.join(self.server.data, folder))
            self.assertEqual([name for name in names if name.endswith(".draft")], [])


class Others(Case):
    """Nobody waits for somebody else's bytes."""

    def test_while_an_upload_is_kept(self):
        body = large("upload")
        reply = self.later(self.upload, body)
        self.wait_held(1)
        self.assert_serves()
        self.assertFalse(reply.done())
        self.faults.let_go(1)
        reply = reply.result(daemon.PATIENCE)
        self.assertEqual(reply.status, 201, reply.body)
        self.assertEqual(self.get("/data/" + reply.json["id"]).body.decode(), body)
        self.stop()

    def test_while_a_request_is_kept(self):
        body = large("request")
        reply = self.later(self.submit, body)
        self.wait_held(1)
        self.assert_serves()
        self.assertFalse(reply.done())
        self.assertEqual(len(self.get("/jobs").json["jobs"]), 1, "it is not accepted yet")
        self.faults.clear()
        reply = reply.result(daemon.PATIENCE)
        self.assertEqual(reply.status, 201, reply.body)
        self.assert_done(reply.json["jobID"], body)
        self.stop()

    def test_while_a_result_is_kept(self):
        body = large("result")
        reply = self.later(self.submit, body)
        self.wait_held(1)
        self.faults.let_go(1)
        job = reply.result(daemon.PATIENCE).json["jobID"]
        self.wait_held(2)
        self.assert_serves()
        self.assertEqual(self.get(f"/jobs/{job}").json["status"], "running")
        self.faults.let_go(2)
        self.assert_done(job, body)
        self.stop()


class Clients(Case):
    """Clients that vanish, and those who send the same."""

    def test_vanished_upload_leaves_nothing(self):
        self.leave("/data", large("gone"))
        self.faults.clear()
        daemon.wait_until(lambda: self.data() == [], "an empty folder")
        self.assertEqual(self.upload(large("gone")).status, 201)
        self.stop()

    def test_vanished_behind_another(self):
        """The one whose digest has not even begun."""
        first = self.later(self.upload, large("first"))
        self.wait_held(1)
        plain = self.send("/data", large("second"))
        self.wait_checked(2)
        self.close(plain)
        self.faults.clear()
        self.assertEqual(first.result(daemon.PATIENCE).status, 201)
        self.assertEqual(self.upload(large("third")).status, 201)  # behind whatever is left
        self.assertEqual(len(self.data()), 2)
        self.stop()

    def test_vanished_request_is_a_job_all_the_same(self):
        body = large("alone")
        self.leave(daemon.EXECUTE, body, "Prefer: respond-async\r\n")
        self.faults.clear()
        jobs = daemon.wait_until(lambda: self.get("/jobs").json["jobs"], "a job")
        self.assert_done(jobs[0]["jobID"], body)
        self.stop()

    def test_equal_uploads_are_one_object(self):
        body = large("twin")
        replies = [self.later(self.upload, body) for _ in range(3)]
        self.wait_held(1)
        self.faults.clear()
        replies = [reply.result(daemon.PATIENCE) for reply in replies]
        self.assertEqual(sorted(reply.status for reply in replies), [200, 200, 201])
        self.assertEqual(self.data(), [replies[0].json["id"]])
        self.assertEqual({reply.json["id"] for reply in replies}, {replies[0].json["id"]})
        self.assertEqual(self.get("/data/" + replies[0].json["id"]).body.decode(), body)
        self.stop()

    def hold_twins(self):
        """Two equal uploads, the first in its fsync and the second waiting for that."""
        blocker = self.later(self.upload, large("blocker"))
        self.wait_held(1)
        body = large("twin")
        plain = self.send("/data", body)
        self.wait_checked(2)
        second = self.later(self.upload, body)
        self.wait_checked(3)
        self.faults.let_go(1)
        self.assertEqual(blocker.result(daemon.PATIENCE).status, 201)
        self.wait_held(2)
        return plain, second

    def test_the_second_takes_over_when_the_first_vanishes(self):
        first, second = self.hold_twins()
        self.close(first)
        self.faults.clear()
        self.assertEqual(second.result(daemon.PATIENCE).status, 201)
        self.assertEqual(len(self.data()), 2)
        self.stop()

    def test_the_second_takes_over_when_the_first_fails(self):
        first, second = self.hold_twins()
        self.faults.fail("sync", errno.ENOSPC, times=1)
        self.faults.let_go(3)
        reply = daemon.Reply(response(first))
        self.assertEqual(reply.status, 507, reply.body)
        self.assertEqual(second.result(daemon.PATIENCE).status, 201)
        self.assertEqual(len(self.data()), 2)
        self.stop()


def response(plain):
    """The reply on a plain socket."""
    reply = http.client.HTTPResponse(plain)
    reply.begin()
    return reply


class Full(Case):
    """The thread's errors are told as the loop's are."""

    def test_no_room_on_the_disk(self):
        for kind in ("write", "sync", "rename"):
            with self.subTest(kind=kind):
                self.faults.clear()
                self.faults.fail(kind, errno.ENOSPC, times=1)
                self.assertEqual(self.upload(large(kind)).status, 507)
                self.assertEqual(self.faults.hits(kind), 1)
                self.faults.fail(kind, errno.ENOSPC, times=1)
                self.assertEqual(self.submit(large(kind)).status, 507)
        self.assertEqual((self.data(), self.server.files()), ([], []))
        self.stop()

    def test_no_room_for_a_result(self):
        for kind in ("sync", "rename"):
            with self.subTest(kind=kind):
                self.faults.hold(HELD)
                reply = self.later(self.submit, large(kind))
                self.wait_held(1)
                self.faults.let_go(1)
                job = reply.result(daemon.PATIENCE).json["jobID"]
                self.wait_held(2)
                self.faults.fail(kind, errno.ENOSPC, times=1)
                self.faults.let_go(2)
                info = self.get(f"/jobs/{job}", Prefer="wait=60").json
                self.assertEqual(info["status"], "failed", info)
                self.assertEqual(self.get(f"/jobs/{job}/results").status, 507)
        self.assertEqual(self.server.files(), [])
        self.stop()


class Quotas(Case):
    options = ["--data-bytes", "7000000", "--job-bytes", "7000000"]

    def assert_one_too_many(self, replies):
        """The first is kept; of the others, whose turn is next, one is refused while one is held."""
        self.faults.let_go(1)
        self.assertEqual(replies[0].result(daemon.PATIENCE).status, 201)
        self.wait_held(2)
        daemon.wait_until(lambda: any(reply.done() for reply in replies[1:]), "a refusal")
        self.assertEqual([reply.result().status for reply in replies[1:] if reply.done()], [507])
        self.faults.clear()
        self.assertEqual(sorted(reply.result(daemon.PATIENCE).status for reply in replies),
                         [201, 201, 507])

    def test_uploads_on_their_way_count(self):
        replies = [self.later(self.upload, large("first"))]
        self.wait_held(1)
        replies += [self.later(self.upload, large(word)) for word in ("second", "third")]
        self.wait_checked(3)
        self.assert_one_too_many(replies)
        self.assertEqual(len(self.data()), 2)
        self.stop()

    def test_requests_on_their_way_count(self):
        replies = [self.later(self.submit, "sleep 30 " + large("first"))]
        self.wait_held(1)
        replies += [self.later(self.submit, "sleep 30 " + large(word)) for word in ("next", "last")]
        time.sleep(1.1)  # bytes are counted anew after a second (allowance.h)
        self.assert_one_too_many(replies)
        self.stop()


class References(Case):
    """Outputs by reference, for which a worker waits."""

    stub = False
    apply = "/processes/apply/execution"
    request = json.dumps({
        "inputs": {"cloud": {"lattice": {"lower": [0], "upper": [1], "cells": [300000]}},
                   "field": "2*x"},
        "outputs": {"value": {"transmissionMode": "reference",
                              "format": {"mediaType": "application/x-npy"}}}})

    def test_kept(self):
        reply = self.later(self.server.request, "POST", self.apply, self.request, JSON)
        self.wait_held(1)
        self.assertEqual(self.get("/healthz").status, 200)
        echo = self.server.request("POST", "/processes/echo/execution",
                                   '{"inputs": {"message": "small"}}', JSON)
        self.assertEqual(echo.status, 200)
        self.assertFalse(reply.done())
        self.faults.clear()
        reply = reply.result(daemon.PATIENCE)
        self.assertEqual(reply.status, 200, reply.body)
        path = "/" + reply.json["value"]["href"].split("/", 3)[3]
        self.assertEqual(int(self.get(path).headers["Content-Length"]), 8 * 300001 + 128)
        self.stop()

    def test_left(self):
        self.leave(self.apply, self.request)
        self.faults.clear()
        daemon.wait_until(lambda: self.data() == [], "an empty folder")
        self.stop()


class Jobs(Case):
    def hold_result(self, word):
        reply = self.later(self.submit, large(word))
        self.wait_held(1)
        self.faults.let_go(1)
        job = reply.result(daemon.PATIENCE).json["jobID"]
        self.wait_held(2)
        return job

    def test_dismissed_while_its_result_is_kept(self):
        job = self.hold_result("unwanted")
        reply = self.server.request("DELETE", f"/jobs/{job}")
        self.assertEqual((reply.status, reply.json["status"]), (200, "dismissed"))
        self.assert_serves()
        self.faults.clear()
        daemon.wait_until(lambda: self.server.files() == [], "no files")
        self.assertEqual(self.get(f"/jobs/{job}").json["status"], "dismissed")
        self.stop()

    def test_key_is_one_job(self):
        """Two equal requests with one key, both on their way."""
        body = large("keyed")
        replies = [self.later(self.submit, body, **{"Idempotency-Key": "same"}) for _ in range(2)]
        self.wait_held(1)
        self.faults.clear()
        replies = [reply.result(daemon.PATIENCE) for reply in replies]
        self.assertEqual([reply.status for reply in replies], [201, 201],
                         [reply.body for reply in replies])
        self.assertEqual(replies[0].json["jobID"], replies[1].json["jobID"])
        self.assert_done(replies[0].json["jobID"], body)
        self.assertEqual(len(self.server.files()), 1)
        self.stop()


class Ends(Case):
    """The daemon ends while bytes are on their way."""

    def restart(self):
        self.faults.clear()
        self.start()
        self.faults.clear()

    def test_stops_when_all_is_kept(self):
        replies = [self.later(self.upload, large("last")), self.later(self.submit, large("job"))]
        self.wait_held(1)
        self.server.process.send_signal(signal.SIGTERM)
        self.server.wait_for_log("event=stopping")
        self.faults.clear()
        self.assertEqual([reply.result(daemon.PATIENCE).status for reply in replies], [201, 201])
        self.stop()
        self.restart()
        self.assertEqual(len(self.data()), 1)
        self.assert_done(replies[1].result().json["jobID"], large("job"))
        self.stop()

    def test_stops_at_once(self):
        """Told twice: nobody is waited for, but what is being written is."""
        reply = self.later(self.upload, large("heard"))
        self.wait_held(1)
        for _ in range(2):
            self.server.process.send_signal(signal.SIGTERM)
            self.server.wait_for_log("event=stopping")
            self.assertIsNone(self.server.process.poll())
        self.faults.clear()
        self.assertEqual(reply.result(daemon.PATIENCE).status, 201)
        self.stop()
        self.assertEqual(len(self.data()), 1)

    def test_killed(self):
        reply = [self.later(self.upload, large("lost")), self.later(self.submit, large("lost"))]
        self.wait_held(1)
        self.server.stop(signal.SIGKILL, keep=True)
        for one in reply:
            with self.assertRaises((http.client.HTTPException, OSError)):
                one.result(daemon.PATIENCE)
        self.restart()
        self.assertEqual((self.data(), self.server.files()), ([], []))
        self.assertEqual(self.get("/jobs").json["jobs"], [])
        self.stop()


if __name__ == "__main__":
    unittest.main()
