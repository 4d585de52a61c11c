"""A job: an execution that goes on at the service, whoever waits for it."""

from __future__ import annotations

import contextlib
import time
from typing import TYPE_CHECKING, Any, Callable, Iterator
from urllib.parse import quote

from . import sse, wire
from .answer import content, failure
from .bar import Bar
from .errors import ScatterdError
from .flow import Flow
from .result import Result
from .study import Study

if TYPE_CHECKING:
    from .client import Client

KINDS = {"study": Study, "flow": Flow}  # results that are more than Result
SLICE = 50.0  # seconds of one long-poll
PACE = 0.1  # seconds between two of them at least
GONE = 410  # dismissed

Progress = Callable[[float, str], None]


class Job:
    """A job at the service; made by `Client.submit`, `Client.job` and `Client.jobs`.

    Attributes:
        id: its name at the service, also for later: `client.job(id)`.
        info: what the service last told of it (statusInfo): status, progress, phase, message,
            created, started, finished, expires, log, ...
    """

    def __init__(self, client: "Client", info: dict, inputs: dict | None = None):
        self.client = client
        self.id: str = info["jobID"]
        self.info = info
        self.inputs = inputs
        self.tag: str | None = None

    @property
    def path(self) -> str:
        return f"/jobs/{quote(self.id, safe='')}"

    @property
    def is_over(self) -> bool:
        """Was it over when the service last told of it?"""
        return self.info["status"] in sse.OVER

    @property
    def status(self) -> str:
        """accepted, running, successful, failed or dismissed; asks, unless it is known to be
        over."""
        return (self.info if self.is_over else self.refresh())["status"]

    def refresh(self, wait: float = 0.0, news: bool = False) -> dict:
        """Asks what has become of it.

        Args:
            wait: seconds that the service may take to answer, which it does when the job is over;
            news: or when anything has changed.

        Returns:
            info.
        """
        headers = wire.accept("json")
        if wait >= 1 and (self.tag or not news):  # without a tag all is news
            headers["Prefer"] = f"wait={int(wait)}"
        if news and self.tag:
            headers["If-None-Match"] = self.tag
        answer = self.client.ask("GET", self.path, None, headers)
        if answer.status != 304:
            if answer.status >= 300:
                raise failure(answer)
            self.info, self.tag = content(answer), answer.headers.get("ETag")
        return self.info

    def changes(self, timeout: float | None = None, news: bool = True,
                slice: float = SLICE) -> Iterator[dict]:
        """Its info again and again until it is over.

        Args:
            timeout: seconds after which TimeoutError is raised.
            news: with every change; else every `slice` seconds and at the end.
            slice: seconds between two at most.
        """
        begun = time.monotonic()
        patience = self.client.transport.timeout
        longest = slice if patience is None else min(slice, patience / 2)
        while not self.is_over:
            asked = time.monotonic()
            left = longest if timeout is None else timeout - (asked - begun)
            if left <= 0:
                raise TimeoutError(f"job {self.id} is {self.info['status']} after {timeout:g} s")
            self.refresh(min(left, longest), news)
            yield self.info
            if not self.is_over:
                time.sleep(max(0.0, min(left, PACE - (time.monotonic() - asked))))

    def wait(self, timeout: float | None = None, progress: bool | Progress = False) -> "Job":
        """Waits until it is over, whether it was successful or not.

        Args:
            timeout: seconds after which TimeoutError is raised; the job goes on.
            progress: True for a bar on standard error, or what is told the fraction done (0 to 1)
                and the phase.

        Returns:
            The job itself.
        """
        tell = Bar() if progress is True else progress or None
        try:
            show(tell, self.info)
            for info in self.changes(timeout, news=tell is not None):
                show(tell, info)
        finally:
            if isinstance(tell, Bar):
                tell.close()
        return self

    def result(self, timeout: float | None = None) -> Any:
        """Waits until it is over, and gives what `Client.execute` would have given.

        Args:
            timeout: seconds to wait for the end.

        Returns:
            A Result; of a batch a list of them in the order of its requests, with a
            ScatterdError in the place of each that failed.

        Raises:
            ScatterdError: why it failed; status 410 if it was dismissed.
            TimeoutError: it is not over; it goes on.
        """
        self.wait(timeout)
        is_batch = bool(self.info.get("parts"))
        headers = wire.accept("json" if is_batch else self.client.format)
        document = self.client.document("GET", f"{self.path}/results", None, headers)
        if is_batch:
            return outcomes(document)
        return KINDS.get(self.info.get("processID", ""), Result)(document, self.inputs)

    def cancel(self) -> "Job":
        """Stops it if it is not over, and drops its results if it is; returns the job itself."""
        answer = self.client.ask("DELETE", self.path, None, wire.accept("json"))
        if answer.status == GONE:
            self.refresh()
        elif answer.status >= 300:
            raise failure(answer)
        else:
            self.info = content(answer)
        return self

    def parts(self) -> Iterator["Job"]:
        """The jobs of a batch, newest first."""
        return self.client.jobs(parent=self.id)

    def events(self, after: str = "") -> Iterator[sse.Event]:
        """What happens to it, as it happens, until it is over.

        A stream that breaks off is taken up after the last event that came, also over a restart
        of the service.

        Args:
            after: id of the last event known, from which to go on; without one the first event
                is the status of now.
        """
        retry, attempt = self.client.retry, 0
        while True:
            stream = self.open_events(after)
            if stream is None:
                return
            with contextlib.closing(stream):
                for event in sse.parse(stream.lines()):
                    after, attempt = event.id, 0
                    yield event
                    if event.is_end:
                        self.info = event.data
                        return
            attempt += 1
            retry.pause(attempt)

    def open_events(self, after: str) -> Any:
        """The stream of its events; None if there are none after that one."""
        headers = {**self.client.headers, "Accept": f"text/event-stream, {wire.PROBLEM}"}
        if after:
            headers["Last-Event-ID"] = after
        transport = self.client.transport
        answer = self.client.retry.run(lambda: transport.open(f"{self.path}/events", headers))
        if answer.status == 204:
            return None
        if answer.status != 200:
            raise failure(answer)
        return answer

    def __repr__(self) -> str:
        process, status = self.info.get("processID", ""), self.info["status"]
        return f"<Job {self.id} {process} {status} {self.info.get('progress', 0)} %>"


def show(tell: Progress | None, info: dict) -> None:
    """Tells how far a job is, and what it is at."""
    if tell:
        tell(info.get("progress", 0) / 100, info.get("phase") or info["status"])


def outcomes(document: dict) -> list[Any]:
    """What became of each request of a batch, in their order."""
    return [outcome(entry) for entry in sorted(document["results"], key=lambda one: one["index"])]


def outcome(entry: dict) -> Any:
    if isinstance(entry.get("results"), dict):
        return Result(entry["results"])
    problem = entry.get("problem") or {"title": f"request {entry['index']} was {entry['status']}"}
    return ScatterdError.from_problem(problem.get("status", 0), problem)
