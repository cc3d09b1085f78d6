"""What results show of themselves: a line in a shell, a small table in a notebook, names as
harmless text."""

from __future__ import annotations

import re

import numpy as np
import pytest

import freebody as fb
from freebody.outputs.display import MOST, TextTable, counted
from support.hostile import hostile


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
        "solutions": fb.inverse_kinematics(model, fb.forward_kinematics(model, q), seed=1),
        "solutions of a batch": fb.inverse_kinematics(
            model, fb.forward_kinematics(model, [q, q]), seed=1
        ),
        "parameters": fb.parameters(model),
        "base parameters": fb.base_parameters(model),
        "singularities": fb.singularities(model),
        "equations": fb.equations(model),
        "diagram": fb.free_body_diagram(model, q),
        "figure": fb.kinematic_diagram(model),
    }
    return made


@pytest.fixture(scope="module")
def arm():
    return results(fb.load("3R"))


def test_a_line_in_a_shell(arm):
    closed = fb.load("five_bar")
    arm |= {
        "derivation": fb.derive(fb.load("2R")),
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
    assert repr(arm["study"]) == "<Study of '3R': 401 samples in 5 s; Not judged>"
    assert repr(arm["solutions of a batch"]).startswith("<Solutions: (2,) targets, ")


def test_a_table_in_a_notebook(arm):
    text = arm["study"]._repr_html_()
    assert text.startswith("<p><b>Study of &#x27;3R&#x27;")
    assert len(re.findall("<tr>", text)) == 1 + 3
    peak = arm["study"].summary.peak_torque.values[0]
    assert f"{peak:.4g} N m" in text
    assert str(arm["study"].verdict) in text
    assert "<td>joint2</td><td>revolute</td>" in arm["model"]._repr_html_()
    rows = re.findall("<tr>", arm["solutions"]._repr_html_())
    assert len(rows) == 1 + min(len(arm["solutions"]), MOST)
    assert f"{abs(arm['motion'].qd[:, 1]).max():.4g}" in arm["motion"]._repr_html_()
    family = fb.load("ur5e").with_payload(mass=[1.0, 2.0])
    assert "of each member" in family._repr_html_()
    assert "loop tip_pin: " in fb.load("five_bar")._repr_html_()
    closed = fb.load("five_bar")
    forces = fb.reactions(closed, fb.assemble(closed), np.zeros(4), qdd=np.zeros(4))
    assert f"<td>tip_pin</td><td>{forces['tip_pin'][0]:.4g}</td>" in forces._repr_html_()
    quadrotor = fb.load("quadrotor")
    assert "q[6]" in fb.default_motion(quadrotor)._repr_html_()


def test_names_of_strangers_stay_text(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for kind, value in results(hostile()).items():
        assert "\u202e" not in repr(value), kind
        text = value._repr_html_() if hasattr(value, "_repr_html_") else ""
        assert not re.search(r"<(?!/?(p|b|table|thead|tbody|tr|th|td)>)", text), kind
        assert "\u202e" not in text


def test_long_tables_say_what_is_left_out():
    table = TextTable(("k",), [(str(k),) for k in range(100)], ["a & b"])
    assert table.html(most=3).count("<tr>") == 4
    assert "<p>… and 97 more</p><p>a &amp; b</p>" in table.html(most=3)
    assert TextTable((), ()).html("nothing <here>") == "<p><b>nothing &lt;here&gt;</b></p>"


def test_counted():
    assert [counted(k, "body") for k in (1, 2)] == ["1 body", "2 bodies"]
    assert counted(0, "loop") == "0 loops"
