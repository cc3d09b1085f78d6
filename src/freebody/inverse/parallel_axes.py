"""Arms whose turning axes are all parallel: planar arms and SCARA robots.

In the plane across the axes a word of up to three joints is left; one slide along the axes, a lift,
stands by itself. The first two joints bring the last axis to its place (two circles, 2.14 and 2.15;
or a circle and a line), the last one turns what is left.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from freebody.algorithms.joint_lines import can_meet, parallel, perpendicular
from freebody.algorithms.screws import Screw, ScrewChain
from freebody.arrays import Array
from freebody.inverse import branch_names
from freebody.inverse import subproblems as sp
from freebody.inverse.closed_form import ClosedFormSolver, Displacement, Reached
from freebody.inverse.position import Candidates, meet


@dataclass(frozen=True, eq=False)
class ParallelAxesArm(ClosedFormSolver):
    """Up to three joints across `normal` at places `across` of the chain, and perhaps a lift at
    place `lift`."""

    normal: Array
    across: tuple[int, ...]
    lift: int | None
    words: tuple[str, str]
    """What the two elbows are called."""

    def name(self) -> str:
        word = "".join("R" if self.screws[i].turning else "P" for i in self.across)
        lifted = " and a lift" if self.lift is not None else ""
        source = " (2.14, 2.15)" if word.startswith("RR") else ""
        return f"closed form: {word} across parallel axes{lifted}{source}"

    def solve(self, X: Displacement, prefer: Array) -> Candidates:
        n = self.normal
        rise = (X.of(self.chain.p) - self.chain.p) @ n
        flat = X if self.lift is None else replace(X, p=X.p - rise[:, None] * n)
        found = self._across(flat, prefer[list(self.across)])
        x = np.zeros((*found.x.shape[:-1], len(self.screws)))
        free = np.zeros(x.shape, dtype=bool)
        x[..., list(self.across)], free[..., list(self.across)] = found.x, found.free
        if self.lift is not None:
            x[..., self.lift] = (rise * (n @ self.screws[self.lift].w))[:, None]
        return Candidates(x, free)

    def _across(self, X: Displacement, prefer: Array) -> Candidates:
        s = [self.screws[i] for i in self.across]
        if len(s) == 1:
            return _one(s[0], X, self.chain.p, prefer, self.scale)
        if len(s) == 2:
            return meet(s[0], s[1], self.chain.p, X.of(self.chain.p), prefer, self.scale)
        if s[2].turning:
            return _last_turns(s, X, prefer, self.scale)
        if s[0].turning:
            back = _last_turns(s[::-1], X.inverse(), -prefer[::-1], self.scale)
            return Candidates(-back.x[..., ::-1], back.free[..., ::-1])
        return _turn_between_slides(s, X)

    def label(self, x: Array) -> list[np.ndarray]:
        s = [self.screws[i] for i in self.across]
        y = x[..., list(self.across)]
        if len(s) == 3 and not s[2].turning and s[0].turning:
            s, y = s[::-1], -y[..., ::-1]
        if len(s) == 3 and not s[2].turning:
            return []
        c = s[2].p if len(s) == 3 else self.chain.p
        up = Screw(True, self.normal, s[0].p)
        if (
            len(s) > 1 and s[0].turning and s[1].turning
        ):  # names do not depend on the sense of the axes
            upper, fore = (replace(up, p=screw.p) for screw in s[:2])
            bent = y[..., :2] * [screw.w @ self.normal for screw in s[:2]]
            return [branch_names.elbow(upper, fore, c, bent, words=self.words)]
        return branch_names.pair(s[0], s[1], c, y[..., :2]) if len(s) > 1 else []

    def reached(self, X: Displacement) -> Reached | None:
        if len(self.across) < 3:
            return self.screws, self.chain.p, X.of(self.chain.p)
        first, last = self.screws[self.across[0]], self.screws[self.across[-1]]
        if last.turning:
            return tuple(s for s in self.screws if s is not last), last.p, X.of(last.p)
        if first.turning:
            rest = tuple(s for s in self.screws[::-1] if s is not first)
            return rest, first.p, X.inverse().of(first.p)
        return self.screws, self.chain.p, X.of(self.chain.p)


def _one(s: Screw, X: Displacement, c: Array, prefer: Array, scale: float) -> Candidates:
    x, free = sp.onto(s, np.broadcast_to(c, X.p.shape), X.of(c), prefer[0], scale)
    if s.turning:  # the frame may stand on the axis
        x, free = np.where(free, sp.turn_of(X.R, s.w), x), np.zeros_like(free)
    return Candidates(x[:, None, None], free[:, None, None])


def _last_turns(s: Sequence[Screw], X: Displacement, prefer: Array, scale: float) -> Candidates:
    """The first two joints bring a point of the third's axis home, the third turns the rest."""
    pair = meet(s[0], s[1], s[2].p, X.of(s[2].p), prefer[:2], scale)
    senses = np.array([(screw.w @ s[2].w) * screw.turning for screw in s[:2]])
    x3 = sp.turn_of(X.R, s[2].w)[..., None] - pair.x @ senses
    free = np.concatenate([pair.free, np.zeros_like(pair.free[..., :1])], axis=-1)
    return Candidates(np.concatenate([pair.x, x3[..., None]], axis=-1), free)


def _turn_between_slides(s: Sequence[Screw], X: Displacement) -> Candidates:
    """P R P: the turn is given; what the two slides must do is linear."""
    x2 = sp.turn_of(X.R, s[1].w)
    second = s[1].turned(x2, np.broadcast_to(s[2].w, X.p.shape))
    way = X.p - s[1].moved(x2, np.zeros_like(X.p))
    m = sp.cross(s[0].w, s[1].w)
    across = second @ m
    with np.errstate(divide="ignore", invalid="ignore"):
        x3 = np.where(np.abs(across) > 1e-9, (way @ m) / across, np.nan)
    x1 = (way - x3[:, None] * second) @ s[0].w
    x = np.stack([x1, x2, x3], axis=-1)[:, None]
    return Candidates(x, np.zeros(x.shape, dtype=bool))


def parallel_axes_arm(
    chain: ScrewChain, normal: Array | None, turned: bool, words: tuple[str, str]
) -> ClosedFormSolver | None:
    """The form for a chain across a normal (None: found), for the pose if `turned`, else for the
    position alone."""
    axes = [s.w for s in chain.screws if s.turning]
    n = normal if normal is not None else axes[0] if axes else None
    if n is None or not all(parallel(w, n) for w in axes):
        return None
    lifts = [i for i, s in enumerate(chain.screws) if not s.turning and parallel(s.w, n)]
    slides = [s for s in chain.screws if not s.turning]
    if len(lifts) > 1 or any(not parallel(s.w, n) and not perpendicular(s.w, n) for s in slides):
        return None
    across = tuple(i for i in range(len(chain.screws)) if i not in lifts)
    form = ParallelAxesArm(chain, n, across, lifts[0] if lifts else None, words)
    return form if _is_regular(form, turned) else None


def _is_regular(form: ParallelAxesArm, turned: bool) -> bool:
    """Whether the joints across are as many as they have to do, and do not repeat each other."""
    s = [form.screws[i] for i in form.across]
    if len(s) == 3 and turned and any(screw.turning for screw in s):
        if s[2].turning or s[0].turning:
            first, second = (s[0], s[1]) if s[2].turning else (s[2], s[1])
            return can_meet(first, second, form.scale)
        return s[1].turning
    return len(s) == 1 or (len(s) == 2 and can_meet(s[0], s[1], form.scale))
