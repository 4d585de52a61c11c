#!/usr/bin/env python3
"""http.daemons: two daemons on one PostgreSQL database answer for the same jobs; one that is killed
loses none; a database that is away for a while costs nothing but time. SCATTERD_SEED=17 repeats a
run, SCATTERD_KILLS=20 is longer."""

import contextlib
import errno
import http.client
import http.server
import json
import os
import random
import re
import shutil
import signal
import sys
import threading
import time
import unittest

sys.dont_write_bytecode = True
import daemon  # noqa: E402
import faults as ordered  # noqa: E402
import postgres  # noqa: E402
import test_access as access  # noqa: E402

SEED = int(os.environ.get("SCATTERD_SEED", time.time_ns() % 1000000))
KILLS = int(os.environ.get("SCATTERD_KILLS", 4))
ASYNC = {"Prefer": "respond-async", "Content-Type": "application/json"}
FINAL = ("successful", "failed", "dismissed")
server = None


def setUpModule():
    global server
    server = postgres.Server("fsync=off")


class Case(unittest.TestCase):
    # one that stands still for as long as its lease loses what it has, as it should
    options = ["--workers", "2", "--lease-seconds", "60"]

    def setUp(self):
        self.name = self.id().rsplit(".", 1)[1]
        self.url = server.database(self.name)
        self.first, self.second = self.start(), self.start()
        for one in (self.first, self.second):
            one.wait_ready()

    def start(self, *options, directory=None):
        started = daemon.Daemon(*self.options, *options, store=self.url, directory=directory)
        self.addCleanup(lambda: started.process.poll() is None and started.stop(signal.SIGKILL))
        return started

    def stop(self, *daemons):
        for one in daemons:
            self.assertEqual(one.stop(), 0, one.log)
            log = "\n".join(one.log)
            self.assertNotIn("Sanitizer", log)
            self.assertNotIn("runtime error", log)

    def submit(self, at, body, path=daemon.EXECUTE, **headers):
        named = {name.replace("_", "-"): value for name, value in headers.items()}
        reply = at.request("POST", path, body, {**ASYNC, **named})
        self.assertEqual(reply.status, 201, reply.body)
        return reply.json["jobID"]

    def status(self, at, job, wait=None):
        headers = {"Prefer": f"wait={wait}"} if wait else {}
        reply = at.request("GET", f"/jobs/{job}", headers=headers)
        self.assertEqual(reply.status, 200, reply.body)
        return reply.json

    def finish(self, at, job):
        return daemon.wait_until(
            lambda: (lambda info: info if info["status"] in FINAL else None)(
                self.status(at, job, wait=20)), f"the end of job {job}")

    @contextlib.contextmanager
    def waking(self):
        with self.first.waking(), self.second.waking():
            yield

    def wait_both_at_work(self):
        """Until each of them runs a job."""
        daemon.wait_until(lambda: len(server.sql(
            "SELECT DISTINCT holder FROM jobs WHERE state = 1 AND parts = 0", self.name)) == 2,
            "both at work")

    def wait_for(self, at, job, state):
        return daemon.wait_until(
            lambda: (lambda info: info if info["status"] == state else None)(self.status(at, job)),
            f"job {job} to be {state}")

    def column(self, job, name):
        return server.sql(f"SELECT {name} FROM jobs WHERE id = '{job}'", self.name)[0]


class Shortage(Case):
    """One daemon; it lacks descriptors."""

    def setUp(self):
        self.faults = ordered.Faults()
        self.addCleanup(self.faults.close)
        self.addCleanup(shutil.rmtree, self.faults.directory, True)
        url = server.database("shortage")
        self.first = daemon.Daemon(*self.options, "--job-attempts", "1000", store=url,
                                   directory=self.faults.directory,
                                   environment=self.faults.environment)
        self.addCleanup(lambda: self.first.process.poll() is None and self.first.stop())
        self.first.wait_ready()

    def test_requests_that_cannot_be_opened(self):
        """Others wait in the database, and are not looked for meanwhile."""
        jobs = [self.submit(self.first, f"sleep 600 #{k}") for k in range(8)]
        self.wait_for(self.first, jobs[0], "running")
        self.faults.fail("memfd", errno.EMFILE)
        with self.first.waking():
            daemon.wait_until(lambda: self.faults.hits("memfd") > 0, "a failure")
        self.first.assert_calm(4)
        self.faults.clear()
        with self.first.waking():
            for job in jobs:
                self.assertEqual(self.finish(self.first, job)["status"], "successful")
        self.stop(self.first)


class Sharing(Case):
    """Each daemon answers for what the other one has."""

    def test_both_run_and_both_answer(self):
        jobs = [self.submit(self.first, f"sleep 600 #{k}") for k in range(12)]
        self.wait_both_at_work()
        with self.waking():
            for job in jobs:
                self.finish(self.second, job)
        for k, job in enumerate(jobs):
            for at in (self.first, self.second):
                info = self.status(at, job)
                self.assertEqual((info["status"], info["attempts"]), ("successful", 1))
                reply = at.request("GET", f"/jobs/{job}/results")
                self.assertEqual((reply.status, reply.body.decode()), (200, f"sleep 600 #{k}"))
        lists = [[job["jobID"] for job in at.request("GET", "/jobs?limit=100").json["jobs"]]
                 for at in (self.first, self.second)]
        self.assertEqual(lists[0], lists[1])
        self.assertEqual(sorted(lists[0]), sorted(jobs))
        self.stop(self.first, self.second)

    def test_large_requests_and_results(self):
        body = "sleep 0.1 " + 3000000 * "x"  # three pieces
        jobs = [self.submit(at, body) for at in (self.first, self.second) for _ in range(3)]
        for job in jobs:
            self.assertEqual(self.finish(self.first, job)["status"], "successful")
            self.assertEqual(self.second.request("GET", f"/jobs/{job}/results").body.decode(), body)
        self.assertEqual(server.sql("SELECT count(*) FROM large WHERE kind <> 2", self.name), ["0"])
        self.stop(self.first, self.second)

    def test_cancel_by_the_other(self):
        jobs = [self.submit(self.first, f"sleep 60 #{k}") for k in range(2)]
        for job in jobs:
            self.wait_for(self.first, job, "running")
        workers = {pid for at in (self.first, self.second) for pid in daemon.children(at.pid)}
        began = time.monotonic()
        for job in jobs:
            self.assertEqual(self.second.request("DELETE", f"/jobs/{job}").status, 200)
        for job in jobs:
            for at in (self.first, self.second):
                self.assertEqual(self.status(at, job)["status"], "dismissed")
        daemon.wait_until(lambda: len(workers & {pid for at in (self.first, self.second)
                                                 for pid in daemon.children(at.pid)}) <= 2,
                          "both workers to be killed")
        print(f"cancelled by the other within {time.monotonic() - began:.2f} s")
        self.assertEqual(self.first.request("DELETE", f"/jobs/{jobs[0]}").status, 410)
        self.stop(self.first, self.second)

    def test_events_and_waits_see_the_other(self):
        job = self.submit(self.first, "phase half 0.5 600")
        self.wait_for(self.first, job, "running")
        replies = {}

        def listen(at):
            reply = at.request("GET", f"/jobs/{job}/events", headers={"Accept": "text/event-stream"})
            replies[at] = reply.body.decode()

        threads = [threading.Thread(target=listen, args=(at,)) for at in (self.first, self.second)]
        for thread in threads:
            thread.start()
        for at in (self.first, self.second):
            info = daemon.wait_until(
                lambda at=at: (lambda i: i if i.get("phase") == "half" and i["progress"] == 50
                               else None)(self.status(at, job)), "its phase")
            self.assertEqual(info["status"], "running")
            at.wait_taken_in()
        with self.waking():
            for at in (self.second, self.first):
                self.assertEqual(self.finish(at, job)["status"], "successful")
        for thread in threads:
            thread.join()
        for text in replies.values():
            self.assertIn('"status":"successful"', text)
        self.assertEqual(sum('"phase":"half"' in text for text in replies.values()), 2, replies)
        waited = self.second.request("POST", daemon.EXECUTE, "sleep 0.3 and wait",
                                     {**ASYNC, "Prefer": "respond-async, wait=20"})
        self.assertEqual((waited.status, waited.body), (200, b"sleep 0.3 and wait"))
        self.stop(self.first, self.second)

    def test_a_key_has_one_job(self):
        results = []

        def post(at):
            reply = at.request("POST", daemon.EXECUTE, "sleep 0.5 once",
                               {**ASYNC, "Idempotency-Key": "the one"})
            results.append((reply.status, reply.json.get("jobID")))

        threads = [threading.Thread(target=post, args=(at,))
                   for at in 3 * [self.first, self.second]]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual({status for status, _ in results}, {201}, results)
        self.assertEqual(len({job for _, job in results}), 1, results)
        self.assertEqual(server.sql("SELECT count(*) FROM jobs", self.name), ["1"])
        self.stop(self.first, self.second)

    def test_batch(self):
        path = "/processes/batch/execution"
        job = self.submit(self.first, "batch 10 sleep 600", path)
        lines = {}

        def read(at):
            reply = at.request("GET", f"/jobs/{job}/results",
                               headers={"Accept": "application/x-ndjson"})
            lines[at] = [int(re.match(r'{"index":(\d+),"jobID":"\w+","status":"successful"', line)[1])
                         for line in reply.body.decode().splitlines()]

        threads = [threading.Thread(target=read, args=(at,)) for at in (self.first, self.second)]
        for thread in threads:
            thread.start()
        self.wait_both_at_work()
        with self.waking():
            self.finish(self.second, job)
            for thread in threads:
                thread.join()
        for at in (self.first, self.second):
            info = self.status(at, job)
            self.assertEqual((info["status"], info["progress"], info["parts"]),
                             ("successful", 100, 10))
            self.assertEqual(sorted(lines[at]), list(range(10)))
            parts = at.request("GET", f"/jobs?parent={job}&limit=20").json["jobs"]
            self.assertEqual({part["status"] for part in parts}, {"successful"})
            whole = at.request("GET", f"/jobs/{job}/results").body.decode()
            self.assertEqual(re.findall(r'"index":(\d+)', whole), [str(k) for k in range(10)])
        other = self.submit(self.first, "batch 6 sleep 60", path)
        self.wait_for(self.second, other, "running")
        self.assertEqual(self.second.request("DELETE", f"/jobs/{other}").status, 200)
        parts = self.first.request("GET", f"/jobs?parent={other}&limit=20").json["jobs"]
        self.assertEqual({part["status"] for part in parts}, {"dismissed"})
        after = self.submit(self.first, "after it")
        self.assertEqual(self.finish(self.first, after)["status"], "successful")
        self.stop(self.first, self.second)

    def test_data(self):
        header = {"Content-Type": "application/json"}
        made = self.first.request("POST", "/data", "[1, 2, 3]", header)
        self.assertEqual(made.status, 201, made.body)
        again = self.second.request("POST", "/data", "[1, 2, 3]", header)
        self.assertEqual((again.status, again.json["id"]), (200, made.json["id"]))
        path = "/data/" + made.json["id"]
        self.assertEqual(self.second.request("GET", path).body, b"[1, 2, 3]")
        self.assertEqual(self.second.request("DELETE", path).status, 204)
        self.assertEqual(self.first.request("GET", path).status, 404)
        self.assertEqual(server.sql("SELECT count(*) FROM large", self.name), ["0"])
        self.stop(self.first, self.second)

    def test_submitters_and_priorities(self):
        self.stop(self.second)
        blocker = self.submit(self.first, "sleep 600")
        self.wait_for(self.first, blocker, "running")
        low = [self.submit(self.first, f"low {k}", Prefer="respond-async, priority=2")
               for k in range(3)]
        high = self.submit(self.first, "high", Prefer="respond-async, priority=8")
        with self.first.waking():
            for job in (*low, high):
                self.finish(self.first, job)
        began = [float(self.column(job, "started")) for job in (high, *low)]
        self.assertEqual(began, sorted(began))
        self.stop(self.first)


class Limits(Case):
    """What a token may have it may have by way of all daemons together."""

    def setUp(self):
        self.file = access.TokenFile()
        self.addCleanup(self.file.directory.cleanup)
        for name in ("alice", "bob"):
            self.file.add(name, "jobs=5")
        self.file.add("free")
        self.options = [*self.options, "--tokens", self.file.path]
        super().setUp()

    def post(self, who, at, body, path=daemon.EXECUTE):
        return at.request("POST", path, body, {**ASYNC, **access.bearer(self.file.secret[who])})

    def post_all(self, orders):
        """Replies to requests that are sent all at once."""
        replies, start = [], threading.Barrier(len(orders))

        def post(order):
            start.wait()
            reply = self.post(*order)
            replies.append((order[0], reply.status, reply))

        threads = [threading.Thread(target=post, args=(order,)) for order in orders]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        return replies

    def drop_all(self, replies):
        for who, status, reply in replies:
            if status == 201:
                dropped = self.second.request("DELETE", "/jobs/" + reply.json["jobID"],
                                              headers=access.bearer(self.file.secret[who]))
                self.assertEqual(dropped.status, 200)

    def test_jobs_of_a_token(self):
        both = (self.first, self.second)
        for turn in range(4):
            orders = [(who, both[k % 2], f"sleep 60 {who} {turn} {k}")
                      for k in range(10) for who in ("alice", "bob", "free")]
            replies = self.post_all(orders)
            for who, most in (("alice", 5), ("bob", 5), ("free", 10)):
                told = sorted(status for name, status, _ in replies if name == who)
                # what is being checked counts, so that fewer may be let in at once, never more
                self.assertEqual(set(told) - {201, 429}, set())
                self.assertLessEqual(told.count(201), most)
                self.assertGreater(told.count(201), 0)
            for who, status, reply in replies:
                if status == 429:
                    self.assertIn("jobs of the token", reply.json["detail"])
                    self.assertGreaterEqual(int(reply.headers["Retry-After"]), 1)
            more = self.post_all([("alice", at, f"sleep 60 more {turn} {k}")
                                  for k, at in enumerate(10 * both)])
            had = sum(status == 201 for who, status, _ in [*replies, *more] if who == "alice")
            self.assertLessEqual(had, 5)
            self.assertEqual(int(server.sql("SELECT count(*) FROM jobs WHERE submitter = 'alice' "
                                            "AND state <= 1", self.name)[0]), had)
            self.drop_all([*replies, *more])
        self.stop(*both)

    def test_batches_of_a_token(self):
        for turn in range(4):
            path = "/processes/batch/execution"
            replies = self.post_all([("alice", at, f"batch 3 sleep 60 {turn} {k}", path)
                                     for k, at in enumerate(2 * (self.first, self.second))])
            self.assertLessEqual(sum(status == 201 for _, status, _ in replies), 1, replies)
            self.drop_all(replies)
        self.stop(self.first, self.second)

    def test_another_daemon_that_hangs_while_it_adds(self):
        hold = ("BEGIN; SELECT pg_advisory_xact_lock(hashtextextended('scatterd jobs of alice', 0));"
                "SELECT pg_sleep(600); COMMIT")

        def hang():
            with contextlib.suppress(AssertionError):  # it is cancelled in the end
                server.sql(hold, self.name)
        other = threading.Thread(target=hang)
        other.start()
        daemon.wait_until(lambda: server.sql("SELECT 1 FROM pg_locks WHERE locktype = 'advisory' "
                                             "AND granted", self.name), "the lock")
        refused = self.post("alice", self.first, "sleep 60 refused")
        self.assertEqual(refused.status, 503, refused.body)
        self.assertGreaterEqual(int(refused.headers["Retry-After"]), 1)
        self.assertEqual(self.post("bob", self.first, "sleep 60 goes on").status, 201)
        server.sql("SELECT pg_terminate_backend(pid) FROM pg_stat_activity "
                   "WHERE query LIKE '%pg_sleep%' AND pid <> pg_backend_pid()", self.name)
        other.join()
        self.assertEqual(self.post("alice", self.first, "sleep 60 later").status, 201)
        self.stop(self.first, self.second)


class Drafts(Case):
    """What is large is written by the second thread, over a connection of its own. Its INSERT waits
    for as long as a test likes; meanwhile everybody else is served."""
    options = ["--workers", "2", "--lease-seconds", "6", "--aside-bytes", "20000"]

    def setUp(self):
        super().setUp()
        server.sql("CREATE FUNCTION hold() RETURNS trigger LANGUAGE plpgsql AS "
                   "$$ BEGIN PERFORM pg_advisory_xact_lock_shared(7); RETURN NEW; END $$;"
                   "CREATE TRIGGER hold BEFORE INSERT ON large FOR EACH ROW WHEN (NEW.kind = -1) "
                   "EXECUTE FUNCTION hold()", self.name)

        self.holder, self.observer = server.session(self.name), server.session(self.name)
        self.addCleanup(self.holder.close)
        self.addCleanup(self.observer.close)

    def waits(self):
        """Processes of the server with a draft that waits."""
        return self.observer.sql(
            "SELECT pid FROM pg_locks WHERE locktype = 'advisory' AND objid = 7 AND NOT granted AND "
            "database = (SELECT oid FROM pg_database WHERE datname = current_database())")

    @contextlib.contextmanager
    def held(self):
        """Drafts wait while this lasts, which is to be short: statements take 4.5 s at most."""
        self.holder.sql("SELECT pg_advisory_lock(7)")
        try:
            yield
        finally:
            self.holder.sql("SELECT pg_advisory_unlock(7)")

    def later(self, *arguments):
        """Makes a request in a thread; the list that its reply comes into, and the thread."""
        replies = []
        thread = threading.Thread(target=lambda: replies.append(self.first.request(*arguments)))
        thread.start()
        daemon.wait_until(lambda: self.waits() or replies, "a draft that waits")
        self.assertEqual(replies, [])
        return replies, thread

    def assert_serves(self):
        self.assertEqual(self.first.request("GET", "/healthz").status, 200)
        small = self.first.request("POST", "/data", "[1, 2]", {"Content-Type": "application/json"})
        self.assertIn(small.status, (200, 201))
        job = self.submit(self.first, "small")
        self.assertEqual(self.status(self.first, job, wait=20)["status"], "successful")

    def drafts(self):
        return server.sql("SELECT DISTINCT owner FROM large WHERE kind = -1", self.name)

    def test_an_upload(self):
        body = "[" + 3000000 * " " + "1]"
        with self.held():
            replies, thread = self.later("POST", "/data", body,
                                         {"Content-Type": "application/json"})
            self.assert_serves()
        thread.join()
        self.assertEqual(replies[0].status, 201, replies[0].body)
        path = "/data/" + replies[0].json["id"]
        self.assertEqual(self.second.request("GET", path).body.decode(), body)
        self.assertEqual(self.drafts(), [])
        self.stop(self.first, self.second)

    def test_an_upload_whose_client_leaves(self):
        body = "[" + 3000000 * " " + "1]"
        plain = self.first.raw()
        with self.held():
            plain.sendall(b"POST /data HTTP/1.1\r\nHost: a\r\nContent-Type: application/json\r\n"
                          + f"Content-Length: {len(body)}\r\n\r\n{body}".encode())
            daemon.wait_until(self.waits, "a draft that waits")
            plain.close()
            self.first.wait_for_log(r"event=request .*end=aborted")
        self.stop(self.first, self.second)
        self.assertEqual(server.sql("SELECT id FROM data", self.name), [])
        self.assertEqual(server.sql("SELECT owner FROM large", self.name), [])

    def test_a_request_and_a_result(self):
        body = "sleep 0.1 " + 3000000 * "x"
        with self.held():
            replies, thread = self.later("POST", daemon.EXECUTE, body, ASYNC)
            self.assert_serves()
        thread.join()
        job = replies[0].json["jobID"]
        self.assertEqual(self.status(self.second, job, wait=20)["status"], "successful")
        big = self.submit(self.first, "big 3000000")
        with self.held():
            pass  # a moment at any stage of it
        self.assertEqual(self.status(self.first, big, wait=20)["status"], "successful")
        self.assertEqual(self.second.request("GET", f"/jobs/{job}/results").body.decode(), body)
        self.assertEqual(len(self.second.request("GET", f"/jobs/{big}/results").body), 3000000)
        self.assertEqual(self.drafts(), [])
        self.stop(self.first, self.second)

    def test_a_result_while_it_is_written(self):
        job = self.submit(self.first, "sleep 0.5")  # somebody has it; then the large one
        self.assertEqual(self.status(self.first, job, wait=20)["status"], "successful")
        with self.held():
            big = self.submit(self.first, "big 3000000")
            daemon.wait_until(self.waits, "a draft that waits")
            time.sleep(1.2)  # longer than a look at what is ours
            self.assertEqual(self.status(self.second, big)["status"], "running")
            self.assert_serves()
        info = self.status(self.second, big, wait=20)
        self.assertEqual((info["status"], info["attempts"]), ("successful", 1))
        self.stop(self.first, self.second)

    def test_a_result_whose_draft_cannot_be_written(self):
        """It is written with its row: no attempt is lost, and the last one is no failure."""
        self.stop(self.first, self.second)
        self.options = [*self.options, "--job-attempts", "1"]
        self.first = self.start()
        with self.held():
            big = self.submit(self.first, "big 3000000")
            for _ in range(2):  # it is tried twice
                pid = daemon.wait_until(self.waits, "a draft that waits")[0]
                self.observer.sql(f"SELECT pg_terminate_backend({pid})")
                daemon.wait_until(lambda pid=pid: pid not in self.waits(), "its end")
            info = self.finish(self.first, big)
            self.assertEqual((info["status"], info["attempts"]), ("successful", 1), info)
        self.assertEqual(len(self.first.request("GET", f"/jobs/{big}/results").body), 3000000)
        self.stop(self.first)
        self.assertEqual(self.drafts(), [])

    def test_a_batch_that_takes_a_while(self):
        body = "batch 80 " + 280 * "x"
        with self.held():
            replies, thread = self.later("POST", "/processes/batch/execution", body, ASYNC)
            time.sleep(1.2)  # longer than a look at what is ours: its parts are in no row yet
            self.assert_serves()
        thread.join()
        self.assertEqual(replies[0].status, 201, replies[0].body)
        job = replies[0].json["jobID"]
        self.assertEqual(self.status(self.second, job, wait=30)["status"], "successful")
        self.stop(self.first, self.second)

    def test_one_that_is_dismissed(self):
        with self.held():
            big = self.submit(self.first, "big 3000000")
            daemon.wait_until(self.waits, "a draft that waits")
            self.assertEqual(self.second.request("DELETE", f"/jobs/{big}").status, 200)
        self.stop(self.first, self.second)
        self.assertEqual(server.sql("SELECT owner FROM large", self.name), [])

    def test_one_that_takes_too_long_is_refused(self):
        with self.held():
            reply = self.first.request("POST", "/data", "[" + 3000000 * " " + "1]",
                                       {"Content-Type": "application/json"})
            self.assertEqual(reply.status, 503, reply.body)
            self.assert_serves()
        self.stop(self.first, self.second)
        self.assertEqual(self.drafts(), [])
        self.assertEqual(server.sql("SELECT max(size) FROM data", self.name), ["6"])

    def test_what_a_dead_daemon_left_goes(self):
        living = server.sql("SELECT id FROM daemons ORDER BY id LIMIT 1", self.name)[0]
        server.sql("INSERT INTO large VALUES('dead.1', -1, 0, 'x'), ('dead.1', -1, 1, 'y'), "
                   f"('{living}.999', -1, 0, 'z')", self.name)
        daemon.wait_until(lambda: self.drafts() == [f"{living}.999"], "the dead one's to go", 60)
        self.stop(self.first, self.second)


class Calls(Case):
    options = [*Case.options, "--callback-hosts", "127.0.0.1:*", "--callback-hosts"]

    def setUp(self):
        calls = self.calls = []

        class Handler(http.server.BaseHTTPRequestHandler):
            def do_POST(self):
                body = self.rfile.read(int(self.headers["Content-Length"]))
                calls.append((self.headers["webhook-id"], body))
                self.send_response(204)
                self.end_headers()

            def log_message(self, *_):
                pass

        self.subscriber = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler)
        threading.Thread(target=self.subscriber.serve_forever, daemon=True).start()
        self.addCleanup(self.subscriber.server_close)
        self.addCleanup(self.subscriber.shutdown)
        self.host = f"127.0.0.1:{self.subscriber.server_port}"
        self.options = [*Case.options, "--callback-hosts", self.host]
        super().setUp()

    def test_each_call_is_made_once(self):
        jobs = [self.submit(at, f"call http://{self.host}/{at.pid}-{k}")
                for k in range(5) for at in (self.first, self.second)]
        for job in jobs:
            self.assertEqual(self.finish(self.first, job)["status"], "successful")
        daemon.wait_until(lambda: server.sql("SELECT count(*) FROM calls", self.name) == ["0"],
                          "all calls to be made")
        ids = sorted(identity for identity, _ in self.calls)
        self.assertEqual(len(ids), len(set(ids)), ids)
        self.assertEqual({identity.split("-")[0] for identity in ids}, set(jobs))
        self.stop(self.first, self.second)


class Client(threading.Thread):
    """Submits jobs to the daemons in turn until it is stopped; keeps what was accepted."""

    def __init__(self, name, daemons):
        super().__init__(name=name)
        self.daemons = daemons
        self.accepted = {}
        self.refused = 0
        self.stopped = False

    def run(self):
        count = 0
        while not self.stopped:
            body = f"sleep 0.0{count % 7} {self.name} {count}" + (count % 2) * 20000 * " "
            at = self.daemons[count % len(self.daemons)]
            count += 1
            try:
                reply = at.request("POST", daemon.EXECUTE, body, ASYNC)
                if reply.status == 201:
                    self.accepted[reply.json["jobID"]] = body
                else:
                    self.refused += 1
                    time.sleep(0.05)
            except (OSError, http.client.HTTPException, ValueError):
                time.sleep(0.02)  # killed: an answer that did not come binds nobody


class Losses(Case):
    """What dies, and what is away."""

    options = ["--workers", "2", "--lease-seconds", "4", "--job-attempts", "1000"]

    @contextlib.contextmanager
    def load(self, daemons):
        clients = [Client(str(k), daemons) for k in range(3)]
        for client in clients:
            client.start()
        try:
            yield clients
        finally:
            for client in clients:
                client.stopped = True
            for client in clients:
                client.join()

    def wait_accepted(self, clients, more):
        """Until so many more jobs have been accepted."""
        before = sum(len(client.accepted) for client in clients)
        daemon.wait_until(lambda: sum(len(client.accepted) for client in clients) >= before + more,
                          f"{more} more jobs")

    def check(self, clients, at):
        """All that was accepted was successful, once, with its own result."""
        accepted = {job: body for client in clients for job, body in client.accepted.items()}
        print(f"{len(accepted)} jobs accepted, {sum(c.refused for c in clients)} refused")
        self.assertGreater(len(accepted), 3)
        for job, body in accepted.items():
            info = self.finish(at, job)
            self.assertEqual(info.get("status"), "successful", info)
            reply = at.request("GET", f"/jobs/{job}/results")
            self.assertEqual((reply.status, reply.body.decode()), (200, body))
        twice = server.sql("SELECT job FROM log WHERE text LIKE 'successful:%' GROUP BY job "
                           "HAVING count(*) > 1", self.name)
        self.assertEqual(twice, [])

    def test_daemons_are_killed(self):
        print(f"SCATTERD_SEED={SEED}")
        generator = random.Random(SEED)
        daemons = [self.first, self.second]
        with self.load(daemons) as clients:
            for _ in range(KILLS):
                time.sleep(generator.uniform(0.2, 1))
                k = generator.randrange(2)
                daemons[k].stop(signal.SIGKILL, keep=True)
                if generator.random() < 0.5:  # the other one has to do it alone for a while
                    time.sleep(generator.uniform(0, 3))
                daemons[k] = self.start(directory=daemons[k].directory)
            self.wait_accepted(clients, 4)
        self.check(clients, daemons[0])
        self.stop(*daemons)

    def test_the_rest_takes_what_a_dead_one_had(self):
        jobs = [self.submit(self.first, f"sleep 600 #{k}") for k in range(2)]
        for job in jobs:
            self.wait_for(self.first, job, "running")
        self.first.stop(signal.SIGKILL)
        with self.second.waking():
            for job in jobs:
                self.assertEqual(self.finish(self.second, job)["status"], "successful")
        attempts = sorted(self.status(self.second, job)["attempts"] for job in jobs)
        self.assertEqual(attempts, [1, 2])  # one ran there, one here
        self.stop(self.second)

    def test_a_stopped_one_gives_back(self):
        jobs = [self.submit(self.first, f"sleep 600 #{k}") for k in range(4)]
        self.stop(self.first)
        with self.second.waking():
            for job in jobs:
                info = self.finish(self.second, job)
                self.assertEqual((info["status"], info["attempts"]), ("successful", 1))
        self.stop(self.second)

    def test_one_that_hung_finds_its_job_taken(self):
        self.stop(self.second)
        job = self.submit(self.first, "sleep 600")
        self.wait_for(self.first, job, "running")
        holder = self.column(job, "holder")
        os.kill(self.first.pid, signal.SIGSTOP)
        second = self.start()
        try:
            daemon.wait_until(lambda: self.column(job, "holder") not in (holder, ""), "a new holder")
        finally:
            os.kill(self.first.pid, signal.SIGCONT)
        self.first.wait_for_log("event=lost")
        with second.waking():
            info = self.finish(self.first, job)
        self.assertEqual((info["status"], info["attempts"]), ("successful", 2))
        self.stop(self.first, second)

    def away(self, leave, come_back):
        with self.load([self.first, self.second]) as clients:
            self.wait_accepted(clients, 4)
            leave()
            daemon.wait_until(lambda: self.first.request("GET", "/readyz").status == 503,
                              "the loss to be seen")
            problem = self.first.request("GET", "/readyz").json
            self.assertIn("database", json.dumps(problem))
            reply = self.first.request("POST", daemon.EXECUTE, "x", ASYNC)
            self.assertEqual(reply.status, 503, reply.body)
            self.assertIn("Retry-After", reply.headers)
            self.assertEqual(self.first.request("GET", f"/jobs/{32 * '0'}").status, 503)
            self.assertEqual(self.first.request("GET", "/jobs").status, 503)
            solved = self.first.request("POST", daemon.EXECUTE, "no job",
                                        {"Content-Type": "application/json"})
            self.assertEqual((solved.status, solved.body), (200, b"no job"))
            time.sleep(1)
            come_back()
            for at in (self.first, self.second):
                at.wait_ready()
            self.wait_accepted(clients, 4)
        self.check(clients, self.second)
        self.stop(self.first, self.second)

    def test_first_results_while_the_database_is_away(self):
        """A daemon that has kept nothing yet cannot count then what there is: that costs no result."""
        jobs = [self.submit(self.first, f"sleep 600 #{k}") for k in range(2)]
        self.wait_both_at_work()
        server.sql("CREATE TABLE waits_for_the_disk()", self.name)  # and all before it
        self.addCleanup(lambda: server.process.poll() is None or server.start())
        server.kill()
        daemon.wait_until(lambda: self.second.request("GET", "/readyz").status == 503,
                          "the loss to be seen")
        with self.waking():
            self.second.wait_for_log("job .* cannot be stored")
        server.start()
        for at in (self.first, self.second):
            at.wait_ready()
        with self.waking():
            for job in jobs:
                self.assertEqual(self.finish(self.first, job)["status"], "successful")
        self.stop(self.first, self.second)

    def test_the_database_is_killed(self):
        self.addCleanup(lambda: server.process.poll() is None or server.start())
        self.away(server.kill, server.start)

    def test_the_database_hangs(self):
        self.addCleanup(server.thaw)
        self.away(server.freeze, server.thaw)


if __name__ == "__main__":
    try:
        setUpModule()
    except postgres.Missing as why:
        print(f"skipped: {why}")
        sys.exit(postgres.SKIPPED)
    del setUpModule
    unittest.main()
