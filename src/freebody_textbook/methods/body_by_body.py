"""Newton's and Euler's equations of every body in a chain: reactions solved from the last body
inward, and the steps that name them, eliminate them and insert the motion (3.5-3.15)."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from itertools import combinations

from freebody.expressions import expression as ex
from freebody.expressions.expression import Equation, Expression, eq
from freebody.expressions.nodes import Product, Symbol, Words
from freebody.expressions.printed_names import component, sym, vec
from freebody.lazy import cached_property
from freebody.scalars.trig import Trig
from freebody.spatial import Vector, add, dot, scale, sub, times
from freebody_textbook.derivation import Step
from freebody_textbook.methods import step_reasons
from freebody_textbook.methods.lengths_and_directions import Directed, cosine, directed, sine
from freebody_textbook.methods.setting import Setting
from freebody_textbook.methods.shared_steps import moment_of

_BY_COMPONENTS = "First each cross product by components, a × b = a_x b_y − a_y b_x."


_FEW = 6
"""Pairs of arms up to which the angle between each two is told."""


_NamedVector = tuple[Expression, Vector]
"""Name and value of a vector along a body."""


Reaction = tuple[Vector, Vector]
"""Force and moment at a joint."""


class SolvedReactions:
    """The reactions at all joints: f and n of body i are the parent's force and moment on it at
    joint i, in the printed axes."""

    def __init__(self, setting: Setting):
        self.s = setting
        self._found = self._inward(lambda i, reaction: reaction)

    @property
    def f(self) -> dict[int, Vector]:
        """Reaction forces at the joints, by body."""
        return {i: f for i, (f, _) in self._found.items()}

    @property
    def n(self) -> dict[int, Vector]:
        """Moments of the reactions about the joints."""
        return {i: n for i, (_, n) in self._found.items()}

    @cached_property
    def borne(self) -> dict[int, Reaction]:
        """The reactions (f, n) of the bearings alone: without the component along the coordinate of
        a joint without motor, which its equation of motion makes zero."""
        return self._inward(self._without_motor)

    def _without_motor(self, i: int, reaction: Reaction) -> Reaction:
        s, (f, n) = self.s, reaction
        if s.driven(i) or not s.is_alone(i) or s.turns(i) == s.slides(i):
            return reaction
        if not self.drives[i].is_zero:
            return reaction
        ((w, v),) = s.tree.bodies[i].columns
        v = s.axes(i, v)
        if s.turns(i):
            return f, sub(n, scale(dot(w, n), w))
        return sub(f, scale(dot(v, f), v)), n

    def _inward(self, passed_on: Callable[[int, Reaction], Reaction]) -> dict[int, Reaction]:
        found: dict[int, Reaction] = {}
        for i in reversed(range(len(self.s.tree.bodies))):
            found[i] = passed_on(i, self._solved(i, found))
        return found

    def _solved(self, i: int, found: dict[int, Reaction]) -> Reaction:
        """The reaction at joint i from the two equations of body i, when those at its children are
        known."""
        s, space = self.s, self.s.tree.space
        f = scale(s.mass(i), sub(s.centre_acceleration(i), s.gravity(i)))
        n = add(
            space.euler(s.inertia(i), s.motion.w[i], s.motion.wd[i]), space.moment(s.centre(i), f)
        )
        for k in s.tree.children(i):
            R = s.motion.joints[k][0]
            f_k, n_k = found[k]
            if not s.planar:
                f_k, n_k = times(R, f_k), space.turn(R, n_k)
            f = add(f, f_k)
            n = add(n, n_k, space.moment(s.to_child(i, k), f_k))
        for force, moment in self.applied(i):
            f, n = sub(f, force), sub(n, moment)
        return f, n

    def applied(self, i: int) -> Iterable[tuple[Vector, Vector]]:
        """External forces on body i except weight, with their moments about its joint."""
        s = self.s
        if s.loaded(i):
            yield s.tip_force(), s.tree.space.moment(s.to_tip(i), s.tip_force())

    def motor(self, i: int) -> Trig:
        """The motor's component of joint i's reaction, with those of the joints that the same motor
        moves, and its drive's friction, springs and rotor."""
        s, total = self.s, self.drives[i]
        for k in s.together(i):
            f, n = self._found[k]
            ((w, v),) = s.tree.bodies[k].columns
            total = total + s.ratio(k) * (dot(w, n) + dot(s.axes(k, v), f))
        return s.symbols.element(total)

    @cached_property
    def drives(self) -> dict[int, Trig]:
        """Torques of friction, springs and rotors that the motors must overcome; at rest only what
        then acts, such as springs."""
        return {i: drive_part(self.s, i) for i in self.s.leaders}

    def motor_rule(self, i: int, moment: Expression) -> Expression:
        """Printed rule for the motor's component of a reaction, plus its drive's part."""
        s = self.s
        part = s.along(i, moment, s.force_name(s.tree.bodies[i].parent, i))
        return ex.add(part, s.show(self.drives[i]))


def drive_part(s: Setting, i: int) -> Trig:
    """The torque that friction, spring and rotor of joint i, and of joints that follow it, require
    of its motor; at rest only what then acts, such as springs."""
    total = s.symbols.zero()
    for k in s.together(i) if s.at_rest else ():
        body = s.tree.bodies[k]
        if body.drive is not None:
            at_rest = body.drive.only(lambda law: not law.only_moving)
            total = total + s.ratio(k) * at_rest.torque(s.symbols.q, (0.0,) * s.tree.nv)
    return total if s.at_rest else s.equations.drives[s.index(i)] + s.rotor_part(i)


class FreeBodies:
    """The steps that name the reactions, eliminate them and insert the motion."""

    def __init__(self, setting: Setting, reactions: SolvedReactions, tau: dict[int, Trig]):
        self.s = setting
        self.reactions = reactions
        self.tau = tau

    def about_centres(self) -> list[Step]:
        """Steps with two equations per body, and then the elimination of reactions from the last
        body inward."""
        s = self.s
        return [*map(self.body, s.order), *map(self.eliminated, reversed(s.order))]

    # ------------------------------------------------------------ free bodies
    def body(self, i: int) -> Step:
        """Step: Newton's and Euler's equations of one free body."""
        s, n = self.s, self.s.numbers[i]
        lines = (eq(self.forces(i), self.inertia_force(i)), eq(self.moments(i), s.spin_terms(i)))
        numbers = {
            ("R", 1): ("3.5", "3.6"),
            ("RR", 1): ("3.10", "3.11"),
            ("RR", 2): ("3.12", "3.13"),
        }.get((s.cited, n), ("3.1", "3.2") if s.planar else ("6.1", "6.2"))
        reason = step_reasons.free_body(s, i, self.further_forces(i))
        return Step(f"Free body {n}", reason, lines, numbers, figure=f"free-body {n}")

    def outer(self, i: int) -> list[tuple[Expression, Expression]]:
        """External forces on body i except weight, each with the vector from its joint to the point
        of action."""
        return [(vec("f"), self.s.tip_name())] if self.s.loaded(i) else []

    def turned(self, i: int) -> list[Expression]:
        """External moments on body i."""
        return []

    def further_forces(self, i: int) -> list[str]:
        """Phrases for forces on body i besides joints, weight and load."""
        return []

    def forces(self, i: int) -> Expression:
        """Sum of the forces on body i: its parent's, minus those on its children, weight and
        external forces."""
        s = self.s
        terms = [s.force_name(s.tree.bodies[i].parent, i)] if s.is_held(i) else []
        terms += [ex.neg(s.force_name(i, k)) for k in s.tree.children(i)]
        if s.weighs:
            terms.append(s.mass_times(i, vec("g")))
        return ex.add(*terms, *(force for force, _ in self.outer(i)))

    def moments(self, i: int) -> Expression:
        """Sum of the moments on body i about its centre of mass."""
        s = self.s
        arm, children = s.centre_name(i), s.tree.children(i)
        terms = [s.joint_moment(i), *(ex.neg(s.joint_moment(k)) for k in children)]
        if s.is_held(i):
            terms.append(ex.neg(ex.cross(arm, s.force_name(s.tree.bodies[i].parent, i))))
        for k in children:
            terms.append(ex.neg(ex.cross(ex.sub(s.reach_name(i, k), arm), s.force_name(i, k))))
        terms += [moment_of(force, ex.sub(at, arm)) for force, at in self.outer(i)]
        return ex.add(*terms, *self.turned(i))

    def inertia_force(self, i: int) -> Expression:
        """The mass times the acceleration of body i, which the forces on it add up to."""
        return self.s.mass_times(i, self.s.name("vc", i, "_d"))

    # ------------------------------------------------------------ elimination
    def left_over(self, i: int) -> str:
        """Phrase for the unknowns that remain when the reaction at joint i is eliminated, besides
        the motor's part."""
        return "nothing unknown"

    def passed(self, i: int) -> Expression:
        """The force at joint i without reactions: inertia and weight of body i and all bodies that
        it carries, minus external forces."""
        s = self.s
        terms = [s.needed(i), *(self.passed(k) for k in s.tree.children(i))]
        return ex.add(*terms, *(ex.neg(force) for force, _ in self.outer(i)))

    def eliminated(self, i: int) -> Step:
        """Step: the reaction at joint i from Newton's equation, inserted into Euler's."""
        s, n = self.s, self.s.numbers[i]
        lines = [
            eq(s.force_name(s.tree.bodies[i].parent, i), self.passed(i)),
            eq(s.joint_moment(i), self.held(i)),
        ]
        if not s.is_pin(i) and s.is_alone(i):
            lines.append(eq(s.motor(i), self.reactions.motor_rule(i, s.joint_moment(i))))
        numbers = {("R", 1): ("3.7",), ("RR", 1): ("3.15",), ("RR", 2): ("3.14",)}.get(
            (s.cited, n), ()
        )
        return Step(
            f"Eliminate the reactions at joint {n}",
            step_reasons.eliminated(s, i, self.left_over(i))
            + (step_reasons.drive(s, i) if s.is_alone(i) else ""),
            tuple(lines),
            numbers,
        )

    def held(self, i: int) -> Expression:
        """The moment at joint i, with the reaction forces eliminated."""
        s, children = self.s, self.s.tree.children(i)
        terms = [
            *map(s.joint_moment, children),
            s.spin_terms(i),
            ex.cross(s.centre_name(i), s.needed(i)),
        ]
        terms += [ex.cross(s.reach_name(i, k), self.passed(k)) for k in children]
        terms += [ex.neg(moment_of(force, arm)) for force, arm in self.outer(i)]
        return ex.add(*terms, *map(ex.neg, self.turned(i)))

    # ------------------------------------------------------------ values
    def crossed(self, i: int) -> Iterator[Equation]:
        """Cross products in the moment at joint i by components; none in space or for closed
        chains, whose forces have unknown components."""
        s = self.s
        if not s.planar or s.tree.loops:
            return
        if i in s.weighted and s.column(s.centre(i)) != ex.ZERO:
            force = scale(s.mass(i), sub(s.centre_acceleration(i), s.gravity(i)))
            yield _crossed(s, (s.centre_name(i), s.centre(i)), (s.needed(i), force))
        for k in s.tree.children(i):
            if s.column(s.to_child(i, k)) != ex.ZERO:
                arm = s.reach_name(i, k), s.to_child(i, k)
                yield _crossed(s, arm, (self.passed(k), self.reactions.f[k]))

    def substituted(self, i: int, reactions: bool) -> Step:
        """Step: reaction and torque at joint i with the motion inserted."""
        s, n = self.s, self.s.numbers[i]
        lines = list(self.crossed(i))
        reason = "" if s.tree.children(i) or not lines else f"{_BY_COMPONENTS} "
        if reactions:
            (force, moment), pin = self.reactions.borne[i], s.is_pin(i)
            lines.append(eq(s.force_name(s.tree.bodies[i].parent, i), s.column(force)))
            if not pin:
                lines.append(eq(s.joint_moment(i), s.angular(moment)))
        if s.is_alone(i):
            lines.append(eq(s.motor(i), s.show(self.tau[i])))
        reason += step_reasons.substituted(s, i, reactions)
        if reactions:
            given = self.reactions.f[i] if pin else (*self.reactions.f[i], *self.reactions.n[i])
            left = force if pin else (*force, *moment)
            if any(not s.symbols.element(a - b).is_zero for a, b in zip(given, left, strict=True)):
                reason += " What vanishes by the equation of a joint without a motor is left out."
            reason += step_reasons.gyroscopic(s, i, self.reactions.n[i])
        return Step(f"Substitute the motion: joint {n}", reason, tuple(lines))


def angles_between_arms(s: Setting) -> list[Step]:
    """Steps on products of lever arms that turn by different angles, which simplify to the cosine
    or sine of the angle between them; none in space, or without such arms."""
    arms = _by_angle(s) if s.planar else {}
    pairs = list(combinations(arms.values(), 2))
    if not pairs or len(pairs) > _FEW:
        return []
    lines = [line for one, other in pairs for line in _products(s, one, other)]
    reason = (
        "Moments are products of two vectors, each with the angle of its own body. What becomes of "
        "the products of sines and cosines, two arms show: a · b and a × b, by components, are "
        "their lengths times the cosine and the sine of the angle from the one to the other."
    )
    return [Step("Angles between the arms", reason, tuple(lines))]


def _by_angle(s: Setting) -> dict[object, tuple[Expression, Vector, Directed]]:
    """For each angle of a lever arm the first such arm: name, value, and value along the angle."""
    found: dict[object, tuple[Expression, Vector, Directed]] = {}
    for name, value in _arms(s):
        parts = directed(s.layout, [s.symbols.element(x) for x in value])
        if len(parts) == 1 and parts[0].angle and parts[0].across.is_zero:
            found.setdefault(parts[0].angle, (name, value, parts[0]))
    return found


def _arms(s: Setting) -> Iterator[_NamedVector]:
    """Lever arms: vectors from the joints to centres of mass, and from joint to joint."""
    for i in s.weighted:
        yield s.centre_name(i), s.centre(i)
    for i in s.order:
        for k in s.tree.children(i):
            yield s.reach_name(i, k), s.to_child(i, k)


def _products(
    s: Setting,
    one: tuple[Expression, Vector, Directed],
    other: tuple[Expression, Vector, Directed],
) -> Iterator[Equation]:
    (a, u, first), (b, v, second) = one, other
    lengths = s.show_moved(first.along), s.show_moved(second.along)
    (moment,) = s.tree.space.moment(u, v)
    (ax, ay), (bx, by) = ([_component(s, x, axis) for axis in "xy"] for x in (a, b))
    for product, value, function in (
        (ex.add(ex.mul(ax, bx), ex.mul(ay, by)), dot(u, v), cosine),
        (ex.sub(ex.mul(ax, by), ex.mul(ay, bx)), moment, sine),
    ):
        yield ex.eq(product, ex.mul(*lengths, function(first, second)), s.show_moved(value))


def _crossed(s: Setting, arm: _NamedVector, force: _NamedVector) -> Equation:
    """The equation of arm × force by components, and with the motion inserted."""
    (a, u), (f, v) = arm, force
    mass, rest = _without_mass(f)
    x, y = (_component(s, a, axis) for axis in "xy")
    spelt = ex.sub(ex.mul(x, _component(s, rest, "y")), ex.mul(y, _component(s, rest, "x")))
    (moment,) = s.tree.space.moment(u, v)
    value = s.show_moved(moment)
    sides = (ex.cross(a, f), ex.mul(mass, spelt), *([] if isinstance(value, Words) else [value]))
    return ex.eq(*sides)


def _without_mass(force: Expression) -> tuple[Expression, Expression]:
    """The two factors m and v̇ - g of an inertia force."""
    if isinstance(force, Product):
        return ex.mul(*force.factors[:-1]), force.factors[-1]
    return ex.ONE, force


def _component(s: Setting, x: Expression, axis: str) -> Expression:
    """A component of a vector expression: each vector is replaced by the name of its component,
    gravity by its value."""
    if x == vec("g"):
        return s.show(s.tree.gravity["xy".index(axis)])
    if s.load and x == vec("f"):
        return sym(s.load["xy".index(axis)])
    if isinstance(x, Symbol):
        return component(x, axis) if x.bold else x
    terms = [_component(s, term, axis) for term in x.parts]
    if isinstance(x, ex.Sum):
        return ex.add(*terms)
    return ex.neg(*terms) if isinstance(x, ex.Negative) else ex.mul(*terms)
