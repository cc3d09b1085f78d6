"""Laws of drives, one file each: friction, rotors, springs. A new law is a file here and a line in
`LAWS`, behind the usual ones."""

from __future__ import annotations

from typing import Literal

from freebody.model.drives import (
    asymmetric,
    cogging,
    coulomb,
    cube_root,
    efficiency,
    hardening,
    load,
    offset,
    quadratic,
    rotor,
    saturating,
    spring,
    stribeck,
    viscous,
)
from freebody.model.drives.law import DriveLaw, LawNumber

LAWS: dict[str, DriveLaw] = {
    law.name: law
    for law in (
        viscous.LAW,
        coulomb.LAW,
        rotor.LAW,
        spring.LAW,
        stribeck.LAW,
        offset.LAW,
        asymmetric.LAW,
        quadratic.LAW,
        cube_root.LAW,
        saturating.LAW,
        hardening.LAW,
        cogging.LAW,
        load.LAW,
        efficiency.LAW,
    )
}

NUMBERS: dict[str, LawNumber] = {
    number.name: number for law in LAWS.values() for number in law.numbers
}
"""The numbers of all laws, by the names of `Drive`'s attributes."""


def assumed_by(function: Literal["identify", "excitation"]) -> tuple[str, ...]:
    """Names of the laws that a function counts on at each joint unless it is given others."""
    return tuple(law.name for law in LAWS.values() if function in law.assumed_by)


__all__ = ["LAWS", "NUMBERS", "DriveLaw", "LawNumber", "assumed_by"]
