"""Joint positions along a path of the tip, on one branch of the inverse kinematics; or why not."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import NoReturn

import numpy as np

from freebody.arrays import Array
from freebody.errors import FreebodyError
from freebody.inverse.kinematics import inverse_kinematics
from freebody.inverse.numerical_solver import EXACT, NumericalSolver
from freebody.motion.planning.tip_paths import TipPath

_JUMP = 0.3  # rad, or of the arm's length: a step of the joints that is cut in half
_HALVINGS = 12
_SINGULAR = 1e-5  # ratio of singular values (lengths over the arm's) at which no branch is left
_NEARLY = 1e-2
_NEWTON = 12  # steps
_LOOKED_AT = 25  # places behind one that is not reached


@dataclass(frozen=True, eq=False)
class TipFollower:
    """Follows a path of a frame; `function` is who asks, for messages."""

    function: str
    solver: NumericalSolver
    path: TipPath

    def joints(self, q0: Array, ways: Array) -> tuple[Array, tuple[str, ...]]:
        """q (N, nq) at the ways (N,), the first being 0, where q0 (nq,) is; and what is worth a
        word.

        Raises FreebodyError where the path leaves what the branch of q0 reaches.
        """
        q, sign = q0, self._sign(q0)
        found = [q]
        for before, way in pairwise(ways.tolist()):
            q = self._followed(q, sign, before, way)
            found.append(q)
        ratios = [self._jacobian(q)[1] for q in found]
        k = int(np.argmin(ratios))
        if ratios[k] > _NEARLY:
            return np.array(found), ()
        return np.array(found), (
            f"At s = {ways[k] / self.path.length:.3g} of the way the arm is nearly singular (ratio "
            f"of singular values {ratios[k]:.2g}); the limits of its joints allow only a very low "
            f"speed of the tip there.",
        )

    def _sign(self, q0: Array) -> float:
        """Of the determinant at the start, which must be regular."""
        _, ratio, sign = self._jacobian(q0)
        if ratio < _SINGULAR:
            self._refuse(0.0, "the arm is singular at the start; begin elsewhere")
        return sign

    def _followed(self, q: Array, sign: float, before: float, way: float) -> Array:
        """The position at `way`, from that at `before`; in smaller steps where need be. sign: of
        the determinant of the branch."""
        ahead, least = [way], (way - before) * 0.5**_HALVINGS
        while ahead:
            reached = self._reached(q, ahead[-1])
            if reached is not None:
                _, ratio, turned = self._jacobian(reached)
                if turned == sign and ratio >= _SINGULAR:
                    q, before = reached, ahead.pop()
                    self._refuse_beyond_limits(q, before)
                    continue
            if ahead[-1] - before <= least:
                self._explain(q, ahead[-1])
            ahead.append(0.5 * (before + ahead[-1]))
        return q

    def _reached(self, q: Array, way: float) -> Array | None:
        """The position at `way` near q by Newton's method; None where that leads away, or
        nowhere."""
        solver, start = self.solver, q
        goal = self.path.at(np.array([way]))
        best, miss = None, np.inf
        for _ in range(_NEWTON):
            T, J = solver.pose_and_jacobian(q[None])
            now = float(solver.task.miss(T, goal)[0])
            if now <= EXACT and now >= 0.5 * miss:
                return best if miss < now else q
            if now <= EXACT:
                best, miss = q, now
            scale = self._scale(len(J[0]))
            step = np.linalg.pinv(scale[:, None] * J[0], rcond=1e-12) @ (
                scale * solver.task.error(T, goal)[0]
            )
            q = q + step
            if not np.abs((q - start) / self._worth).max() <= _JUMP:
                return None
        return best

    @property
    def _worth(self) -> Array:
        """What counts as 1 in each joint: rad, or the arm's length."""
        turns = np.array(
            [x for body in self.solver.model.bodies if body.joint.mimic is None
             for x in body.kind.angular]
        )  # fmt: skip
        return np.where(turns, 1.0, self.solver.length)

    def _scale(self, rows: int) -> Array:
        k = len(self.solver.task.linear)
        return np.array([1.0 / self.solver.length] * k + [1.0] * (rows - k))

    def _jacobian(self, q: Array) -> tuple[Array, float, float]:
        """(J, ratio of its singular values, sign of its determinant, 1 where it is not square)."""
        J = self.solver.pose_and_jacobian(q[None])[1][0]
        J = self._scale(len(J))[:, None] * J * self._worth
        values = np.linalg.svd(J, compute_uv=False)
        ratio = float(values[-1] / values[0]) if len(J) <= J.shape[1] and values[0] else 0.0
        sign = float(np.sign(np.linalg.det(J))) if J.shape[0] == J.shape[1] else 1.0
        return J, ratio, sign

    def _refuse_beyond_limits(self, q: Array, way: float) -> None:
        low, high = self.solver.bounds
        beyond = np.maximum(low - q, q - high)
        k = int(np.argmax(beyond))
        if beyond[k] > 1e-9 * max(1.0, abs(q[k])):
            limit = low[k] if q[k] < low[k] else high[k]
            name = self.solver.model.position_names[k]
            self._refuse(
                way,
                f"{name} reaches its limit {limit:.5g}; begin on another branch "
                f"(fb.inverse_kinematics gives them), or farther from the limit",
            )

    def _explain(self, q: Array, way: float) -> NoReturn:
        """Say why the path cannot be followed to `way` from q, which is just before."""
        solver = self.solver
        later = np.linspace(way, self.path.length, _LOOKED_AT)
        found = inverse_kinematics(
            solver.model,
            self.path.at(later),
            solver.frame,
            list(solver.task.names),
            q0=q,
            limits="ignore",
        )
        if not found.count[:2].all():
            k = int(np.argmax(found.distance))
            far = float(found.distance[k])
            by = (
                f"by up to {far:.3g} m, at s = {later[k] / self.path.length:.3g}"
                if far > 0.0
                else "with this orientation"
            )
            self._refuse(way, f"the path leaves the workspace, {by}; lead it nearer")
        self._refuse(
            way,
            "the arm becomes singular, and its branch ends; begin on another branch "
            "(fb.inverse_kinematics gives them), or lead the path around",
        )

    def _refuse(self, way: float, why: str) -> NoReturn:
        d = self.solver.model.dim
        place = self.path.at(np.array([way]))[0][:d, d]
        at = ", ".join(f"{x:.4g}" for x in place)
        raise FreebodyError(
            f"{self.function}: at s = {way / self.path.length:.3g} of the way, the tip at ({at}) "
            f"m: {why}."
        )
