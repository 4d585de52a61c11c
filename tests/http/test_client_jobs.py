#!/usr/bin/env python3
"""http.client_jobs: jobs by the Python client: submitted, watched, cancelled, listed, mapped, also
with asyncio and from the command line, and over a service that is full or restarts."""

import asyncio
import json
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import threading
import time
import unittest
from datetime import datetime, timedelta, timezone
from email.utils import format_datetime
from unittest import mock

import numpy

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.dont_write_bytecode = True
sys.path[:0] = [str(ROOT / "clients/python"), str(ROOT / "tests/http")]
import scatterd  # noqa: E402  (found by the line above)
from daemon import PATIENCE, Daemon, wait_until  # noqa: E402
from scatterd import aio, sse  # noqa: E402
from scatterd.retry import Retry, retry_after  # noqa: E402

PLANE = {
    "cloud": scatterd.lattice([0, 0], [1, 1], 8, jitter=0.3, seed=4),
    "diffusivity": 1,
    "boundary": [scatterd.dirichlet("boundary", "x")],
}
HEAT = {
    "cloud": scatterd.lattice([0, 0], [1, 1], 60),
    "diffusivity": 1,
    "boundary": [scatterd.dirichlet("boundary", 0)],
    "initial": "sin(pi*x)*sin(pi*y)",
    "time": {"method": "backward-euler", "end": 0.1, "step": 2e-4},
}
MARCH = {**HEAT, "time": {"method": "backward-euler", "end": 0.1, "step": 1e-6}}  # some minutes
LONG = {"message": "long", "pause": 60}


def echoes(count, **inputs):
    return [{"inputs": {"message": str(k), **inputs}} for k in range(count)]


class Case(unittest.TestCase):
    """A daemon with the real worker, and a client, for the class."""

    options = ["--workers", "3"]
    unix = False

    @classmethod
    def setUpClass(cls):
        cls.daemon = Daemon(*cls.options, stub=False, unix=cls.unix)
        cls.addClassCleanup(cls.daemon.stop)
        cls.daemon.wait_ready()
        cls.url = f"unix:{cls.daemon.socket}" if cls.unix else f"http://{cls.daemon.address}"
        cls.client = scatterd.Client(cls.url)
        cls.addClassCleanup(cls.client.close)

    def running(self, inputs=LONG, process="echo"):
        job = self.client.submit(process, inputs)
        wait_until(lambda: job.status == "running", "the run")
        return job

    def assert_refused(self, status, function, *arguments, **options):
        with self.assertRaises(scatterd.ScatterdError) as caught:
            function(*arguments, **options)
        self.assertEqual(caught.exception.status, status, caught.exception)
        return caught.exception


class Submitting(Case):
    def test_a_job_gives_what_a_solve_gives(self):
        direct = self.client.solve(**PLANE)
        for format in ("json", "cbor"):
            with self.subTest(format), scatterd.Client(self.url, format=format) as client:
                job = client.submit("solve", PLANE)
                result = job.result(PATIENCE)
                numpy.testing.assert_array_equal(result.solution, direct.solution)
                self.assertEqual(result.request_inputs["diffusivity"], 1)
                again = client.job(job.id)
                self.assertEqual(again.status, "successful")
                numpy.testing.assert_array_equal(again.result().solution, direct.solution)

    def test_outputs_and_kinds(self):
        self.assertEqual(set(self.client.submit("solve", PLANE, ["points"]).result()), {"points"})
        laplace = {"case": "laplace", "cells": [4, 8]}
        study = self.client.submit("study", laplace).result()
        self.assertIsInstance(study, scatterd.Study)
        self.assertIsInstance(self.client.execute("study", laplace), scatterd.Study)
        self.assertEqual(study.column("cells").tolist(), [4, 8])

    def test_a_key_makes_one_job(self):
        first, again, other = (self.client.submit("echo", {"message": "a"}, key=key)
                               for key in ("k1", "k1", None))
        self.assertEqual(first.id, again.id)
        self.assertNotEqual(first.id, other.id)
        error = self.assert_refused(422, self.client.submit, "echo", {"message": "b"}, key="k1")
        self.assertIn("Idempotency-Key", str(error))

    def test_every_submission_has_a_key(self):
        seen = []
        request = self.client.transport.request

        def record(method, path, body, headers):
            seen.append(headers.get("Idempotency-Key"))
            return request(method, path, body, headers)

        with mock.patch.object(self.client.transport, "request", record):
            for _ in range(2):
                self.client.submit("echo", {"message": "a"})
        self.assertTrue(all(seen))
        self.assertEqual(len(set(seen)), 2)

    def test_priority_and_fresh(self):
        first = self.client.submit("diagnose", {"cloud": PLANE["cloud"]}, priority=9).wait(PATIENCE)
        self.assertEqual(first.info["priority"], 9)
        for fresh, attempts in ((False, 0), (True, 1)):
            job = self.client.submit("diagnose", {"cloud": PLANE["cloud"]}, fresh=fresh)
            self.assertEqual(job.wait(PATIENCE).info["attempts"], attempts)

    def test_what_is_wrong_is_refused_at_once(self):
        bad = {**PLANE, "diffusivity": "1 +"}
        error = self.assert_refused(400, self.client.submit, "solve", bad)
        self.assertEqual(error.errors[0].pointer, "/inputs/diffusivity")
        self.assert_refused(404, self.client.submit, "guess", {})
        address = {"successUri": "http://nobody.example/"}
        error = self.assert_refused(400, self.client.submit, "echo", {"message": "x"},
                                    subscriber=address)
        self.assertEqual(error.errors[0].pointer, "/subscriber/successUri")
        self.assert_refused(404, self.client.job, "none")

    def test_a_job_that_fails_tells_why(self):
        singular = {**PLANE, "boundary": [scatterd.neumann("boundary", 0)]}
        direct = self.assert_refused(422, self.client.solve, **singular)
        job = self.client.submit("solve", singular)
        self.assertEqual(job.wait(PATIENCE).status, "failed")
        self.assertEqual(self.assert_refused(422, job.result).detail, direct.detail)

    def test_batch(self):
        entries = [*echoes(3), {"process": "solve", "inputs": {**PLANE, "boundary": []}}]
        entries[:3] = [{"process": "echo", **entry} for entry in entries[:3]]
        job = self.client.submit("batch", {"requests": entries})
        found = job.result(PATIENCE)
        self.assertEqual([one.message for one in found[:3]], ["0", "1", "2"])
        self.assertIsInstance(found[3], scatterd.ScatterdError)
        self.assertEqual(found[3].status, 422)
        self.assertEqual({part.info["processID"] for part in job.parts()}, {"echo", "solve"})
        self.assertEqual(len(list(job.parts())), 4)


class Watching(Case):
    def test_progress_is_told(self):
        told = []
        job = self.client.submit("solve", HEAT, fresh=True)
        job.wait(PATIENCE, progress=lambda share, what: told.append((share, what)))
        shares = [share for share, _ in told]
        self.assertEqual(shares, sorted(shares))
        self.assertEqual(told[-1], (1.0, "successful"))

    def test_fraction_and_phase_are_told(self):
        told = []

        def tell(share, what):
            told.append((share, what))
            if what == "march":
                job.cancel()

        job = self.client.submit("solve", MARCH, fresh=True)
        self.assertEqual(job.wait(4 * PATIENCE, progress=tell).status, "dismissed")
        self.assertIn("march", [what for share, what in told if 0 < share < 1])

    def test_bar(self):
        with mock.patch("sys.stderr") as stderr:
            stderr.isatty.return_value = True
            self.client.submit("echo", {"message": "x"}).wait(PATIENCE, progress=True)
        text = "".join(call.args[0] for call in stderr.write.call_args_list)
        self.assertRegex(text, r"\r\[#{30}\] 100% .* successful +\n$")

    def test_patience_ends(self):
        job = self.running()
        for method in (job.wait, job.result):
            with self.assertRaisesRegex(TimeoutError, f"{job.id} is running after 0.2 s"):
                method(0.2)
        self.assertEqual(job.status, "running")
        job.cancel()

    def test_cancel(self):
        job = self.running()
        self.assertEqual(job.cancel().info["status"], "dismissed")
        self.assertEqual(job.status, "dismissed")
        self.assert_refused(410, job.result)
        self.assertEqual(job.cancel().status, "dismissed")  # again, as after a lost answer

    def test_cancel_ends_a_wait(self):
        job = self.running()

        def cancel_soon():
            time.sleep(0.3)
            with scatterd.Client(self.url) as other:
                other.job(job.id).cancel()

        other = threading.Thread(target=cancel_soon)
        other.start()
        self.assertEqual(job.wait(PATIENCE).status, "dismissed")
        other.join()

    def test_events(self):
        job = self.client.submit("solve", HEAT, fresh=True)
        events = list(job.events())
        self.assertEqual(events[0].kind, "status")
        self.assertEqual(events[-1].data["status"], "successful")
        self.assertTrue(job.is_over)
        numbers = [int(event.id) for event in events]
        self.assertEqual(numbers, sorted(numbers))
        self.assertEqual(list(job.events(after=events[-1].id)), [])
        self.assertEqual([event.data["status"] for event in job.events()], ["successful"])

    def test_events_of_every_kind(self):
        job, events = self.client.submit("solve", MARCH, fresh=True), []
        for event in job.events(after="1"):  # also what came before we looked
            events.append(event)
            if event.kind == "progress" and event.data["phase"] == "march" and not job.is_over:
                job.cancel()
        self.assertEqual({event.kind for event in events}, {"status", "phase", "progress"})
        self.assertEqual(events[-1].data["status"], "dismissed")
        self.assertIn("march", [event.data["phase"] for event in events if event.kind == "phase"])

    def test_events_go_on_after_a_broken_stream(self):
        job = self.client.submit("echo", {"message": "x", "pause": 5})
        opened = []
        original = job.open_events

        def break_first(after):
            opened.append(after)
            stream = original(after)
            if len(opened) == 1:
                first = stream.response.readline() + stream.response.readline()
                rest = stream.response.readline() + stream.response.readline()
                return mock.Mock(lines=lambda: iter((first + rest).splitlines(True)),
                                 close=stream.close)
            return stream

        with mock.patch.object(job, "open_events", break_first):
            events = list(job.events())
        self.assertEqual(opened, ["", events[0].id])
        self.assertEqual(events[-1].data["status"], "successful")
        self.assertEqual(len({event.id for event in events}), len(events))


class Listing(Case):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.echoes = [cls.client.submit("echo", {"message": str(k)}) for k in range(105)]
        singular = {**PLANE, "boundary": [scatterd.neumann("boundary", 0)]}
        cls.failed = cls.client.submit("solve", singular)
        for job in [*cls.echoes, cls.failed]:
            job.wait(PATIENCE)

    def ids(self, **filters):
        return [job.id for job in self.client.jobs(**filters)]

    def test_all_pages(self):
        newest_first = [job.id for job in [*self.echoes, self.failed]][::-1]
        self.assertEqual(self.ids(), newest_first)
        self.assertEqual(self.ids(limit=103), newest_first[:103])
        self.assertEqual(self.ids(limit=0), [])

    def test_pages_while_jobs_come(self):
        found = self.client.jobs(process="echo")
        first = next(found).id
        late = self.client.submit("echo", {"message": "late"})
        rest = [job.id for job in found]
        late.cancel()
        self.assertEqual(sorted([first, *rest]), sorted(job.id for job in self.echoes))

    def test_filters(self):
        self.assertEqual(self.ids(status="failed"), [self.failed.id])
        self.assertEqual(self.ids(process=["solve", "apply"]), [self.failed.id])
        self.assertEqual(len(self.ids(status=["failed", "successful"])), 106)
        self.assertEqual(self.ids(status="running"), [])
        self.assertEqual(self.ids(min_seconds=1000), [])
        self.assertEqual(self.ids(since=datetime.now(timezone.utc) + timedelta(hours=1)), [])
        self.assertEqual(self.ids(since=self.failed.info["created"], until="..")[-1], self.failed.id)
        with self.assertRaises(scatterd.ScatterdError):
            self.ids(status="nonsense")


class Mapping(Case):
    options = ["--workers", "3", "--job-queue", "2"]

    def setUp(self):
        self.quick = scatterd.Client(self.url, retry=Retry(first=0.05))
        self.addCleanup(self.quick.close)

    def active(self):
        return list(self.client.jobs(status=["accepted", "running"]))

    def test_a_full_queue_is_waited_for(self):
        results = list(self.quick.map(echoes(12, pause=1), "echo"))
        self.assertEqual([result.message for result in results], [str(k) for k in range(12)])
        self.daemon.wait_for_log(r"status=429")

    def test_as_completed(self):
        requests = [{"inputs": {"message": "slow", "pause": 8}}, *echoes(3)]
        found = list(self.client.as_completed(requests, "echo"))
        self.assertEqual(sorted(number for number, _ in found), [0, 1, 2, 3])
        self.assertEqual(found[-1][0], 0)
        self.assertEqual({number: result.message for number, result in found},
                         {0: "slow", 1: "0", 2: "1", 3: "2"})

    def test_processes_and_failures(self):
        requests = [{"process": "echo", "inputs": {"message": "a"}}, {"inputs": {}},
                    {"inputs": PLANE, "outputs": {"points": {}}}]
        found = list(self.client.map(requests, errors="return"))
        self.assertEqual(found[0].message, "a")
        self.assertEqual(found[1].status, 400)
        self.assertEqual(set(found[2]), {"points"})
        with self.assertRaises(scatterd.ScatterdError):
            list(self.client.map(requests))
        with self.assertRaises(ValueError):
            list(self.client.map(requests, errors="ignore"))

    def test_who_leaves_early_cancels(self):
        results = self.client.map([*echoes(1), *echoes(3, pause=50)], "echo")
        self.assertEqual(next(results).message, "0")
        wait_until(self.active, "jobs")
        results.close()
        wait_until(lambda: not self.active(), "the end of all jobs")

    def test_requests_are_taken_as_there_is_room(self):
        taken = []

        def requests():
            for one in echoes(30):
                taken.append(one)
                yield one

        results = self.client.map(requests(), "echo", in_flight=3)
        next(results)
        self.assertLessEqual(len(taken), 5)  # one given back, one drawn and waiting
        self.assertEqual(len(list(results)), 29)

    def test_errors_of_the_requests_come_out(self):
        def requests():
            yield echoes(1)[0]
            raise KeyError("mine")

        with self.assertRaisesRegex(KeyError, "mine"):
            list(self.client.map(requests(), "echo"))
        self.assertEqual(list(self.client.map([], "echo")), [])


class Refusals(unittest.TestCase):
    """When it is asked again, without a daemon."""

    class Answer:
        def __init__(self, status, **headers):
            self.status = status
            self.headers = {name.replace("_", "-"): value for name, value in headers.items()}

    def run_with(self, *answers, **options):
        """Status of the outcome, and the waits."""
        waits, left = [], list(answers)

        def ask():
            found = left.pop(0)
            if isinstance(found, Exception):
                raise found
            return found

        try:
            return Retry(sleep=waits.append, **options).run(ask).status, waits
        except scatterd.UnreachableError:
            return None, waits

    def test_retry_after_is_honoured(self):
        for status in (429, 503):
            found, waits = self.run_with(self.Answer(status, Retry_After="7"), self.Answer(200))
            self.assertEqual(found, 200)
            self.assertTrue(7 <= waits[0] <= 7.5, waits)

    def test_dates(self):
        date = format_datetime(datetime.now(timezone.utc) + timedelta(seconds=100), usegmt=True)
        self.assertTrue(90 < retry_after({"Retry-After": date}) <= 100)
        for text in ("", "soon", "-3", "Mon, 01 Jan 2001 00:00:00 GMT"):
            self.assertEqual(retry_after({"Retry-After": text}), 0, text)

    def test_waits_grow_to_their_bound(self):
        answers = [self.Answer(503) for _ in range(9)]
        found, waits = self.run_with(*answers, attempts=9, first=1, most=8)
        self.assertEqual((found, len(waits)), (503, 8))
        for wait, most in zip(waits, (1, 2, 4, 8, 8, 8, 8, 8)):
            self.assertTrue(most / 2 <= wait <= most, waits)
        self.assertGreater(len(set(waits)), 4)

    def test_other_answers_are_final(self):
        for status in (200, 304, 400, 404, 410, 422, 500, 507):
            self.assertEqual(self.run_with(self.Answer(status)), (status, []))

    def test_lost_connections(self):
        for passing, found in ((True, 200), (False, None)):
            error = scatterd.UnreachableError("here", "lost", passing)
            self.assertEqual(self.run_with(error, self.Answer(200))[0], found)
        lost = 3 * [scatterd.UnreachableError("here", "lost", True)]
        self.assertEqual(self.run_with(*lost, attempts=3)[0], None)

    def test_event_streams(self):
        text = (b": beat\n\nid: 5\nevent: phase\ndata: {\"a\":\ndata: 1}\n\nevent: status\r\n"
                b"data:{\"status\":\"failed\"}\r\n\r\nid: 7\nevent: phase\ndata: {}\n")
        found = list(sse.parse(text.splitlines(True)))
        self.assertEqual(found, [("5", "phase", {"a": 1}), ("5", "status", {"status": "failed"})])
        self.assertEqual([event.is_end for event in found], [False, True])


class Restart(Case):
    unix = True

    def restart(self, how=signal.SIGTERM):
        cls, directory = type(self), self.daemon.directory
        self.daemon.stop(how, keep=True)
        cls.daemon = Daemon(*self.options, stub=False, unix=True, directory=directory)
        cls.addClassCleanup(cls.daemon.stop)

    def test_wait_and_events_go_on(self):
        job = self.running({"message": "x", "pause": 3})
        told, ended, first = [], [], threading.Event()

        def watch():
            for event in job.events():
                told.append(event)
                first.set()

        def wait():
            with scatterd.Client(self.url) as other:
                ended.append(other.job(job.id).result())

        watching, waiting = threading.Thread(target=watch), threading.Thread(target=wait)
        for thread in (watching, waiting):
            thread.start()
        self.assertTrue(first.wait(PATIENCE))
        time.sleep(0.5)  # the other one waits, too
        self.restart()
        for thread in (watching, waiting):
            thread.join(PATIENCE)
        self.assertEqual(ended[0].message, "x")
        self.assertEqual(told[-1].data["status"], "successful")
        self.assertEqual(self.client.submit("echo", {"message": "y"}).result().message, "y")

    def test_a_map_goes_on_after_a_kill(self):
        begun = self.client.get("/jobs?limit=1")["jobs"]
        since = begun[0]["created"] if begun else None
        results = self.client.map(echoes(60, pause=0.02), "echo")
        found = [next(results).message for _ in range(5)]
        self.restart(signal.SIGKILL)
        found += [result.message for result in results]
        self.assertEqual(found, [str(k) for k in range(60)])
        made = [job for job in self.client.jobs(since=since) if job.id not in
                [one["jobID"] for one in begun]]
        self.assertEqual(len(made), 60)  # none was made twice


class Async(Case):
    def run_async(self, work):
        async def whole():
            async with aio.Client(self.url) as client:
                return await asyncio.wait_for(work(client), 2 * PATIENCE)
        return asyncio.run(whole())

    def test_jobs(self):
        async def work(client):
            job = await client.submit("solve", PLANE)
            result = await job
            self.assertEqual(await job.status(), "successful")
            again = await client.job(job.id)
            direct = await client.solve(**PLANE)
            numpy.testing.assert_array_equal(direct.solution, result.solution)
            self.assertIn(again.id, [one.id async for one in client.jobs(process="solve")])
            return (await again.result()).solution.shape
        self.assertEqual(self.run_async(work), (81,))

    def test_many_at_a_time(self):
        async def work(client):
            jobs = await asyncio.gather(*[client.submit("echo", {"message": str(k)})
                                          for k in range(60)])
            return [result.message for result in await asyncio.gather(*jobs)]
        self.assertEqual(self.run_async(work), [str(k) for k in range(60)])

    def test_progress_events_and_cancel(self):
        async def work(client):
            job = await client.submit("echo", LONG)
            with self.assertRaises(TimeoutError):
                await job.wait(timeout=0.2)
            kinds, told = [], []
            async for event in job.events():
                kinds.append(event.kind)
                if not event.is_end:
                    await job.cancel()
            await (await client.submit("solve", HEAT, fresh=True)).wait(
                progress=lambda share, what: told.append(share))
            return kinds[0], kinds[-1], job.info["status"], told[-1]
        self.assertEqual(self.run_async(work), ("status", "status", "dismissed", 1.0))

    def test_map(self):
        async def work(client):
            found = [result.message async for result in client.map(echoes(40), "echo")]
            pairs = {number async for number, _ in client.as_completed(echoes(5), "echo")}
            async for _ in client.map([*echoes(1), *echoes(3, pause=50)], "echo"):
                break
            return found, pairs
        found, pairs = self.run_async(work)
        self.assertEqual(found, [str(k) for k in range(40)])
        self.assertEqual(pairs, set(range(5)))
        wait_until(lambda: not list(self.client.jobs(status=["accepted", "running"])),
                   "the end of what was left")


class Readme(Case):
    def run_block(self, number):
        text = (ROOT / "clients/python/README.md").read_text(encoding="utf-8")
        program = text.split("```python\n")[number].split("```")[0]
        self.assertIn("http://127.0.0.1:8480", program)
        done = subprocess.run(
            [sys.executable, "-B", "-c", program.replace("http://127.0.0.1:8480", self.url)],
            env={**os.environ, "PYTHONPATH": str(ROOT / "clients/python")},
            capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout.split()

    def test_jobs_run_as_printed(self):
        status, highest, *means = self.run_block(2)
        self.assertEqual((status, float(highest)), ("successful", 1.0))
        self.assertEqual(len(means), 4)
        for mean in map(float, means):
            self.assertAlmostEqual(mean, 0.5, delta=0.01)  # the solution is y

    def test_asyncio_runs_as_printed(self):
        neighbours = [float(text) for text in self.run_block(3)]
        self.assertEqual(len(neighbours), 3)
        self.assertGreater(min(neighbours), 5)


class Commands(Case):
    def setUp(self):
        place = tempfile.TemporaryDirectory()
        self.addCleanup(place.cleanup)
        self.folder = pathlib.Path(place.name)

    def command(self, *arguments, status=0):
        environment = {**os.environ, "PYTHONPATH": str(ROOT / "clients/python"),
                       "SCATTERD_URL": self.url}
        done = subprocess.run([sys.executable, "-B", "-m", "scatterd", *arguments], env=environment,
                              capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, status, done.stderr)
        self.assertNotIn("Traceback", done.stderr)
        return done

    def write(self, name, request):
        file = self.folder / name
        file.write_text(json.dumps(request))
        return str(file)

    def test_submit_watch_results(self):
        files = [self.write("a.json", {"inputs": PLANE}),
                 self.write("b.json", {"process": "echo", "inputs": {"message": "b"}})]
        lines = self.command("submit", *files).stdout.splitlines()
        self.assertEqual([line.split()[1] for line in lines], files)
        ids = [line.split()[0] for line in lines]
        watched = self.command("watch", *ids)
        self.assertEqual(watched.stdout.count(" successful: "), 2)
        self.assertIn("100%", watched.stderr)
        saved = self.folder / "a.npz"
        self.assertIn("solution", self.command("results", ids[0], "--output", str(saved)).stdout)
        with numpy.load(saved) as arrays:
            self.assertEqual(arrays["solution"].shape, (81,))
        self.assertRegex(self.command("results", ids[1]).stdout, r"message +b")
        self.command("results", ids[0], "--output", "x.txt", status=1)

    def test_jobs_and_cancel(self):
        job = self.running()
        listed = self.command("jobs", "--status", "running", "--process", "echo").stdout
        self.assertRegex(listed, rf"(?m)^{job.id} running +\d+% echo ")
        self.assertIn(f"{job.id} dismissed", self.command("cancel", job.id).stdout)
        self.assertNotIn(job.id, self.command("jobs", "--status", "running").stdout)
        self.assertIn(" dismissed: ", self.command("watch", job.id, status=1).stdout)
        self.assertIn("410", self.command("results", job.id, status=1).stderr)

    def test_refusals_leave_the_others(self):
        files = [self.write("bad.json", {"inputs": {}}), str(self.folder / "none.json"),
                 self.write("good.json", {"inputs": {"message": "x"}})]
        done = self.command("submit", "--process", "echo", "--wait", *files, status=1)
        self.assertIn("bad.json", done.stderr)
        self.assertIn("none.json", done.stderr)
        self.assertIn("good.json", done.stdout)
        self.assertIn(" successful: ", done.stdout)


if __name__ == "__main__":
    unittest.main()
