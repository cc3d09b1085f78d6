"""Numbers of a law that are quotients of its parameters."""

from __future__ import annotations

from typing import Any

import numpy as np

from freebody.errors import ModelError


def quotient(part: Any, whole: Any, otherwise: Any, what: str, owner: str) -> Any:
    """part / whole; `otherwise` where both are 0. Raises ModelError, which names `what` and the
    owner, where the whole alone is 0."""
    if np.any((whole == 0.0) & (part != 0.0)):
        raise ModelError(f"{owner}: {what}.")
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(whole == 0.0, otherwise, part / whole)
