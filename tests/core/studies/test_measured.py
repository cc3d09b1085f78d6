"""Measured torques beside computed ones, and the page of a duty cycle: what is printed is what the
data hold."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

import freebody as fb
from support.command import told
from support.report_numbers import Cells, compare, data_file


@pytest.fixture(scope="module")
def arm() -> fb.Model:
    return fb.load("2R")


@pytest.fixture(scope="module")
def study(arm: fb.Model) -> fb.Study:
    return fb.study(arm)


@pytest.fixture(scope="module")
def measured(arm: fb.Model, study: fb.Study) -> fb.Study:
    """Of the middle of the motion, 0.3 and 0.7 N m too large."""
    t, tau = study.motion.t, study.data["tau"].values
    some = (t >= 0.5) & (t <= 4.0)
    return fb.study(arm, study.motion, measured=(t[some], tau[some] + [0.3, 0.7]))


def test_a_constant_offset_is_the_rms_difference(study, measured, tmp_path):
    off = measured.summary["measured_rms_difference"].values
    np.testing.assert_allclose(off, [0.3, 0.7], rtol=1e-12)
    t, tau = study.motion.t, study.data["tau"].values + [0.3, 0.7]
    some = (t >= 0.5) & (t <= 4.0)
    own = measured.data["tau_measured"].values
    np.testing.assert_allclose(own[some], tau[some], rtol=1e-12)
    assert np.isnan(own[~some]).all()
    size = np.sqrt(np.trapezoid(tau[some] ** 2, t[some], axis=0) / np.ptp(t[some]))
    share = measured.summary["measured_difference_share"].values
    np.testing.assert_allclose(share, off / size, rtol=1e-12)
    assert measured.verdict.text == study.verdict.text  # it judges what is computed
    page = measured.to_html(tmp_path / "index.html").read_text(encoding="utf-8")
    assert "Computed less measured torque" in page
    assert ">measured</text>" in page
    with data_file(measured, tmp_path) as data:
        assert compare(Cells(page).cells, data) == []
    header = (tmp_path / "torques.csv").read_text(encoding="utf-8").splitlines()[0]
    assert "tau_measured (N m)" in header


def test_measured_torques_come_from_a_file_too(arm, study, measured, tmp_path: Path):
    names = ",".join(arm.velocity_names)
    rows = np.column_stack([study.motion.t, study.data["tau"].values + [0.3, 0.7]])
    some = (rows[:, 0] >= 0.5) & (rows[:, 0] <= 4.0)
    file = tmp_path / "torques.csv"
    np.savetxt(file, rows[some], delimiter=",", header=f"t,{names}", comments="", fmt="%.17g")
    study.save(tmp_path / "given")
    motion = tmp_path / "given" / "motion.csv"
    asked = ["study", "2R", "--motion", str(motion), "--measured", str(file)]
    status, said = told([*asked, "--out", str(tmp_path / "out")])
    assert status == 0
    assert re.search(r"measured \(of\s+the\s+measured\):\s+joint1\s+0\.3\s+N\s+m", said)
    with xr.open_dataset(tmp_path / "out" / "study.nc", engine="scipy") as data:
        for name in ("measured_rms_difference", "measured_difference_share"):
            np.testing.assert_allclose(data[name], measured.summary[name], rtol=1e-6)


def test_measured_torques_that_do_not_fit_are_refused(arm, study):
    t, tau = study.motion.t, study.data["tau"].values
    cycle = fb.DutyCycle([fb.Segment(study.motion)])
    cases: Any = (
        (study.motion, {"measured": (t + 100.0, tau)}, "samples in common. Count both from the"),
        (study.motion, {"measured": (t, tau), "speed": 2.0}, "leave out speed or measured"),
        (study.motion, {"measured": (t, tau[:, :1])}, r"expected \(\d+, 2\)"),
        (study.motion, {"measured": 3.0}, "times and torques"),
        (study.motion, {"measured": (t, tau * np.nan)}, "finite"),
        (cycle, {"measured": (t, tau)}, "measured is for one motion"),
    )
    for motion, how, words in cases:
        with pytest.raises(fb.FreebodyError, match=words):
            fb.study(arm, motion, **how)


def test_the_page_of_a_cycle_prints_what_its_data_hold(arm, tmp_path):
    there = fb.quintic(arm, [[0.2, 0.3], [1.2, -0.4]], [0.0, 0.8])
    back = fb.quintic(arm, [[1.2, -0.4], [0.2, 0.3]], [0.0, 0.6])
    loaded = fb.Segment(there, payload=3.0, dwell=0.5)
    study = fb.study(arm, fb.DutyCycle([loaded, fb.Segment(back)], source="there <and> back"))
    study.save(tmp_path, report=True)
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    cells = Cells(page).cells
    assert len(cells) > 20
    with xr.open_dataset(tmp_path / "cycle.nc", engine="scipy") as data:
        assert compare(cells, data) == []
    assert "there &lt;and&gt; back" in page
    assert page.count(">segment 2</text>") == 3  # torques of two drives, and the power
    for row in study.card.rows:
        assert row.label in page
    assert (tmp_path / "segment-2" / "report.html").is_file()
