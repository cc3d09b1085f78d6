"""What becomes of the right answer: other factors of its terms, other values and angles in it, or
other equations of the bodies."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from fractions import Fraction
from functools import partial
from itertools import pairwise
from typing import Any

from freebody.derivations.check.algebra.finite_field import Turn
from freebody.derivations.check.algebra.quotients import generator
from freebody.derivations.check.reasons.bodies_at_point import Belief
from freebody.derivations.check.reasons.thoughts import Changed, Subject
from freebody.derivations.expressions.printed_names import sym
from freebody.errors import listed
from freebody.model.gravity import axis_of

Change = Callable[[Subject], Iterator[Changed]]
_ZEROS = {1: "the vertical (upwards)", 3: "the vertical (downwards)", 0: "the x axis"}
"""Where angles are 0, by the right angles from the x axis."""
_QUARTERS: Mapping[int, Turn] = {1: (1, 0), 2: (0, -1), 3: (-1, 0)}
"""Sines and cosines of right angles."""


# ---------------------------------------------------------------- factors
def part_of(powers: Mapping[str, int]) -> str:
    """What a term of a torque is by its first rates: of second degree "coriolis" or "centrifugal",
    of first degree, or with a rate's sign, "friction", else ""."""
    if any(x.startswith("sgn_") for x in powers):
        return "friction"
    rates = {x: k for x, k in powers.items() if x.endswith("_d")}
    if sum(rates.values()) == 1:
        return "friction"
    return "coriolis" if len(rates) > 1 else "centrifugal" if rates else ""


def parts(factor: int | Fraction, *kinds: str) -> Change:
    """A factor of some kinds of terms of a torque, a force or an acceleration."""

    def change(x: Subject) -> Iterator[Changed]:
        if x.accelerates and any(part_of(powers) in kinds for powers, _ in x.right.terms()):
            yield {}, x.scaled(factor, lambda powers: part_of(powers) in kinds)

    return change


def without_acceleration(x: Subject) -> Iterator[Changed]:
    """Without the terms of one coordinate's acceleration."""
    for name in (c + "_dd" for c in x.setting.symbols.coordinates if x.accelerates):
        yield {"name": sym(name)}, x.scaled(0, lambda p, name=name: name in p)


def twice_the_energy(x: Subject) -> Iterator[Changed]:
    """Twice the kinetic energy: of all, of what turns or does not, of one body."""
    if not x.is_energy:
        return
    inertial = x.setting.order.inertial
    turning = {name for name, (_, kind) in inertial.items() if kind == 1}
    own = [{name for name, (k, _) in inertial.items() if k == i} for i in _bodies(x)]
    for names in (set(inertial), turning, set(inertial) - turning, *own):

        def meant(powers: Mapping[str, int], names: set[str] = names) -> bool:
            return bool(names & powers.keys()) and any(p.endswith("_d") for p in powers)

        yield {}, x.scaled(2, meant)


def degrees(factor: Any) -> Change:
    """A factor."""
    return lambda x: iter([({}, x.value * x.point.number(factor))])


# ---------------------------------------------------------------- values
def gravity(factor: int) -> Change:
    """Another gravity."""

    def change(x: Subject) -> Iterator[Changed]:
        g = x.setting.order.gravity
        if g in x.names:
            yield {"energy": _weights(x)}, x.scaled(factor, lambda p: g in p)

    return change


def _weights(x: Subject) -> str:
    """The weights' energy, in words."""
    axis = axis_of(x.setting.symbols.model.gravity_direction)
    if not axis:
        return "the weights' potential energy is V = − m g · r, with the vector g"
    pull, rise = ("−", "+") if axis[0] == "-" else ("+", "−")
    return f"weights act along {pull}{axis[1]}, so V = {rise} m g {axis[1]}"


def _bodies(x: Subject) -> range:
    return range(len(x.setting.symbols.model.bodies))


def massless(x: Subject) -> Iterator[Changed]:
    """Without the mass and inertia of one body, or of it and all that it carries."""
    model, inertial = x.setting.symbols.model, x.setting.order.inertial
    heavy = {body for body, _ in inertial.values()}
    carried = {i: {i} for i in _bodies(x)}
    for i in reversed(_bodies(x)):
        if model.bodies[i].parent in carried:
            carried[model.bodies[i].parent] |= carried[i]
    groups = [{i} for i in sorted(heavy)] + [carried[i] & heavy for i in _bodies(x)]
    for group in groups:
        names = {name for name, (i, _) in inertial.items() if i in group}
        if group != heavy and (names & x.names):
            links = listed(str(model.bodies[i].name) for i in sorted(group))
            yield {"links": links}, x.scaled(0, lambda p, own=names: bool(own & p.keys()))


def pointlike(x: Subject) -> Iterator[Changed]:
    """Without moments of inertia."""
    moments = {name for name, (_, kind) in x.setting.order.inertial.items() if kind == 1}
    yield {}, x.scaled(0, lambda p: bool(moments & p.keys()))


def _groups(rows: Sequence[Any]) -> Iterator[Sequence[Any]]:
    """All together, and each alone."""
    yield from [rows] * bool(rows)
    yield from ([x] for x in rows if len(rows) > 1)


def lengths(reach: str, centre: str) -> Change:
    """What stands for the length of a link and for the distance of its centre: "l", "lc" or
    "half"."""

    def change(x: Subject) -> Iterator[Changed]:
        v, half = x.point.values, x.point.number(Fraction(1, 2))
        rows = [row for row in _lengths(x) if (row["l"] in x.names or reach == "l")]
        rows = [row for row in rows if row["lc"] in x.names or centre == "lc"]
        for group in _groups(rows):
            put = {}
            for row in group:
                named = {"l": v[row["l"]], "lc": v[row["lc"]], "half": v[row["l"]] * half}
                put |= {row["l"]: named[reach], row["lc"]: named[centre]}
            said = {
                "which": " and ".join(row["lc"] for row in group),
                "wrong": ", ".join("{l} for {lc}".format(**row) for row in group),
                "back": ", ".join("{lc} for {l}".format(**row) for row in group),
                "half": ", ".join("{lc} = {l}/2".format(**row) for row in group),
            }
            yield {**said, **group[0]}, x.at(put)

    return change


def _lengths(x: Subject) -> Iterator[dict[str, str]]:
    """The names of lengths to the next joint and to the centre of mass, of links that have both."""
    s, ring = x.bodies.s, x.setting.ring.index
    for i in s.order if x.setting.is_planar and x.bodies.is_told else ():
        ends = [s.tree.bodies[k].p for k in s.tree.children(i)]
        ends += [s.tip_frame[2]] * s.ends_in_tip(i)
        centres = [mass.c for mass in s.tree.bodies[i].masses]
        l, lc = (generator(s.symbols.element(v[0][0])) if v else None for v in (ends, centres))
        n = s.numbers[i]
        l = f"l{n}" if l is None and lc == f"lc{n}" and f"l{n}" in ring else l
        if l is not None and lc is not None and l in ring and lc in ring:
            yield {"l": l, "lc": lc}


def axes(factor: int) -> Change:
    """Moments of inertia with m c² as often more."""

    def change(x: Subject) -> Iterator[Changed]:
        rows = list(_inertias(x)) if x.setting.is_planar and x.bodies.is_told else []
        for group in _groups(rows):
            put = {name: x.point.values[name] + factor * value for name, value, _ in group}
            names, lacking = (" and ".join(row[k] for row in group) for k in (0, 2))
            are = "are" if len(group) > 1 else "is"
            yield {"names": names, "are": are, "lacking": lacking}, x.at(put)

    return change


def _inertias(x: Subject) -> Iterator[tuple[str, Any, str]]:
    """Names of moments of inertia in the right answer, m c², and how it is written."""
    s = x.bodies.s
    for i in s.weighted:
        (mass,) = s.tree.bodies[i].masses
        name, c = generator(s.symbols.element(mass.inertia)), s.symbols.element(mass.c[0])
        if name in x.names and s.symbols.element(mass.c[1]).is_zero and not c.is_zero:
            value = x.bodies.number(mass.m * mass.c[0] * mass.c[0])
            yield name, value, f"{generator(s.symbols.element(mass.m))} {generator(c)}²"


# ---------------------------------------------------------------- angles
def _turning(x: Subject) -> list[str]:
    names = x.setting.symbols.coordinates if x.setting.is_planar else ()
    return [name for name in names if name.startswith("theta")]


def turned(x: Subject) -> Iterator[Changed]:
    """The first angle measured from elsewhere."""
    for first in _turning(x)[:1]:
        coordinates = list(x.setting.symbols.coordinates)
        own = ([*x.setting.quarters, *[0] * len(coordinates)])[coordinates.index(first)] % 4
        for other in (k for k in _ZEROS if k != own):
            put = x.point.plus(x.point.turns[first], _QUARTERS[(other - own) % 4])
            said = {"name": sym(first), "zero": _ZEROS[other]}
            yield {**said, "own": _ZEROS.get(own, "elsewhere")}, x.at(turns={first: put})


def absolute(x: Subject) -> Iterator[Changed]:
    """Angles from the x axis for angles from the link before."""
    turning = _turning(x)
    if len(turning) < 2:
        return
    values, turns = dict(x.point.values), dict(x.point.turns)
    for before, name in pairwise(turning):
        s, c = x.point.turns[before]
        turns[name] = x.point.plus(x.point.turns[name], (-s, c))
        for ending in ("_d", "_dd"):
            values[name + ending] = x.point.values[name + ending] - x.point.values[before + ending]
    said = {"names": ", ".join(str(sym(name)) for name in turning[1:])}
    yield said, x.at(turns=turns)
    yield said, x.at(values, turns)
    if len(turning) == len(x.setting.symbols.coordinates) and x.torque is not None:
        name, index = x.torque
        rows: list[tuple[int, Any]] = [(1, x.setting.all_of(name))]
        for i in index:  # τ_k - τ_(k+1) belong to φ_k = θ_1 + … + θ_k
            near = [(1, i), (-1, i + 1)]
            rows = [(a * b, row[k]) for a, row in rows for b, k in near if k < len(row)]
        moved = x.point.changed(values, turns)
        yield said, sum(sign * moved.of(x.setting.element(row)) for sign, row in rows)


# ---------------------------------------------------------------- equations of the bodies
def believed(*beliefs: Belief, of_next: bool = False) -> Change:
    """Other equations of the body to which the answer belongs, or of all; of_next: only of bodies
    that carry others."""

    def change(x: Subject) -> Iterator[Changed]:
        every = range(len(x.bodies.bodies)) if x.about else ()
        for i in x.about:
            groups = [(i,), *[every] * (len(every) > 1)]
            for of in groups if x.bodies.s.tree.children(i) or not of_next else ():
                for belief in beliefs:
                    yield from ((_names(x, i), value) for value in _under(x, i, of, belief))

    return change


def _under(x: Subject, i: int, of: Collection[int], belief: Belief) -> Iterator[Any]:
    """The right answer, of body i, where a belief about some bodies holds."""
    b, right = x.bodies, x.value
    if x.torque is not None:
        moves = belief.spins_alone or belief.turns_alone
        for way in (b.acting, b.projected)[: 1 + moves]:
            yield right + way(x.state, of, belief)["tau", i][0] - way(x.state)["tau", i][0]
    for own in x.components:
        if own.key[1] in (i, -1):
            told = partial(b.acting, b.moving) if own.key[0] in "fn" else b.moved
            gap = own.of(b, told(of, belief)) - own.of(b, told())
            yield right + gap
            if x.is_equation:
                yield right - gap


def _names(x: Subject, i: int) -> dict[str, object]:
    """What sentences about body i name."""
    s, n = x.bodies.s, x.bodies.s.numbers[i]
    h, behind = s.numbers[s.tree.bodies[i].parent], [s.numbers[k] for k in s.tree.children(i)]
    return {
        "n": n, "k": listed(map(str, behind)), "f": f"f{h}{n}",
        "next": listed(f"f{n}{k}" for k in behind), "opposite": listed(f"−f{n}{k}" for k in behind),
    }  # fmt: skip


def alone(*beliefs: Belief) -> Change:
    """The angular velocity of a body, or of all, without those of the bodies before it."""

    def change(x: Subject) -> Iterator[Changed]:
        sums = _sums(x) if x.about else {}
        for of in _groups(list(sums)):
            said = {
                "wrong": listed(f"{sums[i][0]} = {sums[i][-1]}" for i in of),
                "right": listed(f"{sums[i][0]} = {' + '.join(sums[i][1:])}" for i in of),
            }
            for belief in beliefs:
                for i in x.about:
                    yield from ((said, value) for value in _under(x, i, of, belief))

    return change


def _sums(x: Subject) -> dict[int, list[str]]:
    """ω of each body that turns on others that do, and the rates that make it up."""
    s, found = x.bodies.s, dict[int, list[str]]()
    for i, body in enumerate(s.tree.bodies):
        before = found.get(body.parent, [""])[1:]
        own = [str(sym(s.coordinate(i) + "_d"))] * s.turns(i)
        found[i] = [f"ω{s.numbers[i]}", *before, *own]
    return {i: row for i, row in found.items() if len(row) > 2 and s.turns(i)}


def other_axes(x: Subject) -> Iterator[Changed]:
    """Components along the axes of another body, or the world's."""
    b = x.bodies
    found = {**b.moved(), **b.acting(b.moving)} if x.components and not x.is_equation else {}
    for own in x.components if found else ():
        for k in range(-(x.target.in_world is None), len(b.bodies)):
            if k != own.axes and len(found[own.key]) == b.s.tree.space.dim:
                yield {"axes": _axes(x, k), "here": _axes(x, own.axes)}, own.of(b, found, k)


def _axes(x: Subject, i: int) -> str:
    return f"along those of body {x.bodies.s.numbers[i]}" if i >= 0 else "along the world's axes"
