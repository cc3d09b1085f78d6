"""Forces of a closed chain's loops on its free bodies, determined from the joints without motor."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from freebody.algorithms import loop_constraints
from freebody.algorithms.kinematics import frame_pose
from freebody.expressions import expression as ex
from freebody.expressions.expression import Equation, Expression, Symbol, eq
from freebody.expressions.printed_names import entry, sym
from freebody.expressions.typesetting.literal import literal
from freebody.model.tree import TreeLoop
from freebody.spatial import Vector, sub
from freebody_textbook.closed_chains.statics import LoopStatics
from freebody_textbook.derivation import Step
from freebody_textbook.methods.body_by_body import SolvedReactions
from freebody_textbook.methods.cut_loops import Loops
from freebody_textbook.methods.setting import Setting
from freebody_textbook.methods.shared_steps import geometry

FEW = 4
"""Multipliers up to which the equations for them are solved in print."""


class LoopReactions(SolvedReactions):
    """Joint reactions of a closed chain, with the loops' wrenches acting on the bodies."""

    def __init__(self, setting: Setting, loops: Loops):
        self.loads = loop_constraints.loop_loads(
            loops.equations.tree, setting.symbols.q, tuple(loops.system.multipliers)
        )
        super().__init__(setting)

    def applied(self, i: int) -> Iterable[tuple[Vector, Vector]]:
        yield from super().applied(i)
        for body, force, moment in self.loads:
            if body == i:
                yield self.s.axes(i, force), moment


def needs_of(reactions: SolvedReactions, loops: Loops) -> LoopStatics:
    """Torques that the joints need, linear in the loops' forces, and the joints without motor."""
    s = reactions.s
    needed = {s.index(i): reactions.motor(i) for i in s.order}
    passive = tuple(s.index(i) for i in s.order if not s.driven(i))
    return LoopStatics(loops.equations, needed, passive)


class LoopForces:
    """The forces in the loops, their names, and their action on the bodies."""

    def __init__(self, setting: Setting, loops: Loops):
        self.s, self.loops = setting, loops

    @property
    def unknowns(self) -> list[Symbol]:
        """Symbols λ_k of the multipliers, one per loop equation."""
        return [entry("lam", k) for k in range(1, len(self.loops.equations.names) + 1)]

    def step(self, more: str = "") -> Step:
        """Step: forces that replace the cut loops."""
        lines = [line for loop in self.s.tree.loops for line in self.loops.force_lines(loop)]
        held = "; ".join(self.loops.holds(loop) for loop in self.s.tree.loops)
        rods = any(loop.closure.distance for loop in self.s.tree.loops)
        along = (
            " A massless rod transmits force only along its axis; λ is half its tension over its "
            "length."
            if rods
            else ""
        )
        one = len(self.s.tree.loops) == 1
        reason = (
            f"{'The loop is' if one else 'The loops are'} cut: {held}. "
            f"{'It' if one else 'Each'} is replaced by the force of one body on the other and its "
            f"opposite; its components are the unknowns.{along}{more}"
        )
        title = f"Cut {self.loops.named}: {'its force is' if one else 'their forces are'} unknown"
        return Step(title, reason, tuple(lines))

    def system(self, needs: LoopStatics) -> list[Equation]:
        """The equations A λ = k of the joints without motor."""
        lines = [eq(ex.mul("A", "lam"), "k"), *self.loops.matrix(sym("A"), needs.A)]
        return [*lines, *(eq(entry("k", j), self.s.show(x)) for j, x in enumerate(needs.right, 1))]

    # ------------------------------------------------------------ on one body
    def on(self, i: int) -> list[tuple[Expression, Expression]]:
        """The loops' forces on body i, each with the vector from its joint to the point of
        action."""
        return [
            (self._signed(self.loops.force_name(loop), loop, i), self.arm(i, frame))
            for loop, frame in self._ends(i)
        ]

    def moments_on(self, i: int) -> list[Expression]:
        """The moments of loops on body i, if they transmit any."""
        moments = [(self.loops.moment_name(loop), loop) for loop, _ in self._ends(i)]
        return [self._signed(name, loop, i) for name, loop in moments if name != ex.ZERO]

    def in_words(self, i: int) -> list[str]:
        """Phrases for the loops' forces on body i."""
        found = []
        for loop, frame in self._ends(i):
            acting = [self.loops.force_name(loop), self.loops.moment_name(loop)]
            names = " and ".join(
                _in_words(self._signed(x, loop, i)) for x in acting if x != ex.ZERO
            )
            found.append(f"{names} of {literal(loop.name)} at {literal(frame)}")
        return found

    def _signed(self, x: Expression, loop: TreeLoop, i: int) -> Expression:
        return x if self.loops.acts(loop, i) else ex.neg(x)

    def _ends(self, i: int) -> list[tuple[TreeLoop, str]]:
        """Loops that act on body i, each with the frame at which it acts: the body's own, for
        sliding loops that of the second body."""
        return [
            (loop, loop.frames[1] if loop.closure.slides else frame)
            for loop in self.s.tree.loops
            for frame, k in zip(loop.frames, self.loops.ends(loop), strict=True)
            if k == i
        ]

    # ------------------------------------------------------------ where they act
    def arm(self, i: int, frame: str) -> Expression:
        """The vector from joint i to a frame at which a loop acts; 0 if it is at the joint."""
        if all(self.s.symbols.element(x).is_zero for x in self._way(i, frame)):
            return ex.ZERO
        if self._is_only_end(i, frame):
            return self.s.name("s", i)
        return self.s.naming.to_point(self.s.numbers[i], frame)

    def _is_only_end(self, i: int, frame: str) -> bool:
        """Whether the loops and the load act on body i at a single point and it has no further
        joint, so that s_i leads to this point."""
        ends = [f for _, f in self._ends(i)]
        ends += [self.s.symbols.model.frame().name] if self.s.loaded(i) else []
        places = [tuple(map(self.s.symbols.element, self._way(i, f))) for f in ends]
        here = tuple(map(self.s.symbols.element, self._way(i, frame)))
        return not self.s.tree.children(i) and all(place == here for place in places)

    def _way(self, i: int, frame: str) -> Vector:
        k, _, at = self.s.tree.frames[frame]
        if k == i:
            return self.s.axes(i, at)
        _, place = frame_pose(self.s.tree, self.s.world, frame)
        return sub(place, self.s.world[i][1])

    def ways(self, i: int) -> list[tuple[Expression, Vector]]:
        """Vectors on body i from its joint to the points where loops act, with names."""
        ways = [(self.arm(i, frame), self._way(i, frame)) for _, frame in self._ends(i)]
        return [(arm, way) for arm, way in ways if arm != ex.ZERO]

    def geometry(self, rotations: bool = False) -> Step:
        """Step: the vectors along the bodies as in `geometry`, including those to the loops'
        frames."""
        step = geometry(self.s, rotations, inertias=not self.s.at_rest)
        lines: list[Equation] = list(step.equations)
        for i in self.s.order:
            lines += [eq(arm, self.s.column(way)) for arm, way in self.ways(i)]
        others = any(len(getattr(line.lhs, "low", ())) > 1 for line in lines)
        more = "s_i,P points from joint i to a point P where a loop acts; " if others else ""
        reason = more + step.reason.replace("(or the tip)", "(or the tip, or where a loop acts)")
        told = Step(step.operation, reason, tuple(dict.fromkeys(lines)), step.notes, step.figure)
        return without_links(self.s, told)


def without_links(s: Setting, step: Step) -> Step:
    """A step without the equations of massless connecting bodies."""
    skipped = set()
    for i in s.links:
        dotted = [(letter, dots) for letter in ("omega", "v") for dots in ("", "_d")]
        skipped |= {s.angular_name(letter, i, dots) for letter, dots in dotted}
        skipped |= {s.axis_name(i), *(s.reach_name(i, k) for k in s.tree.children(i))}
    return replace(step, equations=tuple(x for x in step.equations if x.lhs not in skipped))


def _in_words(x: Expression) -> str:
    """Text of a loop's force in sentences: f_3,2 or -f_3,2."""
    name = x.operand if isinstance(x, ex.Negative) else x
    assert isinstance(name, Symbol)
    return f"{'-' * (name is not x)}{name.letter}_{','.join(name.low)}{name.high}"
