"""Socket activation, readiness and the user to run as, without a systemd."""

import http.client
import os
import pathlib
import pwd
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import unittest

import daemon

# Starts argv[2:] with descriptor argv[1] as the one that a service manager passes.
ACTIVATE = """
import os, sys
os.dup2(int(sys.argv[1]), 3, inheritable=True)
os.environ.update(LISTEN_PID=str(os.getpid()), LISTEN_FDS="1")
os.execv(sys.argv[2], sys.argv[2:])
"""


class Systemd(unittest.TestCase):

    def setUp(self):
        self.directory = tempfile.mkdtemp(prefix="systemd-test-")
        self.addCleanup(shutil.rmtree, self.directory)
        self.notify = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        self.notify.bind(os.path.join(self.directory, "notify"))
        self.notify.settimeout(daemon.PATIENCE)
        self.addCleanup(self.notify.close)

    def start(self, listener, *options):
        process = subprocess.Popen(
            [sys.executable, "-c", ACTIVATE, str(listener.fileno()), daemon.program(stub=True),
             "--data-dir", os.path.join(self.directory, "data"), "--workers", "1", *options],
            pass_fds=[listener.fileno()], stderr=subprocess.PIPE, text=True,
            env={**os.environ, "NOTIFY_SOCKET": self.notify.getsockname()})
        self.addCleanup(process.stderr.close)
        self.addCleanup(process.wait)
        self.addCleanup(process.kill)
        return process

    def test_takes_the_socket_and_says_ready_and_stopping(self):
        with socket.create_server(("127.0.0.1", 0)) as listener:
            process = self.start(listener)
            self.assertEqual(self.notify.recv(200), b"READY=1")
            connection = http.client.HTTPConnection(*listener.getsockname())
            connection.request("GET", "/healthz")
            self.assertEqual(connection.getresponse().status, 200)
            connection.close()
            process.send_signal(signal.SIGTERM)
            self.assertTrue(self.notify.recv(200).startswith(b"STOPPING=1\nEXTEND_TIMEOUT_USEC="))
            self.assertEqual(process.wait(daemon.PATIENCE), 0)

    def test_reloads(self):
        with socket.create_server(("127.0.0.1", 0)) as listener:
            process = self.start(listener)
            self.assertEqual(self.notify.recv(200), b"READY=1")
            process.send_signal(signal.SIGHUP)
            self.assertRegex(self.notify.recv(200), rb"^RELOADING=1\nMONOTONIC_USEC=\d+$")
            self.assertEqual(self.notify.recv(200), b"READY=1")
            process.send_signal(signal.SIGTERM)
            self.assertEqual(process.wait(daemon.PATIENCE), 0)

    def test_a_socket_beyond_loopback_takes_tokens_too(self):
        with socket.create_server(("0.0.0.0", 0)) as listener:
            process = self.start(listener)
            self.assertEqual(process.wait(daemon.PATIENCE), 1)
            self.assertIn("there are no tokens", process.stderr.read())

    def test_refuses_what_is_no_listening_socket(self):
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as wrong:
            process = self.start(wrong)
            self.assertEqual(process.wait(daemon.PATIENCE), 1)
            self.assertIn("no listening stream socket", process.stderr.read())


@unittest.skipIf(os.geteuid() != 0, "only root can become somebody else")
class User(daemon.Case):
    options = ["--workers", "1", "--user", "nobody"]

    def test_front_and_workers_have_left_root(self):
        entry = pwd.getpwnam("nobody")
        nobody, group = str(entry.pw_uid), str(entry.pw_gid)
        groups = os.getgrouplist("nobody", entry.pw_gid)
        daemon.wait_until(lambda: self.get("/readyz").status == 200, "a worker")
        for pid in (self.daemon.pid, *daemon.children(self.daemon.pid)):
            status = pathlib.Path(f"/proc/{pid}/status").read_text()
            self.assertIn("Uid:\t" + "\t".join(4 * [nobody]), status)
            self.assertIn("Gid:\t" + "\t".join(4 * [group]), status)
            kept = status.split("Groups:\t")[1].split("\n")[0].split()
            self.assertLessEqual(set(map(int, kept)), set(groups))
            self.assertIn("CapEff:\t0000000000000000", status)


class NoSuchUser(unittest.TestCase):

    def test_is_refused(self):
        with tempfile.TemporaryDirectory() as directory:
            done = subprocess.run(
                [daemon.program(stub=True), "--listen", "127.0.0.1:0", "--data-dir", directory,
                 "--user", "no-such-user"], capture_output=True, text=True, check=False,
                timeout=daemon.PATIENCE)
        self.assertEqual(done.returncode, 1)
        self.assertIn("no-such-user", done.stderr)


if __name__ == "__main__":
    unittest.main()
