"""Figures of planar arms in chapters 1 to 5: geometry, vectors, velocities, accelerations, free
bodies."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np

from freebody.any_chain.dynamics import forward_dynamics
from freebody.figures.drawing import Arrow, Drawing, Turn, point
from freebody.figures.figure import Figure, to_one_scale
from freebody.figures.layers import geometry, motion
from freebody.figures.layers.structure import clear_way
from freebody.figures.snapshot import Snapshot, snapshot
from freebody.model.planar_arms import planar
from freebody.trees.public_calls import JointVector
from freebody_notes.figures.apart import apart, inertias
from freebody_notes.figures.bodies import pinned
from freebody_notes.figures.names import called
from freebody_notes.figures.panels import GEOMETRY, RATES, SECOND, TIP, panel, two_links


def _single(before: str, n: str) -> str:
    """Subscript of a reaction force as in chapters 1 and 2: the joint's number alone."""
    return n


def arm_and_vectors(q: JointVector | None = None) -> Figure:
    """Figures 1.2 and 2.1: the arm with lengths, angles, centres of mass; and s_1, s_2, r."""
    seen = two_links(q)
    first = panel(seen, "(a) lengths, angles, centres of mass", GEOMETRY)
    second = panel(
        seen, "(b) position vectors", (geometry.links, geometry.to_tip, geometry.angles), faint=True
    )
    return _together("A planar two-link arm", first, second)


def free_bodies(q: JointVector | None = None, load: JointVector = TIP) -> Figure:
    """Figure 1.4: the arm at rest under a load F at P, and its links apart: F_1, ∓F_2, F, weights,
    torques."""
    load = [10 * x for x in np.asarray(load)]  # of the size of the weights, to be seen beside them
    seen = called(two_links(q, wrenches=load), force=_single, letter="F", load="F")
    first = panel(seen, "(a) the arm", GEOMETRY)
    second = apart(seen, ("r",), "(b) free-body diagrams of the links")
    return Figure("Free-body diagrams of a planar two-link arm", (first, second))


def statics(q: JointVector = (0.9, 0.75), load: JointVector = TIP) -> Figure:
    """Figure 2.3: a force f on the tip of the arm, without weights; its links apart: f_1, ∓f_2, f,
    τ_1, ∓τ_2."""
    seen = two_links(q, wrenches=load)
    seen = snapshot(seen.model.replace(gravity=0.0), seen.q, seen.qd, seen.qdd, load)
    seen = called(seen, force=_single)
    first = panel(seen, "(a) the arm, loaded at P", (*GEOMETRY, _tip_force))
    second = apart(seen, ("s",), "(b) the links in equilibrium")
    return Figure("Static forces on the arm and on each of its links", (first, second))


def _tip_force(drawing: Drawing, seen: Snapshot) -> None:
    """Add the external force at the tip to a drawing."""
    for load in seen.loads[-1].loads:
        if load.role == "external":
            size = float(np.linalg.norm(load.force))
            end = load.place + 0.3 * seen.size * load.force / size
            arrow = Arrow(
                point(load.place),
                point(end),
                "f",
                "external",
                "*f*",
                point(load.force),
                "N",
            )
            drawing.add(arrow)


def pendulum(
    q: JointVector = (0.85,), qd: JointVector = (1.2,), qdd: JointVector = (0.8,)
) -> Figure:
    """Figure 3.1: a bar that turns about A, with r_c and v_c; its free body."""
    seen = _bar(q, qd, qdd)
    first = _bar_panel(seen, "(a) the bar and its motion")
    first.position(np.zeros(2), seen.pose.bodies[0].com, "r_{c}", -geometry.BESIDE)
    first.add(*_velocity(seen))
    second = apart(seen, (), "(b) free-body diagram")
    return Figure("A pendulum", (first, second))


def one_link(q: JointVector = (0.85,)) -> Figure:
    """Figure 5.2: the pendulum bar with l, θ and C."""
    return Figure(
        "An arm with one degree of freedom", (_bar_panel(_bar(q, (0.0,), (0.0,)), ""),), 1
    )


def _bar(q: JointVector, qd: JointVector, qdd: JointVector) -> Snapshot:
    """Snapshot of the pendulum, a uniform bar of 1 m and 2 kg."""
    model = planar("R", l=[1.0], lc=[0.5], m=[2.0], I=[2.0 / 12])
    seen = snapshot(model.replace(name="pendulum"), q, qd, qdd)
    return called(
        seen,
        index=lambda n: "",
        letters=lambda n: "A",
        tip="B",
        force=lambda before, n: "0,1",
    )


def _bar_panel(seen: Snapshot, note: str) -> Drawing:
    drawing = panel(seen, note, GEOMETRY)
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


def dynamics(
    q: JointVector | None = None, qd: JointVector = RATES, qdd: JointVector = SECOND
) -> Figure:
    """Figure 3.2: the moving arm with θ̇_i and v_ci; its links apart, with s_i, s_ci, forces and
    torques."""
    seen = two_links(q, qd, qdd)
    velocities = partial(motion.of_centres, scaled=True)
    first = panel(seen, "(a) angles, rates, velocities", (*GEOMETRY, motion.rates, velocities))
    second = apart(seen, ("s", "sc"), "(b) free-body diagrams of the links")
    return Figure("Dynamics of a planar two-link arm", (first, second))


def recursion(
    q: JointVector | None = None, qd: JointVector = RATES, qdd: JointVector = SECOND
) -> Figure:
    """Figure 4.3: θ_i with its rates, v̇_ci, s_ci and (m_i, I_i); below, the links apart."""
    seen = two_links(q, qd, qdd)
    first = panel(seen, "(a) accelerations", (*_accelerated(), geometry.to_centres))
    second = apart(seen, ("s", "sc"), "(b) forces")
    return Figure("Accelerations and forces of a planar two-link arm", (first, second))


def energies(
    q: JointVector | None = None, qd: JointVector = RATES, qdd: JointVector = SECOND
) -> Figure:
    """Figure 5.3: the upper part of figure 4.3 with r_c1 and r_c2 from the origin."""
    seen = two_links(q, qd, qdd)
    drawing = panel(seen, "", (*_accelerated(), geometry.of_centres))
    drawing.notes = []
    return Figure("An arm with two degrees of freedom", (drawing,), 1, 460.0, 430.0)


def _accelerated() -> tuple[Callable, ...]:
    rates = partial(motion.rates, second=True)
    accelerations = partial(motion.of_centres, second=True, scaled=True)
    return (
        geometry.angles,
        geometry.lengths,
        geometry.centres,
        inertias,
        rates,
        accelerations,
    )


def fixed_axis(q: JointVector = (0.7,), force: JointVector = (8.0, 30.0)) -> Figure:
    """Figure 1.5: a body pinned at O under a force F (N) at its end; the pin's reaction f, a_G and
    α, no weight."""
    model = planar("R", l=[1.0], lc=[0.55], m=[2.0], I=[0.2]).replace(gravity=0.0, name="body")
    still = snapshot(model, q, (0.8,), (0.0,))
    wrench = [*np.asarray(force, dtype=float), 0.0]
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
