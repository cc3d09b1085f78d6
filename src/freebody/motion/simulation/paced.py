"""Progress that is told now and then, not at every step."""

from __future__ import annotations

import time
from collections.abc import Callable

_EVERY = 0.05  # s

Progress = Callable[[str, float], None]
"""A text, and the part that is done (0 to 1)."""


def paced(progress: Progress | None, text: str) -> Callable[[float], None]:
    """A function of the part that is done, quick to call often; of None one that does nothing."""
    if progress is None:
        return lambda done: None
    last = -float("inf")

    def tell(done: float) -> None:
        nonlocal last
        now = time.monotonic()
        if now - last >= _EVERY:
            last = now
            progress(text, min(1.0, done))

    return tell
