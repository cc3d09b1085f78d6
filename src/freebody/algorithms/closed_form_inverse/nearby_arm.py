"""The arm with a closed form that a calibrated one nearly is: axes that are nearly parallel made
so, and axes that nearly meet made to meet."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from freebody.algorithms.joint_lines import common_point, nearest_points
from freebody.algorithms.screws import Screw, ScrewChain

NEARLY = 0.03
"""Axes as near to parallel (rad), and to each other (of the arm's length), are so but for errors of
making."""


def nearby(chain: ScrewChain) -> ScrewChain:
    """The chain with its axes in order."""
    screws = _straightened(chain.screws)
    reach, met = NEARLY * chain.length, [False] * len(screws)
    for first in (len(screws) - 3, 0):  # a wrist, a shoulder
        three = screws[first : first + 3] if first >= 0 else []
        if len(three) == 3 and _may_meet(three) and not any(met[first : first + 3]):
            c = common_point(three, reach / 1e-9)
            if c is not None:
                screws[first : first + 3] = [replace(s, p=c) for s in three]
                met[first : first + 3] = [True] * 3
    for i in range(len(screws) - 1):
        one, other = screws[i : i + 2]
        if not met[i + 1] and _may_meet((one, other)):
            a, b = nearest_points(one, other)
            if float(np.linalg.norm(a - b)) < reach:
                screws[i + 1] = replace(other, p=other.p + a - b)
    return replace(chain, screws=tuple(screws))


def _straightened(screws: Sequence[Screw]) -> list[Screw]:
    """Each axis along the first one that it is nearly parallel to."""
    done: list[Screw] = []
    for s in screws:
        for other in done:
            if float(np.linalg.norm(np.cross(s.w, other.w))) < NEARLY:
                s = replace(s, w=other.w * np.sign(s.w @ other.w))
                break
        done.append(s)
    return done


def _may_meet(screws: Sequence[Screw]) -> bool:
    """Whether axes turn, none of them nearly parallel to the next."""
    crossed = all(float(np.linalg.norm(np.cross(a.w, b.w))) > NEARLY for a, b in pairwise(screws))
    return crossed and all(s.turning for s in screws)
