"""The page for browsers, as bytes and header fields; what it does is tested in tests/browser. A build
without Node has a plain page in its place, which says so."""

import gzip
import re
import unittest

import daemon

BROWSER = "text/html,application/xhtml+xml,application/xml;q=0.9,*/*;q=0.8"


class Page(daemon.Case):
    stub = False

    def setUp(self):
        self.page = self.get("/", Accept=BROWSER)
        self.assertEqual(self.page.status, 200)
        self.assertEqual(self.page.type, "text/html; charset=utf-8")
        self.there = self.page.headers["ETag"] is not None

    def assets(self):
        if not self.there:
            self.skipTest("built without the dashboard")
        return re.findall(r'(?:src|href)="\./(assets/[^"]+)"', self.page.body.decode())

    def test_without(self):
        if self.there:
            self.skipTest("built with the dashboard")
        self.assertIn(b"built without its dashboard", self.page.body)
        self.assert_problem(self.get("/assets/index.js"), 404)

    def test_page_is_checked_every_time(self):
        self.assets()
        self.assertEqual(self.page.headers["Cache-Control"], "no-cache")
        etag = self.page.headers["ETag"]
        for known in (etag, f"W/{etag}", f'"other", {etag}', "*"):
            again = self.get("/", Accept=BROWSER, If_None_Match=known)
            self.assertEqual((again.status, again.body), (304, b""), known)
            self.assertEqual(again.headers["ETag"], etag)
            self.assertEqual(again.headers["Content-Length"], str(len(self.page.body)))
        self.assertEqual(self.get("/", Accept=BROWSER, If_None_Match='"other"').status, 200)

    def test_policy(self):
        self.assets()
        policy = dict(part.strip().split(" ", 1)
                      for part in self.page.headers["Content-Security-Policy"].split(";"))
        self.assertEqual(policy["default-src"], "'none'")
        self.assertEqual(policy["script-src"], "'self'")
        self.assertEqual(policy["style-src"], "'self'")
        self.assertNotIn("unsafe", str(policy))
        self.assertNotIn(b"<style", self.page.body)
        self.assertIsNone(re.search(rb"<script(?![^>]*src=)", self.page.body))

    def test_assets_stay(self):
        found = self.assets()
        self.assertGreaterEqual(len(found), 3)
        for path in found:
            with self.subTest(path=path):
                packed = self.get(f"/{path}", Accept_Encoding="gzip, deflate, br")
                plain = self.get(f"/{path}", Accept_Encoding="gzip;q=0")
                self.assertEqual(packed.headers["Content-Encoding"], "gzip")
                self.assertIsNone(plain.headers["Content-Encoding"])
                self.assertEqual(gzip.decompress(packed.body), plain.body)
                self.assertIn("immutable", plain.headers["Cache-Control"])
                self.assertEqual(plain.headers["X-Content-Type-Options"], "nosniff")
                self.assertIn("Accept-Encoding", plain.headers["Vary"])
                head = self.request("HEAD", f"/{path}")
                self.assertEqual((head.status, head.body), (200, b""))

    def test_what_is_not_there(self):
        for path in ("/assets/nothing.js", "/assets/index.html", "/assets/..%2Findex.html"):
            self.assert_problem(self.get(path), 404)
        self.assertEqual(self.request("POST", "/assets/x", b"").status, 405)


if __name__ == "__main__":
    unittest.main()
