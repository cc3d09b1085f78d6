"""The closed form for a frame and a task, if the chain of joints has one, decided by how the axes
lie and never by a robot's name; and the names of its branches.

Shoulder right, left: a positive turn of joint 2 lifts, lowers what it carries along joint 1's axis
(Lee and Ziegler 1984). Elbow up, down (left, right for arms that move level): on which side of the
line from shoulder to wrist it lies, seen with the wrist to the right. Wrist flipped: the other of
two ways to point the last axis.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import singledispatch
from typing import Any

import numpy as np

from freebody.algorithms.closed_form_inverse.across import Across
from freebody.algorithms.closed_form_inverse.choose_recipe import recipe_for, without_idle
from freebody.algorithms.closed_form_inverse.joint_places import PlacedBranch
from freebody.algorithms.closed_form_inverse.recipe import Recipe
from freebody.algorithms.closed_form_inverse.recipes import (
    OneJointHeld,
    OrientationByThree,
    PositionByThree,
    SeenFromTip,
    SphericalWrist,
    ThreeParallel,
)
from freebody.algorithms.closed_form_inverse.solve import Branches, branches
from freebody.algorithms.joint_lines import parallel, perpendicular
from freebody.algorithms.screws import Screw, ScrewChain, chain_to
from freebody.arrays import Array
from freebody.elementary import Scalar
from freebody.inverse.problem.task import Task
from freebody.lazy import cached_property
from freebody.loops.dyads.plane_vectors import side_of
from freebody.model.model import Model
from freebody.program import Argument, trace
from freebody.spatial import Matrix, Vector, identity
from freebody.targets import Kernel, compile_program

_ElbowWords = tuple[str, str]
"""Words for the two elbows of an arm."""


@dataclass(frozen=True, eq=False)
class ClosedFormArm:
    """An arm whose inverse kinematics has a closed form: its branches, task and words."""

    branches: Branches
    task: Task
    words: tuple[str, str]
    """Words for the two elbows of an arm with parallel axes."""

    @property
    def chain(self) -> ScrewChain:
        """The arm's joints as screws."""
        return self.branches.chain

    @property
    def held(self) -> int | None:
        """The index in q of the joint whose position has to be given, of an arm with one joint more
        than the task needs; None of others."""
        return self.branches.held

    @property
    def decides(self) -> bool:
        """Whether every branch fulfils the task, rather than being a candidate that still has to be
        checked."""
        return self.branches.kind != "position" or not self.task.angular

    @property
    def method(self) -> str:
        """Name of the method, with its source."""
        return f"closed form: {self.branches.recipe.title}"

    def names(self, q: Array) -> np.ndarray:
        """Names (...) of the branches of solutions q (..., nq)."""
        parts = _of_recipe(self.branches.recipe, self.chain.positions(q), self.words)
        return _joined(parts, q.shape[:-1])

    def counted(self, target: Array) -> Array:
        """The counted part of targets (…, dim + 1, dim + 1): the whole pose, the point (…, dim) or
        the rotation."""
        arm = self.branches
        if arm.kind == "pose":
            return target
        d = arm.dim
        return target[..., :d, d] if arm.kind == "position" else target[..., :d, :d]

    def of_counted(self, target: Any) -> tuple[Matrix, Vector]:
        """Rotation and position in space, over scalars, from the counted part of a target."""
        arm = self.branches
        if arm.kind == "pose":
            return arm.in_space(target)
        if arm.kind == "position":
            return identity(3), (*target, 0.0)[:3]
        return target, (0.0, 0.0, 0.0)

    def resting(
        self, at_rest: Sequence[Scalar], R: Matrix, p: Vector, held: Scalar | None = None
    ) -> list[PlacedBranch]:
        """The unverified branches for a pose in space; joints that could stand anywhere stand at
        `at_rest` (n,)."""
        arm = self.branches
        chain = arm.chain.resting(at_rest)
        recipe = recipe_for(chain, arm.kind, arm.dim == 2)
        assert recipe is not None  # there is one for the same chain
        return Branches(chain, arm.kind, recipe, arm.dim).ways(R, p, held)

    @cached_property
    def candidates(self) -> Kernel:
        """The kernel (counted part of a target, at rest (n,), held?) -> (x (branches, n), 1 where a
        joint could stand anywhere (branches, n), margin of existence (branches,)) of unverified
        branches, NaN where one does not exist."""
        arm, n = self.branches, len(self.chain.screws)

        def evaluate(target: Any, at_rest: Any, *held: Any) -> tuple[Any, ...]:
            ways = self.resting(at_rest, *self.of_counted(target), *held)
            x = [[place.value() for place in places] for places, _ in ways]
            free = [[place.free for place in places] for places, _ in ways]
            return x, free, [clear for _, clear in ways]

        target = self.counted(np.eye(arm.dim + 1))
        inputs = [Argument("target", target.shape), Argument("at_rest", (n,))]
        if self.held is not None:
            inputs.append(Argument("held", ()))
        each = (arm.count, n)
        outputs = [Argument("x", each), Argument("free", each), Argument("clear", each[:1])]
        return compile_program(trace("candidates", evaluate, inputs, outputs))

    def complete(self, target: Array) -> Array:
        """Targets (N, …) with the coordinates that the task leaves open set to those of the arm's
        zero position."""
        free = [k for k in range(self.task.dim) if k not in self.task.linear]
        if not free:
            return target
        target = target.copy()
        target[:, free, -1] = self.chain.p[free]
        return target

    def serves(self, target: Array) -> bool:
        """Whether the closed form fits given targets too: a partial orientation must be a turn
        about the arm's own axis."""
        recipe = self.branches.recipe
        if not isinstance(recipe, Across) or self.task.turns or not self.task.angular:
            return True
        turned = target[:, :3, :3] @ (self.chain.R.T @ recipe.normal)
        return bool(np.abs(turned - recipe.normal).max(initial=0.0) < 1e-9)

    def reached(
        self, target: Array, held: Array | None
    ) -> tuple[tuple[Screw, ...], Array, Array] | None:
        """(screws, c, points): targets (N, …) are within reach where the screws bring the point c
        (3,) to points (N, 3); None where reach depends on something else. held: positions (N,) of
        the held joint."""
        found = self.branches.reached(*self.branches.in_space(over_arrays(target)), held)
        if found is None:
            return None
        screws, c, point = found
        return tuple(screws), c, np.stack(np.broadcast_arrays(*point), axis=-1)


def over_arrays(target: Array) -> tuple[tuple[Array, ...], ...]:
    """Targets (N, …) as a matrix whose entries are arrays (N,)."""
    return tuple(tuple(row) for row in np.moveaxis(target, 0, -1))


def closed_form_for(model: Model, frame: str, task: Task) -> ClosedFormArm | None:
    """The closed form that gives all solutions of a task; None where there is none."""
    found = (
        branches(model.tree, frame, task.rows)
        or _level(model, frame, task)
        or _placed(model, frame, task)
    )
    if found is None:
        return None
    words = ("up", "down") if model.dim == 2 else _elbows(model, found.chain)
    return ClosedFormArm(found, task, words)


def _level(model: Model, frame: str, task: Task) -> Branches | None:
    """Branches of an arm in space with parallel axes, for tasks that count its position across the
    axes and along them; None for others."""
    chain = chain_to(model.tree, frame)
    if chain is None or model.dim == 2:
        return None
    kind = "pose" if task.angular else "position"
    if kind == "position":
        chain = without_idle(chain)
    recipe = recipe_for(chain, kind, False)
    if not isinstance(recipe, Across):
        return None
    along = [k for k in range(3) if parallel(np.eye(3)[k], recipe.normal)]
    needed = {k for k in range(3) if k not in along or recipe.lift is not None}
    turned = not task.angular or task.turns or bool(along and along[0] in task.angular)
    return Branches(chain, kind, recipe, 3) if needed <= set(task.linear) and turned else None


def _placed(model: Model, frame: str, task: Task) -> Branches | None:
    """Branches of an arm of three joints in space, whose position determines its orientation; None
    for others."""
    chain = chain_to(model.tree, frame)
    if chain is None or model.dim == 2 or not task.places or len(chain.screws) != 3:
        return None
    recipe = recipe_for(chain, "position", False)
    return None if recipe is None else Branches(chain, "position", recipe, 3)


def _elbows(model: Model, chain: ScrewChain) -> tuple[str, str]:
    """The two words for an elbow's sides: up and down for an arm that moves in an upright plane,
    left and right (from above) for one that moves level."""
    axis = next((s.w for s in chain.screws if s.turning), None)
    if axis is None:
        return ("up", "down")
    lean = float(np.array(model.gravity_direction) @ axis)
    return (
        ("up", "down") if abs(lean) < 0.5 else ("left", "right") if lean < 0 else ("right", "left")
    )


@singledispatch
def _of_recipe(recipe: Recipe, x: Array, words: _ElbowWords) -> list[np.ndarray]:
    """Parts of the names (...) of the branches of solutions x (..., n), by the recipe's joints;
    words: those for elbows of planar arms."""
    raise TypeError(f"no names of branches of a {type(recipe).__name__}")


@_of_recipe.register
def _(recipe: PositionByThree, x: Array, words: _ElbowWords) -> list[np.ndarray]:
    return _arm(recipe.screws, recipe.c, x)


@_of_recipe.register
def _(recipe: OrientationByThree, x: Array, words: _ElbowWords) -> list[np.ndarray]:
    return _wrist(recipe.wrist.screws, x)


@_of_recipe.register
def _(recipe: SphericalWrist, x: Array, words: _ElbowWords) -> list[np.ndarray]:
    return _arm(recipe.screws[:3], recipe.c, x[..., :3]) + _wrist(recipe.screws[3:], x[..., 3:])


@_of_recipe.register
def _(recipe: ThreeParallel, x: Array, words: _ElbowWords) -> list[np.ndarray]:
    s1, s2, s3, s4, s5, s6 = recipe.screws
    carried = s3.moved(x[..., 2], s4.moved(x[..., 3], recipe.c))
    side = _shoulder(s1, s2, s2.moved(x[..., 1], carried))
    return [side, _elbow(s2, s3, s4.p, x[..., 1:3], side), _flip(s2.w, s5, s6.w, x[..., 4])]


@_of_recipe.register
def _(recipe: SeenFromTip, x: Array, words: _ElbowWords) -> list[np.ndarray]:
    return _of_recipe(recipe.forward, -x[..., ::-1], words)


@_of_recipe.register
def _(recipe: OneJointHeld, x: Array, words: _ElbowWords) -> list[np.ndarray]:
    return _of_recipe(recipe.rest, x[..., 1:] if recipe.first else x[..., :-1], words)


@_of_recipe.register
def _(recipe: Across, x: Array, words: _ElbowWords) -> list[np.ndarray]:
    s, y = [recipe.screws[i] for i in recipe.across], x[..., list(recipe.across)]
    if len(s) == 3 and not s[2].turning and s[0].turning:
        s, y = s[::-1], -y[..., ::-1]
    if len(s) < 2 or (len(s) == 3 and not s[2].turning):
        return []
    c = s[2].p if len(s) == 3 else recipe.c
    if not (s[0].turning and s[1].turning):
        return _pair(s[0], s[1], c, y[..., :2])
    # names do not depend on the sense of the axes
    upper, fore = (replace(screw, w=recipe.normal) for screw in s[:2])
    bent = y[..., :2] * [screw.w @ recipe.normal for screw in s[:2]]
    return [_elbow(upper, fore, c, bent, words=words)]


def _shoulder(s1: Screw, s2: Screw, wrist: Array) -> np.ndarray:
    """Branch names of two turning joints that are not parallel; wrist: the carried point (..., 3)
    before joint 1 turns."""
    value = (wrist - s2.p) @ np.cross(s1.w, s2.w)
    size = _size(wrist - s1.p)
    return side_of(value, size, "shoulder right", "shoulder left", "shoulder overhead")


def _elbow(
    s2: Screw,
    s3: Screw,
    c: Array,
    x: Array,
    side: str | np.ndarray = "",
    words: tuple[str, str] = ("up", "down"),
) -> np.ndarray:
    """Branch names of two parallel turning joints at x (..., 2) that carry the point c; on the left
    side they are seen from the back."""
    upper = _across(s2.w, s3.p - s2.p)
    fore = _across(s2.w, s3.moved(x[..., 1], c) - s3.p)
    bend = _cross(upper, fore) @ s2.w
    up, down = (f"elbow {word}" for word in words)
    between = np.where(fore @ upper > 0, "elbow straight", "elbow folded")
    facing = np.where(np.asarray(side) == "shoulder left", 1.0, -1.0)
    return side_of(facing * bend, _size(upper) * _size(fore), up, down, between)


def _flip(u: Array, s5: Screw, v: Array, x5: Array) -> np.ndarray:
    """Branch names of a joint at x5 (...) between two directions u and v, by the way it bends
    them."""
    value = _cross(u, s5.turned(x5, v)) @ s5.w
    return side_of(value, 1.0, "wrist not flipped", "wrist flipped", "wrist straight")


def _wrist(screws: Sequence[Screw], x: Array) -> list[np.ndarray]:
    """Branch names of a wrist of three turning joints at x (..., 3)."""
    s4, s5, s6 = screws
    return [_flip(s4.w, s5, s6.w, x[..., 1])]


def _pair(s1: Screw, s2: Screw, c: Array, x: Array) -> list[np.ndarray]:
    """Branch names of two joints at x (..., 2) that bring the point c to another one."""
    if s1.turning and s2.turning:
        if parallel(s1.w, s2.w):
            return [_elbow(s1, s2, c, x)]
        return [_shoulder(s1, s2, s2.moved(x[..., 1], c))]
    if s1.turning != s2.turning and perpendicular(s1.w, s2.w):
        return [_forward(s1, s2, c, x)]
    return []


def _forward(s1: Screw, s2: Screw, c: Array, x: Array) -> np.ndarray:
    """Branch names of a turning and a sliding joint: whether the arm reaches out along the slide or
    against it."""
    turning, sliding = (s1, s2) if s1.turning else (s2, s1)
    way = s2.moved(x[..., 1], c) - turning.p
    return side_of(
        way @ sliding.w, _size(way), "reaching forward", "reaching backward", "reaching across"
    )


def _arm(screws: Sequence[Screw], c: Array, x: Array) -> list[np.ndarray]:
    """Branch names of three joints at x (..., 3) that bring the point c to another one."""
    s1, s2, s3 = screws
    carried = s3.moved(x[..., 2], c)
    names = _pair(s1, s2, carried, x[..., :2])
    if (
        s2.turning
        and s3.turning
        and parallel(s2.w, s3.w)
        and _size(_across(s2.w, s3.p - s2.p)) > 1e-9
    ):
        if s1.turning and parallel(s1.w, s2.w):  # the elbow has its name
            return names
        return [*names, _elbow(s2, s3, c, x[..., 1:], names[0] if names else "")]
    if s2.turning != s3.turning and perpendicular(s2.w, s3.w):
        return [*names, _forward(s2, s3, c, x[..., 1:])]
    return names


def _joined(parts: list[np.ndarray], shape: tuple[int, ...]) -> np.ndarray:
    """Branch names (...) joined from their parts by commas."""
    if not parts:
        return np.full(shape, "")
    whole = np.broadcast_to(parts[0], shape)
    for part in parts[1:]:
        whole = np.char.add(np.char.add(whole, ", "), part)
    return whole


def _cross(a: Array, b: Array) -> Array:
    """Cross product a × b over the last axis."""
    a, b = np.broadcast_arrays(a, b)
    return np.asarray(np.cross(a, b), dtype=float)


def _across(w: Array, v: Array) -> Array:
    """The part of v at right angles to the unit vector w."""
    return v - (v @ w)[..., None] * w


def _size(v: Array) -> Array:
    """Length of vectors along the last axis."""
    return np.sqrt(np.sum(v * v, axis=-1))
