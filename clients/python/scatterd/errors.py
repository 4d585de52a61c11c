"""What can go wrong, in words that name the culprit."""

from __future__ import annotations

from typing import Any, NamedTuple


class Culprit(NamedTuple):
    """One value of a request that is wrong."""

    pointer: str  #: JSON Pointer into the request, such as /inputs/cloud/points/3
    detail: str  #: what is wrong with it


class ScatterdError(Exception):
    """The service refused a request or failed at it (RFC 9457 problem).

    Attributes:
        status: HTTP status; 0 if no answer came.
        title: the kind of problem.
        detail: this problem in words, "" if there is nothing to add.
        errors: the culprits, as (pointer, detail).
        problem: the whole problem document.
    """

    def __init__(self, status: int, title: str, detail: str = "", problem: Any = None):
        self.status = status
        self.title = title
        self.detail = detail
        self.problem = problem if isinstance(problem, dict) else {}
        self.errors = [
            Culprit(entry.get("pointer", ""), entry.get("detail", ""))
            for entry in self.problem.get("errors", [])
        ]
        super().__init__(status, title, detail)

    @classmethod
    def from_problem(cls, status: int, problem: dict) -> "ScatterdError":
        """The error that a problem document tells of."""
        title = problem.get("title") or f"HTTP status {status}"
        return cls(status, title, problem.get("detail", ""), problem)

    def __str__(self) -> str:
        head = f"{self.status} {self.title}" if self.status else self.title
        culprits = [f"{pointer or 'the body'}: {detail}" for pointer, detail in self.errors]
        is_repeated = culprits and self.detail.startswith(culprits[0])
        lines = [f"{head}: {self.detail}" if self.detail and not is_repeated else head]
        return "\n".join(lines + [f"  {culprit}" for culprit in culprits])


class UnreachableError(ScatterdError, ConnectionError):
    """No service answers at the address.

    Attributes:
        passing: is it worth while to ask again soon? The service was there before.
    """

    def __init__(self, url: str, reason: object, passing: bool = False):
        detail = f"{reason}\n  Start one with: scatterd\n  or name another with Client(url), --url"
        super().__init__(0, f"no scatterd at {url}", f"{detail} or SCATTERD_URL")
        self.passing = passing
