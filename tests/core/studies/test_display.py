"""What results show of themselves: a line in a shell, a small table in a notebook, names as
harmless text."""

from __future__ import annotations

import dataclasses
import re

import numpy as np
import pytest

import freebody as fb
from support.hostile import hostile
from support.public_results import result_classes


def results(model):
    """One of each kind that a model gives, by name."""
    q = np.full(model.nv, 0.3)
    study = fb.study(model)
    made = {
        "model": model,
        "a family": model.bind({"gravity": [9.0, 9.8]}) if model.gravity.any() else model,
        "motion": study.motion,
        "study": study,
        "verdict": study.verdict,
        "solutions": fb.inverse_kinematics(model, fb.forward_kinematics(model, q)),
        "solutions of a batch": fb.inverse_kinematics(model, fb.forward_kinematics(model, [q, q])),
        "parameters": fb.parameters(model),
        "base parameters": fb.base_parameters(model),
        "singularities": fb.singularities(model),
        "equations": fb.equations(model),
        "diagram": fb.free_body_diagram(model, q),
        "figure": fb.kinematic_diagram(model),
        "ellipsoids": fb.ellipsoids(model, q),
        "workspace": fb.workspace(model, np.full(model.dim, 0.1)),
    }
    return made


def shown(value):
    """Its table in a notebook, without the alignment of words."""
    return value._repr_html_().replace(' style="text-align:left"', "")


@pytest.fixture(scope="module")
def arm():
    return results(fb.load("3R"))


def test_a_line_in_a_shell(arm):
    closed = fb.load("five_bar")
    arm |= {
        "derivation": fb.derive(fb.load("2R")),
        "step": fb.derive(fb.load("2R")).steps[0],
        "quantities": fb.quantities(fb.load("2R")),
        "loop equations": fb.loop_equations(closed),
        "mobility": fb.mobility(closed, fb.assemble(closed)),
        "inputs and outputs": fb.input_output(closed, fb.assemble(closed)),
        "verdict of an answer": fb.check(fb.load("2R"), "M11 = 1"),
        "trajectory": fb.sampled_trajectory(np.arange(8.0), np.ones((8, 2))),
        "reactions": fb.reactions(closed, fb.assemble(closed), np.zeros(4), qdd=np.zeros(4)),
    }
    for kind, value in arm.items():
        if kind != "parameters":
            assert len(repr(value)) < 350, kind
            assert "\n" not in repr(value)
            assert "array(" not in repr(value)
    assert repr(arm["study"]) == "<Study of '3R': 402 samples in 5 s; Not judged>"
    assert repr(arm["solutions of a batch"]).startswith("<Solutions: 2 targets, ")


def test_a_table_in_a_notebook(arm):
    text = arm["study"]._repr_html_()
    assert text.startswith("<p><b>Study of &#x27;3R&#x27;")
    assert len(re.findall("<tr>", text)) == 1 + 3
    peak = arm["study"].summary.peak_torque.values[0]
    assert f"{peak:.4g} N m" in text
    assert str(arm["study"].verdict) in text
    assert "<td>joint2</td><td>revolute</td>" in shown(arm["model"])
    rows = re.findall("<tr>", arm["solutions"]._repr_html_())
    assert len(rows) == 1 + len(arm["solutions"]) < 20
    assert f"{abs(arm['motion'].qd[:, 1]).max():.4g}" in arm["motion"]._repr_html_()
    family = fb.load("ur5e").with_payload(mass=[1.0, 2.0])
    assert "of each member" in family._repr_html_()
    assert "loop tip_pin: " in fb.load("five_bar")._repr_html_()
    closed = fb.load("five_bar")
    forces = fb.reactions(closed, fb.assemble(closed), np.zeros(4), qdd=np.zeros(4))
    assert f"<td>tip_pin</td><td>{forces['tip_pin'][0]:.4g}</td>" in shown(forces)
    quadrotor = fb.load("quadrotor")
    assert "q[6]" in fb.default_motion(quadrotor)._repr_html_()


def test_names_of_strangers_stay_text(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for kind, value in results(hostile()).items():
        assert "\u202e" not in repr(value), kind
        text = shown(value) if hasattr(value, "_repr_html_") else ""
        assert not re.search(r"<(?!/?(p|b|table|thead|tbody|tr|th|td)>)", text), kind
        assert "\u202e" not in text


DISPLAYS = ("_repr_html_", "_repr_svg_", "_repr_latex_", "_repr_pretty_")
PLAIN = {
    "Limits", "Drive", "Inertia", "Parameter", "ModelParameter", "Frame", "Coordinates",  # records
    "Members", "LawNumber", "DriveLaw", "Motor", "Gear", "Bearing", "Segment", "RejectedPair",
    "TextTable", "PayloadNumber", "Mistake", "UnreadEquation", "LimitExcess", "Doubt",
    "DoubtKind", "Compared",  # records with a sentence in them
    "Label", "Prism", "Mark", "Arc", "Turn", "Dimension", "Arrow", "Line",
    "Cells", "ColourKey",  # elements of a drawing
    "Drawing", "Picture", "BodyLoads", "Layout", "Order", "Tree", "Structure", "Geometry",
    "CycleLoads", "RestLoads",  # inner
}  # fmt: skip
"""Results that show what Python makes of them."""


def test_no_public_result_forgets_how_to_show_itself():
    """In a line of its own making, or in a notebook; a dataclass of arrays does neither."""
    classes = result_classes()
    forgetful = {
        kind.__name__: origin
        for kind, origin in classes.items()
        if not issubclass(kind, Exception)
        and "Titled" not in {base.__name__ for base in kind.__mro__}
        and not any(hasattr(kind, name) for name in DISPLAYS)
        and (kind.__repr__ is object.__repr__ or dataclasses.is_dataclass(kind))
    }
    assert set(forgetful) <= PLAIN, forgetful
    assert {"Study", "Solutions", "Motion", "Derivation"} <= {kind.__name__ for kind in classes}


def test_results_made_of_formulas_show_them():
    path = fb.trajectory("3*t^2", "sin(t)")
    assert repr(path) == "<Trajectory: r = [3 t², sin t]>"
    assert repr(path.velocity) == "<Function of t: [6 t, cos t]>"
    assert repr(path.velocity.rows) == "(6*t, 1*cos(1*t))"
    free = fb.quantities(fb.planar("RR"))
    holds = fb.relation(free, "omega2 = theta1_d + theta2_d")
    assert repr(holds) == (
        "<Relation omega2 = theta1_d + theta2_d: both sides are equal, as polynomials>"
    )
    assert repr(fb.relation(free, "omega2 = theta1_d")).endswith("the sides differ>")
    condition = fb.singularities(fb.planar("RR")).conditions[0]
    assert repr(condition) == "<Condition: θ₂ = 0 or π>"
    assert condition._repr_latex_().startswith("$\\displaystyle ")


def test_a_notebook_shows_words_where_words_say_it():
    said: list[str] = []
    printer = type("Printer", (), {"text": staticmethod(said.append)})()
    closed = fb.load("five_bar")
    for value in (
        fb.mobility(closed, fb.assemble(closed)),
        fb.check(fb.load("2R"), "M11 = 1"),
        fb.base_parameters(fb.load("2R")),
        fb.loop_equations(closed),
    ):
        value._repr_pretty_(printer, False)
        assert said.pop() == str(value)


def test_figures_bring_their_own_paper():
    """A notebook's theme and the system's need not agree."""
    svg = fb.kinematic_diagram(fb.load("2R"))._repr_svg_()
    assert svg.count(".fig{background:#") == 2


@pytest.mark.sample(1)
@pytest.mark.parametrize("robot", ["2R", "four_bar"])
def test_a_step_shows_itself_as_its_derivation_shows_it(robot):
    derivation = fb.derive(fb.load(robot))
    whole, page = str(derivation), derivation._repr_html_()
    for step in derivation.steps:
        heading, *rest = str(step).splitlines()
        assert heading.startswith(step.operation)
        assert "\n".join(rest) in whole
        assert step._repr_html_().split("</h2>")[1].split("<div")[0] in page
        assert repr(step.equations).count("<Equation ") == len(step.equations)
