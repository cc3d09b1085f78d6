"""The report of real robots in a real browser: no error, no request, no blank picture, no sideways
scrolling."""

import json

import pytest

import freebody as fb
from support.browser import browser
from support.real_files import ROBOTS
from support.report_numbers import compare, data_file

pytestmark = pytest.mark.browser

FILES = {
    "ur5": "ur_description/urdf/ur5_robot.urdf",
    "panda": "panda_description/urdf/panda.urdf",
    "xarm7": "xarm_description/urdf/xarm7.urdf",
    "kinova": "kinova_description/robots/kinova.urdf",
    "talos": "talos_data/robots/talos_left_arm.urdf",
    "double_pendulum": "double_pendulum_description/urdf/double_pendulum.urdf",
}
LARGEST = 2_000_000  # bytes
CELLS = """return [...document.querySelectorAll('[data-var]')].map(c => ({
  text: c.querySelector('span').textContent,
  var: c.dataset.var, at: c.dataset.at, value: c.dataset.value, scale: c.dataset.scale || '1'}))"""
PICTURES = """return [...document.querySelectorAll('svg[role=img]')]
  .filter(s => !s.closest('.still')).map(s => {
  const box = s.getBBox(), shown = s.getBoundingClientRect();
  return {label: s.getAttribute('aria-label'), width: box.width, height: box.height,
    shown: shown.width, drawn: s.querySelectorAll('path,circle').length,
    texts: s.querySelectorAll('text').length}})"""
ROOM = "return [document.documentElement.scrollWidth, document.documentElement.clientWidth]"


@pytest.fixture(scope="module")
def chromium(tmp_path_factory):
    with browser(tmp_path_factory.mktemp("profile")) as driver:
        yield driver


def requests(driver) -> list[str]:
    """Addresses that the page asked for; the font in it is none."""
    events = (json.loads(entry["message"])["message"] for entry in driver.get_log("performance"))
    asked = (
        e["params"]["request"]["url"] for e in events if e["method"] == "Network.requestWillBeSent"
    )
    return [url for url in asked if not url.startswith("data:font/")]


def resize(driver, width: int) -> None:
    metrics = {"width": width, "height": 900, "deviceScaleFactor": 1, "mobile": False}
    driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)


def is_blank(picture: dict) -> bool:
    size = min(picture["width"], picture["height"])
    return size < 60 or picture["shown"] < 200 or picture["drawn"] < 4 or picture["texts"] < 3


LATER = ("panda", "xarm7", "kinova", "talos")


@pytest.mark.sample(1)
@pytest.mark.parametrize(
    "name", [pytest.param(x, marks=pytest.mark.long if x in LATER else ()) for x in FILES]
)
@pytest.mark.filterwarnings("ignore::freebody.PhysicalWarning")
def test_report_of_a_real_robot(name, chromium, tmp_path):
    source = ROBOTS / FILES[name]
    if not source.is_file():
        pytest.skip("needs the robots of example-robot-data")
    study = fb.study(fb.load(source))
    path = study.to_html(tmp_path / "index.html")
    assert path.stat().st_size < LARGEST

    requests(chromium)  # what came before
    resize(chromium, 1280)
    chromium.get(path.as_uri())
    assert requests(chromium) == [path.as_uri()]
    assert chromium.get_log("browser") == []

    cells = chromium.execute_script(CELLS)
    assert len(cells) > 50
    with data_file(study, tmp_path) as data:
        assert compare(cells, data) == []

    chromium.execute_script("document.querySelectorAll('details').forEach(d => d.open = true)")
    for width in (1280, 400):
        resize(chromium, width)
        needed, room = chromium.execute_script(ROOM)
        assert needed <= room, f"{name} scrolls sideways at {width} px"
        pictures = chromium.execute_script(PICTURES)
        assert len(pictures) > 8 + len(study.model.bodies)
        blank = [
            p
            for p in pictures
            if min(p["width"], p["height"]) < 60
            or p["shown"] < 200
            or p["drawn"] < 4
            or p["texts"] < 3
        ]
        assert blank == []
