"""Inverse kinematics: every branch of a closed form side by side."""

from __future__ import annotations

from typing import Any

from freebody.algorithms.closed_form_inverse.solve import Branches, branches, places_beside
from freebody.elementary import Scalar, sqrt, where
from freebody.errors import FreebodyError
from freebody.kernels.formulas.record import Formula, Option, Output, frame_of
from freebody.model.tree import Tree
from freebody.spatial import Matrix


def known_branches(tree: Tree, o: Option) -> Branches:
    """The closed-form recipe for the option's frame; refuses arms without one, and lengths that are
    not numbers."""
    places = [x for body in tree.bodies for x in (*body.p, *sum(body.R, ()), *body.axis)]
    _, R, p = tree.frames[frame_of(o)]
    if not all(isinstance(x, (float, int)) for x in (*places, *p, *sum(R, ()))):
        raise FreebodyError(
            "inverse_kinematics: which closed form fits is decided by where the joints lie, so "
            "that these numbers can be no inputs of its kernel, nor a family's; take "
            "fb.kernel(model[i], ...) of each member."
        )
    found = branches(tree, frame_of(o), o.rows)
    if found is None:
        raise FreebodyError(
            f"inverse_kinematics: no closed form is known for the "
            f"{len(o.rows)} rows asked for of frame {frame_of(o)!r}; rows= asks for its position "
            'alone ("vx", "vy", "vz") or its orientation; fb.inverse_kinematics searches where '
            "there is no closed form."
        )
    return found


def _inverse_kinematics(
    tree: Tree, o: Option, target: Matrix, redundancy: Scalar | None = None
) -> tuple[Any, ...]:
    arm = known_branches(tree, o)
    found, valid, clear = arm.solve(target, redundancy)
    rest = places_beside(tree)
    rows = []
    for x, good in zip(found, valid, strict=True):
        none = sqrt(good - 0.5)  # NaN, which is no constant of a program
        q = list(rest)
        for k, value in zip(arm.chain.index, x, strict=True):
            q[int(k)] = value
        rows.append(tuple(where(good, value, none) for value in q))
    return tuple(rows), tuple(valid), tuple(clear)


FORMULAS = {
    "inverse_kinematics": Formula(
        ("target", "redundancy"),
        {
            "q": Output(
                ("branches", "nq"),
                "positions of the joints, branch by branch, angles -pi to pi; NaN where there is "
                "no such branch (rad, m)",
            ),
            "valid": Output(
                ("branches",), "1 where forward kinematics brings the branch to the target, else 0"
            ),
            "clearance": Output(
                ("branches",),
                "how clearly there is such a branch or none, in relative terms: 0 where two merge "
                "or a joint may stand anywhere, negative where there is none",
            ),
        },
        _inverse_kinematics,
        of_frame=True,
        of_rows=True,
        chains="arm",
        touches=(),
    )
}
