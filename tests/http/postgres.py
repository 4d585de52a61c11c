#!/usr/bin/env python3
"""A PostgreSQL server for tests, in a temporary directory, on a Unix socket only.

    postgres.py PROGRAM [ARGUMENT...]   runs a program with the URL of an empty database in
                                        $SCATTERD_STORE; status 77 if there is no server to start

    server = postgres.Server()          postgres.Missing says why not; settings of postgresql.conf as
                                        "fsync=off"; environment={...} of the server
    url = server.database("name")       made if it is not there
    server.freeze(), server.thaw()      it does not answer, and does again
    server.kill(), server.start()       kill -9 of all of it; another start on the same files
    server.stop()

initdb refuses root, so under root the server runs as user postgres, or nobody.
"""

import atexit
import glob
import os
import pwd
import shutil
import signal
import subprocess
import sys
import tempfile
import time

PATIENCE = 60
SKIPPED = 77


class Missing(Exception):
    """There is no PostgreSQL that could be started."""


def programs():
    """The folder of initdb and postgres, of the newest version there is."""
    found = sorted(glob.glob("/usr/lib/postgresql/*/bin/initdb"),
                   key=lambda path: int(path.split("/")[4].split(".")[0]))
    if found:
        return os.path.dirname(found[-1])
    on_path = shutil.which("initdb")
    if on_path is None:
        raise Missing("no initdb (Debian: postgresql)")
    return os.path.dirname(os.path.realpath(on_path))


def unprivileged():
    """Who to run it as: nobody else, unless we are root."""
    if os.getuid() != 0:
        return None
    for name in ("postgres", "nobody"):
        try:
            return pwd.getpwnam(name)
        except KeyError:
            continue
    raise Missing("no user postgres or nobody")


class Session:
    """Statements over one connection, without the time that it takes to start psql."""

    END = "end of the rows"

    def __init__(self, process):
        self.process = process

    def sql(self, text):
        """Rows as lines, columns with | between."""
        self.process.stdin.write(f"{text};\n\\echo {self.END}\n")
        self.process.stdin.flush()
        rows = []
        for line in self.process.stdout:
            if line == self.END + "\n":
                return rows
            rows.append(line.rstrip("\n"))
        raise AssertionError(f"psql has ended: {rows}")

    def close(self):
        self.process.communicate("\\q\n")


class Server:
    def __init__(self, *settings, environment=None):
        self.settings = settings
        self.environment = {**os.environ, **(environment or {})}
        self.programs = programs()
        self.account = unprivileged()
        self.directory = tempfile.mkdtemp(prefix="postgres-test-")
        self.process = None
        self.frozen = False
        atexit.register(self.stop)
        if self.account:
            os.chown(self.directory, self.account.pw_uid, self.account.pw_gid)
        os.chmod(self.directory, 0o755)
        self.user = self.account.pw_name if self.account else pwd.getpwuid(os.getuid()).pw_name
        made = self.run("initdb", "-D", self.files, "-A", "trust", "-E", "UTF8", "--no-locale",
                        "--no-sync", "-U", "scatterd")
        if made.returncode != 0:
            raise Missing("initdb: " + made.stdout[-400:])
        self.start()

    @property
    def files(self):
        return os.path.join(self.directory, "files")

    @property
    def log(self):
        return os.path.join(self.directory, "log")

    def become(self):
        os.setsid()
        if self.account:
            os.setgroups([])
            os.setgid(self.account.pw_gid)
            os.setuid(self.account.pw_uid)

    def run(self, name, *arguments):
        return subprocess.run([os.path.join(self.programs, name), *arguments], text=True,
                              cwd=self.directory, stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, preexec_fn=self.become, check=False)

    def start(self):
        with open(self.log, "a", encoding="utf-8") as log:
            options = [option for setting in
                       ("listen_addresses=", f"unix_socket_directories={self.directory}",
                        "max_connections=40", "shared_buffers=32MB", *self.settings)
                       for option in ("-c", setting)]
            self.process = subprocess.Popen(
                [os.path.join(self.programs, "postgres"), "-D", self.files, *options],
                cwd=self.directory, stdin=subprocess.DEVNULL, stdout=log, stderr=log,
                env=self.environment,
                preexec_fn=self.become)
        end = time.monotonic() + PATIENCE
        while self.run("pg_isready", "-q", "-h", self.directory).returncode != 0:
            if self.process.poll() is not None or time.monotonic() > end:
                raise Missing("postgres: " + open(self.log, encoding="utf-8").read()[-400:])
            time.sleep(0.05)

    def url(self, name):
        return f"postgresql://scatterd@/{name}?host={self.directory}"

    def sql(self, text, name="postgres"):
        """Rows as lines, columns with | between."""
        ran = self.run("psql", "-X", "-q", "-A", "-t", "-v", "ON_ERROR_STOP=1", "-c", text,
                       self.url(name))
        if ran.returncode != 0:
            raise AssertionError(ran.stdout)
        return ran.stdout.splitlines()

    def session(self, name):
        """A connection that stays; close() it."""
        return Session(subprocess.Popen(
            [os.path.join(self.programs, "psql"), "-X", "-q", "-A", "-t", self.url(name)], text=True,
            cwd=self.directory, stdin=subprocess.PIPE, stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT, preexec_fn=self.become))

    def database(self, name):
        if not self.sql(f"SELECT 1 FROM pg_database WHERE datname = '{name}'"):
            self.sql(f"CREATE DATABASE \"{name}\"")
        return self.url(name)

    def processes(self):
        """The postmaster and its children."""
        task = f"/proc/{self.process.pid}/task/{self.process.pid}/children"
        with open(task, encoding="ascii") as children:
            return [self.process.pid, *map(int, children.read().split())]

    def signal_all(self, number):
        for pid in self.processes():
            try:
                os.kill(pid, number)
            except ProcessLookupError:
                pass

    def freeze(self):
        self.frozen = True
        self.signal_all(signal.SIGSTOP)

    def thaw(self):
        if not self.frozen:
            return
        self.frozen = False
        self.signal_all(signal.SIGCONT)

    def kill(self):
        self.signal_all(signal.SIGKILL)
        self.process.wait(PATIENCE)

    def stop(self):
        if self.process is not None and self.process.poll() is None:
            self.thaw()
            self.process.send_signal(signal.SIGINT)  # ends sessions, writes its files
            try:
                self.process.wait(PATIENCE)
            except subprocess.TimeoutExpired:
                self.kill()
        shutil.rmtree(self.directory, ignore_errors=True)


def main():
    try:
        server = Server()
    except Missing as why:
        print(f"skipped: {why}")
        return SKIPPED
    environment = {**os.environ, "SCATTERD_STORE": server.database("test"),
                   "PATH": os.environ["PATH"] + ":" + server.programs}
    status = subprocess.run(sys.argv[1:], env=environment, check=False).returncode
    server.stop()
    return status


if __name__ == "__main__":
    sys.exit(main())
