"""Findings on shapes: meshes that are not there, and masses that do not fit what shapes fill."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from freebody.arrays import Array
from freebody.diagnosis.facts import LinkFacts, RobotFacts, norm
from freebody.diagnosis.finding import FileLine, FindingKind, FoundFault
from freebody.errors import FreebodyError, listed
from freebody.formats.masses import filled_shapes
from freebody.lazy import kept
from freebody.model.description import Link
from freebody.model.inertia import Inertia, combined
from freebody.model.placement import ArrayPose
from freebody.model.shapes import DENSEST, LIGHTEST

_OUTSIDE = 5.0
"""Standard deviations of a shape's volume at which its ends are far away."""
_APART = 8.0
"""Factor between the widths of a mass and of its shape that no hollow or dense part explains."""
_TINY = 0.005
"""Share of the robot's mass that is passed over: sensors and frames have placeholders."""
_PRODUCTS = 0.02
"""Product of inertia, as a share of the sum of moments, whose sign tells something."""


class _FilledLinks(NamedTuple):
    """Links that are fixed together, the heaviest group first: mass, centre and tensor as written,
    and volume, centre and tensor of their shapes at density 1."""

    link: LinkFacts
    mass: float
    com: Array
    tensor: Array
    volume: float
    centre: Array
    filled: Array


def _missing(facts: RobotFacts) -> Iterator[FoundFault]:
    told: set[str] = set()
    for link in facts.links:
        for shape in link.shapes:
            if shape.kind != "mesh" or shape.file in told:
                continue
            told.add(shape.file)
            package = shape.file.partition("://")[2].partition("/")[0]
            known = "://" not in shape.file or facts.packages.find(package) is not None
            if known and facts.packages.located(shape.file) is None:
                yield FoundFault(
                    f"link {link.name!r}: its mesh {shape.file!r} is not there", shape.line
                )


def _unknown_package(facts: RobotFacts) -> Iterator[FoundFault]:
    lost: dict[str, FileLine] = {}
    for link in facts.links:
        for shape in link.shapes:
            scheme, colon, rest = shape.file.partition("://")
            package = rest.partition("/")[0]
            if not colon or scheme not in ("package", "model") or package in lost:
                continue
            if not facts.packages.find(package) and facts.packages.located(shape.file) is None:
                lost[package] = shape.line
    if lost:
        reason = f"meshes are not looked at: no package {listed(map(repr, lost), 4)} is around"
        yield FoundFault(reason, next(iter(lost.values())))


def _solids(facts: RobotFacts) -> list[_FilledLinks]:
    """Groups of links that are fixed together and whose shapes can all be filled, meshes included
    where their files and trimesh are there; groups of almost no mass are left out."""
    return kept(facts, "solids", _found_solids, facts)


def _found_solids(facts: RobotFacts) -> list[_FilledLinks]:
    groups = (_solid(facts, group) for group in facts.groups.values())
    return [solid for solid in groups if solid is not None and solid.mass > _TINY * facts.mass]


def _solid(facts: RobotFacts, group: list[tuple[LinkFacts, ArrayPose]]) -> _FilledLinks | None:
    weighed = [(x, x.inertia, pose) for x, pose in group if x.inertia and any(x.inertia.tensor)]
    if facts.dim != 3 or not weighed or min(x.numbers()[0] for _, x, _ in weighed) <= 0.0:
        return None
    filled = []
    for link, pose in group:
        try:
            own = _at_density_one(facts, link)
        except FreebodyError:  # a mesh that is not there or not read, or no trimesh
            return None
        filled += [own.placed(*pose)] if own is not None else []
    shape = combined(filled) if filled else None
    if shape is None or not np.linalg.eigvalsh(shape.numbers()[2])[0] > 0.0:
        return None
    whole = combined([inertia.placed(*pose) for _, inertia, pose in weighed])
    link = max(weighed, key=lambda entry: entry[1].numbers()[0])[0]
    return _FilledLinks(link, *whole.numbers(), *shape.numbers())


def _at_density_one(facts: RobotFacts, link: LinkFacts) -> Inertia | None:
    if link.shapes not in facts.filled:
        plain = Link(link.name, shapes=link.shapes)
        facts.filled[link.shapes] = filled_shapes(plain, facts.file, facts.packages)
    return facts.filled[link.shapes]


def _density(facts: RobotFacts) -> Iterator[FoundFault]:
    for solid in _solids(facts):
        density = solid.mass / solid.volume
        if not LIGHTEST <= density <= DENSEST:
            yield FoundFault(
                f"link {solid.link.name!r}: {solid.mass:.3g} kg in {1e3 * solid.volume:.3g} litres "
                f"is a density of {density:.2g} kg/m³",
                solid.link.inertia_line,
            )


def _second(tensor: Array, mass: float) -> Array:
    """Second moments of mass about the centre per unit of mass (m²), from an inertia tensor."""
    return (0.5 * np.trace(tensor) * np.eye(3) - tensor) / mass


def _outside(facts: RobotFacts) -> Iterator[FoundFault]:
    for solid in _solids(facts):
        off = solid.com - solid.centre
        far = np.sqrt(off @ np.linalg.solve(_second(solid.filled, solid.volume), off))
        if far > _OUTSIDE and norm(off) > 0.02 * facts.reach:
            yield FoundFault(
                f"link {solid.link.name!r}: its centre of mass is {norm(off):.3g} m from the "
                f"centre of its shapes, outside them",
                solid.link.inertia_line,
            )


def _unlike(facts: RobotFacts) -> Iterator[FoundFault]:
    for solid in _solids(facts):
        shape, own = _second(solid.filled, solid.volume), _second(solid.tensor, solid.mass)
        root = np.linalg.cholesky(shape)
        widths = np.linalg.eigvalsh(np.linalg.solve(root, np.linalg.solve(root, own).T))
        high = math.sqrt(max(float(widths[-1]), 0.0))
        if high > _APART or high < 1.0 / _APART:
            what = "too large" if high > 1.0 else "too small"
            reason = f"link {solid.link.name!r}: its inertia is {what} for its shapes"
            times = f"by a factor of {high**2:.2g}"
            yield FoundFault(f"{reason}, {times}", solid.link.inertia_line)


def _signs(facts: RobotFacts) -> Iterator[FoundFault]:
    """Findings of files where the products of inertia of most links have the opposite sign of their
    shapes' products."""
    votes = {1: 0, -1: 0}
    first = None
    for solid in _solids(facts):
        for i, j in ((0, 1), (0, 2), (1, 2)):
            own, other = (float(x[i, j]) / float(np.trace(x)) for x in (solid.tensor, solid.filled))
            if min(abs(own), abs(other)) > _PRODUCTS:
                votes[1 if own * other > 0.0 else -1] += 1
                first = first or solid
    if first is not None and votes[-1] >= 3 and votes[-1] > 3 * votes[1]:
        yield FoundFault(
            f"{votes[-1]} of {sum(votes.values())} products of inertia have the other sign than "
            f"those of the shapes",
            first.link.inertia_line,
        )


MISSING = FindingKind("missing mesh", "warning", "correct its path", _missing)
UNKNOWN_PACKAGE = FindingKind(
    "unknown package", "notice", "package_path= names folders of packages", _unknown_package
)
DENSITY = FindingKind("density", "warning", "correct its mass, or its shapes", _density)
OUTSIDE = FindingKind("centre outside", "warning", "correct it, or the shapes", _outside)
UNLIKE = FindingKind("inertia unlike shape", "warning", "correct it, or the shapes", _unlike)
SIGNS = FindingKind(
    "signs of products", "warning",
    "CAD programs export +∫xy dm; a file needs −∫xy dm", _signs,
)  # fmt: skip
