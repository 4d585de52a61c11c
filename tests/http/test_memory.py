#!/usr/bin/env python3
"""http.memory: the front has no memory: its n-th allocation fails, alone or with all after it, for
every n of every kind of request, of a start and of a reload; or all of them do for a while. Who asks
gets the right answer, or one that says there is no room, or a closed connection; the daemon goes on,
loses nothing it accepted, leaves nothing behind, and is as before when there is memory again.
SCATTERD_EVERY=1 takes each n, not only some."""

import collections
import contextlib
import errno
import http.client
import itertools
import json
import os
import re
import shutil
import signal
import socket
import ssl
import sys
import threading
import time
import unittest

sys.dont_write_bytecode = True
import daemon  # noqa: E402
import faults as ordered  # noqa: E402
import test_access  # noqa: E402
import test_callbacks  # noqa: E402
import test_tls  # noqa: E402
from accounting import LARGE, account, work  # noqa: E402

EVERY = os.environ.get("SCATTERD_EVERY")
WORKERS = 3
OPTIONS = ["--workers", str(WORKERS), "--spool-bytes", "64KiB", "--job-attempts", "100",
           "--reuse-results", "0", "--callback-hosts", test_callbacks.RECEIVER.host,
           "--callback-attempts", "100", "--heartbeat-seconds", "1"]
JSON = {"Content-Type": "application/json"}
ASYNC = JSON | {"Prefer": "respond-async"}
REFUSALS = (413, 500, 503, 507)
CLOSED = (ConnectionError, http.client.HTTPException, ssl.SSLError)  # a time-out is none of them
count = itertools.count()


def steps():
    """The n that are tried: all, or fewer and fewer."""
    n = 0
    while True:
        yield n
        n += 1 if EVERY else 1 + n // 6


class Known(daemon.Daemon):
    """A daemon that wants a token, and gets it."""

    def __init__(self, *options, secret="", **more):
        self.known = test_access.bearer(secret)
        super().__init__(*options, **more)

    def request(self, method, path, body=None, headers=None):
        return super().request(method, path, body, self.known | (headers or {}))


class Secure(Known, test_tls.Secure):
    """The same over TLS."""


class Refused(Exception):
    """The daemon said that it has no memory."""


class Client:
    """Asks a daemon, and judges what it says. What it says without faults comes first."""

    def __init__(self, server):
        self.server = server
        self.accepted = {}
        self.usual = {}

    def judge(self, name, reply):
        """Raises Refused for a proper refusal; asserts that it is the usual answer otherwise."""
        fields = sorted(map(str.lower, set(reply.headers.keys()) - {"Content-Encoding"}))
        facts = (reply.status, fields, reply.type)  # packed or not, as memory allows
        if facts == self.usual.setdefault(name, facts):
            return reply
        assert reply.status in REFUSALS, (name, facts, self.usual[name], reply.body[:300])
        if reply.status != self.usual[name][0] and reply.body:
            assert reply.json, (name, facts)
        raise Refused(name)

    def ask(self, name, method, path, body=None, headers=None):
        """The usual answer, or Refused."""
        return self.judge(name, self.server.request(method, path, body, headers))

    def submit(self, name, body, headers=None):
        """A job that was accepted, and is to be accounted for."""
        reply = self.ask(name, "POST", daemon.EXECUTE, body, ASYNC | (headers or {}))
        job = reply.json["jobID"]
        assert reply.headers["Location"].endswith(f"/jobs/{job}"), reply.headers
        self.accepted[job] = body
        return job

    def end(self, name, job):
        """Waits for a job; how it ended."""
        while True:
            reply = self.ask(name, "GET", f"/jobs/{job}", None, {"Prefer": "wait=1"})
            if reply.json["status"] not in ("accepted", "running"):
                return reply.json["status"]

    def end_well(self, name, job):
        status = self.end(name, job)
        if status == "failed":  # it was told, and account() looks at the reason
            raise Refused(name)
        assert status == "successful", status


# ---- What is asked for: each part is a request or a few that belong together ----

def solve(client):
    k = next(count)
    for size in (0, 30000, 100000):
        body = f"now {k}" + size * " "
        assert client.ask(f"{size}", "POST", daemon.EXECUTE, body, JSON).body.decode() == body


def job(client):
    job = client.submit("submit", f"job {next(count)}")
    client.end_well("poll", job)
    result = client.ask("result", "GET", f"/jobs/{job}/results").body.decode()
    assert result == client.accepted[job]


def large_job(client):
    job = client.submit("submit", f"large {next(count)}" + LARGE, {"Idempotency-Key": f"{time.time()}"})
    client.end_well("poll", job)
    result = client.ask("result", "GET", f"/jobs/{job}/results", None, {"Range": "bytes=0-4"})
    assert result.body == b"large", result.body


def waited_for(client):
    body = f"waited for {next(count)}"
    reply = client.server.request("POST", daemon.EXECUTE, body,
                                  JSON | {"Prefer": "respond-async, wait=2"})
    if reply.status == 201:  # it takes longer, without memory
        client.accepted[reply.json["jobID"]] = body
    else:
        assert client.judge("wait", reply).body.decode() == body


def dismissal(client):
    job = client.submit("submit", f"sleep 1 {next(count)}")
    del client.accepted[job]
    for k in range(3):  # who is not answered asks again
        with contextlib.suppress(*CLOSED, Refused):
            reply = client.server.request("DELETE", f"/jobs/{job}")
            if k > 0 and reply.status == 410:
                break  # by what was not answered
            client.judge("dismiss", reply)
            break
    client.server.faults.clear()
    client.server.request("DELETE", f"/jobs/{job}")
    client.ask("again", "DELETE", f"/jobs/{job}")
    assert client.ask("gone", "GET", f"/jobs/{job}").json["status"] == "dismissed"


def lists(client):
    client.ask("first page", "GET", "/jobs?limit=3")
    client.ask("filtered", "GET", "/jobs?status=successful&processID=solve&limit=2")


def events(client):
    """A stream that ends has told everything; one that breaks off is resumed by the browser."""
    job = client.submit("submit", f"phase half 0.5 0.05 {next(count)}")
    reply = client.ask("events", "GET", f"/jobs/{job}/events")
    assert re.search(rb'event: status\ndata: .*"status":"(successful|failed)".*\n\n$', reply.body), \
        reply.body


def upload(client):
    body = f"[{next(count)}, 1, 4]"
    stored = client.ask("upload", "POST", "/data", body, JSON)
    path = stored.headers["Location"]
    path = "/data/" + path.rsplit("/", 1)[1]
    assert client.ask("download", "GET", path).body.decode() == body
    large = client.ask("large", "POST", "/data", f"[{next(count)}]" + 100000 * " ", JSON)
    client.ask("removal", "DELETE", "/data/" + large.headers["Location"].rsplit("/", 1)[1])


def batch(client):
    reply = client.ask("submit", "POST", daemon.EXECUTE, f"batch 3 x {next(count)}", ASYNC)
    job = reply.json["jobID"]
    client.end_well("poll", job)
    client.ask("results", "GET", f"/jobs/{job}/results")
    client.ask("one", "GET", f"/jobs/{job}/results/1")


def bridge(client):
    client.ask("info", "GET", "/Info")
    assert client.ask("evaluate", "POST", "/Evaluate", '{"name": "solve"}').body


def page(client):
    html = client.ask("page", "GET", "/", None, {"Accept": "text/html"})
    client.ask("packed", "GET", "/", None, {"Accept": "text/html", "Accept-Encoding": "gzip"})
    for path in re.findall(rb'(?:src|href)="/?(assets/[^"]+)"', html.body)[:2]:
        tag = client.ask(f"{path}", "GET", "/" + path.decode()).headers["ETag"]
        client.ask(f"{path} again", "GET", "/" + path.decode(), None, {"If-None-Match": tag})


def documents(client):
    for path in ("/", "/api", "/conformance", "/processes", "/processes/solve"):
        client.ask(path, "GET", path)
    client.ask("packed", "GET", "/api", None, {"Accept-Encoding": "gzip"})


def mistakes(client):
    client.ask("body", "POST", daemon.EXECUTE, "bad", ASYNC)
    client.ask("problem", "POST", daemon.EXECUTE, "problem", JSON)
    client.ask("type", "POST", daemon.EXECUTE, "x", {"Content-Type": "text/plain"})
    client.ask("route", "GET", "/nowhere?" + 3000 * "a")
    client.ask("method", "PUT", "/jobs")
    client.ask("job", "GET", "/jobs/none")
    client.ask("process", "POST", "/processes/none/execution", "{}", JSON)
    client.ask("query", "GET", "/jobs?limit=none")


def head_and_options(client):
    for path in ("/api", "/jobs", "/healthz"):
        assert client.ask(f"HEAD {path}", "HEAD", path).body == b""
        client.ask(f"OPTIONS {path}", "OPTIONS", path)


def metrics(client):
    assert b"scatterd_jobs" in client.ask("metrics", "GET", "/metrics").body
    client.ask("ready", "GET", "/readyz")
    client.ask("alive", "GET", "/healthz")


def tokens(client):
    secret = client.server.known["Authorization"].split()[1]
    client.ask("basic", "GET", "/jobs?limit=1", None, test_access.basic("alice", secret))
    client.ask("wrong", "GET", "/jobs?limit=1", None, test_access.basic("alice", "wrong"))
    client.ask("none", "GET", "/jobs?limit=1", None, {"Authorization": ""})


def chunked(client):
    """A body of unknown length, in pieces; one that is too long."""
    parts = [b"in pieces " + f"{next(count)}".encode(), 40000 * b" ", 40000 * b" "]
    reply = client.ask("chunked", "POST", daemon.EXECUTE, iter(parts), JSON)
    assert reply.body == b"".join(parts)


def kept_connection(client):
    """Several requests on one connection."""
    with contextlib.closing(client.server.connect()) as connection:
        for k in range(3):
            connection.request("POST", daemon.EXECUTE, f"kept {k}", JSON | client.server.known)
            reply = client.judge("kept", daemon.Reply(connection.getresponse()))
            assert reply.body.decode() == f"kept {k}"


def callback(client):
    """Who subscribed is called, if not now then when there is memory again; unless the job failed,
    of which account() wants the reason."""
    path = f"/{next(count)}"
    job = client.submit("submit", f"call http://{test_callbacks.RECEIVER.host}{path}")
    time.sleep(0.05)
    client.server.faults.clear()

    def is_over():
        called = test_callbacks.RECEIVER.at(path)
        return called or client.ask("poll", "GET", f"/jobs/{job}").json["status"] == "failed"
    daemon.wait_until(is_over, "a call")


def reload(client):
    """SIGHUP: what cannot be read changes nothing, for nobody."""
    server = client.server
    before = len(server.log)
    server.process.send_signal(signal.SIGHUP)
    daemon.wait_until(lambda: any("event=tokens" in line or "event=reload" in line
                                  for line in server.log[before:]), "the end of the reload")
    server.faults.clear()
    for name in server.secrets:
        client.ask(name, "GET", "/jobs?limit=1", None, test_access.bearer(server.secrets[name]))


def by_reference(client):
    """The worker asks the front for values, and has it keep some."""
    cloud = json.dumps([[k] for k in (0, 1, 2.5, 4, 5, 6 + 1 / (2 + next(count)))])
    where = client.ask("upload", "POST", "/data", cloud, JSON).json["href"]
    body = json.dumps({"inputs": {"cloud": {"href": where}, "field": "2*x"},
                       "outputs": {"laplacian": {"transmissionMode": "reference"}}})
    reply = client.ask("apply", "POST", "/processes/apply/execution", body, JSON)
    kept = re.search(rb'/data/[0-9a-f]{64}', reply.body)
    client.ask("kept", "GET", kept.group().decode())
    later = client.ask("job", "POST", "/processes/apply/execution", body, ASYNC).json["jobID"]
    client.end_well("poll", later)
    client.ask("results", "GET", f"/jobs/{later}/results")


PARTS = [solve, job, large_job, waited_for, dismissal, lists, events, upload, batch, bridge, page,
         documents, mistakes, head_and_options, metrics, tokens, chunked,
         kept_connection, callback, reload]


class Case(unittest.TestCase):
    def setUp(self):
        self.faults = ordered.Faults(memory=True)
        self.addCleanup(self.faults.close)
        self.addCleanup(shutil.rmtree, self.faults.directory, True)
        self.file = test_access.TokenFile()
        self.addCleanup(self.file.directory.cleanup)
        for name in ("alice", "bob"):
            self.file.add(name)

    def start(self, *first, kind=Known, **more):
        server = kind(*first, *OPTIONS, "--tokens", self.file.path,
                      secret=self.file.secret["alice"], directory=self.faults.directory,
                      environment=self.faults.environment, **more)
        self.addCleanup(lambda: server.process.poll() is None and server.stop())
        server.faults, server.secrets = self.faults, self.file.secret
        return server

    def assert_alive(self, server):
        self.assertIsNone(server.process.poll(), "\n".join(server.log[-20:]))

    def assert_sound(self, server):
        """It does everything."""
        self.assert_alive(server)
        log = "\n".join(server.log)
        self.assertNotIn("Sanitizer", log)
        self.assertNotIn("runtime error", log)
        accepted = {}
        self.assertTrue(work(server, accepted))
        self.assertEqual(account(server, accepted, False), 0)

    def assert_idle(self, server):
        """No job is stuck."""
        for state in ("accepted", "running"):
            daemon.wait_until(lambda: server.request("GET", f"/jobs?status={state}").json["jobs"]
                              == [], f"no job that is {state}")

    def assert_tidy(self, server):
        """Every file belongs to a job that is known."""
        for name in os.listdir(os.path.join(server.data, "jobs")):
            self.assertEqual(server.request("GET", "/jobs/" + name[:32]).status, 200, name)

    def stop(self, server):
        self.assertEqual(server.stop(keep=True), 0, "\n".join(server.log[-40:]))
        self.assertNotIn("Sanitizer", "\n".join(server.log))


class EachAllocation(Case):
    def descriptors(self, server):
        """What is open, by kind, and how often."""
        return collections.Counter(re.sub(r"[:\d].*", "", what.replace("/memfd:", "memory "))
                                   for what in daemon.descriptors(server.pid).values())

    def attempt(self, client, part, n, times):
        """The n-th allocation from now on fails; the whole part is done or refused."""
        server = client.server
        self.faults.fail("memory", errno.ENOMEM, after=n, times=times)
        end = threading.Timer(3, self.faults.clear)  # for a part that waits until there is some
        end.start()
        with contextlib.suppress(*CLOSED, Refused):
            part(client)
        end.cancel()
        if os.environ.get("SCATTERD_TELL"):
            print(n, times, time.time(), flush=True)
        hits = self.faults.hits("memory")
        self.faults.clear()
        self.assert_alive(server)
        self.assertEqual(server.request("GET", "/healthz").status, 200)
        return hits

    def each(self, client, part, times):
        """For every n; how many there are."""
        tried = 0
        for n in steps():
            with self.subTest(part=part.__name__, n=n, times=times):
                hits = self.attempt(client, part, n, times)
                failures = account(client.server, client.accepted, True)
                client.accepted = {}
                tried += hits > 0
                self.failures += failures
                if hits == 0:
                    return n, tried
            self.assert_alive(client.server)

    def survive(self, server, parts):
        for part in parts:
            self.failures = 0
            client = Client(server)
            for _ in range(3):
                part(client)  # what is made once, and what it says
            account(server, client.accepted, False)
            client.accepted = {}
            server.wait_for_metric('scatterd_workers{state="idle"}', WORKERS)  # none is being replaced
            before = self.descriptors(server)
            done = [self.each(client, part, times) for times in (1, -1)]
            self.assert_idle(server)
            with contextlib.suppress(AssertionError):
                daemon.wait_until(lambda: self.descriptors(server) <= before, "all closed")
            self.assertLessEqual(self.descriptors(server), before)
            self.assert_alive(server)
            server.assert_calm(0.5)
            print(f"{part.__name__}: {done[0][0]} allocations, {sum(d[1] for d in done)} tries, "
                  f"{self.failures} jobs failed with a reason", flush=True)
        self.assert_tidy(server)

    def test_requests(self):
        server = self.start()
        server.wait_ready()
        only = os.environ.get("SCATTERD_PART", "").split(",")
        self.survive(server, [part for part in PARTS if only == [""] or part.__name__ in only])
        self.assert_sound(server)
        self.stop(server)

    def dismiss_batch(self, server, n):
        """The n-th allocation of a dismissal fails; whether there was one."""
        reply = server.request("POST", daemon.EXECUTE, f"batch 3 sleep 600 {n}", ASYNC)
        job = f"/jobs/{reply.json['jobID']}"
        self.faults.fail("memory", errno.ENOMEM, after=n, times=1)
        with contextlib.suppress(*CLOSED):
            server.request("DELETE", job)
        hits = self.faults.hits("memory")
        self.faults.clear()
        server.request("DELETE", job)
        daemon.wait_until(lambda: server.request("GET", job).json["status"] == "dismissed",
                          "it to be stored")
        parts = server.request("GET", "/jobs?parent=" + job[6:]).json["jobs"]
        self.assertEqual([part["status"] for part in parts], 3 * ["dismissed"])
        return hits > 0

    def test_dismissal_of_a_batch(self):
        """Whatever cannot be looked up, its parts go with it."""
        server = self.start()
        server.wait_ready()
        self.dismiss_batch(server, 10**9)  # what is made once
        tried = sum(1 for _ in itertools.takewhile(lambda n: self.dismiss_batch(server, n),
                                                   itertools.count()))
        self.assert_idle(server)
        self.stop(server)
        print(f"dismissal of a batch: {tried} allocations", flush=True)

    def test_by_reference(self):
        """With the real worker."""
        server = self.start(stub=False)
        server.wait_ready()
        self.survive(server, [by_reference])
        self.stop(server)


class EachOfTls(Case):
    """Libraries below GnuTLS end a process that has no memory for a handshake (GMP, libtasn1): what
    is promised then is that nothing is lost."""

    def setUp(self):
        if daemon.is_sanitized():
            self.skipTest("AddressSanitizer reports what these libraries do as ours")
        super().setUp()
        self.certificates = test_tls.Certificates()
        self.addCleanup(self.certificates.directory.cleanup)
        self.certificates.make("first")
        self.certificates.install("first")

    def start_again(self):
        server = self.start(self.certificates, kind=Secure)
        server.wait_ready()
        return server

    def test_each(self):
        accepted, died, tried = {}, 0, 0
        client = Client(self.start_again())
        large_job(client)
        for n in steps():
            self.faults.fail("memory", errno.ENOMEM, after=n, times=1)
            with contextlib.suppress(*CLOSED, Refused):
                large_job(client)
            hits = self.faults.hits("memory")
            self.faults.clear()
            accepted |= client.accepted
            client.accepted = {}
            with contextlib.suppress(*CLOSED):
                client.server.request("GET", "/healthz")
            if client.server.process.poll() is not None:
                died += 1
                self.assertIn(client.server.stop(keep=True), (-signal.SIGABRT, -signal.SIGSEGV))
                client.server = self.start_again()
            if hits == 0:
                break
            tried += 1
        account(client.server, accepted, True)
        self.assert_idle(client.server)
        self.assert_sound(client.server)
        self.assert_tidy(client.server)
        self.stop(client.server)
        print(f"TLS: {n} allocations, {tried} tries, {died} of them ended the process, "
              f"{len(accepted)} jobs accepted, none lost", flush=True)


class ForAWhile(Case):
    """No memory at all for 2 s."""

    def load(self, server, accepted, over, wrong):
        while not over.is_set():
            try:
                work(server, accepted, REFUSALS)
            except CLOSED:
                time.sleep(0.02)
            except Exception as why:  # noqa: BLE001: told by the test
                wrong.append(why)

    def test_under_load(self):
        server = self.start()
        server.wait_ready()
        accepted, wrong, over = [{} for _ in range(4)], [], threading.Event()
        clients = [threading.Thread(target=self.load, args=(server, mine, over, wrong))
                   for mine in accepted]
        for client in clients:
            client.start()
        time.sleep(0.5)
        self.faults.fail("memory", errno.ENOMEM)
        time.sleep(2)
        hits = self.faults.hits("memory")
        self.faults.clear()
        time.sleep(0.5)
        over.set()
        for client in clients:
            client.join(4 * daemon.PATIENCE)
        self.assertEqual(wrong, [])
        every = {job: body for mine in accepted for job, body in mine.items()}
        failures = account(server, every, True)
        self.assert_idle(server)
        self.assert_sound(server)
        self.assert_tidy(server)
        self.stop(server)
        print(f"under load: {hits} allocations failed, {len(every)} jobs accepted, {failures} of them "
              "failed with a reason", flush=True)

    def test_at_rest(self):
        """A job runs and is watched, one waits, connections stay: it does not spin, and goes on."""
        server = self.start("--workers", "2")
        server.wait_ready()
        client = Client(server)
        running = client.submit("submit", f"sleep 3 {next(count)}")
        waiting = client.submit("submit", f"sleep 0.1 {next(count)}")
        with contextlib.closing(server.connect()) as stream, \
                contextlib.closing(server.connect()) as kept:
            stream.request("GET", f"/jobs/{running}/events", None, server.known)
            kept.request("GET", "/healthz")
            kept.getresponse().read()
            self.faults.fail("memory", errno.ENOMEM)
            server.assert_calm(2)
            for _ in range(3):
                with server.raw() as plain:
                    plain.sendall(b"GET /healthz HTTP/1.1\r\nHost: a\r\n\r\n")
            server.assert_calm(1)
            self.faults.clear()
        for job in (running, waiting):
            self.assertEqual(client.end("poll", job), "successful")
        account(server, client.accepted, False)
        self.assert_sound(server)
        self.stop(server)


class Starting(Case):
    """A start without memory: it serves, or says why not; the next one has everything."""

    def before(self):
        server = self.start()
        server.wait_ready()
        accepted = {}
        self.assertTrue(work(server, accepted))
        account(server, accepted, False)
        client = Client(server)
        for k in range(3):
            client.submit("waits", f"sleep 0.2 waits {k}")
            client.submit("waits", f"sleep 0.2 waits too {k}" + LARGE)
        upload = server.request("POST", "/data", "[3, 1, 4]", JSON)
        self.assertEqual(upload.status, 201, upload.body)
        server.stop(signal.SIGKILL, keep=True)
        return accepted | client.accepted, "/data/" + upload.json["id"]

    def attempt(self, n, times):
        """Starts with the n-th allocation failing; whether one did, and whether it serves."""
        self.faults.fail("memory", errno.ENOMEM, after=n, times=times)
        try:
            server = self.start()
        except AssertionError as ended:
            # AddressSanitizer ends a process that starts a thread without memory to look at its stack
            self.assertRegex(str(ended), "(?i)memory|allocat|cannot|ENOMEM|pthread_getattr_np")
            return True, False
        hits = self.faults.hits("memory")
        self.faults.clear()
        self.assertEqual(server.request("GET", "/healthz").status, 200)
        self.assertEqual(server.stop(signal.SIGKILL, keep=True), -signal.SIGKILL)
        return hits > 0, True

    def each(self, times):
        tried = served = 0
        for n in steps():
            with self.subTest(n=n, times=times):
                hit, serves = self.attempt(n, times)
                self.faults.clear()
                if not hit:
                    return n, tried, served
                tried += 1
                served += serves

    def test_each(self):
        accepted, data = self.before()
        done = [self.each(times) for times in (1, -1)]
        server = self.start()
        account(server, accepted, False)
        self.assertEqual(server.request("GET", data).status, 200)
        self.assert_sound(server)
        self.stop(server)
        print(f"start: {done[0][0]} allocations, {sum(d[1] for d in done)} tries, "
              f"{sum(d[2] for d in done)} of which serve; {len(accepted)} jobs kept", flush=True)


class Bounds(unittest.TestCase):
    """What clients can make the front hold is what OPERATIONS.md says, "How much machine"."""

    CONNECTIONS, HEADER, SPOOL = 80, 16384, 65536
    OF_ONE = 4 * HEADER + 65536  # a connection with its request

    def setUp(self):
        if daemon.is_sanitized():
            self.skipTest("AddressSanitizer keeps what was freed")
        self.server = daemon.Daemon("--workers", "2", "--spool-bytes", str(self.SPOOL),
                                    "--header-bytes", str(self.HEADER), "--reuse-results", "0")
        self.addCleanup(self.server.stop)
        self.server.wait_ready()

    def own(self):
        """Bytes of its own."""
        with open(f"/proc/{self.server.pid}/status", encoding="ascii") as file:
            return 1024 * int(re.search(r"RssAnon:\s+(\d+)", file.read()).group(1))

    def in_files(self):
        """Bytes in its memory files."""
        total = 0
        for number, what in daemon.descriptors(self.server.pid).items():
            if what.startswith("/memfd:"):
                with contextlib.suppress(OSError):
                    total += os.stat(f"/proc/{self.server.pid}/fd/{number}").st_blocks * 512
        return total

    def grown(self, name, request, most_own, most_files):
        """Sends the same on many connections that neither end nor read; how much each costs."""
        before = self.own(), self.in_files()
        with contextlib.ExitStack() as stack:
            for _ in range(self.CONNECTIONS):
                plain = stack.enter_context(self.server.raw())
                plain.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
                plain.sendall(request)
            for _ in range(5):  # after what came before
                time.sleep(0.2)
                self.server.request("GET", "/healthz")
            own, files = ((now - then) // self.CONNECTIONS
                          for now, then in zip((self.own(), self.in_files()), before))
        print(f"{name}: {own} bytes of its own a connection, {files} in memory files", flush=True)
        self.assertLessEqual(own, most_own, name)
        self.assertLessEqual(files, most_files, name)
        daemon.wait_until(lambda: self.server.request("GET", "/readyz").status == 200, "it to be free")

    def header(self, method, path, *more):
        filler = "X-Filler: " + (self.HEADER - 500) * "x"
        return "\r\n".join([f"{method} {path} HTTP/1.1", "Host: a", filler, *more, ""]).encode()

    def test_requests(self):
        self.grown("unfinished header", self.header("GET", "/healthz"), self.OF_ONE, 0)
        body = self.header("POST", daemon.EXECUTE, "Content-Type: application/json",
                           f"Content-Length: {10 * self.SPOOL}", "")
        self.grown("unfinished body", body + self.SPOOL * b" ", self.OF_ONE, self.SPOOL)
        self.grown("body on disk", body + 3 * self.SPOOL * b" ", self.OF_ONE, self.SPOOL)

    def test_streams(self):
        job = self.server.request("POST", daemon.EXECUTE, "phase half 0.5 5", ASYNC).json["jobID"]
        self.grown("event stream", self.header("GET", f"/jobs/{job}/events", ""),
                   self.OF_ONE + 8192, 0)

    def test_replies(self):
        """A reply that nobody reads is held: once, packed only if the client wants that."""
        batch = self.server.request("POST", daemon.EXECUTE, "batch 2000 x", ASYNC).json["jobID"]
        page = f"/jobs?limit=10000&parent={batch}"
        size = len(self.server.request("GET", page).body)
        print(f"page of 2000 jobs: {size / 2000:.0f} bytes a job")
        self.assertLess(size / 2000, 1024)
        self.grown("page of jobs", self.header("GET", page, ""), self.OF_ONE + size, 0)

    def test_results(self):
        self.grown("result", self.header("POST", daemon.EXECUTE, "Content-Type: application/json",
                                         "Content-Length: 11", "") + b"big 4000000",
                   self.OF_ONE, 4000000 + 65536)


if __name__ == "__main__":
    unittest.main()
