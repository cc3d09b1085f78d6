"""Lagrange's equations of the second kind: energies, the Lagrangian, one equation per coordinate
(5.6-5.20, 6.15)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

from freebody.algorithms.kinematics import BodyMotions, outward
from freebody.expressions import expression as ex
from freebody.expressions.expression import Equation, Expression, eq
from freebody.expressions.nodes import Symbol, Words
from freebody.expressions.polynomials.symbols import RATE
from freebody.expressions.printed_names import component, sym, vec
from freebody.scalars.trig import Trig
from freebody.spatial import dot
from freebody_textbook.derivation import Meaning, Method, Step, Worked
from freebody_textbook.methods import glossary, step_reasons
from freebody_textbook.methods.body_quantities import meanings
from freebody_textbook.methods.ending import ending
from freebody_textbook.methods.energies import HALF, Energies, virtual_work
from freebody_textbook.methods.lengths_and_directions import cosine, directed, sine
from freebody_textbook.methods.setting import Setting
from freebody_textbook.methods.shared_steps import measured
from freebody_textbook.methods.terms import KINETIC, POTENTIAL, TIME, TermSources

_FEW = 6
"""Terms of a v² up to which it is put in."""
_PAIRS = 3
"""Pairs of parts of a velocity up to which their products are written down."""


def work_out(setting: Setting) -> Worked:
    """Derive the equations of motion from the energies."""
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
    """Meanings of the symbols that the energies introduce."""
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
        yield Meaning((sym("V_s"),), f"potential energy of the {energies.storing}", glossary.JOULE)
    yield Meaning((sym("L"),), "Lagrangian", glossary.JOULE)


def lagrangian(s: Setting) -> tuple[Energies, list[Step]]:
    """The energies, and the steps from positions to L = T - V."""
    still = tuple(0.0 for _ in s.symbols.qd)
    moving = outward(s.tree, s.symbols.q, s.symbols.qd, still)
    energies = Energies(s, moving)
    steps = [_positions(s), _angular_velocities(s, moving), _velocities(s)]
    return energies, [
        *steps,
        *_squared_speeds(s),
        _kinetic(s, energies),
        _potential(s, energies),
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


def _squared_speeds(s: Setting) -> list[Step]:
    """Step: v_ci² of each body, squared and simplified; none if they are too long to read, or
    nothing moves."""
    lines, mixed = [], False
    for i in s.weighted if s.planar or not s.tree.loops else ():
        value = _speed_squared(s, i)
        if value is None:
            continue
        spelt = _spelt(s, i) if s.planar else None
        mixed |= spelt is not None
        lines.append(ex.eq(_square(s, i), *([] if spelt is None else [spelt]), value))
    if not lines:
        return []
    reason = "The squares of the components added up"
    if s.planar and any(map(s.turns, s.order)):
        reason += "; by sin² + cos² = 1 a part's own angle drops out of its square"
    reason += "."
    if mixed:
        reason += (
            " Of two parts that turn by different angles two products of sines and cosines are "
            "left, which add up to the cosine or the sine of the difference of the angles. Such a "
            "line has first these products, then their sum."
        )
    return [Step("Squares of the velocities", reason, tuple(lines))]


def _speed_squared(s: Setting, i: int) -> Expression | None:
    """The squared speed v_c² of body i; None if it is too long to read, or 0."""
    v = s.centre_velocity(i)
    value = s.show_moved(dot(v, v))
    return None if value == ex.ZERO or isinstance(value, Words) else value


def _square(s: Setting, i: int) -> Expression:
    """The square of the velocity of body i's centre of mass, in the plane by its components."""
    name = s.name("vc", i)
    if not s.planar or not isinstance(name, Symbol):
        return ex.power(name, 2)
    return ex.add(*(ex.power(component(name, axis), 2) for axis in "xy"))


def _spelt(s: Setting, i: int) -> Expression | None:
    """The squared speed as a squared sum before simplification; None if it contains no products of
    sines and cosines, or too many terms to read."""
    parts = directed(s.layout, [s.symbols.element(x) for x in s.centre_velocity(i)])
    pairs = list(combinations(parts, 2))
    if len(pairs) > _PAIRS or not any(one.angle and other.angle for one, other in pairs):
        return None
    terms = [s.show_moved(part.square) for part in parts]
    for one, other in pairs:
        for own, theirs, sign, function in (
            (one.along, other.along, 1, cosine),
            (one.across, other.across, 1, cosine),
            (one.across, other.along, 1, sine),
            (one.along, other.across, -1, sine),
        ):
            if not (own.is_zero or theirs.is_zero):
                speeds = s.show_moved(own), s.show_moved(theirs)
                terms.append(ex.mul(2 * sign, *speeds, function(one, other)))
    return ex.add(*terms)


def _kinetic(s: Setting, energies: Energies) -> Step:
    """Step: the kinetic energy of each body, ½ m v² + ½ I ω²."""
    lines: list[Equation] = []
    for i in s.weighted:
        v, w = s.name("vc", i), s.angular_name("omega", i)
        inertia = s.inertia_name(i)
        spin = ex.mul(inertia, ex.power(w, 2)) if s.planar else ex.dot(w, ex.mul(inertia, w))
        turning = ex.ZERO if s.is_point(i) else ex.mul(HALF, spin)
        lines += measured(s, i, True)
        rule = ex.add(ex.mul(HALF, s.mass_name(i), ex.power(v, 2)), turning)
        line = s.with_value(f"T{s.numbers[i]}", rule, energies.kinetic(i))
        lines.append(_with_squares(s, i, energies, line))
    if energies.has_rotors:
        lines.append(eq("T_r", s.show(energies.rotors)))
    reason = (
        "The kinetic energy of a body is that of its mass moving with the centre of mass, plus "
        "that of its rotation about the centre of mass"
    )
    rotors = "; the motors' rotors add T_r" if energies.has_rotors else ""
    numbers = {"RR": ("5.3", "5.11", "5.13", "5.17", "5.19")}.get(s.cited, ("5.3",))
    return Step("Kinetic energies", f"{reason}{rotors}.", tuple(lines), numbers)


def _with_squares(s: Setting, i: int, energies: Energies, line: Equation) -> Equation:
    """The equation of a planar body's T, with v² and ω² inserted as a middle side if they are
    sums."""
    v, w = _speed_squared(s, i), s.angular(energies.moving.w[i])
    many = isinstance(v, ex.Sum) and len(v.terms) > _FEW
    if not s.planar or v is None or many or not any(isinstance(x, ex.Sum) for x in (v, w)):
        return line
    turning = ex.ZERO if s.is_point(i) else ex.mul(HALF, s.inertia_name(i), ex.power(w, 2))
    put_in = ex.add(ex.mul(HALF, s.mass_name(i), v), turning)
    return eq(*line.sides[:2], put_in, *line.sides[2:])


def _potential(s: Setting, energies: Energies) -> Step:
    """Step: the potential energy of weights, and of springs if there are any."""
    lines = [eq("V0", s.show(energies.resting))] if energies.has_resting else []
    for i in s.weighted if s.weighs else ():
        n = s.numbers[i]
        rule = ex.neg(s.mass_times(i, ex.dot(vec("g"), s.name("rc", i))))
        lines.append(s.with_value(f"V{n}", rule, energies.potential(i)))
    if energies.has_springs:
        lines.append(eq("V_s", s.show(energies.springs)))
    parts = (
        ["that of a weight is mass times gravity times height above the base's origin"]
        if s.weighs
        else []
    )
    parts += (
        ["that of what is fixed to the base, V_0, is the same at all times"]
        if energies.has_resting
        else []
    )
    parts += energies.stored
    words = (
        "Potential energy: " + "; ".join(parts)
        if parts
        else "Without gravity and springs there is no potential energy"
    )
    numbers = (
        ("5.4", *({"RR": ("5.12", "5.14", "5.18", "5.20")}.get(s.cited, ()))) if s.weighs else ()
    )
    words += ". (The notes' (5.14) is misprinted; (5.20) is right.)" if "5.14" in numbers else "."
    return Step(
        "Potential energies",
        words,
        tuple(lines),
        (*numbers, *(["5.5"] if energies.has_springs else [])),
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
    """The derivatives of the Lagrangian by one coordinate and its rate."""

    step: Step
    needed: Trig
    """The sum of the derivatives and friction: the force along the coordinate."""
    friction: Trig
    sources: TermSources
    """The derivative that each term of the needed force is from."""


def derivatives(s: Setting, energies: Energies, i: int) -> LagrangianDerivatives:
    """The three derivatives of the Lagrangian in one coordinate's equation, and their sum."""
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
    """The equation of one coordinate; work: the load's generalized force."""
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
    """The closed form's step with the terms of its torque equations marked by their origin."""
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
