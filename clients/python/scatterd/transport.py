"""HTTP over one kept connection per thread: tcp, tls, or a Unix socket."""

from __future__ import annotations

import contextlib
import http.client
import socket
import ssl
import threading
import weakref
from typing import Iterator, NamedTuple
from urllib.parse import urlsplit

from .errors import UnreachableError


SILENCE = 60.0  # seconds after which a stream counts as broken; the service's beats come oftener


class Answer(NamedTuple):
    """An HTTP answer with its whole body."""

    status: int
    headers: http.client.HTTPMessage
    body: bytes


class Stream(NamedTuple):
    """An HTTP answer whose body comes line by line for as long as it goes on."""

    status: int
    headers: http.client.HTTPMessage
    response: http.client.HTTPResponse
    connection: http.client.HTTPConnection

    def lines(self) -> Iterator[bytes]:
        """Its lines until it ends, by itself or because the connection broke."""
        with contextlib.suppress(http.client.HTTPException, OSError):
            yield from self.response

    def close(self) -> None:
        self.response.close()
        self.connection.close()


def trusting(ca: str | None) -> ssl.SSLContext:
    """What checks the certificate of a service."""
    context = ssl.create_default_context()
    if ca:
        context.load_verify_locations(ca)
    return context


class UnixConnection(http.client.HTTPConnection):
    """HTTP over a Unix socket."""

    def __init__(self, path: str, timeout: float | None):
        super().__init__("localhost", timeout=timeout)
        self.path = path

    def connect(self) -> None:
        self.sock = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        if self.timeout is not None:
            self.sock.settimeout(self.timeout)
        self.sock.connect(self.path)


class Transport:
    """Sends requests to the service at `url`: http://, https:// or unix:PATH; `ca` is a file of
    certificates to trust beside those of the system."""

    def __init__(self, url: str, timeout: float | None, ca: str | None = None):
        self.url = url
        self.timeout = timeout
        self.context = trusting(ca) if url.startswith("https:") else None
        self.prefix = "" if url.startswith("unix:") else urlsplit(url).path.rstrip("/")
        self.local = threading.local()
        self.all: weakref.WeakSet[http.client.HTTPConnection] = weakref.WeakSet()
        self.lock = threading.Lock()  # of all
        self.has_answered = False  # ever
        self.make()  # complains about the address now rather than at the first request

    def make(self) -> http.client.HTTPConnection:
        """A connection, not yet open."""
        if self.url.startswith("unix:"):
            return UnixConnection(self.url.removeprefix("unix:").removeprefix("//"), self.timeout)
        parts = urlsplit(self.url)
        if parts.scheme not in ("http", "https") or not parts.hostname:
            raise ValueError(f"address {self.url!r} is none of http://..., https://..., unix:PATH")
        if parts.scheme == "http":
            return http.client.HTTPConnection(parts.hostname, parts.port, timeout=self.timeout)
        return http.client.HTTPSConnection(
            parts.hostname, parts.port, timeout=self.timeout, context=self.context
        )

    def request(
        self, method: str, path: str, body: bytes | None, headers: dict[str, str]
    ) -> Answer:
        """One request and its answer. A kept connection that has died is opened anew once; a
        request can be repeated because a second one changes nothing at the service: executions
        keep nothing, and what accepts a job carries an Idempotency-Key."""
        with self.complaining():
            kept = getattr(self.local, "connection", None)
            if kept is not None:
                try:
                    return self.exchange(kept, method, path, body, headers)
                except (http.client.RemoteDisconnected, ConnectionError):
                    self.close()
            self.local.connection = self.make()
            with self.lock:
                self.all.add(self.local.connection)
            return self.exchange(self.local.connection, method, path, body, headers)

    @contextlib.contextmanager
    def complaining(self) -> Iterator[None]:
        """Makes whatever goes wrong on the way an UnreachableError."""
        try:
            yield
        except TimeoutError as error:
            self.close()
            raise UnreachableError(self.url, f"no answer within {self.timeout:g} s") from error
        except (http.client.HTTPException, OSError) as error:
            self.close()
            raise UnreachableError(self.url, error, passing=self.has_answered) from error

    def open(self, path: str, headers: dict[str, str]) -> "Answer | Stream":
        """The answer to a GET as a stream, on a connection of its own; if it is not 200, as it
        is."""
        connection = self.make()
        connection.timeout = min(self.timeout or SILENCE, SILENCE)
        with self.complaining():
            connection.request("GET", self.prefix + path, None, headers)
            response = connection.getresponse()
            self.has_answered = True
            if response.status == 200:
                return Stream(200, response.headers, response, connection)
            with contextlib.closing(connection):
                return Answer(response.status, response.headers, response.read())

    def exchange(
        self,
        connection: http.client.HTTPConnection,
        method: str,
        path: str,
        body: bytes | None,
        headers: dict[str, str],
    ) -> Answer:
        connection.request(method, self.prefix + path, body, headers)
        response = connection.getresponse()
        self.has_answered = True
        content = response.read()
        if response.will_close:
            self.close()
        return Answer(response.status, response.headers, content)

    def close(self) -> None:
        """Closes this thread's connection; the next request opens another."""
        connection = getattr(self.local, "connection", None)
        if connection is not None:
            connection.close()
            self.local.connection = None

    def kept(self) -> list[http.client.HTTPConnection]:
        """The connections of all threads, for whoever closes them."""
        with self.lock:
            return list(self.all)
