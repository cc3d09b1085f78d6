"""A model prepared for derivation: its bodies by number, their motion, and how everything is named
and printed.

In the plane vectors have world components, as in chapters 1 to 5 of the notes; in space those of
the body's own frame, as in chapter 6.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from freebody.algorithms.kinematics import (
    BodyMotions,
    Pose,
    joint_poses,
    outward,
    world_poses,
)
from freebody.algorithms.rnea import External, Recursion, rnea
from freebody.elementary import Scalar
from freebody.expressions import expression as ex
from freebody.expressions.expression import Expression
from freebody.expressions.naming import Naming
from freebody.expressions.nodes import Equation, Words
from freebody.expressions.notations.lettering import PLAIN, Lettering
from freebody.expressions.polynomials.symbols import Symbols
from freebody.expressions.polynomials.textbook_form import Layout
from freebody.expressions.printed_names import sym, vec
from freebody.lazy import cached_property
from freebody.model.joints import JointWords
from freebody.model.tree import Mass, Tree
from freebody.scalars.trig import Trig
from freebody.spatial import Vector, add, sub, times, transposed
from freebody_textbook.closed_chains.absolute import links_of
from freebody_textbook.equations.equations import Equations
from freebody_textbook.methods.lengths_and_directions import by_lengths

LOADS = {2: ("fx", "fy"), 3: ("fx", "fy", "fz")}
"""Names of the components of the force on the tip."""
MOST = 200
"""Terms that will not fit whatever their form."""
LONGEST = 160
"""Numbers and symbols up to which an expression is written out; a longer one is told by its
length."""


@dataclass(frozen=True)
class Setting:
    """A model over the ring of polynomials, prepared for derivation; load: names of the components
    of the force on the tip, empty without one."""

    symbols: Symbols
    load: tuple[str, ...] = ()
    at_rest: bool = False
    """Whether the robot stands still: velocities and accelerations are zero."""
    letters: Lettering = PLAIN
    """The letters that the derivation will be printed in; what is made here has the notes'."""

    # ------------------------------------------------------------ the model
    @property
    def tree(self) -> Tree:
        """The model as a tree over the ring."""
        return self.symbols.tree

    @property
    def planar(self) -> bool:
        """Whether the model is planar."""
        return self.tree.space.dim == 2

    @cached_property
    def naming(self) -> Naming:
        """The names of the model's forces, masses, vectors and lengths."""
        return Naming(self.symbols.model, self.symbols.reader.numbers)

    # ------------------------------------------------------------ joints
    @cached_property
    def numbers(self) -> dict[int, int]:
        """The printed number of each tree body, counted from 1 in the model's order; 0 for the base
        (-1)."""
        return {-1: 0} | {k: i + 1 for i, k in enumerate(self.tree.body_of)}

    @cached_property
    def order(self) -> tuple[int, ...]:
        """Tree bodies sorted by their number."""
        return tuple(sorted(range(len(self.tree.bodies)), key=lambda k: self.numbers[k]))

    @cached_property
    def links(self) -> frozenset[int]:
        """Massless bodies of a closed chain between consecutive free joints: a platform moves with
        its legs instead of being carried by them."""
        return frozenset(links_of(self.symbols) if self.tree.loops else ())

    def is_held(self, i: int) -> bool:
        """Whether joint i constrains its body in any direction."""
        return self.tree.bodies[i].parent not in self.links

    def turns(self, i: int) -> bool:
        """Whether joint i turns its body about its axis."""
        return self.tree.bodies[i].primitive.turns

    def slides(self, i: int) -> bool:
        """Whether joint i moves its body along its axis."""
        return self.tree.bodies[i].primitive.slides

    def words(self, i: int) -> JointWords:
        """Words for the joint of body i."""
        return self.tree.bodies[i].primitive.words

    @cached_property
    def cited(self) -> str:
        """The notes' arm "R" or "RR" if the model is this arm in the same angles, otherwise ""."""
        if self.symbols.turned or any(self.symbols.quarters):
            return ""
        if self.tree.loops or len(self.leaders) < len(self.order):
            return ""
        bodies = [self.tree.bodies[i] for i in self.order]
        is_chain = all(self.numbers[body.parent] == k for k, body in enumerate(bodies))
        if (
            not self.planar
            or not is_chain
            or not all(map(self.turns, self.order))
            or len(bodies) > 2
        ):
            return ""
        return "R" * len(bodies)

    def coordinate(self, i: int) -> str:
        """Name of the coordinate of body i's joint."""
        return self.symbols.coordinates[self.index(i)]

    def index(self, i: int) -> int:
        """Index of that coordinate among all."""
        return self.tree.bodies[i].coordinates.v[0]

    def driven(self, i: int) -> bool:
        """Whether a motor acts on the joint of body i."""
        return self.naming.driven(self.numbers[i])

    @cached_property
    def leaders(self) -> tuple[int, ...]:
        """Bodies whose joints have their own coordinate, sorted by number."""
        return tuple(i for i in self.order if not self.follows(i))

    def follows(self, i: int) -> bool:
        """Whether the joint of body i follows another."""
        return self.naming.follows(self.numbers[i])

    def together(self, i: int) -> tuple[int, ...]:
        """Body i and the bodies whose joints follow its joint."""
        return (i, *(k for k in self.order if self.follows(k) and self.index(k) == self.index(i)))

    def is_alone(self, i: int) -> bool:
        """Whether the joint of body i neither follows another nor is followed."""
        return not self.follows(i) and len(self.together(i)) == 1

    @cached_property
    def coupled(self) -> tuple[int, ...]:
        """Bodies whose joints others follow."""
        return tuple(i for i in self.leaders if not self.is_alone(i))

    def ratio(self, i: int) -> float:
        """The ratio of joint i's motion to its coordinate."""
        return self.tree.bodies[i].coordinates.ratio

    def rate(self, i: int, rates: Vector) -> Scalar:
        """The rate (or acceleration) of body i's joint, from those of the coordinates."""
        return self.tree.bodies[i].rates(rates)[0]

    def rotor_part(self, i: int) -> Trig:
        """The rotor inertia at joint i and at joints that follow it, times their accelerations."""
        total = self.symbols.zero()
        for k in self.together(i):
            drive = self.tree.bodies[k].drive
            if drive is not None:
                total = total + self.ratio(k) * (drive.inertia * self.rate(k, self.symbols.qdd))
        return total

    # ------------------------------------------------------------ masses
    def _mass(self, i: int) -> Mass:
        """Mass, centre of mass and inertia of body i; zeros for a body without mass."""
        masses = self.tree.bodies[i].masses
        assert len(masses) < 2, "its parts are made one by symbols_of_bodies"
        return masses[0] if masses else Mass(0.0, self.tree.space.zero, self._nothing())

    def _nothing(self) -> Any:
        return 0.0 if self.planar else ((0.0,) * 3,) * 3

    def mass(self, i: int) -> Scalar:
        """Mass of body i as polynomial or number."""
        return self._mass(i).m

    def inertia(self, i: int) -> Scalar:
        """Inertia of body i about its centre of mass."""
        return self._mass(i).inertia

    @cached_property
    def weighted(self) -> tuple[int, ...]:
        """Bodies with mass, sorted by number."""
        return tuple(i for i in self.order if self.tree.bodies[i].masses)

    def is_point(self, i: int) -> bool:
        """Whether body i is a point mass, without moment of inertia."""
        inertia = self.inertia(i)
        entries = (inertia,) if self.planar else (x for row in inertia for x in row)
        return all(isinstance(x, float) and x == 0.0 for x in entries)

    @property
    def weighs(self) -> bool:
        """Whether gravity acts."""
        return any(not (isinstance(x, float) and x == 0.0) for x in self.tree.gravity)

    # ------------------------------------------------------------ the tip
    @property
    def load_components(self) -> Vector:
        """The load on the tip in world axes, as given."""
        return tuple(self.symbols.ring[name] for name in self.load)

    @cached_property
    def tip_frame(self) -> tuple[int, Any, Vector]:
        """The body that carries the tip, and the tip's rotation and position there."""
        return self.tree.frames[self.symbols.model.frame().name]

    @property
    def tip(self) -> int:
        """The body that carries the tip."""
        return self.tip_frame[0]

    def loaded(self, i: int) -> bool:
        """Whether the load acts on body i."""
        return bool(self.load) and self.tip == i

    # ------------------------------------------------------------ the layout
    @cached_property
    def equations(self) -> Equations:
        """Equations of motion in closed form."""
        return Equations(self.symbols)

    @property
    def layout(self) -> Layout:
        """The printed layout of polynomials."""
        return self.equations.layout

    # ------------------------------------------------------------ how values are shown
    def show(self, x: Scalar) -> Expression:
        """Printed scalar sorted by accelerations and rates, or its length if it is too long."""
        return self._short(x, self.layout.form)

    def show_moved(self, x: Scalar) -> Expression:
        """Printed component of a velocity, acceleration or force, sorted by lengths."""
        return self._short(x, lambda element: by_lengths(self.layout, element))

    def with_value(self, left: str, rule: Expression, x: Scalar) -> Equation:
        """The equation left = rule = value, without the value if it is too long to read."""
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
        """Printed column vector; 0 if all entries vanish."""
        entries = tuple(self.show_moved(x) for x in v)
        return ex.ZERO if all(x == ex.ZERO for x in entries) else ex.Vector(entries)

    def angular(self, v: Vector) -> Expression:
        """Printed angular vector: a scalar in the plane."""
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
        """Symbol f_{i,k} of the force by body i on body k."""
        return self.naming.force(self.numbers[i], self.numbers[k])

    def moment_name(self, i: int, k: int) -> Expression:
        """Symbol n_{i,k} of the moment by body i on body k."""
        return self.naming.moment(self.numbers[i], self.numbers[k])

    def joint_moment(self, i: int) -> Expression:
        """Symbol of the parent's moment on body i: n, but for a turning joint in the plane the
        motor's τ_i or 0."""
        return self.naming.joint_moment(self.numbers[i])

    def is_pin(self, i: int) -> bool:
        """Whether joint i turns in the plane, so that it transmits no moment except its motor's."""
        moment = self.joint_moment(i)
        return moment in (ex.ZERO, self.naming.torque(self.numbers[i]))

    def centre_name(self, i: int) -> Expression:
        """Symbol s_ci of the vector from joint i to the centre of mass of body i; 0 for a massless
        body, whose moments are taken about its joint."""
        return self.name("sc", i) if i in self.weighted else ex.ZERO

    def reach_name(self, i: int, k: int) -> Expression:
        """Symbol of the vector from joint i to the joint of child k: s_i, or s_{i,k} if body i has
        several children."""
        return self.naming.reach(self.numbers[i], self.numbers[k])

    def tip_name(self) -> Expression:
        """Symbol s of the vector from the joint of the tip's body to the tip."""
        return self.naming.to_tip(self.numbers[self.tip])

    def axis_name(self, i: int) -> Expression:
        """Symbol of joint i's axis: z_i if it turns, u_i if it slides."""
        return self.naming.axis(self.numbers[i])

    def rotation_name(self, source: int, target: int) -> ex.Symbol:
        """Symbol R^target_source of the matrix that converts components from one body's axes to
        another's."""
        a, b = self.numbers[source], self.numbers[target]
        return ex.Symbol(f"R{a}_{b}", "R", (str(a),), high=str(b))

    def motor(self, i: int) -> Expression:
        """Symbol τ_i of the motor's torque; 0 for a passive joint."""
        return self.naming.motor(self.numbers[i])

    def mass_name(self, i: int) -> Expression:
        """Symbol of the mass of body i: the model's name, otherwise m_i."""
        return self.naming.mass(self.numbers[i])

    def inertia_name(self, i: int) -> Expression:
        """Symbol of the moment of inertia of body i in the plane: the model's name, otherwise
        I_i."""
        return self.naming.inertia(self.numbers[i])

    def field_name(self, i: int) -> Expression:
        """Symbol of gravity acting on body i."""
        return vec("g")

    # ------------------------------------------------------------ terms of equations
    def position(self, i: int) -> Expression:
        """Printed displacement of body i's joint: its coordinate, or for a following joint ratio
        times coordinate plus offset."""
        at = self.tree.bodies[i].coordinates
        turned = ex.mul(self.show(at.ratio), sym(self.coordinate(i)))
        return ex.add(turned, self.show(at.offset))

    def advance(self, i: int) -> Expression:
        """Printed distance along the axis per unit of joint i's coordinate."""
        return self.show(self.tree.bodies[i].primitive.advance)

    def along(
        self,
        i: int,
        moment: Expression,
        force: Expression,
        product: Callable[[Expression, Expression], Expression] = ex.dot,
    ) -> Expression:
        """The component of a moment and a force at joint i that does work along its coordinate."""
        axis, terms = self.axis_name(i), []
        if self.turns(i):
            terms.append(moment if self.planar else product(axis, moment))
        if self.slides(i):
            terms.append(ex.mul(self.advance(i), product(axis, force)))
        return ex.add(*terms)

    def mass_times(self, i: int, x: Expression) -> Expression:
        """Printed product m_i x; 0 for a body without mass."""
        return ex.mul(self.mass_name(i), x) if i in self.weighted else ex.ZERO

    def needed(self, i: int) -> Expression:
        """Printed m (v̇_c - g) of body i, the sum of all forces on it except weight."""
        acceleration = self.name("vc", i, "_d")
        return self.mass_times(i, ex.sub(acceleration, vec("g")) if self.weighs else acceleration)

    def spin_terms(self, i: int) -> Expression:
        """Printed I ω̇ (in space + ω × I ω), the sum of the moments about a body's centre of mass;
        0 for a point mass."""
        if self.is_point(i):
            return ex.ZERO
        inertia = self.inertia_name(i)
        turning = ex.mul(inertia, self.angular_name("omega", i, "_d"))
        if self.planar:
            return turning
        w = self.angular_name("omega", i)
        return ex.add(turning, ex.cross(w, ex.mul(inertia, w)))

    # ------------------------------------------------------------ motion
    @cached_property
    def motion(self) -> BodyMotions:
        """Velocities and accelerations of all bodies in body axes, with the base at rest."""
        return outward(self.tree, self.symbols.q, *self._rates)

    @property
    def _rates(self) -> tuple[Vector, Vector]:
        """Velocities and accelerations of the coordinates."""
        still = (0.0,) * self.tree.nv
        return (still, still) if self.at_rest else (self.symbols.qd, self.symbols.qdd)

    def recursion(self, gravity: str) -> Recursion:
        """Intermediate results of the Newton-Euler recursion; gravity: "base" or "explicit"."""
        return rnea(self.tree, self.symbols.q, *self._rates, self.tip_load(), gravity)

    def tip_load(self) -> tuple[External, ...]:
        """The load in the axes of the tip's body, as external force for the recursion."""
        if not self.load:
            return ()
        body, _, p = self.tip_frame
        world = world_poses(self.tree, joint_poses(self.tree, self.symbols.q))
        force = times(transposed(world[body][0]), self.load_components)
        return ((body, force, self.tree.space.moment(p, force)),)

    @cached_property
    def world(self) -> list[Pose]:
        """Pose of every body in the world."""
        return world_poses(self.tree, self.motion.joints)

    # ------------------------------------------------------------ vectors
    def axes(self, i: int, v: Vector) -> Vector:
        """Components of a vector of body i in the printed axes: the world's in the plane, the
        body's in space."""
        return times(self.world[i][0], v) if self.planar else v

    def axis(self, i: int) -> Vector:
        """Direction of joint i, in the printed axes."""
        return self.axes(i, self.tree.bodies[i].axis)

    def centre(self, i: int) -> Vector:
        """Vector from the joint origin of body i to its centre of mass."""
        return self.axes(i, self._mass(i).c)

    def centre_velocity(self, i: int) -> Vector:
        """Velocity of the centre of mass of body i."""
        c = self._mass(i).c
        return self.axes(i, add(self.motion.v[i], self.tree.space.cross(self.motion.w[i], c)))

    def centre_acceleration(self, i: int) -> Vector:
        """Acceleration of the centre of mass of body i."""
        return self.axes(i, add(self.motion.vd[i], times(self.motion.rates[i], self._mass(i).c)))

    def centre_position(self, i: int) -> Vector:
        """World position of the centre of mass of body i."""
        R, p = self.world[i]
        return add(p, times(R, self._mass(i).c))

    def to_child(self, i: int, k: int) -> Vector:
        """Vector from the joint origin of body i to that of its child k."""
        if self.planar:
            return sub(self.world[k][1], self.world[i][1])
        return self.motion.joints[k][1]

    def ends_in_tip(self, i: int) -> bool:
        """Whether body i is the last of its branch and carries the tip."""
        has_tip = self.symbols.model.tip is not None
        return has_tip and not self.tree.children(i) and self.tip == i

    def to_tip(self, i: int) -> Vector:
        """Vector from the joint origin of body i to the tip on it."""
        return self.axes(i, self.tip_frame[2])

    def gravity(self, i: int) -> Vector:
        """Gravity in the axes of body i."""
        return (
            self.tree.gravity
            if self.planar
            else times(transposed(self.world[i][0]), self.tree.gravity)
        )

    def tip_force(self) -> Vector:
        """The load on the tip, converted from world axes to the printed axes of its body."""
        force = self.load_components
        return force if self.planar else times(transposed(self.world[self.tip][0]), force)

    def tip_position(self) -> Vector:
        """Position of the tip in the world."""
        R, p = self.world[self.tip]
        return add(p, times(R, self.tip_frame[2]))
