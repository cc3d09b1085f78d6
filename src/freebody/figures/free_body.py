"""Free-body diagrams: each body alone, with every force and moment on it at one instant."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from os import PathLike

import numpy as np

from freebody.any_chain.dynamics import inverse_dynamics
from freebody.errors import FreebodyError, MissingValueError, UnknownNameError
from freebody.expressions.notations.notation import BookNotation
from freebody.figures.body_loads import NOISE, BodyLoads
from freebody.figures.drawing import Drawing
from freebody.figures.figure import Figure, to_one_scale
from freebody.figures.labelling import chosen_of, labels_of
from freebody.figures.layers import forces
from freebody.figures.marked_text import indexed
from freebody.figures.snapshot import Snapshot, resting_pose, snapshot, with_values
from freebody.model.model import Model
from freebody.motion.ranges import angular
from freebody.outputs.number_text import significant
from freebody.trees.public_calls import FrameWrenchTable, JointVector

PANEL, TALLEST = 430.0, 400.0
"""Size of one diagram, pixels."""

_VECTORS = ("s", "sc")
SHOW: dict[int, dict[str, tuple[str, ...]]] = {
    2: {"points": ("points",), "centres": ("centres",), "lengths": ("lengths",),
        "angles": ("angles",), "vectors": _VECTORS},
    3: {"points": ("points",), "centres": ("centres",), "axes": ("axes",), "vectors": _VECTORS},
}  # fmt: skip
"""Choices of `show`, by dimension: parts of `forces.PARTS` that stand beside the forces."""


@dataclass(frozen=True, eq=False, repr=False)
class FreeBodyDiagram(Figure):
    """The free-body diagrams of one or all bodies at one instant; shows itself in a notebook."""

    q: tuple[float, ...] = ()
    """The position at which it was drawn, rad or m."""
    loads: tuple[BodyLoads, ...] = ()
    """The loads drawn on each body; for assumed values where some are missing."""
    missing: tuple[str, ...] = ()
    """Parameters of the model that have no value."""
    unheld: tuple[str, ...] = ()
    """Efforts that joints without motor would need to be in this state, in words; () where
    nothing."""

    def _title(self) -> str:
        return self.title

    @property
    def bodies(self) -> tuple[BodyLoads, ...]:
        """The loads on each body and how well they balance.

        Raises MissingValueError where the model has parameters without value.
        """
        if self.missing:
            raise MissingValueError(f"the loads in the {self.title}", self.missing)
        return self.loads


def free_body_diagram(
    model: Model,
    q: JointVector | None = None,
    body: str | int | None = None,
    qd: JointVector | None = None,
    qdd: JointVector | None = None,
    wrenches: FrameWrenchTable = None,
    *,
    labels: str | None = None,
    show: str | Sequence[str] = (),
    notation: str | PathLike[str] | BookNotation | None = None,
) -> FreeBodyDiagram:
    """Free-body diagram of a body, or of all: forces to scale.

    Parameters
    ----------
    model
        Parameters without value get typical ones, for which forces are then drawn.
    q
        (nq,) rad or m; default: a clearly visible pose, if possible one in which joints without a
        motor stay at rest.
    body
        The body's name, its joint's or a link's, or its index from 0; default: all.
    qd, qdd
        (nv,); default: at rest.
    wrenches
        Acting on the arm, as for `inverse_dynamics`.
    labels
        "names", "values" or "both"; default: both, or names where parameters have no value.
    show
        One or several of "points" (O, A, P), "centres" (C_i), "vectors" (s_i, s_ci), in the plane
        "lengths" (l_i, l_ci) and "angles" (θ_i), in space "axes" (z_i, of slides u_i).
    notation
        Whose letters stand in it, as for `check`.

    Returns
    -------
    FreeBodyDiagram
        A figure with `.svg`, `.save("fbd.svg")`, `.drawing` (the arrows as data) and `.bodies` (the
        loads and how well they balance).

    Raises
    ------
    ShapeError, NotFiniteError, UnknownNameError, MissingValueError, FileError

    References
    ----------
    Figures 1.4, 2.3, 3.2, 6.4.
    """
    caller = "free_body_diagram"
    how, parts = labels_of(caller, model, labels), _parts(model.dim, show)
    chosen = None if body is None else _index(model, body)
    still = np.zeros(model.nv)
    if q is None and qd is None and qdd is None:
        q = resting_pose(with_values(model), wrenches)
    qd, qdd = still if qd is None else qd, still if qdd is None else qdd
    seen = snapshot(model, q, qd, qdd, wrenches, caller, notation)
    if seen.names.naming.letters.notation.absolute:
        raise FreebodyError(
            f"{caller}: torques are those of the joints, and a notation with absolute angles has "
            "others; take one with angles = 'relative'."
        )
    title, loads = f"Free-body diagram of {model.name}", seen.loads
    if chosen is not None:
        loads = (loads[chosen],)
        title += f": {loads[0].body.name}"
    drawings = diagrams(seen, loads, parts, how, model.missing)
    made = title, drawings, 2, PANEL, TALLEST, caller, 0.0
    needs = _unheld(seen, bool(model.missing))
    lacking = tuple(text for item in loads for text in needs.get(item.body.index, ()))
    return FreeBodyDiagram(*made, tuple(seen.q.tolist()), loads, tuple(model.missing), lacking)


def diagrams(
    seen: Snapshot,
    bodies: Sequence[BodyLoads],
    parts: Sequence[str] = (),
    labels: str = "both",
    missing: Sequence[str] = (),
) -> tuple[Drawing, ...]:
    """Drawings of bodies with forces to one scale, so that action and reaction look equal, and
    lengths to one scale where the bodies' sizes allow it. parts: of `forces.PARTS`; missing:
    parameters for which values were assumed."""
    scales = forces.scales_of(bodies)
    drawings, unheld = [], _unheld(seen, bool(missing) or labels == "names")
    for loads, scale in zip(bodies, scales, strict=True):
        drawing = forces.alone(seen, loads.body, parts, scale, inertia=True)
        drawing.heading = f"Body {loads.body.number} · {loads.body.name}"
        drawing.compass, drawing.labels = True, labels
        if not missing:
            if scale.force:
                drawing.ruler(scale.force / 2.5, scale.longest / 2.5, "N", "reaction")
            drawing.ruler(scale.longest / 3.75, scale.longest / 3.75, "m", "length")
        longer = [] if missing else scale.lengthened(drawing.arrows)
        notes = _notes(loads, longer, labels, missing)
        drawing.notes = [*notes, *unheld.get(loads.body.index, ())]
        drawings.append(drawing)
    to_one_scale(drawings, PANEL, TALLEST, [scale.longest for scale in scales])
    return tuple(drawings)


def _notes(
    loads: BodyLoads, longer: Sequence[str], labels: str, missing: Sequence[str]
) -> list[str]:
    """Notes on loads that vanish, on loads drawn longer than to scale, and on the balance or the
    values assumed."""
    small = [x.name for x in loads.loads if not any(x.force)]
    small += [x.moment_name for x in loads.loads if x.moment_name and not any(x.moment)]
    notes = [f"≈ 0: {', '.join(small)}"] if small else []
    if longer:
        notes.append(f"longer than to scale: {', '.join(longer)}")
    n, residuals = loads.body.number, (loads.force_residual, loads.moment_residual)
    force, moment = (significant(x, 2) for x in residuals)
    if missing:
        notes.append(f"drawn for typical values: {len(missing)} parameters have none")
    elif labels != "names":
        notes.append(
            f"|ΣF − {loads.mass_name} {indexed('a', str(n))}| = {force} N,\u2003"
            f"|ΣM − {indexed('Ḣ', str(n))}| = {moment} N m"
        )
    return notes


def _unheld(seen: Snapshot, unnumbered: bool) -> dict[int, list[str]]:
    """For each body the efforts that its joint without motor would have to supply in this state,
    which nothing does; empty for closed chains, whose drives hold them. unnumbered: in words,
    without values."""
    model, found = seen.model, dict[int, list[str]]()
    if model.loops or not model.passive:
        return found
    tau = inverse_dynamics(model, seen.q, seen.qd, seen.qdd, wrenches=seen.wrenches)
    largest = max(np.linalg.norm(x.force) for body in seen.loads for x in body.loads)
    turns = angular(model)
    for body, at in zip(seen.pose.bodies, model.coordinates, strict=True):
        for k in at.v if model.bodies[body.index].joint.passive else ():
            unit, least = ("N m", seen.size) if turns[k] else ("N", 1.0)
            if abs(tau[k]) > NOISE * largest * least:
                name = model.velocity_names[k]
                what = f"{significant(float(tau[k]), 3)} {unit}"
                if unnumbered:
                    what = "a torque" if turns[k] else "a force"
                found.setdefault(body.index, []).append(
                    f"{name} is passive, and this state needs {what} there"
                )
    return found


def _parts(dim: int, show: str | Sequence[str]) -> list[str]:
    """The parts of `forces.PARTS` that a choice by name stands for."""
    chosen = chosen_of(f"free_body_diagram of a model in {dim}D", show, SHOW[dim])
    return [part for name in chosen for part in SHOW[dim][name]]


def _index(model: Model, body: str | int) -> int:
    if isinstance(body, int):
        if not 0 <= body < len(model.bodies):
            raise FreebodyError(
                f"free_body_diagram: body {body} of {model.name!r} is not there; it has bodies 0 "
                f"to {len(model.bodies) - 1}."
            )
        return body
    if body in model.joint_names:
        return model.joint_names.index(body)
    names = [b.name for b in model.bodies]
    index = model.body_index(body) if body in (*names, *model.frame_names) else -1
    if index < 0:
        raise UnknownNameError("body", body, f"{model.name!r}", names)
    return index
