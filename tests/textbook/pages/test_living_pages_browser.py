"""Pages of derivations that can be tried, in a real browser under their own policy: their numbers
are Python's, the keyboard is enough, answers are judged and never run."""

from __future__ import annotations

import json
import re
import shutil
from pathlib import Path

import numpy as np
import pytest

import freebody as fb
from freebody_notes.contents import chapters, items
from freebody_notes.item import run_all
from freebody_notes.page import pages
from freebody_textbook.living.line_values import line_values
from freebody_textbook.living.living import is_diagnosed
from support.methods import METHODS
from support.symbolic import coupled

pytestmark = [
    pytest.mark.browser,
    pytest.mark.skipif(
        not (shutil.which("chromium") and shutil.which("chromedriver")),
        reason="needs chromium and chromedriver",
    ),
]

WINDOW = 1500, 900
LARGEST = 600_000  # bytes
REQUEST = "Network.requestWillBeSent"
RANDOM = np.random.default_rng(7)
NAMES = "return [...document.querySelectorAll('.slider input')].map(e => e.dataset.input)"
SET = """const [state] = arguments, inputs = [...document.querySelectorAll('.slider input')];
inputs.forEach((slider, k) => {
  slider.min = -1e6; slider.max = 1e6; slider.value = state[k];
  slider.dispatchEvent(new Event('input')); });"""
STATE = NAMES.replace("dataset.input", "valueAsNumber")
NUMBERS = """return [...document.querySelectorAll('[data-of]')].map(row =>
  [row.dataset.of, Number(row.querySelector('output').title)])"""
VALUES = """return [...document.querySelectorAll('.value')].map(row =>
  [row.dataset.name || row.textContent, row.querySelector('output').title])"""
MOVE = """const [name, value] = arguments;
const slider = document.querySelector(`[data-input=${name}]`);
slider.value = value; slider.dispatchEvent(new Event('input'));"""
ARROWS = """return [...document.querySelectorAll('#bodies g:not(.legend) line.reaction')].map(e =>
  ['x1', 'y1', 'x2', 'y2'].map(name => Number(e.getAttribute(name))))"""
ANSWER = """const [line, text] = arguments;
const field = [...document.querySelectorAll('.answer')].find(f =>
  f.dataset.name === line && f.closest('section').querySelector('.hidden'));
field.querySelector('input').value = text; field.querySelector('button').click();
return [field.querySelector('p').textContent, Boolean(field.closest('.hidden'))]"""


def opened(driver, folder: Path, derivation: fb.Derivation) -> None:
    visited(driver, folder / "derivation.html", derivation.html())


def visited(driver, page: Path, text: str | None = None) -> None:
    """The page, which is not large, asks for nothing and has no error; text: what is written
    there."""
    if text is not None:
        page.write_text(text, encoding="utf-8")
    assert page.stat().st_size < LARGEST
    driver.get_log("performance")
    driver.get(page.as_uri())
    assert not driver.get_log("browser")
    sent = [json.loads(entry["message"])["message"] for entry in driver.get_log("performance")]
    asked = [x["params"]["request"]["url"] for x in sent if x["method"] == REQUEST]
    assert [url for url in asked if not url.startswith("data:")] == [page.as_uri()]


def values(driver) -> dict[str, list[list[float]]]:
    """What stands below the equations, by the left sides in the page's order."""
    found: dict[str, list[list[float]]] = {}
    for name, title in driver.execute_script(VALUES):
        found.setdefault(name, []).append([float(x) for x in title.strip("[]").split(",")])
    return found


@pytest.mark.sample(1)
@pytest.mark.parametrize(
    "model",
    [
        *map(fb.planar, ("RP", "PRR")),
        coupled(fb.planar("RRR"), joint2=("joint1", -1.0, 0.2)),
    ],
)
def test_the_numbers_are_those_of_the_kernels(driver, tmp_path, model):
    """Torques and forces at the joints, against the recursion in numbers, to 1e-9."""
    opened(driver, tmp_path, fb.derive(model, "newton-euler"))
    names = driver.execute_script(NAMES)
    bodies = range(len(model.bodies))
    assert {*model.parameters} - {*names} <= {f"l{len(bodies)}"}  # that of the tip is not needed
    coordinates = fb.equations(model).symbols.coordinates
    for _ in range(3):
        state = RANDOM.uniform(0.2, 1.5, len(names)).tolist()
        driver.execute_script(SET, state)
        shown, numbers = values(driver), dict(zip(names, state, strict=True))
        arm = model.bind(**{name: numbers.get(name, 0.3) for name in model.parameters})
        motion = [[numbers[x + dots] for x in coordinates] for dots in ("", "_d", "_dd")]
        tau, forces = fb.inverse_dynamics(arm, *motion), fb.joint_wrenches(arm, *motion)
        for k in range(model.nv):
            for found in shown[f"tau{k + 1}"]:
                np.testing.assert_allclose(found, [tau[k]], rtol=1e-9, atol=1e-11)
        for k in bodies:
            for found in shown[f"f{k}{k + 1}"]:
                np.testing.assert_allclose(found, forces[k][:2], rtol=1e-9, atol=1e-11)


@pytest.fixture(scope="module")
def notes():
    """Functions that make the pages of the notes, with few items."""
    return list(pages(run_all(items()[:3]), "notes.html").values())[1:]


@pytest.mark.sample(1)
@pytest.mark.parametrize("chapter", chapters())
def test_each_chapter_of_the_notes_has_an_arm_that_moves(driver, tmp_path, notes, chapter):
    visited(driver, tmp_path / "notes.html", notes[chapter - 1]())
    before = values(driver)
    assert len(before) > 3
    name = list(filter(None, driver.execute_script(NAMES)))[int(chapter > 1)]
    driver.execute_script(MOVE, name, 1.1)
    assert values(driver) != before
    driver.find_element("id", "fold").send_keys(" ")  # all steps were folded
    assert driver.find_element("id", "fold").text == "Fold all steps"
    driver.find_element("id", "predict").send_keys(" ")
    assert driver.find_elements("css selector", ".answer")
    if chapter == 3:
        at = dict(driver.execute_script(NUMBERS))
        model = fb.planar("RR")
        arm = model.bind(**{x: at.get(x, 1.0) for x in model.parameters})
        q, qd, qdd = ([at[f"theta{k}{dots}"] for k in (1, 2)] for dots in ("", "_d", "_dd"))
        tau = fb.inverse_dynamics(arm, q, qd, qdd)
        for k in (1, 2):
            for found in values(driver)[f"tau{k}"]:
                np.testing.assert_allclose(found, [tau[k - 1]], rtol=1e-9)


def test_angles_and_parameters_of_a_notation_have_sliders(driver, tmp_path, page_of):
    """Absolute angles from the downward vertical, slender rods: torques are those on the bodies, Bᵀ
    τ at θ = B φ + b; nothing that a page calls τ is another."""
    file, model = tmp_path / "mine.toml", fb.load("2R")
    file.write_text(
        'title = "Mine"\nangles = "absolute"\nzero = "down"\n'
        '[parameters]\nlc = "l/2"\nI = "m*l^2/12"\n'
    )
    opened(driver, tmp_path, fb.derive(model, "lagrange", notation=str(file)))
    names = driver.execute_script(NAMES)
    assert {*model.parameters} - {*names} == {"lc1", "lc2", "I1", "I2"}
    driver.execute_script(SET, RANDOM.uniform(0.2, 1.5, len(names)).tolist())
    at, shown = dict(driver.execute_script(NUMBERS)), values(driver)
    rods = {f"lc{k}": at[f"l{k}"] / 2 for k in (1, 2)}
    rods |= {f"I{k}": at[f"m{k}"] * at[f"l{k}"] ** 2 / 12 for k in (1, 2)}
    arm, B = model.bind(**{x: at.get(x, rods.get(x)) for x in model.parameters}), [[1, 0], [-1, 1]]
    motion = np.array([[at[f"theta{k}{dots}"] for k in (1, 2)] for dots in ("", "_d", "_dd")])
    q, qd, qdd = motion @ np.transpose(B)
    tau = np.transpose(B) @ fb.inverse_dynamics(arm, q - [np.pi / 2, 0], qd, qdd)
    for k in (1, 2):
        np.testing.assert_allclose(np.ravel(shown[f"tau{k}"]), tau[k - 1], rtol=1e-9)
    words = "return [...document.querySelectorAll('#bodies .moment-text')].map(e => e.textContent)"
    said = {word.split(" = ")[0].strip("−") for word in driver.execute_script(words)}
    assert said == {"n0,1", "n1,2"}
    visited(driver, page_of("four_bar", parameters={"lc": "l/2"}))
    assert driver.execute_script(OPEN) == ""
    assert len(values(driver)) > 30


def test_under_a_load_at_rest_too(driver, page_of):
    model = fb.load("2R")
    visited(driver, page_of("2R", "statics"))
    numbers = dict(zip(driver.execute_script(NAMES), driver.execute_script(STATE), strict=True))
    load, q = [numbers["fx"], numbers["fy"], 0.0], [numbers["theta1"], numbers["theta2"]]
    assert "theta1_d" not in numbers
    assert np.linalg.norm(load) > 10
    tau = fb.inverse_dynamics(model, q, [0, 0], [0, 0], wrenches=load)
    forces = fb.joint_wrenches(model, q, [0, 0], [0, 0], wrenches=load)
    shown = values(driver)
    np.testing.assert_allclose([shown["tau1"][0], shown["tau2"][0]], tau[:, None], rtol=1e-9)
    np.testing.assert_allclose(shown["f12"][0], forces[1][:2], rtol=1e-9)


@pytest.mark.sample(1)
@pytest.mark.parametrize("name", ["pendubot", "cart_pole", "furuta"])
def test_a_joint_without_motor_moves_as_it_must(driver, page_of, name):
    """Its acceleration is the one for which it needs no motor: forward dynamics has the same."""
    model = fb.load(name)
    derivation = fb.derive(model, "newton-euler")
    visited(driver, page_of(name, "newton-euler"))
    coordinates = derivation.equations.symbols.coordinates
    state, shown = dict(driver.execute_script(NUMBERS)), values(driver)
    motion = [[state.get(x + dots, 0.0) for x in coordinates] for dots in ("", "_d", "_dd")]
    tau = [shown.get(f"tau{k + 1}", [[0.0]])[0][0] for k in range(model.nv)]
    arm = model.bind(**{x: state[x] for x in model.parameters if x in state})
    np.testing.assert_allclose(fb.forward_dynamics(arm, *motion[:2], tau), motion[2], rtol=1e-9)
    words = "return [...document.querySelectorAll('#bodies .moment-text')].map(e => e.textContent)"
    if name == "pendubot":  # none at its elbow
        assert [word.split(" ")[0] for word in driver.execute_script(words)] == ["τ1"]


@pytest.mark.parametrize("method", METHODS)
def test_every_method_has_a_page_that_can_be_tried(driver, page_of, method):
    name = "acrobot" if method == "newton-euler" else "2R"
    visited(driver, page_of(name, method))
    found = values(driver)
    assert len(found) > 3
    assert all(np.isfinite(row).all() for rows in found.values() for row in rows)
    for rows in found.values():  # one quantity has one value, wherever it stands
        for row in rows:
            np.testing.assert_allclose(row, rows[0], rtol=1e-12, atol=1e-14)


@pytest.mark.sample(1)
@pytest.mark.parametrize("name", ["elbow_arm", "cylindrical_arm"])
def test_the_numbers_of_an_arm_in_space_are_those_of_the_kernels(driver, page_of, name):
    """Torques, and forces at the joints, which the page has in axes of the bodies."""
    model = fb.load(name)
    visited(driver, page_of(name, "newton-euler"))
    names = driver.execute_script(NAMES)
    coordinates = fb.equations(model).symbols.coordinates
    state = RANDOM.uniform(0.2, 1.5, len(names)).tolist()
    driver.execute_script(SET, state)
    shown, numbers = values(driver), dict(zip(names, state, strict=True))
    arm = model.bind(**{name: numbers[name] for name in model.parameters if name in numbers})
    found = dict(driver.execute_script(NUMBERS))
    motion = [[found.get(x + dots, 0.0) for x in coordinates] for dots in ("", "_d", "_dd")]
    tau, forces = fb.inverse_dynamics(arm, *motion), fb.joint_wrenches(arm, *motion)
    assert len(shown["tau1"]) == 3  # as z · n, with the motion, and in the closed form
    for k in range(model.nv):
        for found in shown[f"tau{k + 1}"]:
            np.testing.assert_allclose(found, [tau[k]], rtol=1e-9, atol=1e-11)
        for found in shown[f"f{k}{k + 1}"]:
            size = np.linalg.norm(forces[k][:3])
            np.testing.assert_allclose(np.linalg.norm(found), size, rtol=1e-9)


LONG_ARMS = ["stanford", "puma560", "ur5e", "iiwa14", "gantry_crane"]


@pytest.mark.sample(1)
@pytest.mark.parametrize("name", LONG_ARMS)
@pytest.mark.filterwarnings("ignore::freebody.PhysicalWarning")
def test_the_recursion_of_a_long_arm_runs_in_its_page(driver, page_of, name):
    """Joint by joint as the page prints it: torques and forces are those of the kernels."""
    model = fb.load(name)
    derivation = fb.derive(model)
    visited(driver, page_of(name))
    sliders = driver.execute_script(NAMES)
    driver.execute_script(SET, RANDOM.uniform(0.2, 1.2, len(sliders)).tolist())
    at, found = dict(driver.execute_script(NUMBERS)), values(driver)
    arm = model.bind(**{x: at[x] for x in model.parameters if x in at})
    coordinates = derivation.equations.symbols.coordinates
    motion = [[at.get(x + dots, 0.0) for x in coordinates] for dots in ("", "_d", "_dd")]
    tau, forces = fb.inverse_dynamics(arm, *motion), fb.joint_wrenches(arm, *motion)
    if name != "gantry_crane":
        assert {f"omega{k}" for k in range(1, model.nv + 1)} <= found.keys()
    told = 0
    for k in range(model.nv):
        for one in found.get(f"tau{k + 1}", ()):
            np.testing.assert_allclose(one, [tau[k]], rtol=1e-9, atol=1e-9)
            told += 1
    assert told >= model.nv - len(model.passive)
    sizes = np.linalg.norm(forces[:, :3], axis=1)
    for k in range(len(model.bodies)):
        for one in found.get(f"f{k}{k + 1}", ()) if name in LONG_ARMS[:4] else ():
            np.testing.assert_allclose(np.linalg.norm(one), sizes[k], rtol=1e-9)
    driver.execute_script(MOVE, coordinates[-1], 0.4)
    assert values(driver) != found


def quaternion(*angles: float) -> list[float]:
    """Of yaw, pitch and roll."""
    quat = np.array([1.0, 0.0, 0.0, 0.0])
    for angle, axis in zip(angles, (2, 1, 0), strict=True):
        c, turn = np.cos(angle / 2), np.sin(angle / 2) * np.eye(3)[axis]
        w, v = quat[0], quat[1:]
        quat = np.array([w * c - v @ turn, *(w * turn + c * v + np.cross(v, turn))])
    return quat.tolist()


def in_body_axes(p_d, angles, rates):
    """Velocity and angular velocity by components in the body's axes."""
    (c4, c5, c6), (s4, s5, s6) = np.cos(angles), np.sin(angles)
    R = np.array([
        [c4 * c5, c4 * s5 * s6 - s4 * c6, c4 * s5 * c6 + s4 * s6],
        [s4 * c5, s4 * s5 * s6 + c4 * c6, s4 * s5 * c6 - c4 * s6],
        [-s5, c5 * s6, c5 * c6],
    ])  # fmt: skip
    E = np.array([[-s5, 0.0, 1.0], [c5 * s6, c6, 0.0], [c5 * c6, -s6, 0.0]])
    return np.concatenate([R.T @ p_d, E @ rates])


PAINTED = """const canvas = document.getElementById(`${arguments[0]}-solids`);
const {width, height} = canvas;
const copy = Object.assign(document.createElement('canvas'), {width, height});
const context = copy.getContext('2d', {willReadFrequently: true});
context.drawImage(canvas, 0, 0);
const {data} = context.getImageData(0, 0, width, height);
let count = 0, left = width, top = height, right = 0, bottom = 0;
for (let k = 3; k < data.length; k += 4) {
  if (!data[k]) continue;
  const x = (k >> 2) % width, y = Math.floor((k >> 2) / width);
  count += 1;
  [left, right] = [Math.min(left, x), Math.max(right, x + 1)];
  [top, bottom] = [Math.min(top, y), Math.max(bottom, y + 1)];
}
return {share: count / width / height,
  box: [left / width, top / height, 1 - right / width, 1 - bottom / height]}"""
"""What is painted of a drawing: the share of its pixels, and the margins around them."""


@pytest.mark.long
def test_the_platform_on_six_legs_moves_in_its_page(driver, page_of):
    """The page closes the loops; its forces are those of the kernels, to 1e-9 of the largest."""
    model = fb.load("stewart")
    derivation = fb.derive(model)
    visited(driver, page_of("stewart"))
    legs, names = range(9, 25, 3), derivation.equations.symbols.coordinates
    for k, n in enumerate(legs):
        start = dict(driver.execute_script(NUMBERS))[f"d{n}"]
        for dots, value in (("", start + 0.02 * k - 0.04), ("_d", 0.1 * k - 0.2), ("_dd", 0.3 - k)):
            driver.execute_script(MOVE, f"d{n}{dots}", value)
    at, shown = dict(driver.execute_script(NUMBERS)), values(driver)
    assert driver.execute_script(OPEN) == ""
    q, qd, qdd = (np.array([at[x + dots] for x in names]) for dots in ("", "_d", "_dd"))
    step = 1e-30j  # the derivative of an analytic function, exactly
    body = in_body_axes(qd[:3], q[3:6], qd[3:6])
    moved = in_body_axes(
        qd[:3] + step * qdd[:3], q[3:6] + step * qd[3:6], qd[3:6] + step * qdd[3:6]
    )
    held = fb.reactions(
        model,
        [*q[:3], *quaternion(*q[3:6]), *q[6:]],
        [*body, *qd[6:]],
        qdd=[*(moved.imag / 1e-30), *qdd[6:]],
    )
    size = np.abs(held.multipliers).max()
    found = [at[f"lam{k}"] for k in range(1, 19)]
    np.testing.assert_allclose(found, held.multipliers, rtol=0, atol=1e-9 * size)
    driven = [at for at in range(model.nv) if at not in model.passive]
    for one in shown["tau9"]:
        np.testing.assert_allclose(one, [held.tau[driven[0]]], rtol=1e-9)
    for part in ("arm", "bodies"):
        assert driver.execute_script(PAINTED, part)["share"] > 0.01
    first = driver.execute_script(ARROWS)
    driver.execute_script(
        """const slider = document.getElementById('first'); slider.value = 5;
        slider.dispatchEvent(new Event('input'));"""
    )
    assert driver.execute_script(ARROWS) != first


@pytest.mark.sample(1)
@pytest.mark.parametrize(("name", "count"), [("elbow_arm", 45), ("stanford", 58)])
def test_lines_have_values_where_gravity_is_an_acceleration_of_the_base(name, count):
    derivation = fb.derive(fb.load(name), "recursive")
    text = derivation.html()
    assert text.count('class="value"') >= count
    for k in range(1, len(derivation.tau) + 1):
        assert f'data-name="vc{k}_d"' in text


def test_the_quadrotor_follows_its_four_thrusts(driver, page_of):
    """Its accelerations are those for which the kernel finds the force and moment of the
    thrusts."""
    model = fb.load("quadrotor")
    visited(driver, page_of("quadrotor"))
    for thrusts in ((12.0, 15.0, 9.0, 14.5), (0.0, 3.0, 20.0, 30.0)):
        for k, thrust in enumerate(thrusts, 1):
            driver.execute_script(MOVE, f"T{k}", thrust)
        at = dict(driver.execute_script(NUMBERS))
        quat = quaternion(*(at[f"theta{k}"] for k in (4, 5, 6)))
        moving = [
            [at[f"{letter}_{x}{dots}"] for letter in ("v", "omega") for x in "xyz"]
            for dots in ("", "_d")
        ]
        found = fb.inverse_dynamics(model, [at["x"], at["y"], at["z"], *quat], *moving)
        a, b, c, d = (at[f"T{k}"] for k in (1, 2, 3, 4))
        right = [0.0, 0.0, a + b + c + d, 0.5 * (b - d), -0.5 * (a - c), 0.0]
        np.testing.assert_allclose(found, right, rtol=1e-9, atol=1e-9)
        shown = values(driver)
        told = [shown[f"{letter}_{x}"][0][0] for letter in "fn" for x in "xyz"]
        np.testing.assert_allclose(told, right, rtol=1e-9, atol=1e-9)
    shown = driver.find_elements("css selector", "#bodies .external-text")
    assert [x.text for x in shown] == ["T2", "T3", "T4"]  # T1 is zero


def test_an_arm_in_space_is_seen_from_where_one_likes(driver, page_of):
    visited(driver, page_of("elbow_arm", "newton-euler"))
    arrows, before = np.array(driver.execute_script(ARROWS)), values(driver)
    driver.execute_script(
        """const canvas = document.getElementById('arm-solids');
        for (const key of Array.from({length: 15}, (_, k) => k % 2 ? 'ArrowLeft' : 'ArrowUp')
          .concat(Array(10).fill('ArrowUp'))) {
          canvas.dispatchEvent(new KeyboardEvent('keydown', {key, bubbles: true})); }"""
    )
    moved = np.array(driver.execute_script(ARROWS))
    assert values(driver) == before
    assert np.abs(moved - arrows).max() > 5
    for ends in (arrows, moved):
        _, back, on, *_ = ends[:, 2:] - ends[:, :2]
        np.testing.assert_allclose(on, -back, atol=1e-9)
    # from above, with x down the page: what is vertical in space has no length
    assert np.linalg.norm(moved[:, 2:] - moved[:, :2], axis=1).max() < 20


def test_a_wheel_is_drawn_about_its_axis(driver, page_of):
    """Bodies without extent, the gyro's rotor and the reaction wheel, are discs. All is drawn as
    large as its place lets it, also while it moves."""
    for name in ("gyro", "reaction_wheel", "cart_pole", "furuta"):
        visited(driver, page_of(name, "newton-euler"))
        assert driver.execute_script(PAINTED, "bodies")["share"] > 0.01
        for angle in (0.9, 2.0, -2.5):
            driver.execute_script(MOVE, "theta2" if name == "cart_pole" else "theta1", angle)
            left, top, right, bottom = driver.execute_script(PAINTED, "arm")["box"]
            assert min(left, top, right, bottom) > 0
            assert max(1 - left - right, 1 - top - bottom) > 0.4
    size = {"width": 1200, "height": 900, "deviceScaleFactor": 1, "mobile": False}
    driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
    left, beside = driver.execute_script("""return [...document.querySelectorAll('#try > div')].map(
      e => { const {left, right, top} = e.getBoundingClientRect(); return [left, right, top]; })""")
    driver.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})
    assert left[1] < beside[0]  # drawings, and sliders beside them
    assert left[2] == beside[2]


def test_a_slide_is_drawn_along_its_axis(driver, page_of):
    """The ball's, which begins beside the joint of the beam, was drawn from that joint."""
    visited(driver, page_of("ball_and_beam"))
    driver.execute_script(MOVE, "theta1", 0.7)
    lines = driver.execute_script(
        """return [...document.querySelectorAll('#arm .dimension')].map(e =>
          [e.x2.baseVal.value - e.x1.baseVal.value, e.y1.baseVal.value - e.y2.baseVal.value])"""
    )
    assert lines
    x, y = np.transpose(lines)
    turned = (np.arctan2(y, x) - 0.7 + np.pi / 4) % (np.pi / 2) - np.pi / 4  # along it or across
    np.testing.assert_allclose(turned, 0.0, atol=1e-4)


def test_vectors_of_three_entries_are_predicted(driver, page_of):
    visited(driver, page_of("furuta", "newton-euler"))
    driver.find_element("id", "predict").click()
    for answer, verdict in {
        "[theta2_d, theta1_d sin(theta2), theta1_d cos(theta2)]": "Right: ",
        "theta2_d*[1, 0, 0] + cross([theta1_d, 0, 0], [0, c2, -s2])": "Right: ",
        "[theta2_d, theta1_d sin(theta2), 0]": "Not right: ",
        "cross([1, 0, 0], [theta1_d, theta2_d, 0])": "Not right: ",
        "[theta1_d, theta2_d]": "Cannot be read: omega2 has 3 entries here.",
        "[1, 2] + [1, 2, 3]": "Cannot be read: ",
        "cross(1, [1, 2, 3])": "Cannot be read: ",
        "[1, 2, 3, 4]": "Cannot be read: ",
    }.items():
        said, _ = driver.execute_script(ANSWER, "omega2", answer)
        assert said.startswith(verdict), (answer, said)


CLOSED = [
    ("four_bar", "newton-euler"), ("five_bar", "newton-euler"),
    ("slider_crank", "newton-euler"), ("five_bar_rods", "lagrange-first-kind"),
    ("double_four_bar", "newton-euler"),
    pytest.param("3RRR", "lagrange-first-kind", marks=pytest.mark.long),
    # one of its equations follows from the others
    pytest.param("bricard", "lagrange-first-kind", marks=pytest.mark.long),
]  # fmt: skip
OPEN = "return document.getElementById('open').textContent"


def energies_are_right(shown, arm, q, qd):
    """Of `five_bar_rods` m3 is the mass of body 4."""
    energy = fb.kinetic_energy(arm, q, qd) - fb.potential_energy(arm, q)
    for found in shown.get("L", ()):
        np.testing.assert_allclose(found, [energy], rtol=1e-9, atol=1e-12)


@pytest.mark.sample(1)
@pytest.mark.parametrize(("name", "method"), CLOSED)
def test_a_closed_chain_is_closed_by_its_page(driver, page_of, name, method):
    """The kernels refuse an open loop; torques and forces in joints and loops are theirs."""
    model = fb.load(name)
    derivation = fb.derive(model, method)
    visited(driver, page_of(name, method))
    coordinates = derivation.equations.symbols.coordinates
    moved = driver.execute_script(NAMES)
    driven = [x for x in coordinates if x in moved]
    assert len(driven) == len(coordinates) - fb.mobility(model, fb.assemble(model)).rank
    ends = """return [...document.querySelectorAll('.slider input')].filter(e =>
      arguments[0].includes(e.dataset.input)).map(e => [e.min, e.value, e.max].map(Number))"""
    for low, value, high in driver.execute_script(ends, driven):
        assert low + 0.5 < value < high - 0.5
    for step in (0.0, 0.15, -0.2) if name != "3RRR" else (0.0, -0.05, -0.1):
        for k, x in enumerate(driven):
            start = dict(driver.execute_script(NUMBERS))[x]
            for dots, value in (("", start + step), ("_d", 0.7 - 0.3 * k), ("_dd", 1.1 + step)):
                driver.execute_script(MOVE, x + dots, value)
        state, shown = dict(driver.execute_script(NUMBERS)), values(driver)
        q, qd, qdd = ([state[x + dots] for x in coordinates] for dots in ("", "_d", "_dd"))
        arm = model.bind(**{x: state[x] for x in model.parameters if x in state})
        held = fb.reactions(arm, q, qd, qdd=qdd)
        if not model.passive:  # all joints have motors: the forces in the loops are free
            for k, force in enumerate(held.multipliers, 1):
                driver.execute_script(MOVE, f"lam{k}", force)
            state, shown = dict(driver.execute_script(NUMBERS)), values(driver)
        if all(loop.kind != "distance" for loop in model.loops):
            found = [state[f"lam{k + 1}"] for k in range(len(held.multipliers))]
            np.testing.assert_allclose(found, held.multipliers, rtol=1e-9, atol=1e-10)
        for k in range(len(held.multipliers)):  # as the quotients that the lines end in
            for found in shown.get(f"lam{k + 1}", ()):
                np.testing.assert_allclose(found, [state[f"lam{k + 1}"]], rtol=1e-9, atol=1e-10)
        for k in range(model.nv):
            for found in shown.get(f"tau{k + 1}", ()):
                np.testing.assert_allclose(found, [held.tau[k]], rtol=1e-9, atol=1e-10)
        for n, body in enumerate(model.bodies if method == "newton-euler" else (), 1):
            for found in shown[f"f{body.parent + 1}{n}"]:
                force = held.wrenches[n - 1][:2]
                np.testing.assert_allclose(found, force, rtol=1e-9, atol=1e-10)
        energies_are_right(shown, arm, q, qd)
    assert len(shown) > 10
    if name == "bricard":
        page = derivation.html()
        assert re.search(r'data-name="f05">.*?N \(in axes of the world\)</p>', page)
        assert re.search(r'data-name="f45">.*?N \(in axes of body 5\)</p>', page)
    assert ("L" in shown) == (method == "lagrange-first-kind")
    assert ("lam1" in shown) == (method == "newton-euler" and bool(model.passive))
    assert driver.execute_script(OPEN) == ""


def test_a_loop_that_cannot_be_closed_is_told(driver, page_of):
    """No values and no other drawing then; the values come back with the loop."""
    visited(driver, page_of("four_bar", "newton-euler"))
    before, drawing = values(driver), driver.execute_script(ARROWS)
    long = dict(driver.execute_script(NUMBERS))["d"]
    driver.execute_script("document.querySelector('[data-input=d]').max = 50")
    driver.execute_script(MOVE, "d", 50)
    assert "cannot be closed" in driver.execute_script(OPEN)
    assert all(np.isnan(row).all() for rows in values(driver).values() for row in rows)
    assert driver.execute_script(ARROWS) == drawing
    driver.execute_script(MOVE, "d", long)
    assert driver.execute_script(OPEN) == ""
    for name, rows in values(driver).items():
        np.testing.assert_allclose(rows, before[name], rtol=1e-9, atol=1e-12)


def test_other_robots_have_pages_without_a_script():
    """Of Bricard's loop the equations depend on each other, so that joints without motor tell
    nothing of one of its forces."""
    model = fb.load("bricard").replace(actuated=["joint1"])
    assert "<script" not in fb.derive(model).html()


@pytest.mark.sample(1)
@pytest.mark.parametrize("width", [500, 1000, 1500])
def test_without_a_script_neither_panel_nor_values_are_shown(driver, page_of, tmp_path, width):
    """Nor before it is there: sliders that move nothing, and values without numbers."""
    page, size = tmp_path / "page.html", driver.get_window_size()
    html = page_of("2R", "lagrange").read_text(encoding="utf-8")
    page.write_text(html.replace("<script", "<template").replace("</script", "</template"), "utf-8")
    driver.set_window_size(width, 900)
    driver.execute("get", {"url": page.as_uri()})
    seen = """return [...document.querySelectorAll(arguments[0])]
        .filter((x) => x.getClientRects().length).length"""
    assert not driver.execute_script(seen, ".try, .values")
    assert driver.execute_script(seen, "math") > 40
    driver.set_window_size(size["width"], size["height"])


def test_action_and_reaction_are_drawn_equal(driver, page_of):
    visited(driver, page_of("2R", "newton-euler"))
    arrows = np.array(driver.execute_script(ARROWS))
    _, on_first, on_second = arrows[:, 2:] - arrows[:, :2]
    np.testing.assert_allclose(on_first, -on_second, atol=1e-9)
    assert np.linalg.norm(on_second) > 1


def test_the_keyboard_is_enough(driver, page_of):
    from selenium.webdriver.common.keys import Keys

    visited(driver, page_of("2R", "newton-euler"))
    before = values(driver)
    body = driver.switch_to.active_element
    for _ in range(60):
        body.send_keys(Keys.TAB)
        body = driver.switch_to.active_element
        if body.get_attribute("data-input") == "theta2":
            break
    body.send_keys(Keys.ARROW_RIGHT)
    assert values(driver)["tau1"] != before["tau1"]
    assert values(driver)["omega1"] == before["omega1"]
    state = "return [...document.querySelectorAll('section > details')].map(e => e.open)"
    driver.find_element("id", "fold").send_keys(Keys.SPACE)
    assert not any(driver.execute_script(state))
    driver.find_element("css selector", "section > details > summary").send_keys(Keys.ENTER)
    assert driver.execute_script(state)[:2] == [True, False]
    driver.find_element("id", "again").send_keys(Keys.SPACE)
    assert values(driver) == before

    driver.find_element("css selector", "section > details > summary").send_keys(Keys.ENTER)
    driver.find_element("id", "fold").send_keys(Keys.SPACE)  # all but one are folded: unfold
    driver.find_element("id", "predict").send_keys(Keys.SPACE)
    asked = driver.switch_to.active_element
    for _ in range(200):
        asked.send_keys(Keys.TAB)
        asked = driver.switch_to.active_element
        if asked.tag_name == "input" and asked.get_attribute("type") == "text":
            break
    answer = driver.execute_script("return arguments[0].closest('.answer')", asked)
    for typed, verdict in (("[1, 2]", "Not right: "), ("m2*(vc2_d - gravity)", "Right: ")):
        asked.send_keys(Keys.CONTROL, "a", Keys.NULL, typed, Keys.ENTER)
        said = answer.find_element("css selector", "p").text
        assert said.startswith(verdict), (answer.get_attribute("data-name"), said)


# fmt: off
RIGHT = {
    "tau2": [
        "I2*(theta1_dd + theta2_dd) + m2*lc2*(lc2*(qdd1 + qdd2) + l1*(qdd1 cos(theta2) + "
        "qd1^2 sin(theta2)) + g*c12)",
        "tau2 = I2 omega2_d + cross(sc2, m2*(vc2_d - gravity))",
        "I₂ (θ̈₁ + θ̈₂) + sc2x·f12y − sc2y·f12x",
    ],
    "omega2": [
        "0 - theta1_d^2/(-theta1_d) + theta2_d", "2^-1*2*theta1_d + dtheta2", "(-1)^2 qd1 + θ̇₂",
        "theta1_d/2*2 - -theta2dot", "-(-θ̇₁ − q̇₂)", "omega1*2/(1 + 1) + 2.5e-1·4 theta2_d",
    ],
    "f12": ["m2*(vc2_d - gravity)", "m2*[vc2_dx, vc2_dy + g]"],
}
WRONG = {
    "tau2": ["I2*omega2_d + cross(sc2, m2*vc2_d)", "I2*omega2_d - cross(sc2, f12)", "0", "1/0"],
    "omega2": [
        "-1^2*theta1_d + theta2_d", "theta1_d/(2*2) + theta2_d", "theta1 + theta2", "omega2",
        "theta1_d + 1.00001 theta2_d", "theta1_dd + theta2_dd", "theta1_d - theta2_d", "omega1",
    ],
    "f12": ["m2*(vc2_d + gravity)", "m2*vc2_dx", "[0, 0]"],
}
UNREAD = [
    "tau2", "2 +", "(" * 500 + "1", "alert(1)", "document.title = 'run'",
    "constructor", "__proto__", "sin", "sin(1, 2)", "f12 + 1", "m2 ^ 0.5", "m2^2^2",
    "[1, 2", "<b>1</b>", "'", "x" * 5000, "toString()", "lc2(", "7 = 7",
]
# fmt: on


def test_predict_first(driver, page_of):
    visited(driver, page_of("2R", "newton-euler"))
    shown = "return document.querySelectorAll('.equations:not(.short)')[2].offsetHeight > 0"
    assert driver.execute_script(shown)
    driver.find_element("id", "predict").click()
    assert not driver.execute_script(shown)
    for line, answers in WRONG.items():
        for answer in answers:
            verdict, hidden = driver.execute_script(ANSWER, line, answer)
            assert verdict.startswith(("Not right: ", "Cannot be read")), (answer, verdict)
            assert hidden
            command = f"freebody check ROBOT '{line} = " in verdict
            assert command == (line != "f12" and verdict.startswith("Not right")), verdict
    for answer in UNREAD:
        verdict, hidden = driver.execute_script(ANSWER, "tau2", answer)
        assert verdict.startswith("Cannot be read: "), (answer, verdict)
        assert hidden
    assert driver.title.startswith("2R")
    assert not driver.get_log("browser")
    for line, answers in RIGHT.items():
        for answer in answers:
            verdict, hidden = driver.execute_script(ANSWER, line, answer)
            assert verdict.startswith("Right: "), (answer, verdict)
            assert hidden or line == "f12"  # until the step's other line is right too
    assert driver.execute_script(shown)


_H12, _G1 = "m2 lc2^2 + I2 + m2 l1 lc2 ", "(m1 lc1 + m2 l1) g c1 + m2 lc2 g "
READ = {
    "H12": [
        *(_H12 + x for x in (
            "cos theta2", "cosθ2", "cos θ₂", "c_2", "c_{2}", "cos(q_2)", "cosq2", "cos th2",
            "Cos(theta2)", "\\cos\\theta_2", "cos [theta2]", "cos{theta2}.", "cos -theta2",
            "sin(theta2 + pi/2)", "(cos θ2)",
        )),
        "H_{12} = m_2 l_{c2}^{2} + I_2 + m_2 l_1 l_{c2} \\cos\\theta_2",
        "I2 + m2 [lc2^(2) + l1 l_c2 cos θ2]", "m2lc2^2+I2+m2l1lc2cosθ2",
        "m2 cosθ2 l1 lc2 + m2 lc2² + I2",
        "m2 lc2^2 (sin^2 theta2 + cos²(q2)) + I2 + m2 l1 lc2 c2",
        "\\frac{2 m_2}{2} lc2^2 + I2 + \\left( m2 l1 \\right) lc2 c2",
        _H12 + "cos 2 θ2", _H12 + "sin theta2", _H12 + "cos 2", "m2lc2^2+I2+m2l1lc1cosθ2", _H12,
    ],
    "G1": [
        _G1 + "c_12", _G1 + "cos θ12", _G1 + "cos θ1", _G1 + "cos theta1 + theta2", _G1 + "s12",
        "2 m1 g lc1/2 c1 + m2 g (2 l1/2 c1 + lc2 c12)",
        _G1 + "(c1 c2 − s1 s2)", _G1 + "cos theta1 theta2", "g m1lc1c1 + g m2 (l1c1 + lc2c12)",
    ],
    "omega2": [
        "θ1' + theta2'", "\\dot\\theta_1 + \\dot{\\theta}_2", "dq1 + theta_dot_2",
        "w1 + theta2_dot", "thetadot1 + thetadot2", "\\ddot\\theta_1 + \\dot\\theta_2",
        "θ1'' + θ2'", "theta12_d",
    ],
}  # fmt: skip


def test_pages_read_answers_as_check_does(driver, page_of):
    """What a page reads means the same to `fb.check`."""
    model = fb.load("2R")
    visited(driver, page_of("2R", "newton-euler"))
    driver.find_element("id", "predict").click()
    for line, answers in READ.items():
        for answer in answers:
            said, _ = driver.execute_script(ANSWER, line, answer)
            right = fb.check(model, answer if "=" in answer else f"{line} = {answer}")
            verdict = {True: "Right: ", False: "Not right: "}[bool(right)]
            assert said.startswith(verdict), (answer, said)
    for line, answer in (("omega2", "w2"), ("omega2", "omega_2"), ("f12", "[f12x, f_{12y}]")):
        said, _ = driver.execute_script(ANSWER, line, answer)
        assert said.startswith("Cannot be read: there is no "), said  # its own reason


def test_what_formulas_give_may_be_typed(driver, tmp_path):
    arm = fb.planar("R", l=[1]).bind(lc="l/2", I="m*l^2/12")
    opened(driver, tmp_path, fb.derive(arm, "newton-euler"))
    driver.find_element("id", "predict").click()
    for answer, verdict in (("[lc1 c1, l1/2 s1]", "Right: "), ("lc1 [c1, c1]", "Not right: ")):
        said, _ = driver.execute_script(ANSWER, "sc1", answer)
        assert said.startswith(verdict), (answer, said)


def test_answers_are_typed_in_the_letters_of_the_notation(driver, page_of):
    """Siciliano's l2 is the distance of a centre of mass, a1 a length."""
    visited(driver, page_of("2R", "lagrange", notation="siciliano"))
    driver.find_element("id", "predict").click()
    for line, answer, verdict in (
        ("b22", "ml2*l2^2 + Il2", "Right: "),
        ("g2", "ml2*g*l2*c12", "Right: "),
        ("b22", "ml2*a2^2 + Il2", "Not right: "),
        ("b12", "ml2*(l2^2 + l2^2*c2) + Il2", "Not right: "),
    ):
        said, _ = driver.execute_script(ANSWER, line, answer)
        assert said.startswith(verdict), (line, answer, said)
    assert said.endswith(f"freebody check ROBOT 'b12 = {answer}' --notation siciliano")
    labels = driver.execute_script(
        "return [...document.querySelectorAll('.slider label')].map((x) => x.textContent)"
    )
    assert {"a1", "l1", "l2"} <= {x.replace("\u200b", "").replace(" ", "") for x in labels}


def test_energies_are_typed_as_they_are_printed(driver, page_of):
    """A half in front, squares of vectors, a rate by its own name; steps of which no line can be
    typed are hidden too, since the next could be read off them."""
    visited(driver, page_of("2R", "lagrange"))
    driver.find_element("id", "predict").click()
    for line, answer, said in (
        ("omega1", "theta1_d", "Right: "),
        ("T1", "1/2 m1 vc1^2 + ½ I₁ ω₁²", "Right: "),
        ("T1", "-1/-2 (m1 lc1^2 + I1) theta1_d^2", "Right: "),
        ("T1", "1/2 I1 theta1_d^2", "Not right: "),
        ("T1", "m1 lc1^2/2 theta1_d^2 + I1/2 theta1_d^2", "Right: "),
        ("T1", "m1 lc1^2/m2 theta1_d^2", "Not right: "),
        ("T1", "1½ (m1 lc1^2 + I1)/3 * theta1_d^2", "Cannot be read: the number ½ follows 1"),
        ("T1", "1.0.5 (m1 lc1^2 + I1) theta1_d^2", "Cannot be read: the number .5 follows 1.0"),
        ("T1", "0,5 m1 vc1^2", "Not decided here: More than one equation"),
        ("rc1", "(lc1 c1, lc1 s1)", "Right: "),
        ("rc1", "(lc1 c1, lc1 s1", "Cannot be read: "),
        ("V1", "9.81 m1 lc1 s1", "Right: equal at 8 random states. ‘9.81’ is read as g."),
    ):
        verdict, _ = driver.execute_script(ANSWER, line, answer)
        assert verdict.startswith(said), (answer, verdict)
    again, _ = driver.execute_script(ANSWER, "T1", "1/2 I1 theta1_d^2")
    assert re.match(r"Not right: here it is [\d.]+, the line [\d.]+ J\. ", again), again
    shown = """return [...document.querySelectorAll('section')].filter(step =>
      [...step.querySelectorAll('.equations')].some(e => e.offsetHeight)).length"""
    assert driver.execute_script(shown) == 0
    sections = driver.find_elements("css selector", "section")
    on_paper = next(section for section in sections if "on paper" in section.text)
    on_paper.find_element("tag name", "button").click()
    assert driver.execute_script(shown) == 1


@pytest.mark.parametrize("method", METHODS)
def test_the_commands_that_pages_name_are_understood(method):
    """Every line of which a page names one begins with what `fb.check` knows by that name."""
    model = fb.load("2R")
    found = line_values(fb.derive(model, method))
    asked = [one.line.lhs.name for one in found.lines if is_diagnosed(one, found)]
    for name in dict.fromkeys(asked):
        assert not fb.check(model, f"{name} = 7")
