"""Changes of the correct answer by a misconception: factors of its terms, values and angles in
it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from fractions import Fraction
from typing import Any

from freebody.errors import listed
from freebody.expressions.grammar.atoms import atom
from freebody.expressions.grammar.parser import PI
from freebody.expressions.polynomials.symbols import RATE, SECOND
from freebody.expressions.printed_names import sym
from freebody.model.gravity import axis_of
from freebody.scalars.generators import SIGN, function_of
from freebody_textbook.check.algebra.finite_field import SineAndCosine
from freebody_textbook.check.algebra.quotients import generator
from freebody_textbook.check.reasons.forgotten_parameters import moments_of_inertia
from freebody_textbook.check.reasons.thoughts import Change, Changed, Subject, each_and_all

VELOCITY = ("coriolis", "centrifugal")
_ZEROS = {1: "the vertical (upwards)", 3: "the vertical (downwards)", 0: "the x axis"}
"""Names of the direction where angles are 0, by the right angles from the x axis."""
_QUARTERS: Mapping[int, SineAndCosine] = {1: (1, 0), 2: (0, -1), 3: (-1, 0)}
"""Sines and cosines of right angles."""


# ---------------------------------------------------------------- factors
def part_of(powers: Mapping[str, int]) -> str:
    """The part of a torque that a term with these powers belongs to: "coriolis" or "centrifugal"
    for quadratic rates; "friction" for a single rate or a rate's sign; otherwise ""."""
    if any(function_of(x) == SIGN for x in powers):
        return "friction"
    rates = {x: k for x, k in powers.items() if atom(x).dots == 1}
    if sum(rates.values()) == 1:
        return "friction"
    return "coriolis" if len(rates) > 1 else "centrifugal" if rates else ""


def parts(factor: int | Fraction, *kinds: str) -> Change:
    """Change: terms of some kinds in a torque, force or acceleration are multiplied by a factor."""

    def change(x: Subject) -> Iterator[Changed]:
        if x.accelerates and any(part_of(powers) in kinds for powers, _ in x.rows):
            yield {}, x.scaled(factor, lambda powers: part_of(powers) in kinds)

    return change


def without_acceleration(x: Subject) -> Iterator[Changed]:
    """Change: the terms with one coordinate's acceleration are left out."""
    for name in (c + SECOND for c in x.setting.symbols.coordinates if x.accelerates):
        yield {"name": sym(name)}, x.at({name: 0})


def twice_the_energy(x: Subject) -> Iterator[Changed]:
    """Change: kinetic energy doubled, of everything, of rotation or translation, or of one body."""
    if not x.is_energy:
        return
    inertial = x.setting.order.inertial
    turning = moments_of_inertia(x.setting)
    own = [
        {name for name, (k, _) in inertial.items() if k == i}
        for i in range(len(x.bodies.s.symbols.model.bodies))
    ]
    for names in (set(inertial), turning, set(inertial) - turning, *own):

        def meant(powers: Mapping[str, int], names: set[str] = names) -> bool:
            return bool(names & powers.keys()) and any(atom(p).dots == 1 for p in powers)

        yield {}, x.scaled(2, meant)


def unmixed_rates(x: Subject) -> Iterator[Changed]:
    """Change: kinetic energy without products of two joint rates, in all terms or in those with
    moments of inertia."""
    rates = {name + RATE for name in _turning(x)} if x.is_energy else set()
    for names in (x.names, moments_of_inertia(x.setting)) if rates else ():

        def meant(powers: Mapping[str, int], names: set[str] = names) -> bool:
            return len(rates & powers.keys()) > 1 and not names.isdisjoint(powers)

        yield {}, x.scaled(0, meant)


def unmixed_velocities(x: Subject) -> Iterator[Changed]:
    """Change: kinetic energy without products of two lengths, or of a length and a slide's rate."""
    turning = _turning(x) if x.is_energy else set()
    if turning:
        ways = {name for row in _lengths(x) for name in row}
        ways |= {name + RATE for name in {*x.setting.symbols.coordinates} - turning}
        yield {}, x.scaled(0, lambda powers: len(ways & powers.keys()) > 1)


def _turning(x: Subject) -> set[str]:
    """Names of the coordinates of turning joints."""
    return {name for row in chains(x).values() for name in row}


def degrees(x: Subject) -> Iterator[Changed]:
    """Change: angles or rates in degrees, which gives derivatives a factor π/180."""
    yield {}, x.value * x.point.number(PI / 180)
    yield {}, x.value * x.point.number(180 / PI)


# ---------------------------------------------------------------- values
def other_gravity(x: Subject) -> Iterator[Changed]:
    """Change: gravity reversed in direction."""
    g = x.setting.order.gravity
    if g in x.names:
        yield {"energy": _weights(x)}, x.at({g: -x.point.values[g]})


def _weights(x: Subject) -> str:
    """Phrase for the energy of the weights."""
    axis = axis_of(x.setting.symbols.model.gravity_direction)
    if not axis:
        return "the weights' potential energy is V = − m g · r, with the vector g"
    pull, rise = ("−", "+") if axis[0] == "-" else ("+", "−")
    return f"weights act along {pull}{axis[1]}, so V = {rise} m g {axis[1]}"


def lengths(reach: str = "l", centre: str = "lc") -> Change:
    """Change: other values for a link's length and the distance of its centre of mass: "l", "lc" or
    "half"."""

    def change(x: Subject) -> Iterator[Changed]:
        v, half = x.point.values, x.point.number(Fraction(1, 2))
        changed = [k for k, same in enumerate((reach == "l", centre == "lc")) if not same]
        rows = [row for row in _lengths(x) if x.names.issuperset(row[k] for k in changed)]
        for group in each_and_all(rows):
            put = {}
            for l, lc in group:
                named = {"l": v[l], "lc": v[lc], "half": v[l] * half}
                put |= {l: named[reach], lc: named[centre]}
            shown = [(str(sym(l)), str(sym(lc))) for l, lc in group]
            said = {
                "l": shown[0][0],
                "lc": shown[0][1],
                "centres": " and ".join(lc for _, lc in shown),
                "wrong": ", ".join(f"{l} for {lc}" for l, lc in shown),
                "back": ", ".join(f"{lc} for {l}" for l, lc in shown),
                "half": ", ".join(f"{lc} = {l}/2" for l, lc in shown),
            }
            yield said, x.at(put)

    return change


def _lengths(x: Subject) -> Iterator[tuple[str, str]]:
    """Names of the length to the next joint and of the distance to the centre of mass, for links
    with both."""
    s, ring = x.bodies.s, x.setting.ring.index
    for i in s.order if x.setting.is_planar and x.bodies.is_told else ():
        ends = [s.tree.bodies[k].p for k in s.tree.children(i)]
        ends += [s.tip_frame[2]] * s.ends_in_tip(i)
        centres = [mass.c for mass in s.tree.bodies[i].masses]
        l, lc = (generator(s.symbols.element(v[0][0])) if v else None for v in (ends, centres))
        l = l or f"l{s.numbers[i]}"  # of a last link without a tip
        if lc in ring and l in ring:
            yield l, lc


def slides(x: Subject) -> Iterator[Changed]:
    """Change: a slide's displacement measured from the joint before, to its body's centre of mass,
    or both: the lengths that the model has there are 0."""
    for d, before, behind in _slides(x):
        ways = [(before, "from the joint before"), (behind, "to the centre of mass")]
        ways.append((before + behind, "from the joint before to the centre of mass"))
        for names, how in ways:
            if names and x.names.issuperset(names):
                said = {
                    "zeros": " and ".join(f"{sym(name)} = 0" for name in names),
                    "d": str(sym(d)),
                    "how": how,
                    "options": " ".join(f"--parameter {name}=0" for name in names),
                    "given": ", ".join(f'"{name}": 0' for name in names),
                }
                yield said, x.at(dict.fromkeys(names, 0))


def _slides(x: Subject) -> Iterator[tuple[str, tuple[str, ...], tuple[str, ...]]]:
    """The displacement of each slide in the plane; the length along it from the joint before to
    where it is counted from, and the distance behind it to the centre of mass, none where it is no
    symbol."""
    s = x.bodies.s
    for i in s.order if x.setting.is_planar and x.bodies.is_told else ():
        body = s.tree.bodies[i]
        if s.turns(i) or len(body.masses) != 1:
            continue
        along = max(range(len(body.axis)), key=lambda k, axis=body.axis: abs(float(axis[k])))
        found = (generator(s.symbols.element(v[along])) for v in (body.p, body.masses[0].c))
        before, behind = ((name,) if name else () for name in found)
        yield s.coordinate(i), before, behind


def axes(factor: int) -> Change:
    """Change: moments of inertia about another axis: m c² is added `factor` times to each."""

    def change(x: Subject) -> Iterator[Changed]:
        rows = list(_inertias(x)) if x.setting.is_planar and x.bodies.is_told else []
        for group in each_and_all(rows):
            put = {name: x.point.values[name] + factor * value for name, value, _ in group}
            names = " and ".join(str(sym(name)) for name, _, _ in group)
            lacking = " and ".join(term for _, _, term in group)
            are = "are" if len(group) > 1 else "is"
            yield {"names": names, "are": are, "lacking": lacking}, x.at(put)

    return change


def _inertias(x: Subject) -> Iterator[tuple[str, Any, str]]:
    """Moments of inertia in the correct answer: the name, the value m c², and its text."""
    s = x.bodies.s
    for i in s.weighted:
        (mass,) = s.tree.bodies[i].masses
        name, m, c = (generator(s.symbols.element(v)) for v in (mass.inertia, mass.m, mass.c[0]))
        if name in x.names and m and c and s.symbols.element(mass.c[1]).is_zero:
            yield name, x.bodies.number(mass.m * mass.c[0] * mass.c[0]), f"{sym(m)} {sym(c)}²"


# ---------------------------------------------------------------- angles
def turned(x: Subject) -> Iterator[Changed]:
    """Change: angles of the joints at the ground measured from another direction."""
    coordinates = x.setting.symbols.coordinates
    first = [row[0] for row in chains(x).values() if len(row) == 1]
    quarters = x.setting.quarters or (0,) * len(coordinates)
    zeros = {quarters[coordinates.index(name)] % 4 for name in first}
    for own in zeros if len(zeros) == 1 else ():
        for other in (q for q in _ZEROS if q != own):
            quarter = _QUARTERS[(other - own) % 4]
            put = {name: x.point.plus(x.point.turns[name], quarter) for name in first}
            names, it = listed(str(sym(x)) for x in first), ("it is", "they are")[len(first) > 1]
            said = {"names": names, "it": it, "zero": _ZEROS[other]}
            yield {**said, "own": _ZEROS.get(own, "elsewhere")}, x.at(turns=put)


def absolute(x: Subject) -> Iterator[Changed]:
    """Change: joint angles taken as angles from the x axis, although they are relative to the
    previous link."""
    s = x.bodies.s
    before = {row[-1]: row[-2] for row in chains(x).values() if len(row) > 1}
    if not before:
        return
    values, turns = dict(x.point.values), dict(x.point.turns)
    for name, other in before.items():
        sine, cosine = x.point.turns[other]
        turns[name] = x.point.plus(x.point.turns[name], (-sine, cosine))
        for ending in (RATE, SECOND):
            values[name + ending] = x.point.values[name + ending] - x.point.values[other + ending]
    said = {"names": ", ".join(str(sym(name)) for name in before)}
    yield said, x.at(turns=turns)
    yield said, x.at(values, turns)
    if len(before) == len(s.symbols.coordinates) - 1 and x.torque is not None:
        rows: list[tuple[int, Any]] = [(1, x.setting.all_of(x.torque[0]))]
        for i in (k - 1 for k in x.target.index):  # τ_k - τ_(k+1) belong to φ_k = θ_1 + … + θ_k
            near = [(1, i), (-1, i + 1)]
            rows = [(a * b, row[k]) for a, row in rows for b, k in near if k < len(row)]
        moved = x.point.changed(values, turns)
        yield said, sum(sign * moved.of(x.setting.element(row)) for sign, row in rows)


def chains(x: Subject) -> dict[int, list[str]]:
    """The joint angles that add up to each body's direction, for bodies that turn in the plane."""
    s, found = x.bodies.s, dict[int, list[str]]()
    is_told = s.planar and not s.tree.follows
    for i, body in enumerate(s.tree.bodies if is_told else ()):
        found[i] = [*found.get(body.parent, ()), *[s.coordinate(i)] * s.turns(i)]
    return {i: row for i, row in found.items() if s.turns(i)}
