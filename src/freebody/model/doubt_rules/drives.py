"""Rules on drives: what no motor has, and what is not given of one."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import isfinite
from typing import TYPE_CHECKING

from freebody.errors import listed
from freebody.model.doubt_rules.aspects import NAMES
from freebody.model.drives import LAWS
from freebody.model.quantity_reader import VALUES

if TYPE_CHECKING:
    from freebody.model.model import Model


def no_drive(model: Model, _: Sequence[str]) -> Iterator[str]:
    wrong = [
        f"joint {body.joint.name!r}: {fault}"
        for body in model.bodies
        if (fault := body.joint.drive.fault())
    ]
    if wrong:
        more = f" ({len(wrong) - 1} more)" if len(wrong) > 1 else ""
        yield f"no motor has such a drive: {wrong[0]}{more}."


_ROTORS = tuple(law.strength for law in LAWS.values() if law.inertia is not None)


def no_rotor(model: Model, _: Sequence[str]) -> Iterator[str]:
    """Rotor inertias that are missing in joints whose drive is described otherwise; a textbook's
    have none."""
    described_joints, without = 0, []
    for body in model.bodies:
        limits, drive = body.joint.limits.meant, body.joint.drive
        described = isfinite(limits.effort) or isfinite(limits.velocity)
        if body.joint.passive or body.joint.mimic or body.kind.nv != 1 or not described:
            continue
        described_joints += 1
        if all(VALUES.quantity(getattr(drive, name)) == 0.0 for name in _ROTORS):
            without.append(body.joint.name)
    if without:
        of = "" if len(without) == described_joints else f" of {listed(without, NAMES)}"
        yield f"rotor inertia{of} is not given; its torque is left out."
