"""What an answer of the service says: its document, or the error it tells of."""

from __future__ import annotations

from typing import Any

from . import wire
from .errors import ScatterdError
from .transport import Answer


def content(answer: Answer) -> Any:
    """The document in it."""
    coding = answer.headers.get("Content-Encoding", "")
    return wire.decode(answer.body, answer.headers.get("Content-Type", wire.JSON), coding)


def failure(answer: Answer) -> ScatterdError:
    """The error an answer tells of, also if it is no problem document (of a proxy, say)."""
    try:
        problem = content(answer)
    except ValueError:
        problem = None
    if isinstance(problem, dict):
        return ScatterdError.from_problem(answer.status, problem)
    excerpt = answer.body[:200].decode("utf-8", "replace").strip()
    return ScatterdError(answer.status, f"HTTP status {answer.status}", excerpt)
