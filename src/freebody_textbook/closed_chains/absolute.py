"""A planar mechanism in absolute coordinates: position x, y of each body's centre of mass and angle
φ of its axes, with joints and loops as constraints (5.21-5.29).

M is constant and diagonal, and Φ_q has entries for the two bodies that a constraint joins, no
others. A body that several joints in a row free altogether, such as a platform on legs, is held by
none.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from freebody.algorithms.energy import resting_energy
from freebody.algorithms.kinematics import Pose
from freebody.algorithms.loop_constraints import LoopEquation, loop_equations
from freebody.elementary import Scalar
from freebody.expressions.polynomials.arithmetic import PolynomialRows
from freebody.expressions.polynomials.symbol_order import Order
from freebody.expressions.polynomials.symbols import RATE, SECOND, Symbols, TrigReader
from freebody.expressions.polynomials.textbook_form import Layout
from freebody.expressions.printed_names import COMPONENTS
from freebody.lazy import cached_property
from freebody.model.tree import Tree, TreeLoop
from freebody.scalars.generators import sign_of
from freebody.scalars.trig import Trig, TrigRing
from freebody.spatial import Vector, add, dot, product, sub, times
from freebody_textbook.closed_chains.first_kind import MULTIPLIER

LETTERS = ("x", "y", "phi")
_HALF = 0.5
"""The distance for which the algorithms' equation of a rod is |r|² - d², up to its constant."""


class _AbsoluteOrder(Order):
    """The order of symbols in absolute coordinates, where all angles are about one axis."""

    @cached_property
    def blocks(self) -> tuple[tuple[str, ...], ...]:
        """Groups of angles about parallel axes: a single group."""
        return (self.angles,)


class _AbsoluteLayout(Layout):
    """The layout for printing polynomials in absolute coordinates."""

    @cached_property
    def order(self) -> Order:
        """The order of symbols in print, and the kind of each."""
        return _AbsoluteOrder(self.symbols)


@dataclass(frozen=True)
class Constraint:
    """The equations of a joint (with its body) or of a loop; first: index of the first one."""

    values: tuple[Trig, ...]
    first: int
    body: int = -1
    loop: TreeLoop | None = None

    @property
    def rows(self) -> range:
        """Indices of the constraint's equations among all."""
        return range(self.first, self.first + len(self.values))


class AbsoluteCoordinates:
    """The constraints of a planar model and their derivatives, as polynomials in the absolute
    coordinates x, y and φ of its bodies (indices in the tree)."""

    def __init__(self, given: Symbols, efforts: Mapping[int, str]):
        """Set up the constraints of a model. efforts: names of forces or torques along the joints,
        by body."""
        self.given, self.efforts = given, efforts
        tree = given.tree
        self.numbers = {k: i + 1 for i, k in enumerate(tree.body_of)}
        self.links = frozenset(links_of(given))
        """Bodies without mass that stand for nothing: they are left out."""
        self.bodies = tuple(
            k for k in sorted(self.numbers, key=self.numbers.__getitem__) if k not in self.links
        )
        self.names = tuple(name for i in self.bodies for name in self.names_of(i))
        self.symbols = self._symbols()

    def names_of(self, i: int) -> tuple[str, str, str]:
        """Names of the coordinates of body i."""
        x, y, phi = (f"{letter}{self.numbers[i]}" for letter in LETTERS)
        return x, y, phi

    def _symbols(self) -> Symbols:
        """Symbols of the model in a ring with absolute coordinates in place of joint
        coordinates."""
        given = self.given
        moving = {x + end for x in given.coordinates for end in ("", RATE, SECOND)}
        signs = {sign_of(x + RATE) for x in given.coordinates}
        kept = [x for x in given.ring.names if x not in moving | signs | set(given.extra)]
        names = (*self.names, *(x + end for x in self.names for end in (RATE, SECOND)))
        count = 2 * len(self.bodies) + 3 * len(given.tree.loops) + len(self.bodies)
        multipliers = (f"{MULTIPLIER}{k}" for k in range(1, count + 1))
        extra = tuple(dict.fromkeys((*self.efforts.values(), *given.extra, *multipliers)))
        angles = [name for name in self.names if name.startswith(LETTERS[2])]
        turned = [x for x in given.ring.angles if x in kept]
        others = [x for x in (*names, *kept, *extra) if x not in (*angles, *turned)]
        ring = TrigRing([*angles, *turned], others)
        reader = TrigReader(ring, given.reader.numbers, given.formulas, given.reader.own)
        return Symbols(given.model, ring, self.names, reader, extra)

    @cached_property
    def tree(self) -> Tree:
        """The model's tree over the ring, used only for its constant numbers."""
        return self.symbols.tree

    @cached_property
    def layout(self) -> Layout:
        """The layout for printing polynomials in absolute coordinates."""
        return _AbsoluteLayout(self.symbols)

    # ------------------------------------------------------------ poses
    def _element(self, x: Scalar) -> Trig:
        return self.symbols.element(x)

    def mass(self, i: int) -> tuple[Trig, Vector, Trig]:
        """(m, centre of mass in body axes, I) of body i; zeros for a body without mass."""
        masses = self.tree.bodies[i].masses
        if not masses:
            return self.symbols.zero(), self.tree.space.zero, self.symbols.zero()
        return self._element(masses[0].m), masses[0].c, self._element(masses[0].inertia)

    def pose(self, i: int) -> Pose:
        """(R, origin) of the frame of body i, -1 being the ground."""
        if i < 0:
            return ((1.0, 0.0), (0.0, 1.0)), (0.0, 0.0)
        x, y, phi = self.names_of(i)
        ring = self.symbols.ring
        s, c = ring.sin(phi), ring.cos(phi)
        R = ((c, -s), (s, c))
        return R, sub((ring[x], ring[y]), times(R, self.mass(i)[1]))

    def point(self, i: int, at: Vector) -> tuple[Trig, ...]:
        """World position of a point of body i."""
        R, p = self.pose(i)
        return tuple(map(self._element, add(p, times(R, at))))

    def angle(self, i: int) -> Trig:
        """Absolute angle φ of body i."""
        return self.symbols.zero() if i < 0 else self.symbols.ring[self.names_of(i)[2]]

    # ------------------------------------------------------------ joints and loops
    def along(self, i: int) -> tuple[Trig, ...]:
        """(direction of the slide of joint i, direction across it) in world axes; both are fixed to
        the preceding body."""
        body = self.tree.bodies[i]
        R = product(self.pose(body.parent)[0], body.R)
        ux, uy = map(self._element, times(R, body.axis))
        return ux, uy, -uy, ux

    def gap(self, i: int) -> tuple[Trig, ...]:
        """Vector from the place of joint i on the body before it to the origin of body i."""
        body = self.tree.bodies[i]
        there = self.point(body.parent, body.p)
        return tuple(a - b for a, b in zip(self.point(i, (0.0, 0.0)), there, strict=True))

    def turned(self, i: int) -> Trig:
        """The angle of body i relative to the preceding body, including the constant rotation of
        its placement."""
        return self.angle(i) - self.angle(self.tree.bodies[i].parent)

    def coordinate(self, i: int) -> Trig:
        """The coordinate of joint i up to a constant turn; its motor does work along it."""
        if self.tree.bodies[i].primitive.turns:
            return self.turned(i)
        ux, uy, _, _ = self.along(i)
        dx, dy = self.gap(i)
        return ux * dx + uy * dy

    @cached_property
    def joints(self) -> tuple[int, ...]:
        """The bodies with a joint; other bodies are free."""
        return tuple(i for i in self.bodies if self.tree.bodies[i].parent not in self.links)

    @cached_property
    def constraints(self) -> tuple[Constraint, ...]:
        """The constraints of all loops, whose multipliers equal those in joint coordinates, and
        then of every joint."""
        found: list[Constraint] = []
        first = 0
        for loop in self.tree.loops:
            values = tuple(self._loop_values(loop))
            found.append(Constraint(values, first, loop=loop))
            first += len(values)
        for i in self.joints:
            dx, dy = self.gap(i)
            if self.tree.bodies[i].primitive.turns:
                values = (dx, dy)
            else:
                _, _, nx, ny = self.along(i)
                values = (nx * dx + ny * dy, self.turned(i))
            found.append(Constraint(values, first, body=i))
            first += 2
        return tuple(found)

    def _loop_values(self, loop: TreeLoop) -> Iterator[Trig]:
        if loop.closure.distance:
            (_, a), (_, b) = (self._frame(name) for name in loop.frames)
            r = sub(b, a)
            yield self._element(dot(r, r) - loop.distance * loop.distance)
        else:
            yield from (self._element(e.value) for e in self.equations_of(loop))

    def equations_of(self, loop: TreeLoop) -> list[LoopEquation]:
        """The equations of a loop, with the forces of their multipliers; for a rod |r|² - d² =
        0."""
        own = TreeLoop(loop.name, loop.closure, loop.frames, _HALF)
        frames = (self._frame(name) for name in loop.frames)
        return loop_equations(self.tree.space, own, *frames)

    def _frame(self, name: str) -> Pose:
        k, turned, at = self.tree.frames[name]
        R, _ = self.pose(k)
        return product(R, turned), self.point(k, at)

    # ------------------------------------------------------------ derivatives
    @cached_property
    def Phi(self) -> tuple[Trig, ...]:
        """Constraint equations Φ(q) (5.21)."""
        return tuple(x for constraint in self.constraints for x in constraint.values)

    @cached_property
    def Phi_q(self) -> PolynomialRows:
        """Jacobian of the constraints, ∂Φ/∂q (5.22)."""
        return [[x.derivative(name) for name in self.names] for x in self.Phi]

    @cached_property
    def c(self) -> list[Trig]:
        """Right side of Φ_q q̈ = c: -Φ̇_q q̇ (5.28)."""
        rates = {x: self.symbols.ring[x + RATE] for x in self.names}
        return [-x.along(rates).along(rates) for x in self.Phi]

    @cached_property
    def multipliers(self) -> list[Trig]:
        """Multipliers λ as symbols of the ring."""
        return [self.symbols.ring[f"{MULTIPLIER}{k}"] for k in range(1, len(self.Phi) + 1)]

    @cached_property
    def M(self) -> list[Trig]:
        """The diagonal of the mass matrix."""
        found = []
        for i in self.bodies:
            m, _, inertia = self.mass(i)
            found += [m, m, inertia]
        return found

    @cached_property
    def forces(self) -> list[Trig]:
        """Generalized forces Q - Φ_qᵀ λ by coordinate, the right side of M q̈ = …; Q: motors,
        weights and load."""
        ring = self.symbols.ring
        total = [a + b for a, b in zip(self._weights(), self._load(), strict=True)]
        pairs = [(self.coordinate(i), ring[name]) for i, name in self.efforts.items()]
        pairs += [(-x, y) for x, y in zip(self.Phi, self.multipliers, strict=True)]
        for along, effort in pairs:
            slopes = (along.derivative(name) for name in self.names)
            total = [x + slope * effort for x, slope in zip(total, slopes, strict=True)]
        return total

    def _weights(self) -> list[Trig]:
        found = []
        for i in self.bodies:
            m = self.mass(i)[0]
            found += [*(m * self._element(x) for x in self.tree.gravity), self.symbols.zero()]
        return found

    @cached_property
    def potential(self) -> Trig:
        """Potential energy V of the weights: minus force times position, plus the constant of parts
        fixed to the base."""
        ring, total = self.symbols.ring, self._element(resting_energy(self.tree))
        for force, name in zip(self._weights(), self.names, strict=True):
            total = total - force * ring[name]
        return total

    def _load(self) -> list[Trig]:
        """Generalized forces from the force on the tip."""
        force = tuple(self.symbols.ring[x] for x in COMPONENTS if x in self.given.extra)
        if not force:
            return [self.symbols.zero()] * len(self.names)
        k, _, at = self.tree.frames[self.given.model.frame().name]
        tip = self.point(k, at)
        return [dot(tuple(x.derivative(name) for x in tip), force) for name in self.names]


def links_of(given: Symbols) -> Iterator[int]:
    """Indices of massless bodies between the single joints that replace a free joint without
    motor."""
    n = 0
    for body in (given.given or given.model).bodies:
        parts = body.kind.nv if body.kind.composed else 1
        if parts == len(LETTERS) and body.kind.frees(2) and body.joint.passive and body.parent < 0:
            yield from (given.tree.body_of[k] for k in range(n, n + parts - 1))
        n += parts
