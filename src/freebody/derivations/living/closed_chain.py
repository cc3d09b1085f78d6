"""Closed chains in a page: what loops do to bodies, as the multipliers make it, and the equations
by which the page closes the loops."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from freebody.algorithms.kinematics import frame_pose
from freebody.derivations.closed_chains.first_kind import multiplier_names
from freebody.derivations.living.body_quantities import vector
from freebody.derivations.living.kernel import PageProgram
from freebody.derivations.methods.cut_loops import Loops
from freebody.derivations.methods.loop_forces import LoopReactions
from freebody.derivations.methods.setting import Setting
from freebody.derivations.polynomials.symbols import RATE, SECOND
from freebody.lazy import cached_property
from freebody.model.tree import TreeLoop


@dataclass(frozen=True)
class LoopEnd:
    """Where a loop acts on a body: the point, the force, and what it is called."""

    place: Any
    force: Any
    sign: int
    name: str


class ClosedChain:
    """The closed chain of a derivation, over polynomials or over the scalars of a program."""

    key = "loop"
    why = "by the loops"

    def __init__(self, setting: Setting, kernel: PageProgram, start: Sequence[float]):
        """start: coordinates at which the loops are closed."""
        self.s, self.at_rest = setting, setting.at_rest
        self._kernel, self._start = kernel, start
        self.loops = Loops(self.s)
        self.reactions = LoopReactions(self.s, self.loops)

    @property
    def passive(self) -> tuple[int, ...]:
        """Bodies whose joints have no motor: as many as loop equations, which determine their
        coordinates."""
        return tuple(i for i in self.s.order if not self.s.driven(i))

    @cached_property
    def dependent(self) -> tuple[int, ...]:
        """Bodies whose coordinates the page computes: those without motor; where every joint has
        one, the last that the loops determine."""
        if self.passive:
            return self.passive
        given = dict(zip(self.s.symbols.coordinates, self._start, strict=True))
        entries = [x for row in self.loops.equations.Phi_q for x in row]
        columns = self._kernel.at_random(entries, **given)[:, 0].reshape(-1, len(self._start)).T
        chosen: list[int] = []
        for i in reversed(self.s.order):
            tried = [*chosen, i]
            if np.linalg.matrix_rank(columns[[self.s.index(k) for k in tried]]) == len(tried):
                chosen = tried
        return tuple(chosen)

    @cached_property
    def is_served(self) -> bool:
        """Whether the loops determine as many coordinates as are not driven, and every loop
        transmits a force alone."""
        forces = all(
            not loop.closure.turns and not loop.closure.slides for loop in self.s.tree.loops
        )
        return forces and len(self.dependent) == len(self.loops.equations.names)

    # ------------------------------------------------------------ what is drawn
    def ends(self, n: int) -> list[LoopEnd]:
        """Where loops act on body n."""
        i = self.s.order[n - 1]
        return [
            LoopEnd(
                self._place(frame),
                vector(self.s, self.loops.wrench(loop)[0]),
                1 if self.loops.acts(loop, i) else -1,
                str(self.loops.force_name(loop)),
            )
            for loop, frame in self._acting(i)
        ]

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
        """Symbols that the page computes from the others."""
        names = [self.s.coordinate(i) for i in self.dependent]
        dots = ("",) if self.at_rest else ("", RATE, SECOND)
        multipliers = multiplier_names(self.loops.equations) if self.passive else ()
        return (*(name + dot for dot in dots for name in names), *multipliers)

    @property
    def names(self) -> tuple[str, ...]:
        """Symbols that the page needs for it."""
        dots = ("",) if self.at_rest else ("", RATE, SECOND)
        coordinates = [self.s.coordinate(i) for i in self.s.order]
        multipliers = multiplier_names(self.loops.equations)
        return (*(name + dot for dot in dots for name in coordinates), *multipliers)

    @property
    def units(self) -> dict[str, str]:
        """Of the multipliers: a rod's equation is that of a distance squared."""
        names = multiplier_names(self.loops.equations)
        return {
            names[k]: "N/m" if loop.closure.distance else "N"
            for loop in self.s.tree.loops
            for k in self.loops.equations.rows(loop)
        }

    def _pressed(self, k: int) -> Any:
        """What the loops press on a coordinate, of Φ_qᵀ λ."""
        names = multiplier_names(self.loops.equations)
        parts = zip(self.loops.equations.Phi_q, names, strict=True)
        return sum((row[k] * self.s.symbols.ring[x] for row, x in parts), self.s.symbols.zero())

    def page(self, kernel: PageProgram, inputs: Mapping[str, int]) -> dict[str, Any]:
        """Places of Φ, Φ_q, c and of what joints without motor would have to give without the
        loops; which inputs are found from these; and where massless rods reach from and to."""
        equations, s = self.loops.equations, self.s
        free = [self.reactions.motor(i) - self._pressed(s.index(i)) for i in self.passive]
        dots = {"q": ""} | ({} if self.at_rest else {"qd": RATE, "qdd": SECOND})
        return {
            "rods": [
                [kernel.places(self._place(frame)) for frame in loop.frames]
                for loop in s.tree.loops
                if loop.closure.distance
            ],
            "phi": [kernel.places(x)[0] for x in equations.Phi],
            "jacobian": [kernel.places(tuple(row)) for row in equations.Phi_q],
            "c": [] if self.at_rest else [kernel.places(x)[0] for x in equations.c],
            "need": [kernel.places(x)[0] for x in free],
            "solved": [s.index(i) for i in self.dependent],
            "multipliers": [inputs[name] for name in multiplier_names(equations)],
            **{key: [inputs[x + dot] for x in s.symbols.coordinates] for key, dot in dots.items()},
        }
