"""The page that moves, in a real browser: places of the tip as Python has them, one cursor for
robot, curves and table, keys alone, and the still page where no script runs and on paper."""

from __future__ import annotations

import base64
import json
from dataclasses import replace

import numpy as np
import pytest

import freebody as fb
from support.browser import browser, touched
from support.page_labels import computed
from support.real_files import ROBOTS as ROBOTS_OF_WHEEL

pytestmark = pytest.mark.browser

MOVING = "const done = arguments[0], wait = () => (player ? done() : setTimeout(wait, 5)); wait()"
PLACES = "return player.stage.places(player.q, player.study.scene.tip)"
SAMPLES = "return [[...player.t], player.q.map(q => [...q])]"
KEY = """const [id, key] = arguments, target = document.getElementById(id);
target.focus();
target.dispatchEvent(new KeyboardEvent('keydown', {key, bubbles: true}));
return document.activeElement === target"""
VIEW = (
    "const c = player.stage.camera; return [...c.right, ...c.up, ...c.towards, ...c.aside, c.zoom]"
)
LABELS = """const [states, seed] = arguments, found = [], {camera} = player.stage;
let last = seed;
const random = () => (last = (Math.imul(last, 1664525) + 1013904223) >>> 0) / 4294967296;
const sheet = document.getElementById('names').getBoundingClientRect();
for (let n = 0; n < states; n++) {
  player.show(Math.floor(random() * player.t.length));
  camera.reset();
  camera.turn(360 * random(), 90 * random() - 45);
  if (random() < 0.3) camera.closer(0.5 + 2 * random());
  player.stage.draw();
  const boxes = [...document.querySelectorAll('#names text')].map(t => t.getBoundingClientRect());
  boxes.forEach((a, i) => {
    const beyond = Math.max(sheet.left - a.left, a.right - sheet.right, sheet.top - a.top);
    if (Math.max(beyond, a.bottom - sheet.bottom) > 1) found.push([n, 'cut']);
    boxes.slice(0, i).forEach(b => {
      const wide = Math.min(a.right, b.right) - Math.max(a.left, b.left);
      const high = Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top);
      if (wide > 1 && high > 4) found.push([n, 'overlap']);
    });
  });
}
return found"""
NOW = """player.show(arguments[0]);
return [...document.querySelectorAll('.here tbody tr')].map(row =>
  [...row.querySelectorAll('[data-now]')].map(cell => cell.textContent))"""
WORK = """const done = arguments[0];
player.work.length = 0; player.speed = 1; player.play();
setTimeout(() => { player.pause(); done([player.work, player.k]); }, 1000)"""
PICTURES = """player.stage.hurry(true);
for (let n = 0; n < arguments[0]; n++) player.show(n * 37 % player.t.length);"""
CURVES = "return player.what.compute(...arguments).curves.map(curve => [...curve])"
SLIDE = """for (const [id, value] of Object.entries(arguments[0])) {
  const slider = document.getElementById(id);
  slider.value = value;
  slider.dispatchEvent(new Event('input'));
}
return [...document.querySelectorAll('[data-drive]')].map(r => r.cells[2].textContent)"""
AT = """const element = document.getElementById(arguments[0]);
element.scrollIntoView({block: 'center', behavior: 'instant'});
const {left, top, width, height} = element.getBoundingClientRect();
return [left + width / 2, top + height / 2, width]"""
PIXELS = """const c = document.getElementById('canvas'), seen = new Set();
const {data} = c.getContext('2d').getImageData(0, 0, c.width, c.height);
for (let k = 0; k < data.length; k += 4) seen.add(data[k] << 16 | data[k + 1] << 8 | data[k + 2]);
return seen.size"""
KEYS = """return [[...document.querySelectorAll('.key li')].map(one => {
  const [left, right] = [...one.querySelectorAll('path')].reduce(([a, b], path) => {
    const box = path.getBoundingClientRect();
    return [Math.min(a, box.left), Math.max(b, box.right)];
  }, [1e9, -1e9]);
  return [one.textContent.trim(), right - left];
}), player.study.arrows.lengths, LONGEST]"""
MARKS = """player.show(0);
const box = player.stage.canvas.getBoundingClientRect(), {drives} = player.study;
const marks = [...document.querySelectorAll('.here .mark')].map(mark => mark.textContent);
const drawn = [...document.querySelectorAll('#names text')].map(text => {
  const {left, right, top, bottom} = text.getBoundingClientRect();
  return [text.textContent, (left + right) / 2 - box.left, (top + bottom) / 2 - box.top];
});
return [marks, drawn, drives.map(({at}) => player.stage.at(at))]"""
CARD = """return [...document.querySelectorAll('.card li')].map(row =>
  [row.querySelector('strong')?.textContent ?? '', row.textContent])"""
TOPS = """return ['.ruling', '.hero', '.card', '.instants', 'nav li:last-child', 'nav li'].map(
  one => document.querySelector(one).getBoundingClientRect().top)"""
CUT = """return [...document.querySelectorAll('nav ol, .scroll')]
  .filter(one => one.scrollWidth > one.clientWidth + 1)
  .map(one => getComputedStyle(one).backgroundImage)"""
LARGEST = 800_000  # bytes
ROBOTS = ("2R", pytest.param("ur5e", marks=pytest.mark.long), "five_bar")


@pytest.fixture(scope="module", params=ROBOTS)
def study(request):
    return fb.study(fb.load(request.param))


@pytest.fixture(scope="module")
def path(study, tmp_path_factory):
    return study.to_html(tmp_path_factory.mktemp("page") / "index.html")


@pytest.fixture(scope="module")
def chromium(tmp_path_factory):
    with browser(tmp_path_factory.mktemp("profile")) as driver:
        yield driver


@pytest.fixture
def page(path, chromium):
    """The page, moving."""
    metrics = {"width": 1400, "height": 900, "deviceScaleFactor": 1, "mobile": False}
    chromium.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)
    chromium.get_log("performance")  # what came before
    chromium.get(path.as_uri())
    chromium.execute_async_script(MOVING)
    return chromium


DIGITS = str.maketrans("−⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "--0123456789")


def number(text: str) -> float:
    """A number as the page prints it."""
    return float(text.replace("·10", "e").translate(DIGITS))


def test_the_tip_is_where_python_has_it(study, page, path):
    assert path.stat().st_size < LARGEST
    t, q = map(np.array, page.execute_script(SAMPLES))
    own = np.isin(t, study.motion.t)
    assert own.sum() >= len(t) - 4  # the others are instants of the verdict, between samples
    kept = np.searchsorted(study.motion.t, t[own])
    assert np.array_equal(study.motion.q[kept], q[own])
    assert np.abs(study.motion.at(t)[0] - q).max() < 1e-9
    places = np.array(page.execute_script(PLACES))
    expected = study.data["tip_position"].values[kept]
    assert np.abs(places[own][:, : expected.shape[1]] - expected).max() < 1e-9


def test_the_page_goes_to_the_verdicts_own_instants(study, page):
    """Where a limit is used most between samples, the page shows that instant and its numbers."""
    shown = page.execute_script("return [...player.t]")
    for use in study.verdict.uses[:3]:
        if np.isfinite(use.time) and not study.model.loops:
            assert np.abs(np.array(shown) - use.time).min() < 1e-9 * study.motion.duration
            if use.quantity == "speed":
                k = int(np.argmin(np.abs(np.array(shown) - use.time)))
                row = list(study.model.driven_names).index(use.coordinate)
                told = number(page.execute_script(NOW, k)[row][1])
                assert abs(abs(told) - abs(use.value)) <= 1e-3 * abs(use.value)


def test_nothing_is_asked_for_and_nothing_fails(page, path):
    events = [json.loads(entry["message"])["message"] for entry in page.get_log("performance")]
    asked = [
        e["params"]["request"]["url"] for e in events if e["method"] == "Network.requestWillBeSent"
    ]
    assert [url for url in asked if not url.startswith("data:font/")] == [path.as_uri()]
    assert page.get_log("browser") == []
    assert page.execute_script(PIXELS) > 50  # shades


def test_one_cursor_moves_everything(study, page):
    samples = page.execute_script(SAMPLES)[0]
    instant = next(k for k in range(100, 110) if samples[k] in study.motion.t)
    t = samples[instant]
    k = int(np.searchsorted(study.motion.t, t))
    rows = page.execute_script(NOW, instant)
    assert len(rows) == len(study.model.driven_names)
    for name, row in zip(study.model.driven_names, rows, strict=True):
        at = {"time": k, "coordinate": study.model.velocity_names.index(name)}
        torque = study.data["tau"]
        largest = float(np.abs(torque.isel(coordinate=at["coordinate"])).max())
        assert abs(number(row[-1]) - float(torque.isel(at))) <= 1e-3 * largest
    page.execute_script("document.querySelector('[data-plot] svg').scrollIntoView()")
    told = page.execute_async_script(
        """const done = arguments[0], reading = player.readings[0];
        const look = () => reading.line.getAttribute('x1')
          ? done([reading.time(reading.line.getBoundingClientRect().left),
                  reading.text.textContent])
          : setTimeout(look, 5);
        look()"""
    )
    step = study.motion.duration / 100
    assert abs(told[0] - t) < step
    assert any(character.isdigit() for character in told[1])
    page.execute_script(
        """const svg = document.querySelector('[data-plot] svg'), box = svg.getBoundingClientRect();
        svg.dispatchEvent(new PointerEvent('pointermove', {clientX: box.left + box.width / 2}))"""
    )
    middle = page.execute_script(
        "return [player.t[player.k], Number(player.slider.value), player.k]"
    )
    assert abs(middle[0] - study.motion.duration / 2) < 0.1 * study.motion.duration
    assert middle[1] == middle[2]


def test_the_worst_instant_is_gone_to(study, page):
    page.execute_script("player.show(0); document.querySelector('[data-instant]').click()")
    shown = page.execute_script("return player.t[player.k]")
    assert shown == study.motion.t[study.worst.index]


def test_the_tips_velocity_is_drawn_to_its_scale(study, page):
    """So many pixels for so many metres per second, along the path as it is seen."""
    speed = np.linalg.norm(study.data["tip_velocity"].values, axis=1)
    fastest = study.motion.t[int(speed.argmax())]
    instant = page.execute_script(f"player.seek({fastest}); return player.k")
    lengths, right, up, t = page.execute_script(
        "const {right, up} = player.stage.camera;"
        "return [player.study.arrows.lengths, right, up, [...player.t]]"
    )
    x1, y1, x2, y2 = page.execute_script(
        """const [shaft, head] = ['line.velocity', 'polygon.velocity-head'].map(
          kind => document.querySelector(`#names ${kind}`)), tip = head.points[0];
        return [shaft.x1.baseVal.value, shaft.y1.baseVal.value, tip.x, tip.y]"""
    )
    at = np.interp(t[instant], study.motion.t, np.arange(len(study.motion.t)))
    v = study.data["tip_velocity"].values[round(at)]
    seen = [float(np.dot(v, axis[: len(v)])) for axis in (right, up)]
    expected = 60 / lengths["m/s"] * np.array(seen)
    np.testing.assert_allclose([x2 - x1, y1 - y2], expected, atol=0.5)
    drawn = page.execute_script("return document.querySelectorAll('#names .moment').length")
    assert 0 < drawn <= len(study.model.driven_names)


def test_the_key_shows_arrows_as_long_as_those_on_the_robot(study, page):
    """Each kind of arrows with its value, in the length that has it on the robot."""
    keys, lengths, longest = page.execute_script(KEYS)
    for unit, value in lengths.items():
        ending = f" {value:g} {unit}".replace(" ", "\N{NO-BREAK SPACE}")[1:]
        (long,) = (long for words, long in keys if words.endswith(f" {ending}"))
        assert unit == "N m" or abs(long - longest) < 2.0
    assert len(keys) == len(lengths) + 1
    assert keys[-1][0] == f"path of {study.tip}"


def test_a_drive_has_in_the_table_the_mark_that_stands_at_it_on_the_robot(study, page):
    marks, drawn, places = page.execute_script(MARKS)
    assert len(marks) == len(study.model.driven)
    for mark, (x, y) in zip(marks, places, strict=True):
        near = min((one for one in drawn if one[0] in marks),
                   key=lambda one: np.hypot(one[1] - x, one[2] - y))  # fmt: skip
        assert near[0] == mark


def test_where_limits_are_missing_the_card_tells_what_the_drives_give(study, page):
    rows, card = page.execute_script(CARD), study.card.rows
    if any(row.value != "–" for row in card):
        assert [row.label for row in card] == [
            row[1][: len(x.label)] for row, x in zip(rows, card, strict=True)
        ]
        return
    power = study.data["power"].values[:, list(study.model.driven)]
    together = power.sum(axis=1)
    expected = (
        study.worst.value,
        power.flat[np.argmax(np.abs(power))],
        together[np.argmax(np.abs(together))],
    )
    shown = [number(value.split()[0]) for value, _ in rows[:3]]
    np.testing.assert_allclose(shown, expected, rtol=1e-3)
    assert all(f"{row.label}: {row.remark}" in rows[3][1] for row in card)


def test_on_a_narrow_screen_the_robot_comes_before_the_card(page):
    narrow = {"width": 400, "height": 800, "deviceScaleFactor": 1, "mobile": True}
    page.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", narrow)
    ruling, robot, card, instants, last, first = page.execute_script(TOPS)
    assert ruling < robot < card < instants
    assert robot < narrow["height"]
    assert last == first  # the contents are one line
    assert "none" not in page.execute_script(CUT)  # what is cut off has an edge that shows it
    assert page.execute_script("return document.documentElement.scrollWidth") <= 400


def test_numbers_are_rounded_as_by_python(page):
    """What lies exactly between two numbers with so many digits too: one instant has one time."""
    asked = [k / 16 for k in range(-990, 991, 7)]
    for digits in (2, 3, 4):
        text = "return arguments[0].map(x => significant(x, arguments[1]))"
        told = [number(x) for x in page.execute_script(text, asked, digits)]
        assert told == [float(f"{x:.{digits}g}") for x in asked]


def test_keys_alone_suffice(study, page):
    before = page.execute_script(VIEW)
    for key in ("ArrowLeft", "+"):
        assert page.execute_script(KEY, "canvas", key)
        after = page.execute_script(VIEW)
        assert after != before
        before = after
    page.execute_script(KEY, "canvas", "0")
    page.execute_script(KEY, "canvas", " ")
    assert page.execute_script("return player.playing")
    page.execute_script(KEY, "canvas", " ")
    assert not page.execute_script("return player.playing")
    assert page.execute_script("return find('play').textContent") == "Play"


@pytest.mark.sample(1)
def test_fingers_turn_and_enlarge_the_robot_and_the_page_still_scrolls(study, page):
    """Sideways one finger is the picture's, up and down the page's; two are the picture's."""

    def moved(*fingers):
        before = [*page.execute_script(VIEW), page.execute_script("return scrollY")]
        touch(*fingers)
        after = [*page.execute_script(VIEW), page.execute_script("return scrollY")]
        changed = np.array(after) != before
        return changed[:-2].any(), changed[-2], changed[-1]

    with touched(page) as touch:
        x, y, _ = page.execute_script(AT, "canvas")
        assert moved(*[[(x + d, y)] for d in range(0, 90, 15)]) == (True, False, False)
        assert moved(*[[(x - d, y), (x + d, y)] for d in range(20, 80, 15)])[1:] == (True, False)
        assert moved(*[[(x, y - d)] for d in range(0, 90, 15)])[1:] == (False, True)
        x, y, wide = page.execute_script(AT, "time")
        touch([(x + wide / 4, y)])
    k, count = page.execute_script("return [player.k, player.t.length]")
    assert abs(k / (count - 1) - 0.75) < 0.05


def test_it_plays_by_the_clock(study, page):
    """A second of the motion takes a second; what a frame works is told by the page."""
    start = page.execute_script("player.show(0); return player.k")
    work, k = page.execute_async_script(WORK)
    t = page.execute_script("return player.t[player.k]")
    assert start == 0 < k
    assert len(work) > 3
    assert 0.5 < t < 1.6
    assert np.median(work) < 30  # ms, on a machine with other work


def test_torques_under_another_load_pace_and_tilt_are_those_of_a_study(study, page):
    """What the page computes itself is what Python computes of the robot as it is then."""
    assert page.execute_script("return document.getElementById('unlike')") is None
    if study.model.loops:
        assert not page.execute_script("return Boolean(player.what)")
        assert "No sliders: " in page.find_element("tag name", "main").text
        return
    load = page.execute_script("return Number(find('load').max)") / 4  # one of the slider's steps
    pace, tilt = 1.5, 30.0
    c, s = np.cos(np.deg2rad(-tilt)), np.sin(np.deg2rad(-tilt))
    turned = np.array([[c, -s], [s, c]])
    gravity = study.model.gravity.copy()
    gravity[-2:] = turned @ gravity[-2:]
    model = study.model.with_payload(load).replace(gravity=gravity)
    t, q = map(np.array, page.execute_script(SAMPLES))
    _, qd, qdd = study.motion.at(t)
    qd, qdd = pace * qd, pace**2 * qdd
    expected = fb.inverse_dynamics(model, q, qd, qdd)
    found = np.array(page.execute_script(CURVES, load, pace, tilt)).T
    assert np.abs(found - expected).max() < 1e-9 * np.abs(expected).max()
    rows = page.execute_script(SLIDE, {"load": load, "pace": pace, "tilt": tilt})
    for row, peak in zip(rows, np.abs(expected).max(axis=0), strict=True):
        assert abs(number(row.split()[0]) - peak) <= 1e-3 * peak
    instant = page.execute_script(NOW, 100)
    largest = np.abs(expected).max(axis=0)
    for row, torque, size in zip(instant, expected[100], largest, strict=True):
        assert abs(number(row[-1]) - torque) <= 1e-3 * size
    page.execute_script("find('as-given').click()")
    assert not page.execute_script("return document.querySelector('.otherwise')")


def test_what_python_did_not_write_is_not_offered(study, page):
    if study.model.loops:
        return
    fault = page.execute_script(
        "const wrong = new Float64Array(player.what.what.checked.length * player.what.nv).fill(1);"
        "return player.what.unlike(wrong)"
    )
    assert "not those that Python wrote" in fault


def crowded(page) -> list[list]:
    """Names that overlap or are cut off at 200 random states, seen from anywhere."""
    return [found for seed in range(10) for found in page.execute_script(LABELS, 20, seed)]


def test_names_stand_on_no_other(page):
    assert crowded(page) == []


TOGETHER = """return player.robots.map(({q, stage: {camera, canvas}}) =>
  [q.map(x => [...x]), camera.azimuth, camera.aside[0], canvas.toDataURL()])"""


@pytest.mark.sample(1)
def test_robots_beside_each_other_move_by_one_cursor_and_are_turned_together(
    study, chromium, tmp_path
):
    quick = fb.study(study.model, study.motion, speed=2.0)
    path = fb.compare({"as given": study, "quick": quick}).to_html(tmp_path / "index.html")
    assert path.stat().st_size < LARGEST
    chromium.get_log("performance")
    chromium.get(path.as_uri())
    chromium.execute_async_script(MOVING)
    t = np.array(chromium.execute_script("return [...player.t]"))
    drawn = chromium.execute_script(TOGETHER)
    for (q, *_), one in zip(drawn, (study, quick), strict=True):
        end = one.motion.duration
        own = np.isin(t, one.motion.t) if study.model.loops else t <= end
        assert np.abs(np.array(q)[own] - one.motion.at(t[own])[0]).max() < 1e-9
        assert np.abs(np.array(q)[t >= end][-1] - one.motion.q[-1]).max() < 1e-12
    k = int(np.flatnonzero(np.isin(t, study.motion.t) & np.isin(t, quick.motion.t))[-1])
    chromium.execute_script(f"player.show({k})")
    rows = chromium.execute_script(
        "return [...document.querySelectorAll('.now tbody tr')].map(row =>"
        "  [...row.querySelectorAll('[data-now]')].map(cell => cell.textContent))"
    )
    for row, name in zip(rows, study.model.driven_names, strict=True):
        for told, one in zip(row, (study, quick), strict=True):
            torque = one.data["tau"].sel(coordinate=name)
            right = float(torque[np.flatnonzero(one.motion.t == t[k])[0]])
            assert abs(number(told) - right) <= 1e-3 * float(np.abs(torque).max())
    chromium.execute_script(f"player.show({len(t) - 1})")
    assert chromium.find_element("css selector", "[data-end]").text.startswith("Its motion is over")
    assert {x.text for x in chromium.find_elements("css selector", "tr td:last-child")} >= {"– N m"}
    before = chromium.execute_script(TOGETHER)
    assert chromium.execute_script(KEY, "canvas-0", "ArrowLeft")
    for (_, *seen), (_, *others) in zip(before, chromium.execute_script(TOGETHER), strict=True):
        assert seen[:2] != others[:2]
        assert seen[2] != others[2]
    requests = [json.loads(x["message"])["message"] for x in chromium.get_log("performance")]
    asked = [
        x["params"]["request"]["url"]
        for x in requests
        if x["method"] == "Network.requestWillBeSent"
    ]
    assert asked == [path.as_uri()]
    assert chromium.get_log("browser") == []


def test_the_page_stands_still_without_scripts_and_on_paper(study, path, chromium):
    shown = """return [...document.querySelectorAll('.still, .moving')].map(e =>
      [e.className.split(' ')[0], e.getBoundingClientRect().height > 0])"""
    chromium.execute_cdp_cmd("Emulation.setScriptExecutionDisabled", {"value": True})
    try:
        chromium.get(path.as_uri())
        without = chromium.execute_script(shown)
    finally:
        chromium.execute_cdp_cmd("Emulation.setScriptExecutionDisabled", {"value": False})
    assert [x for x in without if x[0] == "still"] == [["still", True], ["still", True]]
    assert not any(shown for name, shown in without if name == "moving")
    chromium.get(path.as_uri())
    chromium.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": "print"})
    on_paper = chromium.execute_script(shown)
    chromium.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": ""})
    assert {tuple(x) for x in on_paper} == {("still", True), ("moving", False)}
    options = {"preferCSSPageSize": True}
    assert len(base64.b64decode(chromium.execute_cdp_cmd("Page.printToPDF", options)["data"])) > 1e4


SHAPED = """<robot name="shaped">
<link name="base"/>
<link name="upper"><inertial><mass value="3"/><origin xyz="0 0 0.2"/>
<inertia ixx="0.05" iyy="0.05" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>
<visual><origin xyz="0 0.1 0.2" rpy="0.3 0.2 0.5"/>
<geometry><box size="0.1 0.3 0.4"/></geometry></visual></link>
<joint name="pivot" type="revolute"><parent link="base"/><child link="upper"/>
<origin xyz="0 0 0.1"/><axis xyz="0 1 0"/>
<limit lower="-3" upper="3" velocity="2" effort="50"/></joint>
<link name="lower"><inertial><mass value="1"/><origin xyz="0 0 0.1"/>
<inertia ixx="0.01" iyy="0.01" izz="0.002" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="elbow" type="revolute"><parent link="upper"/><child link="lower"/>
<origin xyz="0 0 0.4"/><axis xyz="0 1 0"/>
<limit lower="-2" upper="2" velocity="2" effort="20"/></joint></robot>"""


@pytest.fixture(scope="module")
def shaped(tmp_path_factory):
    file = tmp_path_factory.mktemp("shaped") / "shaped.urdf"
    file.write_text(SHAPED)
    return fb.load(file)


def test_shapes_do_not_make_another_robot(shaped):
    bare = replace(shaped, shapes=())
    assert shaped.shapes
    assert not bare.shapes
    assert bare == shaped
    assert hash(bare) == hash(shaped)


@pytest.mark.long
def test_a_box_of_the_file_stands_where_its_link_is(shaped, chromium, tmp_path):
    """Its eight corners in the page are those that forward kinematics places."""
    path = fb.study(shaped).to_html(tmp_path / "index.html")
    words = "upper is drawn by shapes of the file, lower as a bar."
    assert words in path.read_text(encoding="utf-8")
    chromium.get(path.as_uri())
    q, corners = chromium.execute_async_script(
        """const done = arguments[0], look = () => {
          if (!player) return setTimeout(look, 5);
          player.show(77);
          const {parts, points} = player.stage.solids, {first, end} = parts[parts.length - 1];
          done([[...player.q[77]], [...points.slice(3 * first, 3 * end)]]);
        };
        look()"""
    )
    T = fb.forward_kinematics(shaped, q, "upper")
    R = rotation(0.3, 0.2, 0.5)
    ends = np.array(np.meshgrid([-1, 1], [-1, 1], [-1, 1])).reshape(3, -1).T
    local = [0, 0.1, 0.2] + ends * [0.05, 0.15, 0.2] @ R.T
    expected = local @ T[:3, :3].T + T[:3, 3]
    found = np.array(corners).reshape(-1, 3)
    apart = np.linalg.norm(found[:, None] - expected, axis=-1)
    assert apart.min(axis=0).max() < 2e-6  # a drawing is rounded to a micrometre


@pytest.mark.long
def test_a_red_limit_that_is_not_judged_is_not_called_kept(chromium, tmp_path):
    """Of a robot with impossible inertias the page's own torques are beyond a limit."""
    file = tmp_path / "doubtful.urdf"
    impossible = SHAPED.replace('ixx="0.05"', 'ixx="-0.05"').replace('effort="50"', 'effort="5"')
    file.write_text(impossible)
    with pytest.warns(fb.PhysicalWarning):
        path = fb.study(fb.load(file)).to_html(tmp_path / "index.html")
    chromium.get(path.as_uri())
    chromium.execute_async_script(MOVING)
    told, red = chromium.execute_script(
        "return [find('recomputed').textContent, document.querySelectorAll('#what .over').length]"
    )
    assert red == 1
    assert told.startswith("Not judged; by the numbers that there are the torque of pivot is ")


HUMANOID = ROBOTS_OF_WHEEL / "talos_data/robots/talos_full_v2.urdf"


@pytest.mark.long
@pytest.mark.parametrize(
    ("robot", "largest", "longest"),
    [
        ("ur5e", LARGEST, 6.0),
        ("panda", LARGEST, 16.0),
        ("stewart", LARGEST, 16.0),
        ("template:delta", LARGEST, 16.0),
        pytest.param(
            HUMANOID,
            2_000_000,
            16.0,
            marks=pytest.mark.skipif(not HUMANOID.exists(), reason="needs example-robot-data"),
        ),
    ],
)
@pytest.mark.filterwarnings("ignore::freebody.PhysicalWarning")
def test_pages_are_small_and_their_pictures_quick(chromium, tmp_path, robot, largest, longest):
    """Bytes, and milliseconds of the page's thread for a picture while it plays: robot, names,
    curves and table; and no name stands on another."""
    path = fb.study(fb.load(robot)).to_html(tmp_path / "index.html")
    assert path.stat().st_size < largest
    chromium.get(path.as_uri())
    chromium.execute_async_script(MOVING)
    chromium.execute_script(PICTURES, 20)  # the first are interpreted
    assert computed(chromium, PICTURES, 100) / 100 < longest
    assert crowded(chromium) == []
    assert chromium.get_log("browser") == []


def rotation(roll: float, pitch: float, yaw: float) -> np.ndarray:
    (a, b, c), (x, y, z) = np.cos([roll, pitch, yaw]), np.sin([roll, pitch, yaw])
    return np.array([
        [c * b, c * y * x - z * a, c * y * a + z * x],
        [z * b, z * y * x + c * a, z * y * a - c * x],
        [-y, b * x, b * a],
    ])  # fmt: skip
