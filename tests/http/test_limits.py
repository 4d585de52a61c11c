"""Each limit of one request, and of all together: what is just within it is served, what is beyond
it gets the status that server/SECURITY.md has for it, and the daemon goes on."""

import ctypes
import gzip
import json
import threading
import time
import unittest

import daemon

SOLVE = "/processes/solve/execution"
APPLY = "/processes/apply/execution"
JSON = {"Content-Type": "application/json"}
DROPS, PAUSE = 200, 0.2
ASYNC = {**JSON, "Prefer": "respond-async"}


def lattice(*cells):
    return {"lattice": {"lower": [0] * len(cells), "upper": [1] * len(cells),
                        "cells": list(cells)}}


def apply(cells, field=1, **operator):
    inputs = {"cloud": lattice(cells, cells), "field": field}
    if operator:
        inputs["operator"] = operator
    return json.dumps({"inputs": inputs, "outputs": {"value": {}}})


def zstd(data):
    """Compressed, by the library that the daemon uses."""
    library = ctypes.CDLL("libzstd.so.1")
    library.ZSTD_compressBound.restype = library.ZSTD_compress.restype = ctypes.c_size_t
    library.ZSTD_compressBound.argtypes = [ctypes.c_size_t]
    library.ZSTD_compress.argtypes = [ctypes.c_char_p, ctypes.c_size_t, ctypes.c_char_p,
                                      ctypes.c_size_t, ctypes.c_int]
    room = ctypes.create_string_buffer(library.ZSTD_compressBound(len(data)))
    size = library.ZSTD_compress(room, len(room), data, len(data), 3)
    return room.raw[:size]


class OneRequest(daemon.Case):
    stub = False
    options = ["--workers", "2", "--decoded-bytes", "1MiB", "--depth", "10", "--nodes", "500",
               "--points", "1000", "--neighbours", "30", "--expression-bytes", "50",
               "--expression-work", "2000", "--steps", "100", "--header-bytes", "4KiB",
               "--seconds", "6", "--job-seconds", "6", "--batch-parts", "3", "--body-bytes",
               "300000"]

    def post(self, body, path=APPLY, **headers):
        return self.request("POST", path, body, {**JSON, **headers})

    def both(self, good, bad, status, *words, path=APPLY):
        """The one is served, the other refused: at once, and before it becomes a job."""
        self.assertEqual(self.post(good, path).status, 200)
        self.assert_problem(self.post(bad, path), status)
        refused = self.post(bad, path, Prefer="respond-async")
        problem = self.assert_problem(refused, status)
        text = problem["detail"] + "".join(e["detail"] for e in problem.get("errors", []))
        for word in words:
            self.assertIn(word, text)

    def test_body_bytes(self):
        within = apply(3).encode().ljust(300000)
        self.assertEqual(self.post(within).status, 200)
        self.assert_problem(self.post(within + b" "), 413, "body-bytes")

    def test_decoded_bytes(self):
        for coding, pack in (("gzip", gzip.compress), ("zstd", zstd)):
            with self.subTest(coding):
                within = pack(apply(3).encode().ljust(1 << 20))
                self.assertEqual(self.post(within, Content_Encoding=coding).status, 200)
                bomb = pack(apply(3).encode().ljust(200 << 20))
                self.assertLess(len(bomb), 300000)
                began = time.monotonic()
                self.assert_problem(self.post(bomb, Content_Encoding=coding), 413, "1048576")
                self.assert_problem(self.request("POST", "/data", bomb, {
                    **JSON, "Content-Encoding": coding}), 413)
                self.assertLess(time.monotonic() - began, daemon.PATIENCE)
        twice = gzip.compress(gzip.compress(apply(3).encode()))
        self.assert_problem(self.post(twice, Content_Encoding="gzip, gzip"), 415)

    def test_depth(self):
        def nested(levels):
            return apply(3)[:-1] + ',"x":' + (levels - 1) * "[" + (levels - 1) * "]" + "}"
        self.both(nested(10), nested(11), 413, "10")
        deep = self.post(300000 * "[")
        self.assert_problem(deep, 413)
        cbor = self.post(b"\xa1\x61x" + 200000 * b"\x81", Content_Type="application/cbor")
        self.assert_problem(cbor, 413)

    def test_nodes(self):
        def many(count):
            return apply(3)[:-1] + ',"x":[' + ",".join(count * ['""']) + "]}"
        self.both(many(400), many(600), 413, "500")

    def test_points(self):
        self.both(apply(30), apply(31), 400, "1024 points", "1000")
        posted = {"inputs": {"cloud": {"points": [[k / 1001, 0.5] for k in range(1001)]},
                             "field": 1}}
        self.assert_problem(self.post(json.dumps(posted)), 400)

    def test_neighbours(self):
        self.assertEqual(self.post(apply(8, radius=2.1)).status, 200)
        self.assert_problem(self.post(apply(8, radius=5.1)), 422, "neighbours")

    def test_expression_bytes(self):
        self.both(apply(3, "x".ljust(50)), apply(3, "x".ljust(51)), 400, "50")

    def test_expression_work(self):
        self.both(apply(30, "x+1+2"), apply(30, "x+1+2+3"), 400, "3 operations", "961 points",
                  "2000")

    def test_steps(self):
        def march(step):
            return json.dumps({"inputs": {
                "cloud": lattice(6, 6), "diffusivity": 1, "initial": 0,
                "boundary": [{"on": "boundary", "type": "dirichlet", "value": 1}],
                "time": {"method": "backward-euler", "end": 1, "step": step}},
                "outputs": {"solution": {}}})
        self.assertEqual(self.post(march(0.01), SOLVE).status, 200)
        for step in (0.0099, 1e-300):
            reply = self.post(march(step), SOLVE)
            self.assertEqual(reply.status, 422, reply.body)
            self.assertIn(b"100", reply.body)

    def test_seconds(self):
        def pause(seconds):
            return json.dumps({"inputs": {"message": "", "pause": seconds}})
        echo = "/processes/echo/execution"
        self.assertEqual(self.post(pause(0.1), echo).status, 200)
        self.assert_problem(self.post(pause(30), echo), 504, "6 s")
        made = self.post(pause(31), echo, Prefer="respond-async").json["jobID"]
        daemon.wait_until(lambda: self.get("/jobs/" + made).json["status"] == "failed", "the end")
        self.assert_problem(self.get(f"/jobs/{made}/results"), 504, "job-seconds")

    def test_batch_parts(self):
        def batch(count):
            return json.dumps({"inputs": {"requests": count * [
                {"process": "echo", "inputs": {"message": ""}}]}})
        path = "/processes/batch/execution"
        self.assertEqual(self.post(batch(3), path).status, 201)
        self.assert_problem(self.post(batch(4), path), 422, "batch-parts")

    def test_header_bytes(self):
        self.assertEqual(self.get("/healthz?" + 1900 * "x").status, 200)
        self.assert_problem(self.get("/healthz?" + 2100 * "x"), 414, "header-bytes")
        self.assertEqual(self.get("/healthz", X=3000 * "x").status, 200)
        self.assert_problem(self.get("/healthz", X=4500 * "x"), 431, "header-bytes")
        huge = self.exchange(b"GET / HTTP/1.1\r\nHost: a\r\nX: " + 1000000 * b"x" + b"\r\n\r\n")
        self.assertRegex(huge, rb"^(HTTP/1\.1 431 |$)")
        many = self.exchange(b"GET / HTTP/1.1\r\nHost: a\r\n" + 20000 * b"X: y\r\n" + b"\r\n")
        self.assertRegex(many, rb"^(HTTP/1\.1 431 |$)")


class Memory(daemon.Case):
    stub = False
    options = ["--workers", "1", "--memory-bytes", "512MiB"]

    def solve(self, cells):
        return json.dumps({"inputs": {
            "cloud": lattice(cells, cells), "diffusivity": 1, "solver": {"method": "direct"},
            "boundary": [{"on": "boundary", "type": "dirichlet", "value": 1}]},
            "outputs": {"solution": {}, "report": {}}})

    def test_memory_bytes(self):
        for headers in (JSON, ASYNC):
            reply = self.request("POST", SOLVE, self.solve(700), headers)
            self.assert_problem(reply, 422, "memory-bytes")
        self.assertEqual(self.execute(json.dumps({"inputs": {
            "cloud": lattice(8, 8), "diffusivity": 1, "boundary": [
                {"on": "boundary", "type": "dirichlet", "value": 1}]}})).status, 200)


class Disk(daemon.Case):
    options = ["--workers", "1", "--job-bytes", "300000", "--data-bytes", "1000"]

    def test_job_bytes(self):
        body = "sleep 0 ".ljust(100000)
        made = []
        for k in range(10):
            reply = self.request("POST", SOLVE, f"{body}{k}", ASYNC)
            if reply.status != 201:
                break
            made.append("/jobs/" + reply.json["jobID"])
        self.assert_problem(reply, 507, "job-bytes")
        self.assertLess(len(made), 4)
        self.assertEqual(self.execute("small and at once").status, 200)
        for job in made:
            daemon.wait_until(lambda job=job: self.get(job).json["status"] in
                              ("successful", "failed"), job)
            self.assertEqual(self.request("DELETE", job).status, 200)
        daemon.wait_until(lambda: self.request("POST", SOLVE, f"{body}x", ASYNC).status == 201,
                          "room again")

    def test_a_result_beyond_it(self):
        def fails():
            reply = self.request("POST", SOLVE, "big 400000", {**ASYNC,
                                                               "Cache-Control": "no-cache"})
            if reply.status == 507:
                return False  # not yet
            job = "/jobs/" + reply.json["jobID"]
            daemon.wait_until(lambda: self.get(job).json["status"] == "failed", "failure")
            self.assert_problem(self.get(job + "/results"), 507)
            return True
        daemon.wait_until(fails, "room for the request")

    def test_data_bytes(self):
        self.assertEqual(self.request("POST", "/data", json.dumps(900 * "a"), JSON).status, 201)
        self.assert_problem(self.request("POST", "/data", json.dumps(200 * "b"), JSON), 507,
                            "data-bytes")


class Slow(daemon.Case):
    """Clients that hold connections: by a byte now and then, by nothing, by not reading."""

    options = ["--workers", "2", "--connections", "40", "--receive-seconds", "1",
               "--idle-seconds", "1", "--receive-rate", "1000"]

    def drip(self, first, pieces, held):
        """Sends pieces, as long as the daemon lets it; how long that was."""
        began = time.monotonic()
        with self.daemon.raw() as plain:
            held.release()
            try:
                plain.sendall(first)
                for piece in pieces:
                    time.sleep(PAUSE)
                    plain.sendall(piece)
            except OSError:
                pass
            daemon.read_all(plain)
        return time.monotonic() - began

    def crowd(self, first, *pieces):
        """40 of them, and somebody who is served in spite of them."""
        held, lasted = threading.Semaphore(0), []
        threads = [threading.Thread(target=lambda: lasted.append(
            self.drip(first, pieces, held))) for _ in range(40)]
        for thread in threads:
            thread.start()
        for _ in threads:
            held.acquire()
        self.assertEqual(self.execute("served").body, b"served")
        for thread in threads:
            thread.join()
        self.assertLess(max(lasted), DROPS * PAUSE)  # which all drops would take at least

    def test_headers(self):
        self.crowd(b"GET / HTTP/1.1\r\nHost: a\r\n", *DROPS * [b"X: y\r\n"])

    def test_request_lines(self):
        self.crowd(b"GET /", *DROPS * [b"x"])

    def test_bodies(self):
        self.crowd(f"POST {daemon.EXECUTE} HTTP/1.1\r\nHost: a\r\nContent-Type: application/json"
                   "\r\nContent-Length: 100000\r\n\r\n".encode(), *DROPS * [b"x"])

    def test_chunks(self):
        self.crowd(f"POST {daemon.EXECUTE} HTTP/1.1\r\nHost: a\r\nContent-Type: application/json"
                   "\r\nTransfer-Encoding: chunked\r\n\r\n".encode(),
                   *DROPS * [b"1\r\nx\r\n"])

    def test_silence(self):
        self.crowd(b"")


if __name__ == "__main__":
    unittest.main()
