"""`same_robot`: whether two descriptions are of one robot, and where they differ."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from freebody.by_value import ByValue
from freebody.diagnosis.alignment import Alignment, Tolerances, align
from freebody.diagnosis.bodies_in_space import BodyTree, floating, held, pose_in_space
from freebody.diagnosis.differences import ASPECTS, RobotDifference
from freebody.diagnosis.facts import norm
from freebody.errors import FreebodyError, KindError, listed
from freebody.formats.loading import load
from freebody.model.bodies import Body
from freebody.model.model import Model
from freebody.model.model_argument import require_one
from freebody.model.placement import ArrayPose, composed
from freebody.model.single_joints import is_taken_apart, with_single_joints
from freebody.outputs.display import InWords, Tabled, TextTable, counted

_NAMES = 4


@dataclass(frozen=True, eq=False, repr=False)
class RobotComparison(InWords, Tabled, ByValue):
    """The result of comparing two robots; true as a condition if they are the same robot.

    differences: where they differ, the first first. regardless: differences of the descriptions
    that make no other robot, in words. joints: names of the joints of the first with those of the
    second. base: (R, p), the second's base in the first's (m).
    """

    names: tuple[str, str]
    differences: tuple[RobotDifference, ...]
    regardless: tuple[str, ...]
    joints: dict[str, str]
    base: tuple[np.ndarray, np.ndarray]

    @property
    def same(self) -> bool:
        """Whether the two descriptions are of one robot."""
        return not self.differences

    @property
    def first(self) -> RobotDifference | None:
        """The first difference between the two robots; None where there is none."""
        return self.differences[0] if self.differences else None

    def __bool__(self) -> bool:
        return self.same

    @property
    def title(self) -> str:
        """A sentence that says whether the two descriptions are of one robot."""
        a, b = self.names
        if self.same:
            return f"{a} and {b} are the same robot."
        return f"{a} and {b} differ in {counted(len(self.differences), 'place')}."

    @property
    def data(self) -> dict[str, Any]:
        """The comparison as plain data, such as JSON holds."""
        return {
            "names": list(self.names),
            "same": self.same,
            "differences": [
                {
                    "aspect": x.aspect,
                    "place": list(x.place),
                    "text": x.text,
                    "size": x.size if np.isfinite(x.size) else None,
                }
                for x in self.differences
            ],
            "regardless": list(self.regardless),
            "joints": self.joints,
        }

    def __str__(self) -> str:
        return "\n".join([self.title, *map(str, self.differences), *self.regardless])

    def _title(self) -> str:
        return self.title

    def _table(self) -> TextTable:
        rows = [(x.aspect, " / ".join(dict.fromkeys(x.place)), x.text) for x in self.differences]
        return TextTable(("aspect", "where", "difference"), rows, self.regardless)


def same_robot(
    a: Model | str | os.PathLike[str],
    b: Model | str | os.PathLike[str],
    *,
    tolerance: float = 1e-5,
) -> RobotComparison:
    """Whether two models or files are of one robot, else where they first differ and by how much.

    What a description is free to choose does not count, and is told: where the base stands and what
    the tool's frame is, where a joint's zero is and which way it counts, where the frames of links
    are, names, links that are split into several, and a joint of several axes that is a chain of
    joints in the other. Joints of several axes in both are compared with their frames as they are,
    and what is fixed to the base only by the joints on it. A robot in the plane is compared with
    one in space by what moves it there. Where the base of one floats, and that of the other is
    fixed, this is one difference, and what the bases carry is compared. Limits, friction and masses
    that one of them does not give at all are told, not compared.

    Parameters
    ----------
    a, b
        Models, or what `load` takes.
    tolerance
        Differences that are none: relative, rad, and in lengths a share of the longest chain.

    Returns
    -------
    RobotComparison
        True as a condition if they are one robot; `differences`, each with `aspect`, `place`,
        `text` and `size`; `regardless`, what does not count; `joints`, which are which.

    Raises
    ------
    FileError
        A file that cannot be read.
    FreebodyError
        A family, or parameters without value.
    """
    if isinstance(tolerance, bool) or not 0.0 < tolerance < 1.0:
        raise FreebodyError(f"same_robot: tolerance is {tolerance}, expected one between 0 and 1.")
    one, two = _model("a", a), _model("b", b)
    if one.name == two.name:
        # sentences name the robot that they mean
        one, two = (
            x.replace(name=f"{x.name} ({which})") for x, which in ((one, "first"), (two, "second"))
        )
    found = _compared(one, two, tolerance)
    fixed = _with_fixed_bases(one, two)
    if fixed is None or found:
        return found
    floats, one, two = fixed
    other = _compared(one, two, tolerance)
    other = replace(other, differences=(floats, *other.differences))
    # six joints in a row may be a base that floats, too
    return min(found, other, key=lambda comparison: len(comparison.differences))


def _compared(one: Model, two: Model, tolerance: float) -> RobotComparison:
    """The comparison of two models as they stand."""
    if _composed_kinds(one) != _composed_kinds(two):  # a format without them writes several
        one, two = with_single_joints(one), with_single_joints(two)
    robots = BodyTree(one), BodyTree(two)
    lengths = tolerance * max(robot.reach for robot in robots)
    found = align(*robots, Tolerances(lengths, tolerance))
    differences: list[RobotDifference] = []
    absent: list[str] = []
    for aspect in ASPECTS:
        given = [aspect.given(robot) for robot in robots]
        differences += aspect.find(found, given[0] & given[1])
        for model, own, other in ((one, *given), (two, *reversed(given))):
            if other - own:
                lacks = listed(sorted(other - own), _NAMES)
                absent.append(f"{model.name!r} gives no {lacks}: not compared")
    return RobotComparison(
        (one.name, two.name),
        tuple(differences),
        (*_regardless(found), *absent),
        {
            x.joint.name: y.joint.name
            for pair in found.pairs
            for x, y in ((pair.a.body, pair.b.body), (pair.a.shaft, pair.b.shaft))
            if x and y
        },
        found.base,
    )


def _with_fixed_bases(one: Model, two: Model) -> tuple[RobotDifference, Model, Model] | None:
    """The difference that the base of one of two robots floats, and both on fixed bases; None where
    both float or neither does."""
    bases = floating(one), floating(two)
    match bases:
        case (None, None) | (Body(), Body()):
            return None
        case (None, Body(name=name)):
            place, who, other = ("", name), two, one
        case (Body(name=name), None):
            place, who, other = (name, ""), one, two
    text = (
        f"floats in {who.name!r}, and the base of {other.name!r} is fixed; the masses of both "
        f"bases are not compared"
    )
    return RobotDifference("joints", place, text, np.inf), held(one), held(two)


def _model(argument: str, given: object) -> Model:
    if not isinstance(given, Model | str | os.PathLike):
        raise KindError("same_robot", argument, given, "a Model or a path")
    model = given if isinstance(given, Model) else load(given, physical="ignore")
    require_one("same_robot", model)
    model.require_values("same_robot: the numbers")
    return model


def _composed_kinds(model: Model) -> list[str]:
    return sorted(body.joint.kind for body in model.bodies if is_taken_apart(body, euler=False))


# ------------------------------------------------------------ what does not count
def _regardless(found: Alignment) -> Iterator[str]:
    """Differences in mere choices of the descriptions (the base's place, joints' zeros and
    directions), in words."""
    one, two = found.a.model.name, found.b.model.name
    if moved := _off(found.base, found.tolerances):
        yield f"the base of {two!r} stands {moved} from that of {one!r}"
    shifted = [
        f"{pair.a.joint} by {pair.offset:.6g} {'rad' if pair.a.turns else 'm'}"
        for pair in found.pairs
        if abs(pair.offset) > found.tolerances.share
    ]
    if shifted:
        yield f"joints have another zero: {listed(shifted, _NAMES)}"
    flipped = [pair.a.joint for pair in found.pairs if pair.flip < 0.0]
    if flipped:
        yield f"joints count the other way: {listed(flipped, _NAMES)}"
    renamed = [
        f"{pair.a.joint} is {pair.b.joint}" for pair in found.pairs if pair.a.joint != pair.b.joint
    ]
    if renamed:
        yield f"joints are renamed: {listed(renamed, _NAMES)}"
    split = [
        f"{pair.a.body.name} is {counted(n, 'link')} and {counted(m, 'link')}"
        for pair in found.pairs
        if (n := len(pair.a.body.inertias)) != (m := len(pair.b.body.inertias)) and n and m
    ]
    if split:
        yield f"bodies are split differently: {listed(split, _NAMES)}"
    yield from _tool(found)


def _tool(found: Alignment) -> Iterator[str]:
    models = found.a.model, found.b.model
    tips = [next((x for x in model.frames if x.name == model.tip), None) for model in models]
    one, two = tips
    if one is None or two is None:
        return
    pair = next((x for x in found.pairs if x.a.index == one.body), None)
    if one.body >= 0 and (pair is None or pair.b.index != two.body):
        yield f"their tips, {one.name!r} and {two.name!r}, are on other bodies"
        return
    base: ArrayPose = found.base if pair is None else pair.pose
    R, p = pose_in_space(one.placement, models[0].dim)
    S, q = composed(base, pose_in_space(two.placement, models[1].dim))
    if moved := _off((R.T @ S, R.T @ (q - p)), found.tolerances):
        yield f"the tip {two.name!r} is {moved} from {one.name!r}"


def _off(pose: ArrayPose, tolerances: Tolerances) -> str:
    """A displacement in words, such as "3 mm and 0.1 rad"; "" where it is within the tolerances."""
    R, p = pose
    angle = float(np.arccos(np.clip(0.5 * (np.trace(R) - 1.0), -1.0, 1.0)))
    parts = []
    if norm(p) > tolerances.length:
        parts.append(f"{1e3 * norm(p):.4g} mm")
    if angle > max(tolerances.share, 1e-7):
        parts.append(f"{angle:.4g} rad")
    return listed(parts)
