"""Motions of closed chains from files: the drives' positions suffice."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import freebody as fb
from freebody import FileError


def written(path: Path, header: str, *columns: np.ndarray) -> Path:
    rows = [",".join(f"{x:.12g}" for x in row) for row in zip(*columns, strict=True)]
    path.write_text("\n".join([header, *rows]) + "\n", encoding="utf-8")
    return path


@pytest.fixture
def swing() -> tuple[fb.Model, np.ndarray, np.ndarray, np.ndarray]:
    model = fb.load("five_bar")
    start = dict(zip(model.position_names, fb.assemble(model), strict=True))
    t = np.linspace(0.0, 2.0, 81)
    return model, t, start["theta1"] + 0.3 * np.sin(t) ** 2, start["theta2"] - 0.2 * np.sin(t) ** 2


def test_the_drives_positions_suffice(tmp_path, swing):
    model, t, first, second = swing
    motion = fb.read_motion(
        model, written(tmp_path / "pick.csv", "t,theta1,theta2", t, first, second)
    )
    at = dict(zip(model.position_names, motion.q.T, strict=True))
    np.testing.assert_allclose(at["theta1"], first, atol=1e-11)
    np.testing.assert_allclose(at["theta2"], second, atol=1e-11)
    np.testing.assert_allclose(fb.assemble(model, motion.q), motion.q, atol=1e-10)
    study = fb.study(model, motion)
    assert study.checked, [c for c in study.checks if not c.passed]


def test_any_determining_positions_will_do(tmp_path):
    model = fb.load("slider_crank")
    t = np.linspace(0.0, 1.0, 41)
    guide = 0.7 + 0.03 * np.sin(2 * t) ** 2
    motion = fb.read_motion(model, written(tmp_path / "slide.csv", "t,guide", t, guide))
    np.testing.assert_allclose(motion.q[:, model.position_names.index("guide")], guide, atol=1e-11)


@pytest.mark.parametrize(
    ("header", "text"),
    [
        (
            "t,theta1,theta2.v",
            "the positions of theta1 do not determine those of the other joints of 'five_bar'",
        ),
        ("t,theta1,elbow", "no column 'elbow' in a motion of 'five_bar'"),
        (
            "t,theta1.v,theta2.v",
            "there is no position; a motion gives at least those of the driven joints",
        ),
    ],
)
def test_refused(tmp_path, swing, header, text):
    model, t, first, second = swing
    with pytest.raises(FileError, match=text):
        fb.read_motion(model, written(tmp_path / "m.csv", header, t, first, second))


def test_rates_of_the_drives_are_taken_and_others_held_against_the_loops(tmp_path, swing):
    model, t, first, second = swing
    slope, bend = np.sin(2 * t), 2 * np.cos(2 * t)
    table = {"t": t, "theta1": first, "theta2": second}
    rates = {"theta1.v": 0.3 * slope, "theta2.v": -0.2 * slope}
    seconds = {"theta1.a": 0.3 * bend, "theta2.a": -0.2 * bend}
    by_rates = fb.Motion.of(model, table | rates)
    given = fb.Motion.of(model, table | rates | seconds)
    assert (by_rates.differentiated, given.differentiated) == ("rates", "")
    assert not given.notices
    np.testing.assert_array_equal(given.qd[:, :2], np.stack(list(rates.values()), axis=-1))
    np.testing.assert_allclose(by_rates.qdd[:, 1], seconds["theta2.a"], atol=1e-5)
    np.testing.assert_allclose(fb.loop_velocity(model, given.q, given.qd), given.qd, atol=1e-12)
    B = {"B.v": given.qd[:, model.velocity_names.index("B")]}
    assert not fb.Motion.of(model, table | rates | B).notices
    with pytest.raises(fb.FreebodyError, match=r"'B.v' is .* where the loops of 'five_bar'"):
        fb.Motion.of(model, table | rates | {"B.v": 1.1 * B["B.v"]})
    for some in (seconds, {"theta2.v": rates["theta2.v"]}):
        with pytest.raises(fb.FreebodyError, match=r"there is no column for 'theta1.v'"):
            fb.Motion.of(model, table | some)
    twice = {name: 2.0 * column for name, column in rates.items()}
    (told,) = fb.Motion.of(model, table | twice).notices
    assert told.startswith("The rates given for 'theta1', and those of 1 more, are not the slope")


def test_noise_in_given_rates_is_smoothed(swing):
    model, _, first, second = swing
    t = np.linspace(0.0, 2.0, 401)
    slope = np.sin(2 * t) + 1e-3 * np.random.default_rng(1).normal(size=len(t))
    way = np.sin(t) ** 2
    table = {"t": t, "theta1": first[0] + 0.3 * way, "theta2": second[0] - 0.2 * way}
    noisy = fb.Motion.of(model, table | {"theta1.v": 0.3 * slope, "theta2.v": -0.2 * slope})
    clean = fb.smoothed(model, noisy)
    off = [np.abs(x.qdd[50:-50, 0] - 0.6 * np.cos(2 * t[50:-50])).max() for x in (noisy, clean)]
    assert off[1] < 0.02 < 0.1 < off[0]
    np.testing.assert_allclose(clean.q, noisy.q, atol=1e-3)


def test_where_the_loops_end_is_said(tmp_path, swing):
    model, t, first, second = swing
    apart = t / t[-1]  # both cranks outwards: farther than the distal links span
    path = written(
        tmp_path / "m.csv",
        "t,theta1,theta2",
        t,
        first[0] + apart * (np.pi - first[0]),
        second[0] * (1.0 - apart),
    )
    with pytest.raises(
        FileError,
        match=r"the loops of 'five_bar' block the driven joints at sample \d+",
    ):
        fb.read_motion(model, path)


def test_a_column_that_contradicts_the_loops_is_named(tmp_path, swing):
    model, t, first, second = swing
    path = written(tmp_path / "m.csv", "t,theta1,theta2,B", t, first, second, np.zeros_like(t))
    with pytest.raises(
        FileError,
        match=r"'B' is 0 at t = \S+ s, where the loops of 'five_bar' and theta1, theta2 put it",
    ):
        fb.read_motion(model, path)


def four_bar(path: Path, lengths: tuple[float, ...], home: float) -> fb.Model:
    """Crank, coupler, rocker and ground; the crank is driven."""
    text = 'dim = 2\n[[link]]\nname = "ground"\n'
    for name, length, mass in zip(
        ("crank", "coupler", "rocker"), lengths, (1.0, 2.0, 1.5), strict=False
    ):
        text += f'[[link]]\nname = "{name}"\nmass = {mass}\ncom = [{length / 2}, 0]\n'
        text += f"shape = {{ bar = {{ length = {length} }} }}\n"
    at = {"A": ("ground", "crank", 0.0), "B": ("crank", "coupler", lengths[0])}
    for name, (parent, child, x) in (at | {"D": ("ground", "rocker", lengths[3])}).items():
        text += (
            f'[[joint]]\nname = "{name}"\nkind = "continuous"\nparent = "{parent}"\n'
            f'child = "{child}"\n'
        )
        text += f"origin = [{x}, 0]\npassive = {str(name != 'A').lower()}\n"
    for name, parent, x in (("c1", "coupler", lengths[1]), ("c2", "rocker", lengths[2])):
        text += f'[[frame]]\nname = "{name}"\nparent = "{parent}"\norigin = [{x}, 0]\n'
    text += f'[[loop]]\nname = "C"\nkind = "revolute"\nframes = ["c1", "c2"]\n[home]\nA = {home}\n'
    path.write_text(text)
    return fb.load(path)


@pytest.mark.sample(1)
@pytest.mark.parametrize(
    ("lengths", "home"),
    [
        ((0.2, 0.5, 0.4, 0.6), 1.0471975511965976),
        ((0.2439014, 0.27174341, 0.67937908, 0.6363227), 2.40201),
    ],
)
def test_whatever_four_bar_is_studied(tmp_path: Path, lengths: tuple[float, ...], home: float):
    """Between the samples the curve of a motion leaves the loop open by its own error (crank and
    coupler in line); and one slow joint alone is not at rest."""
    model = four_bar(tmp_path / "four.toml", lengths, home)
    found = fb.study(model)
    assert found.checked, [check for check in found.checks if not check.passed]
    motion = found.motion
    tau = fb.inverse_dynamics(model, motion.q, motion.qd, motion.qdd)
    np.testing.assert_allclose(found.data["tau"].values, tau, atol=1e-9)
