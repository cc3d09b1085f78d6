"""How the quantities of a derivation are called and shown."""

from __future__ import annotations

from collections.abc import Callable

from freebody.elementary import Scalar
from freebody.expressions import expression as ex
from freebody.expressions.expression import Expression
from freebody.expressions.nodes import Equation, Words
from freebody.expressions.polynomials.grouped_by_length import by_lengths
from freebody.expressions.polynomials.textbook_form import Layout
from freebody.expressions.printed_names import sym, vec
from freebody.lazy import cached_property
from freebody.scalars.trig import Trig
from freebody.spatial import Vector
from freebody_textbook.equations.equations import Equations
from freebody_textbook.methods.mechanism import Mechanism

MOST = 200
"""Terms that will not fit whatever their form."""
LONGEST = 160
"""Numbers and symbols up to which an expression is written out; a longer one is told by its
length."""


class ShownMechanism(Mechanism):
    """The symbols of a model's quantities, and its values as they are printed."""

    # ------------------------------------------------------------ the layout
    @cached_property
    def equations(self) -> Equations:
        """The closed forms."""
        return Equations(self.symbols)

    @property
    def layout(self) -> Layout:
        """How polynomials are printed."""
        return self.equations.layout

    # ------------------------------------------------------------ how values are shown
    def show(self, x: Scalar) -> Expression:
        """A scalar sorted by accelerations and rates, or told by its length."""
        return self._short(x, self.layout.form)

    def show_moved(self, x: Scalar) -> Expression:
        """A component of a velocity, acceleration or force, sorted by lengths."""
        return self._short(x, lambda element: by_lengths(self.layout, element))

    def with_value(self, left: str, rule: Expression, x: Scalar) -> Equation:
        """left = rule = value; left = rule where nobody could read the value."""
        value = self.show(x)
        return ex.eq(left, rule) if isinstance(value, Words) else ex.eq(left, rule, value)

    def _short(self, x: Scalar, form: Callable[[Trig], Expression]) -> Expression:
        element = self.symbols.element(x)
        if len(element) <= MOST:
            shown = form(element)
            if ex.size(shown) <= LONGEST:
                return shown
        return ex.words(f"({len(element)} terms)")

    def column(self, v: Vector) -> Expression:
        """A vector written out; 0 where all of it vanishes."""
        entries = tuple(self.show_moved(x) for x in v)
        return ex.ZERO if all(x == ex.ZERO for x in entries) else ex.Vector(entries)

    def angular(self, v: Vector) -> Expression:
        """An angular vector: a scalar in the plane."""
        return self.show(v[0]) if self.planar else self.column(v)

    # ------------------------------------------------------------ names
    def name(self, letter: str, i: int, dots: str = "") -> Expression:
        """Symbol of a vector of body i, such as v_ci."""
        return vec(f"{letter}{self.numbers[i]}{dots}")

    def angular_name(self, letter: str, i: int, dots: str = "") -> Expression:
        """Symbol of an angular vector of body i."""
        name = f"{letter}{self.numbers[i]}{dots}"
        return sym(name) if self.planar else vec(name)

    def force_name(self, i: int, k: int) -> Expression:
        """f_{i,k}: by body i on body k."""
        return self.naming.force(self.numbers[i], self.numbers[k])

    def moment_name(self, i: int, k: int) -> Expression:
        """n_{i,k}: moment by body i on body k."""
        return self.naming.moment(self.numbers[i], self.numbers[k])

    def joint_moment(self, i: int) -> Expression:
        """The moment of the parent on body i: n, but in a turning joint of the plane the motor's
        τ_i or 0."""
        return self.naming.joint_moment(self.numbers[i])

    def is_pin(self, i: int) -> bool:
        """Whether joint i turns in the plane and transmits no moment besides its motor's, if it has
        one."""
        moment = self.joint_moment(i)
        return moment in (ex.ZERO, self.naming.torque(self.numbers[i]))

    def centre_name(self, i: int) -> Expression:
        """s_ci from joint i to the centre of mass of body i; 0 of a body without mass, whose
        moments are taken about its joint."""
        return self.name("sc", i) if i in self.weighted else ex.ZERO

    def reach_name(self, i: int, k: int) -> Expression:
        """s_i from joint i to that of its child k, or s_{i,k} where body i carries several."""
        return self.naming.reach(self.numbers[i], self.numbers[k])

    def tip_name(self) -> Expression:
        """s of the body that carries the tip, from its joint to the tip."""
        return self.naming.to_tip(self.numbers[self.tip])

    def axis_name(self, i: int) -> Expression:
        """z_i, which joint i turns about, or u_i, along which it slides."""
        return self.naming.axis(self.numbers[i])

    def motor(self, i: int) -> Expression:
        """τ_i of the motor; 0 of a passive joint."""
        return self.naming.motor(self.numbers[i])

    def mass_name(self, i: int) -> Expression:
        """The model's name for the mass of body i, else m_i."""
        return self.naming.mass(self.numbers[i])

    def inertia_name(self, i: int) -> Expression:
        """The model's name for the moment of inertia of body i in the plane, else I_i."""
        return self.naming.inertia(self.numbers[i])

    def field_name(self, i: int) -> Expression:
        """Gravity as it acts on body i."""
        return vec("g")

    # ------------------------------------------------------------ terms of equations
    def position(self, i: int) -> Expression:
        """What the joint of body i has turned or slid: its coordinate, or of one that follows
        another ratio times that and the offset."""
        at = self.tree.bodies[i].coordinates
        turned = ex.mul(self.show(at.ratio), sym(self.coordinate(i)))
        return ex.add(turned, self.show(at.offset))

    def advance(self, i: int) -> Expression:
        """How far joint i takes its body along its axis for each unit of its coordinate."""
        return self.show(self.tree.bodies[i].primitive.advance)

    def along(
        self,
        i: int,
        moment: Expression,
        force: Expression,
        product: Callable[[Expression, Expression], Expression] = ex.dot,
    ) -> Expression:
        """The part of a moment and a force at joint i that does work along its coordinate."""
        axis, terms = self.axis_name(i), []
        if self.turns(i):
            terms.append(moment if self.planar else product(axis, moment))
        if self.slides(i):
            terms.append(ex.mul(self.advance(i), product(axis, force)))
        return ex.add(*terms)

    def mass_times(self, i: int, x: Expression) -> Expression:
        """m_i x; 0 of a body without mass."""
        return ex.mul(self.mass_name(i), x) if i in self.weighted else ex.ZERO

    def needed(self, i: int) -> Expression:
        """m (v̇_c - g) of body i: what all other forces on it must add up to."""
        acceleration = self.name("vc", i, "_d")
        return self.mass_times(i, ex.sub(acceleration, vec("g")) if self.weighs else acceleration)

    def spin_terms(self, i: int) -> Expression:
        """I ω̇ (+ ω × I ω in space): what the moments about a body's centre of mass add up to; 0 of
        a point mass."""
        if self.is_point(i):
            return ex.ZERO
        inertia = self.inertia_name(i)
        turning = ex.mul(inertia, self.angular_name("omega", i, "_d"))
        if self.planar:
            return turning
        w = self.angular_name("omega", i)
        return ex.add(turning, ex.cross(w, ex.mul(inertia, w)))
