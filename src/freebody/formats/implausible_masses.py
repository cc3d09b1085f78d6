"""Masses in a file that cannot be the robot's: missing, placeholders, implausible.

The bars are wide: they are to find what is wrong, not what is unusual. All are about bodies that
move.

- Missing: a body without mass and inertia, where its links have shapes or where nothing that it
  carries has mass either (a body in between that has neither shape nor mass is how several freedoms
  are put into one place).
- Placeholder: the same numbers for links that carry one another, round and alike about all axes; or
  the same, however written, for three such links of different length. Links beside each other
  (legs, fingers) may well be alike.
- Implausible, of all that is fixed together: a radius of gyration, or a centre of mass, far outside
  it, or a radius far too small; a density above that of any metal, below that of any foam, where
  all shapes are boxes, cylinders, spheres.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from freebody.errors import listed
from freebody.model.bodies import Body
from freebody.model.doubts import IMPLAUSIBLE, NO_MASSES, Doubt, is_bare, weighs
from freebody.model.inertia import Inertia, combined
from freebody.model.model import Model
from freebody.model.placement import Placement
from freebody.model.quantity_reader import VALUES
from freebody.model.shapes import DENSEST, LIGHTEST, Shape
from freebody.spatial import of_dimension

_WIDE, _SMALL, _FAR = 2.0, 0.01, 3.0
"""Of a link's size: radius of gyration at most, at least; centre of mass."""
_FLOOR = 0.1  # of the robot's reach: the least size of a body, whatever the file shows of it
# of the moving mass: below which links that are alike, and a body, are passed over
_COUNTS, _TINY = 0.01, 0.001
_ROW, _LOOKED = 8, 64
"""Links alike in a row that suffice; bodies towards the base that are searched for them."""
_SHOWN = 12  # names in a sentence


@dataclass
class _DoubtsFound:
    """A doubt in the making: its sentence, and what it is about."""

    text: str
    about: list[tuple[str, Inertia | None]]
    kind: str = IMPLAUSIBLE


@dataclass(frozen=True)
class _LinkInertia:
    """The inertia of one link, and the body that it is part of."""

    name: str
    body: int
    mass: float
    tensor: np.ndarray
    inertia: Inertia


def implausible_masses(
    model: Model, shapes: Mapping[str, tuple[Shape, ...]], only_missing: bool = False
) -> list[Doubt]:
    """Doubts on the masses of a model, whose links have `shapes`; model.source is the file."""
    missing = _missing(model, shapes)
    found: list[_DoubtsFound] = []
    if missing:
        several = len(missing) > 1
        text = (
            f"{len(missing)} of {len(model.bodies)} moving bodies {'have' if several else 'has'} "
            f"no mass: {listed(missing, _SHOWN)}"
        )
        found.append(_DoubtsFound(text, [(name, None) for name in missing], NO_MASSES))
    if not only_missing:
        sizes = _sizes(model, shapes)
        found += [*_placeholders(model, sizes), *_implausible(model, shapes, sizes)]
    if found and any(shapes.values()) and not only_missing:
        found[-1].text += (
            " (--estimate-inertia MASS, in Python estimate_inertia=, estimates from the shapes in "
            "the file)"
        )
    file = model.source or None
    return [Doubt(x.kind, f"{x.text}.", file, about=tuple(x.about)) for x in found]


# ------------------------------------------------------------ missing
def _missing(model: Model, shapes: Mapping[str, tuple[Shape, ...]]) -> list[str]:
    """Names of the bodies without mass."""
    bare = list(map(is_bare, model.bodies))
    carries = [False] * len(bare)
    for k, empty in enumerate(bare):
        i = k
        while not empty and i >= 0 and not carries[i]:
            carries[i] = True
            i = model.bodies[i].parent
    shaped = {frame.body for frame in model.frames if shapes.get(frame.name)}
    return [
        body.name
        for i, body in enumerate(model.bodies)
        if bare[i] and (i in shaped or not carries[i])
    ]


# ------------------------------------------------------------ sizes
def _sizes(model: Model, shapes: Mapping[str, tuple[Shape, ...]]) -> list[float]:
    """How far each body reaches from its joint (m): to the joints and frames that it carries,
    around its shapes."""
    space = of_dimension(model.dim)
    reach = [0.0] * len(model.bodies)

    def counted(i: int, placement: Placement, more: float = 0.0) -> None:
        if i >= 0:
            _, p = placement.lower(space, VALUES)
            reach[i] = max(reach[i], math.hypot(*p) + more)

    for body in model.bodies:
        counted(body.parent, body.joint.placement)
    for frame in model.frames:
        counted(frame.body, frame.placement)
        for shape in shapes.get(frame.name, ()):
            counted(frame.body, frame.placement.then(shape.placement), shape.radius)
    return reach


# ------------------------------------------------------------ placeholders
def _links(model: Model) -> Iterator[_LinkInertia]:
    """The links that move and weigh something."""
    for i, body in enumerate(model.bodies):
        for part in body.inertias:
            mass, _, tensor = part.inertia.numbers()
            if mass > 0.0:
                yield _LinkInertia(part.link, i, mass, tensor, part.inertia)


def _placeholders(model: Model, own: Sequence[float]) -> Iterator[_DoubtsFound]:
    links = list(_links(model))
    whole = sum(link.mass for link in links)
    alike: dict[tuple[float, ...], list[_LinkInertia]] = {}
    for link in links:
        alike.setdefault((link.mass, *link.tensor.ravel()), []).append(link)
    for group in alike.values():
        if len(group) < 2 or sum(link.mass for link in group) < _COUNTS * whole:
            continue
        by_body: dict[int, list[_LinkInertia]] = {}
        for link in group:
            by_body.setdefault(link.body, []).append(link)
        row = max((_above(model, link, by_body) for link in group), key=len)
        sizes = [own[link.body] for link in row]
        differ = len(row) > 2 and max(sizes) > 1.1 * min(sizes)
        if (len(row) > 1 and _is_plain(row[0])) or differ:
            mass, inertia = row[0].mass, float(row[0].tensor[0, 0])
            yield _DoubtsFound(
                f"{len(group)} links have the same placeholder inertia ({mass:g} kg, {inertia:g} "
                f"kg m²): {listed([link.name for link in group], _SHOWN)}",
                [(link.name, link.inertia) for link in group],
            )


def _above(
    model: Model, link: _LinkInertia, by_body: Mapping[int, Sequence[_LinkInertia]]
) -> list[_LinkInertia]:
    """Of the group what the link is, or hangs on, from it towards the base; a few suffice."""
    found: list[_LinkInertia] = []
    i = link.body
    for _ in range(_LOOKED):
        if i < 0 or len(found) == _ROW:
            break
        found += by_body.get(i, [])[:1]
        i = model.bodies[i].parent
    return found


def _is_plain(link: _LinkInertia) -> bool:
    """Whether the numbers are round, and the inertia the same about all axes."""
    diagonal = np.diag(link.tensor)
    alike = bool((link.tensor == np.diag(diagonal)).all() and (diagonal == diagonal[0]).all())
    return alike and all(float(f"{x:.2g}") == x for x in (link.mass, float(diagonal[0])))


# ------------------------------------------------------------ implausible
def _implausible(
    model: Model, shapes: Mapping[str, tuple[Shape, ...]], own: Sequence[float]
) -> Iterator[_DoubtsFound]:
    reach = sum(sorted(own)[-4:])  # the longest bodies make it
    volumes = _volumes(model, shapes)
    bodies = [_whole(body) for body in model.bodies]
    tiny = _TINY * sum(mass for mass, _, _ in bodies)
    ends = set(range(len(bodies))) - {body.parent for body in model.bodies}
    reasons: dict[str, list[tuple[Body, str]]] = {}
    for i, (mass, away, gyration) in enumerate(bodies):
        if mass <= tiny or reach == 0.0:
            continue
        least = (
            reach if i in ends else _FLOOR * reach
        )  # an end may be a long tool that only a mesh shows
        for reason, value in _faults(
            mass, away, gyration, own[i], least, _FLOOR * reach, volumes[i]
        ):
            reasons.setdefault(reason, []).append((model.bodies[i], value))
    for reason, bodies_found in reasons.items():
        names = [f"{body.name} ({value})" for body, value in bodies_found]
        yield _DoubtsFound(
            f"{reason}: {listed(names, _SHOWN)}",
            [(part.link, part.inertia) for body, _ in bodies_found for part in body.inertias],
        )


def _whole(body: Body) -> tuple[float, float, float]:
    """Of all that is fixed together: mass, distance of its centre from the joint, largest radius of
    gyration; 0 where masses are not positive."""
    parts = [part for part in body.inertias if weighs(part)]
    if not parts or any(VALUES.quantity(part.inertia.mass) <= 0.0 for part in parts):
        return 0.0, 0.0, 0.0
    placed = (part.inertia.placed(*part.placement.lower(of_dimension(3), VALUES)) for part in parts)
    mass, com, tensor = combined(list(placed)).numbers()
    if body.parent < 0 and body.kind.turns:  # nothing else of it is ever felt
        largest = max(float(np.array(body.joint.axis) @ tensor @ np.array(body.joint.axis)), 0.0)
    else:
        largest = max(float(np.linalg.eigvalsh(tensor).max()), 0.0)
    return mass, math.hypot(*com), math.sqrt(largest / mass)


def _faults(
    mass: float, away: float, gyration: float, own: float, least: float, floor: float, volume: float
) -> Iterator[tuple[str, str]]:
    size = max(own, away, floor)
    if gyration > _WIDE * size:
        yield (
            "inertia far too large for the body",
            f"radius of gyration {gyration:.2g} m, its size {size:.2g} m",
        )
    elif gyration < _SMALL * own:
        yield (
            "inertia far too small for the body",
            f"radius of gyration {gyration:.2g} m, its size {own:.2g} m",
        )
    if away > _FAR * max(own, least):
        yield (
            "centre of mass far outside the body",
            f"{away:.2g} m from its joint, its size {max(own, floor):.2g} m",
        )
    if volume > 0.0 and not LIGHTEST <= mass / volume <= DENSEST:
        yield "mass that does not fit the shape", f"{mass:.3g} kg in {1e3 * volume:.3g} litres"


def _volumes(model: Model, shapes: Mapping[str, tuple[Shape, ...]]) -> list[float]:
    """m³ of each body's shapes, of the role that fills more; 0 where there are none, or meshes:
    they stay closed."""
    filled = {role: [0.0] * len(model.bodies) for role in ("collision", "visual")}
    for frame in model.frames:
        for shape in shapes.get(frame.name, ()):
            if frame.body >= 0:
                filled[shape.role][frame.body] += shape.volume  # NaN stays
    pairs = zip(*filled.values(), strict=True)
    return [0.0 if math.isnan(a + b) else max(a, b) for a, b in pairs]
