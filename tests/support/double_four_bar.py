"""The double four-bar: IFToMM library of computational benchmark problems, N-four-bar mechanism (N
= 2)."""

from __future__ import annotations

import numpy as np

TIP = {4.0: (0.11761610237558555, 0.99305913845147), 10.0: (0.3284581115336901, 0.9445185381810788)}
"""Time -> the tip of the first crank, as published."""


def cranks(theta: float, rate: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """All three cranks at one angle: O1, A1, O2, A2, O3."""
    return theta * np.array([1.0, -1, 1, -1, 1]), rate * np.array([1.0, -1, 1, -1, 1])
