"""What derivations ask of the model: its bodies by number, their joints and masses, the tip."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from freebody.elementary import Scalar
from freebody.errors import FreebodyError
from freebody.expressions.naming import Naming
from freebody.expressions.notations.lettering import PLAIN, Lettering
from freebody.expressions.polynomials.symbols import Symbols
from freebody.lazy import cached_property
from freebody.model.joints import JointWords
from freebody.model.tree import Mass, Tree
from freebody.spatial import Vector
from freebody_textbook.closed_chains.absolute import links_of


@dataclass(frozen=True)
class Mechanism:
    """One model over the ring of polynomials; load: names of the components of the force on the
    tip, or none."""

    symbols: Symbols
    load: tuple[str, ...] = ()
    at_rest: bool = False
    """Whether the robot stands still: velocities and accelerations are zero."""
    letters: Lettering = PLAIN
    """The letters that the derivation will be printed in; what is made here has the notes'."""

    # ------------------------------------------------------------ the model
    @property
    def tree(self) -> Tree:
        """The model over the ring."""
        return self.symbols.tree

    @property
    def planar(self) -> bool:
        """Whether the model is in the plane."""
        return self.tree.space.dim == 2

    @cached_property
    def naming(self) -> Naming:
        """What everything is called."""
        return Naming(self.symbols.model, self.symbols.reader.numbers)

    # ------------------------------------------------------------ joints
    @cached_property
    def numbers(self) -> dict[int, int]:
        """Number of each body of the tree, as the model's order counts from 1; the base (-1) is
        0."""
        return {-1: 0} | {k: i + 1 for i, k in enumerate(self.tree.body_of)}

    @cached_property
    def order(self) -> tuple[int, ...]:
        """Bodies of the tree by their number."""
        return tuple(sorted(range(len(self.tree.bodies)), key=lambda k: self.numbers[k]))

    @cached_property
    def links(self) -> frozenset[int]:
        """Of a closed chain the bodies without mass between joints in a row that hold nothing: a
        platform on legs is moved by these, not borne."""
        return frozenset(links_of(self.symbols) if self.tree.loops else ())

    def is_held(self, i: int) -> bool:
        """Whether joint i holds its body in any direction."""
        return self.tree.bodies[i].parent not in self.links

    def turns(self, i: int) -> bool:
        """Whether joint i turns its body about its axis."""
        return self.tree.bodies[i].primitive.turns

    def slides(self, i: int) -> bool:
        """Whether joint i takes its body along its axis."""
        return self.tree.bodies[i].primitive.slides

    def words(self, i: int) -> JointWords:
        """How the joint of body i is spoken of."""
        return self.tree.bodies[i].primitive.words

    @cached_property
    def cited(self) -> str:
        """ "R" or "RR" where the model is an arm that the notes derive in these angles, else ""."""
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
        """Place of that coordinate among all."""
        return self.tree.bodies[i].coordinates.v[0]

    def driven(self, i: int) -> bool:
        """Whether a motor acts on the joint of body i."""
        return self.naming.driven(self.numbers[i])

    @cached_property
    def leaders(self) -> tuple[int, ...]:
        """Bodies whose joints have a coordinate of their own, by their number."""
        return tuple(i for i in self.order if not self.follows(i))

    def follows(self, i: int) -> bool:
        """Whether the joint of body i follows another."""
        return self.naming.follows(self.numbers[i])

    def together(self, i: int) -> tuple[int, ...]:
        """Body i and those whose joints follow its."""
        return (i, *(k for k in self.order if self.follows(k) and self.index(k) == self.index(i)))

    def is_alone(self, i: int) -> bool:
        """Whether the joint of body i neither follows another nor is followed."""
        return not self.follows(i) and len(self.together(i)) == 1

    def ratio(self, i: int) -> float:
        """How far the joint of body i goes for each unit of its coordinate."""
        return self.tree.bodies[i].coordinates.ratio

    def rate(self, i: int, rates: Vector) -> Scalar:
        """The rate of body i's joint, or its acceleration, of those of the coordinates."""
        return self.tree.bodies[i].rates(rates)[0]

    # ------------------------------------------------------------ masses
    def _mass(self, i: int) -> Mass:
        """What body i weighs; one without mass is a point of none."""
        masses = self.tree.bodies[i].masses
        assert len(masses) < 2, "its parts are made one by symbols_of_bodies"
        return masses[0] if masses else Mass(0.0, self.tree.space.zero, self._nothing())

    def _nothing(self) -> Any:
        return 0.0 if self.planar else ((0.0,) * 3,) * 3

    def mass(self, i: int) -> Scalar:
        """Mass of body i."""
        return self._mass(i).m

    def inertia(self, i: int) -> Scalar:
        """Inertia of body i about its centre of mass."""
        return self._mass(i).inertia

    @cached_property
    def weighted(self) -> tuple[int, ...]:
        """Bodies with mass, by their number."""
        return tuple(i for i in self.order if self.tree.bodies[i].masses)

    def is_point(self, i: int) -> bool:
        """Whether all of body i's mass is in its centre: it has no moment of inertia."""
        inertia = self.inertia(i)
        entries = (inertia,) if self.planar else (x for row in inertia for x in row)
        return all(isinstance(x, float) and x == 0.0 for x in entries)

    @property
    def weighs(self) -> bool:
        """Whether there is gravity."""
        return any(not (isinstance(x, float) and x == 0.0) for x in self.tree.gravity)

    # ------------------------------------------------------------ the tip
    @property
    def load_components(self) -> Vector:
        """The load on the tip as it is given, in the world's axes."""
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


def require_single_joints(symbols: Symbols, what: str) -> None:
    """Refuse what is not written out body by body: joints of several coordinates, and in closed
    chains joints that follow others."""
    model = symbols.model
    for body in model.bodies:
        follows = bool(model.loops) and body.joint.mimic is not None
        if body.kind.nv != 1 or follows:
            instead = (
                "fb.loop_equations gives those of its loops"
                if model.loops
                else "fb.equations gives the closed form"
            )
            raise FreebodyError(
                f"{what}: joint {body.joint.name!r} of {model.name!r} is {body.kind.name}"
                f"{' and follows another' if follows else ''}; derivations"
                f"{' of closed chains' if follows else ''} are written "
                f"for {'independent ' if follows else ''}joints of one coordinate: {instead}."
            )
