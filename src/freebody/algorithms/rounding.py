"""Limits below which a difference counts as rounding, in numbers of any length."""

from __future__ import annotations

from freebody.elementary import Scalar, epsilon, maximum


def no_finer(limit: float, x: Scalar, roundings: float) -> Scalar:
    """The limit, relative; of numbers with fewer digits as many of their roundings.

    roundings: how many units of rounding of x's type what is compared may well have gathered.
    """
    return maximum(limit, roundings * epsilon(x))
