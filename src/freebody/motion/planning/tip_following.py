"""Joint positions along a path of the tip, on one branch of the inverse kinematics; or the reason
why there are none."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import NoReturn

import numpy as np

from freebody.arrays import Array
from freebody.errors import FreebodyError, LoopError
from freebody.inverse.kinematics import inverse_kinematics
from freebody.inverse.problem.numerical_solver import NumericalSolver
from freebody.inverse.problem.task import combined_rates
from freebody.lazy import cached_property
from freebody.motion.planning.tip_mobility import TipMobility, TipPosture, TipSteps
from freebody.motion.planning.tip_paths import TipPath
from freebody.outputs.display import counted

_HALVINGS = 12
_SINGULAR = 1e-5  # ratio of singular values (lengths over the arm's) at which no branch is left
_NEARLY = 1e-2
_LOOKED_AT = 25  # places behind one that is not reached
_OF_LOOPS = 3  # the same of a closed chain, whose search takes longer
_UNHEEDED = 5e-7
"""m, rad: what a path may ask that no joint can do; numbers of a target are rounded."""


@dataclass(frozen=True, eq=False)
class Missing:
    """The largest part of a path that the joints cannot follow: a shift (dim,) in m, or a rotation
    vector (3,), in the plane (1,), in rad, world axes."""

    turns: bool
    vector: Array
    way: float
    whole: bool
    """Whether the missing motion is known along the whole path."""

    @property
    def size(self) -> float:
        """Size of the missing motion, m or rad."""
        return float(np.linalg.norm(self.vector))

    def in_words(self, length: float, means: str) -> str:
        """The missing motion in words, on a path of a given length; means: words for the joints
        that cannot make it."""
        verb, size = ("move", f"{self.size:.3g} m")
        if self.turns:
            verb, size = "turn", f"{np.degrees(self.size):.3g} °"
        axis = ""
        if len(self.vector) > 1:
            unit = self.vector / self.size
            k = int(np.argmax(np.abs(unit)))
            of = ", ".join(f"{x + 0.0:.3g}" for x in np.sign(unit[k]) * unit.round(6))
            one = "xyz"[k] if abs(unit[k]) > 1.0 - 1e-9 else f"({of})"
            axis = f" {'about' if self.turns else 'along'} {one} (world axes)"
        most = "up to" if self.whole else "more than"
        return (
            f"{verb}{axis} as asked: {most} {size}, at s = {self.way / length:.3g}, are beyond "
            f"{means}"
        )


@dataclass(frozen=True, eq=False)
class TipFollower:
    """A follower of a frame's path from q0 (nq,); function: the caller, for messages. nearest:
    whether the orientation only comes as near as the joints allow; else the whole task is kept."""

    function: str
    solver: NumericalSolver
    path: TipPath
    q0: Array
    nearest: bool = False

    @cached_property
    def mobility(self) -> TipMobility:
        """The motions that the joints can give the tip on the branch of q0."""
        return TipMobility.of(self.solver, self.q0)

    def along(self, ways: Array) -> list[TipPosture]:
        """The postures at path lengths `ways` (N,), the first of which is 0.

        Raises FreebodyError where the path leaves what the branch of q0 reaches.
        """
        at = self.mobility.posture(self.q0)
        self._refuse_start(at)
        found = [at]
        for before, way in pairwise(ways.tolist()):
            at = self._followed(at, before, way)
            found.append(at)
        return found

    def between(self, found: Sequence[TipPosture], ways: Array, guesses: Array) -> list[TipPosture]:
        """The postures halfway between those at path lengths `ways` (N,), found from guesses (N -
        1, nq)."""
        postures = []
        for at, (before, after), guess in zip(
            found, pairwise(ways.tolist()), guesses, strict=False
        ):
            way = 0.5 * (before + after)
            near = self._reached(guess, way)
            if near is None or not self._on_branch(at, near):
                near = self._followed(at, before, way)
            self._refuse_beyond_limits(near.q, way)
            postures.append(near)
        return postures

    def notices(self, found: Sequence[TipPosture], ways: Array) -> tuple[str, ...]:
        """Sentences on the postures at path lengths `ways` (N,): near singular positions, and
        motions that are left out."""
        q = np.array([at.q for at in found])
        return *self._near_singular(found, ways), *self._left_out(q, ways)

    def _near_singular(self, found: Sequence[TipPosture], ways: Array) -> Iterator[str]:
        for sizes, text in (
            (
                [at.ratio for at in found],
                "the arm is nearly singular (ratio of singular values {:.2g}); the limits of its "
                "joints allow only a very low speed of the tip there.",
            ),
            (
                [at.hold for at in found],
                "the drives hardly hold the tip (a singular position of the second type is near: "
                "{:.2g}); forces in them are large there.",
            ),
        ):
            k = int(np.argmin(sizes))
            if sizes[k] <= _NEARLY:
                yield f"At s = {ways[k] / self.path.length:.3g} of the way {text.format(sizes[k])}"

    def _left_out(self, q: Array, ways: Array) -> Iterator[str]:
        missing = self._missing(q, ways)
        if missing.size > _UNHEEDED:
            yield f"The tip does not {self._in_words(missing)}."

    def _refuse_start(self, at: TipPosture) -> None:
        model, freedom = self.solver.model, self.mobility.freedom
        if model.loops and len(model.driven) != freedom:
            raise LoopError(
                f"{self.function}: {model.name!r} has {counted(freedom, 'degree')} of freedom and "
                f"{counted(len(model.driven), 'driven joint')}, {', '.join(model.driven_names)}; "
                f"its path is led by as many. Give samples to fb.Motion.of."
            )
        if at.ratio < _SINGULAR:
            names = self.solver.task.names
            lost = None if at.lost is None else combined_rates(at.lost, names)
            why = "" if lost is None else f": {lost} = 0, whatever its joints do"
            self._refuse(0.0, f"the arm is singular at the start{why}; begin elsewhere")
        if at.hold < _SINGULAR:
            self._refuse(
                0.0,
                "the drives do not hold the tip at the start (a singular position of the second "
                "type); begin elsewhere",
            )

    def _followed(self, at: TipPosture, before: float, way: float) -> TipPosture:
        """The posture at path length `way`, followed from the one at `before`, in smaller steps
        where necessary."""
        ahead, least = [way], (way - before) * 0.5**_HALVINGS
        while ahead:
            found = self._reached(at.q, ahead[-1])
            if found is not None and self._on_branch(at, found):
                at, before = found, ahead.pop()
                self._refuse_beyond_limits(at.q, before)
                continue
            if ahead[-1] - before <= least:
                self._explain(at, found, ahead[-1])
            ahead.append(0.5 * (before + ahead[-1]))
        return at

    def _reached(self, start: Array, way: float) -> TipPosture | None:
        """The posture near start (nq,) with the tip on the path; None where there is none."""
        q = TipSteps(self.mobility, self.nearest).reached(start, self._goal(way))
        if q is None or self._off(q, way) > _UNHEEDED:
            return None
        return self.mobility.posture(q)

    @staticmethod
    def _on_branch(at: TipPosture, found: TipPosture) -> bool:
        regular = found.ratio >= _SINGULAR and found.hold >= _SINGULAR
        return regular and found.moves_like(at) and found.holds_like(at)

    def _goal(self, way: float) -> Array:
        return self.path.at(np.array([way]))[0]

    def _off(self, q: Array, way: float) -> float:
        """The error (m, rad) of the pose at q, in the part of the task that has to be kept."""
        T, _ = self.solver.pose_and_jacobian(q)
        error, k = self.solver.task.error(T, self._goal(way)), len(self.solver.task.linear)
        parts = [error[:k]] if self.nearest else [error[:k], error[k:]]
        return max(float(np.linalg.norm(part)) for part in parts)

    def _missing(self, q: Array, ways: Array) -> Missing:
        """The largest missing motion at positions q (N, nq): of the position, else of the
        orientation."""
        task = self.solver.task
        T, _ = self.solver.pose_and_jacobian(q)
        error, k = task.error(T, self.path.at(ways)), len(task.linear)
        for turns, rows in ((False, slice(0, k)), (True, slice(k, None))):
            sizes = np.linalg.norm(error[:, rows], axis=1)
            n = int(np.argmax(sizes))
            if sizes[n] > _UNHEEDED or turns:
                break
        dim = task.dim
        every = np.zeros(6 if dim == 3 else 3)
        every[list(task.rows)] = error[n]
        whole = bool(ways[-1] == self.path.length)
        return Missing(turns, every[dim:] if turns else every[:dim], float(ways[n]), whole)

    def _in_words(self, missing: Missing) -> str:
        count = self.mobility.freedom
        means = f"the {counted(count, 'drive' if self.solver.model.loops else 'joint')}"
        return missing.in_words(self.path.length, means)

    def _refuse_beyond_limits(self, q: Array, way: float) -> None:
        low, high = self.solver.bounds
        beyond = np.maximum(low - q, q - high)
        k = int(np.argmax(beyond))
        if beyond[k] > 1e-9 * max(1.0, abs(q[k])):
            end, limit = ("lower", low[k]) if q[k] < low[k] else ("upper", high[k])
            name = self.solver.model.position_names[k]
            self._refuse(
                way,
                f"{name} reaches its {end} limit {limit:.5g}; begin on another branch "
                f"(fb.inverse_kinematics gives them), or farther from the limit",
            )

    def _explain(self, at: TipPosture, found: TipPosture | None, way: float) -> NoReturn:
        """Raise the error that says why the path cannot be followed from a posture just before to
        `way`; found: the posture there, if any."""
        if found is not None and not (found.hold >= _SINGULAR and found.holds_like(at)):
            self._refuse(
                way,
                "the drives no longer hold the tip (a singular position of the second type); lead "
                "the path around",
            )
        self._refuse_missing(at.q, way)
        self._refuse_out_of_reach(at.q, way)
        self._refuse(
            way,
            "the arm becomes singular, and its branch ends; begin on another branch "
            "(fb.inverse_kinematics gives them), or lead the path around",
        )

    def _refuse_missing(self, q: Array, way: float) -> None:
        """Raise an error where the motion missing at path length `way`, just after q, is one that
        no joint can make."""
        steps, found = TipSteps(self.mobility, nearest=True), []
        ways = np.linspace(way, self.path.length, _LOOKED_AT)
        for there in ways.tolist():
            nearest = steps.reached(q, self._goal(there))
            if nearest is None or self.mobility.posture(nearest).ratio < _SINGULAR:
                break
            q = nearest
            found.append(q)
        if not found or self._off(found[0], way) <= _UNHEEDED:
            return
        missing = self._missing(np.array(found), ways[: len(found)])
        instead = (
            'leave that out of the target, or the task "reachable" follows it as far as they can'
            if missing.turns
            else "lead the path where they can bring it"
        )
        self._refuse(way, f"the tip cannot {self._in_words(missing)}; {instead}")

    def _refuse_out_of_reach(self, q: Array, way: float) -> None:
        solver, task = self.solver, self.solver.task
        count = _OF_LOOPS if solver.model.loops else _LOOKED_AT
        later = np.linspace(way, self.path.length, count)
        rows = task.names[: len(task.linear)] if self.nearest else task.names
        found = inverse_kinematics(
            solver.model, self.path.at(later), solver.frame, list(rows), q0=q, limits="ignore"
        )
        if found.count[:2].all():
            return
        k = int(np.argmax(found.distance))
        far = float(found.distance[k])
        by = (
            f"by up to {far:.3g} m, at s = {later[k] / self.path.length:.3g}"
            if far > 0.0
            else "with this orientation"
        )
        self._refuse(way, f"the path leaves the workspace, {by}; lead it nearer")

    def _refuse(self, way: float, why: str) -> NoReturn:
        d = self.solver.model.dim
        at = ", ".join(f"{x:.4g}" for x in self._goal(way)[:d, d])
        raise FreebodyError(
            f"{self.function}: at s = {way / self.path.length:.3g} of the way, the tip at ({at}) "
            f"m: {why}."
        )
