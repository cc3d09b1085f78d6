"""The figures of all chapters, each drawn from a model and read back."""

from __future__ import annotations

import re

import numpy as np

from freebody_notes.checks import Run
from freebody_notes.drawn import Caption, Drawn, Panel
from freebody_notes.figures.catalogue import notes_figure
from freebody_notes.item import Item, Outcome


def trajectory(p: Panel):
    """The direction of v against that of the curve where P is."""
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
        "s1": p.span("s_1"), "s2": p.span("s_2"), "r": p.span("r"), "OA": p.span("link 1"), "AP": p.span("link 2"),
        "C1": p.start("C_1"), "A": p.end("link 1"), "r_end": p.end("r"), "P": p.start("P"),
        "angle1": p.direction("θ_1"), "angle2": p.direction("θ_2"), "theta1": p.of("θ_1"),
    }  # fmt: skip


def cloud(p: Panel):
    spread = [p.span(f"ρ_{k}", 1) for k in range(1, 6)]
    seen = [p.span(f"r_{k}", 0) for k in range(1, 6)]
    return {
        "r_G": p.span("r_{G}", 0), "G": p.start("G", 0), "O": p.start("O", 0), "r_1": seen[0], "m_1": p.start("m_1", 0),
        "G_there": p.start("G", 1), "rho_1": spread[0], "nothing": np.zeros(2),
    }  # fmt: skip


def pairs(p: Panel, on1="−F_{2}", on2="F_{2}", base="F_{1}"):
    """The pair of forces at the elbow, and moments at it; where the base's force stands."""
    return {
        "on1": p.span(on1, 1), "on2": p.span(on2, 1), "turn1": p.of("−τ_2", 1), "turn2": p.of("τ_2", 1),
        "base": p.start(base, 1), "O": p.start("joint 1", 1), "down": p.of("m_1 g", 1)[0],
        "at2": p.start(on2, 1), "A": p.start("link 2", 1), "arrow": p.along(on2, 1),
    }  # fmt: skip


def dynamic_pairs(p: Panel):
    return pairs(p, "−f_{1,2}", "f_{1,2}", "f_{0,1}")


def fixed_axis(p: Panel):
    arm, a_G = p.start("G", 1) - p.start("O", 1), p.of("a_G", 1)
    across = np.array([-arm[1], arm[0]]) / (arm @ arm)
    return {
        "f_start": p.start("f", 1), "O": p.start("O", 1), "a_start": p.start("a_G", 1), "G": p.start("G", 1),
        "tangential": float(a_G @ across), "alpha": p.of("α", 1),
    }  # fmt: skip


def five_bar(p: Panel):
    at = {name: p.start(name, 0) for name in "ABCDP"}
    return at | {
        "O": np.zeros(2), "AB": p.span("AB", 1), "CD": p.span("CD", 1), "AP": p.span("AP", 1), "CP": p.span("CP", 1),
        "BP": p.span("link 3", 0), "DP": p.span("link 4", 0),
    }  # fmt: skip


def pendulum(p: Panel):
    weight = p.of("m g", 1)
    return {
        "r_c": p.span("r_{c}", 0), "v_c": p.span("v_{c}", 0), "C": p.start("C", 0), "A": p.start("joint 1", 0),
        "B": p.start("B", 0), "f_start": p.start("f_{0,1}", 1), "A_free": p.start("joint 1", 1), "sideways": weight[0],
        "weight": p.along("m g", 1),
    }  # fmt: skip


def speeds(p: Panel):
    """The velocity arrows against the arm's own velocities: perpendicular to the first link at
    C₁."""
    return dynamic_pairs(p) | {
        "v_start": p.start("v_{c1}", 0), "C1": p.start("C_1", 0), "across": float(p.span("v_{c1}", 0) @ p.span("link 1", 0)),
        "v2_start": p.start("v_{c2}", 0), "C2": p.start("C_2", 0), "along2": p.along("v_{c2}", 0),
    }  # fmt: skip


def velocity_labels(form: str) -> Outcome:
    """Which arrow stands at the centre of mass of the outer link."""
    p = Panel(notes_figure("3.2"))
    label = re.findall(r"v_c(\d)", form)[-1]
    same = np.allclose(p.start(f"v_{{c{label}}}", 0), p.start("C_2", 0))
    return Outcome(bool(same), (f"The arrow v_c{label} starts at {'C_2' if same else 'C_1'}.",))


def relative(p: Panel):
    return {
        "v_A": p.span("v_A", 1), "v_B": p.span("v_B at A", 1), "turn": p.span("ω × s", 1), "s": p.span("s", 1),
        "A": p.start("A", 1), "tip": p.start("v_A", 1), "B": p.start("joint 2", 0), "v_start": p.start("v_B", 0),
    }  # fmt: skip


def one_link(p: Panel):
    return {
        "s": p.span("s_i"), "sc": p.span("s_{ci}"), "C": p.start("C_i"), "B": p.start("joint 3"), "C_joint": p.start("joint 4"),
        "f_start": p.start("f_{i−1,i}"), "back_start": p.start("−f_{i,i+1}"), "a_start": p.start("v̇_{ci}"),
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
        "speed": float(np.linalg.norm(p.of("v_1", 1))), "rate": abs(p.of("ω", 1)) * float(np.linalg.norm(arm)),
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
        "a1_start": p.start("v̇_{c1}"), "C1": p.start("C_1"), "along1": p.along("v̇_{c1}"), "a2_start": p.start("v̇_{c2}"),
        "C2": p.start("C_2"), "along2": p.along("v̇_{c2}"), "rc1": p.end("r_{c1}"), "rc2": p.end("r_{c2}"),
    }  # fmt: skip


def solid(p: Panel):
    axes = np.array([p.span(f"{x}_i") / np.linalg.norm(p.span(f"{x}_i")) for x in "xyz"])
    return {
        "r_end": p.end("r"), "C": p.start("C"), "v_start": p.start("v_c"), "x_start": p.start("x_i"),
        "handed": float(np.linalg.det(axes)), "f": p.along("f"), "n": p.along("n_i"),
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
        "s_1": p.span("s_1", 1), "A": p.start("rotor A", 1), "centre": p.start("C", 2), "weight_start": p.start("m g", 2),
        "to_scale": lengths / lengths[0], "thrusts": np.array([3.2, 1.4, 2.5, 3.6]) / 3.2, "weight": p.along("m g", 2),
    }  # fmt: skip


def spatial_link(p: Panel):
    return {
        "s": p.span("s_i"), "sc": p.span("s_{ci}"), "C": p.start("C_i"), "start": p.start("s_i"), "f_start": p.start("f_{i−1,i}"),
        "n_start": p.start("n_{i−1,i}"), "back": p.start("−f_{i,i+1}"), "back_turn": p.start("−n_{i,i+1}"), "end": p.end("s_i"),
        "z_along": round(float(np.linalg.norm(np.cross(p.span("z_i"), p.span("θ̇_i")))), 9),
    }  # fmt: skip


def slide(p: Panel):
    d, z = p.span("d_i"), p.span("Z_i")
    return {
        "off": round(float(np.linalg.norm(np.cross(d, z))), 9), "p_start": p.start("p^{i−1}_i"), "p_end": p.end("p^{i−1}_i"),
        "before": p.start("X_{i−1}"), "here": p.start("X_i"), "c_end": p.end("c_i"), "C": p.start("C_i"),
    }  # fmt: skip


def which_figure(form: str) -> Outcome:
    """What the text speaks of there are the vectors of an arm."""
    number = re.findall(r"\d\.\d", form)[0]
    there = {
        element.name for drawing in notes_figure(number).drawings for element in drawing.elements
    }
    missing = {"s_1", "s_2", "r"} - there
    words = f"has no {', '.join(sorted(missing))}" if missing else "has s_1, s_2 and r"
    return Outcome(not missing, (f"Figure {number} {words}.",))


_ARM = (
    "ground",
    "link 1",
    "link 2",
    "l_1",
    "l_2",
    "C_1",
    "C_2",
    "θ_1",
    "θ_2",
    "label O",
    "label A",
    "label P",
)
_CUT = (
    "m_1 g",
    "m_2 g",
    "τ_1",
    "−τ_2",
    "τ_2",
    "s_1",
    "s_2",
    "s_{c1}",
    "s_{c2}",
    "f_{0,1}",
    "−f_{1,2}",
    "f_{1,2}",
)
_PAIR = "on1 = -on2; turn1 = -turn2; base = O; at2 = A; arrow = 1"
_VECTORS = "s1 + s2 = r; s1 = OA; s2 = AP; r_end = P; C1 = A/2; angle1 = 0; angle2 = theta1"

ITEMS = (
    Item(
        "fig-1.1", "1.2.1", "A path and its velocity", "figure", "A curve, the point P on it with its position from the origin, "
        "and its velocity along the tangent.", "r_start = 0; r_end = P; v_start = P; cosine = 1",
        Drawn("1.1", (("x", "y", "Γ", "P", "r(t)", "v(t)", "a(t)"),), trajectory), figure="1.1",
    ),
    Item(
        "fig-1.2", "1.2.1", "An arm of two links", "figure", "Lengths, angles and centres of mass; and the vectors along the links.",
        _VECTORS, Drawn("1.2", (_ARM, ("s_1", "s_2", "r")), arm_vectors), figure="1.2",
    ),
    Item(
        "fig-1.3", "1.2.2", "Centre of mass", "figure", "Particles seen from any origin, and from their centre of mass.",
        "r_G = G - O; r_1 = m_1 - O; G_there = nothing; rho_1 = r_1 - r_G",
        Drawn("1.3", (("m_1", "r_1", "r_{G}", "G"), ("m_1", "ρ_1", "ρ_5", "G")), cloud), figure="1.3",
    ),
    Item(
        "fig-1.4", "1.3", "Free bodies of an arm", "figure", "The arm, and both links cut free with all forces on them.",
        f"{_PAIR}; down = 0",
        Drawn("1.4", (_ARM, ("F_{1}", "−F_{2}", "F_{2}", "F", "m_1 g", "m_2 g", "r_1", "r_2", "τ_1", "−τ_2", "τ_2")), pairs), figure="1.4",
    ),
    Item(
        "fig-1.5", "1.4.2", "Rotation about a fixed axis", "figure", "A body on a pin with the force on it; the same with the pin's force and "
        "what it does.", "f_start = O; a_start = G; tangential = alpha",
        Drawn("1.5", (("body", "O", "G", "F"), ("F", "f", "a_G", "α")), fixed_axis), figure="1.5",
    ),
    Item(
        "fig-2.1", "2.2.1", "An arm of two links", "figure", "The same drawing as figure 1.2.", _VECTORS,
        Drawn("2.1", (_ARM, ("s_1", "s_2", "r")), arm_vectors), figure="2.1",
    ),
    Item(
        "uf-2.10-figref", "2.2.1", "Which figure", "definition", "The tip's position vector is said to be found in a figure.",
        "Fig. 2.2", Run(which_figure, calls='fb.notes_figure("2.1").named("s_1")'), "misprint", "Fig. 2.1", "Figure 2.2 is the parallel robot; the arm is figure 2.1.",
        figure="2.1",
    ),
    Item(
        "fig-2.2", "2.3", "A robot with five bars", "figure", "Two cranks on the base, two bars from them to P; closed as drawn.",
        "A + C = 0; AB = B - A; CD = D - C; AP = AB + BP; CP = CD + DP; AP = P - A",
        Drawn("2.2", (("A", "B", "C", "D", "P", "l_1", "l_2", "l_3", "l_4", "θ_1", "θ_2", "d/2 left", "d/2 right"), ("AB", "CD", "AP", "CP")), five_bar),
        figure="2.2",
    ),
    Item(
        "fig-2.3", "2.4", "Statics of an arm", "figure", "The loaded arm and its free links; the caption is that of figure 2.2.",
        "Kinematic diagram of a 2D parallel manipulator",
        Caption("2.3", {
            "parallel": ("A", "B", "C", "D"), "serial": ("link 1", "link 2", "s_1", "s_2"),
            "free": ("f_{1}", "−f_{2}", "f_{2}", "f", "τ_1", "−τ_2", "τ_2"),
        }), "misprint", "Static forces on the 2D serial manipulator and on its free bodies",
        "The caption was copied from figure 2.2; the drawing is of the serial arm and its free bodies.", figure="2.3",
    ),
    Item(
        "fig-3.1", "3.2", "An arm of one link", "figure", "The bar with its centre of mass and that point's velocity; the bar cut free.",
        "r_c = C - A; 2*r_c = B - A; dot(v_c, r_c) = 0; f_start = A_free; sideways = 0; weight = 1",
        Drawn("3.1", (("joint 1", "B", "C", "r_{c}", "v_{c}", "l", "θ", "x", "y"), ("f_{0,1}", "m g", "τ")), pendulum), figure="3.1",
    ),
    Item(
        "fig-3.2", "3.3", "Dynamics of an arm", "figure", "Angles, rates and velocities of the centres of mass; and the free links. In print the "
        "velocities at both centres carry the same label.", "v_c1 at the inner link, v_c1 at the outer link", Run(velocity_labels, calls='fb.notes_figure("3.2").named("v_{c2}")'), "misprint",
        "v_c1 at the inner link, v_c2 at the outer link", "The velocity of the outer link's centre of mass is v_c2.", figure="3.2",
    ),
    Item(
        "fig-4.1", "4.2.1", "Velocities of two points", "figure", "Two links with their rates; and v_A as the sum of v_B and ω × s.",
        "v_A = v_B + turn; dot(turn, s) = 0; tip = A; v_start = B",
        Drawn("4.1", (("θ_0", "θ", "ω_0", "ω", "s", "v_B", "v_A", "label O"), ("r", "s", "v_B", "v_B at A", "ω × s", "v_A", "φ")), relative), figure="4.1",
    ),
    Item(
        "fig-4.2", "4.3.1", "One link of many", "figure", "Link i between its joints, with what the recursion needs of it.",
        "s = C_joint - B; sc = C - B; f_start = B; back_start = C_joint; a_start = C",
        Drawn("4.2", (("s_{i−1}", "s_i", "s_{ci}", "v_{i−1}", "v_i", "v̇_{ci}", "ω_i", "f_{i−1,i}", "−f_{i,i+1}", "M_i", "−M_{i+1}"),), one_link), figure="4.2",
    ),
    Item(
        "fig-4.3", "4.3.1", "Accelerations and forces", "figure", "The arm with the accelerations of its centres of mass; and the free links.",
        f"{_PAIR}; a1_start = C1; a2_start = C2; along1 = 1; along2 = 1",
        Drawn("4.3", (("θ_1", "θ̇_1", "θ̈_1", "θ_2", "θ̇_2", "θ̈_2", "v̇_{c1}", "v̇_{c2}", "m_1, I_1", "m_2, I_2"), _CUT), accelerations), figure="4.3",
    ),
    Item(
        "fig-5.1", "5.1.1", "Three kinds of motion", "figure", "Translation, rotation about a fixed axis, and both together.",
        "v_1 = v_2; across = 0; speed = rate", Drawn("5.1", (("v", "v_1", "v_2"), ("axis", "ω", "v_1"), ("v_G", "ω")), movements), figure="5.1",
    ),
    Item(
        "fig-5.2", "5.3", "An arm of one link", "figure", "As the first part of figure 3.1.", "C = 1/2*(A + B); angle = 0",
        Drawn("5.2", (("joint 1", "B", "C", "l", "θ"),), bar), figure="5.2",
    ),
    Item(
        "fig-5.3", "5.3", "An arm of two links", "figure", "As the first part of figure 4.3, with the positions of the centres of mass.",
        "a1_start = C1; a2_start = C2; along1 = 1; along2 = 1; rc1 = C1; rc2 = C2",
        Drawn("5.3", (("v̇_{c1}", "v̇_{c2}", "r_{c1}", "r_{c2}", "m_1, I_1", "m_2, I_2", "θ_1", "θ_2"),), arm_accelerations), figure="5.3",
    ),
    Item(
        "fig-6.1", "6.1", "A body in space", "figure", "World axes, axes of the body, its velocity, a force and a moment; the caption speaks of a robot.",
        "1-dof robot",
        Caption("6.1", {"1-dof robot": ("ground", "joint 1", "θ"), "global": ("X", "Y", "Z"), "body-fixed": ("x_i", "y_i", "z_i"), "forces": ("f", "n_i", "v̇_c", "ω", "r")}),
        "misprint", "A rigid body in space with global and body-fixed axes, its motion and the forces on it",
        "The caption was copied from figure 5.2.", figure="6.1",
    ),
    Item(
        "fig-6.2", "6.1", "A gyro", "figure", "A rotor that rolls about X′ in a ring that yaws about Z′, and the moment about Y′.",
        "norm(spin) = 5; norm(yaw) = 3; moment = I_x*cross(yaw, spin); spin_along = 1",
        Drawn("6.2", (("X′", "Z′", "ω_{x′}", "ω_{z′}", "n_{y′}", "rotor", "shaft"),), gyro), figure="6.2",
    ),
    Item(
        "fig-6.3", "6.1", "A quadrotor", "figure", "The vehicle, its axes and rotors, and its thrusts to one scale.",
        "s_1 = A - centre; to_scale = thrusts; weight_start = centre; weight = 1",
        Drawn("6.3", (("hull",), ("X", "Y", "Z", "x", "y", "z", "rotor A", "rotor B", "rotor C", "rotor D", "s_1"), ("F_1", "F_2", "F_3", "F_4", "m g", "v")), quadrotor),
        figure="6.3",
    ),
    Item(
        "fig-6.4", "6.3.1.1", "One link in space", "figure", "Link i with both joints, its vectors and the wrenches on it.",
        "sc = C - start; f_start = start; n_start = start; back = end; back_turn = end; z_along = 0",
        Drawn("6.4", (("s_i", "s_{ci}", "z_i", "z_{i+1}", "θ̇_i", "θ̇_{i+1}", "v̇_{ci}", "f_{i−1,i}", "n_{i−1,i}", "−f_{i,i+1}", "−n_{i,i+1}", "m_i g"),), spatial_link),
        figure="6.4",
    ),
    Item(
        "fig-6.5", "6.3.1.2", "A sliding joint", "figure", "Frames of both links, the slide along z, and the vectors between them.",
        "off = 0; p_start = before; p_end = here; c_end = C",
        Drawn("6.5", (("X_{i−1}", "Y_{i−1}", "Z_{i−1}", "X_i", "Y_i", "Z_i", "d_i", "p^{i−1}_i", "c_i", "v_{i−1}", "v_{ci}", "ω_{i−1}"),), slide), figure="6.5",
    ),
)  # fmt: skip
