"""Lagrange's equations of the second kind: energies, the Lagrangian, one equation per
coordinate (5.6-5.20, 6.15)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

from freebody.algorithms.kinematics import BodyMotions, outward
from freebody.expressions import expression as ex
from freebody.expressions.expression import Equation, Expression, eq
from freebody.expressions.polynomials.symbols import RATE
from freebody.expressions.printed_names import sym
from freebody.scalars.trig import Trig
from freebody_textbook.derivation import Meaning, Step
from freebody_textbook.methods import glossary, step_reasons
from freebody_textbook.methods.body_quantities import meanings
from freebody_textbook.methods.ending import ending
from freebody_textbook.methods.energies import (
    Energies,
    kinetic_step,
    potential_step,
    squared_speeds,
    virtual_work,
)
from freebody_textbook.methods.method import Method, Worked
from freebody_textbook.methods.setting import Setting
from freebody_textbook.methods.terms import KINETIC, POTENTIAL, TIME, TermSources


def work_out(setting: Setting) -> Worked:
    """Derive the equations of motion by energies."""
    s = setting
    energies, found = lagrangian(s)
    steps = [_coordinates(s), *found]
    load = s.symbols.zero()
    works: dict[int, Trig] = {}
    if s.load:
        step, works = virtual_work(s)
        steps.append(step)
    by_coordinate = [derivatives(s, energies, i) for i in s.leaders]
    tau = []
    for i, one in zip(s.leaders, by_coordinate, strict=True):
        equation, torque = _equation(s, i, one, works.get(i, load))
        steps += [one.step, equation]
        tau.append(torque)
    closed, *told = ending(s)
    steps += [_marked(closed, [one.sources for one in by_coordinate]), *told]
    return Worked(tuple(steps), tuple(tau), symbols(s, energies))


def symbols(s: Setting, energies: Energies) -> Iterator[Meaning]:
    """Meanings of the symbols that the energies bring in."""
    yield from meanings(s, "rc{n}")
    yield from meanings(s, "omega{n}", "vc{n}")
    yield Meaning(
        (sym("T_i"), sym("V_i")), "kinetic and potential energy of body i", glossary.JOULE
    )
    if energies.has_rotors:
        yield Meaning((sym("T_r"),), "kinetic energy of the motors' rotors", glossary.JOULE)
    if energies.has_resting:
        yield Meaning((sym("V0"),), "potential energy of what is fixed to the base", glossary.JOULE)
    if energies.has_springs:
        yield Meaning((sym("V_s"),), "potential energy of the springs", glossary.JOULE)
    yield Meaning((sym("L"),), "Lagrangian", glossary.JOULE)


def lagrangian(s: Setting) -> tuple[Energies, list[Step]]:
    """The energies, and the steps from the positions to L = T - V."""
    still = tuple(0.0 for _ in s.symbols.qd)
    moving = outward(s.tree, s.symbols.q, s.symbols.qd, still)
    energies = Energies(s, moving)
    steps = [_positions(s), _angular_velocities(s, moving), _velocities(s)]
    return energies, [
        *steps,
        *squared_speeds(s),
        kinetic_step(s, energies),
        potential_step(s, energies),
        _lagrangian(s, energies),
    ]


def _coordinates(s: Setting) -> Step:
    names = ex.Vector(tuple(sym(s.coordinate(i)) for i in s.leaders))
    forces = ex.Vector(tuple(s.motor(i) for i in s.leaders))
    one = len(s.leaders) == 1
    motor = " or ".join(sorted({s.words(i).effort for i in s.leaders}, reverse=True))
    reason = (
        f"The joint's variable fixes the pose of {'every' if s.order[1:] else 'the'} body; its "
        f"motor's {motor} does work along it."
        if one
        else "The joint variables fix the pose of every body and can be varied one by one; "
        f"along each only its own motor's {motor} does work."
    )
    if s.symbols.turned:
        reason = f"The angles of the links fix the pose of every body. {step_reasons.ABSOLUTE}"
    reason += step_reasons.motorless(s)
    lines = (eq(sym("q"), names), eq(sym("Q"), forces)) if not s.load else (eq(sym("q"), names),)
    return Step("Choose independent coordinates", reason, lines)


def _positions(s: Setting) -> Step:
    lines = [eq(s.name("rc", i), s.column(s.centre_position(i))) for i in s.weighted]
    if s.planar:
        reason = (
            "The energies depend on the position and the velocity of each centre of mass; the "
            "velocities follow from these positions."
        )
    else:
        reason = (
            "The energies depend on the position and the velocity of each centre of mass; "
            "following the frames from the base gives the positions, in world axes."
        )
    return Step("Positions of the centres of mass", reason, tuple(lines), figure="centres")


def _angular_velocities(s: Setting, moving: BodyMotions) -> Step:
    lines = []
    for i in s.order:
        parent = s.tree.bodies[i].parent
        rate = s.show(s.rate(i, s.symbols.qd))
        chain: list[Expression] = [s.angular_name("omega", parent)] if parent >= 0 else []
        if s.turns(i):
            chain.append(rate if s.planar else ex.mul(rate, s.name("z", i)))
        rule, value = ex.add(*chain), s.angular(moving.w[i])
        lines.append(ex.chain(s.angular_name("omega", i), rule, value))
    axes = (
        "" if s.planar else ". Each is given in its body's own axes, where the inertia is constant"
    )
    numbers = {"RR": ("5.8", "5.9"), "R": ("4.1",)}.get(
        s.cited, ("4.1",) if s.planar else ("6.16", "6.24")
    )
    return Step(
        "Angular velocities", f"{step_reasons.added_rates(s)}{axes}.", tuple(lines), numbers
    )


def _velocities(s: Setting) -> Step:
    lines = []
    for i in s.weighted:
        rate: Expression = ex.d_dt(s.name("rc", i))
        if not s.planar:
            rate = ex.mul(s.rotation_name(-1, i), rate)
        lines.append(eq(s.name("vc", i), rate, s.column(s.centre_velocity(i))))
    reason = "Differentiating the positions with respect to time gives the velocities"
    axes = (
        ""
        if s.planar
        else "; turned into the body's own axes they are shorter, and their squares are the same"
    )
    numbers = ("5.10",) if s.cited == "RR" else ()
    middle = (
        " (Here the notes place the centre of mass of link 2 at its midpoint.)" if numbers else ""
    )
    return Step(
        "Velocities of the centres of mass",
        f"{reason}{axes}.{middle}",
        tuple(lines),
        numbers,
        figure="velocities",
    )


def _lagrangian(s: Setting, energies: Energies) -> Step:
    numbers = [s.numbers[i] for i in s.weighted]
    potential = ex.add(
        *(["V0"] if energies.has_resting else []),
        *(f"V{n}" for n in numbers),
        *(["V_s"] if energies.has_springs else []),
    )
    kinetic = ex.add(*(f"T{n}" for n in numbers), *(["T_r"] if energies.has_rotors else []))
    rule = ex.sub(kinetic, potential) if energies.has_potential else kinetic
    return Step(
        "The Lagrangian",
        f"Kinetic minus potential energy: all that the equations need from the "
        f"{'bodies' if s.tree.loops else 'arm'}.",
        (s.with_value("L", rule, energies.lagrangian),),
        ("5.6",),
    )


@dataclass(frozen=True)
class LagrangianDerivatives:
    """The derivatives of L by one coordinate."""

    step: Step
    needed: Trig
    """The sum of the derivatives and friction: the force along the coordinate."""
    friction: Trig
    sources: TermSources
    """The derivative that each term of the needed force is from."""


def derivatives(s: Setting, energies: Energies, i: int) -> LagrangianDerivatives:
    """The three derivatives of L by one coordinate, and what they add up to."""
    x, L = s.coordinate(i), energies.lagrangian
    by_rate, by_position = L.derivative(x + RATE), L.derivative(x)
    moved = by_rate.along(s.symbols.rates)
    friction = s.equations.drives[s.index(i)] - energies.springs.derivative(x)
    potential = energies.total_potential.derivative(x)
    parts = {TIME: moved}, {KINETIC: by_position + potential, POTENTIAL: potential}
    in_time, in_space = (TermSources(s.symbols, part) for part in parts)
    slope, d_position = ex.partial("L", x + RATE), ex.partial("L", x)
    lines = (
        eq(slope, s.show(by_rate)),
        eq(ex.d_dt(slope), in_time.marked(s.show(moved))),
        eq(d_position, in_space.marked(s.show(by_position))),
    )
    step = Step(
        f"Derivatives for {sym(x)}",
        "In the partial derivatives coordinates and rates count as independent; the derivative "
        "with respect to time brings in the accelerations.",
        lines,
    )
    others = {} if friction.is_zero else {"friction": friction}
    sources = TermSources(s.symbols, parts[0] | parts[1] | others)
    return LagrangianDerivatives(step, moved - by_position + friction, friction, sources)


def _equation(s: Setting, i: int, found: LagrangianDerivatives, work: Trig) -> tuple[Step, Trig]:
    """The equation of one coordinate; work: what the load adds to its force."""
    torque, x, friction = found.needed - work, s.coordinate(i), found.friction
    slope, d_position = ex.partial("L", x + RATE), ex.partial("L", x)
    force = s.motor(i) if not s.load else sym(f"Q{s.index(i) + 1}")
    right = ex.add(force, ex.neg_each(s.show(friction)))
    number = {("RR", 1): "5.15", ("RR", 2): "5.16"}.get(
        (s.cited, s.numbers[i]), "" if s.planar else "6.15"
    )
    motor = s.words(i).effort
    reason = f"Lagrange's equation; the generalized force is the {motor} of the joint's motor"
    if s.symbols.turned:
        reason = "Lagrange's equation; the generalized force is the torque on the body"
    elif not s.driven(i):
        reason = "Lagrange's equation; the joint has no motor and no generalized force"
    if s.load:
        reason = "Lagrange's equation; the generalized force is that of motor and load, found above"
    reason += "." if friction.is_zero else ", less friction."
    equation = Step(
        f"The equation of {sym(x)}",
        reason,
        (
            eq(ex.sub(ex.d_dt(slope), d_position), right),
            eq(s.motor(i), found.sources.marked(s.show(torque))),
        ),
        ("5.7", number) if number else ("5.7",),
    )
    return equation, torque


def _marked(closed: Step, sources: Sequence[TermSources]) -> Step:
    """The closed form, whose first lines are the torques, with their terms marked."""
    lines = [
        Equation((*line.sides[:-1], one.marked(line.rhs)))
        for line, one in zip(closed.equations, sources, strict=False)
    ]
    return replace(closed, equations=(*lines, *closed.equations[len(lines) :]))


METHOD = Method(
    "lagrange",
    "Lagrange's equations of the second kind",
    "kinetic and potential energies, one equation per coordinate",
    "lecture notes, chapter 5 and section 6.2",
    work_out,
    aliases=("lagrange-second-kind",),
    absolute=True,
)
