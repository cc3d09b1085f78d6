"""Rules on the limits of one joint, each with its test: they are asked when a model is made, where
limits are used, and by `doctor`."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

from freebody.outputs.number_text import compared


class LimitRule(NamedTuple):
    """A rule: which limits it is about, whether their values break it, and what is said of those
    that do."""

    about: tuple[str, ...]
    broken: Callable[..., bool]
    said: Callable[..., str]


def _swap_them(lower: float, upper: float) -> str:
    low, high = compared(lower, upper, digits=6)
    return (
        f"lower limit {low} is above upper {high}; swap them, or leave both out where there are "
        f"none"
    )


SWAPPED = LimitRule(("lower", "upper"), lambda lower, upper: lower > upper, _swap_them)
UNREACHABLE = LimitRule(
    ("lower", "upper"),
    lambda lower, upper: lower == math.inf or upper == -math.inf,
    lambda lower, upper: "no position lies between its limits; make one finite",
)
NEGATIVE = tuple(
    LimitRule(
        (name,),
        lambda most: most < 0.0,
        lambda most, name=name: f"{name} limit {most:g} is negative; give its size",
    )
    for name in ("velocity", "effort")
)
NO_JOINT_HAS = (SWAPPED, UNREACHABLE, *NEGATIVE)
"""Rules without which a model is refused, in this order."""


def is_not_given(*values: Any) -> bool:
    """Whether a limit of speed or effort, or the two of a range, are what files write where they
    give none: 0, or a range of no width."""
    return bool(values[0] == 0.0 if len(values) == 1 else values[0] == values[1])
