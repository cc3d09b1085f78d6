"""A planar mechanism taken apart into dyads: loop after loop whose unknown joints follow from what is known by then."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from freebody.algorithms.kinematics import ancestors
from freebody.arrays import Array
from freebody.loops import dyads
from freebody.loops.dyads import Chain, Coincident, Crossing, Posture, Step
from freebody.model.model import Model
from freebody.trees.triangles import side_of


@dataclass(frozen=True, eq=False)
class Decomposition:
    """Steps that find all unknown coordinates, one after the other."""

    model: Model
    steps: tuple[Step, ...]

    def solve(self, q: Array, target: Array | None = None) -> Array | None:
        """All solutions (N, K, nq) with the known coordinates of q (N, nq), NaN where a branch has none.

        target: poses (N, 3, 3) of the frame that is held. None where pins of a dyad coincide: no angle is singled out.
        """
        at = self._posture(q[:, None, :], target)
        try:
            with np.errstate(
                invalid="ignore", divide="ignore"
            ):  # branches without solution are NaN from there on
                for step in self.steps:
                    at = at.moved(np.concatenate(step.solve(at), axis=1))
        except Coincident:
            return None
        return at.q

    def branches(self, q: Array, target: Array | None = None) -> list[str]:
        """Names of the solutions q (k, nq) of one sample: on which side elbows lie, which way slides reach."""
        at = self._posture(q[None], target)
        columns = []
        for step in self.steps:
            label = step.label(at)
            if label is not None:
                (left, right), stem = step.words, step.words[0].split()[0]
                columns.append([side_of(float(x), 1.0, left, right, f"{stem} straight") for x in label[0]])
        return [", ".join(names) for names in zip(*columns, strict=True)] if columns else [""] * len(q)

    def obstacles(self, q: Array, target: Array | None = None) -> list[str]:
        """Sentences: which dyads cannot close, by how much, for one sample q (nq,)."""
        at = self._posture(q[None, None, :], target)
        found: list[str] = []
        unsolved: set[int] = set()
        for step in self.steps:
            if unsolved & self._carried_by(step):
                continue
            try:
                with np.errstate(invalid="ignore", divide="ignore"):
                    solutions = np.concatenate(step.solve(at), axis=1)
            except Coincident:
                return found
            good = np.isfinite(solutions[0]).all(axis=-1)
            if good.any():
                at = at.moved(solutions[:, good])
                continue
            unsolved |= dyads.coordinates(self.model.tree, step.crossings)
            reach = step.reach(at)
            if reach is not None:
                found.append(_obstacle(*reach))
        return found

    def _carried_by(self, step: Step) -> set[int]:
        """The coordinates that a step's frames hang on."""
        tree = self.model.tree
        bodies = [tree.frames[frame][0] for frame in step.frames]
        return dyads.coordinates(tree, ((i, 1.0) for body in bodies for i in ancestors(tree, body)))

    def _posture(self, q: Array, target: Array | None) -> Posture:
        if target is None:
            return Posture(self.model.tree, q)
        point = target[:, 0, 2] + 1j * target[:, 1, 2]
        return Posture(
            self.model.tree, q, point[:, None], np.arctan2(target[:, 1, 0], target[:, 0, 0])[:, None]
        )


def _obstacle(one: str, two: str, apart: Array, low: Array, high: Array) -> str:
    away, least, most = (float(x[0, 0]) for x in (apart, low, high))
    gap = away - most if away > most else least - away
    return (
        f"{one} and {two} would be {away:.6g} m apart; the links between them span {least:.6g} to {most:.6g} m, which "
        f"is {gap:.3g} m too {'short' if away > most else 'long'}."
    )


def decomposed(
    model: Model, unknown: Sequence[int], held: str | None = None, oriented: bool = False
) -> Decomposition | None:
    """How the unknown coordinates (indices in q) follow from the others; None where the mechanism is no row of dyads.

    held: a frame that is held at a target, its direction too where `oriented`.
    """
    tree = model.tree
    if model.dim != 2 or tree.follows or (held is None and not model.loops):
        return None
    pending: list[Chain] = []
    if held is not None:
        pending.append(dyads.chain(tree, held, (None, held)))
    for loop in tree.loops:
        closure = loop.closure
        if closure.slides or closure.turns:
            return None
        distance = float(loop.distance) if closure.distance else 0.0
        pending.append(dyads.chain(tree, loop.name, loop.frames, distance))
    steps = _found(model, set(unknown), pending, held if oriented else None)
    return None if steps is None else Decomposition(model, tuple(steps))


def _found(model: Model, left: set[int], pending: list[Chain], heading: str | None) -> list[Step] | None:
    """Steps for all coordinates in `left`, or None."""
    steps: list[Step] = []
    if heading is not None:
        turns = [c for c in pending[0].path if _at(model, c) in left and dyads.is_turning(model.tree, c)]
        if len(turns) > 1:
            return None
        steps += [dyads.Heading(heading, turns[0])] if turns else []
    while True:
        for step in steps:
            left -= dyads.coordinates(model.tree, step.crossings)
        pending = [c for c in pending if any(_at(model, x) in left for x in c.path)]
        if not pending:
            return None if left else steps
        chosen = _next(model, left, pending)
        if chosen is None:
            return None
        step, used = chosen
        steps.append(step)
        pending = [c for c in pending if c not in used]


def _at(model: Model, crossing: Crossing) -> int:
    return model.tree.bodies[crossing[0]].coordinates.q[0]


def _next(model: Model, left: set[int], pending: list[Chain]) -> tuple[Step, tuple[Chain, ...]] | None:
    """The next step, and the chains that it closes."""
    for c in pending:
        free = [x for x in c.path if _at(model, x) in left]
        kinds = "".join("R" if dyads.is_turning(model.tree, x) else "P" for x in free)
        make = _STEPS.get((c.distance > 0.0, kinds))
        if make is not None:
            return make(model, c, free), (c,)
    for one, two in combinations([c for c in pending if c.distance > 0.0], 2):
        step = _circles(model, left, one, two)
        if step is not None:
            return step, (one, two)
    return None


def _circles(model: Model, left: set[int], one: Chain, two: Chain) -> Step | None:
    free = [[x for x in c.path if _at(model, x) in left] for c in (one, two)]
    bodies = [sorted(i for i, _ in row) for row in free]
    signs = [{sign for _, sign in row} for row in free]
    slides = all(not dyads.is_turning(model.tree, x) for row in free for x in row)
    if len(bodies[0]) != 2 or bodies[0] != bodies[1] or not slides or any(len(s) != 1 for s in signs):
        return None
    a, b = bodies[0]
    (first,), (second,) = signs
    name = one.ends[1] if first > 0 else one.ends[0]
    return dyads.TwoCircles((one, two), ((a, 1.0), (b, 1.0)), (first, second), str(name))


def _joint(model: Model, crossing: Crossing) -> str:
    """Name of the coordinate."""
    return model.position_names[_at(model, crossing)]


def _triangle(model: Model, c: Chain, free: list[Crossing]) -> Step:
    one, two = free
    return dyads.Triangle(c, one, two, (_joint(model, one), _joint(model, two), c.ends[0] or c.ends[1]))


def _mixed(model: Model, c: Chain, free: list[Crossing]) -> Step:
    turn, slide = sorted(free, key=lambda x: not dyads.is_turning(model.tree, x))
    return dyads.TurnAndSlide(c, turn, slide, _joint(model, slide))


def _swing(model: Model, c: Chain, free: list[Crossing]) -> Step:
    (turn,) = free
    end = c.ends[1] if turn[1] > 0 else c.ends[0]
    return dyads.Swing(c, turn, (_joint(model, turn), str(end)))


Maker = Callable[[Model, Chain, list[Crossing]], Step]

_STEPS: dict[tuple[bool, str], Maker] = {
    (False, "RR"): _triangle,
    (False, "RP"): _mixed,
    (False, "PR"): _mixed,
    (False, "PP"): lambda _, c, free: dyads.TwoSlides(c, free[0], free[1]),
    (True, "R"): _swing,
    (True, "P"): lambda model, c, free: dyads.Stretch(c, free[0], _joint(model, free[0])),
}
"""By whether the ends stay a distance apart, and the unknown joints in their order."""
