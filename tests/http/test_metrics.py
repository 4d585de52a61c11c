#!/usr/bin/env python3
"""http.metrics: GET /metrics is what Prometheus takes and says what happened; GET /readyz means
it; the Grafana dashboard asks only for what there is."""

import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import threading
import unittest

sys.dont_write_bytecode = True
import daemon  # noqa: E402
import prometheus  # noqa: E402

ROOT = pathlib.Path(__file__).resolve().parents[2]
SOLVE = json.dumps({"inputs": {
    "cloud": {"lattice": {"lower": [0, 0], "upper": [1, 1], "cells": [30, 30]}}, "diffusivity": 1,
    "boundary": [{"on": "boundary", "type": "dirichlet", "value": 0}], "source": 1}})


class Case(daemon.Case):
    def metrics(self):
        reply = self.get("/metrics")
        self.assertEqual(reply.status, 200)
        self.assertEqual(reply.type, "text/plain; version=0.0.4; charset=utf-8")
        return prometheus.parse(reply.body.decode())

    def wait_for(self, name, value, **labels):
        daemon.wait_until(lambda: self.metrics()[name].value(**labels) == value, f"{name} {value}")


class Metrics(Case):
    stub = False

    def test_promtool_agrees(self):
        text = self.get("/metrics").body
        if shutil.which("promtool") is None:
            self.skipTest("promtool is not installed; prometheus.py checks the same rules")
        done = subprocess.run(["promtool", "check", "metrics"], input=text, capture_output=True)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    def test_another_reader_agrees(self):
        from prometheus_client.parser import text_string_to_metric_families
        text = self.get("/metrics").body.decode()
        theirs = {}
        for family in text_string_to_metric_families(text):
            for sample in family.samples:
                theirs[(sample.name, tuple(sorted(sample.labels.items())))] = sample.value
        ours = {(name, tuple(sorted(labels.items()))): value
                for family in prometheus.parse(text).values()
                for name, labels, value in family.samples}
        self.assertEqual(ours, theirs)
        self.assertGreater(len(ours), 30)

    def test_requests_are_counted(self):
        before = self.metrics()["scatterd_http_requests_total"]
        for _ in range(3):
            self.get("/processes/solve")
        self.get("/processes/nowhere")
        self.get("/no/such/path?q=1")
        self.request("BREW", "/healthz")
        self.request("HEAD", "/healthz")
        after = self.metrics()["scatterd_http_requests_total"]

        def more(**labels):
            return after.value(**labels) - before.value(**labels)
        self.assertEqual(more(route="/processes/{}", method="GET", status="200"), 3)
        self.assertEqual(more(route="/processes/{}", method="GET", status="404"), 1)
        self.assertEqual(more(route="none", method="GET", status="404"), 1)
        self.assertEqual(more(method="other", status="405"), 1)
        self.assertEqual(more(route="/healthz", method="HEAD", status="200"), 1)
        self.assertEqual(more(route="/metrics"), 1)

    def test_labels_come_from_closed_sets(self):
        """No client makes a series: neither by its path, its method nor its process."""
        for k in range(30):
            self.get(f"/processes/x{k}")
            self.get(f"/x{k}")
            self.request("POST", f"/processes/x{k}/execution", "{}")
            self.request(f"METHOD{k}", "/")
        text = self.get("/metrics").body.decode()
        self.assertNotRegex(text, r"x\d|METHOD")

    def test_a_solve_is_seen(self):
        before = self.metrics()
        reply = self.execute(SOLVE)
        self.assertEqual(reply.status, 200)
        after = self.metrics()

        def more(name, suffix="", **labels):
            return after[name].value(suffix, **labels) - before[name].value(suffix, **labels)
        self.assertEqual(more("scatterd_runs_total", process="solve", end="reply"), 1)
        self.assertEqual(more("scatterd_run_seconds", "_count", process="solve"), 1)
        self.assertEqual(more("scatterd_queue_wait_seconds", "_count"), 1)
        route = "/processes/{}/execution"
        self.assertEqual(more("scatterd_http_request_seconds", "_count", route=route), 1)
        self.assertEqual(more("scatterd_http_request_bytes_total", route=route), len(SOLVE))
        self.assertEqual(more("scatterd_http_response_bytes_total", route=route), len(reply.body))
        seconds = reply.json["report"]["value"]["seconds"]
        phases = sum(more("scatterd_phase_seconds_total", phase=phase)
                     for phase in after["scatterd_phase_seconds_total"].labels("phase"))
        self.assertGreater(more("scatterd_phase_seconds_total", phase="factor"), 0)
        self.assertGreater(phases, 0.5 * (seconds["search"] + seconds["factor"]))
        self.assertLess(phases, more("scatterd_run_seconds", "_sum", process="solve") + 1e-3)

    def test_gauges(self):
        families = self.metrics()
        workers = families["scatterd_workers"]
        self.assertEqual(workers.labels("state"), {"absent", "starting", "idle", "busy", "ending"})
        self.assertEqual(workers.value(), 2)
        self.assertEqual(families["scatterd_queue_length"].value(), 0)
        self.assertGreater(families["scatterd_workers_resident_memory_bytes"].value(), 1e6)
        self.assertGreater(families["process_resident_memory_bytes"].value(), 1e6)
        self.assertEqual(families["scatterd_build_info"].value(), 1)
        self.assertGreater(families["scatterd_store_free_bytes"].value(), 0)

        def agrees():  # once the connections of before are closed on its side, too
            counted = self.metrics()["process_open_fds"].value()
            return abs(counted - len(daemon.descriptors(self.daemon.pid))) <= 2
        daemon.wait_until(agrees, "the number of descriptors")

    def test_a_job_is_seen(self):
        before = self.metrics()
        reply = self.execute(SOLVE, Prefer="respond-async")
        self.assertEqual(reply.status, 201, reply.body)
        self.wait_for("scatterd_jobs", 0)
        after = self.metrics()

        def more(name, **labels):
            return after[name].value(**labels) - before[name].value(**labels)
        self.assertEqual(more("scatterd_jobs_ended_total", state="successful"), 1)
        self.assertEqual(more("scatterd_runs_total", process="solve", work="job", end="reply"), 1)
        self.assertEqual(more("scatterd_runs_total", process="solve", work="check"), 1)
        self.assertEqual(after["scatterd_jobs"].labels("state"), {"accepted", "running"})
        self.assertEqual(after["scatterd_jobs_ended_total"].labels("state"),
                         {"successful", "failed", "dismissed"})
        self.assertGreater(after["scatterd_jobs_room"].value(), 0)
        self.assertGreater(after["scatterd_store_bytes"].value(), 0)

    def test_head_and_other_methods(self):
        self.assertEqual(self.request("HEAD", "/metrics").status, 200)
        self.assertEqual(self.request("POST", "/metrics", "").status, 405)


class Life(Case):
    """What happens to workers is counted."""
    options = ["--workers", "2", "--seconds", "3"]

    def test_ends(self):
        self.wait_for("scatterd_workers", 2, state="idle")
        before = self.metrics()
        for body in ("sleep 0", "abort", "memory", "sleep 600"):
            self.execute(body)
        after = self.metrics()
        for end in ("reply", "crash", "memory", "time"):
            self.assertEqual(after["scatterd_runs_total"].value(end=end)
                             - before["scatterd_runs_total"].value(end=end), 1, end)
        self.wait_for("scatterd_workers", 2, state="idle")
        final = self.metrics()
        starts = final["scatterd_worker_starts_total"].value()
        exits = final["scatterd_worker_exits_total"]
        self.assertEqual(starts - exits.value(), 2)
        self.assertEqual(exits.value(how="signal"), 1)
        self.assertGreaterEqual(exits.value(how="planned"), 1)

    def test_phases(self):
        before = self.metrics()["scatterd_phase_seconds_total"].value(phase="half")
        self.execute("phase half 0.5 0.4")
        spent = self.metrics()["scatterd_phase_seconds_total"].value(phase="half") - before
        self.assertGreaterEqual(spent, 0.399)


class Leaving(Case):
    options = ["--workers", "2"]

    def test_a_client_that_leaves(self):
        family = "scatterd_runs_cancelled_total"
        before = self.metrics()[family].value()
        with self.daemon.raw() as plain:
            plain.sendall(b"POST /processes/solve/execution HTTP/1.1\r\nHost: a\r\n"
                          b"Content-Type: application/json\r\nContent-Length: 9\r\n\r\nsleep 600")
            self.wait_for("scatterd_workers", 1, state="busy")
        self.wait_for(family, before + 1)
        self.wait_for("scatterd_http_requests_total", 1, status="aborted")


class Readiness(Case):
    options = ["--workers", "1", "--queue", "1"]

    def test_a_full_queue_is_not_ready(self):
        self.assertEqual(self.get("/readyz").json, {"status": "ready", "workers": 1})
        threads = [threading.Thread(target=self.execute, args=("sleep 60",)) for _ in range(2)]
        for thread in threads:
            thread.start()
        self.wait_for("scatterd_queue_length", 1)
        reply = self.get("/readyz")
        self.assert_problem(reply, 503, "the queue is full")
        self.assertEqual(reply.headers["Retry-After"], "1")
        self.assertEqual(self.metrics()["scatterd_ready"].value(check="queue"), 0)
        with self.daemon.waking():
            for thread in threads:
                thread.join()
        self.assertEqual(self.get("/readyz").status, 200)
        self.assertEqual(self.metrics()["scatterd_ready"].value(check="queue"), 1)

    def test_a_data_directory_that_is_gone(self):
        hidden = self.daemon.data + ".hidden"
        os.rename(self.daemon.data, hidden)
        try:
            self.assert_problem(self.get("/readyz"), 503, "data directory")
            self.assertEqual(self.metrics()["scatterd_ready"].value(check="store"), 0)
            self.assertEqual(self.get("/healthz").status, 200)
        finally:
            os.rename(hidden, self.daemon.data)
        self.assertEqual(self.get("/readyz").status, 200)


class Dashboard(Case):
    stub = False

    def test_it_asks_only_for_what_there_is(self):
        dashboard = json.loads((ROOT / "clients" / "grafana" / "scatterd.json").read_text())
        families = self.metrics()
        known = {name + end for name, family in families.items()
                 for end in (("_bucket", "_sum", "_count") if family.kind == "histogram" else ("",))}
        expressions = [target["expr"] for panel in dashboard["panels"]
                       for target in panel.get("targets", [])]
        self.assertGreater(len(expressions), 10)
        asked = set()
        for text in expressions:
            names = set(re.findall(r"\b((?:scatterd|process)_[a-z_]+)", text))
            self.assertTrue(names, text)
            self.assertLessEqual(names, known, text)
            self.assertEqual(text.count("("), text.count(")"), text)
            asked |= names
        own = {name for name in known if name.startswith("scatterd_")}
        unused = {re.sub("_(bucket|sum|count)$", "", name) for name in own} - {
            re.sub("_(bucket|sum|count)$", "", name) for name in asked}
        self.assertEqual(unused, set(), "metrics that no panel shows")

    def test_it_is_made_by_its_script(self):
        folder = ROOT / "clients" / "grafana"
        made = subprocess.run([sys.executable, folder / "make.py"], capture_output=True, check=True)
        self.assertEqual(made.stdout, (folder / "scatterd.json").read_bytes())

    def test_panels_are_well_formed(self):
        dashboard = json.loads((ROOT / "clients" / "grafana" / "scatterd.json").read_text())
        panels = dashboard["panels"]
        self.assertEqual(len({panel["id"] for panel in panels}), len(panels))
        places = [panel["gridPos"] for panel in panels]
        for a in places:
            self.assertLessEqual(a["x"] + a["w"], 24)
        cells = [(x, y) for p in places for x in range(p["x"], p["x"] + p["w"])
                 for y in range(p["y"], p["y"] + p["h"])]
        self.assertEqual(len(cells), len(set(cells)), "panels overlap")


if __name__ == "__main__":
    unittest.main()
