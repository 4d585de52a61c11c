"""Server-sent events: a stream of lines as events (HTML standard, section 9.2)."""

from __future__ import annotations

import json
from typing import Any, Iterable, Iterator, NamedTuple

OVER = ("successful", "failed", "dismissed")  #: states that a job does not leave
STATES = ("accepted", "running", *OVER)


class Event(NamedTuple):
    """What a job told."""

    id: str  #: place in the stream, for Last-Event-ID
    kind: str  #: status, progress or phase
    data: Any  #: of a status the whole statusInfo, else {"progress", "phase"}

    @property
    def is_end(self) -> bool:
        """Is the job over by it?"""
        return self.kind == "status" and self.data.get("status") in OVER


def parse(lines: Iterable[bytes]) -> Iterator[Event]:
    """Events of a stream. One that breaks off before its empty line is none; comments, which keep
    the connection alive, are left out."""
    last, fields = "", {}
    for line in lines:
        text = line.decode("utf-8").rstrip("\r\n")
        if not text:
            last = fields.get("id", last)
            if "data" in fields:
                yield Event(last, fields.get("event", "message"), json.loads(fields["data"]))
            fields = {}
            continue
        name, _, value = text.partition(":")
        value = value[1:] if value.startswith(" ") else value
        if name == "data" and "data" in fields:
            value = fields["data"] + "\n" + value
        if name:
            fields[name] = value
