"""Figures of planar arms in chapters 1 to 5: geometry, vectors, velocities, accelerations, free
bodies."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

import numpy as np

from freebody.any_chain.dynamics import forward_dynamics
from freebody.figures.drawing import Arrow, Drawing, Turn, point
from freebody.figures.figure import Figure, to_one_scale
from freebody.figures.layers import measures, motion
from freebody.figures.layers.bare_robot import Layer, clear_way, structure
from freebody.figures.snapshot import Snapshot, snapshot
from freebody.figures.view import FLAT
from freebody.formats.loading import load
from freebody.model.planar_arms import planar
from freebody.trees.public_calls import FrameWrenchTable, JointVector
from freebody_notes.figures.apart import apart, inertias
from freebody_notes.figures.bodies import pinned
from freebody_notes.figures.pattern_names import called

_GEOMETRY: tuple[Layer, ...] = (
    measures.angles,
    measures.lengths,
    measures.centres,
)
_RATES, _SECOND = [0.9, 1.1], [1.5, 1.0]
"""Joint rates (rad/s) and accelerations (rad/s²) of the two-link arm in the figures that show its
motion."""
_TIP = [-4.5, -3.0, 0.0]
"""The tip load of section 2.4: force (N), moment (N m)."""


def _at_rest(wrenches: FrameWrenchTable = None) -> Snapshot:
    """The bundled arm 2R at rest at a pose that is seen well."""
    return snapshot(load("2R"), None, [0.0, 0.0], [0.0, 0.0], wrenches)


def _moving() -> Snapshot:
    """The bundled arm 2R in motion."""
    return snapshot(load("2R"), None, _RATES, _SECOND)


def _panel(seen: Snapshot, note: str, layers: Sequence[Layer], faint: bool = False) -> Drawing:
    """An arm with some layers, and a line of words below."""
    drawing = Drawing(FLAT, f"{seen.model.name}: {note}")
    structure(drawing, seen, faint)
    for layer in layers:
        layer(drawing, seen)
    drawing.notes = [note]
    return drawing


def _single(before: str, n: str) -> str:
    """Subscript of a reaction force as in chapters 1 and 2: the joint's number alone."""
    return n


def arm_and_vectors() -> Figure:
    """Figures 1.2 and 2.1: the arm with lengths, angles, centres of mass; and s_1, s_2, r."""
    seen = _at_rest()
    first = _panel(seen, "(a) lengths, angles, centres of mass", _GEOMETRY)
    second = _panel(
        seen,
        "(b) position vectors",
        (measures.links, measures.to_tip, measures.angles),
        faint=True,
    )
    return _together("A planar two-link arm", first, second)


def free_bodies() -> Figure:
    """Figure 1.4: the arm at rest under a load F at P, and its links apart: F_1, ∓F_2, F, weights,
    torques."""
    wrench = [10 * x for x in _TIP]  # of the size of the weights, to be seen beside them
    seen = called(_at_rest(wrench), force=_single, letter="F", load="F")
    first = _panel(seen, "(a) the arm", _GEOMETRY)
    second = apart(seen, ("r",), "(b) free-body diagrams of the links")
    return Figure("Free-body diagrams of a planar two-link arm", (first, second))


def statics() -> Figure:
    """Figure 2.3: a force f on the tip of the arm, without weights; its links apart: f_1, ∓f_2, f,
    τ_1, ∓τ_2."""
    model = load("2R").replace(gravity=0.0)
    seen = snapshot(model, (0.9, 0.75), [0.0, 0.0], [0.0, 0.0], _TIP)
    seen = called(seen, force=_single)
    first = _panel(seen, "(a) the arm, loaded at P", (*_GEOMETRY, _tip_force))
    second = apart(seen, ("s",), "(b) the links in equilibrium")
    return Figure("Static forces on the arm and on each of its links", (first, second))


def _tip_force(drawing: Drawing, seen: Snapshot) -> None:
    """Add the external force at the tip to a drawing."""
    for one in seen.loads[-1].loads:
        if one.role == "external":
            size = float(np.linalg.norm(one.force))
            end = one.place + 0.3 * seen.size * one.force / size
            arrow = Arrow(
                point(one.place),
                point(end),
                "f",
                "external",
                "*f*",
                point(one.force),
                "N",
            )
            drawing.add(arrow)


def pendulum() -> Figure:
    """Figure 3.1: a bar that turns about A, with r_c and v_c; its free body."""
    seen = _bar((1.2,), (0.8,))
    first = _bar_panel(seen, "(a) the bar and its motion")
    first.position(np.zeros(2), seen.pose.bodies[0].com, "r_{c}", -measures.BESIDE)
    first.add(*_velocity(seen))
    second = apart(seen, (), "(b) free-body diagram")
    return Figure("A pendulum", (first, second))


def one_link() -> Figure:
    """Figure 5.2: the pendulum bar with l, θ and C."""
    return Figure("An arm with one degree of freedom", (_bar_panel(_bar((0.0,), (0.0,)), ""),), 1)


def _bar(qd: JointVector, qdd: JointVector) -> Snapshot:
    """Snapshot of the pendulum at one angle, a uniform bar of 1 m and 2 kg."""
    model = planar("R", l=[1.0], lc=[0.5], m=[2.0], I=[2.0 / 12])
    seen = snapshot(model.replace(name="pendulum"), (0.85,), qd, qdd)
    return called(
        seen,
        index=lambda n: "",
        letters=lambda n: "A",
        tip="B",
        force=lambda before, n: "0,1",
    )


def _bar_panel(seen: Snapshot, note: str) -> Drawing:
    drawing = _panel(seen, note, _GEOMETRY)
    drawing.notes = [note] if note else []
    return drawing


def _velocity(seen: Snapshot) -> tuple[Arrow, Turn]:
    """The arrow of the bar's velocity v_c, and the arrow of its angular rate."""
    body = seen.pose.bodies[0]
    v = seen.velocity_at(body, body.com)
    end = body.com + 0.35 * seen.size * v / np.linalg.norm(v)
    u, w = clear_way(seen, body)
    rate = Turn(
        point(body.origin), float(seen.qd[0]), "θ\u0307", "velocity", "θ\u0307", "rad/s", 20.0,
        float(np.degrees(np.arctan2(w, u))), 150.0,
    )  # fmt: skip
    return Arrow(point(body.com), point(end), "v_{c}", "velocity", "*v*_{c}", point(v), "m/s"), rate


def dynamics() -> Figure:
    """Figure 3.2: the moving arm with θ̇_i and v_ci; its links apart, with s_i, s_ci, forces and
    torques."""
    seen = _moving()
    velocities = partial(motion.of_centres, scaled=True)
    first = _panel(seen, "(a) angles, rates, velocities", (*_GEOMETRY, motion.rates, velocities))
    second = apart(seen, ("s", "sc"), "(b) free-body diagrams of the links")
    return Figure("Dynamics of a planar two-link arm", (first, second))


def recursion() -> Figure:
    """Figure 4.3: θ_i with its rates, v̇_ci, s_ci and (m_i, I_i); below, the links apart."""
    seen = _moving()
    first = _panel(seen, "(a) accelerations", (*_accelerated(), measures.to_centres))
    second = apart(seen, ("s", "sc"), "(b) forces")
    return Figure("Accelerations and forces of a planar two-link arm", (first, second))


def energies() -> Figure:
    """Figure 5.3: the upper part of figure 4.3 with r_c1 and r_c2 from the origin."""
    seen = _moving()
    drawing = _panel(seen, "", (*_accelerated(), measures.of_centres))
    drawing.notes = []
    return Figure("An arm with two degrees of freedom", (drawing,), 1, 460.0, 430.0)


def _accelerated() -> tuple[Callable, ...]:
    rates = partial(motion.rates, second=True)
    accelerations = partial(motion.of_centres, second=True, scaled=True)
    return (
        measures.angles,
        measures.lengths,
        measures.centres,
        inertias,
        rates,
        accelerations,
    )


def fixed_axis() -> Figure:
    """Figure 1.5: a body pinned at O under a force F (N) at its end; the pin's reaction f, a_G and
    α, no weight."""
    model = planar("R", l=[1.0], lc=[0.55], m=[2.0], I=[0.2]).replace(gravity=0.0, name="body")
    still = snapshot(model, (0.7,), (0.8,), (0.0,))
    wrench = [8.0, 30.0, 0.0]
    qdd = forward_dynamics(model, still.q, still.qd, [0.0], wrenches=wrench)
    seen = snapshot(model, still.q, still.qd, qdd, wrench)
    first, second = (
        pinned(seen, "(a) applied force", False),
        pinned(seen, "(b) reaction and accelerations", True),
    )
    return _together("Rotation about a fixed axis", first, second)


def _together(title: str, *drawings: Drawing) -> Figure:
    """A figure of several drawings, brought to one scale."""
    to_one_scale(drawings)
    return Figure(title, drawings)
