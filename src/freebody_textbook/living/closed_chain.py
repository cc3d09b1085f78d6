"""Closed chains in interactive pages: the loops' forces on bodies from the multipliers, and the
equations for closing the loops."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from freebody.algorithms.kinematics import frame_pose
from freebody.arrays import Array
from freebody.expressions.expression import Expression
from freebody.expressions.polynomials.symbols import RATE, SECOND
from freebody.lazy import cached_property
from freebody.model.tree import TreeLoop
from freebody_textbook.closed_chains.multiplier_equations import multiplier_names
from freebody_textbook.living.body_quantities import vector
from freebody_textbook.living.page_program import PageProgram
from freebody_textbook.methods.loop_forces_on_bodies import LoopReactions
from freebody_textbook.methods.loops_and_multipliers import Loops
from freebody_textbook.methods.setting import Setting

_ASIDE, _STEPS, _CLOSED = 0.05, 20, 1e-10


def _rank(matrix: Array) -> int:
    """The rank of a matrix at a position known to about 1e-12."""
    return int(np.linalg.matrix_rank(matrix, rtol=1e-8))


@dataclass(frozen=True)
class LoopEnd:
    """The force and moment of a loop on a body, their point of action and names."""

    place: Any
    force: Any
    moment: Any
    """Moment that the loop transmits; None of a loop that transmits none."""
    sign: int
    names: tuple[Expression, Expression]
    """The names of the force and of the moment."""


class ClosedChain:
    """The closed chain of a derivation, over polynomials or over the scalars of a program."""

    key = "loop"
    why = "by the loops"

    def __init__(self, setting: Setting, kernel: PageProgram, start: Sequence[float]):
        """Prepare a closed chain for a page; start: coordinates with the loops closed."""
        self.s, self.at_rest = setting, setting.at_rest
        self._kernel, self._start = kernel, start
        self.loops = Loops(self.s)
        self.reactions = LoopReactions(self.s, self.loops)

    @property
    def passive(self) -> tuple[int, ...]:
        """Bodies whose joints have no motor, as many as loop equations, which determine their
        coordinates."""
        return tuple(i for i in self.s.order if not self.s.driven(i))

    @cached_property
    def dependent(self) -> tuple[int, ...]:
        """Bodies whose coordinates the page computes: those without motor; if every joint has one,
        the last ones that the loops determine."""
        if self.passive:
            return self.passive
        _, jacobian = self._at(np.array(self._start))
        chosen: list[int] = []
        for i in reversed(self.s.order):
            tried = [*chosen, i]
            if _rank(jacobian[:, [self.s.index(k) for k in tried]]) == len(tried):
                chosen = tried
        return tuple(chosen)

    @cached_property
    def is_served(self) -> bool:
        """Whether the page supports the chain: the loops determine all coordinates without drive,
        and no loop slides."""
        closures = [loop.closure for loop in self.s.tree.loops]
        if any(x.slides or (x.turns and not x.point) for x in closures):
            return False
        regular = len(self.dependent) == len(self.loops.equations.names)
        return regular or (not self.passive and self._is_redundant)

    @property
    def _is_redundant(self) -> bool:
        """Whether loop equations that are dependent at the start stay so in motion and thus
        satisfied."""
        solved = [self.s.index(i) for i in self.dependent]
        free = [k for k in range(len(self._start)) if k not in solved]
        q = np.array(self._start)
        q[free[:1]] += _ASIDE
        for _ in range(_STEPS if free else 0):
            phi, jacobian = self._at(q)
            q[solved] -= np.linalg.lstsq(jacobian[:, solved], phi, rcond=None)[0]
        phi, jacobian = self._at(q)
        return bool(free) and _rank(jacobian) == len(solved) and bool(np.abs(phi).max() < _CLOSED)

    def _at(self, q: Array) -> tuple[Array, Array]:
        """The values of Φ and Φ_q at coordinates q."""
        equations, model = self.loops.equations, self.s.symbols.model
        known = {name: x for name, x in model.parameters.items() if x is not None}
        state = {**known, **dict(zip(self.s.symbols.coordinates, q, strict=True))}
        entries = [*equations.Phi, *(x for row in equations.Phi_q for x in row)]
        values, m = self._kernel.at_random(entries, **state)[:, 0], len(equations.names)
        return values[:m], values[m:].reshape(m, -1)

    # ------------------------------------------------------------ what is drawn
    def ends(self, n: int) -> list[LoopEnd]:
        """The actions of the loops on body n."""
        i = self.s.order[n - 1]
        return [self._end(loop, frame, i) for loop, frame in self._acting(i)]

    def _end(self, loop: TreeLoop, frame: str, i: int) -> LoopEnd:
        force, moment = (vector(self.s, v) for v in self.loops.wrench(loop))
        names = self.loops.force_name(loop), self.loops.moment_name(loop)
        turning = None if not loop.closure.turns else moment[0] if self.s.planar else moment
        sign = 1 if self.loops.acts(loop, i) else -1
        return LoopEnd(self._place(frame), force, turning, sign, names)

    def _place(self, frame: str) -> tuple[Any, ...]:
        return vector(self.s, frame_pose(self.s.tree, self.s.world, frame)[1])

    def _acting(self, i: int) -> list[tuple[TreeLoop, str]]:
        return [
            (loop, frame)
            for loop in self.s.tree.loops
            for frame, k in zip(loop.frames, self.loops.ends(loop), strict=True)
            if k == i
        ]

    # ------------------------------------------------------------ what closes it
    @property
    def solved_names(self) -> tuple[str, ...]:
        """Names of the symbols that the page computes from others."""
        names = [self.s.coordinate(i) for i in self.dependent]
        dots = ("",) if self.at_rest else ("", RATE, SECOND)
        multipliers = multiplier_names(self.loops.equations) if self.passive else ()
        return (*(name + dot for dot in dots for name in names), *multipliers)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the symbols that the page needs for closing the loops."""
        dots = ("",) if self.at_rest else ("", RATE, SECOND)
        coordinates = [self.s.coordinate(i) for i in self.s.order]
        multipliers = multiplier_names(self.loops.equations)
        return (*(name + dot for dot in dots for name in coordinates), *multipliers)

    @property
    def units(self) -> dict[str, str]:
        """Units of the multipliers; a rod's equation is a squared distance."""
        names = multiplier_names(self.loops.equations)
        return {
            names[k]: "N/m" if loop.closure.distance else "N"
            for loop in self.s.tree.loops
            for k in self.loops.equations.rows(loop)
        }

    def _pressed(self, k: int) -> Any:
        """The generalized force of the loops, an entry of Φ_qᵀ λ, along a coordinate."""
        names = multiplier_names(self.loops.equations)
        parts = zip(self.loops.equations.Phi_q, names, strict=True)
        return sum((row[k] * self.s.symbols.ring[x] for row, x in parts), self.s.symbols.zero())

    def page(self, kernel: PageProgram, inputs: Mapping[str, int]) -> dict[str, Any]:
        """Data for closing loops in the script: places of Φ, Φ_q, c and of the torques of joints
        without motor in the output, and inputs to be solved for."""
        equations, s = self.loops.equations, self.s
        free = [self.reactions.motor(i) - self._pressed(s.index(i)) for i in self.passive]
        dots = {"q": ""} | ({} if self.at_rest else {"qd": RATE, "qdd": SECOND})
        return {
            "phi": [kernel.places(x)[0] for x in equations.Phi],
            "jacobian": [kernel.places(tuple(row)) for row in equations.Phi_q],
            "c": [] if self.at_rest else [kernel.places(x)[0] for x in equations.c],
            "need": [kernel.places(x)[0] for x in free],
            "solved": [s.index(i) for i in self.dependent],
            "multipliers": [inputs[name] for name in multiplier_names(equations)],
            **{key: [inputs[x + dot] for x in s.symbols.coordinates] for key, dot in dots.items()},
        }
