"""Drawings as data: where things stand, which way forces point, what they add up to, and that the
SVG is sound."""

import itertools
import math
import re
import xml.etree.ElementTree as ET

import numpy as np
import pytest

import freebody as fb
from freebody import FreebodyError, MissingValueError, ShapeError, UnknownNameError
from freebody.figures.drawing import Arc, Arrow, Dimension, Line, Mark, Prism, Turn
from freebody.figures.kinematic import robot_drawing
from freebody.figures.labelling import Crowd, Wanted, overlaps
from freebody.figures.layers import forces
from freebody.figures.marked_text import plain
from freebody.figures.plots import Plot, plot, thin, ticks
from freebody.figures.snapshot import snapshot, with_values
from freebody.figures.svg import picture
from freebody.figures.svg_symbols import MARKS
from freebody.figures.view import best_view
from freebody.model.joints import KINDS
from freebody.outputs.number_text import significant
from freebody_textbook.drawings.illustrate import illustrations
from support.command import run

Q2, QD2, QDD2 = [0.6, 0.9], [1.0, -0.5], [2.0, 3.0]
ROBOTS = ("2R", "3R", "RP", "pendulum", "ur5e", "panda", "scara", "gyro", "quadrotor")


@pytest.fixture(scope="module")
def arm():
    return fb.planar("RR", l=[0.4, 0.3], lc=[0.2, 0.15], m=[2.0, 1.0], I=[0.03, 0.01])


@pytest.fixture(scope="module")
def diagram(arm):
    return fb.free_body_diagram(arm, Q2, qd=QD2, qdd=QDD2)


def rooted(svg: str) -> ET.Element:
    """The parsed SVG; nothing in it may point outside."""
    assert not re.search(r'(?:href|src)="(?!#)|url\(|<script|@import', svg)
    return ET.fromstring(svg)


# ---------------------------------------------------------------- the stick drawing
def test_planar_arm_stands_where_forward_kinematics_puts_it(arm):
    drawing = robot_drawing(arm, Q2)
    elbow = (0.4 * math.cos(0.6), 0.4 * math.sin(0.6))
    tip = (elbow[0] + 0.3 * math.cos(1.5), elbow[1] + 0.3 * math.sin(1.5))
    first, second = drawing.named("link 1"), drawing.named("link 2")
    assert isinstance(first, Line)
    assert isinstance(second, Line)
    np.testing.assert_allclose(first.points, [(0, 0), elbow], atol=1e-12)
    np.testing.assert_allclose(second.points, [elbow, tip], atol=1e-12)
    com = drawing.named("C_2")
    assert isinstance(com, Mark)
    np.testing.assert_allclose(com.at, np.mean([elbow, tip], axis=0), atol=1e-12)


def test_angles_are_measured_as_in_the_notes(arm):
    drawing = robot_drawing(arm, Q2)
    one, two = drawing.named("θ_1"), drawing.named("θ_2")
    assert isinstance(one, Arc)
    assert isinstance(two, Arc)
    assert one.start == pytest.approx(0.0)
    assert one.sweep == pytest.approx(0.6)
    assert two.start == pytest.approx(0.6), "θ2 is measured from the extended link 1"
    assert two.sweep == pytest.approx(0.9)


def test_slider_stands_at_the_end_of_its_rail():
    arm = fb.planar("RP", l=[0.3, 0.2], lc=[0.1, 0.1], m=[1.0, 1.0], I=[0.1, 0.1])
    drawing = robot_drawing(arm, [0.5, 0.25])
    slider, rail = drawing.named("joint 2"), drawing.named("rod 2")
    assert isinstance(slider, Mark)
    assert isinstance(rail, Line)
    assert slider.kind == "slider"
    u = np.array([math.cos(0.5), math.sin(0.5)])
    np.testing.assert_allclose(slider.at, 0.55 * u, atol=1e-12)
    np.testing.assert_allclose(rail.points, [0.3 * u, 0.55 * u], atol=1e-12)


@pytest.mark.parametrize("kind", KINDS.values(), ids=KINDS)
def test_every_kind_of_joint_names_its_symbol(kind):
    """Solids along an axis are those of kinds that have one."""
    assert kind.mark in {"", *MARKS}
    assert all(part.along == "axis" for part in kind.solids) == (kind.needs_axis or not kind.solids)
    moving, still = ([x for x in kind.solids if x.moves is moves] for moves in (True, False))
    for rod, sleeve in itertools.product(moving, still):  # through which it is seen
        assert rod.half > sleeve.half or rod.along != sleeve.along
        assert rod.radius < sleeve.radius or rod.along != sleeve.along
    if not kind.holds:
        assert not kind.mark, "no joint is drawn where nothing holds a body"
        assert not kind.solids


def test_tip_triad_in_space_is_the_tip_frame():
    arm = fb.load("ur5e")
    q = np.linspace(-1, 1, 6)
    T = fb.forward_kinematics(arm, q)
    drawing = robot_drawing(arm, q)
    for k, name in enumerate("xyz"):
        axis = drawing.named(f"tip {name}")
        assert isinstance(axis, Arrow)
        np.testing.assert_allclose(axis.start, T[:3, 3], atol=1e-12)
        direction = np.subtract(axis.end, axis.start)
        np.testing.assert_allclose(direction / np.linalg.norm(direction), T[:3, k], atol=1e-9)


@pytest.mark.sample(4)
@pytest.mark.parametrize("name", ROBOTS)
def test_every_kind_of_robot_draws(name):
    model = fb.load(name)
    q, qd, qdd = fb.random_state(model, 4)
    root = rooted(picture(robot_drawing(model, q, [fb.neutral(model)])).text())
    assert len(root.findall(".//{*}path")) > 5
    rooted(fb.free_body_diagram(model, q, qd=qd, qdd=qdd).svg)


# ---------------------------------------------------------------- free-body diagrams
def test_names_and_places_of_the_forces_on_link_1(diagram):
    first = diagram.drawings[0]
    elbow = (0.4 * math.cos(0.6), 0.4 * math.sin(0.6))
    com = (0.2 * math.cos(0.6), 0.2 * math.sin(0.6))
    for name, place in (("f_{0,1}", (0, 0)), ("−f_{1,2}", elbow), ("m_1 g", com), ("m_1 a_1", com)):
        np.testing.assert_allclose(first.named(name).start, place, atol=1e-12, err_msg=name)
    assert {a.name for a in diagram.drawings[1].arrows} == {"f_{1,2}", "m_2 g", "m_2 a_2"}


def test_arrows_point_along_the_forces_and_to_one_scale(arm, diagram):
    w = fb.joint_wrenches(arm, Q2, QD2, QDD2)
    values = {"f_{0,1}": w[0, :2], "f_{1,2}": w[1, :2], "−f_{1,2}": -w[1, :2]}
    scales = []
    for drawing in diagram.drawings:
        for arrow in drawing.arrows:
            shown = np.subtract(arrow.end, arrow.start)
            if arrow.name in values:
                np.testing.assert_allclose(arrow.value, values[arrow.name], atol=1e-9)
                scales.append(drawing.scale * np.linalg.norm(shown) / np.linalg.norm(arrow.value))
            assert np.cross([*shown, 0], [*arrow.value, 0])[2] == pytest.approx(0, abs=1e-9)
            assert np.dot(shown, arrow.value) > 0
    np.testing.assert_allclose(scales, scales[0], rtol=1e-9)


def test_third_law_is_seen(diagram):
    on_first, on_second = (
        diagram.drawings[0].named("−f_{1,2}"),
        diagram.drawings[1].named("f_{1,2}"),
    )
    assert on_first.start == pytest.approx(on_second.start)
    np.testing.assert_allclose(
        np.subtract(on_first.end, on_first.start),
        -np.subtract(on_second.end, on_second.start),
        atol=1e-12,
    )
    turn, counter = diagram.drawings[1].named("τ_2"), diagram.drawings[0].named("−τ_2")
    assert isinstance(turn, Turn)
    assert isinstance(counter, Turn)
    assert turn.value == pytest.approx(-counter.value)
    assert turn.at == pytest.approx(counter.at)


def test_third_law_holds_for_moments_in_space(arm):
    first, second = fb.free_body_diagram(arm.to_space(), Q2, qd=QD2, qdd=QDD2).drawings
    on_first, on_second = first.named("−n_{1,2}"), second.named("n_{1,2}")
    np.testing.assert_allclose(
        np.subtract(on_first.end, on_first.start),
        -np.subtract(on_second.end, on_second.start),
        atol=1e-12,
    )


def test_torque_of_a_planar_turn_is_the_inverse_dynamics(arm, diagram):
    tau = fb.inverse_dynamics(arm, Q2, QD2, QDD2)
    for k, drawing in enumerate(diagram.drawings):
        assert drawing.named(f"τ_{k + 1}").value == pytest.approx(tau[k])


def test_friction_makes_the_moment_something_else_than_the_torque():
    arm = fb.planar("R", l=[0.4], lc=[0.2], m=[2.0], I=[0.03], drives=[fb.Drive(viscous=0.5)])
    drawing = fb.free_body_diagram(arm, [0.3], qd=[1.0]).drawing
    moment = drawing.named("n_{0,1}")
    assert isinstance(moment, Turn)
    assert moment.value == pytest.approx(
        float(fb.inverse_dynamics(arm, [0.3], [1.0], [0.0])[0]) - 0.5
    )


def test_external_wrench_stands_at_its_frame(arm):
    drawing = fb.free_body_diagram(arm, Q2, body="link2", wrenches=[3.0, -4.0, 0.5]).drawing
    force = drawing.named("f")
    assert isinstance(force, Arrow)
    assert force.value == (3.0, -4.0)
    np.testing.assert_allclose(force.start, fb.forward_kinematics(arm, Q2)[:2, 2], atol=1e-12)
    assert drawing.named("n").value == 0.5


@pytest.mark.parametrize("name", ROBOTS)
def test_bodies_balance(name):
    model = fb.load(name)
    q, qd, qdd = fb.random_state(model, 11)
    for body in fb.free_body_diagram(model, q, qd=qd, qdd=qdd).bodies:
        size = max(np.linalg.norm(load.force) for load in body.loads)
        turning = max(1.0, *(np.linalg.norm(load.moment) for load in body.loads))
        assert body.force_residual < 1e-11 * max(size, 1.0)
        assert body.moment_residual < 1e-11 * max(turning, size)


def test_plane_and_its_twin_in_space_show_the_same_forces(arm, diagram):
    twin = fb.free_body_diagram(arm.to_space(), Q2, qd=QD2, qdd=QDD2)
    for flat, spatial in zip(diagram.drawings, twin.drawings, strict=True):
        for arrow in flat.arrows:
            other = spatial.named(arrow.name)
            assert isinstance(other, Arrow)
            assert len(arrow.value) == len(arrow.start) == 2, "nothing planar is padded"
            np.testing.assert_allclose(other.value, [*arrow.value, 0.0], atol=1e-9)


@pytest.mark.parametrize("q", ["90 deg,0", "90 deg,180 deg", "-90 deg,0"])
def test_rounding_is_no_load(q, tmp_path, capsys, monkeypatch):
    """An arm that stands upright: the moments of 1e-16 N m at its joints are rounding, drawn and
    listed nowhere."""
    monkeypatch.chdir(tmp_path)
    assert run(["fbd", "2R", "--q", q]) == 0
    assert "10⁻" not in capsys.readouterr().out
    at = [math.radians(float(x.removesuffix("deg"))) for x in q.split(",")]
    arm = fb.load("2R")
    figure = fb.free_body_diagram(arm, at)
    assert not [e for d in figure.drawings for e in d.elements if isinstance(e, Turn)]
    assert "τ_1" in figure.drawings[0].notes[0], "it is said to be 0"
    seen = snapshot(arm, at, [0, 0], [0, 0])
    scales = forces.scales_of(seen.loads)
    sketches = [
        forces.alone(seen, body, forces.BOOK[2], scale)
        for body, scale in zip(seen.pose.bodies, scales, strict=True)
    ]
    assert not [e for d in sketches for e in d.elements if isinstance(e, Turn)]


def test_small_loads_are_shown():
    """A millionth of the weight is no rounding."""
    feather = fb.free_body_diagram(fb.load("2R"), Q2, body=1, wrenches=[3e-6, 0.0, 0.0])
    assert feather.drawing.named("f").value == (3e-6, 0.0)


def test_what_vanishes_is_said_to(arm):
    weightless = arm.replace(gravity=0.0)
    drawing = fb.free_body_diagram(weightless, Q2, body=1, wrenches=[5.0, 0.0, 0.0]).drawing
    assert any("≈ 0" in note and "m_2 g" in note for note in drawing.notes)
    nothing = fb.free_body_diagram(weightless, Q2, body=1)
    rooted(nothing.svg)
    assert nothing.drawing.arrows == []


HANGING = """
[[link]]
name = "rails"
[[link]]
name = "trolley"
mass = 35
[[link]]
name = "boom"
mass = 60
com = [0, 0, -2]
inertia = [0.5, 0, 0, 0.6, 0, 0.1]
[[link]]
name = "hook"
mass = 5
com = [0, 0, -0.02]
[[joint]]
name = "travel"
kind = "prismatic"
parent = "rails"
child = "trolley"
axis = "x"
[[joint]]
name = "ball"
kind = "spherical"
parent = "trolley"
child = "boom"
passive = true
[[joint]]
name = "swivel"
kind = "revolute"
parent = "boom"
child = "hook"
origin = [0, 0, -2]
axis = "y"
passive = true
[[frame]]
name = "eye"
parent = "hook"
origin = [0, 0, -0.02]
"""


@pytest.fixture
def hanging(tmp_path):
    (tmp_path / "crane.toml").write_text(HANGING, encoding="utf-8")
    return fb.load(tmp_path / "crane.toml")


def test_joints_without_motor_rest_unless_a_state_is_given(hanging):
    still = np.zeros(hanging.nv)
    figure = fb.free_body_diagram(hanging)
    needed = fb.inverse_dynamics(hanging, figure.q, still, still)
    assert np.abs(needed).max() < 1e-8
    assert figure.unheld == ()
    assert not any("passive" in note for d in figure.drawings for note in d.notes)


def test_what_a_joint_without_motor_lacks_is_said(hanging):
    q = fb.integrate(hanging, figure_q := fb.neutral(hanging), [0.3, 0.5, 0.0, 0.0, 0.0])
    still = np.zeros(hanging.nv)
    tau = fb.inverse_dynamics(hanging, q, still, still)
    figure = fb.free_body_diagram(hanging, q, labels="both")
    assert f"ball.wx is passive, and this state needs {tau[1]:.0f} N m there" in figure.unheld
    assert not any("ball.wz" in text or "travel" in text for text in figure.unheld)
    assert any("ball.wx is passive" in note for note in figure.drawings[1].notes)
    free = fb.forward_dynamics(hanging, q, still, still)
    assert fb.free_body_diagram(hanging, q, qdd=free).unheld == (), "it swings as it would"
    assert fb.free_body_diagram(hanging, figure_q).unheld == ()
    named = fb.free_body_diagram(hanging, q, labels="names").drawings[1].notes
    assert "ball.wx is passive, and this state needs a torque there" in named


def test_a_body_is_drawn_in_its_own_size(hanging):
    """Beside a boom of 2 m a hook of 2 cm has its vector, and axes no longer than itself; a
    trolley's forces are no dots beside its rail."""
    figure = fb.free_body_diagram(hanging, [1.5, 1, 0, 0, 0, 0], show=["vectors", "axes"])
    trolley, _, hook = figure.drawings
    length = lambda arrow: float(np.linalg.norm(np.subtract(arrow.end, arrow.start)))
    assert length(hook.named("s_3")) == pytest.approx(0.02)
    assert length(hook.named("z_3")) < 0.02
    assert max(length(a) for a in trolley.arrows if a.name.startswith("f")) > 0.5


@pytest.mark.parametrize("name", ["2R", "crane", "ur5e"])
def test_forces_of_all_bodies_are_drawn_to_one_scale(name, hanging):
    """Also where bodies are of unlike size: action and reaction are of one length on the page, and
    what is too small for it is said to be drawn longer."""
    model = hanging if name == "crane" else fb.load(name)
    q, qd, qdd = fb.random_state(model, 3)
    figure = fb.free_body_diagram(model, q, qd=qd, qdd=qdd)
    true = []
    for drawing, body in zip(figure.drawings, figure.bodies, strict=True):
        assert {x.name for x in body.loads if any(x.force)} <= {a.name for a in drawing.arrows}
        longer = "".join(note for note in drawing.notes if note.startswith("longer than to scale"))
        for arrow in drawing.arrows:
            if arrow.unit == "N" and arrow.name not in longer:
                metres = np.linalg.norm(np.subtract(arrow.end, arrow.start))
                true.append(drawing.scale * metres / np.linalg.norm(arrow.value))
    assert len(true) > 2
    np.testing.assert_allclose(true, true[0], rtol=1e-9)


def test_arrows_whose_heads_meet_are_drawn_side_by_side():
    """The reactions that press the rocker of the four-bar from both ends."""
    drawn = illustrations(fb.derive(fb.load("four_bar"), "newton-euler"))["free-body 3"]
    asides = {a.name: a.aside for a in drawn.arrows}
    assert asides["f_{0,3}"] != asides["−f_{3,2}"]


def test_arrows_on_one_line_are_drawn_side_by_side():
    """On an upright link weight and reactions are on one line."""
    drawing = fb.free_body_diagram(fb.load("2R"), [math.pi / 2, 0.0]).drawings[0]
    asides = {a.name: a.aside for a in drawing.arrows}
    assert asides.keys() == {"f_{0,1}", "−f_{1,2}", "m_1 g"}
    assert asides["f_{0,1}"] == 0.0
    assert abs(asides["−f_{1,2}"]) > 5, "its head meets that of the other reaction"
    assert abs(asides["m_1 g"]) > 5, "it goes down beside the reaction that goes up"
    free = fb.free_body_diagram(fb.load("2R"), [0.3, 0.4]).drawings[0]
    assert not any(a.aside for a in free.arrows)


@pytest.mark.sample(1)
@pytest.mark.parametrize("name", ["four_bar", "bricard", "stewart"])
def test_a_body_cut_out_of_a_loop_has_the_joint_there(name):
    """Both bodies that a loop ties have its symbol where its force acts."""
    model = fb.load(name)
    figure = fb.free_body_diagram(model)
    for loop in model.loops:
        ends = [model.frame(frame).body for frame in loop.frames]
        for drawing in (figure.drawings[k] for k in ends if k >= 0):
            assert isinstance(drawing.named(loop.name), Mark | Prism)


def test_every_body_is_seen_in_its_length():
    """A body that the view of the whole robot shows foreshortened is seen from where it is not."""
    figure = fb.free_body_diagram(fb.load("ur5e"))
    for drawing in figure.drawings:
        for e in drawing.elements:
            if isinstance(e, Line) and e.role == "link":
                a, b = map(np.array, (e.points[0], e.points[-1]))
                assert drawing.view.shown(a, b) > 0.6


def test_views_that_show_alike_are_chosen_without_rounding():
    """Opposite ways are seen alike from opposite sides, whatever the last bits say."""
    rng = np.random.default_rng(5)
    for way in rng.normal(size=(20, 3)):
        way[2] = 0.0
        views = {best_view([(np.zeros(3), s * way)]).rows for s in (1.0, -1.0, 1.0 + 1e-13)}
        assert len(views) == 1


def test_lengths_that_are_lost_in_rounding_are_refused():
    arm = fb.planar("RR", l=[1e20, 1], lc=[1, 0.5], m=[1, 1], I=[1, 1])
    with pytest.raises(FreebodyError, match=r"body 2, link2: .* lost in rounding"):
        fb.free_body_diagram(arm).svg
    assert fb.free_body_diagram(arm, body=0).svg
    assert fb.free_body_diagram(fb.planar("R", l=[1e30], lc=[1e30], m=[1], I=[1])).svg


def test_angles_and_lengths_of_a_small_link_fit_it():
    arm = fb.planar("RR", l=[1, 0.03], lc=[0.5, 0.015], m=[3, 0.1], I=[0.1, 1e-4])
    small = fb.free_body_diagram(arm, [0.5, 0.6], show=["lengths", "angles"]).drawings[1]
    (arc,) = [e for e in small.elements if isinstance(e, Arc)]
    assert arc.radius < 0.03
    assert {"l_2", "l_{c2}"} <= {e.name for e in small.elements if isinstance(e, Dimension)}


def test_a_length_that_is_the_centre_s_too_is_drawn_once():
    for name, lengths in {"cart_pole": ["l_2"], "2R": ["l_2", "l_{c2}"]}.items():
        body = fb.free_body_diagram(fb.load(name), [0.5, 0.6], show=["lengths"]).drawings[1]
        assert sorted(e.name for e in body.elements if isinstance(e, Dimension)) == lengths


def test_what_carries_a_floating_base_is_not_called_a_drive():
    floating = fb.load("ur5e", base="free")
    assert fb.free_body_diagram(floating).bodies[0].loads[0].other == "what moves it"


def test_figure_shows_and_saves_itself(diagram, tmp_path):
    assert diagram._repr_svg_() == diagram.svg
    path = diagram.save(tmp_path / "fbd.svg")
    assert rooted(path.read_text(encoding="utf-8")).tag.endswith("svg")
    with pytest.raises(FreebodyError, match=r"'fbd.png' is not an .svg or .pdf file"):
        diagram.save(tmp_path / "fbd.png")
    with pytest.raises(
        FreebodyError, match=r"it has 2 drawings; take one of .drawings, or name a body"
    ):
        diagram.drawing


def test_bad_input_is_refused_by_name(arm):
    with pytest.raises(UnknownNameError, match=r"no body 'link3' in 'RR'. Did you mean 'link[12]'"):
        fb.free_body_diagram(arm, Q2, body="link3")
    with pytest.raises(FreebodyError, match=r"body 2 of 'RR' is not there; it has bodies 0 to 1"):
        fb.free_body_diagram(arm, Q2, body=2)
    with pytest.raises(ShapeError, match=r"free_body_diagram: q has shape \(3,\)"):
        fb.free_body_diagram(arm, [0, 0, 0])


# ---------------------------------------------------------------- names, values, both
def texts(figure) -> set[str]:
    """What stands in a figure, each label without marks."""
    root = ET.fromstring(figure.svg)
    return {"".join(x.itertext()) for x in root.iter("{http://www.w3.org/2000/svg}text")}


def test_arrows_have_names_values_or_both(arm):
    """One drawing: its elements are the same, and only what stands beside them differs."""
    made = {
        how: fb.free_body_diagram(arm, Q2, 0, labels=how) for how in ("names", "values", "both")
    }
    elements = [figure.drawing.elements for figure in made.values()]
    assert elements[0] == elements[1] == elements[2]
    force = np.linalg.norm(fb.joint_wrenches(arm, Q2, [0, 0], [0, 0])[0, :2])
    value = f"{significant(force)} N"
    assert {"f0,1", "τ1", "m1 g"} <= texts(made["names"])
    assert value in texts(made["values"])
    assert f"f0,1\u2002{value}" in texts(made["both"])
    assert not any(text.endswith((" N", " N m")) for text in texts(made["names"]) - {"10 N"})
    assert texts(fb.free_body_diagram(arm, Q2, 0)) == texts(made["both"]), "what it shows unasked"


def test_lengths_and_angles_have_values(arm):
    shown = texts(fb.kinematic_diagram(arm, Q2, "geometry", labels="both"))
    assert {"l1 = 0.400 m", "lc2 = 0.150 m", f"θ1 = {significant(math.degrees(0.6))}°"} <= shown
    assert "0.400 m" in texts(fb.kinematic_diagram(arm, Q2, "geometry", labels="values"))
    assert texts(fb.kinematic_diagram(arm, Q2)) == texts(
        fb.kinematic_diagram(arm, Q2, labels="names")
    )


def test_free_body_of_a_model_with_symbols_shows_names_and_no_number():
    model = fb.planar("RRP")
    figure = fb.free_body_diagram(model)
    assert {"f0,1", "−f1,2", "m1 g", "τ1"} <= texts(figure)
    assert not [x for x in texts(figure) if re.search(r"\d (N|m)", x)], "nothing is measured"
    assert figure.drawings[0].rulers == []
    assert "typical values: 11 parameters have none" in figure.drawings[0].notes[-1]
    with pytest.raises(MissingValueError, match="the loads in the Free-body diagram of RRP"):
        figure.bodies
    with pytest.raises(MissingValueError, match=r"labels='both' of 'RRP': numbers need a value"):
        fb.free_body_diagram(model, labels="both")
    values = dict.fromkeys(model.missing, 1.0) | dict.fromkeys(("I1", "I2", "I3"), 0.1)
    assert fb.free_body_diagram(model.bind(values)).bodies, "given, they are there"


def test_geometry_is_shown_on_wish(arm):
    plain = {e.name for e in fb.free_body_diagram(arm, Q2, 1).drawing.elements}
    shown = fb.free_body_diagram(
        arm, Q2, 1, show=["points", "centres", "lengths", "angles", "vectors"]
    )
    more = {e.name for e in shown.drawing.elements} - plain
    assert {"label A", "label P", "label C_2", "l_2", "l_{c2}", "θ_2", "s_{c2}"} <= more
    assert shown.drawing.named("θ_2").sweep == pytest.approx(Q2[1])
    assert "l_1" not in more, "of this body alone"
    twin = fb.free_body_diagram(arm.to_space(), Q2, 1, show=("axes", "points"))
    np.testing.assert_allclose(twin.drawing.named("z_2").value, [0, 0, 1], atol=1e-12)


def test_wrong_wishes_are_refused_by_name(arm):
    with pytest.raises(UnknownNameError, match=r"Did you mean 'lengths'\? Choices: points"):
        fb.free_body_diagram(arm, Q2, show="length")
    with pytest.raises(UnknownNameError, match=r"Choices: points, centres, axes, vectors"):
        fb.free_body_diagram(arm.to_space(), Q2, show="lengths")
    for draw in (fb.free_body_diagram, fb.kinematic_diagram):
        with pytest.raises(UnknownNameError, match=r"Choices: names, values, both"):
            draw(arm, Q2, labels="numbers")
        with pytest.raises(FreebodyError, match=r"show is 5; give a name, or several"):
            draw(arm, Q2, show=5)


def test_a_centre_without_value_is_drawn_halfway_along_a_link_with_one():
    """That of a link of 0.2 m had been drawn 0.36 m along it."""
    drawn = with_values(fb.planar("RRR", l=["l1", 0.4, 0.2]).bind(l1=0.5)).parameters
    assert drawn["lc1"] == 0.25
    assert with_values(fb.planar("RR")).parameters["lc1"] == 0.45


def test_a_body_that_no_joint_holds_has_no_joint_axes_in_its_caption(page_of):
    page = page_of("quadrotor").read_text(encoding="utf-8")
    assert "Joint axes" not in page
    assert "axes are those of the world" in page
    assert "Joint axes" in page_of("elbow_arm", "kinematics").read_text(encoding="utf-8")


def test_pages_of_derivations_show_values_on_wish(page_of):
    named, both = (fb.derive(fb.load("2R")).html(how) for how in ("names", "both"))
    assert "1.00 m" in both
    assert "1.00 m" not in named
    assert "Values in these drawings: q = (0.600, 0.750)" in both, "the state is said"
    loaded = fb.derive(fb.load("2R"), "statics").html("both")
    assert re.search(r"f = \(\d[\d.]*, −[\d.]+\) N at the tip", loaded), "and the load"
    assert named == page_of("2R").read_text(encoding="utf-8")
    with pytest.raises(
        MissingValueError, match="a derivation's drawings with labels='values' of 'RR'"
    ):
        fb.derive(fb.planar("RR")).html("values")


def test_colours_of_forces_are_in_the_theme():
    from freebody.figures import colours

    assert set(colours.FORCES.values()) <= set(colours.page_colours(dark=True))


# ---------------------------------------------------------------- labels, numbers, curves
def test_labels_keep_apart():
    crowd = Crowd(300, 300)
    boxes = crowd.settle([Wanted(f"label {k}", "", [(150 + 150j, 1)], 45.0) for k in range(6)])
    apart = (overlaps(np.array(boxes[k + 1 :]).reshape(-1, 4), boxes[k]) for k in range(6))
    assert sum(x.sum() for x in apart) < 60
    assert all(b[0] >= 0 and b[1] >= 0 and b[2] <= 300 and b[3] <= 300 for b in boxes)


def test_labels_of_a_diagram_stay_on_the_page(diagram):
    for drawing in diagram.drawings:
        page = picture(drawing, 430, 400)
        for text in ET.fromstring(page.text()).iter("{http://www.w3.org/2000/svg}text"):
            assert 0 <= float(text.get("x", 0)) <= page.width
            assert 0 <= float(text.get("y", 0)) <= page.height


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.0, "0"),
        (9.81, "9.81"),
        (-0.05, "−0.0500"),
        (12345.6, "12346"),
        (1.6e-15, "1.60·10⁻¹⁵"),
        (math.inf, "∞"),
    ],
)
def test_numbers_in_figures(value, text):
    assert significant(value) == text


def test_plain_text_has_no_marks():
    assert plain("−f_{1,2} = τ_2") == "−f1,2 = τ2"


def test_thinned_curve_stays_near_all_samples():
    x = np.linspace(0, 300, 5001)
    y = 80 * np.sin(x / 20) * np.exp(-x / 200)
    kept = thin(x, y, 0.1)
    assert len(kept) < 400
    slope = np.abs(np.gradient(y, x)).max()
    assert np.abs(np.interp(x, x[kept], y[kept]) - y).max() < 0.1 * math.hypot(1, slope)


def test_ticks_are_round():
    assert ticks(0, 5) == [0, 1, 2, 3, 4, 5]
    assert ticks(-0.31, 0.52, 4) == pytest.approx([-0.25, 0, 0.25, 0.5])


def test_plot_marks_peak_and_limit():
    t = np.linspace(0, 1, 200)
    svg = plot(
        Plot("joint_1", t, {"total": 30 * np.sin(6 * t)}, "N m", limits=(-35, 35), now=0.5)
    ).text()
    root = rooted(svg)
    assert len(root.findall(".//{*}path[@class='limit']")) == 2
    assert len(root.findall(".//{*}circle")) == 1
    assert "joint_1" in svg
    rooted(plot(Plot("nothing", t, {"zero": 0 * t}, "J")).text())
    rooted(plot(Plot("tiny", t, {"noise": 1e-15 * t}, "J", log=True)).text())


def test_a_curve_fills_its_plot_however_long_it_lasts():
    t = np.linspace(0.0, 1.0, 21)
    short, long = (plot(Plot("", x, {"a": t**2}, "m")).body for x in (t, 3.0 + 4.0 * t))
    curve = re.compile('<path class="curve s0" d="([^"]*L[^"]*)"')
    assert curve.findall(short) == curve.findall(long) != []
