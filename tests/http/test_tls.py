"""HTTPS with certificates made here: versions, large bodies both ways, event streams, slow and rude
clients, and a certificate that is replaced while connections go on."""

import contextlib
import http.client
import itertools
import json
import os
import signal
import socket
import ssl
import subprocess
import tempfile
import threading
import time
import unittest

import daemon

JSON = {"Content-Type": "application/json"}
OPTIONS = ["--workers", "2"]


class Certificates:
    """Self-signed certificates in a directory: NAME.pem and NAME.key."""

    def __init__(self):
        self.directory = tempfile.TemporaryDirectory(prefix="tls-test-")

    def path(self, name):
        return os.path.join(self.directory.name, name)

    def make(self, name, kind="ec"):
        how = {"ec": ["-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1"],
               "rsa": ["-newkey", "rsa:2048"]}[kind]
        subprocess.run(["openssl", "req", "-x509", *how, "-nodes", "-days", "2", "-subj",
                        f"/CN={name}", "-addext", "subjectAltName=DNS:localhost,IP:127.0.0.1",
                        "-keyout", self.path(name + ".key"), "-out", self.path(name + ".pem")],
                       check=True, capture_output=True)

    def install(self, name):
        """Makes this the one in use, each file in one step."""
        for kind in ("pem", "key"):
            with open(self.path(f"{name}.{kind}"), encoding="ascii") as source:
                text = source.read()
            with open(os.open(self.path("new"), os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o600),
                      "w", encoding="ascii") as copy:
                copy.write(text)
            os.replace(self.path("new"), self.path("current." + kind))


class Secure(daemon.Daemon):
    """A daemon that is talked to over TLS."""

    def __init__(self, certificates, *options, **more):
        self.certificates = certificates
        super().__init__("--tls-certificate", certificates.path("current.pem"), "--tls-key",
                         certificates.path("current.key"), *options, **more)

    def context(self, *names):
        context = ssl.create_default_context()
        for name in names or ("current",):
            context.load_verify_locations(self.certificates.path(name + ".pem"))
        return context

    def connect(self, timeout=daemon.PATIENCE):
        return http.client.HTTPSConnection("127.0.0.1", self.port, timeout=timeout,
                                           context=self.context())

    def secured(self, context=None):
        """A plain socket with TLS on it."""
        return (context or self.context()).wrap_socket(self.raw(), server_hostname="localhost")

    def reload(self):
        before = len(self.log)
        self.process.send_signal(signal.SIGHUP)
        return daemon.wait_until(
            lambda: [line for line in self.log[before:]
                     if "event=certificate" in line or "event=reload" in line], "the log")[0]


class Case(daemon.Case):
    more = []

    @classmethod
    def setUpClass(cls):
        cls.files = Certificates()
        cls.addClassCleanup(cls.files.directory.cleanup)
        cls.files.make("first")
        cls.files.install("first")
        cls.daemon = Secure(cls.files, *OPTIONS, *cls.more)
        cls.addClassCleanup(cls.daemon.stop)
        cls.daemon.wait_ready()


class Silence(Case):
    more = ["--receive-seconds", "2"]

    def test_refusal_in_the_middle_of_a_body(self):
        head = (f"POST {daemon.EXECUTE} HTTP/1.1\r\nHost: a\r\nContent-Type: application/json\r\n"
                "Transfer-Encoding: chunked\r\n\r\n5\r\nabc").encode()
        with self.daemon.secured() as secured:  # then silence
            secured.sendall(head)
            reply = daemon.read_all(secured)
        self.assertTrue(reply.startswith(b"HTTP/1.1 408 "), reply)
        self.assertEqual(json.loads(reply.split(b"\r\n\r\n", 1)[1])["status"], 408)

    def test_a_handshake_that_never_comes(self):
        with self.daemon.raw() as plain:
            self.assertEqual(daemon.read_all(plain), b"")
        with self.daemon.raw() as plain:
            plain.sendall(b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc")  # a hello's first bytes
            daemon.read_all(plain)


class Tls(Case):

    def test_links_say_https(self):
        for link in self.get("/").json["links"]:
            self.assertTrue(link["href"].startswith(f"https://{self.daemon.address}/"), link)

    def test_plain_http_gets_nothing(self):
        with self.daemon.raw() as plain:
            plain.sendall(b"GET /healthz HTTP/1.1\r\nHost: a\r\n\r\n")
            self.assertNotIn(b"HTTP", daemon.read_all(plain))

    def test_versions(self):
        for version, good in ((ssl.TLSVersion.TLSv1_2, True), (ssl.TLSVersion.TLSv1_3, True),
                              (ssl.TLSVersion.TLSv1_1, False)):
            context = self.daemon.context()
            context.set_ciphers("ALL:@SECLEVEL=0")
            with contextlib.suppress(ValueError), self.subTest(version):
                context.minimum_version = context.maximum_version = version
                if good:
                    with self.daemon.secured(context) as secured:
                        self.assertEqual(secured.version(), version.name.replace("_", "."))
                else:
                    with self.assertRaises((ssl.SSLError, ConnectionError)):
                        self.daemon.secured(context)

    def test_curl(self):
        url = f"https://localhost:{self.daemon.port}{daemon.EXECUTE}"
        done = subprocess.run(["curl", "-sS", "--fail", "--cacert", self.files.path("current.pem"),
                               "--resolve", f"localhost:{self.daemon.port}:127.0.0.1", "-H",
                               "Content-Type: application/json", "-d", "by curl", url],
                              check=True, capture_output=True, timeout=daemon.PATIENCE)
        self.assertEqual(done.stdout, b"by curl")

    def test_large_bodies_both_ways(self):
        for size in (0, 1, 16383, 16384, 16385, 100000, 20000000):
            body = b"#" + bytes(k % 251 for k in range(min(size, 251))) * (size // 251 + 1)
            reply = self.execute(body)
            self.assertEqual(reply.status, 200)
            self.assertTrue(reply.body == body, size)

    def test_many_requests_on_one_connection(self):
        connection = self.daemon.connect()
        for k in range(200):
            connection.request("POST", daemon.EXECUTE, f"#{k}" * (1 + k * 37), JSON)
            self.assertEqual(connection.getresponse().read().decode(), f"#{k}" * (1 + k * 37))
        connection.close()

    def test_pipelined_requests(self):
        one = b"GET /healthz HTTP/1.1\r\nHost: a\r\n\r\n"
        with self.daemon.secured() as secured:
            secured.sendall(20 * one + one.replace(b"\r\n\r\n", b"\r\nConnection: close\r\n\r\n"))
            self.assertEqual(daemon.read_all(secured).count(b"HTTP/1.1 200 OK"), 21)

    def test_a_slow_reader_gets_all(self):
        with self.daemon.secured() as secured:
            secured.sendall(f"POST {daemon.EXECUTE} HTTP/1.1\r\nHost: a\r\nConnection: close\r\n"
                            "Content-Type: application/json\r\nContent-Length: 11\r\n\r\n"
                            "big 4000000".encode())
            data = b""
            while True:
                part = secured.recv(30000)
                if not part:
                    break
                data += part
                if len(data) < 600000:
                    time.sleep(0.02)
        self.assertEqual(len(data.split(b"\r\n\r\n", 1)[1]), 4000000)

    def test_sleeping_requests_and_streams(self):
        made = self.request("POST", daemon.EXECUTE, "phase half 0.5 600",
                            {**JSON, "Prefer": "respond-async"}).json["jobID"]
        with contextlib.closing(self.daemon.connect()) as connection:
            connection.request("GET", f"/jobs/{made}/events", headers={"Last-Event-ID": "1"})
            stream = connection.getresponse()
            with self.daemon.waking():
                events = stream.read()
        self.assertIn(b'"phase":"half"', events)
        self.assertIn(b'"status":"successful"', events)
        replies = []
        threads = [threading.Thread(target=lambda: replies.append(self.execute("sleep 0.5").status))
                   for _ in range(6)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(replies, 6 * [200])

    def test_a_client_that_leaves_stops_its_worker(self):
        with self.daemon.secured() as secured:
            secured.sendall(f"POST {daemon.EXECUTE} HTTP/1.1\r\nHost: a\r\nX-Request-Id: left\r\n"
                            "Content-Type: application/json\r\nContent-Length: 8\r\n\r\nsleep 99"
                            .encode())
            daemon.wait_until(lambda: 'busy"} 1' in self.get("/metrics").body.decode(), "busy")
        self.daemon.wait_for_log("id=left .*end=aborted")

    def test_noise(self):
        for noise in (b"\0" * 1000, os.urandom(3000), b"\x16\x03\x01\xff\xff" + b"a" * 70000,
                      b"\x80\x2e\x01\x00\x02"):
            with self.daemon.raw() as plain, contextlib.suppress(OSError):
                plain.sendall(noise)
                plain.shutdown(socket.SHUT_WR)
                daemon.read_all(plain)
        self.assertEqual(self.get("/healthz").status, 200)


class Reload(unittest.TestCase):

    def setUp(self):
        self.files = Certificates()
        self.addCleanup(self.files.directory.cleanup)
        for name, kind in (("first", "ec"), ("second", "rsa"), ("third", "ec")):
            self.files.make(name, kind)
        self.files.install("first")
        self.daemon = Secure(self.files, *OPTIONS)
        self.addCleanup(self.daemon.stop)
        self.daemon.wait_ready()

    def served(self):
        """Name in the certificate of a new connection."""
        with self.daemon.secured(self.daemon.context("first", "second", "third")) as secured:
            return dict(part[0] for part in secured.getpeercert()["subject"])["commonName"]

    def test_new_connections_get_the_new_one_and_old_ones_go_on(self):
        self.assertEqual(self.served(), "first")
        kept = self.daemon.connect()
        kept.request("GET", "/healthz")
        kept.getresponse().read()
        replies = []
        context = self.daemon.context("first", "second")

        def execute():
            connection = http.client.HTTPSConnection("127.0.0.1", self.daemon.port,
                                                     timeout=daemon.PATIENCE, context=context)
            connection.request("POST", daemon.EXECUTE, "sleep 60", JSON)
            replies.append(connection.getresponse().status)
            connection.close()
        thread = threading.Thread(target=execute)
        thread.start()
        daemon.wait_until(lambda: 'busy"} 1' in self.daemon.request("GET", "/metrics").body.decode(),
                          "busy")
        self.files.install("second")
        self.assertIn("good until", self.daemon.reload())
        self.assertEqual(self.served(), "second")
        kept.request("GET", "/healthz")
        self.assertEqual(kept.getresponse().status, 200)
        kept.close()
        with self.daemon.waking():
            thread.join()
        self.assertEqual(replies, [200])

    def test_what_is_no_good_changes_nothing(self):
        for bad, word in (("mixed", "not the key of"), ("garbage", "tls-certificate"),
                          ("missing", "No such file")):
            with self.subTest(bad):
                self.files.install("first")
                if bad == "mixed":
                    os.replace(self.files.path("third.key"), self.files.path("current.key"))
                elif bad == "garbage":
                    with open(self.files.path("current.pem"), "w", encoding="ascii") as file:
                        file.write("-----BEGIN CERTIFICATE-----\nAAAA\n")
                else:
                    os.unlink(self.files.path("current.key"))
                line = self.daemon.reload()
                self.assertIn("event=reload", line)
                self.assertIn(word, line)
                self.assertEqual(self.served(), "first")

    def test_under_load(self):
        """Connections by the hundred while certificates change: none fails."""
        contexts = self.daemon.context("first", "second", "third")
        failed, done, stop = [], [0], threading.Event()

        def connect():
            while not stop.is_set():
                try:
                    with self.daemon.secured(contexts) as secured:
                        secured.sendall(b"GET /healthz HTTP/1.1\r\nHost: a\r\nConnection: close"
                                        b"\r\n\r\n")
                        if not daemon.read_all(secured).startswith(b"HTTP/1.1 200"):
                            failed.append("no reply")
                    done[0] += 1
                except OSError as error:
                    failed.append(error)
        threads = [threading.Thread(target=connect) for _ in range(4)]
        for thread in threads:
            thread.start()
        for name in itertools.cycle(["second", "third", "first"]):
            self.files.install(name)
            self.assertIn("good until", self.daemon.reload())
            if done[0] > 60 or failed:
                break
        stop.set()
        for thread in threads:
            thread.join()
        self.assertEqual(failed, [])


class Start(unittest.TestCase):

    def start(self, *options):
        with tempfile.TemporaryDirectory() as directory:
            return subprocess.run(
                [daemon.program(stub=True), "--listen", "127.0.0.1:0", "--data-dir", directory,
                 "--workers", "1", *options],
                capture_output=True, text=True, check=False, timeout=daemon.PATIENCE)

    def test_bad_files(self):
        files = Certificates()
        self.addCleanup(files.directory.cleanup)
        files.make("a")
        files.make("b")
        pem, key, other = files.path("a.pem"), files.path("a.key"), files.path("b.key")
        for options, word in ((["--tls-certificate", pem, "--tls-key", other], "not the key of"),
                              (["--tls-certificate", pem], "tls-key"),
                              (["--tls-certificate", key, "--tls-key", key], "tls-certificate"),
                              (["--tls-certificate", "/no/such"], "/no/such"),
                              (["--tls-key", key], "no tls-certificate")):
            done = self.start(*options)
            self.assertEqual(done.returncode, 1)
            self.assertIn(word, done.stderr)

    def test_both_in_one_file(self):
        files = Certificates()
        self.addCleanup(files.directory.cleanup)
        files.make("a")
        files.install("a")
        with open(files.path("current.key"), encoding="ascii") as key:
            with open(files.path("current.pem"), "a", encoding="ascii") as both:
                both.write(key.read())
        os.chmod(files.path("current.pem"), 0o644)
        running = daemon.Daemon("--tls-certificate", files.path("current.pem"), "--workers", "1")
        self.addCleanup(running.stop)
        running.wait_for_log("event=certificate .*may be read by everybody")
        context = ssl.create_default_context(cafile=files.path("a.pem"))
        with context.wrap_socket(running.raw(), server_hostname="localhost") as secured:
            self.assertEqual(secured.version(), "TLSv1.3")


if __name__ == "__main__":
    unittest.main()
