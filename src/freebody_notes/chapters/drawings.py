"""Checks of the notes' figures: each figure is drawn from a model and its quantities are read back
from the drawing."""

from __future__ import annotations

import re
from collections.abc import Mapping

import numpy as np

from freebody_notes.checks import ByFunction
from freebody_notes.checks.figure import Caption, Drawn, Facts, Panel
from freebody_notes.figures.catalogue import notes_figure
from freebody_notes.item import Outcome


def trajectory(p: Panel):
    """Vectors read from figure 1.1: whether v(t) is parallel to the tangent of the curve at P."""
    points = p.points("Γ")
    k = int(np.argmin(np.linalg.norm(points - p.start("P"), axis=1)))
    k = min(max(k, 1), len(points) - 2)
    tangent, v = points[k + 1] - points[k - 1], p.span("v(t)")
    cosine = tangent @ v / np.linalg.norm(tangent) / np.linalg.norm(v)
    return {
        "r_start": p.start("r(t)"),
        "r_end": p.end("r(t)"),
        "P": p.start("P"),
        "v_start": p.start("v(t)"),
        "cosine": round(cosine, 3),
    }


def arm_vectors(p: Panel):
    return {
        "s1": p.span("s_1"), "s2": p.span("s_2"), "r": p.span("r"), "OA": p.span("link 1"),
        "AP": p.span("link 2"), "C1": p.start("C_1"), "A": p.end("link 1"), "r_end": p.end("r"),
        "P": p.start("P"), "angle1": p.direction("θ_1"), "angle2": p.direction("θ_2"),
        "theta1": p.of("θ_1"),
    }  # fmt: skip


def cloud(p: Panel):
    spread = [p.span(f"ρ_{k}", 1) for k in range(1, 6)]
    seen = [p.span(f"r_{k}", 0) for k in range(1, 6)]
    return {
        "r_G": p.span("r_{G}", 0), "G": p.start("G", 0), "O": p.start("O", 0), "r_1": seen[0],
        "m_1": p.start("m_1", 0), "G_there": p.start("G", 1), "rho_1": spread[0],
        "nothing": np.zeros(2),
    }  # fmt: skip


def pairs(p: Panel, on1="−F_{2}", on2="F_{2}", base="F_{1}"):
    """Forces and moments at the elbow of a drawn arm, read from the drawing: on1 and on2 are
    opposite; and the point at which the base's force acts."""
    return {
        "on1": p.span(on1, 1), "on2": p.span(on2, 1), "turn1": p.of("−τ_2", 1),
        "turn2": p.of("τ_2", 1), "base": p.start(base, 1), "O": p.start("joint 1", 1),
        "down": p.of("m_1 g", 1)[0], "at2": p.start(on2, 1), "A": p.start("link 2", 1),
        "arrow": p.along(on2, 1),
    }  # fmt: skip


def dynamic_pairs(p: Panel):
    return pairs(p, "−f_{1,2}", "f_{1,2}", "f_{0,1}")


def fixed_axis(p: Panel):
    arm, a_G = p.start("G", 1) - p.start("O", 1), p.of("a_G", 1)
    across = np.array([-arm[1], arm[0]]) / (arm @ arm)
    return {
        "f_start": p.start("f", 1), "O": p.start("O", 1), "a_start": p.start("a_G", 1),
        "G": p.start("G", 1), "tangential": float(a_G @ across), "alpha": p.of("α", 1),
    }  # fmt: skip


def five_bar(p: Panel):
    at = {name: p.start(name, 0) for name in "ABCDP"}
    return at | {
        "O": np.zeros(2), "AB": p.span("AB", 1), "CD": p.span("CD", 1), "AP": p.span("AP", 1),
        "CP": p.span("CP", 1), "BP": p.span("link 3", 0), "DP": p.span("link 4", 0),
    }  # fmt: skip


def pendulum(p: Panel):
    weight = p.of("m g", 1)
    return {
        "r_c": p.span("r_{c}", 0), "v_c": p.span("v_{c}", 0), "C": p.start("C", 0),
        "A": p.start("joint 1", 0), "B": p.start("B", 0), "f_start": p.start("f_{0,1}", 1),
        "A_free": p.start("joint 1", 1), "sideways": weight[0], "weight": p.along("m g", 1),
    }  # fmt: skip


def speeds(p: Panel):
    """Velocity arrows read from a figure, and the arm's velocities; v_c1 is perpendicular to the
    first link at C₁."""
    return dynamic_pairs(p) | {
        "v_start": p.start("v_{c1}", 0), "C1": p.start("C_1", 0),
        "across": float(p.span("v_{c1}", 0) @ p.span("link 1", 0)),
        "v2_start": p.start("v_{c2}", 0), "C2": p.start("C_2", 0), "along2": p.along("v_{c2}", 0),
    }  # fmt: skip


def velocity_labels(form: str) -> Outcome:
    """Whether the velocity arrow that a formula names starts at the centre of mass of the outer
    link."""
    p = Panel(notes_figure("3.2"))
    label = re.findall(r"v_c(\d)", form)[-1]
    same = np.allclose(p.start(f"v_{{c{label}}}", 0), p.start("C_2", 0))
    return Outcome(bool(same), (f"The arrow v_c{label} starts at {'C_2' if same else 'C_1'}.",))


def relative(p: Panel):
    return {
        "v_A": p.span("v_A", 1), "v_B": p.span("v_B at A", 1), "turn": p.span("ω × s", 1),
        "s": p.span("s", 1), "A": p.start("A", 1), "tip": p.start("v_A", 1),
        "B": p.start("joint 2", 0), "v_start": p.start("v_B", 0),
    }  # fmt: skip


def one_link(p: Panel):
    return {
        "s": p.span("s_i"), "sc": p.span("s_{ci}"), "C": p.start("C_i"), "B": p.start("joint 3"),
        "C_joint": p.start("joint 4"), "f_start": p.start("f_{i−1,i}"),
        "back_start": p.start("−f_{i,i+1}"), "a_start": p.start("v̇_{ci}"),
    }  # fmt: skip


def accelerations(p: Panel):
    return dynamic_pairs(p) | {
        "a1_start": p.start("v̇_{c1}", 0), "C1": p.start("C_1", 0), "along1": p.along("v̇_{c1}", 0),
        "a2_start": p.start("v̇_{c2}", 0), "C2": p.start("C_2", 0), "along2": p.along("v̇_{c2}", 0),
    }  # fmt: skip


def movements(p: Panel):
    arm = p.start("v_1", 1) - p.start("axis", 1)
    return {
        "v_1": p.of("v_1", 0), "v_2": p.of("v_2", 0), "across": float(arm @ p.of("v_1", 1)),
        "speed": float(np.linalg.norm(p.of("v_1", 1))),
        "rate": abs(p.of("ω", 1)) * float(np.linalg.norm(arm)),
    }  # fmt: skip


def bar(p: Panel):
    return {
        "A": p.start("joint 1"),
        "B": p.start("B"),
        "C": p.start("C"),
        "angle": p.direction("θ"),
    }


def arm_accelerations(p: Panel):
    return {
        "a1_start": p.start("v̇_{c1}"), "C1": p.start("C_1"), "along1": p.along("v̇_{c1}"),
        "a2_start": p.start("v̇_{c2}"), "C2": p.start("C_2"), "along2": p.along("v̇_{c2}"),
        "rc1": p.end("r_{c1}"), "rc2": p.end("r_{c2}"),
    }  # fmt: skip


def solid(p: Panel):
    axes = np.array([p.span(f"{x}_i") / np.linalg.norm(p.span(f"{x}_i")) for x in "xyz"])
    return {
        "r_end": p.end("r"), "C": p.start("C"), "v_start": p.start("v_c"),
        "x_start": p.start("x_i"), "handed": float(np.linalg.det(axes)), "f": p.along("f"),
        "n": p.along("n_i"),
    }  # fmt: skip


def gyro(p: Panel):
    spin, yaw, moment = p.of("ω_{x′}"), p.of("ω_{z′}"), p.of("n_{y′}")
    return {
        "spin": spin,
        "yaw": yaw,
        "moment": moment,
        "spin_along": p.along("ω_{x′}"),
        "I_x": 10.0,
    }


def quadrotor(p: Panel):
    thrusts = [p.span(f"F_{k}", 2) for k in range(1, 5)]
    z = p.span("z", 1) / np.linalg.norm(p.span("z", 1))
    lengths = np.array([float(F @ z) for F in thrusts])
    return {
        "s_1": p.span("s_1", 1), "A": p.start("rotor A", 1), "centre": p.start("C", 2),
        "weight_start": p.start("m g", 2), "to_scale": lengths / lengths[0],
        "thrusts": np.array([3.2, 1.4, 2.5, 3.6]) / 3.2, "weight": p.along("m g", 2),
    }  # fmt: skip


def spatial_link(p: Panel):
    return {
        "s": p.span("s_i"), "sc": p.span("s_{ci}"), "C": p.start("C_i"), "start": p.start("s_i"),
        "f_start": p.start("f_{i−1,i}"), "n_start": p.start("n_{i−1,i}"),
        "back": p.start("−f_{i,i+1}"), "back_turn": p.start("−n_{i,i+1}"), "end": p.end("s_i"),
        "z_along": round(float(np.linalg.norm(np.cross(p.span("z_i"), p.span("θ̇_i")))), 9),
    }  # fmt: skip


def slide(p: Panel):
    d, z = p.span("d_i"), p.span("Z_i")
    return {
        "off": round(float(np.linalg.norm(np.cross(d, z))), 9), "p_start": p.start("p^{i−1}_i"),
        "p_end": p.end("p^{i−1}_i"), "before": p.start("X_{i−1}"), "here": p.start("X_i"),
        "c_end": p.end("c_i"), "C": p.start("C_i"),
    }  # fmt: skip


FACTS: Mapping[str, Facts] = {
    "1.1": trajectory,
    "1.2": arm_vectors,
    "1.3": cloud,
    "1.4": pairs,
    "1.5": fixed_axis,
    "2.1": arm_vectors,
    "2.2": five_bar,
    "3.1": pendulum,
    "4.1": relative,
    "4.2": one_link,
    "4.3": accelerations,
    "5.1": movements,
    "5.2": bar,
    "5.3": arm_accelerations,
    "6.2": gyro,
    "6.3": quadrotor,
    "6.4": spatial_link,
    "6.5": slide,
}
"""Facts that are read off each figure."""

CHECKS = {
    **{number: Drawn(number, facts) for number, facts in FACTS.items()},
    **{number: Caption(number) for number in ("2.3", "6.1")},
    "velocity_labels": ByFunction(velocity_labels, calls='fb.notes_figure("3.2").named("v_{c2}")'),
}
