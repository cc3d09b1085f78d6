"""The studio's page in a real browser: its numbers are Python's, joints are dragged and the tip
pulled by mouse and keys, the simulation is that of `fb.simulate`, and nothing is asked for."""

from __future__ import annotations

import ast
import json
from dataclasses import replace

import numpy as np
import pytest

import freebody as fb
from support.browser import browser, touched
from support.command import run
from support.helpers import homogeneous_of

pytestmark = [pytest.mark.browser, pytest.mark.usefixtures("numpy_kernels")]

LARGEST = 800_000  # bytes
ROBOTS = ("2R", "five_bar", *(pytest.param(x, marks=pytest.mark.long) for x in ("ur5e", "panda")))
STAND = """page.change(() => {
  page.state.q.set(arguments[0]); page.state.qd.set(arguments[1]); page.state.mass = arguments[2];
})"""
TOLD = """const {state, studio} = page, none = {T: [], J: [], sizes: []};
const look = studio.arm ? state.look() : none;
return [[...state.held()], state.energy(), [...look.T], [...look.J], [...look.sizes]]"""
STATE = "return [[...page.state.q], [...page.state.qd]]"
PLACE = """const box = document.getElementById('canvas').getBoundingClientRect();
const [x, y] = page.bench.at(arguments[0]);
return [box.left + x, box.top + y]"""
GRABBED = """const {bench} = page, tip = page.studio.arm ? bench.at(bench.scene.tip) : [-99, -99];
for (const [role, ...ends] of bench.scene.solids.toReversed()) {
  const [a, b] = ends.slice(0, 2).map(end => inWorld(bench.frames, end));
  const place = a.map((c, k) => (2 * c + 3 * b[k]) / 5);
  const [x, y] = bench.at([0, ...place]), held = bench.picked(x, y);
  if (role === 'link' && held && Math.hypot(x - tip[0], y - tip[1]) > 40) return held.local;
}"""
TYPE = """const field = document.querySelectorAll('[data-place]')[arguments[0]];
field.value = arguments[1]; field.dispatchEvent(new Event('input'))"""
BRANCHES = "return page.state.branches().map(q => [...q])"
RUN = "page.run.law = arguments[1]; page.run.begin(); return page.run.advance(arguments[0])"
FRAMES = """const done = arguments[0];
page.work.length = 0; page.running(true);
setTimeout(() => { page.running(false); done([page.work, page.run.t]); }, 1000)"""
RING = """const chosen = document.getElementById('ellipsoid'), {bench} = page;
chosen.value = 'velocity'; chosen.dispatchEvent(new Event('change'));
const ring = document.querySelector('.handle'), [x, y] = bench.at(bench.scene.tip);
const oval = document.querySelector('.oval').getBBox();
return [ring.cx.baseVal.value - x, ring.cy.baseVal.value - y,
  oval.x + oval.width / 2 - x, oval.y + oval.height / 2 - y, Math.max(oval.width, oval.height)]"""
SEEN = """const {bench} = page, {width, height} = bench.canvas;
return bench.solids.reach(bench.frames).map(place => {
  const [x, y] = bench.camera.seen(place);
  return [x / width, y / height];
})"""
SLIDERS = "return [...document.querySelectorAll('.slid input')].map(x => x.clientWidth)"
SAID = "return document.getElementById('said').textContent"


@pytest.fixture(scope="module", params=ROBOTS)
def model(request):
    return fb.load(request.param)


@pytest.fixture(scope="module")
def path(model, tmp_path_factory):
    path = tmp_path_factory.mktemp("studio") / "index.html"
    assert run(["studio", model.name, "--no-open", "--out", str(path)]) == 0
    return path


@pytest.fixture(scope="module")
def chromium(tmp_path_factory):
    with browser(tmp_path_factory.mktemp("profile")) as driver:
        yield driver


@pytest.fixture
def page(path, chromium):
    """The page, with its proof behind it."""
    metrics = {"width": 1400, "height": 1000, "deviceScaleFactor": 1, "mobile": False}
    chromium.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)
    chromium.get_log("performance")  # what came before
    chromium.get(path.as_uri())
    chromium.execute_async_script(
        "const done = arguments[0], wait = () => (page ? done() : setTimeout(wait, 5)); wait()"
    )
    return chromium


def states(model, page, count=6):
    """States with closed loops: random ones, or those that the page's own simulation leads to."""
    if not model.loops:
        q, qd, _ = fb.random_state(model, 7, count)
        return list(zip(q, qd, strict=True))
    found = []
    for _ in range(count):
        assert page.execute_script(RUN, 40, "off")
        found.append(tuple(map(np.array, page.execute_script(STATE))))
    return found


def drag(page, start, end, steps=4):
    """Presses the mouse at a place of the window, moves it to another, and lets it go."""
    way = np.linspace(start, end, steps + 1)
    kinds = ["mousePressed", *["mouseMoved"] * steps, "mouseReleased"]
    for kind, (x, y) in zip(kinds, [*way, end], strict=True):
        event = {"type": kind, "x": float(x), "y": float(y), "button": "left", "buttons": 1}
        page.execute_cdp_cmd("Input.dispatchMouseEvent", {**event, "clickCount": 1})


def test_all_numbers_are_those_of_python(model, page, path):
    assert path.stat().st_size < LARGEST
    mass = 0.75
    loaded = model.with_payload(mass, frame=model.tip)
    for q, qd in states(model, page):
        page.execute_script(STAND, q.tolist(), qd.tolist(), mass)
        held, energies, T, J, sizes = map(np.array, page.execute_script(TOLD))
        expected = [
            (held, fb.static_torque(loaded, q)),
            (energies, [fb.kinetic_energy(loaded, q, qd), fb.potential_energy(loaded, q)]),
        ]
        if not model.loops:
            d, names = model.dim, ("vx", "vy", "vz", "wx", "wy", "wz")
            rows = names[:d] if model.nv < 6 else names
            expected += [
                (T, np.ravel(fb.forward_kinematics(model, q, model.tip))),
                (J, np.ravel(fb.jacobian(model, q, model.tip)[:d])),
                (sizes, fb.dexterity(model, q, task=rows).singular_values),
            ]
        for found, right in expected:
            assert np.abs(found - right).max() <= 1e-9 * max(np.abs(right).max(), 1.0)


def test_the_simulation_is_that_of_python(model, page):
    q, qd = states(model, page, 1)[0]
    qd = 0.3 * qd
    page.execute_script(STAND, q.tolist(), qd.tolist(), 0.0)
    count = 1000 if model.nv >= 6 else 100  # of NumPy's steps
    page.execute_script("page.run.stops = false")
    assert page.execute_script(RUN, count, "off")
    found = np.concatenate(page.execute_script(STATE))
    method = page.find_element("css selector", "#method").text.partition("method “")[2]
    method = method.partition("”")[0]
    t = 1e-3 * np.arange(count + 1)
    simulated = fb.simulate(model, q, qd, t, method=method)
    end = np.concatenate([simulated.q.values[-1], simulated.qd.values[-1]])
    assert np.abs(found - end).max() < 1e-6 * max(np.abs(end).max(), 1.0)
    gained = page.execute_script("return page.run.gained")
    if method == "rk4":  # without friction nothing is lost
        assert abs(gained) < 1e-4 * np.abs(simulated.kinetic_energy.values).max()
    else:
        assert gained < 0.0


def test_limits_stop_joints_as_in_python(model, page):
    """Impacts are at ends of steps there, and between them in `fb.simulate`."""
    if model.loops or model.nv > 2:
        return
    limits = fb.Limits(lower=-1.0, upper=1.0)
    bodies = [replace(b, joint=replace(b.joint, limits=limits)) for b in model.bodies]
    q, qd = np.array([-0.9, 0.9]), np.array([-1.0, 1.5])
    page.execute_script(STAND, q.tolist(), qd.tolist(), 0.0)
    page.execute_script(
        "for (const joint of page.studio.joints) Object.assign(joint, {low: -1, high: 1})"
    )
    assert page.execute_script(RUN, 200, "off")
    found = np.array(page.execute_script(STATE)[0])
    stopped = replace(model, bodies=tuple(bodies))
    t = 2e-3 * np.arange(101)
    simulated = fb.simulate(stopped, q, qd, t, method="rk4", restitution=0.0)
    assert np.abs(simulated.q.values).max() > 1.0 - 1e-9
    assert np.abs(found - simulated.q.values[-1]).max() < 5e-3


def test_drives_that_carry_the_weight_keep_the_robot_where_it_is(model, page):
    if model.loops:
        return  # redundant drives and passive joints: tried by the numbers of `static_torque`
    before = page.execute_script(STATE)[0]
    assert page.execute_script(RUN, 200, "weight")
    assert np.abs(np.subtract(page.execute_script(STATE)[0], before)).max() < 1e-9


def test_a_link_is_dragged_under_the_pointer(model, page):
    before = np.array(page.execute_script(STATE)[0])
    held = page.execute_script(GRABBED)
    start = np.array(page.execute_script(PLACE, held))
    end = start + [14.0, -11.0]
    drag(page, start, end)
    after = np.array(page.execute_script(STATE)[0])
    if model.loops:
        assert np.abs(after - before).max() > 1e-3
        assert np.abs(fb.assemble(model, after) - after).max() < 1e-9
        return
    assert np.count_nonzero(after != before) == 1
    place, was = np.array(page.execute_script(PLACE, held)), start
    assert np.linalg.norm(place - end) < np.linalg.norm(was - end)
    if model.dim == 2:  # as near as its circle comes
        axis = np.array(page.execute_script(PLACE, [held[0], 0.0, 0.0, 0.0]))
        ways = [x - axis for x in (place, end)]
        beside = abs(np.linalg.det(ways))
        assert beside < 1e-3 * np.prod([np.linalg.norm(x) for x in ways])


def test_the_tip_is_pulled_by_hand_and_by_numbers(model, page):
    if model.loops:
        assert page.find_elements("css selector", ".handle, [data-place]") == []
        return
    *apart, size = page.execute_script(RING)
    assert np.abs(apart).max() < 1.0  # pixels: both are drawn about the tip
    assert size > 20
    tip = page.execute_script("return page.bench.scene.tip")
    start = np.array(page.execute_script(PLACE, tip))
    drag(page, start, start + [-20.0, 15.0])
    assert np.abs(page.execute_script(PLACE, tip) - start - [-20.0, 15.0]).max() < 0.02
    q = np.array(page.execute_script(STATE)[0])
    place = np.asarray(fb.forward_kinematics(model, q, model.tip))[: model.dim, model.dim].copy()
    place[0] -= 0.03
    page.execute_script(TYPE, 0, float(place[0]))
    q = np.array(page.execute_script(STATE)[0])
    reached = np.asarray(fb.forward_kinematics(model, q, model.tip))[: model.dim, model.dim]
    assert abs(reached[0] - place[0]) < 1e-9
    page.execute_script(TYPE, 0, 99.0)
    assert "does not reach" in page.execute_script(SAID)
    q = np.array(page.execute_script(STATE)[0])
    assert (q >= model.limits.lower - 1e-12).all()
    assert (q <= model.limits.upper + 1e-12).all()


@pytest.mark.sample(1)
def test_a_finger_drags_a_link_and_the_page_stays(model, page):
    before = page.execute_script(STATE)[0]
    x, y = page.execute_script(PLACE, page.execute_script(GRABBED))
    with touched(page) as touch:
        touch(*[[(x + d, y + 2 * d)] for d in range(0, 20, 4)])
    assert page.execute_script(STATE)[0] != before
    assert page.execute_script("return scrollY") == 0


def test_branches_lead_to_the_same_pose(model, page):
    if model.loops:
        return
    q = np.array(page.execute_script(STATE)[0])
    rows = model.dim if model.nv < 6 else None  # the position alone, or the pose
    at = np.asarray(fb.forward_kinematics(model, q, model.tip))
    branches = np.array(page.execute_script(BRANCHES))
    assert len(branches) > 1
    for branch in branches:
        pose = np.asarray(fb.forward_kinematics(model, branch, model.tip))
        compared = np.s_[: model.dim, model.dim] if rows else np.s_[:, :]
        assert np.abs(pose - at)[compared].max() < 1e-8


def test_keys_alone_move_it_and_the_state_is_python(model, page):
    from selenium.webdriver.common.keys import Keys

    before = page.execute_script(STATE)[0]
    page.find_element("css selector", "[data-joint] input").send_keys(Keys.ARROW_RIGHT)
    q = page.execute_script(STATE)[0]
    assert q[0] > before[0]
    text = page.find_element("id", "python").get_attribute("value")
    assert ast.literal_eval(text.partition("q = ")[2]) == q


def test_it_runs_by_the_clock_in_quick_pictures(page):
    work, t = page.execute_async_script(FRAMES)
    assert 0.3 < t < 1.6
    assert np.min(work) < 16  # ms, on a machine with other work


def test_numbers_that_python_did_not_write_stop_the_page(page):
    """A kernel that gives one other number is named; the page asks for that before it moves."""
    other = page.execute_async_script(
        """const done = arguments[0], right = kernels.held, {proofs} = page.studio;
        kernels.held = (...all) => {
          const found = right(...all);
          found[0] += 1e-6 * Math.abs(found[0]) + 1e-6;
          return found;
        };
        unlike(proofs).then(async name => {
          kernels.held = right;
          done([name, await unlike(proofs)]);
        })"""
    )
    assert other == ["held", ""]


def test_nothing_is_asked_for_and_a_narrow_window_holds_it(page, path):
    events = [json.loads(entry["message"])["message"] for entry in page.get_log("performance")]
    asked = [
        e["params"]["request"]["url"] for e in events if e["method"] == "Network.requestWillBeSent"
    ]
    assert asked == [path.as_uri()]
    assert page.get_log("browser") == []
    for wide in (400, 920):
        narrow = {"width": wide, "height": 900, "deviceScaleFactor": 1, "mobile": False}
        page.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", narrow)
        assert page.execute_script("return document.documentElement.scrollWidth") <= wide
        assert min(page.execute_script(SLIDERS)) >= 130  # pixels, of two turns


def test_without_scripts_it_is_a_drawing_and_a_table_of_limits(model, path, chromium):
    chromium.execute_cdp_cmd("Emulation.setScriptExecutionDisabled", {"value": True})
    try:
        chromium.get(path.as_uri())
        text = chromium.find_element("tag name", "main").text
        drawn = chromium.find_element("css selector", ".still svg").size["height"]
    finally:
        chromium.execute_cdp_cmd("Emulation.setScriptExecutionDisabled", {"value": False})
    assert drawn > 100
    assert "asks the network for nothing" in text
    assert "no limit" in text or "°" in text
    assert "Simulate" not in text
    assert "load at" not in text


def test_the_robot_fills_its_picture_and_stays_in_it(model, page):
    first = np.array(page.execute_script(SEEN))
    assert (first >= 0.0).all()
    assert (first <= 1.0).all()
    assert np.ptp(first, axis=0).max() > 0.5
    if model.loops:
        return
    q, _, _ = fb.random_state(model, 3, 4)
    for row in q:
        page.execute_script(STAND, row.tolist(), [0.0] * model.nv, 0.0)
        seen = np.array(page.execute_script(SEEN))
        assert (seen > -1e-9).all()
        assert (seen < 1 + 1e-9).all()


OVAL = """<robot name="oval"><link name="base"/><link name="link"><inertial><mass value="2"/>
<inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial><visual>
<origin xyz="0.1 0.2 0.3" rpy="0.3 0.2 0.1"/><geometry><drake:ellipsoid a="0.1" b="0.2" c="0.4"/>
</geometry></visual></link><joint name="j" type="revolute"><parent link="base"/>
<child link="link"/><axis xyz="0 1 0"/><limit lower="-1" upper="1" effort="9" velocity="9"/></joint>
</robot>"""


@pytest.mark.long
def test_an_ellipsoid_of_the_file_is_one_on_the_page(chromium, tmp_path):
    """Its corners lie on it, its normals are across it, and it reaches its six tips."""
    (tmp_path / "oval.urdf").write_text(OVAL)
    path = tmp_path / "index.html"
    assert run(["studio", str(tmp_path / "oval.urdf"), "--no-open", "--out", str(path)]) == 0
    chromium.get(path.as_uri())
    q, points, normals = chromium.execute_async_script(
        """const done = arguments[0], look = () => {
          if (!page) return setTimeout(look, 5);
          const {solids} = page.bench, {first, end} = solids.parts[solids.parts.length - 1];
          done([page.state.q, solids.points, solids.normals].map((x, k) =>
            [...(k ? x.slice(3 * first, 3 * end) : x)]));
        };
        look()"""
    )
    oval = fb.load(tmp_path / "oval.urdf")
    T = fb.forward_kinematics(oval, q, "link") @ homogeneous_of(oval.shapes[0][1].placement)
    R, p = T[:3, :3], T[:3, 3]
    half = np.array([0.1, 0.2, 0.4])
    local = (np.reshape(points, (-1, 3)) - p) @ R / half
    assert np.abs(np.linalg.norm(local, axis=1) - 1.0).max() < 1e-4
    across = local / half
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    assert np.abs(np.reshape(normals, (-1, 3)) @ R - across).max() < 1e-3
    assert (np.abs(local).max(axis=0) > 0.98).all()
