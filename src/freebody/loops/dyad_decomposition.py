"""A planar mechanism decomposed into dyads: loop after loop whose unknown joints follow from those
known by then."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from freebody.algorithms.kinematics import ancestors
from freebody.arrays import Array
from freebody.loops.dyads import (
    OF_ONE,
    OF_TWO,
    Chain,
    ConstructionStep,
    Crossing,
    Posture,
    chain,
    coordinate,
    coordinates,
    heading,
    is_turning,
)
from freebody.loops.dyads.geometry import side_of
from freebody.model.model import Model
from freebody.outputs.number_text import compared


@dataclass(frozen=True, eq=False)
class Decomposition:
    """A sequence of construction steps that find all unknown coordinates, one after the other."""

    model: Model
    steps: tuple[ConstructionStep, ...]

    def solve(self, q: Array, target: Array | None = None) -> tuple[Array, NDArray[np.bool_]]:
        """(all solutions (N, K, nq) with the known coordinates of q (N, nq), NaN where a branch has
        none; flags (N,) of samples where pins of a dyad coincide, so that its angle is arbitrary).

        target: poses (N, 3, 3) of the frame that is held.
        """
        at = self._posture(q[:, None, :], target)
        anywhere = np.zeros(len(q), dtype=bool)
        with np.errstate(all="ignore"):  # branches without solution are NaN from there on
            for step in self.steps:
                anywhere |= step.anywhere(at).any(axis=1)
                at = at.moved(np.concatenate(step.solve(at), axis=1))
        return at.q, anywhere

    def branches(self, q: Array, target: Array | None = None) -> list[str]:
        """Names of solutions q (k, nq) by the sides of elbows and the ways of slides; target: their
        poses (k, 3, 3), or (1, 3, 3) for all."""
        at = self._posture(q[:, None], target)
        columns = []
        for step in self.steps:
            label = step.label(at)
            if label is not None:
                words = [f"{step.called} {way}" for way in (*step.ways, "straight")]
                columns.append(side_of(label[:, 0], 1.0, *words).tolist())
        return (
            [", ".join(names) for names in zip(*columns, strict=True)] if columns else [""] * len(q)
        )

    def obstacles(self, q: Array, target: Array | None = None) -> list[str]:
        """Sentences on the dyads that cannot close, with the distance missing, for one sample q
        (nq,)."""
        at = self._posture(q[None, None, :], target)
        found: list[str] = []
        unsolved: set[int] = set()
        for step in self.steps:
            if unsolved & self._carried_by(step):
                continue
            if step.anywhere(at).any():
                return found
            with np.errstate(all="ignore"):
                solutions = np.concatenate(step.solve(at), axis=1)
            good = np.isfinite(solutions[0]).all(axis=-1)
            if good.any():
                at = at.moved(solutions[:, good])
                continue
            unsolved |= coordinates(self.model.tree, step.crossings)
            reach = step.reach(at)
            if reach is not None:
                found.append(_obstacle(*reach))
        return found

    def _carried_by(self, step: ConstructionStep) -> set[int]:
        """The coordinates that move the frames of a step."""
        tree = self.model.tree
        bodies = [tree.frames[frame][0] for frame in step.frames]
        return coordinates(tree, ((i, 1.0) for body in bodies for i in ancestors(tree, body)))

    def _posture(self, q: Array, target: Array | None) -> Posture:
        if target is None:
            return Posture(self.model.tree, q)
        point = target[:, 0, 2] + 1j * target[:, 1, 2]
        return Posture(
            self.model.tree,
            q,
            point[:, None],
            np.arctan2(target[:, 1, 0], target[:, 0, 0])[:, None],
        )


def _obstacle(one: str, two: str, apart: Array, low: Array, high: Array) -> str:
    away, least, most = (float(x[0, 0]) for x in (apart, low, high))
    gap = away - most if away > most else least - away
    distance, short, long = compared(away, least, most, digits=6)
    return (
        f"{one} and {two} would be {distance} m apart; the links between them span {short} to "
        f"{long} m, which is {gap:.3g} m too {'short' if away > most else 'long'}."
    )


def decomposed(
    model: Model, unknown: Sequence[int], held: str | None = None, oriented: bool = False
) -> Decomposition | None:
    """A decomposition that gives the unknown coordinates (indices in q) from the others; None where
    the mechanism is no sequence of dyads.

    held: a frame that is held at a target, its direction too where `oriented`.
    """
    tree = model.tree
    if model.dim != 2 or tree.follows or (held is None and not model.loops):
        return None
    pending: list[Chain] = []
    if held is not None:
        pending.append(chain(tree, held, (None, held)))
    for loop in tree.loops:
        closure = loop.closure
        if closure.slides or closure.turns:
            return None
        distance = float(loop.distance) if closure.distance else 0.0
        pending.append(chain(tree, loop.name, loop.frames, distance))
    steps = _found(model, set(unknown), pending, held if oriented else None)
    return None if steps is None else Decomposition(model, tuple(steps))


def _found(
    model: Model, left: set[int], pending: list[Chain], held: str | None
) -> list[ConstructionStep] | None:
    """Steps that find all coordinates in `left`; None where there are none."""
    turns = [] if held is None else _free_turns(model, left, pending[0])
    if len(turns) > 1:
        return None
    steps = [heading(held, turn) for turn in turns] if held is not None else []
    while True:
        for step in steps:
            left -= coordinates(model.tree, step.crossings)
        pending = [c for c in pending if any(coordinate(model.tree, x) in left for x in c.path)]
        if not pending:
            return None if left else steps
        chosen = _next(model, left, pending)
        if chosen is None:
            return None
        step, used = chosen
        steps.append(step)
        pending = [c for c in pending if c not in used]


def _free_turns(model: Model, left: set[int], chain: Chain) -> list[Crossing]:
    """The turning joints on the way of a chain whose coordinates are unknown."""
    tree = model.tree
    return [c for c in chain.path if coordinate(tree, c) in left and is_turning(tree, c)]


def _next(
    model: Model, left: set[int], pending: list[Chain]
) -> tuple[ConstructionStep, tuple[Chain, ...]] | None:
    """The next step that can be constructed, and the chains that it closes; None where no step
    fits."""
    tree = model.tree

    def free(c: Chain) -> list[Crossing]:
        return [x for x in c.path if coordinate(tree, x) in left]

    def name_of(crossing: Crossing) -> str:
        return model.position_names[coordinate(tree, crossing)]

    for c in pending:
        joints = "".join("R" if is_turning(tree, x) else "P" for x in free(c))
        kind = OF_ONE.get((c.distance > 0.0, joints))
        if kind is not None:
            return kind.make(c, free(c), name_of), (c,)
    for one, two in combinations(pending, 2):
        for make in OF_TWO:
            step = make(tree, (one, two), (free(one), free(two)))
            if step is not None:
                return step, (one, two)
    return None
