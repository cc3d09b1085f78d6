"""Drawings with symbols: true to the model, third law, closed five-bar, legible; beside the steps
of derivations."""

import math
import re
import xml.etree.ElementTree as ET

import numpy as np
import pytest

import freebody as fb
from freebody.figures import marked_text, svg
from freebody.figures.drawing import Arc, Arrow, Dimension, Label, Line, Mark, Prism, Turn
from freebody.figures.figure import Figure
from freebody.figures.labelling import overlaps
from freebody.figures.layers.measures import common_normal
from freebody.figures.snapshot import clear_pose, with_values
from freebody.model.joints import KINDS
from freebody.model.loop_kinds import LOOP_KINDS
from freebody_notes.figures.catalogue import FIGURES
from freebody_notes.figures.quadrotor import zxz
from freebody_textbook.drawings.illustrate import illustrations
from freebody_textbook.methods import METHODS
from freebody_textbook.render.equation_lines import STYLE
from support.command import run

pytestmark = pytest.mark.usefixtures("numpy_kernels")

Q = [0.6, 0.75]


def arrow(figure, name, panel=None) -> Arrow:
    found = figure.named(name, panel)
    assert isinstance(found, Arrow), name
    return found


def span(element) -> np.ndarray:
    return np.subtract(element.end, element.start)


def place(figure, name, panel=None) -> np.ndarray:
    return np.array(figure.named(name, panel).at)


def parallel(a, b) -> bool:
    return bool(np.dot(a, b) > 0.999999 * np.linalg.norm(a) * np.linalg.norm(b))


@pytest.fixture(scope="module")
def arm():
    return fb.load("2R")


@pytest.fixture(scope="module")
def figures() -> dict[str, Figure]:
    return Drawn()


class Drawn(dict):
    """Figures by number, drawn when they are first asked for."""

    def __missing__(self, number: str) -> Figure:
        return self.setdefault(number, fb.notes_figure(number))


# ---------------------------------------------------------------- every figure
@pytest.mark.sample(4)
@pytest.mark.parametrize("number", FIGURES)
def test_figures_are_sound_and_legible(number, figures):
    figure = figures[number]
    root = ET.fromstring(figure.svg)
    assert root.tag.endswith("svg")
    assert not re.search(r'(?:href|src)="(?!#)|url\(|<script|@import', figure.svg)
    for drawing in figure.drawings:
        assert_legible(drawing, figure.width, figure.tallest)


def assert_legible(drawing, width, tallest):
    """No label on another, on a line or off the page."""
    page, height, boxes = svg.laid_out(drawing, width, tallest)
    for k, (label, box) in enumerate(zip(page.wanted, boxes, strict=True)):
        left, top, right, bottom = box
        text, others = label.text, np.array(boxes[k + 1 :]).reshape(-1, 4)
        assert min(left, top, width - right, height - bottom) >= 0, text
        assert not (overlaps(others, box) > 12).any(), text
        lines = [
            p
            for p in page.crowd.points
            if left + 1 < p.real < right - 1 and top + 2 < p.imag < bottom - 2
        ]
        assert not lines, f"{text} stands on a line"


@pytest.mark.sample(1)
@pytest.mark.parametrize("word", ["R", "RR", "RP", "PR", "PP", "PRP", "RPR", "RRRR"])
def test_any_planar_arm_is_legible(word):
    shows = ["geometry", "vectors", "centres", "velocities", "accelerations"]
    figure = fb.kinematic_diagram(fb.planar(word), show=shows)
    for drawing in figure.drawings:
        assert_legible(drawing, figure.width, figure.tallest)


@pytest.mark.parametrize("q", [[0, 0], [math.pi / 2, 0], [0.7, math.pi], [-2.0, 1.0], [2.5, -1.2]])
def test_odd_poses_are_legible(arm, q):
    figure = fb.kinematic_diagram(arm, q, show=["geometry", "velocities"])
    for drawing in figure.drawings:
        assert_legible(drawing, figure.width, figure.tallest)


@pytest.mark.sample(1)
@pytest.mark.parametrize("name", ["puma560", "scara", "gyro", "quadrotor"])
@pytest.mark.filterwarnings("ignore::freebody.PhysicalWarning")
def test_robots_in_space_draw(name):
    figure = fb.kinematic_diagram(fb.load(name), show=["frames", "normals", "vectors"])
    ET.fromstring(figure.svg)
    for drawing in figure.drawings:
        assert_legible(drawing, figure.width, figure.tallest)


def test_unknown_figures_and_elements_are_named():
    with pytest.raises(
        fb.UnknownNameError, match=r"no figure '3.9' in the notes. Did you mean '3.[12]'"
    ):
        fb.notes_figure("3.9")
    figure = fb.notes_figure("fig-1.2")
    assert figure.named("s_{1}") is figure.named("s_1")
    with pytest.raises(fb.UnknownNameError, match=r"no element 's_9' in 'A planar two-link arm'"):
        figure.named("s_9")


# ---------------------------------------------------------------- geometry
def test_arm_stands_where_forward_kinematics_puts_it(arm):
    figure = fb.kinematic_diagram(arm, Q)
    tip = fb.forward_kinematics(arm, Q)[:2, 2]
    elbow = np.array([math.cos(0.6), math.sin(0.6)])
    np.testing.assert_allclose(place(figure, "P"), tip, atol=1e-12)
    length = figure.named("l_2")
    assert isinstance(length, Dimension)
    np.testing.assert_allclose((length.start, length.end), (elbow, tip), atol=1e-12)
    np.testing.assert_allclose(span(arrow(figure, "r", 1)), tip, atol=1e-12)
    np.testing.assert_allclose(
        span(arrow(figure, "s_1", 1)) + span(arrow(figure, "s_2", 1)), tip, atol=1e-12
    )
    one, two = figure.named("θ_1"), figure.named("θ_2")
    assert isinstance(one, Arc)
    assert isinstance(two, Arc)
    assert (one.start, one.sweep) == pytest.approx((0.0, 0.6))
    assert (two.start, two.sweep) == pytest.approx((0.6, 0.75)), "from the extended link 1"
    kinds = {e.kind for e in figure.drawings[0].elements if isinstance(e, Mark)}
    assert {"ground", "joint", "com"} <= kinds


def test_symbols_without_values_are_drawn():
    model = fb.planar("RPR")
    assert model.missing
    figure = fb.kinematic_diagram(model, show="geometry")
    assert isinstance(figure.named("d_2"), Dimension)
    assert not with_values(model).missing
    assert with_values(fb.load("2R")).parameters == fb.load("2R").parameters, "known values stay"


@pytest.mark.sample(1)
@pytest.mark.parametrize("method", [None, *METHODS])
def test_arm_with_only_one_moment_of_inertia_named_is_drawn(method):
    """Typical values of Izz beside Ixx = Iyy = 0 are of no rigid body; nothing of that is drawn."""
    rows = [
        {"a": a, "m": 1.0, "com": [0, 0, 0], "I": [0, 0, 0, 0, 0, f"Izz{k}"]}
        for k, a in ((1, 0.3), (2, 0.2))
    ]
    scara = fb.dh(
        [*rows, {"joint": "P", "m": 1.0, "com": [0, 0, 0], "I": [0, 0, 0, 0, 0, "Izz3"]}],
        convention="standard",
    )
    if method is None:
        figures = fb.kinematic_diagram(scara).drawings
    else:
        derivation = fb.derive(scara, method)
        assert "<svg" in derivation.html()
        figures = illustrations(derivation).values()
    for drawing in figures:
        assert_legible(drawing, 460.0, 400.0)


EVERYTHING = {
    "one DH row, nothing given": lambda: fb.dh([{}], convention="standard"),
    "DH with symbols": lambda: fb.dh([{"a": "a1"}, {"a": "a2", "d": "d2"}], convention="standard"),
    "some numbers": lambda: fb.dh([{"a": 0.3, "m": "m1"}, {"a": "a2"}], convention="modified"),
    "prismatic first": lambda: fb.dh(
        [{"joint": "P", "a": "a1"}, {"a": "a2"}], convention="standard"
    ),
    "no lengths, no masses": lambda: fb.planar("RR", l=[0, 0], m=[0, 0]),
    "a massless link": lambda: fb.planar("RR", m=[0, None]),
    "slides only": lambda: fb.planar("PP"),
    "seven joints": lambda: fb.planar("R" * 7, l=[0.3] * 7, lc=[0.1] * 7, m=[1] * 7, I=[0.1] * 7),
    "one motor for three joints": lambda: fb.planar("RRR").replace(actuated=["joint2"]),
    "no motor": lambda: fb.planar("RP").replace(actuated=[]),
    "long names": lambda: fb.planar(
        "RR", l=["left_upper_arm_length_of_the_first_robot", "θ1"], m=["m_c", "J"]
    ),
    "more joints than letters": lambda: fb.planar(
        "R" * 17, l=[0.3] * 17, lc=[0.1] * 17, m=[1] * 17, I=[0.1] * 17
    ),
}


@pytest.mark.sample(1)
@pytest.mark.parametrize("kind", EVERYTHING)
def test_whatever_robot_is_drawn(kind):
    model = EVERYTHING[kind]()
    for drawing in fb.kinematic_diagram(model).drawings:
        letters = [
            e.text
            for e in drawing.elements
            if isinstance(e, Label) and re.fullmatch("[A-Z]′*", e.text)
        ]
        assert len(letters) == len(set(letters)), "a letter is one place's"
    if len(model.bodies) < 10:
        for method in ("newton-euler", "statics", "kinematics"):
            for name, drawing in illustrations(fb.derive(model, method)).items():
                ET.fromstring(svg.picture(drawing, 460.0, 400.0).text())
                if name == "overview" and len(model.bodies) < 7:
                    assert_legible(drawing, 460.0, 400.0)


def test_velocities_and_accelerations_are_the_models(arm):
    qd, qdd = [0.9, 1.1], [1.5, 1.0]
    figure = fb.kinematic_diagram(arm, Q, ["velocities", "accelerations"], qd, qdd)
    scales = []
    for k, (link, lc) in enumerate((("link1", 0.5), ("link2", 0.4)), 1):
        v = fb.velocity(arm, Q, qd, link, [lc, 0.0])[:2]
        a = fb.acceleration(arm, Q, qd, qdd, link, [lc, 0.0])[:2]
        np.testing.assert_allclose(arrow(figure, f"v_{{c{k}}}").value, v, atol=1e-12)
        np.testing.assert_allclose(
            arrow(figure, f"v̇_c{k}".replace("c", "{c") + "}").value, a, atol=1e-12
        )
        shown = arrow(figure, f"v_{{c{k}}}")
        np.testing.assert_allclose(shown.start, place(figure, f"C_{k}"), atol=1e-12)
        assert parallel(span(shown), v)
        scales.append(np.linalg.norm(span(shown)) / np.linalg.norm(v))
    assert scales[0] == pytest.approx(scales[1]), "one scale"
    rate = figure.named("θ̇_2")
    assert isinstance(rate, Turn)
    assert rate.value == 1.1


def test_clear_pose_is_within_the_limits():
    for name in ("ur5e", "scara", "RP"):
        model = fb.load(name)
        q = clear_pose(model)
        assert np.all(q >= model.limits.lower)
        assert np.all(q <= model.limits.upper)


def test_bad_requests_are_explained(arm):
    with pytest.raises(
        fb.UnknownNameError, match="no choice 'frames' in kinematic_diagram of a model in 2D"
    ):
        fb.kinematic_diagram(arm, show="frames")
    with pytest.raises(fb.FreebodyError, match="show is empty; name one of geometry"):
        fb.kinematic_diagram(arm, show=[])
    with pytest.raises(fb.ShapeError, match=r"q has shape \(3,\)"):
        fb.kinematic_diagram(arm, [0, 0, 0])
    with pytest.raises(
        fb.ShapeError, match=r"q has shape \(5, 4, 2\), expected \(2,\): one sample"
    ):
        fb.kinematic_diagram(arm, np.zeros((5, 4, 2)))


def test_common_normal_meets_both_axes_at_right_angles():
    rng = np.random.default_rng(3)
    p, q = rng.normal(size=(2, 3))
    u, v = (x / np.linalg.norm(x) for x in rng.normal(size=(2, 3)))
    foot, head = common_normal(p, u, q, v)
    assert abs((head - foot) @ u) < 1e-12
    assert abs((head - foot) @ v) < 1e-12
    np.testing.assert_allclose(np.cross(foot - p, u), 0, atol=1e-12)
    np.testing.assert_allclose(np.cross(head - q, v), 0, atol=1e-12)
    np.testing.assert_allclose(common_normal(p, u, q, u)[1], q)


def test_denavit_hartenberg_lengths_are_found_again():
    rows = [
        {"a": 0.0, "alpha": 0.0, "d": 0.3}, {"a": 0.25, "alpha": -1.2, "d": 0.1},
        {"a": 0.4, "alpha": 0.7, "d": 0.2}
    ]  # fmt: skip
    model = fb.dh(
        [{**row, "m": 1.0, "com": [0, 0, 0], "I": [0.1, 0, 0, 0.1, 0, 0.1]} for row in rows],
        convention="modified",
    )
    figure = fb.kinematic_diagram(model, [0.3, 0.5, -0.4], show="normals")
    assert np.linalg.norm(span(arrow(figure, "a_1"))) == pytest.approx(0.25)
    assert np.linalg.norm(span(arrow(figure, "a_2"))) == pytest.approx(0.4)
    assert np.linalg.norm(span(arrow(figure, "d_2"))) == pytest.approx(0.1)


# ---------------------------------------------------------------- forces
@pytest.mark.parametrize(
    ("number", "on_first", "on_second"),
    [
        ("1.4", "−F_2", "F_2"),
        ("2.3", "−f_2", "f_2"),
        ("3.2", "−f_{1,2}", "f_{1,2}"),
        ("4.3", "−f_{1,2}", "f_{1,2}"),
    ],
)
def test_third_law_is_seen_at_the_elbow(number, on_first, on_second, figures):
    figure = figures[number]
    one, two = arrow(figure, on_first, 1), arrow(figure, on_second, 1)
    np.testing.assert_allclose(span(one), -span(two), atol=1e-12)
    gap = figure.drawings[1].moved[2]
    np.testing.assert_allclose(np.subtract(two.start, gap), one.start, atol=1e-12)
    assert figure.named("τ_2", 1).value == pytest.approx(-figure.named("−τ_2", 1).value)


def test_static_figure_shows_the_load_and_its_torques(figures):
    figure = figures["2.3"]
    load = arrow(figure, "f", 1)
    np.testing.assert_allclose(load.value, [-4.5, -3.0])
    np.testing.assert_allclose(np.add(arrow(figure, "f_2", 1).value, load.value), 0, atol=1e-12)
    model = fb.load("2R").replace(gravity=0.0)
    q = [figure.named("θ_1", 0).sweep, figure.named("θ_2", 0).sweep]
    tau = fb.static_torque(model, q, [-4.5, -3.0, 0.0])
    assert [figure.named(f"τ_{k}", 1).value for k in (1, 2)] == pytest.approx(list(tau))
    assert "m_1 g" not in {e.name for e in figure.drawings[1].elements}


def test_forces_are_drawn_to_one_scale_from_where_they_act(figures):
    figure = figures["3.2"]
    names = ["f_{0,1}", "−f_{1,2}", "f_{1,2}", "m_1 g", "m_2 g"]
    found = [arrow(figure, name, 1) for name in names]
    for a in found:
        assert parallel(span(a), a.value)
    scales = [np.linalg.norm(span(a)) / np.linalg.norm(a.value) for a in found]
    np.testing.assert_allclose(scales, scales[0], rtol=1e-9)
    np.testing.assert_allclose(found[3].start, place(figure, "C_1", 1))
    np.testing.assert_allclose(found[0].start, 0.0)
    assert figure.drawings[1].rulers, "the scale is named"


# ---------------------------------------------------------------- the notes' other figures
def test_velocity_is_tangent_to_the_trajectory(figures):
    figure = figures["1.1"]
    curve = figure.named("Γ")
    assert isinstance(curve, Line)
    at, v = place(figure, "P"), arrow(figure, "v(t)")
    np.testing.assert_allclose(arrow(figure, "r(t)").end, at)
    k = int(np.argmin(np.linalg.norm(np.subtract(curve.points, at), axis=1)))
    chord = np.subtract(curve.points[k + 1], curve.points[k - 1])
    assert chord @ span(v) > 0.999 * np.linalg.norm(chord) * np.linalg.norm(span(v))


def test_particles_balance_about_their_centre(figures):
    figure = figures["1.3"]
    masses = (2.0, 1.0, 1.5, 2.5, 1.0)
    moments = sum(m * span(arrow(figure, f"ρ_{k}", 1)) for k, m in enumerate(masses, 1))
    np.testing.assert_allclose(moments, 0.0, atol=1e-12)
    np.testing.assert_allclose(arrow(figure, "r_{G}", 0).end, place(figure, "G", 0))


def test_pinned_body_obeys_newton_and_euler(figures):
    figure = figures["1.5"]
    F, f, a = (np.array(arrow(figure, name, 1).value) for name in ("F", "f", "a_G"))
    np.testing.assert_allclose(F + f, 2.0 * a, atol=1e-9)
    arm = np.array(arrow(figure, "F", 1).start)
    turning = arm[0] * F[1] - arm[1] * F[0]
    assert turning == pytest.approx((0.2 + 2.0 * 0.55**2) * figure.named("α", 1).value)
    assert "f" not in {e.name for e in figure.drawings[0].elements}


def test_five_bar_closes(figures):
    figure = figures["2.2"]
    at = {name: place(figure, name, 0) for name in "ABCDP"}
    np.testing.assert_allclose(at["A"], -at["C"])
    for name, ends in (("l_1", "AB"), ("l_2", "CD"), ("l_3", "BP"), ("l_4", "DP")):
        length = figure.named(name, 0)
        assert isinstance(length, Dimension)
        np.testing.assert_allclose((length.start, length.end), [at[x] for x in ends])
    model = fb.load("five_bar")
    guess = {"theta1": 2.0, "theta2": 1.0, "B": -1.5, "D": 1.5}
    q = fb.assemble(model, guess, free=["B", "D"])
    np.testing.assert_allclose(fb.forward_kinematics(model, q, "P")[:2, 2], at["P"], atol=1e-9)
    shown = fb.kinematic_diagram(model, q).drawings[0].elements
    halves = [e.end for e in shown if isinstance(e, Dimension) and e.name == "b"]
    np.testing.assert_allclose(halves, [at["A"], at["C"]], atol=1e-12)
    np.testing.assert_allclose(
        fb.forward_kinematics(model, q, "distal2")[:2, 2], at["D"], atol=1e-9
    )
    np.testing.assert_allclose(arrow(figure, "CP", 1).end, at["P"])
    bars = [np.linalg.norm(at["P"] - at[x]) for x in "BD"]
    np.testing.assert_allclose(bars, [model.parameters["l3"], model.parameters["l4"]])
    np.testing.assert_allclose(at["B"] - at["A"], 0.4 * np.array([np.cos(2.0), np.sin(2.0)]))


@pytest.mark.sample(1)
@pytest.mark.parametrize("name", ["five_bar", "four_bar", "slider_crank", "stewart", "bricard"])
def test_closed_chains_are_drawn_closed(name):
    model = fb.load(name)
    figure = fb.kinematic_diagram(model, show=["vectors"])
    for loop in model.loops:
        symbol = KINDS[LOOP_KINDS[loop.kind].symbol(model.dim)]
        found = [
            e
            for e in figure.drawings[0].elements
            if e.name == loop.name and isinstance(e, Mark | Prism)
        ]
        T = fb.forward_kinematics(model, fb.assemble(model), loop.frames[1])
        for e in found:
            np.testing.assert_allclose(e.at, T[: model.dim, -1], atol=1e-9)
        if model.dim == 3 and symbol.solids:
            assert [e.sides for e in found] == [part.sides for part in symbol.solids]
            assert parallel(found[0].axis, T[:3, :3] @ loop.axis)
        else:
            assert {e.kind for e in found} == {symbol.mark}
    ET.fromstring(figure.svg)


@pytest.mark.parametrize("kind", LOOP_KINDS.values(), ids=LOOP_KINDS)
def test_every_kind_of_loop_has_the_symbol_of_a_joint(kind):
    for dim in kind.dimensions:
        symbol = KINDS[kind.symbol(dim)]
        assert symbol.needs_axis <= (dim in kind.axis_in) or dim == 2


def test_pendulum_moves_across_itself(figures):
    figure = figures["3.1"]
    assert span(arrow(figure, "r_c", 0)) @ span(arrow(figure, "v_c", 0)) == pytest.approx(
        0.0, abs=1e-12
    )
    assert arrow(figure, "m g", 1).value == pytest.approx((0.0, -2 * 9.81))
    total = np.add(arrow(figure, "f_{0,1}", 1).value, arrow(figure, "m g", 1).value)
    c = figure.named("C", 1).at
    acceleration = 0.8 * np.array([-c[1], c[0]]) - 1.2**2 * np.array(c)
    np.testing.assert_allclose(total, 2.0 * acceleration, atol=1e-12)


def test_relative_velocity_adds_up(figures):
    figure = figures["4.1"]
    carried, turned, v = (arrow(figure, name, 1) for name in ("v_B at A", "ω × s", "v_A"))
    np.testing.assert_allclose(carried.end, turned.start)
    np.testing.assert_allclose(turned.end, v.end, atol=1e-12)
    assert span(turned) @ span(arrow(figure, "s", 1)) == pytest.approx(0.0, abs=1e-12)
    assert figure.named("ω", 0).value == pytest.approx(0.8 + 0.7)


def test_three_kinds_of_motion(figures):
    figure = figures["5.1"]
    moving = [[np.array(arrow(figure, name, k).value) for name in ("v_1", "v_2")] for k in range(3)]
    np.testing.assert_allclose(*moving[0])
    turning = figure.named("ω", 1)
    assert isinstance(turning, Turn)
    for name, v in zip(("v_1", "v_2"), moving[1], strict=True):
        r = np.subtract(arrow(figure, name, 1).start, turning.at)
        np.testing.assert_allclose(v, turning.value * np.array([-r[1], r[0]]), atol=1e-12)
    assert not np.allclose(*moving[2])


def test_free_body_in_space_obeys_euler(figures):
    figure = figures["6.1"]
    axes = np.array([np.array(arrow(figure, f"{x}_i").value) for x in "xyz"])
    np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-12)
    np.testing.assert_allclose(
        np.array(arrow(figure, "f").value), 5 * np.array(arrow(figure, "v̇_c").value)
    )
    arm = np.subtract(arrow(figure, "f").start, figure.named("C").at)
    np.testing.assert_allclose(
        arrow(figure, "n_i").value, np.cross(arm, arrow(figure, "f").value), atol=1e-12
    )


def test_gyro_needs_a_moment_about_y(figures):
    figure = figures["6.2"]
    roll, yaw, n = (np.array(arrow(figure, name).value) for name in ("ω_{x′}", "ω_{z′}", "n_{y′}"))
    assert np.linalg.norm(roll) == pytest.approx(5.0)
    assert np.linalg.norm(yaw) == pytest.approx(3.0)
    np.testing.assert_allclose(n, 10.0 * np.cross(yaw, roll), atol=1e-9)


def test_thrusts_of_the_quadrotor_are_along_its_z(figures):
    figure = figures["6.3"]
    up = zxz((math.pi / 4, 0.1, 0.2))[:, 2]
    thrusts = [arrow(figure, f"F_{k}", 2) for k in range(1, 5)]
    for thrust, size in zip(thrusts, (3.2, 1.4, 2.5, 3.6), strict=True):
        np.testing.assert_allclose(thrust.value, size * up, atol=1e-9)
    scales = [np.linalg.norm(span(t)) / np.linalg.norm(t.value) for t in thrusts]
    np.testing.assert_allclose(scales, scales[0])
    assert parallel(span(arrow(figure, "m g", 2)), [0, 0, -1])
    np.testing.assert_allclose(np.linalg.norm(span(arrow(figure, "s_1", 1))), 0.5)


def test_link_in_space_balances(figures):
    figure = figures["6.4"]
    names = ("f_{i−1,i}", "−f_{i,i+1}", "m_i g")
    forces = [np.array(arrow(figure, name).value) for name in names]
    np.testing.assert_allclose(
        sum(forces), 4.0 * np.array(arrow(figure, "v̇_{ci}").value), atol=1e-9
    )
    np.testing.assert_allclose(arrow(figure, "s_i").end, arrow(figure, "−n_{i,i+1}").start)


def test_slide_goes_along_its_axis(figures):
    figure = figures["6.5"]
    d, z = arrow(figure, "d_i"), arrow(figure, "Z_i")
    assert parallel(d.value, z.value)
    assert np.linalg.norm(d.value) == pytest.approx(0.75)
    np.testing.assert_allclose(arrow(figure, "p^{i−1}_i").end, arrow(figure, "c_i").start)


# ---------------------------------------------------------------- beside the derivations
@pytest.mark.sample(1)
@pytest.mark.parametrize("method", METHODS)
def test_derivation_of_a_planar_arm_is_illustrated(method):
    derivation = fb.derive(fb.planar("RP"), method)
    drawn = illustrations(derivation)
    asked = {step.figure for step in derivation.steps if step.figure}
    assert asked
    assert set(drawn) == asked | {"overview"}
    for drawing in drawn.values():
        assert_legible(drawing, 460.0, 400.0)
    assert derivation.html().count("<figure>") == len(drawn)
    for shown in (derivation._repr_html_(), derivation.steps[0]._repr_html_()):
        assert STYLE in shown, "in a notebook too, equations are aligned at their sign"


def test_names_are_those_of_the_equations():
    moments = {
        method: illustrations(fb.derive(fb.planar("RP"), method))["free-body 2"]
        for method in ("newton-euler", "recursive")
    }
    assert (
        moments["newton-euler"].named("n_{1,2}").value
        == moments["recursive"].named("n_{1,2}").value
    )
    carried = illustrations(fb.derive(fb.planar("RR"), route="pivot"))["carried 1"]
    np.testing.assert_allclose(carried.named("r_{1,c2}").end, carried.named("C_2").at)
    assert "f_{1,2}" not in {e.name for e in carried.elements}, "inner reactions cancel"
    letters = [e.text for e in carried.elements if isinstance(e, Label)]
    assert len(letters) == len(set(letters)), "where two links meet, the joint is named once"


def test_markdown_refers_to_drawings_beside_it(tmp_path, capsys):
    target = tmp_path / "arm.md"
    assert run(["derive", "2R", "--form", "markdown", "--out", str(target)]) == 0
    text = target.read_text(encoding="utf-8")
    images = re.findall(r"!\[\]\((.+?)\)", text)
    assert images[0] == "arm-overview.svg"
    assert "arm-free-body-2.svg" in images
    for image in images:
        ET.fromstring((tmp_path / image).read_text(encoding="utf-8"))


# ---------------------------------------------------------------- the command
def test_fbd_writes_a_drawing_and_lists_the_loads(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert (
        run(["fbd", "2R", "--q", "0.6 0.9", "--qd", "1, -0.5", "--qdd", "2 3", "--body", "link2"])
        == 0
    )
    said = capsys.readouterr().out.splitlines()
    assert said[1].split() == ["link2", "link1", "f1,2", "−11.87", "32.81", "τ2", "6.465"]
    assert said[-1] == "written: 2R-fbd.svg"
    ET.fromstring((tmp_path / "2R-fbd.svg").read_text(encoding="utf-8"))
    assert run(["fbd", "ur5e", "--out", "all.svg"]) == 0
    said = capsys.readouterr().out
    assert "choose another with --q" in said
    assert "10⁻" not in said, "rounding is not listed as force"


def test_fbd_of_letters_lists_names_alone(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert run(["fbd", "RRP", "--show", "points", "--show", "lengths"]) == 0
    said = capsys.readouterr().out.splitlines()
    assert said[1].split() == ["body", "by", "force", "moment"]
    assert said[2].split() == ["link1", "the", "ground", "f0,1", "τ1"]
    assert said[-2].startswith("drawn for typical values; without value: I1, I2, I3, l1")
    assert ">A</tspan>" in (tmp_path / "RRP-fbd.svg").read_text(encoding="utf-8")


def test_derive_shows_values_on_pages_alone(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert run(["derive", "2R", "--labels", "both", "--out", "arm.html"]) == 0
    assert "1.00 m" in (tmp_path / "arm.html").read_text(encoding="utf-8")
    assert run(["derive", "2R", "--labels", "both", "--out", "arm.md"]) == 0
    assert "1.00 m" in (tmp_path / "arm-overview.svg").read_text(encoding="utf-8")
    capsys.readouterr()
    assert run(["derive", "2R", "--labels", "both"]) == 2
    assert capsys.readouterr().err.startswith("error: --labels applies to drawings, and this")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--labels", "numbers"], "Invalid value for '--labels': 'numbers' is not one of"),
        (["--show", "axes"], "no choice 'axes' in free_body_diagram of a model in 2D: show=."),
        (
            ["--q", "0.5 x"],
            "--q '0.5 x': 'x' is not a number that can be used; write for example --q \"0.5, 30 "
            'deg".',
        ),
        (["--q", "0.5"], "free_body_diagram: q has shape (1,)"),
        (["--body", "link3"], "no body 'link3' in '2R'."),
        (["--out", "a.png"], "free_body_diagram: 'a.png' is not an .svg or .pdf file"),
    ],
)
def test_fbd_refuses_in_one_line(arguments, words, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert run(["fbd", "2R", *arguments]) == 2
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err.startswith(f"error: {words}")
    assert said.err.count("\n") == 1


def test_fbd_reads_degrees(capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    listed = []
    for q in ("30 deg, 60°", f"{math.pi / 6} {math.pi / 3}"):
        assert run(["fbd", "2R", "--q", q]) == 0
        listed.append(capsys.readouterr().out)
    assert listed[0] == listed[1]


def test_derivation_in_space_is_illustrated():
    drawn = illustrations(fb.derive(fb.load("scara"), "newton-euler"))
    assert {"overview", "vectors", "free-body 1", "free-body 4"} <= set(drawn)
    body = drawn["free-body 3"]
    assert isinstance(body.named("u_3"), Arrow)
    assert_legible(body, 460.0, 400.0)


# ---------------------------------------------------------------- formulas
def test_formulas_are_set_as_in_print():
    assert marked_text.plain("−*f*_{i−1,i}") == "−fi−1,i"
    marked = marked_text.marked(marked_text.runs("*v̇*_{c1}"))
    assert ">v</tspan>" in marked, "a letter without its accent"
    assert ">.</tspan>" in marked, "and the dot above it"
    assert marked_text.formula_width("p^{i−1}_i") < marked_text.formula_width("p_{i−1}_i")


def test_symbols_in_sentences_are_set_and_names_are_left():
    said = list(marked_text.sentence("|ΣM − Ḣ_1| of left_arm, −f_{1,2}"))
    assert [run.text for run in said if run.style == "v"] == ["Ḣ", "f"]
    assert [run.text for run in said if run.level] == ["1", "1,2"]
    assert "".join(run.text for run in said) == "|ΣM − Ḣ1| of left_arm, −f1,2"


def test_quadrotor_is_drawn_with_its_four_thrusts():
    derivation = fb.derive(fb.load("quadrotor"))
    drawings = illustrations(derivation)
    assert list(drawings) == ["overview", "free 1"]
    drawing = drawings["free 1"]
    assert_legible(drawing, 460.0, 400.0)
    thrusts = [drawing.named(f"T_{k}") for k in (1, 2, 3, 4)]
    weight = drawing.named("m g")
    assert all(isinstance(x, Arrow) for x in (*thrusts, weight))
    total = sum(np.array(x.value) for x in thrusts)
    np.testing.assert_allclose(total + np.array(weight.value), 0.0, atol=1e-9)
    length = [np.linalg.norm(np.subtract(x.end, x.start)) for x in (*thrusts, weight)]
    np.testing.assert_allclose(length, np.array([1, 1, 1, 1, 4]) * length[0], rtol=1e-9)
    np.testing.assert_allclose(drawing.named("s_2").value, [0.0, 0.5, 0.0], atol=1e-12)
    assert derivation.html().count("<figure>") == 2
