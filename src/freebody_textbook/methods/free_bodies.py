"""Newton's and Euler's equations of free bodies, in body axes (6.1, 6.2): a quadrotor, a satellite,
a thrown stone.

v is the velocity of the body's origin and ω its angular velocity, both by components in the body's
own axes, where the inertia is constant. The derivative of a vector has the components ȧ + ω × a
there. The orientation is told by three angles, or by a quaternion.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from freebody.errors import FreebodyError
from freebody.expressions.polynomials.symbols import RATE, SECOND
from freebody.expressions.printed_names import sym, vec
from freebody.expressions.typesetting.literal import literal
from freebody.model.model import Model
from freebody.model.parameters import Parameter, each_parameter
from freebody_textbook.derivation import Meaning, Worked
from freebody_textbook.methods import glossary
from freebody_textbook.methods.free_body_steps import (
    PLACES,
    UNITS,
    FreeBody,
    part_with_mass,
    thrusts_of,
)
from freebody_textbook.methods.setting import Setting


def work_out(s: Setting, route: str) -> Worked:
    """Derive the equations of motion of free bodies, body by body."""
    if route != "centre" or s.load:
        raise FreebodyError(
            "derive: f is the sum of all forces on a free body besides its weight, "
            "to which a load on the tip belongs; leave load out."
            if s.load
            else "derive: a free body has no pivot; leave route out."
        )
    given = s.symbols.given or s.symbols.model
    bodies = [FreeBody(s, given, k) for k in range(len(given.bodies))]
    return Worked(
        tuple(step for body in bodies for step in body.steps()),
        tuple(x for body in bodies for x in body.generalized),
        (),
        "Newton and Euler in the axes of the body",
        "Sought: the force f of all that acts on the body besides its weight, and its moment n "
        "about the centre of mass, for a given motion.",
        robot=_robot(len(bodies)),
        table=tuple(_table(s, given, bodies)),
    )


def _robot(count: int) -> tuple[str, ...]:
    """Sentences that describe the free bodies and the axes of their vectors."""
    many = "A rigid body moves" if count == 1 else f"{count} rigid bodies move"
    return (
        f"{many} freely in space, held by no joint: {PLACES * count} degrees of freedom.",
        "Vectors are given by their components in the body's own axes (the notes mark them with a "
        "prime), p and g by those in the world's.",
    )


# ---------------------------------------------------------------- table of symbols
def _table(s: Setting, given: Model, bodies: list[FreeBody]) -> Iterator[Meaning]:
    yield from _coordinates([x for b in bodies for x in b.coordinates[:3]], "position", "m")
    yield from _coordinates(
        [x for b in bodies for x in b.coordinates[3:]], "yaw, pitch and roll", "rad"
    )
    forces = [PLACES * b.k + j for b in bodies for j in range(1, 7)]
    for words, unit, chosen in (
        ("forces along the position", "N", [j for j in forces if (j - 1) % PLACES < 3]),
        ("moments along the angles", "N m", [j for j in forces if (j - 1) % PLACES >= 3]),
    ):
        yield Meaning(tuple(sym(f"tau{j}") for j in chosen), words, unit)
    yield from _parameters(s, given)
    yield from _vectors(bodies)
    yield from _constants(given, bodies)


def _vectors(bodies: list[FreeBody]) -> Iterator[Meaning]:
    """Glossary entries of the bodies' vectors; for velocities also of components and
    derivatives."""
    for letter, words, unit in (
        ("p", "position of the body's origin, world axes", "m"),
        ("v", "velocity of the body's origin", "m/s"),
        ("omega", "angular velocity of the body", "rad/s"),
        ("f", "force on the body besides its weight", "N"),
        ("n", "moment of these forces about the centre of mass", "N m"),
    ):
        yield Meaning(tuple(body.vector(letter) for body in bodies), words, unit)
        if letter in UNITS:
            names = [name for body in bodies for name in body.components(letter)]
            yield Meaning(tuple(map(sym, names)), "its components", unit)
            rates = tuple(sym(name + RATE) for name in names)
            yield Meaning(rates, "their derivatives with respect to time", f"{unit}²")


def _constants(given: Model, bodies: list[FreeBody]) -> Iterator[Meaning]:
    """Glossary entries of inertias, rotations, centres of mass and thrusts."""
    yield Meaning(tuple(b.inertia for b in bodies), "inertia about the centre of mass", "kg m²")
    yield Meaning(tuple(b.R for b in bodies), "rotation from the body's axes to the world's", "")
    yield Meaning(tuple(x for b in bodies for x in b.q), "the same as a quaternion", "")
    places = tuple(b.arm for b in bodies if b.is_off_centre)
    if places:
        yield Meaning(places, "centre of mass, from the body's origin", "m")
    names = tuple(thrusts_of(given))
    if names:
        words = "thrusts along the z axes of the frames on the body"
        yield Meaning(tuple(map(sym, names)), words, "N")
        where = tuple(vec(f"s{name.removeprefix('T')}") for name in names)
        yield Meaning(where, "places of the thrusts, from the centre of mass", "m")


def _coordinates(names: Iterable[str], words: str, unit: str) -> Iterator[Meaning]:
    names = list(names)
    yield Meaning(tuple(map(sym, names)), words, unit)
    rates = tuple(sym(x + dots) for dots in (RATE, SECOND) for x in names)
    yield Meaning(rates, "their velocities and accelerations", f"{unit}/s, {unit}/s²")


def _parameters(s: Setting, given: Model) -> Iterator[Meaning]:
    """Glossary entries of the parameters that occur, by their meaning."""
    used = set(s.symbols.ring.names)
    for parameter, words, unit in _in_model(given):
        if parameter.name in used:
            used.remove(parameter.name)
            yield Meaning((sym(parameter.name),), words, unit)
    gravity = s.layout.order.gravity
    if gravity and s.weighs:
        yield Meaning((sym(gravity),), "acceleration of gravity", glossary.ACCELERATION)


def _in_model(given: Model) -> Iterator[tuple[Parameter, str, str]]:
    for k, body in enumerate(given.bodies):
        own = f"body {k + 1}" if len(given.bodies) > 1 else "the body"
        part = part_with_mass(body)
        for quantities, words, unit in (
            (part.inertia.mass, f"mass of {own}", glossary.KILOGRAM),
            (part.inertia.com, f"distance from its origin to the centre of mass of {own}", "m"),
            (part.inertia.tensor, f"entry of the inertia of {own}", glossary.INERTIA),
            (part.placement, f"distance or angle of the mass on {own}", "m, rad"),
        ):
            for parameter in each_parameter(quantities):
                yield parameter, words, unit
    for frame in given.frames:
        for parameter in each_parameter(frame.placement):
            yield parameter, f"distance or angle of {literal(frame.name)}", "m, rad"
