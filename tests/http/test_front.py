"""Routes, negotiation, links, and what every reply has."""

import gzip
import json
import unittest

import daemon

OGC = "http://www.opengis.net/def/exceptions/ogcapi-processes-1/1.0/"
OPENAPI = "application/vnd.oai.openapi+json;version=3.0"
DOCUMENTS = ["/", "/api", "/conformance", "/processes", "/processes/solve", "/processes/echo",
             "/healthz", "/readyz"]


class Documents(daemon.Case):

    def test_each_is_json_without_an_accept_field(self):
        for path in DOCUMENTS:
            with self.subTest(path):
                reply = self.get(path)
                self.assertEqual(reply.status, 200)
                self.assertEqual(reply.type, OPENAPI if path == "/api" else "application/json")
                self.assertIsInstance(reply.json, dict)

    def test_head_is_get_without_the_body(self):
        for path in DOCUMENTS + ["/nothing"]:
            with self.subTest(path):
                get, head = self.get(path), self.request("HEAD", path)
                self.assertEqual(head.status, get.status)
                self.assertEqual(head.type, get.type)
                self.assertEqual(head.headers["Content-Length"], get.headers["Content-Length"])
                self.assertEqual(head.body, b"")

    def test_landing_page_for_a_browser(self):
        reply = self.get("/", Accept="text/html,application/xhtml+xml,*/*;q=0.8")
        self.assertEqual(reply.type, "text/html; charset=utf-8")
        # the dashboard, or without Node at build time the plain page
        self.assertRegex(reply.body, b'href="[^"]*(api|/processes)"')

    def test_api_for_reading(self):
        self.assertEqual(self.get("/api", Accept="application/json").type, "application/json")
        page = self.get("/api", Accept="text/html")
        self.assertEqual(page.type, "text/html; charset=utf-8")
        self.assertIn("default-src 'none'", page.headers["Content-Security-Policy"])
        self.assertEqual(page.headers["X-Content-Type-Options"], "nosniff")

    def test_links_are_absolute_by_the_host_used(self):
        links = self.get("/").json["links"]
        self.assertTrue(links)
        for link in links:
            self.assertTrue(link["href"].startswith(f"http://{self.daemon.address}/"), link)
            self.assertTrue(link["rel"] and link["type"])
        other = self.get("/", Host="solver.example:8000").json["links"]
        self.assertTrue(all(x["href"].startswith("http://solver.example:8000/") for x in other))
        self.assertNotIn(b"{B}", self.get("/api").body)

    def test_links_without_a_host(self):
        reply = self.exchange(b"GET / HTTP/1.0\r\n\r\n")
        self.assertIn(f"http://{self.daemon.address}/".encode(), reply)

    def test_host_is_checked(self):
        for host in [b"", b"Host: a b\r\n", b'Host: a"b\r\n', b"Host: a/b\r\n", b"Host: a:b\r\n",
                     b"Host: [::1\r\n", b"Host: a\r\nHost: a\r\n", b"Host:\r\n"]:
            with self.subTest(host):
                reply = self.exchange(b"GET / HTTP/1.1\r\nConnection: close\r\n" + host + b"\r\n")
                self.assertTrue(reply.startswith(b"HTTP/1.1 400 "), reply)
                self.assertIn(b"application/problem+json", reply)
        for host in ["[::1]:80", "a-b.example", "127.0.0.1"]:
            self.assertEqual(self.get("/", Host=host).status, 200)

    def test_packed_where_that_is_asked_for_and_worth_it(self):
        for path in ("/api", "/processes", "/processes/solve"):
            with self.subTest(path):
                plain = self.get(path)
                packed = self.get(path, Accept_Encoding="gzip")
                self.assertEqual(packed.headers["Content-Encoding"], "gzip")
                self.assertEqual(gzip.decompress(packed.body), plain.body)
                self.assertLess(len(packed.body), len(plain.body) / 2)
                self.assertEqual(packed.type, plain.type)
                best = self.get(path, Accept_Encoding="gzip, zstd;q=1")
                self.assertEqual(best.headers["Content-Encoding"], "zstd")
                self.assertEqual(best.body[:4], b"\x28\xb5\x2f\xfd")
                head = self.request("HEAD", path, headers={"Accept_Encoding": "gzip"})
                self.assertEqual(head.headers["Content-Length"], str(len(packed.body)))
                for reply in (plain, packed, best, head):
                    self.assertIn("Accept-Encoding", reply.headers.get_all("Vary"))
        metrics = self.get("/metrics", Accept_Encoding="gzip")
        self.assertIn(b"# TYPE", gzip.decompress(metrics.body))

    def test_as_it_is_where_packing_is_not_asked_for(self):
        for path, field in (("/api", "identity"), ("/api", "*"), ("/api", "br"), ("/api", ""),
                            ("/api", "gzip;q=0"), ("/api", "*;q=0"), ("/healthz", "gzip"),
                            ("/conformance", "gzip"), ("/nothing", "gzip")):
            with self.subTest(path=path, field=field):
                reply = self.get(path, Accept_Encoding=field)
                self.assertNotIn("Content-Encoding", reply.headers)
                self.assertIsInstance(reply.json, dict)

    def test_limit_of_processes(self):
        everything = self.get("/processes").json["processes"]
        self.assertGreater(len(everything), 1)
        for limit in (1, len(everything), 10000):
            some = self.get(f"/processes?limit={limit}").json
            self.assertEqual(some["processes"], everything[:limit])
            self.assertIn("links", some)
        for limit in ("0", "-1", "10001", "x", "1x", "", "1e1", "99999999999999999999"):
            with self.subTest(limit):
                self.assert_problem(self.get(f"/processes?limit={limit}"), 400, "limit")

    def test_paths(self):
        self.assertEqual(self.get("/processes/%73olve").json["id"], "solve")
        self.assertEqual(self.get("/healthz?x=1").status, 200)
        for path in ["/processes/", "/processes/solve/", "/processes//execution", "//", "/healthzz",
                     "/processes/solve/execution/x", "/processes/" + 100 * "a", "/job",
                     "/processes%2Fsolve", "/processes/solve%2Fexecution"]:
            with self.subTest(path):
                self.assert_problem(self.get(path), 404)
        for path in ["/processes/solve%00", "/%", "/%4", "/%zz"]:
            with self.subTest(path):
                self.assert_problem(self.get(path), 400, "target")

    def test_absolute_target(self):
        reply = self.exchange(b"GET http://solver.example/healthz HTTP/1.1\r\nHost: solver.example"
                              b"\r\nConnection: close\r\n\r\n")
        self.assertTrue(reply.startswith(b"HTTP/1.1 200 "), reply)

    def test_no_such_process(self):
        for reply in (self.get("/processes/nothing" + 300 * "x"), self.get("/processes/nothing%2F"),
                      self.get("/processes/nothing"),
                      self.execute("{}", "/processes/nothing/execution")):
            problem = self.assert_problem(reply, 404, "nothing")
            self.assertEqual(problem["type"], OGC + "no-such-process")

    def test_not_acceptable(self):
        for path in ["/", "/api", "/conformance", "/processes", "/processes/solve"]:
            self.assert_problem(self.get(path, Accept="image/png"), 406, "image/png")
        self.assertEqual(self.get("/", Accept="application/*;q=0.1").status, 200)
        self.assert_problem(self.get("/conformance", Accept="application/json;q=0"), 406)

    def test_methods(self):
        for method, path, allow in [("POST", "/", "GET, HEAD, OPTIONS"),
                                    ("DELETE", "/processes/solve", "GET, HEAD, OPTIONS"),
                                    ("GET", daemon.EXECUTE, "POST, OPTIONS"),
                                    ("HEAD", daemon.EXECUTE, "POST, OPTIONS"),
                                    ("BREW", "/healthz", "GET, HEAD, OPTIONS"),
                                    ("get", "/healthz", "GET, HEAD, OPTIONS")]:
            with self.subTest(method=method, path=path):
                reply = self.request(method, path)
                self.assertEqual(reply.status, 405)
                self.assertEqual(reply.headers["Allow"], allow)
                if method != "HEAD":
                    self.assert_problem(reply, 405, method)

    def test_options(self):
        reply = self.request("OPTIONS", daemon.EXECUTE)
        self.assertEqual(reply.status, 204)
        self.assertEqual(reply.headers["Allow"], "POST, OPTIONS")
        self.assertIsNone(reply.headers["Access-Control-Allow-Origin"])
        self.assertEqual(self.request("OPTIONS", "*").status, 204)
        self.assertEqual(self.request("OPTIONS", "/nothing").status, 404)

    def test_problems_as_plain_json(self):
        self.assertEqual(self.get("/x", Accept="application/json").type, "application/json")
        self.assertEqual(self.get("/x", Accept="application/json, application/problem+json").type,
                         "application/problem+json")
        self.assertEqual(self.get("/x", Accept="*/*").type, "application/problem+json")
        self.assertEqual(self.execute("problem", Accept="application/json").type,
                         "application/json")

    def test_request_id(self):
        self.assertEqual(self.get("/", X_Request_Id="run-7.a_B").headers["X-Request-Id"],
                         "run-7.a_B")
        made = {self.get("/healthz").headers["X-Request-Id"] for _ in range(3)}
        self.assertEqual(len(made), 3)
        for bad in ["a b", 'a"b', "x" * 65, "", "ä"]:
            self.assertNotEqual(self.get("/", X_Request_Id=bad).headers["X-Request-Id"], bad)

    def test_log_line(self):
        self.execute("abc", X_Request_Id="logged-1")
        line = self.daemon.wait_for_log("id=logged-1 .*").group(0)
        self.assertRegex(line, r"^id=logged-1 peer=127\.0\.0\.1 method=POST target=" +
                         daemon.EXECUTE + r" status=200 in=3 out=3 ms=[\d.]+ process=solve "
                         r"worker=\d+ run_ms=[\d.]+$")
        self.get('/x"y?a=%0a', X_Request_Id="logged-2")
        line = self.daemon.wait_for_log("id=logged-2 .*").group(0)
        self.assertIn(r'target="/x\"y?a=%0a" status=404', line)

    def test_get_with_a_body(self):
        self.assertEqual(self.request("GET", "/healthz", b"x" * 1000).status, 200)


class Execution(daemon.Case):

    def test_body_comes_back(self):
        for size in (0, 1, 1000, 16384, 16385, 1000000):
            body = bytes(k * 7 % 251 for k in range(size))
            reply = self.execute(b"#" + body)
            self.assertEqual((reply.status, reply.type), (200, "application/json"))
            self.assertEqual(reply.body, b"#" + body)
            self.assertEqual(reply.headers["Content-Length"], str(size + 1))

    def test_empty_body_and_empty_reply(self):
        self.assertEqual(self.execute(b"").body, b"")
        self.assertEqual(self.execute("nothing").body, b"")

    def test_without_length(self):
        reply = self.exchange(b"POST " + daemon.EXECUTE.encode() +
                              b" HTTP/1.1\r\nHost: a\r\nConnection: close\r\n\r\n")
        self.assertTrue(reply.startswith(b"HTTP/1.1 411 "), reply)

    def test_media_types(self):
        for sent, wanted, got in [("application/json", None, "application/json"),
                                  ("application/json; charset=UTF-8", "*/*", "application/json"),
                                  ("APPLICATION/CBOR", "application/cbor", "application/cbor"),
                                  ("application/json", "application/cbor, application/json;q=0.9",
                                   "application/cbor"),
                                  ("application/cbor", "text/html, application/*;q=0.1",
                                   "application/json")]:
            with self.subTest(sent=sent, wanted=wanted):
                headers = {"Content_Type": sent, **({"Accept": wanted} if wanted else {})}
                reply = self.execute("x", **headers)
                self.assertEqual((reply.status, reply.type), (200, got))

    def test_type_may_be_left_out(self):
        reply = self.request("POST", daemon.EXECUTE, b"x")
        self.assertEqual(reply.status, 200)

    def test_unsupported_media_type(self):
        for sent in ["text/plain", "application/x-www-form-urlencoded", "application/json;charset="
                     "latin1", "application/json, application/json", "nonsense", ""]:
            with self.subTest(sent):
                reply = self.execute("x", Content_Type=sent)
                self.assert_problem(reply, 415, "Content-Type")
                self.assertEqual(reply.headers["Accept"], "application/json, application/cbor")

    def test_codings(self):
        reply = self.execute("x", Content_Encoding="gzip")
        self.assertEqual(reply.headers["Content-Encoding"], "gzip")
        reply = self.execute("x", Content_Encoding="br")
        self.assert_problem(reply, 415, "br")
        self.assertEqual(reply.headers["Accept-Encoding"], "gzip, zstd")
        self.assert_problem(self.execute("x", Accept_Encoding="identity;q=0"), 406)

    def test_not_acceptable(self):
        self.assert_problem(self.execute("x", Accept="image/png"), 406, "image/png")

    def test_other_preferences_stay_synchronous(self):
        reply = self.execute("x", Prefer='wait=10; foo="a,b", unknown, respond-asynchronously')
        self.assertEqual(reply.status, 200)
        self.assertIsNone(reply.headers["Preference-Applied"])

    def test_problem_of_the_worker(self):
        problem = self.assert_problem(self.execute("problem"), 422, "singular")
        self.assertEqual(problem["errors"][0]["pointer"], "/inputs/boundary")

    def test_no_link_field(self):
        self.assertIsNone(self.execute("x").headers["Link"])


class Origins(daemon.Case):
    options = ["--cors-origins", "https://a.example, https://b.example:8443"]

    def test_listed(self):
        for origin in ("https://a.example", "https://b.example:8443"):
            reply = self.get("/healthz", Origin=origin)
            self.assertEqual(reply.headers["Access-Control-Allow-Origin"], origin)
            self.assertIn("Origin", reply.headers["Vary"])

    def test_not_listed(self):
        for origin in ("https://c.example", "https://a.example.evil", "https://a.exampl", "null"):
            reply = self.get("/healthz", Origin=origin)
            self.assertEqual(reply.status, 200)
            self.assertIsNone(reply.headers["Access-Control-Allow-Origin"])

    def test_preflight(self):
        reply = self.request("OPTIONS", daemon.EXECUTE, headers={
            "Origin": "https://a.example", "Access_Control_Request_Method": "POST"})
        self.assertEqual(reply.status, 204)
        self.assertEqual(reply.headers["Access-Control-Allow-Origin"], "https://a.example")
        self.assertIn("POST", reply.headers["Access-Control-Allow-Methods"])
        self.assertIn("Content-Type", reply.headers["Access-Control-Allow-Headers"])

    def test_refusals_too(self):
        reply = self.execute("x", Origin="https://a.example", Content_Type="text/plain")
        self.assertEqual(reply.status, 415)
        self.assertEqual(reply.headers["Access-Control-Allow-Origin"], "https://a.example")


class PublicUrl(daemon.Case):
    options = ["--public-url", "https://solve.example/pde/", "--cors-origins", "*"]

    def test_links(self):
        for link in self.get("/").json["links"]:
            self.assertRegex(link["href"], r"^https://solve\.example/pde/([a-z]|$)")

    def test_any_origin(self):
        reply = self.get("/healthz", Origin="http://x.example")
        self.assertEqual(reply.headers["Access-Control-Allow-Origin"], "http://x.example")


class UnixSocket(daemon.Case):
    unix = True

    def test_serves(self):
        self.assertTrue(self.daemon.address.startswith("unix:"))
        self.assertEqual(self.execute("abc").body, b"abc")
        self.assertEqual(self.get("/").json["links"][0]["href"], "http://localhost/")

    def test_socket_in_use(self):
        with self.assertRaisesRegex(AssertionError, "Address already in use"):
            daemon.Daemon("--listen", "unix:" + self.daemon.socket)


class Documentation(daemon.Case):

    def test_served_json_is_what_the_list_says(self):
        for process in self.get("/processes").json["processes"]:
            description = self.get("/processes/" + process["id"]).json
            self.assertEqual(description["id"], process["id"])
            self.assertEqual(json.dumps(description).count("{B}"), 0)


if __name__ == "__main__":
    unittest.main()
