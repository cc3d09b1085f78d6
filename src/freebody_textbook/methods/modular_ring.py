"""A spatial chain whose last body is connected to the ground by a loop, derived line by line: the
recursion, with the loop's force transformed from the ground's axes to those of that body."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator
from dataclasses import replace

from freebody.algorithms.kinematics import joint_poses
from freebody.algorithms.rnea import External, Recursion
from freebody.errors import listed
from freebody.expressions import expression as ex
from freebody.expressions.expression import Expression, Symbol, eq, nodes
from freebody.expressions.nodes import Words
from freebody.expressions.printed_names import sym, vec
from freebody.lazy import cached_property
from freebody.scalars.trig import Trig
from freebody.spatial import Vector, add, times, transposed
from freebody_textbook.derivation import Meaning, Step
from freebody_textbook.methods import recursive
from freebody_textbook.methods.cut_loops import Loops
from freebody_textbook.methods.glossary import MOMENT, NEWTON
from freebody_textbook.methods.loop_forces import LoopForces
from freebody_textbook.methods.modular import AXES, ModularSetting, generator
from freebody_textbook.methods.recursive import Inward, worked
from freebody_textbook.methods.setting import Setting

_OF_LOOP = ("loop.f", "loop.n")
"""Force and moment of the loop on the last body, as generators."""


def is_ring(s: Setting, forces: Iterable[Trig]) -> bool:
    """Whether a robot is a serial chain closed by a single loop from its last body to the ground,
    with equations too long to read."""
    if s.planar or s.load or len(s.tree.loops) != 1:
        return False
    ends = Loops(s).ends(s.tree.loops[0])
    serial = all(s.tree.bodies[i].parent == k for k, i in enumerate(range(len(s.order)), -1))
    return serial and ends == (-1, s.order[-1]) and not recursive.is_readable(s, forces)


class RingSetting(ModularSetting):
    """A derivation's setting for the serial chain; the loop acts on its last body."""

    @classmethod
    def more_names(cls, count: int) -> Iterator[str]:
        for quantity in _OF_LOOP:
            yield from (generator(quantity, n, x) for n in range(count + 1) for x in AXES)

    @cached_property
    def loops(self) -> Loops:
        """The loop, as the other methods describe loops."""
        return Loops(self)

    def vector(self, quantity: str, i: int) -> Symbol:
        """Symbol of the loop's force f_{0,n} or moment n_{0,n}; a body number above means that
        body's axes."""
        if quantity not in _OF_LOOP:
            return super().vector(quantity, i)
        (loop,), force = self.tree.loops, quantity == _OF_LOOP[0]
        name = self.loops.force_name(loop) if force else self.loops.moment_name(loop)
        assert isinstance(name, Symbol)
        n = self.numbers[i]
        return replace(name, name=name.name + f"_in{n}", high=str(n)) if n else name

    def vectors(self) -> Iterator[tuple[str, int]]:
        yield from super().vectors()
        yield from itertools.product(self.quantities, (-1, *self.order))

    @property
    def quantities(self) -> tuple[str, ...]:
        """Names of the force, and of the moment if the loop transmits one."""
        return _OF_LOOP if self.tree.loops[0].closure.turns else _OF_LOOP[:1]

    @cached_property
    def carried(self) -> dict[str, list[Vector]]:
        """The loop's force and moment in the axes of the ground and of each body, expressed in
        those in the preceding axes."""
        poses, found = joint_poses(self.tree, self.symbols.q), {}
        wrench = self.loops.wrench(self.tree.loops[0])
        for quantity, value in zip(self.quantities, wrench, strict=False):
            rows = [value]
            for i in self.order:
                before = self.named(quantity, self.tree.bodies[i].parent, rows[-1])
                rows.append(times(transposed(poses[i][0]), before))
            found[quantity] = rows
        return found

    def tip_load(self) -> tuple[External, ...]:
        """The loop's force and moment acting on the last body."""
        (loop,), last, space = self.tree.loops, self.order[-1], self.tree.space
        acting = [self.named(x, last, self.carried[x][-1]) for x in self.quantities]
        force, moment = (*acting, space.zero_angular)[:2]
        at = self.tree.frames[loop.frames[1]][2]
        return ((last, force, add(space.moment(at, force), moment)),)


class _RingInward(Inward):
    """The inward sweep of the recursion, with the loop acting on the last body."""

    s: RingSetting

    def _names(self, i: int) -> list[Symbol]:
        if i != self.s.order[-1]:
            return []
        return [self.s.vector(quantity, i) for quantity in self.s.quantities]

    def _force(self, i: int) -> Expression:
        return ex.add(super()._force(i), *(ex.neg(x) for x in self._names(i)[:1]))

    def _moment(self, i: int) -> Expression:
        names, frame = self._names(i), self.s.tree.loops[0].frames[1]
        arm = LoopForces(self.s, self.s.loops).arm(i, frame) if names else ex.ZERO
        parts = [ex.neg(x) for x in names[1:]] + [ex.neg(ex.cross(arm, x)) for x in names[:1]]
        return ex.add(super()._moment(i), *parts)

    def _reason(self, i: int) -> str:
        told = " What the loop exerts on the body is taken off." if self._names(i) else ""
        return f"{super()._reason(i)}{told}"


def steps(s: Setting) -> list[Step]:
    """All steps of a ring's derivation, from the general equations to the torques."""
    shown = RingSetting.of(s)
    record: Recursion = shown.recursion("base")
    outward = recursive.Outward(shown, record, True, False)
    inward = _RingInward(shown, record, True, False)
    return [
        _general(shown),
        LoopForces(shown, shown.loops).geometry(rotations=True),
        outward.start(),
        *map(outward.step, shown.order),
        shown.loops.wrenches(),
        _turned(shown),
        *map(inward.step, reversed(shown.order)),
    ]


def _general(s: RingSetting) -> Step:
    n = s.numbers[s.order[-1]]
    acting, verb = f"the force f_0,{n}", "is"
    if s.quantities[1:]:
        acting, verb = f"{acting} and the moment n_0,{n}", "are"
    reason = (
        "Along each coordinate act the joint's motor and the loop. Written out in the coordinates "
        "of all joints the derivatives of L are too long to read. The recursion of Newton and "
        "Euler gives the same torques exactly, each line by those before; what -Φ_qᵀ λ is to the "
        f"coordinates, {acting} of the loop on body {n} {verb} to the bodies. In Python the "
        "derivation holds the torques in the coordinates, as .tau, and M, Φ_q and c, as .system."
    )
    slope = ex.sub(ex.d_dt(ex.partial("L", vec("q_d"))), ex.partial("L", vec("q")))
    loop = ex.mul(ex.transposed(s.loops.phi_q), sym("lam"))
    line = eq(ex.add(slope, loop), sym("Q"))
    return Step("The equations, body by body", reason, (line,), ("5.23",))


def _turned(s: RingSetting) -> Step:
    """Step: quantities transformed from the ground's axes through all bodies to the last."""
    lines = []
    for quantity in s.quantities:
        for k, i in enumerate(s.order):
            parent = s.tree.bodies[i].parent
            rule = ex.mul(s.rotation_name(parent, i), s.vector(quantity, parent))
            value = s.column(s.carried[quantity][k + 1])
            lines.append(worked(s.vector(quantity, i), rule, value, False))
    n = s.numbers[s.order[-1]]
    reason = (
        "What the loop does is given by its components along the world's axes; as every vector, it "
        f"is turned from body to body. A number at the top tells the body whose axes these are: "
        f"those of body {n} are needed."
    )
    return Step("The loop's force in the axes of the bodies", reason, tuple(lines))


def symbols(s: Setting) -> Iterator[Meaning]:
    """Meanings of the symbols that the derivation of a ring introduces."""
    yield from recursive.symbols(s)
    n = str(s.numbers[s.order[-1]])
    for letter, what, unit in (("f", "force", NEWTON), ("n", "moment", MOMENT)):
        if letter == "f" or s.tree.loops[0].closure.turns:
            name = Symbol(f"{letter}_loop_i", letter, ("0", n), bold=True, high="i")
            yield Meaning((name,), f"{what} of the loop on body {n}, in axes of body i", unit)


def without_lengths(step: Step, what: str) -> Step:
    """A step without the lines that only state their length; what: phrase for what they would
    contain."""
    long = [x for x in step.equations if any(isinstance(node, Words) for node in nodes(x))]
    names = [f"{x.lhs.letter}_{x.lhs.low[0]}" for x in long if isinstance(x.lhs, Symbol)]
    if not names:
        return step
    are = "is" if len(names) == 1 else "are"
    reason = f"{step.reason} {listed(names)} {are} too long to print: {what}."
    kept = tuple(x for x in step.equations if x not in long)
    return replace(step, reason=reason, equations=kept)
