"""The closed form for a frame and a task, if its chain of joints has one: decided by the lines its
joints turn about and slide along, never by a name."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from freebody.algorithms.closed_form_inverse.across import Across
from freebody.algorithms.closed_form_inverse.choose_recipe import recipe_for, without_idle
from freebody.algorithms.closed_form_inverse.joint_places import Branch
from freebody.algorithms.closed_form_inverse.solve import Branches, branches
from freebody.algorithms.joint_lines import parallel
from freebody.algorithms.screws import Screw, ScrewChain, chain_to
from freebody.arrays import Array
from freebody.elementary import Scalar
from freebody.inverse import branch_names
from freebody.inverse.task import Task
from freebody.lazy import cached_property
from freebody.model.model import Model
from freebody.program import Argument, trace
from freebody.spatial import Matrix, Vector, identity
from freebody.targets import Kernel, compile_program


@dataclass(frozen=True, eq=False)
class ClosedFormArm:
    """All branches of a task."""

    branches: Branches
    task: Task
    words: tuple[str, str]
    """What the two elbows of an arm with parallel axes are called."""

    @property
    def chain(self) -> ScrewChain:
        """The joints as screws."""
        return self.branches.chain

    @property
    def held(self) -> int | None:
        """The place in q of the joint whose position has to be given: of seven joints one."""
        return self.branches.held

    @property
    def decides(self) -> bool:
        """Whether its branches are all that the task asks for, and not candidates alone."""
        return self.branches.kind != "position" or not self.task.angular

    @property
    def method(self) -> str:
        """What is done, with its source."""
        return f"closed form: {self.branches.recipe.title}"

    def names(self, q: Array) -> np.ndarray:
        """Names (...) of the branches of solutions q (..., nq)."""
        parts = branch_names.of_recipe(self.branches.recipe, self.chain.positions(q), self.words)
        return branch_names.joined(parts, q.shape[:-1])

    def counted(self, target: Array) -> Array:
        """What counts of targets (…, dim + 1, dim + 1): all, the point (…, dim) or the rotation."""
        arm = self.branches
        if arm.kind == "pose":
            return target
        d = arm.dim
        return target[..., :d, d] if arm.kind == "position" else target[..., :d, :d]

    def of_counted(self, target: Any) -> tuple[Matrix, Vector]:
        """Rotation and position in space, of scalars, from what counts of a target."""
        arm = self.branches
        if arm.kind == "pose":
            return arm.in_space(target)
        if arm.kind == "position":
            return identity(3), (*target, 0.0)[:3]
        return target, (0.0, 0.0, 0.0)

    def resting(
        self, at_rest: Sequence[Scalar], R: Matrix, p: Vector, held: Scalar | None = None
    ) -> list[Branch]:
        """The branches for a pose in space, none of them verified; joints that could stand anywhere
        are at rest (n,)."""
        arm = self.branches
        chain = arm.chain.resting(at_rest)
        recipe = recipe_for(chain, arm.kind, arm.dim == 2)
        assert recipe is not None  # there is one for the same chain
        return Branches(chain, arm.kind, recipe, arm.dim).ways(R, p, held)

    @cached_property
    def candidates(self) -> Kernel:
        """(what counts of a target, at rest (n,), held?) -> (x (branches, n), 1 where a joint could
        stand anywhere (branches, n), how clear a branch is (branches,)), none of them verified, NaN
        where there is none."""
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
        """Targets (N, …) with what the task leaves open as the arm has it."""
        free = [k for k in range(self.task.dim) if k not in self.task.linear]
        if not free:
            return target
        target = target.copy()
        target[:, free, -1] = self.chain.p[free]
        return target

    def serves(self, target: Array) -> bool:
        """Whether it fits these targets too: a partial orientation must be a turn about the arm's
        own axis."""
        recipe = self.branches.recipe
        if not isinstance(recipe, Across) or self.task.turns or not self.task.angular:
            return True
        turned = target[:, :3, :3] @ (self.chain.R.T @ recipe.normal)
        return bool(np.abs(turned - recipe.normal).max(initial=0.0) < 1e-9)

    def reached(
        self, target: Array, held: Array | None
    ) -> tuple[tuple[Screw, ...], Array, Array] | None:
        """(screws, c, points): a target (N, …) is in the workspace where the screws bring the point
        c (3,) to points (N, 3); None where that is not what decides. held: (N,), where it is
        given."""
        found = self.branches.reached(*self.branches.in_space(over_arrays(target)), held)
        if found is None:
            return None
        screws, c, point = found
        return tuple(screws), c, np.stack(np.broadcast_arrays(*point), axis=-1)


def over_arrays(target: Array) -> tuple[tuple[Array, ...], ...]:
    """Targets (N, …) as a matrix whose entries are arrays (N,)."""
    return tuple(tuple(row) for row in np.moveaxis(target, 0, -1))


def closed_form_for(model: Model, frame: str, task: Task) -> ClosedFormArm | None:
    """The closed form that gives all solutions of a task, or None."""
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
    """Of an arm with parallel axes in space, for rows that tell where it stands across and along
    them."""
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
    """Of an arm of three joints in space, whose position leaves no choice of the orientation."""
    chain = chain_to(model.tree, frame)
    if chain is None or model.dim == 2 or not task.places or len(chain.screws) != 3:
        return None
    recipe = recipe_for(chain, "position", False)
    return None if recipe is None else Branches(chain, "position", recipe, 3)


def _elbows(model: Model, chain: ScrewChain) -> tuple[str, str]:
    """Up and down for an arm that moves in an upright plane, left and right (from above) for one
    that moves level."""
    axis = next((s.w for s in chain.screws if s.turning), None)
    if axis is None:
        return ("up", "down")
    lean = float(np.array(model.gravity_direction) @ axis)
    return (
        ("up", "down") if abs(lean) < 0.5 else ("left", "right") if lean < 0 else ("right", "left")
    )
