"""`load_diagram`: the largest payload over the distance of its centre of mass from the flange, a
curve for each limit of a drive, brake or bearing, as makers of robots print it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from freebody.arrays import Array, as_floats, refuse_not_finite
from freebody.by_value import ByValue
from freebody.capacity.payload import payload
from freebody.capacity.payload_limits import by_limits
from freebody.design.drive_loads import ChosenDrives
from freebody.design.parts import Bearing
from freebody.errors import FreebodyError, ShapeError, UnknownNameError
from freebody.figures.figure import Pictured
from freebody.figures.plots import Plot, plot
from freebody.figures.svg import Picture
from freebody.model.doubts import Doubt, attribute, in_one_line, named
from freebody.model.model import Model
from freebody.motion.motion import Motion
from freebody.outputs.display import Tabled, TextTable
from freebody.outputs.number_text import rounded_down
from freebody.reach.labelled_maps import labelled
from freebody.trees.public_calls import FrameWrenchTable, JointVector

if TYPE_CHECKING:
    import xarray as xr

_OFFSETS = 25
_FAR = 0.5
"""m: the farthest offset where none is given."""
_HIGH = 1.6
"""Height of the diagram, as a multiple of the largest payload."""


@dataclass(frozen=True, eq=False, repr=False)
class LoadDiagram(Tabled, ByValue, Pictured):
    """The largest payload over the offset of its centre of mass.

    offsets: (k,), m along an axis of the frame. by_joint: (k, K), kg, at which each joint alone
    reaches its limit, infinite where none does. joint: (k,), index of the one that limits, -1
    without one. joint_names, limits, parts: (K,), as of `fb.payload`. frame, along: its name and
    the axis. doubts: those on the robot's masses, drives and effort limits.
    """

    offsets: Array
    by_joint: Array
    joint: np.ndarray
    joint_names: tuple[str, ...]
    limits: tuple[str, ...]
    parts: tuple[str, ...]
    frame: str
    along: str
    doubts: tuple[Doubt, ...] = ()
    _aside = ("doubts",)
    caller = "load_diagram"

    @property
    def mass(self) -> Array:
        """The largest payload (k,) at each offset, kg."""
        return np.asarray(self.by_joint.min(axis=-1))

    @property
    def by(self) -> str:
        """Words on what is counted, as of `fb.payload`."""
        return by_limits(self.limits)

    @property
    def picture(self) -> Picture:
        """The diagram: mass over offset in mm, a curve for each part that limits somewhere, or
        nearly; what lies below all of them is carried."""
        mass = self.mass
        top = _HIGH * float(mass[np.isfinite(mass)].max(initial=0.0))
        curves = {
            name: np.where(own <= top, own, np.nan)
            for name, own in zip(self.parts, self.by_joint.T, strict=True)
            if (own <= top).sum() > 1
        } or {"nothing limits": np.full(len(mass), np.nan)}
        title = f"Largest payload over its offset along {self.along} of {self.frame}, {self.by}"
        across = "offset in mm"
        size = (460.0, 300.0)
        return plot(
            Plot(title, 1e3 * self.offsets, curves, "kg", peaks=False, across=across, size=size)
        )

    def to_xarray(self) -> xr.Dataset:
        """A labelled dataset over the offsets."""
        names, limits = (np.array([*x, ""])[self.joint] for x in (self.joint_names, self.limits))
        each = "mass at which it reaches its limit"
        return labelled(
            {
                "mass": (("offset",), self.mass, "kg", "largest payload"),
                "by_joint": (("offset", "coordinate"), self.by_joint, "kg", each),
                "joint": (("offset",), names, "1", "joint that limits it"),
                "limit": (("offset",), limits, "1", "limit that it reaches there"),
            },
            {
                "offset": (("offset",), self.offsets, "m", f"along {self.along} of {self.frame}"),
                "coordinate": (("coordinate",), np.array(self.parts), "1", "what has a limit"),
            },
            {"frame": self.frame, **attribute(self.doubts)},
        )

    def _title(self) -> str:
        return (
            f"Load diagram: {_carried(self.mass[0])} at {1e3 * self.offsets[0]:.4g} mm to "
            f"{_carried(self.mass[-1])} at {1e3 * self.offsets[-1]:.4g} mm along {self.along} of "
            f"{self.frame!r}, {self.by}{named(self.doubts)}"
        )

    def _table(self) -> TextTable:
        names = [*self.parts, "none"]
        rows = [
            (f"{1e3 * at:.4g}", f"{mass:.4g}", names[k])
            for at, mass, k in zip(self.offsets, self.mass, self.joint, strict=True)
        ]
        notes = [in_one_line(self.doubts)] if self.doubts else []
        return TextTable(("offset (mm)", "payload (kg)", "what limits it"), rows, notes)


def _carried(mass: float) -> str:
    """A mass in words, rounded down: it is promised."""
    return f"{rounded_down(float(mass))} kg" if np.isfinite(mass) else "any mass"


def load_diagram(
    model: Model,
    motion: Motion | Sequence[Motion] | JointVector,
    *,
    offsets: ArrayLike | None = None,
    along: str | None = None,
    frame: str | None = None,
    wrenches: FrameWrenchTable = None,
    effort: JointVector | None = None,
    brakes: ChosenDrives | None = None,
    bearings: Mapping[str, Bearing] | None = None,
) -> LoadDiagram:
    """The largest payload, a point, over its offset from the frame's origin along one of its axes.

    Parameters
    ----------
    model, motion, frame, wrenches, effort, brakes, bearings
        As for `fb.payload`: of several motions or postures the least payload counts, such as over
        `fb.random_state(model, seed, 10**5)[0]`.
    offsets
        (k,), m, at least two, increasing; default 25 from 0 to 0.5.
    along
        The frame's axis, "x", "y", or "z"; default "z", in the plane "x".

    Returns
    -------
    LoadDiagram
        With `.svg` and `.save("loads.svg")`.

    Raises
    ------
    FreebodyError, PassiveJointError, KindError, ShapeError, NotFiniteError, UnknownNameError
        As `fb.payload`; offsets that do not increase; an axis that there is not.
    """
    function, axes = "load_diagram", ("x", "y", "z")[: model.dim]
    axis = along or axes[-1 if model.dim == 3 else 0]
    if axis not in axes:
        raise UnknownNameError("axis", axis, f"{function}: along=", axes)
    given = np.linspace(0.0, _FAR, _OFFSETS) if offsets is None else offsets
    places = as_floats(function, "offsets", given)
    if places.ndim != 1 or len(places) < 2:
        raise ShapeError(function, "offsets", places.shape, "(k,)", "at least two, along an axis")
    refuse_not_finite(function, "offsets", places, 0)
    if not (np.diff(places) > 0.0).all():
        raise FreebodyError(f"{function}: offsets must increase; got {places.tolist()}.")
    unit = np.array([float(name == axis) for name in axes])
    found = [
        payload(
            model, motion, com=x * unit, frame=frame, wrenches=wrenches, effort=effort,
            brakes=brakes, bearings=bearings,
        )
        for x in places
    ]  # fmt: skip
    if not found[0].mass.size:
        raise FreebodyError(f"{function}: there are no postures; give at least one.")
    by_joint = np.array([x.by_joint.reshape(-1, len(x.joint_names)).min(axis=0) for x in found])
    free = np.isinf(by_joint.min(axis=-1))
    return LoadDiagram(
        places,
        by_joint,
        np.where(free, -1, np.argmin(by_joint, axis=-1)).astype(int),
        found[0].joint_names,
        found[0].limits,
        found[0].parts,
        found[0].frame,
        axis,
        found[0].doubts,
    )
