"""Joint kinds, one file each; a new kind is a file here and a line in `KINDS`."""

from __future__ import annotations

from freebody.model.joints.cylindrical import Cylindrical
from freebody.model.joints.fixed import Fixed
from freebody.model.joints.free import Free
from freebody.model.joints.helical import Helical
from freebody.model.joints.kind import JointKind, JointWords, Primitive
from freebody.model.joints.planar import Planar
from freebody.model.joints.prismatic import Prismatic
from freebody.model.joints.revolute import Continuous, Revolute
from freebody.model.joints.spherical import Spherical
from freebody.model.joints.universal import Universal

KINDS: dict[str, JointKind] = {
    kind.name: kind
    for kind in (
        Revolute(),
        Continuous(),
        Prismatic(),
        Helical(),
        Fixed(),
        Cylindrical(),
        Universal(),
        Planar(),
        Spherical(),
        Free(),
    )
}

BY_LETTER: dict[str, str] = {kind.letter: kind.name for kind in KINDS.values() if kind.letter}
"""Names of kinds by their letter in planar words and DH tables."""

__all__ = ["BY_LETTER", "KINDS", "JointKind", "JointWords", "Primitive"]
