#!/usr/bin/env python3
"""http.data: objects under /data and inputs by reference, with the real worker."""

import base64
import contextlib
import gzip
import hashlib
import http.server
import io
import json
import sys
import threading
import time
import unittest

import numpy

sys.dont_write_bytecode = True
import daemon  # noqa: E402

APPLY = "/processes/apply/execution"
POINTS = numpy.array([[0.0], [1.0], [2.0], [3.5]])


def npy(array):
    out = io.BytesIO()
    numpy.save(out, array)
    return out.getvalue()


def request(cloud, field="2*x", **more):
    return {"inputs": {"cloud": cloud, "field": field}, "outputs": {"laplacian": {}}, **more}


class Real(daemon.Case):
    stub = False
    options = ["--workers", "2"]

    def upload(self, body, kind="application/json", **headers):
        return self.request("POST", "/data", body, {"Content_Type": kind, **headers})

    def apply(self, body, **headers):
        return self.execute(json.dumps(body), APPLY, **headers)

    def laplacian(self, body):
        reply = self.apply(body)
        self.assertEqual(reply.status, 200, reply.body)
        return reply.json["laplacian"]

    def assert_pointer(self, reply, pointer, *words):
        problem = self.assert_problem(reply, 400, *words)
        self.assertIn(pointer, [error["pointer"] for error in problem["errors"]])


class Objects(Real):
    def test_upload_is_content_addressed(self):
        body = json.dumps(POINTS.tolist()).encode()
        first = self.upload(body)
        self.assertEqual(first.status, 201, first.body)
        info = first.json
        self.assertEqual(info["id"], hashlib.sha256(body).hexdigest())
        self.assertEqual(first.headers["Location"], info["href"])
        self.assertTrue(info["href"].endswith("/data/" + info["id"]))
        self.assertEqual((info["size"], info["type"]), (len(body), "application/json"))
        again = self.upload(body)
        self.assertEqual((again.status, again.json["id"]), (200, info["id"]))
        other = self.upload(body.replace(b" ", b""))
        self.assertEqual(other.status, 201)
        self.assertNotEqual(other.json["id"], info["id"])

    def test_every_type_and_coding(self):
        bodies = {"application/json": b"[1, 2]", "application/cbor": b"\x82\x01\x02",
                  "application/x-npy": npy(POINTS), "text/csv": b"x\n1\n2\n"}
        for kind, body in bodies.items():
            for coded in (False, True):
                with self.subTest(kind=kind, coded=coded):
                    headers = {"Content_Encoding": "gzip"} if coded else {}
                    reply = self.upload(gzip.compress(body) if coded else body, kind, **headers)
                    self.assertEqual(reply.status, 200 if coded else 201, reply.body)
                    self.assertEqual(reply.json["id"], hashlib.sha256(body).hexdigest())
                    got = self.get("/data/" + reply.json["id"])
                    self.assertEqual((got.status, got.type, got.body), (200, kind, body))

    def test_refused(self):
        self.assert_problem(self.upload(b"[1, 2"), 400, "JSON")
        self.assert_problem(self.upload(npy(POINTS)[:-1], "application/x-npy"), 400, "npy")
        self.assert_problem(self.upload(b"1,2\n3\n", "text/csv"), 400, "CSV")
        self.assert_problem(self.upload(b"x", "image/png"), 415, "image/png")
        self.assert_problem(self.upload(b"[]", Content_Encoding="br"), 415, "br")
        self.assert_problem(self.upload(b"1\n", "text/csv", Accept="image/png"), 406)
        self.upload(b"7\n", "text/csv")
        self.assert_problem(self.upload(b"7\n"), 409, "text/csv")
        self.assert_problem(self.get("/data/" + "0" * 64), 404)
        self.assert_problem(self.get("/data/../jobs.db"), 404)
        self.assert_problem(self.get("/data/" + "x" * 64), 404)
        self.assert_problem(self.request("PUT", "/data"), 405)

    def test_parts_and_tags(self):
        body = b"x\n" + b"".join(b"%d\n" % k for k in range(9000))
        info = self.upload(body, "text/csv").json
        path = "/data/" + info["id"]
        whole = self.get(path)
        tag = whole.headers["ETag"]
        self.assertEqual(whole.headers["X-Content-Type-Options"], "nosniff")
        self.assertEqual(tag, '"%s"' % info["id"])
        self.assertEqual(whole.headers["Accept-Ranges"], "bytes")
        size = len(body)
        parts = {"bytes=0-0": (0, 1), "bytes=10-19": (10, 20), "bytes=20000-": (20000, size),
                 "bytes=-5": (size - 5, size), "bytes=5-9999999": (5, size),
                 "bytes=0-39999": (0, 40000)}
        for field, (first, last) in parts.items():
            with self.subTest(field=field):
                part = self.get(path, Range=field)
                self.assertEqual(part.status, 206)
                self.assertEqual(part.body, body[first:last])
                self.assertEqual(part.headers["Content-Range"], f"bytes {first}-{last - 1}/{size}")
        for field in ("bytes=a-b", "lines=1-2", "bytes=5-2", "bytes=0-1,4-5", "bytes=1"):
            self.assertEqual(self.get(path, Range=field).status, 200, field)
        outside = self.get(path, Range=f"bytes={size}-")
        self.assert_problem(outside, 416)
        self.assertEqual(outside.headers["Content-Range"], f"bytes */{size}")
        self.assertEqual(self.get(path, Range="bytes=0-1", If_Range=tag).status, 206)
        self.assertEqual(self.get(path, Range="bytes=0-1", If_Range='"x"').status, 200)
        known = self.get(path, If_None_Match=tag)
        self.assertEqual((known.status, known.headers["Content-Length"]), (304, str(size)))
        self.assertEqual(self.get(path, If_None_Match='"x"').status, 200)
        head = self.request("HEAD", path)
        self.assertEqual((head.status, head.body, head.headers["Content-Length"]),
                         (200, b"", str(size)))
        self.assert_problem(self.get(path, Accept="image/png"), 406)

    def test_delete(self):
        path = "/data/" + self.upload(b"[8]").json["id"]
        self.assertEqual(self.request("DELETE", path).status, 204)
        self.assert_problem(self.get(path), 404)
        self.assert_problem(self.request("DELETE", path), 404)
        self.assertEqual(self.upload(b"[8]").status, 201)


class References(Real):
    def setUp(self):
        self.expected = self.laplacian(request({"points": POINTS.tolist()}))
        self.body = json.dumps({"points": POINTS.tolist()}).encode()

    def test_every_type(self):
        field = self.upload(json.dumps((2 * POINTS[:, 0]).tolist())).json["href"]
        for kind, body in {"application/json": self.body, "application/x-npy": npy(POINTS),
                           "text/csv": b"x\n0\n1\n2\n3.5\n"}.items():
            for form in (POINTS, "fortran"):
                with self.subTest(kind=kind):
                    info = self.upload(body, kind).json
                    for href in (info["href"], "/data/" + info["id"]):
                        cloud = {"href": href}
                        self.assertEqual(self.laplacian(request(cloud)), self.expected)
                        self.assertEqual(self.laplacian(request({"value": cloud})), self.expected)
                        self.assertEqual(self.laplacian(request(cloud, {"href": field})),
                                         self.expected)

    def test_other_memory_order_and_number_types(self):
        wide = numpy.asfortranarray(numpy.random.default_rng(3).random((30, 2)))
        for array in (wide, wide.astype(">f8")):
            info = self.upload(npy(array), "application/x-npy").json
            self.assertEqual(self.laplacian(request({"href": info["href"]}, "x*y")),
                             self.laplacian(request({"points": wide.tolist()}, "x*y")))

    def test_data_urls(self):
        text = base64.b64encode(npy(POINTS)).decode()
        for href in ("data:application/json," + self.body.decode().replace(" ", "%20"),
                     "data:application/x-npy;base64," + text):
            self.assertEqual(self.laplacian(request({"href": href})), self.expected)

    def test_results_of_a_job(self):
        job = self.apply(request({"points": POINTS.tolist()}), Prefer="respond-async, wait=30")
        where = job.headers["Content-Location"] or job.headers["Location"] + "/results"
        same = self.apply({"inputs": {"cloud": {"points": POINTS.tolist()},
                                      "field": {"href": where + "/laplacian"}}})
        self.assertEqual(same.status, 200, same.body)
        self.assert_pointer(
            self.apply({"inputs": {"cloud": {"points": POINTS.tolist()},
                                   "field": {"href": where + "/nothing"}}}),
            "/inputs/field/href", "nothing")

    def test_refused(self):
        for href, word in {"/data/" + "0" * 64: "no data", "/data/x": "no data",
                           "/jobs/" + "0" * 32 + "/results/x": "no job",
                           "/nothing": "leads to nothing", "nothing": "leads to nothing",
                           "http://127.0.0.1:1/x": "not allowed",
                           "file:///etc/passwd": "leads to nothing"}.items():
            with self.subTest(href=href):
                self.assert_pointer(self.apply(request({"href": href})), "/inputs/cloud/href", word)

    def test_outputs_by_reference(self):
        wanted = {"laplacian": {"transmissionMode": "reference"},
                  "gradient": {"transmissionMode": "reference",
                               "format": {"mediaType": "application/x-npy"}},
                  "value": {}}
        body = {**request({"points": POINTS.tolist()}), "outputs": wanted}
        reply = self.apply(body)
        self.assertEqual(reply.status, 200, reply.body)
        result = reply.json
        self.assertEqual(len(result["value"]), 4)
        self.assertEqual(result["laplacian"]["type"], "application/json")
        path = result["laplacian"]["href"].split("/", 3)[3]
        self.assertEqual(self.get("/" + path).json, self.expected)
        path = result["gradient"]["href"].split("/", 3)[3]
        self.assertEqual(numpy.load(io.BytesIO(self.get("/" + path).body)).shape, (4, 1))
        del wanted["value"]
        links = self.apply({**body, "response": "raw"})
        self.assertEqual((links.status, links.body), (204, b""))
        self.assertEqual(len(links.headers.get_all("Link")), 2)


class Limits(Real):
    options = ["--workers", "2", "--data-bytes", "1000"]

    def fill(self):
        """The path of what leaves no room for `other`."""
        first = self.upload(json.dumps(list(range(200))))
        self.assertEqual(first.status, 201)
        return "/data/" + first.json["id"]

    def other(self):
        return self.upload(json.dumps(list(range(1, 200))))

    def wait_room(self):
        daemon.wait_until(lambda: self.other().status in (200, 201), "room")

    def test_quota(self):
        path = self.fill()
        self.assert_problem(self.other(), 507, "data-bytes")
        self.assertEqual(self.request("DELETE", path).status, 204)
        self.wait_room()


class Expiring(Limits):
    options = [*Limits.options, "--data-seconds", "1"]

    def test_quota(self):
        path = self.fill()
        daemon.wait_until(lambda: self.get(path).status == 404, "expiry")
        self.wait_room()


class Pinned(Real):
    options = ["--workers", "2", "--data-seconds", "2"]

    def submit(self, pause):
        """An upload and a job that needs it, which has to come before the upload expires."""
        info = self.upload(b'"hello"').json
        body = {"inputs": {"message": {"href": info["href"]}, "pause": pause}}
        job = self.execute(json.dumps(body), "/processes/echo/execution", Prefer="respond-async")
        return (info, "/jobs/" + job.json["jobID"]) if job.status == 201 else None

    def test_a_job_keeps_what_it_needs(self):
        _, short = daemon.wait_until(lambda: self.submit(0), "a job in time")
        daemon.wait_until(lambda: self.get(short).json["status"] == "successful", "its end")
        self.assertEqual(self.get(short + "/results").json["message"], "hello")
        info, path = daemon.wait_until(lambda: self.submit(60), "a job in time")
        self.assert_problem(self.request("DELETE", "/data/" + info["id"]), 409, "job")
        time.sleep(2.5)
        self.assertEqual(self.get("/data/" + info["id"]).status, 200)
        self.assertIn(self.get(path).json["status"], ("accepted", "running"))
        self.assertEqual(self.request("DELETE", path).status, 200)
        daemon.wait_until(lambda: self.get("/data/" + info["id"]).status == 404, "expiry")


ASKED, OVER = threading.Event(), threading.Event()  # /slow was asked for; may be answered


class Elsewhere(http.server.BaseHTTPRequestHandler):
    """Another host with files, and traps."""

    def do_GET(self):
        replies = {"/points.npy": (200, "application/x-npy", npy(POINTS)),
                   "/points.csv": (200, "text/csv; charset=utf-8", b"x\n0\n1\n2\n3.5\n"),
                   "/page": (200, "text/html", b"<html>"),
                   "/large": (200, "application/json", b"[" + b"1," * 60000 + b"1]"),
                   "/moved": (302, "text/plain", b"")}
        if self.path == "/slow":
            ASKED.set()
            OVER.wait(daemon.PATIENCE)
        status, kind, body = replies.get(self.path, (404, "text/plain", b""))
        self.send_response(status)
        self.send_header("Content-Type", kind)
        self.send_header("Content-Length", str(len(body)))
        if status == 302:
            self.send_header("Location", "/points.npy")
        with contextlib.suppress(ConnectionError):  # who has had enough hangs up
            self.end_headers()
            self.wfile.write(body)

    def log_message(self, *_):
        pass


class OtherHosts(Real):
    @classmethod
    def setUpClass(cls):
        cls.server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Elsewhere)
        threading.Thread(target=cls.server.serve_forever, daemon=True).start()
        port = cls.server.server_address[1]
        cls.base = f"http://127.0.0.1:{port}"
        cls.private = f"http://localhost:{port}"
        cls.options = ["--workers", "2", "--fetch-hosts", f"127.0.0.1:{port} localhost:{port}",
                       "--fetch-private-hosts", f"127.0.0.1:{port}", "--fetch-bytes", "100000",
                       "--fetch-seconds", "5"]
        super().setUpClass()

    @classmethod
    def tearDownClass(cls):
        OVER.set()
        super().tearDownClass()
        cls.server.shutdown()
        cls.server.server_close()

    def test_fetched(self):
        expected = self.laplacian(request({"points": POINTS.tolist()}))
        for name in ("points.npy", "points.csv"):
            self.assertEqual(self.laplacian(request({"href": f"{self.base}/{name}"})), expected)

    def test_refused(self):
        for url, word in {f"{self.base}/none": "status 404", f"{self.base}/moved": "status 302",
                          f"{self.base}/page": "text/html", f"{self.base}/large": "bytes",
                          f"{self.base}/slow": "cannot be fetched",
                          f"{self.private}/points.npy": "public",
                          "http://127.0.0.1:1/points.npy": "not allowed",
                          f"http://user@127.0.0.1:{self.server.server_address[1]}/points.npy":
                              "not allowed"}.items():
            with self.subTest(url=url):
                self.assert_pointer(self.apply(request({"href": url})), "/inputs/cloud/href", word)

    def test_client_leaves_while_waiting(self):
        body = json.dumps(request({"href": f"{self.base}/slow"}))
        ASKED.clear()
        with self.daemon.raw() as plain:
            plain.sendall((f"POST {APPLY} HTTP/1.1\r\nHost: x\r\nContent-Length: {len(body)}\r\n\r\n"
                           + body).encode())
            self.assertTrue(ASKED.wait(daemon.PATIENCE))
        self.assertEqual(self.get("/healthz").status, 200)
        self.assertEqual(self.laplacian(request({"points": POINTS.tolist()})),
                         self.laplacian(request({"href": f"{self.base}/points.npy"})))


if __name__ == "__main__":
    unittest.main()
