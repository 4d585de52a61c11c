"""What a client does with jobs: submit, list, map."""

from __future__ import annotations

import uuid
from datetime import datetime, timezone
from typing import Any, Iterable, Iterator, Mapping, Sequence
from urllib.parse import quote, urlencode

from . import wire
from .job import Job
from .mapping import Requests
from .retry import Retry
from .transport import Answer, Transport

PAGE = 100  # jobs that are asked for at a time


class Jobs:
    """The part of Client for executions that nobody need wait for.

    Accepted means stored: a job survives the end of the client and of the service.
    """

    transport: Transport
    retry: Retry
    format: str
    headers: dict[str, str]

    def submit(
        self,
        process: str,
        inputs: Mapping[str, Any],
        outputs: Sequence[str] | None = None,
        **options: Any,
    ) -> Job:
        """Submits an execution of a process.

        Args:
            process: solve, apply, diagnose, study, flow, echo, batch.
            inputs: its inputs by name: the arguments of the method of that name.
            outputs: names of the outputs wanted; by default all.
            options: priority, key, fresh, subscriber of `submit_request`.

        Returns:
            The job; `job.result()` waits for its result.
        """
        return self.submit_request(process, execute_request(inputs, outputs), **options)

    def submit_request(
        self,
        process: str,
        request: Mapping[str, Any],
        *,
        priority: int | None = None,
        key: str | None = None,
        fresh: bool = False,
        subscriber: Mapping[str, str] | None = None,
    ) -> Job:
        """Submits a whole execute request: {"inputs": ..., "outputs": ...}.

        Args:
            priority: 0 to 9, the highest goes first; 5 by default.
            key: the Idempotency-Key, one of its own by default. The same key with the same request
                gives the same job, also after the end of this program.
            fresh: compute it, even if the service has the result of an equal request.
            subscriber: {"successUri", "inProgressUri", "failedUri"} that the service calls.
        """
        whole = dict(request) if subscriber is None else {**request, "subscriber": subscriber}
        body, headers = wire.encode(whole, self.format)
        headers.update(wire.accept("json"))
        wanted = "" if priority is None else f", priority={priority}"
        headers["Prefer"] = "respond-async" + wanted
        headers["Idempotency-Key"] = key or uuid.uuid4().hex
        if fresh:
            headers["Cache-Control"] = "no-cache"
        path = f"/processes/{quote(process, safe='')}/execution"
        info = self.document("POST", path, body, headers)
        return Job(self, info, dict(request.get("inputs", {})))  # type: ignore[arg-type]

    def job(self, id: str) -> Job:
        """A job by its id."""
        return Job(self, self.get(f"/jobs/{quote(id, safe='')}"))  # type: ignore[arg-type]

    def jobs(
        self,
        *,
        status: str | Sequence[str] | None = None,
        process: str | Sequence[str] | None = None,
        since: datetime | str | None = None,
        until: datetime | str | None = None,
        min_seconds: int | None = None,
        max_seconds: int | None = None,
        parent: str | None = None,
        limit: int | None = None,
    ) -> Iterator[Job]:
        """The jobs of the service, newest first, page by page as they are taken.

        Args:
            status: accepted, running, successful, failed, dismissed, or several of them.
            process: of this process, or of one of several.
            since, until: created then; a datetime, or text as in RFC 3339.
            min_seconds, max_seconds: that ran so long.
            parent: the parts of this batch; else there are none among them.
            limit: so many at most.
        """
        chosen = {
            "status": listed(status), "processID": listed(process), "parent": parent,
            "datetime": interval(since, until),
            "minDuration": min_seconds, "maxDuration": max_seconds,
        }
        query = {name: value for name, value in chosen.items() if value is not None}
        for count, info in enumerate(self.pages(query)):
            if count == limit:
                return
            yield Job(self, info)  # type: ignore[arg-type]

    def pages(self, query: dict[str, Any]) -> Iterator[dict]:
        """Entries of all pages of the list, each once although new jobs move the others on."""
        seen: set[str] = set()
        offset, is_last = 0, False
        while not is_last:
            page = self.get("/jobs?" + urlencode({**query, "limit": PAGE, "offset": offset}))
            for info in page["jobs"]:
                if info["jobID"] not in seen:
                    seen.add(info["jobID"])
                    yield info
            offset += PAGE
            is_last = all(link["rel"] != "next" for link in page["links"])

    def map(self, requests: Iterable[Mapping[str, Any]], process: str = "solve",
            *, errors: str = "raise", **options: Any) -> Iterator[Any]:
        """Results of many requests in their order, each run as a job.

        All are submitted as fast as the service takes them; while its queue is full (429) the rest
        waits. Whoever leaves early, also by an error, cancels what is not over.

        Args:
            requests: each {"inputs": ..., "outputs": ...}, with "process" for another process.
            process: of requests that name none.
            errors: "raise" the first failure at its turn, or "return" a ScatterdError in the place
                of each result that failed.
            options: in_flight, jobs that are submitted and not yet taken (1000); priority.
        """
        return Requests(self, requests, process, ordered=True, **options).results(errors)

    def as_completed(self, requests: Iterable[Mapping[str, Any]], process: str = "solve",
                     **options: Any) -> Iterator[tuple[int, Any]]:
        """Like `map`, but pairs (number of the request from 0, result or ScatterdError), in the
        order in which they end."""
        return Requests(self, requests, process, ordered=False, **options).outcomes()

    # what Client brings
    def get(self, path: str) -> Any:
        raise NotImplementedError

    def document(self, method: str, path: str, body: bytes | None, headers: dict) -> Any:
        raise NotImplementedError

    def ask(self, method: str, path: str, body: bytes | None, headers: dict) -> Answer:
        raise NotImplementedError


def execute_request(inputs: Mapping[str, Any], outputs: Sequence[str] | None) -> dict[str, Any]:
    """The request for a process with its inputs, and outputs wanted by name."""
    request: dict[str, Any] = {"inputs": dict(inputs)}
    if outputs is not None:
        request["outputs"] = {name: {"transmissionMode": "value"} for name in outputs}
    return request


def listed(value: str | Sequence[str] | None) -> str | None:
    return value if value is None or isinstance(value, str) else ",".join(value)


def interval(since: datetime | str | None, until: datetime | str | None) -> str | None:
    """An interval of time as in RFC 3339, open where there is no bound."""
    if since is None and until is None:
        return None
    return f"{instant(since)}/{instant(until)}"


def instant(time: datetime | str | None) -> str:
    if isinstance(time, datetime):
        return time.astimezone(timezone.utc).strftime("%Y-%m-%dT%H:%M:%S.%fZ")
    return time or ".."
