"""Figures of a study by themselves, the moving one among them."""

import re
import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest

import freebody as fb
from support.command import run

NAMES = (
    "robot", "animation", "free_bodies", "kinematics", "gravity", "motion", "torques", "powers",
    "energies", "residual", "reactions", "drift",
)  # fmt: skip
SVG = "{http://www.w3.org/2000/svg}"


@pytest.fixture(scope="module")
def study():
    model = fb.planar("RP", l=[1.0, 0.5], m=[2.0, 1.0], I=[0.1, 0.05], lc=[0.5, 0.25])
    return fb.study(model)


def numbers(path):
    return np.array(re.findall(r"(-?[\d.]+) (-?[\d.]+)", path), dtype=float)


def of_class(element, css):
    return [e for e in element.iter() if e.get("class") == css]


@pytest.mark.sample(8)
@pytest.mark.parametrize("name", NAMES)
def test_every_figure_stands_alone(study, name, tmp_path):
    figure = study.figure(name)
    written = figure.save(tmp_path / f"{name}.svg").read_text(encoding="utf-8")
    root = ElementTree.fromstring(written)
    assert root.tag == f"{SVG}svg"
    assert "@media" in written
    assert "http" not in written.replace("http://www.w3.org/2000/svg", "")
    assert "<script" not in written
    assert len(figure.titles) == len(figure.panels) >= 1


def test_the_command_names_every_figure(capsys):
    assert run(["study", "--help"]) == 0
    assert set(NAMES) <= set(re.findall(r"\w+", capsys.readouterr().out))


def test_panels_of_unlike_units_are_all_there(study):
    """A robot that turns and slides has two panels of one title, in rad and in m."""
    titles = study.figure("motion").titles
    assert [titles.count(title) for title in ("Position", "Speed", "Acceleration")] == [2, 2, 2]
    assert study.figure("motion", "Speed").titles == ("Speed", "Speed")


def test_panels_are_chosen_by_their_titles_in_the_order_given(study):
    first, second = study.model.driven_names
    assert study.figure("torques").titles == (first, second)
    assert study.figure("torques", [second, first]).titles == (second, first)
    assert study.figure("torques", second).panels == study.figure("torques").panels[1:]
    bodies = tuple(body.name for body in study.model.bodies)
    assert study.figure("free_bodies").titles == bodies


def test_what_is_not_there_is_refused_with_what_is(study, tmp_path):
    with pytest.raises(fb.UnknownNameError, match=r"no figure 'torque' in a study"):
        study.figure("torque")
    with pytest.raises(fb.UnknownNameError, match=r"no panel 'elbow' in the figure 'torques'"):
        study.figure("torques", "elbow")
    with pytest.raises(fb.FreebodyError, match="there is nothing to draw"):
        study.figure("lifting")
    with pytest.raises(fb.FreebodyError, match="only names no panel"):
        study.figure("torques", [])
    with pytest.raises(fb.FreebodyError, match=r"is not an .svg or .pdf file"):
        study.figure("torques").save(tmp_path / "torques.png")


def test_the_tip_of_every_pose_lies_on_the_path_and_is_where_the_motion_says(study):
    root = ElementTree.fromstring(study.figure("animation").svg)
    poses = of_class(root, "pose")
    (path,) = (numbers(e.get("d")) for e in of_class(root, "tippath"))
    tips = [of_class(pose, "position-head")[-1] for pose in poses]
    drawn = np.array([[float(tip.get("cx")), float(tip.get("cy"))] for tip in tips])
    assert np.ptp(drawn, axis=0).min() > 20.0
    off = np.abs(drawn[:, None] - path).sum(axis=-1).min(axis=1)
    assert off.max() < 3.0
    instants = study.motion.duration * np.arange(len(poses)) / len(poses)
    world = study.data["tip_position"].values
    at = np.stack([np.interp(instants, study.motion.t, x) for x in world.T], axis=-1)
    # pixels are an affine map of metres: y points down, one scale for both
    ones = np.column_stack([at, np.ones(len(at))])
    fitted, *_ = np.linalg.lstsq(ones, drawn, rcond=None)
    assert np.abs(ones @ fitted - drawn).max() < 3.0
    assert fitted[0, 0] == pytest.approx(-fitted[1, 1], rel=0.02)


def test_links_are_as_long_in_every_pose(study):
    """Also after their places were written as steps from one to the next; the second slides out."""
    poses = of_class(ElementTree.fromstring(study.figure("animation").svg), "pose")
    lengths = []
    for pose in poses:
        bars = [re.findall(r"-?[\d.]+", bar.get("d")) for bar in of_class(pose, "bar")]
        lengths.append([np.hypot(float(x), float(y)) for *_, x, y in bars])
    assert np.ptp(lengths, axis=0)[0] < 0.3  # pixels
    assert np.min(lengths) > 20.0


def test_poses_take_turns(study):
    """At each instant one pose is seen: the delays are a whole round, evenly spaced."""
    figure = study.figure("animation").svg
    poses = of_class(ElementTree.fromstring(figure), "pose")
    count, seconds = len(poses), study.motion.duration
    delays = [float(re.search(r"-?[\d.]+", pose.get("style")).group()) for pose in poses]
    assert delays == pytest.approx(seconds * (np.arange(count) / count - 1.0), abs=1e-3)
    shown = re.search(r"visible\}([\d.]+)%", figure)
    assert float(shown.group(1)) == pytest.approx(100.0 / count)
    assert f"@keyframes pose{count}" in figure
    own = f";animation-duration:{seconds:.9g}s;animation-name:pose{count}"
    assert all(own in pose.get("style") for pose in poses)
    assert "prefers-reduced-motion" in figure
    resting = [pose.get("style").endswith(";visibility:visible") for pose in poses]
    assert resting == [True] + [False] * (count - 1)  # seen where nothing moves


def test_a_pdf_page_is_as_large_as_the_figure(study, tmp_path):
    pdfium = pytest.importorskip("pypdfium2", reason="needs pypdfium2, which reads PDF")
    figure = study.figure("energies")
    document = pdfium.PdfDocument(figure.save(tmp_path / "energies.pdf"))
    assert len(document) == 1
    size = 0.75 * np.array([figure.picture.width, figure.picture.height])
    assert document[0].get_size() == pytest.approx(size, abs=1.5)
