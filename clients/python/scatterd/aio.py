"""The client for asyncio.

    from scatterd import aio

    async with aio.Client() as client:
        job = await client.submit("solve", {...})
        result = await job                               # or: await client.solve(...)
        results = await asyncio.gather(*[client.solve(...) for ... in ...])

It is the client of threads in threads of its own: simple, and enough for hundreds of jobs, since
waiting for a job takes a thread only now and then.
"""

from __future__ import annotations

import asyncio
import contextlib
import functools
import threading
from concurrent.futures import ThreadPoolExecutor
from typing import Any, AsyncIterator, Callable, Generator, Iterable, Mapping

from . import client as plain
from . import job as plain_job
from .bar import Bar
from .mapping import Requests
from .sse import Event

SLICE = 2.0  # seconds that waiting for a job keeps a thread: others wait, too
AHEAD = 16  # items that an iteration may be ahead of its reader


class Client:
    """Client with the methods of `scatterd.Client` as coroutines; arguments are the same.

    Args:
        threads: requests at a time, and as many that wait for jobs.
        options: url, token, timeout, format, retry, ca of `scatterd.Client`.
    """

    def __init__(self, *arguments: Any, threads: int = 16, **options: Any):
        self.plain = plain.Client(*arguments, **options)
        self.asking = ThreadPoolExecutor(threads, "scatterd-ask")
        self.waiting = ThreadPoolExecutor(threads, "scatterd-wait")

    def __getattr__(self, name: str) -> Callable[..., Any]:
        """A method of `scatterd.Client` as a coroutine."""
        if name.startswith("_"):
            raise AttributeError(name)
        method = getattr(self.plain, name)

        @functools.wraps(method)
        async def call(*arguments: Any, **options: Any) -> Any:
            return await run(self.asking, method, *arguments, **options)

        return call

    async def submit(self, *arguments: Any, **options: Any) -> "Job":
        """Submits an execution of a process: arguments of `scatterd.Client.submit`."""
        return Job(self, await run(self.asking, self.plain.submit, *arguments, **options))

    async def submit_request(self, *arguments: Any, **options: Any) -> "Job":
        """Submits a whole execute request: arguments of `scatterd.Client.submit_request`."""
        return Job(self, await run(self.asking, self.plain.submit_request, *arguments, **options))

    async def job(self, id: str) -> "Job":
        """A job by its id."""
        return Job(self, await run(self.asking, self.plain.job, id))

    async def jobs(self, **filters: Any) -> AsyncIterator["Job"]:
        """The jobs of the service: arguments of `scatterd.Client.jobs`."""
        async for job in iterate(self.plain, self.plain.jobs(**filters)):
            yield Job(self, job)

    def map(self, requests: Iterable[Mapping], process: str = "solve", *,
            errors: str = "raise", **options: Any) -> AsyncIterator[Any]:
        """Results of many requests: as `scatterd.Client.map`."""
        asked = Requests(self.plain, requests, process, ordered=True, **options)
        return iterate(self.plain, asked.results(errors), asked.stop)

    def as_completed(self, requests: Iterable[Mapping], process: str = "solve",
                     **options: Any) -> AsyncIterator[tuple[int, Any]]:
        """The same as pairs in the order in which they end."""
        asked = Requests(self.plain, requests, process, ordered=False, **options)
        return iterate(self.plain, asked.outcomes(), asked.stop)

    async def close(self) -> None:
        """Ends its threads, and closes their connections."""
        kept = self.plain.transport.kept()  # a thread that ends forgets its own
        for pool in (self.asking, self.waiting):
            await asyncio.to_thread(pool.shutdown, cancel_futures=True)
        for connection in kept:
            connection.close()

    async def __aenter__(self) -> "Client":
        return self

    async def __aexit__(self, *_: object) -> None:
        await self.close()


class Job:
    """A job at the service; `await job` is its result.

    Attributes:
        plain: the same job for threads.
    """

    def __init__(self, client: Client, job: plain_job.Job):
        self.client, self.plain = client, job

    @property
    def id(self) -> str:
        return self.plain.id

    @property
    def info(self) -> dict:
        """What the service last told of it."""
        return self.plain.info

    async def status(self) -> str:
        """accepted, running, successful, failed or dismissed."""
        return await run(self.client.asking, lambda: self.plain.status)

    async def wait(self, timeout: float | None = None,
                   progress: bool | plain_job.Progress = False) -> "Job":
        """Waits until it is over: arguments of `scatterd.Job.wait`."""
        tell = Bar() if progress is True else progress or None
        changes = self.plain.changes(timeout, news=tell is not None, slice=SLICE)
        try:
            while await run(self.client.waiting, next, changes, None) is not None:
                plain_job.show(tell, self.plain.info)
        finally:
            if isinstance(tell, Bar):
                tell.close()
        return self

    async def result(self, timeout: float | None = None) -> Any:
        """Waits until it is over, and gives its result: as `scatterd.Job.result`."""
        await self.wait(timeout)
        return await run(self.client.asking, self.plain.result)

    def __await__(self) -> Generator[Any, None, Any]:
        return self.result().__await__()

    async def cancel(self) -> "Job":
        """Stops it if it is not over, and drops its results if it is."""
        await run(self.client.asking, self.plain.cancel)
        return self

    def events(self, after: str = "") -> AsyncIterator[Event]:
        """What happens to it, as it happens, until it is over."""
        return iterate(self.plain.client, self.plain.events(after))

    def __repr__(self) -> str:
        return f"aio.{self.plain!r}"


async def run(pool: ThreadPoolExecutor, function: Callable, *arguments: Any, **options: Any) -> Any:
    """What a function returns, called in a thread of a pool."""
    call = functools.partial(function, *arguments, **options)
    return await asyncio.get_running_loop().run_in_executor(pool, call)


async def iterate(client: plain.Client, items: Any,
                  leave: Callable[[], None] = lambda: None) -> AsyncIterator[Any]:
    """The items of a generator that waits, which is run in a thread. When the reader goes,
    leave() is called, and the generator closed after its next item."""
    feed = Feed(client, items)
    threading.Thread(target=feed.fill, daemon=True).start()
    try:
        async for item in feed.items():
            yield item
    finally:
        await asyncio.to_thread(feed.stop, leave)


class Feed:
    """Items on their way from a thread to the loop it was made in."""

    def __init__(self, client: plain.Client, source: Any):
        self.client, self.source = client, source
        self.loop = asyncio.get_running_loop()
        self.queue: asyncio.Queue = asyncio.Queue()  # (is it the end?, item or error)
        self.room = threading.Semaphore(AHEAD)
        self.is_left = False

    def fill(self) -> None:
        """Runs in the thread, until the end or until the reader has left."""
        error = None
        try:
            for item in self.source:
                self.room.acquire()
                if self.is_left:
                    break
                self.put(False, item)
            self.source.close()
        except BaseException as caught:
            error = caught
        self.client.close()  # the connection of this thread
        self.put(True, error)

    def stop(self, leave: Callable[[], None]) -> None:
        self.is_left = True
        self.room.release()
        leave()
        self.client.close()

    def put(self, is_end: bool, item: Any) -> None:
        with contextlib.suppress(RuntimeError):  # the loop has ended
            self.loop.call_soon_threadsafe(self.queue.put_nowait, (is_end, item))

    async def items(self) -> AsyncIterator[Any]:
        while True:
            is_end, item = await self.queue.get()
            self.room.release()
            if is_end and item is not None:
                raise item
            if is_end:
                return
            yield item
