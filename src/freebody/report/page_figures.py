"""The figures of the report."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from freebody.errors import listed
from freebody.figures.body_loads import BodyLoads
from freebody.figures.free_body import PANEL, TALLEST, diagrams
from freebody.figures.kinematic import robot_drawing
from freebody.figures.plane_map import plane_map
from freebody.figures.plots import Plot, plot
from freebody.figures.snapshot import snapshot
from freebody.figures.svg import Picture, picture
from freebody.motion.ranges import ranges as allowed
from freebody.outputs.number_text import significant
from freebody.report.lifting import chart, lifting_along, lifting_over_plane
from freebody.report.page_tables import carrying, following
from freebody.report.printed_columns import EVERYDAY
from freebody.report.tables import shortened
from freebody.report.variables import PARTS

if TYPE_CHECKING:
    import xarray as xr

    from freebody.report.study import Study


TOTAL = "total"
MEASURED = "measured"
"""The name of a measured curve."""
_TOGETHER = 8  # curves that one picture holds
_SEEN = 1e-4  # of the largest: a part that is smaller is no line of its own
_FLAT = 1e-2  # of the largest: what is smaller cannot be told from zero beside it
_NOISE = 1e-9  # of the largest torque: what is smaller is rounding
_NAMED = 6  # joints that a caption names
_HERO = (460.0, 400.0)  # of the robot, pixels


@dataclass(frozen=True)
class CaptionedDrawing:
    """A picture with its caption."""

    picture: Picture
    caption: str = ""
    plot: Plot | None = None
    """The curves of the drawing, where they are over the time of the motion."""
    number: int | None = None
    """Its number among those that follow the cursor of a page."""
    body: str = ""
    """The body that it shows alone."""

    @property
    def title(self) -> str:
        """A name for the drawing: of a body, a joint or a quantity."""
        return self.body or (self.picture.title if self.plot is None else self.plot.title)

    @property
    def svg(self) -> str:
        """SVG text for a page, which has the style sheet."""
        return self.picture.text(css=False)


def robot(study: Study) -> CaptionedDrawing:
    """The drawing of the robot at the worst instant, with earlier and later poses."""
    model, q = study.model, study.motion.q
    count, worst = len(study.motion.t), study.worst
    others = {count * k // 4 for k in (range(4) if len(model.bodies) <= 12 else (1, 3))}
    ghosts = [q[k] for k in sorted(others - {worst.index})]
    path, words = None, ""
    if study.tip is not None:
        path = path_of_tip(study)
        words = f" Orange: the path of {study.tip}."
    drawing = picture(robot_drawing(model, q[worst.index], ghosts, path), *_HERO)
    return CaptionedDrawing(
        drawing,
        f"At the worst instant, t = {worst.time:.3g} s; paler, other poses of the motion.{words}",
    )


def path_of_tip(study: Study) -> np.ndarray:
    """Places (k, dim) that the tip passes, m, as many as a line needs."""
    return study.data["tip_position"].values[:: max(1, len(study.motion.t) // 240)]


def free_bodies(study: Study) -> tuple[list[CaptionedDrawing], tuple[BodyLoads, ...]]:
    """The diagram of each body at the worst instant, and the loads they show."""
    k, m = study.worst.index, study.motion
    seen = snapshot(study.model, m.q[k], m.qd[k], m.qdd[k], study.wrenches)
    drawn = zip(diagrams(seen, seen.loads), seen.loads, strict=True)
    return [
        CaptionedDrawing(
            picture(drawing, PANEL, TALLEST), body=study.model.bodies[loads.body.index].name
        )
        for drawing, loads in drawn
    ], seen.loads


def motion(study: Study) -> Iterator[CaptionedDrawing]:
    """Plots of positions, rates and accelerations over time, in a closed chain of what is
    driven."""
    there = set(following(study))
    yield from _moved(study, lambda joint: joint not in there)


def followers(study: Study) -> Iterator[CaptionedDrawing]:
    """Plots of the motion of those joints of a closed chain that no drive moves."""
    there = set(following(study))
    yield from _moved(study, lambda joint: joint in there)


def _moved(study: Study, shown: Callable[[str], bool]) -> Iterator[CaptionedDrawing]:
    for variable, what, suffix in (
        ("q", "Position", ""), ("qd", "Speed", "/s"), ("qdd", "Acceleration", "/s²"),
    ):  # fmt: skip
        names = map(str, study.data[variable].coords[_dim(study, variable)].values)
        joints = _joints(study)
        only = [name for name in names if shown(joints[name])]
        yield from _overlays(study, variable, what, suffix, only=only)


def torques(study: Study) -> Iterator[CaptionedDrawing]:
    """Plots of each coordinate's torque with the parts that it has there, its limits, and what was
    measured."""
    data, limits = study.data, allowed(study.model).effort
    shown = parts(study)
    if "tau_measured" in data:
        shown["tau_measured"] = MEASURED
    colours = {words: k for k, words in enumerate(shown.values())}
    units = data["effort_unit"].values
    for name in study.model.driven_names:
        k = study.model.velocity_names.index(name)
        curves = {words: data[variable].values[:, k] for variable, words in shown.items()}
        there = _SEEN * np.abs(curves[TOTAL]).max()
        curves = {
            words: curve
            for words, curve in curves.items()
            if words == TOTAL or np.nanmax(np.abs(curve), initial=0.0) > there
        }
        bounds = (-float(limits[k]), float(limits[k])) if np.isfinite(limits[k]) else ()
        yield _plot(study, name, curves, str(units[k]), limits=bounds, peaks=True, colours=colours)


def parts(study: Study) -> dict[str, str]:
    """The variables of the torque and of those of its parts that are not zero, with their names in
    print."""
    there = {
        x: words
        for x, words in PARTS.items()
        if x in study.data and np.abs(study.data[x].values).max() > 0
    }
    return {"tau": TOTAL, **there}


def powers(study: Study) -> Iterator[CaptionedDrawing]:
    """Plots of the mechanical power of each drive and of all together."""
    data = study.data
    for group in _groups(study.model.driven_names):
        curves = {short: data["power"].sel(coordinate=name).values for name, short in group}
        yield _plot(study, "Power of each drive", curves, "W")
    yield _single(study, "Power of all drives", "all", data["motor_power"].values, "W")


def energies(study: Study) -> Iterator[CaptionedDrawing]:
    """The plot of the energies."""
    data = study.data
    kinetic, potential = data["kinetic_energy"].values, data["potential_energy"].values
    start = float(potential[0])
    curves = {"kinetic": kinetic, "potential": potential - start}
    curves["total"] = kinetic + potential - start
    yield _plot(study, "Energy relative to the start", curves, "J")


def residual(study: Study) -> Iterator[CaptionedDrawing]:
    """The plot of the error of the energy balance."""
    curve = study.data["energy_residual"].values
    yield _single(study, "Residual of the energy balance", "residual", curve, "J")


def kinematics(study: Study) -> Iterator[CaptionedDrawing]:
    """Plots of the tip's path and speed, and of how near the arm is to a singular pose; none
    without a tip."""
    data, singularity = study.data, study.singularity
    if singularity is None:
        return
    position = data["tip_position"]
    curves = {str(a): position.sel(axis=a).values for a in position["axis"].values}
    yield _plot(study, f"Position of {study.tip}", curves, "m")
    speed = np.linalg.norm(data["tip_velocity"].values, axis=-1)
    yield _single(study, f"Speed of {study.tip}", "speed", speed, "m/s")
    smallest = data["smallest_singular_value"]
    curve = {"smallest singular value": smallest.values}
    yield _plot(study, "Smallest singular value", curve, "1/rad", names=False, now=singularity.time)


def gravity(study: Study) -> Iterator[CaptionedDrawing]:
    """Plots of the torques that gravity causes."""
    load = np.abs(study.data["tau_gravity"].values).max(axis=0)
    felt = load > _NOISE * np.abs(study.data["tau"].values).max()
    names = [x for x, there in zip(study.model.velocity_names, felt, strict=True) if there]
    yield from _overlays(study, "tau_gravity", "Gravity load", "", "effort_unit", names)


def lifting(study: Study) -> Iterator[CaptionedDrawing]:
    """The plot of the largest payload along the motion, and its map over a plane."""
    mass = lifting_along(study)
    if mass is None:
        return
    least = int(np.argmin(mass))
    curve = _plot(study, "Largest payload at rest", {"payload": mass}, "kg", names=False)
    words = (
        f"The largest mass at {study.tip}, beyond what the robot carries already, that its drives "
        f"hold at rest within their limits; friction does not count. At least "
        f"{significant(float(mass[least]))} kg, at t = {study.motion.t[least]:.3g} s."
    )
    yield replace(curve, caption=words)
    found = lifting_over_plane(study)
    if found is not None:
        yield CaptionedDrawing(
            plane_map(chart(study, found)),
            f"In the upright plane of the worst instant, {study.tip} {found.words}; at each point "
            f"the best of all postures that reach it. Blank points are out of reach within the "
            f"joint limits; beyond the last contour the payload is larger.",
        )


def reactions(study: Study) -> Iterator[CaptionedDrawing]:
    """Plots of the magnitude of each joint's reaction, where it can be told from zero."""
    for variable, what, unit in (
        ("reaction_force", "Reaction force", "N"),
        ("reaction_moment", "Reaction moment", "N m"),
    ):
        names = carrying(study)
        size = np.linalg.norm(study.data[variable].sel(joint=list(names)).values, axis=-1)
        peaks = size.max(axis=0)
        there = peaks > _FLAT * peaks.max(initial=0.0)
        flat = [name for name, seen in zip(names, there, strict=True) if not seen]
        drawn = [name for name in names if name not in flat]
        words = f"Not drawn, below 1 % of the largest: {listed(flat, _NAMED)}." if flat else ""
        for group in _groups(drawn):
            curves = {short: size[:, names.index(name)] for name, short in group}
            yield replace(_plot(study, what, curves, unit), caption=words)
            words = ""


def drift(study: Study) -> Iterator[CaptionedDrawing]:
    """The plot of the open-loop run's distance from the reference."""
    replay = study.replay
    if replay is None or len(replay.drift_time) < 2:
        return
    off = np.abs(replay.drift).max(axis=1)
    floor = max(float(off[off > 0].min(initial=1e-16)), 1e-16)
    curve = {"largest of all coordinates": np.maximum(off, floor)}
    what = Plot(
        "Open loop: distance from the motion",
        replay.drift_time,
        curve,
        "rad, m",
        names=False,
        log=True,
    )
    yield CaptionedDrawing(plot(what))


def _overlays(
    study: Study, variable: str, what: str, suffix: str, unit_name: str = "unit",
    only: Collection[str] | None = None,
) -> Iterator[CaptionedDrawing]:  # fmt: skip
    """Plots of a variable for coordinates of one unit together, at most eight in each, those of a
    joint of several coordinates by themselves; only: those that are shown, default all."""
    array, dim = study.data[variable], _dim(study, variable)
    joints, several = _joints(study), _several(study)
    groups: dict[tuple[str, str], list[str]] = {}
    for name, unit in _units(study, array, dim, unit_name):
        if only is None or name in only:
            owner = f" of {joints[name]}" if joints[name] in several else ""
            groups.setdefault((owner, unit), []).append(name)
    for (owner, unit), names in groups.items():
        title = f"Quaternion{owner}" if unit == "1" else what + owner
        for group in _groups(names):
            curves = {short: array.sel({dim: name}).values for name, short in group}
            yield _plot(study, title, curves, unit + suffix)


def _dim(study: Study, variable: str) -> str:
    return "position" if "position" in study.data[variable].dims else "coordinate"


def _joints(study: Study) -> dict[str, str]:
    """The joint of each position and of each rate, by name."""
    model = study.model
    return {
        name: body.joint.name
        for body, at in zip(model.bodies, model.coordinates, strict=True)
        for names, entries in ((model.position_names, at.q), (model.velocity_names, at.v))
        for name in (names[k] for k in entries)
    }


def _several(study: Study) -> set[str]:
    """The joints of several coordinates, which are drawn by themselves."""
    return {body.joint.name for body in study.model.bodies if body.kind.nv > 1}


def _units(
    study: Study, array: xr.DataArray, dim: str, unit_name: str
) -> Iterator[tuple[str, str]]:
    """Pairs (name, unit) along a dimension; entries of quaternions have no unit."""
    known = dict(zip(study.model.velocity_names, study.data[unit_name].values, strict=True))
    for name in map(str, array[dim].values):
        yield name, str(known.get(name, "1" if ".quat_" in name else "m"))


def _groups(names: Sequence[str]) -> Iterator[Sequence[tuple[str, str]]]:
    """Groups of at most eight and about equal size: pairs of a name and its text in a legend."""
    called = list(zip(names, shortened(names), strict=True))
    count = -(-len(names) // _TOGETHER)
    size = -(-len(names) // count) if count else 1
    for k in range(0, len(names), size):
        yield called[k : k + size]


def _single(study: Study, title: str, name: str, curve: np.ndarray, unit: str) -> CaptionedDrawing:
    """A plot of a single curve with its peak marked."""
    return _plot(study, title, {name: curve}, unit, names=False, peaks=True)


def _plot(
    study: Study, title: str, curves: dict[str, np.ndarray], unit: str, *,
    limits: tuple[float, ...] = (),
    names: bool = True, peaks: bool = False, now: float | None = None,
    colours: dict[str, int] | None = None,
) -> CaptionedDrawing:  # fmt: skip
    at = study.worst.time if now is None else now
    also = EVERYDAY[unit] if unit.startswith("rad") and unit in EVERYDAY else None
    what = Plot(
        title, study.motion.t, curves, unit, limits, at, peaks, names, colours=colours, also=also
    )
    return CaptionedDrawing(plot(what), plot=what)


def numbered(
    plots: dict[str, list[CaptionedDrawing]],
) -> tuple[dict[str, list[CaptionedDrawing]], list[Plot]]:
    """The figures of a page with numbers on those that are curves over the motion, and what these
    show."""
    found: list[Plot] = []

    def one(figure: CaptionedDrawing) -> CaptionedDrawing:
        if figure.plot is None:
            return figure
        found.append(figure.plot)
        return replace(figure, number=len(found) - 1)

    return {name: list(map(one, figures)) for name, figures in plots.items()}, found


PLOTS = (
    kinematics, gravity, lifting, motion, followers, torques, powers, energies, reactions, drift,
    residual,
)  # fmt: skip
"""Figures of the page, by the names of their functions."""
