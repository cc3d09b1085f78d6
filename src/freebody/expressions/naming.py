"""Names of the forces, moments, masses, vectors and lengths of a model, for all that prints or
draws them.

Bodies count from 1 in names, the ground is 0. f_{i,k} is the force of body i on body k and n_{i,k}
the moment, whether a joint or a loop transmits them: of a joint k is the child, of a loop the body
of its second frame, as in `joint_wrenches` and `reactions`, whose rows are the values of these
names. Where two of them join the same bodies, the loop's has a prime. A turn in the plane that
transmits nothing but its motor's torque has the moment τ_k, and none where there is no motor.
"""

from __future__ import annotations

from dataclasses import dataclass

from freebody.expressions import expression as ex
from freebody.expressions.expression import Expression, Symbol
from freebody.expressions.notations.lettering import PLAIN, Lettering
from freebody.expressions.polynomials.symbols import names_by_body
from freebody.expressions.printed_names import entry, sym, vec
from freebody.lazy import cached_property
from freebody.model.bodies import Body
from freebody.model.loop_kinds import LOOP_KINDS
from freebody.model.model import Model
from freebody.model.parameters import Parameter, Quantity
from freebody.model.placement import Placement, Shift
from freebody.spatial import of_dimension

TIP = "P"
"""The tip, in sentences, formulas and drawings."""


@dataclass(frozen=True)
class Naming:
    """Printed names of the quantities of one model; n, i, k are numbers of bodies. numbers: whether
    values stand in place of parameters."""

    model: Model
    numbers: bool = False
    letters: Lettering = PLAIN
    """The letters of a notation."""

    @property
    def planar(self) -> bool:
        """Whether the model is planar, so that moments and angular velocities are scalars."""
        return self.model.dim == 2

    def body(self, n: int) -> Body:
        """The body with number n, counted from 1."""
        return self.model.bodies[n - 1]

    def parent(self, n: int) -> int:
        """The number of the body that carries body n."""
        return self.body(n).parent + 1

    def children(self, n: int) -> tuple[int, ...]:
        """Numbers of the bodies that hang on body n."""
        return tuple(k for k, body in enumerate(self.model.bodies, 1) if body.parent == n - 1)

    def turns(self, n: int) -> bool:
        """Whether body n hangs on a revolute joint of its own."""
        return self.body(n).kind.turns and self.body(n).joint.mimic is None

    # ------------------------------------------------------------ joints
    def coordinate(self, n: int) -> str | None:
        """Name in code of joint n's coordinate; None of a joint that follows another or has
        several."""
        names = self._coordinates[n - 1]
        return names[0] if len(names) == 1 else None

    @cached_property
    def _coordinates(self) -> list[tuple[str, ...]]:
        return names_by_body(self.model)

    def follows(self, n: int) -> bool:
        """Whether joint n follows another."""
        return self.body(n).joint.mimic is not None

    def leader(self, n: int) -> int:
        """Number of the joint that joint n follows; n of one that follows none."""
        mimic = self.body(n).joint.mimic
        return n if mimic is None else self.model.joint_names.index(mimic.joint) + 1

    def together(self, n: int) -> tuple[int, ...]:
        """Numbers of the joints that the motor of joint n moves: n and those that follow it."""
        return tuple(k for k in range(1, len(self.model.bodies) + 1) if self.leader(k) == n)

    def place(self, n: int) -> int:
        """The rank of joint n's coordinate among all coordinates, from 1; joints that follow others
        have none."""
        return n - sum(map(self.follows, range(1, n)))

    def driven(self, n: int) -> bool:
        """Whether a motor acts on joint n, its own or that of the joint that it follows."""
        return not self.body(self.leader(n)).joint.passive

    def torque(self, n: int) -> Symbol:
        """The symbol τ of joint n's motor, with the rank of its coordinate."""
        return self.letters.symbol(sym_of(f"tau{self.place(n)}"))

    def motor(self, n: int) -> Expression:
        """τ_n, or 0 where joint n has no motor."""
        return self.torque(n) if self.driven(n) else ex.ZERO

    def joint_moment(self, n: int) -> Expression:
        """The moment of the carrying body on body n at joint n: the symbol n, or for a planar
        turning joint τ_n or 0, unless other joints follow it."""
        alone = len(self.together(n)) == 1  # others would take a part of the motor's torque
        if self.planar and self.turns(n) and alone and not self._drives(n):
            return self.motor(n)
        return self.moment(self.parent(n), n)

    def _drives(self, n: int) -> bool:
        """Whether friction, rotor or spring act along joint n besides the motor."""
        return not all(map(_is_zero, self.body(n).joint.drive.strengths))

    def axis(self, n: int) -> Symbol:
        """The symbol of joint n's axis: z_n where it turns, u_n where it slides."""
        return vec(f"{self.body(n).kind.axis_letter}{n}")

    # ------------------------------------------------------------ forces
    def force(self, i: int, k: int) -> Symbol:
        """The symbol f_{i,k} of the force by body i on body k."""
        return vec(f"f{i}{k}" if i < 10 and k < 10 else f"f{i}_{k}")

    def moment(self, i: int, k: int) -> Symbol:
        """The symbol n_{i,k} of the moment by body i on body k."""
        return self.angular(f"n{i}_{k}")

    def angular(self, name: str) -> Symbol:
        """The symbol of an angular vector: not bold in the plane, where it is a scalar."""
        return sym_of(name) if self.planar else vec(name)

    def loop_bodies(self, loop: int) -> tuple[int, int]:
        """(the body that exerts the shown wrench of a loop, the one that it acts on)."""
        first, second = (self.model.frame(name).body + 1 for name in self.model.loops[loop].frames)
        return first, second

    def loop_force(self, loop: int) -> Symbol:
        """The symbol of a loop's force, by the first frame's body on the second's."""
        return self._primed(loop, self.force(*self.loop_bodies(loop)))

    def loop_moment(self, loop: int) -> Expression:
        """The symbol of a loop's moment about the origin of its second frame, by the first frame's
        body on the second's; 0 where the loop transmits none."""
        own = self.model.loops[loop]
        if not LOOP_KINDS[own.kind].closure(of_dimension(self.model.dim), own.axis).turns:
            return ex.ZERO
        return self._primed(loop, self.moment(*self.loop_bodies(loop)))

    def _primed(self, loop: int, name: Symbol) -> Symbol:
        ends = set(self.loop_bodies(loop))
        joined = any({n, self.parent(n)} == ends for n in range(1, len(self.model.bodies) + 1))
        before = sum(set(self.loop_bodies(k)) == ends for k in range(loop))
        primes = joined + before
        if not primes:
            return name
        return Symbol(
            name.name + "_prime" * primes, name.letter, name.low, name.dots, name.bold, "′" * primes
        )

    # ------------------------------------------------------------ masses
    def mass(self, n: int) -> Symbol:
        """The model's name for the mass of body n, else m_n."""
        return self._parameter(n, "mass") or self.letters.symbol(sym_of(f"m{n}"))

    def inertia(self, n: int) -> Symbol:
        """The symbol of the inertia of body n: in the plane the model's name for it, or I_n; in
        space the matrix I_n."""
        return (self._parameter(n, "tensor") or sym_of(f"I{n}")) if self.planar else vec(f"I{n}")

    def _parameter(self, n: int, quantity: str) -> Symbol | None:
        parts = self.body(n).inertias
        values = [getattr(part.inertia, quantity) for part in parts]
        one = values[0] if len(values) == 1 else None
        return self._named(one[0] if isinstance(one, tuple) else one)

    def _named(self, quantity: Quantity | None) -> Symbol | None:
        if not isinstance(quantity, Parameter) or self.numbers:
            return None
        return self.letters.symbol(sym_of(quantity.name))

    # ------------------------------------------------------------ vectors and lengths
    def reach(self, i: int, k: int) -> Symbol:
        """s_i from joint i to that of its child k, or s_{i,k} where body i carries several."""
        return vec(f"s{i}" if len(self.children(i)) == 1 else f"s{i}_{k}")

    def to_tip(self, n: int) -> Symbol:
        """s_n from joint n to the tip on body n, or s_{n,P} where s_n leads to a joint."""
        return self.to_point(n, TIP) if self.children(n) else vec(f"s{n}")

    def to_point(self, n: int, name: str) -> Symbol:
        """s_{n,name}: from joint n to a point of that name."""
        return Symbol(f"s{n}_{name}", "s", (str(n), name), bold=True)

    def length(self, child: int | None, frame: str = "") -> Symbol | None:
        """The model's name for the way from a joint to that of the next body, or to a frame; None
        where it has none."""
        return self._one(
            self.model.frame(frame).placement if child is None else self.body(child).joint.placement
        )

    def centre_length(self, n: int) -> Symbol | None:
        """The model's name for the way from joint n to the centre of mass of body n."""
        parts = self.body(n).inertias
        if len(parts) != 1:
            return None
        placed = parts[0].placement
        return self._one(placed.then(Placement((Shift(parts[0].inertia.com),))))

    def rod(self, loop: int) -> Symbol | None:
        """The model's name for the length of the rod that closes a loop; None where it has none."""
        return self._named(self.model.loops[loop].distance)

    def _one(self, placement: Placement) -> Symbol | None:
        """The symbol of the only length in a placement; None where there are several or none."""
        shifts = [
            x
            for step in placement.steps
            if isinstance(step, Shift)
            for x in step.by
            if not _is_zero(x)
        ]
        return self._named(shifts[0]) if len(shifts) == 1 else None


def _is_zero(x: Quantity) -> bool:
    """Whether a number or parameter is 0."""
    return (x.value if isinstance(x, Parameter) else x) == 0.0


def motors(model: Model) -> tuple[Expression, ...]:
    """τ_i for each coordinate, 0 where nothing drives it: what stands on the left of the equations
    of motion."""
    driven = set(model.driven_names)
    return tuple(
        entry("tau", i) if name in driven else ex.ZERO
        for i, name in enumerate(model.velocity_names, 1)
    )


def sym_of(name: str) -> Symbol:
    """The symbol of a name that is not the sign of anything."""
    symbol = sym(name)
    assert isinstance(symbol, Symbol)
    return symbol
