"""HTTP over one kept connection per thread: tcp, tls, or a Unix socket."""

from __future__ import annotations

import http.client
import socket
import threading
from typing import NamedTuple
from urllib.parse import urlsplit

from .errors import UnreachableError


class Answer(NamedTuple):
    """An HTTP answer with its whole body."""

    status: int
    headers: http.client.HTTPMessage
    body: bytes


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
    """Sends requests to the service at `url`: http://, https:// or unix:PATH."""

    def __init__(self, url: str, timeout: float | None):
        self.url = url
        self.timeout = timeout
        self.prefix = "" if url.startswith("unix:") else urlsplit(url).path.rstrip("/")
        self.local = threading.local()
        self.make()  # complains about the address now rather than at the first request

    def make(self) -> http.client.HTTPConnection:
        """A connection, not yet open."""
        if self.url.startswith("unix:"):
            return UnixConnection(self.url.removeprefix("unix:").removeprefix("//"), self.timeout)
        parts = urlsplit(self.url)
        kinds = {"http": http.client.HTTPConnection, "https": http.client.HTTPSConnection}
        if parts.scheme not in kinds or not parts.hostname:
            raise ValueError(f"address {self.url!r} is none of http://..., https://..., unix:PATH")
        return kinds[parts.scheme](parts.hostname, parts.port, timeout=self.timeout)

    def request(
        self, method: str, path: str, body: bytes | None, headers: dict[str, str]
    ) -> Answer:
        """One request and its answer. A kept connection that has died is opened anew once; a
        request can be repeated because none changes anything at the service."""
        kept = getattr(self.local, "connection", None)
        if kept is not None:
            try:
                return self.exchange(kept, method, path, body, headers)
            except (http.client.RemoteDisconnected, ConnectionError):
                self.close()
        self.local.connection = self.make()
        try:
            return self.exchange(self.local.connection, method, path, body, headers)
        except TimeoutError as error:
            self.close()
            raise UnreachableError(self.url, f"no answer within {self.timeout:g} s") from error
        except (http.client.HTTPException, OSError) as error:
            self.close()
            raise UnreachableError(self.url, error) from error

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
