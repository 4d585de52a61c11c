"""Starts a daemon for a test and stops it; talks HTTP to it.

    class MyTest(daemon.Case):
        options = ["--workers", "1"]
        def test_it(self):
            reply = self.get("/healthz")

The program is $SCATTERD, the one with a worker that fails on demand $SCATTERD_STUB (stub_answer.c);
a Case runs the latter unless `stub` is False. A daemon listens on a free port (or a Unix socket),
keeps its files in a directory of its own, and must stop with status 0 and leave nothing behind. It
may be called by any Host, unless --hosts is among the options.

With SCATTERD_TEST_STORE=postgres each daemon has a database of its own on a PostgreSQL server that
the test starts; the test is skipped, saying why, if that is not to be had. SCATTERD_OPTIONS holds
further options for every daemon.
"""

import contextlib
import http.client
import json
import os
import pathlib
import re
import shlex
import shutil
import signal
import socket
import subprocess
import tempfile
import threading
import time
import unittest

import postgres

EXECUTE = "/processes/solve/execution"
# what a data directory always holds
STORE = {"lock", "jobs", "jobs.db", "jobs.db-shm", "jobs.db-wal", "data", "runs"}
PATIENCE = 120  # seconds that anything may take on a busy machine


def program(stub):
    return os.environ["SCATTERD_STUB" if stub else "SCATTERD"]


def shares_store():
    """Do the jobs go to PostgreSQL?"""
    return os.environ.get("SCATTERD_TEST_STORE") == "postgres"


_server = None


def database(name):
    """URL of a database on the server of this test, which is started with the first."""
    global _server
    if _server is None:
        try:
            _server = postgres.Server("fsync=off")  # the machine stays up
        except postgres.Missing as why:
            print(f"skipped: {why}", flush=True)
            os._exit(postgres.SKIPPED)
    return _server.database(name)


def is_sanitized():
    """Is the daemon built with AddressSanitizer?"""
    return b"__asan_init" in pathlib.Path(program(stub=False)).read_bytes()


def wait_until(condition, what, seconds=PATIENCE):
    """Polls until condition() is true and returns what it returned."""
    end = time.monotonic() + seconds
    while True:
        result = condition()
        if result:
            return result
        if time.monotonic() > end:
            raise AssertionError(f"not within {seconds} s: {what}")
        time.sleep(0.01)


def children(pid):
    """Process ids of the children of a process, zombies too."""
    return [int(text) for text in
            pathlib.Path(f"/proc/{pid}/task/{pid}/children").read_text().split()]


def processor_seconds(pid):
    """Processor time of a process so far."""
    fields = pathlib.Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def descriptors(pid):
    """Open descriptors of a process: number to what it is."""
    found = {}
    for link in pathlib.Path(f"/proc/{pid}/fd").iterdir():
        with contextlib.suppress(OSError):
            found[int(link.name)] = os.readlink(link)
    return found


class UnixConnection(http.client.HTTPConnection):
    """HTTP over a Unix socket."""

    def __init__(self, path, timeout):
        super().__init__("localhost", timeout=timeout)
        self.path = path

    def connect(self):
        self.sock = socket.socket(socket.AF_UNIX)
        self.sock.settimeout(self.timeout)
        self.sock.connect(self.path)


class Reply:
    """Status, header fields and body of a reply."""

    def __init__(self, response):
        self.status = response.status
        self.headers = response.headers
        self.body = response.read()

    @property
    def type(self):
        return self.headers["Content-Type"]

    @property
    def json(self):
        return json.loads(self.body)


class Daemon:
    """A running daemon."""

    def __init__(self, *options, stub=True, unix=False, environment=None, directory=None,
                 before=None, store=None):
        """`directory`: of an earlier daemon that was stopped with keep=True; `before`: called in
        the new process before it becomes the daemon; `store`: URL of the database."""
        self.directory = directory or tempfile.mkdtemp(prefix="daemon-test-")
        os.chmod(self.directory, 0o755)  # a daemon that leaves root must still reach its data
        self.socket = os.path.join(self.directory, "socket")
        listen = f"unix:{self.socket}" if unix else "127.0.0.1:0"
        self.log = []
        if store is None and shares_store():
            store = database(os.path.basename(self.directory))
        self.store = store
        shared = ["--store", store, "--lease-seconds", "6"] if store else []
        self.process = subprocess.Popen(
            [program(stub), "--listen", listen, "--data-dir", self.data, "--hosts", "*", *shared,
             *options, *shlex.split(os.environ.get("SCATTERD_OPTIONS", ""))],
            stdin=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True,
            env={**os.environ, **(environment or {})}, preexec_fn=before)
        self.pid = self.process.pid
        self.reader = threading.Thread(target=self._read_log, daemon=True)
        self.reader.start()
        try:
            line = self.wait_for_log(r"event=listening address=(\S+)")
        except AssertionError:
            self.stop(keep=directory is not None)
            raise
        self.address = line.group(1)
        self.port = None if unix else int(self.address.rsplit(":", 1)[1])

    @property
    def data(self):
        return os.path.join(self.directory, "data")

    def files(self):
        """Names of the files of jobs, JOB.KIND, or what they would be called if they are rows."""
        if self.store:
            kinds = "(ARRAY['request', 'checkpoint', 'result'])[kind + 1]"
            return _server.sql(f"SELECT DISTINCT owner || '.' || {kinds} FROM large WHERE "
                               "length(owner) = 32 ORDER BY 1", os.path.basename(self.directory))
        return sorted(os.listdir(os.path.join(self.data, "jobs")))

    def _read_log(self):
        for line in self.process.stderr:
            self.log.append(line.rstrip("\n"))

    def wait_for_log(self, pattern):
        """The match of the first log line that `pattern` is found in."""
        def find():
            for line in list(self.log):
                match = re.search(pattern, line)
                if match:
                    return match
            if self.process.poll() is not None:
                self.reader.join(PATIENCE)
                raise AssertionError("the daemon ended: " + "\n".join(self.log))
            return None
        return wait_until(find, f"a log line with {pattern}")

    def wait_ready(self):
        wait_until(lambda: self.request("GET", "/readyz").status == 200, "readiness")

    def metric(self, series):
        """Value of a line of /metrics; 0 if there is none yet."""
        text = self.request("GET", "/metrics").body.decode()
        found = re.search("^" + re.escape(series) + " (.+)$", text, re.MULTILINE)
        return float(found[1]) if found else 0

    def wait_for_metric(self, series, value):
        wait_until(lambda: self.metric(series) == value, f"{series} {value}")

    def wait_busy(self, workers=1):
        """So many workers have a request of somebody, by what the front knows: a worker may be done
        with the one before a little later than whoever asked."""
        self.wait_for_metric('scatterd_workers{state="busy"}', workers)

    def wake(self):
        """What sleeps in a worker at this moment has slept enough (stub_answer.c)."""
        self.signal_workers(signal.SIGUSR1)

    def signal_workers(self, how):
        for worker in children(self.pid):
            with contextlib.suppress(ProcessLookupError):
                os.kill(worker, how)

    @contextlib.contextmanager
    def waking(self):
        """Nothing sleeps any longer, now or later, while this lasts."""
        over = threading.Event()

        def run():
            while not over.wait(0.01):
                self.wake()
        waker = threading.Thread(target=run)
        waker.start()
        try:
            yield
        finally:
            over.set()
            waker.join()

    def assert_calm(self, seconds):
        """It does not spin: a loop that does takes all of a processor."""
        before = processor_seconds(self.pid)
        time.sleep(seconds)
        used = processor_seconds(self.pid) - before
        assert used < seconds / 4, f"it spins: {used} s of processor in {seconds} s"

    def connect(self, timeout=PATIENCE):
        if self.port is None:
            return UnixConnection(self.socket, timeout)
        return http.client.HTTPConnection("127.0.0.1", self.port, timeout=timeout)

    def raw(self):
        """A plain socket to the daemon."""
        if self.port is None:
            plain = socket.socket(socket.AF_UNIX)
            plain.connect(self.socket)
        else:
            plain = socket.create_connection(("127.0.0.1", self.port))
        plain.settimeout(PATIENCE)
        return plain

    def request(self, method, path, body=None, headers=None):
        """One request on a connection of its own."""
        connection = self.connect()
        try:
            connection.request(method, path, body, headers or {})
            return Reply(connection.getresponse())
        finally:
            connection.close()

    def wait_taken_in(self):
        """What was sent before on other connections has been read: all of a turn of its loop is."""
        for _ in range(2):
            assert self.request("GET", "/healthz").status == 200

    def stop(self, how=signal.SIGTERM, keep=False):
        """Stops it and returns its exit status."""
        if self.process.poll() is None:
            self.process.send_signal(how)
        status = self.process.wait(PATIENCE)
        self.reader.join(PATIENCE)
        self.process.stderr.close()
        if not keep:
            shutil.rmtree(self.directory, ignore_errors=True)
        return status


class Case(unittest.TestCase):
    """Tests on one daemon, started for the class."""

    options = []
    stub = True
    unix = False

    @classmethod
    def setUpClass(cls):
        cls.daemon = Daemon(*cls.options, stub=cls.stub, unix=cls.unix)
        cls.addClassCleanup(cls.daemon.stop)  # where the class fails to start, nothing else stops it
        cls.daemon.wait_ready()

    @classmethod
    def tearDownClass(cls):
        daemon = cls.daemon
        assert daemon.process.poll() is None, "it ended by itself:\n" + "\n".join(daemon.log)
        workers = children(daemon.pid)
        files = sorted(set(os.listdir(daemon.data)) - STORE)
        status = daemon.stop()
        log = "\n".join(daemon.log)
        assert status == 0, f"exit status {status}\n{log}"
        assert not os.path.exists(daemon.socket), "the socket file is left"
        assert files == [], f"files left: {files}"
        assert "Sanitizer" not in log and "runtime error" not in log, log
        for pid in workers:
            assert not os.path.exists(f"/proc/{pid}"), f"worker {pid} is left"

    def get(self, path, **headers):
        return self.request("GET", path, headers=headers)

    def request(self, method, path, body=None, headers=None):
        named = {name.replace("_", "-"): value for name, value in (headers or {}).items()}
        return self.daemon.request(method, path, body, named)

    def execute(self, body, path=EXECUTE, **headers):
        headers.setdefault("Content_Type", "application/json")
        return self.request("POST", path, body, headers)

    def exchange(self, data):
        """Sends bytes and returns all that comes back until the daemon closes."""
        with self.daemon.raw() as plain:
            plain.sendall(data)
            return read_all(plain)

    def assert_problem(self, reply, status, *words):
        """The reply is a problem of this status whose detail has all these words."""
        self.assertEqual(reply.status, status, reply.body)
        self.assertEqual(reply.type, "application/problem+json")
        problem = reply.json
        self.assertEqual(problem["status"], status)
        self.assertTrue(problem["type"] and problem["title"])
        for word in words:
            self.assertIn(word, problem["detail"])
        return problem


def read_all(plain):
    data = b""
    with contextlib.suppress(ConnectionResetError):
        while True:
            part = plain.recv(65536)
            if not part:
                break
            data += part
    return data
