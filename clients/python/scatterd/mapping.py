"""Many requests as jobs: one thread submits them, some wait for them."""

from __future__ import annotations

import contextlib
import copy
import math
import queue
import threading
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Iterable, Iterator

from .errors import ScatterdError
from .job import Job

if TYPE_CHECKING:
    from .jobs import Jobs

WAITERS = 16  # the service begins jobs in their order: few need be watched at a time
ALL = -1  # in place of a number: how many requests there are, or what was wrong with them


class Stopped(Exception):
    """Nobody wants the results any more."""


class Requests:
    """Requests on their way: submitted, over, taken.

    Each takes a slot when it is submitted and gives it back when its result is taken, so results
    do not heap up in front of one that is slow, or of a reader that is.
    """

    def __init__(self, client: "Jobs", requests: Iterable[Any], process: str, *,
                 ordered: bool, in_flight: int = 1000, priority: int | None = None):
        self.client, self.requests, self.process = client, requests, process
        self.ordered, self.priority = ordered, priority
        self.slots = threading.Semaphore(in_flight)
        self.stopping = threading.Event()
        self.submitted: queue.Queue = queue.Queue()  # (number, job); None ends a waiter
        self.over: queue.Queue = queue.Queue()  # (number, result or error)
        self.jobs: dict[int, Job] = {}  # not over yet
        self.held: dict[int, Any] = {}  # over, but not their turn
        self.turn = 0

    def outcomes(self) -> Iterator[tuple[int, Any]]:
        """Pairs (number, result or ScatterdError)."""
        threads = [threading.Thread(target=run, daemon=True)
                   for run in [self.submit_all] + WAITERS * [self.wait_for_them]]
        for thread in threads:
            thread.start()
        try:
            for number, outcome in self.finished():
                self.held[number] = outcome
                for ready in self.ready():
                    yield ready, self.held.pop(ready)
                    self.slots.release()
        finally:
            self.stop()

    def results(self, errors: str) -> Iterator[Any]:
        """What is in the pairs; with errors="raise" the first failure is raised at its turn."""
        if errors not in ("raise", "return"):
            raise ValueError(f"errors is {errors!r}, needs 'raise' or 'return'")
        for _, found in self.outcomes():
            if errors == "raise" and isinstance(found, Exception):
                raise found
            yield found

    def finished(self) -> Iterator[tuple[int, Any]]:
        """Pairs in the order in which they end, until there are as many as requests."""
        total, count = math.inf, 0
        while count < total:
            number, outcome = self.over.get()
            if number == ALL and isinstance(outcome, BaseException):
                raise outcome
            if number == ALL:
                total = outcome
            else:
                self.jobs.pop(number, None)
                count += 1
                yield number, outcome

    def ready(self) -> Iterator[int]:
        """Numbers whose turn it is among those held."""
        if not self.ordered:
            yield from list(self.held)
        while self.ordered and self.turn in self.held:
            self.turn += 1
            yield self.turn - 1

    def stop(self) -> None:
        """Ends the threads and the pairs, and cancels what is not over; from any thread."""
        self.stopping.set()
        self.over.put((ALL, 0))
        self.slots.release()
        for _ in range(WAITERS):
            self.submitted.put(None)
        with contextlib.suppress(KeyError):
            while True:
                cancel(self.jobs.popitem()[1])

    # ---- the thread that submits ----

    def submit_all(self) -> None:
        client = copy.copy(self.client)
        client.retry = replace(client.retry, attempts_full=math.inf, sleep=self.sleep)
        count = 0
        try:
            for request in self.requests:
                self.slots.acquire()
                self.submit(client, count, dict(request))
                count += 1
            self.over.put((ALL, count))
        except Stopped:
            pass
        except BaseException as error:  # the requests themselves: for whoever reads the results
            self.over.put((ALL, error))
        finally:
            client.transport.close()

    def submit(self, client: "Jobs", number: int, request: dict) -> None:
        if self.stopping.is_set():
            raise Stopped
        process = request.pop("process", self.process)
        try:
            job = client.submit_request(process, request, priority=self.priority)
        except ScatterdError as error:
            self.over.put((number, error))
            return
        job.client = self.client  # type: ignore[assignment]
        self.jobs[number] = job
        if self.stopping.is_set():
            cancel(job)
        self.submitted.put((number, job))

    def sleep(self, seconds: float) -> None:
        if self.stopping.wait(seconds):
            raise Stopped

    # ---- the threads that wait ----

    def wait_for_them(self) -> None:
        for number, job in iter(self.submitted.get, None):
            if self.stopping.is_set():
                break
            try:
                self.over.put((number, job.result()))
            except Exception as error:
                self.over.put((number, error))
        self.client.transport.close()


def cancel(job: Job) -> None:
    with contextlib.suppress(ScatterdError):
        job.cancel()
