"""Reaction wrenches of joints and loops over motions, as far as rigid bodies determine them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Literal

import numpy as np

from freebody.any_chain.dynamics import joint_wrenches
from freebody.any_chain.reactions import reactions
from freebody.arrays import Array
from freebody.errors import listed
from freebody.model.model import Model


def known_wrenches(
    model: Model, q: Array, qd: Array, qdd: Array, wrenches: Any, axes: Literal["world", "child"]
) -> Array:
    """Wrenches (T, joints and loops, 6 or 3) as of `joint_wrenches`, NaN where a closed chain is
    held more than once, so that what its parts share is not determined."""
    if not model.loops:
        return joint_wrenches(model, q, qd, qdd, wrenches, axes)
    found = reactions(model, q, qd, qdd=qdd, wrenches=wrenches, reference=axes)
    return np.where(found.determined, found.wrenches, np.nan)


def undetermined(places: Sequence[str]) -> tuple[str, ...]:
    """The sentence on joints whose loads are not all determined; none where there is no such."""
    if not places:
        return ()
    return (
        f"nan at {listed(map(repr, places), 8)}: the mechanism is held more than once there, so "
        f"that its parts share a load as they yield, which rigid bodies do not tell.",
    )
