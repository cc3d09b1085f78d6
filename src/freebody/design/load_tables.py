"""`floor_loads`, `load_table`: what a robot does to its foundation, to its flange, or to any of its
joints, as makers print it: each component at its greatest with the others of that instant."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from freebody.any_chain.dynamics import joint_wrenches
from freebody.arrays import Array
from freebody.by_value import ByValue
from freebody.design.drive_loads import cycle_notices, doubt_notices
from freebody.design.duty_cycle import Cycles, Segment, duty_cycles
from freebody.design.joint_loads import known_wrenches, undetermined
from freebody.design.notices import noise_notices
from freebody.errors import FreebodyError
from freebody.model.cut_fixed_joints import behind, fixed_frame, rides
from freebody.model.loops import held_by_base
from freebody.model.model import Model
from freebody.model.tree import Attached
from freebody.outputs.display import Tabled, TextTable
from freebody.spatial import of_dimension
from freebody.trees.kinematics import forward_kinematics
from freebody.trees.public_calls import checked_reference, wrenches_by_frame

LoadAxes = Literal["world", "child"]
_COMPONENTS = {2: ("fx", "fy", "m"), 3: ("fx", "fy", "fz", "mx", "my", "mz")}


@dataclass(frozen=True, eq=False, repr=False)
class LoadTable(Tabled, ByValue):
    """Forces and moments at one place of a robot over duty cycles: by what is behind the place on
    what is before it, such as by the robot on the floor, by a tool on the flange."""

    model: Model
    place: str
    """"floor", or the name of a joint or frame."""
    axes: LoadAxes
    """Axes of the components: the world's, or those of the joint's child, of the frame."""
    wrench: Array
    """(T, 6), in the plane (T, 3): force (N), then moment (N m) about the place's origin, at the
    samples of all cycles, one after another; NaN where rigid bodies do not determine it."""
    cycle: Array
    """(T,), the number of each sample's cycle, from 0."""
    time: Array
    """(T,), s since that cycle began."""
    notices: tuple[str, ...] = ()

    @property
    def rows(self) -> tuple[str, ...]:
        """Names of the rows of `greatest`: each component, the whole force, the whole moment."""
        whole = ("force", "moment") if self.model.dim == 3 else ("force",)
        return (*_COMPONENTS[self.model.dim], *whole)

    @property
    def instants(self) -> np.ndarray:
        """Index (rows,) of the sample at which each row is greatest in magnitude."""
        d = self.model.dim
        known = np.nan_to_num(self.wrench)
        sizes = [*np.abs(known).T, np.linalg.norm(known[:, :d], axis=1)]
        if d == 3:
            sizes.append(np.linalg.norm(known[:, d:], axis=1))
        return np.argmax(np.array(sizes), axis=1)

    @property
    def greatest(self) -> Array:
        """(rows, 6), in the plane (rows, 3): the wrench at the sample where the component, or the
        size of force or moment, is greatest in magnitude."""
        return self.wrench[self.instants]

    def _rounded(self, wrench: Array) -> Array:
        """Wrenches without what rounding alone leaves."""
        none = _NOTHING * np.abs(np.nan_to_num(self.wrench)).max(initial=0.0)
        return np.where(np.abs(wrench) <= none, 0.0, wrench)

    def _title(self) -> str:
        d = self.model.dim
        most = [
            np.linalg.norm(x, axis=1).max() for x in np.split(self._rounded(self.wrench), [d], 1)
        ]
        of = "Floor" if self.place == FLOOR else f"Loads at {self.place!r}"
        return f"{of} of {self.model.name!r}: at most {most[0]:.4g} N and {most[1]:.4g} N m"

    def _table(self) -> TextTable:
        names = _COMPONENTS[self.model.dim]
        units = [f"{name} (N{' m' if name[0] == 'm' else ''})" for name in names]
        rows = [
            (
                name,
                *(f"{x:.4g}" for x in self._rounded(self.wrench[k])),
                f"{self.time[k]:.4g} s",
                str(self.cycle[k] + 1),
            )
            for name, k in zip(self.rows, self.instants, strict=True)
        ]
        words = {"world": "World axes.", "child": f"Axes of {self.place!r}."}
        return TextTable(
            ("greatest", *units, "at", "of cycle"), rows, (words[self.axes], *self.notices)
        )


FLOOR = "floor"
"""The place below the base."""
_NOTHING = 1e-12
"""Share of the largest component that is printed as none: what rounding leaves."""


def floor_loads(model: Model, cycles: Cycles) -> LoadTable:
    """Forces and moments that a robot exerts on its foundation over duty cycles: each component at
    its greatest, with the others of that instant; the weight of its base included.

    Parameters
    ----------
    model
        The robot with its drives, open or closed, on a fixed base.
    cycles
        A DutyCycle or a Motion, or a list of those.

    Returns
    -------
    LoadTable
        At the origin of the base, world axes.

    Raises
    ------
    FreebodyError
        A base that is free.
    """
    if len(held_by_base(model)) < len(model.bodies):
        raise FreebodyError(
            f"floor_loads: the base of {model.name!r} is free and stands on nothing."
        )
    return _tabled("floor_loads", model, cycles, FLOOR, "world", lambda x: _on_floor(model, x))


def load_table(
    model: Model, cycles: Cycles, at: str | None = None, *, reference: LoadAxes = "child"
) -> LoadTable:
    """Forces and moments on a robot's flange by what it carries, or at a joint by all behind it,
    over duty cycles: each component at its greatest, with the others of that instant.

    Parameters
    ----------
    model
        The robot with its drives.
    cycles
        A DutyCycle or a Motion, or a list of those, with payloads and wrenches.
    at
        The frame of the flange: the load of all that is fixed to it, payloads, tools, links.
        Default: the tip. Or the name of a joint or loop: the load that its parent bears. Of a
        frame that is a body's own, or behind which a loop ends: of what is carried in it alone.
    reference
        "child": the frame's axes, those of the joint's child or of the loop's second frame; or
        "world".

    Returns
    -------
    LoadTable
        At the frame's or joint's origin, by what is behind it on what is before it.

    Raises
    ------
    FreebodyError, UnknownNameError
    """
    checked_reference(reference, ("world", "child"))
    place, remarks = model.frame().name if at is None else at, ()
    if at is None or at not in model.reaction_names:
        fixed = {frame.name for frame in model.frames if not frame.parent}
        place = place if place in fixed else fixed_frame(model, place, "load_table").name
        if _carries_alone(model, place):
            remarks = (
                f"Of what is carried in {place!r} alone: links and loops that end there cannot be "
                f"told from it. The name of a joint has all behind it.",
            )
    found = _tabled(
        "load_table", model, cycles, place, reference, lambda x: _behind(model, x, place, reference)
    )
    return replace(found, notices=(*remarks, *found.notices))


def _tabled(
    function: str,
    model: Model,
    cycles: Cycles,
    place: str,
    axes: LoadAxes,
    wrench: Callable[[Segment], Array],
) -> LoadTable:
    """The table of wrenches (T, 6 or 3) that a function gives of each segment."""
    done = duty_cycles(function, model, cycles)
    parts: list[tuple[Array, Array, np.ndarray]] = []
    for k, cycle in enumerate(done):
        begun = 0.0
        for segment in cycle.segments:
            found, t = wrench(segment), segment.motion.t - segment.motion.t[0]
            rest = t[-1:] if segment.dwell > 0.0 else t[:0]
            parts.append((found, begun + np.append(t, rest), np.full(len(found), k)))
            begun += segment.duration
    wrenches, times, numbers = (np.concatenate(x) for x in zip(*parts, strict=True))
    open_one = [place] if np.isnan(wrenches).any() else []
    notices = (
        *doubt_notices(model),
        *noise_notices(model, done),
        *cycle_notices(done),
        *undetermined(open_one),
    )
    return LoadTable(model, place, axes, wrenches, numbers, times, notices)


# ------------------------------------------------------------ the floor
def _on_floor(model: Model, segment: Segment) -> Array:
    """Wrenches (T, 6 or 3): the opposite of what holds the bodies, the weight of the base, and what
    acts on it.

    Struts and loops are left out: what they take from some bodies they give to others or to the
    base, so the sum is the same.
    """
    q, qd, qdd, wrenches, _ = segment.states()
    d, loaded = model.dim, segment.carried_by(model).opened.without("struts")
    reactions = joint_wrenches(loaded, q, qd, qdd, wrenches)
    total = np.zeros((len(q), reactions.shape[-1]))

    def add(at: Array, wrench: Array) -> None:
        force = np.broadcast_to(wrench[..., :d], (len(q), d))
        total[:, :d] += force
        total[:, d:] += wrench[..., d:] + _moment(np.broadcast_to(at, (len(q), d)), force)

    for k, body in enumerate(model.bodies):
        if body.parent < 0:
            add(forward_kinematics(loaded, q, body.name)[:, :d, d], -reactions[:, k])
    weightless = np.zeros(total.shape[1] - d)
    for mass in loaded.tree.base:
        weight = float(mass.m) * np.asarray(model.gravity, dtype=float)
        add(np.asarray(mass.c, dtype=float), np.concatenate([weight, weightless]))
    for name, wrench in wrenches_by_frame("floor_loads", model, wrenches).items():
        if model.frame(name).body < 0:
            add(forward_kinematics(loaded, q, name)[:, :d, d], wrench)
    return total


def _moment(at: Array, force: Array) -> Array:
    """Moments (T, 3 or 1) of forces (T, dim) at points (T, dim)."""
    found = of_dimension(at.shape[1]).moment(tuple(at.T), tuple(force.T))
    return np.stack([np.asarray(x) for x in found], axis=-1)


# ------------------------------------------------------------ flanges and joints
def _behind(model: Model, segment: Segment, place: str, reference: LoadAxes) -> Array:
    """Wrenches (T, 6 or 3) of what is behind a place on what is before it; NaN where a closed chain
    leaves a component open."""
    q, qd, qdd, wrenches, _ = segment.states()
    loaded = segment.carried_by(model)
    if place not in model.reaction_names:
        apart, name = _with_seam(loaded, place), place
        if _SEAM in apart.frame_names:
            name = _SEAM
            loads = wrenches_by_frame("load_table", model, wrenches)
            wrenches = {_SEAM if x == place else x: load for x, load in loads.items()}
        return -joint_wrenches(apart, q, qd, qdd, wrenches, reference, name)
    known = known_wrenches(loaded, q, qd, qdd, wrenches, reference)
    return -known[:, loaded.reaction_names.index(place)]


_SEAM = "flange, apart from its link"


def _carries_alone(model: Model, place: str) -> bool:
    """Whether a place is a body's own frame, or a loop ends behind it, so that only what is carried
    in it can be told from the body."""
    frame, ends = model.frame(place), {name for loop in model.loops for name in loop.frames}
    return not (frame.parent and ends.isdisjoint(behind(model, place)))


def _with_seam(model: Model, place: str) -> Model:
    """The open chain of a model, with what is carried at a place of that kind in a frame fixed to
    it."""
    if not _carries_alone(model, place):
        return model.opened
    found = model.opened.with_frame(_SEAM, frame=place)

    def moved(parts: tuple[Attached, ...]) -> tuple[Attached, ...]:
        return tuple(replace(x, frame=_SEAM) if x.load and rides(x, {place}) else x for x in parts)

    bodies = tuple(replace(body, inertias=moved(body.inertias)) for body in found.bodies)
    return replace(found, bodies=bodies, base_inertias=moved(found.base_inertias))
