"""A progress bar."""

from __future__ import annotations

import sys
import time


class Bar:
    """A progress bar on standard error; on a terminal it stays on its line."""

    WIDTH = 30

    def __init__(self) -> None:
        self.begun = time.monotonic()
        self.is_terminal = sys.stderr.isatty()
        self.is_open = False
        self.shown = -1

    def __call__(self, share: float, what: str) -> None:
        share = 1.0 if share > 1 - 1e-9 else share
        line = (f"[{'#' * int(share * self.WIDTH):{self.WIDTH}s}] {share:4.0%} "
                f"{time.monotonic() - self.begun:5.0f} s  {what[:40]:40s}")
        if self.is_terminal:
            self.is_open = share < 1
            print("\r" + line, end="" if self.is_open else "\n", file=sys.stderr, flush=True)
        elif int(share * 10) > self.shown:
            self.shown = int(share * 10)
            print(line.rstrip(), file=sys.stderr, flush=True)

    def close(self) -> None:
        """Ends its line, if it has not come to 100 %."""
        if self.is_open:
            self.is_open = False
            print(file=sys.stderr, flush=True)
