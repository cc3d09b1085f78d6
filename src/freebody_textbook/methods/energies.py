"""Energies of an arm and the work of a load, of which Lagrange's equations are made, and the
steps that show them (5.1-5.5, 5.11-5.20)."""

from __future__ import annotations

from fractions import Fraction
from itertools import combinations

from freebody.algorithms.energy import resting_energy
from freebody.algorithms.kinematics import BodyMotions
from freebody.expressions import expression as ex
from freebody.expressions.expression import Equation, Expression, eq
from freebody.expressions.nodes import Symbol, Words
from freebody.expressions.polynomials.arithmetic import inner
from freebody.expressions.printed_names import component, sym, vec
from freebody.lazy import cached_property
from freebody.scalars.trig import Trig
from freebody.spatial import add, dot, times
from freebody_textbook.derivation import Step
from freebody_textbook.methods.lengths_and_directions import cosine, directed, sine
from freebody_textbook.methods.setting import Setting
from freebody_textbook.methods.shared_steps import measured

HALF = ex.num(Fraction(1, 2))
_FEW = 6
"""Terms of a v² up to which it is put in."""


_PAIRS = 3
"""Pairs of parts of a velocity up to which their products are written down."""


class Energies:
    """The energies as polynomials; accelerations do not occur in them."""

    def __init__(self, setting: Setting, moving: BodyMotions):
        self.s = setting
        self.moving = moving

    def kinetic(self, i: int) -> Trig:
        """½ m v_c² + ½ ω · I ω of body i, of each of its parts."""
        space, v, w = self.s.tree.space, self.moving.v[i], self.moving.w[i]
        total = self.s.symbols.zero()
        for part in self.s.tree.bodies[i].masses:
            vc = add(v, space.cross(w, part.c))
            total = total + part.m * dot(vc, vc) + dot(w, space.inertia_times(part.inertia, w))
        return total * 0.5

    def potential(self, i: int) -> Trig:
        """-m g · r_c of body i, of each of its parts."""
        R, p = self.s.world[i]
        total = self.s.symbols.zero()
        for part in self.s.tree.bodies[i].masses:
            total = total - part.m * dot(self.s.tree.gravity, add(p, times(R, part.c)))
        return total

    @cached_property
    def springs(self) -> Trig:
        """Energy of the joints' springs."""
        total = self.s.symbols.zero()
        for body in self.s.tree.bodies:
            if body.drive is not None:
                total = total + body.drive.energy(self.s.symbols.q)
        return total

    @cached_property
    def rotors(self) -> Trig:
        """Kinetic energy of the drives' rotors."""
        total = self.s.symbols.zero()
        for body in self.s.tree.bodies:
            if body.drive is not None:
                (rate,) = body.rates(self.s.symbols.qd)
                total = total + 0.5 * body.drive.inertia * (rate * rate)
        return total

    @cached_property
    def resting(self) -> Trig:
        """-m g · r_c of what is fixed to the base: a constant."""
        return self.s.symbols.element(resting_energy(self.s.tree))

    @property
    def has_resting(self) -> bool:
        """Whether what is fixed to the base has a potential energy."""
        return not self.resting.is_zero

    @property
    def has_springs(self) -> bool:
        """Whether springs store energy."""
        return not self.springs.is_zero

    @property
    def has_rotors(self) -> bool:
        """Whether rotors have kinetic energy."""
        return not self.rotors.is_zero

    @property
    def has_potential(self) -> bool:
        """Whether there is any potential energy."""
        return self.s.weighs or self.has_springs

    @cached_property
    def total_potential(self) -> Trig:
        """Potential energy V of weights and springs."""
        own = (self.potential(i) for i in self.s.weighted)
        return sum(own, self.resting + self.springs)

    @cached_property
    def lagrangian(self) -> Trig:
        """Lagrange's function T - V."""
        total = sum((self.kinetic(i) for i in self.s.weighted), self.rotors)
        return total - self.total_potential


def kinetic_step(s: Setting, energies: Energies) -> Step:
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
    """T of a body of the plane with v² and ω² put in between, where these are sums."""
    v, w = _speed_squared(s, i), s.angular(energies.moving.w[i])
    many = isinstance(v, ex.Sum) and len(v.terms) > _FEW
    if not s.planar or v is None or many or not any(isinstance(x, ex.Sum) for x in (v, w)):
        return line
    turning = ex.ZERO if s.is_point(i) else ex.mul(HALF, s.inertia_name(i), ex.power(w, 2))
    put_in = ex.add(ex.mul(HALF, s.mass_name(i), v), turning)
    return eq(*line.sides[:2], put_in, *line.sides[2:])


def potential_step(s: Setting, energies: Energies) -> Step:
    """Step: the potential energy of weights, and of springs where there are any."""
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
    parts += (
        ["that of a spring is half its stiffness times the square of its deflection"]
        if energies.has_springs
        else []
    )
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


def _speed_squared(s: Setting, i: int) -> Expression | None:
    """v_c² of body i; none where it is too long to read, or 0."""
    v = s.centre_velocity(i)
    value = s.show_moved(dot(v, v))
    return None if value == ex.ZERO or isinstance(value, Words) else value


def squared_speeds(s: Setting) -> list[Step]:
    """v_ci² of each body: its components squared and added up, then shortened; none where they are
    too long to read, or nothing moves."""
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


def _square(s: Setting, i: int) -> Expression:
    """v² of body i's centre of mass, in the plane by the components."""
    name = s.name("vc", i)
    if not s.planar or not isinstance(name, Symbol):
        return ex.power(name, 2)
    return ex.add(*(ex.power(component(name, axis), 2) for axis in "xy"))


def _spelt(s: Setting, i: int) -> Expression | None:
    """The square of a sum of parts, products of sines and cosines left as they come; none where
    there are no such products, or too many to read."""
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


def virtual_work(s: Setting) -> tuple[Step, dict[int, Trig]]:
    """The step, and what the load adds to the force along each coordinate: f · ∂r_P/∂q_i."""
    tip = [s.symbols.element(x) for x in s.tip_position()]
    lines = [
        eq(vec("f"), ex.Vector(tuple(map(sym, s.load)))),
        eq(vec("r_P"), s.column(tuple(tip))),
    ]
    works: dict[int, Trig] = {}
    for i in s.leaders:
        x = s.coordinate(i)
        works[i] = inner([position.derivative(x) for position in tip], s.load_components, s.symbols)
        part = ex.dot(vec("f"), ex.partial(vec("r_P"), x))
        motor = s.motor(i)
        lines.append(eq(f"Q{s.index(i) + 1}", ex.add(motor, part), ex.add(motor, s.show(works[i]))))
    reason = (
        "The work of motors and load in a small change of the coordinates, Σ τ_i δq_i + f · δr_P, "
        "is Σ Q_i δq_i: the load adds its component along the direction in which each coordinate "
        "moves the tip."
    )
    return Step("Generalized forces by virtual work", reason, tuple(lines)), works
