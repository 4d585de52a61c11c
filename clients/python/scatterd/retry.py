"""Asking again: exponential back-off with jitter, and Retry-After where the service says when."""

from __future__ import annotations

import random
import time
from dataclasses import dataclass
from datetime import datetime, timezone
from email.utils import parsedate_to_datetime
from typing import Any, Callable, Mapping

from .errors import UnreachableError

FULL, BUSY = 429, 503  # the queue of jobs is full; no worker, stream or memory is free


@dataclass(frozen=True)
class Retry:
    """How often to ask again, and how long to wait before.

    A request is repeated after 429, 503, and a connection that was lost. A service that has never
    answered is not waited for, nor one that was silent for the whole timeout.

    Attributes:
        attempts: requests at most, the first one included; 1 never repeats.
        attempts_full: the same as long as the queue of jobs is full (429).
        first: longest wait before the second request (s); it doubles with each one.
        most: longest wait without a Retry-After (s).
        sleep: waits so many seconds.
    """

    attempts: float = 6
    attempts_full: float = 6
    first: float = 0.5
    most: float = 30.0
    sleep: Callable[[float], Any] = time.sleep

    def run(self, ask: Callable[[], Any]) -> Any:
        """The answer of ask(), which has `status` and `headers`: the first that is neither 429 nor
        503, or the last one."""
        attempt = 1
        while True:
            try:
                answer = ask()
            except UnreachableError as error:
                if not error.passing or attempt >= self.attempts:
                    raise
                after = 0.0
            else:
                if attempt >= self.limit(answer.status):
                    return answer
                after = retry_after(answer.headers)
            self.pause(attempt, after)
            attempt += 1

    def limit(self, status: int) -> float:
        """Requests at most, if one was answered so."""
        return {FULL: self.attempts_full, BUSY: self.attempts}.get(status, 0)

    def pause(self, attempt: int, after: float = 0.0) -> None:
        """Waits after request number `attempt` (1, ...): what the service asks for, and a random
        part of the back-off, so that many clients do not return at once."""
        backoff = min(self.most, self.first * 2 ** min(attempt - 1, 30))
        self.sleep(after + backoff * random.uniform(0.5, 1.0))


def retry_after(headers: Mapping[str, str]) -> float:
    """Seconds that a Retry-After field asks for, a number or a date; 0 without one."""
    text = headers.get("Retry-After", "").strip()
    if text.isdigit():
        return float(text)
    try:
        date = parsedate_to_datetime(text)
    except (TypeError, ValueError, IndexError):
        return 0.0
    aware = date if date.tzinfo else date.replace(tzinfo=timezone.utc)
    return max(0.0, (aware - datetime.now(timezone.utc)).total_seconds())
