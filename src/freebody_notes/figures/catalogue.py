"""Figures of the notes by number, the one table of the files of this folder: which function draws
each."""

from __future__ import annotations

from collections.abc import Callable

from freebody.errors import UnknownNameError, require_kind
from freebody.figures.figure import Figure
from freebody_notes.figures import (
    bodies,
    five_bar,
    gyro,
    links,
    planar,
    points,
    quadrotor,
    solid,
    spatial_link,
)

FIGURES: dict[str, Callable[[], Figure]] = {
    "1.1": points.trajectory,
    "1.2": planar.arm_and_vectors,
    "1.3": points.centre_of_mass,
    "1.4": planar.free_bodies,
    "1.5": planar.fixed_axis,
    "2.1": planar.arm_and_vectors,
    "2.2": five_bar.five_bar,
    "2.3": planar.statics,
    "3.1": planar.pendulum,
    "3.2": planar.dynamics,
    "4.1": links.relative_velocity,
    "4.2": links.one_of_many,
    "4.3": planar.recursion,
    "5.1": bodies.motions,
    "5.2": planar.one_link,
    "5.3": planar.energies,
    "6.1": solid.free_body,
    "6.2": gyro.gyro,
    "6.3": quadrotor.quadrotor,
    "6.4": spatial_link.link_symbols,
    "6.5": spatial_link.slide,
}


def notes_figure(number: str) -> Figure:
    """Draw the figure "3.2" (or "fig-3.2") of the notes; raises UnknownNameError.

    Its elements are data: `.named("v_{c1}")` finds one in any of its drawings, `.named("f_{1,2}",
    1)` in the second.
    """
    require_kind("notes_figure", "number", number, str, 'the number of a figure, such as "3.2"')
    key = number.removeprefix("fig-")
    if key not in FIGURES:
        raise UnknownNameError("figure", number, "the notes", FIGURES)
    return FIGURES[key]()
