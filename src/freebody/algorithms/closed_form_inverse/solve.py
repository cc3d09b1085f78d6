"""All closed-form branches of an arm for a target: positions, which of them are solutions, and how
clearly."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from freebody.algorithms.closed_form_inverse.choose_recipe import (
    TargetKind,
    recipe_for,
    without_idle,
)
from freebody.algorithms.closed_form_inverse.joint_places import JointPlaces, PlacedBranch, numbers
from freebody.algorithms.closed_form_inverse.recipe import ReachCondition, Recipe, WantedMotion
from freebody.algorithms.closed_form_inverse.recipes import OneJointHeld
from freebody.algorithms.screws import ScrewChain, chain_to
from freebody.elementary import Scalar, epsilon, less, less_equal, maximum, where
from freebody.lazy import cached_property
from freebody.model.tree import Tree
from freebody.spatial import Matrix, Vector, dot, sub, times, transposed

REACHED = 1e-10
"""A branch brings the frame this near to its target (m and rad), else it is none."""

_REACHED_IN_32_BITS = 5e-5


@dataclass(frozen=True, eq=False)
class Branches:
    """The recipe of one chain for one kind of target."""

    chain: ScrewChain
    kind: TargetKind
    recipe: Recipe
    dim: int

    @property
    def held(self) -> int | None:
        """The place in q of the joint whose position has to be given, of an arm with one joint more
        than the target needs; None of others."""
        if not isinstance(self.recipe, OneJointHeld):
            return None
        return int(self.chain.index[0 if self.recipe.first else -1])

    @cached_property
    def count(self) -> int:
        """The number of branches that the recipe computes side by side."""
        with np.errstate(all="ignore"):
            one = np.float64(1.0)
            home = tuple(tuple(one * x for x in row) for row in self.chain.R)
            return len(self.ways(home, tuple(one * self.chain.p), one))

    def solve(
        self, target: Matrix, held: Scalar | None = None
    ) -> tuple[list[list[Scalar]], list[Scalar], list[Scalar]]:
        """Per branch the positions of the chain's joints, 1 where these reach the target, else 0,
        and how clear that is.

        target: homogeneous matrix of scalars; held: the position of the joint that is held.
        """
        R, p = self.in_space(target)
        x, valid, clear = [], [], []
        for places, clearly in self.ways(R, p, held):
            miss = self.miss(places, R, p)
            limit = where(less(epsilon(miss), 1e-10), REACHED**2, _REACHED_IN_32_BITS**2)
            x.append([self.coordinate(k, place.value(), held) for k, place in enumerate(places)])
            valid.append(less_equal(miss, limit))
            clear.append(clearly)
        return x, valid, clear

    def coordinate(self, k: int, x: Scalar, held: Scalar | None = None) -> Scalar:
        """The entry of q of the chain's joint k that stands at x; one that is held as it was given,
        whole turns too."""
        if held is not None and self.held == self.chain.index[k]:
            return held
        return (x - float(self.chain.offset[k])) / float(self.chain.ratio[k])

    def ways(self, R: Matrix, p: Vector, held: Scalar | None = None) -> list[PlacedBranch]:
        """The branches for a pose in space, none of them verified."""
        X = self.wanted(R, p)
        if isinstance(self.recipe, OneJointHeld):
            assert held is not None  # an input of the formula for such an arm
            found = self.recipe.at(X, self._held_at(held))
        else:
            found = self.recipe.ways(X)
        return [(places, _unless_free(places, clear)) for places, clear in found]

    def reached(self, R: Matrix, p: Vector, held: Scalar | None = None) -> ReachCondition | None:
        """The condition under which a pose is within reach; held: None where that joint may stand
        anywhere."""
        X = self.wanted(R, p)
        if isinstance(self.recipe, OneJointHeld) and held is not None:
            return self.recipe.reached_at(X, self._held_at(held))
        return self.recipe.reached(X)

    def gaps(self, R: Matrix, p: Vector, x: Scalar) -> list[Scalar] | None:
        """The squares of distances between a frame's pose and what the arm can reach with the
        deciding joint at x; see `Recipe.gaps`."""
        return self.recipe.gaps(self.wanted(R, p), x)

    def _held_at(self, held: Scalar) -> Scalar:
        """The position of the held joint itself where its entry of q is `held`."""
        k = list(self.chain.index).index(self.held)
        return float(self.chain.ratio[k]) * held + float(self.chain.offset[k])

    def in_space(self, target: Matrix) -> tuple[Matrix, Vector]:
        """Rotation and position of a target, one in the plane put into z = 0."""
        d = self.dim
        if d == 3:
            return tuple(row[:3] for row in target[:3]), tuple(row[3] for row in target[:3])
        (a, b, x), (c, e, y) = target[:2]
        return ((a, b, 0.0), (c, e, 0.0), (0.0, 0.0, 1.0)), (x, y, 0.0)

    def wanted(self, R: Matrix, p: Vector) -> WantedMotion:
        """The motion T T(0)⁻¹ that the joints have to make for a pose T; for a target that is a
        point, the shift that brings the frame to it from zero."""
        home = numbers(self.chain.p)
        if self.kind == "position":
            return WantedMotion(tuple(map(numbers, np.eye(3))), sub(p, home))
        back = tuple(map(numbers, self.chain.R))
        turned = tuple(tuple(dot(row, other) for other in back) for row in R)
        return WantedMotion(turned, sub(p, times(turned, home)))

    def miss(self, places: JointPlaces, R: Matrix, p: Vector) -> Scalar:
        """The square of the distance from the target (m), or of the angle (rad) if it is larger, by
        forward kinematics; compared half way along the chain."""
        half = len(places) // 2
        misses = []
        if self.kind != "orientation":
            want, have = p, numbers(self.chain.p)
            for place in places[:half]:
                want = place.back().point(want)
            for place in reversed(places[half:]):
                have = place.point(have)
            way = sub(want, have)
            misses.append(dot(way, way))
        if self.kind != "position":
            total: Scalar = 0.0
            for want, have in zip(transposed(R), self.chain.R.T, strict=True):
                have = numbers(have)
                for place in places[:half]:
                    want = place.back().direction(want)
                for place in reversed(places[half:]):
                    have = place.direction(have)
                way = sub(want, have)
                total = total + dot(way, way)
            misses.append(0.5 * total)  # three columns differ by 2 angle² together
        return misses[0] if len(misses) == 1 else maximum(*misses)


def _unless_free(places: JointPlaces, clear: Scalar) -> Scalar:
    """The margin by which a branch exists; 0 if one of its joints may have any other value as
    well."""
    for place in places:
        clear = where(place.free, 0.0, clear)
    return clear


def branches(tree: Tree, frame: str, rows: tuple[int, ...]) -> Branches | None:
    """The recipe for a frame of a tree of numbers and for the rows of its motion that a target
    tells; None where there is none."""
    d = tree.space.dim
    every = 6 if d == 3 else 3
    kinds: dict[tuple[int, ...], TargetKind] = {
        tuple(range(every)): "pose",
        tuple(range(d)): "position",
        tuple(range(d, every)): "orientation",
    }
    kind = kinds.get(tuple(sorted(rows)))
    chain = chain_to(tree, frame)
    if chain is None or kind is None:
        return None
    if kind == "position":
        chain = without_idle(chain)
    recipe = recipe_for(chain, kind, d == 2)
    return None if recipe is None else Branches(chain, kind, recipe, d)


def places_beside(tree: Tree) -> list[Scalar]:
    """Values of q for the joints that do not move the frame: 0, and no turn for quaternions."""
    q: list[Scalar] = [0.0] * tree.nq
    for body in tree.bodies:
        if body.primitive.nq > body.primitive.nv:
            q[body.coordinates.q[-4]] = 1.0
    return q
