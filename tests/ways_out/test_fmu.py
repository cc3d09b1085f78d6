"""Robots as units of co-simulation: FMPy finds the description right, runs the unit, and gets the
motion that `fb.simulate` gives."""

import zipfile

import numpy as np
import pytest

import freebody as fb
from support.command import run
from support.extras import extra
from support.helpers import close


def simulated(file, model, torques, end, start):
    """The last positions of a run by FMPy, in communication steps of 10 ms."""
    fmpy = extra("fmpy")
    names = [f"q.{name}" for name in model.position_names]
    driven = [model.velocity_names[k] for k in model.driven]
    columns = [("time", "f8"), *((f"tau.{x}", "f8") for x in driven)]
    found = fmpy.simulate_fmu(
        str(file),
        stop_time=end,
        output_interval=0.01,
        input=np.array([(0.0, *torques)], dtype=columns),
        start_values=start,
        output=names,
    )
    assert abs(found["time"][-1] - end) < 1e-9
    return np.array([found[name][-1] for name in names])


def test_an_arm_moves_as_in_simulate(tmp_path):
    """UR5e from a state that is set, under constant torques."""
    validate_fmu = extra("fmpy.validation", "fmpy").validate_fmu
    model, file = fb.load("ur5e"), tmp_path / "ur5e.fmu"
    assert fb.export_fmu(model, file, step=5e-4) == file
    assert validate_fmu(str(file)) == []
    q = np.array([0.1, -1.2, 0.8, 0.2, 0.3, -0.4])
    torques = np.array([1.0, -20.0, 5.0, 0.3, -0.2, 0.1])
    start = {f"q.{name}": x for name, x in zip(model.position_names, q, strict=True)}
    found = simulated(file, model, torques, 0.5, start)
    expected = fb.simulate(model, q, np.zeros(6), [0.0, 0.5], torques, tolerance=1e-12)
    close(found, expected.q.values[-1], 1e-8)


def test_a_closed_chain_starts_closed_and_is_moved_by_its_drives(tmp_path):
    """Its passive joints have no inputs."""
    model, file = fb.load("five_bar"), tmp_path / "robot.fmu"
    fb.export_fmu(model, file)
    found = simulated(file, model, np.array([0.5, -0.2]), 0.05, {})
    torques = np.zeros(model.nv)
    torques[list(model.driven)] = 0.5, -0.2
    still = np.zeros(model.nv)
    expected = fb.simulate(model, fb.assemble(model), still, [0.0, 0.05], torques, tolerance=1e-12)
    close(found, expected.q.values[-1], 1e-7)


def test_what_is_refused(tmp_path):
    model = fb.load("2R")
    with pytest.raises(fb.FreebodyError, match=r"must end in \.fmu"):
        fb.export_fmu(model, tmp_path / "arm.zip")
    with pytest.raises(fb.FreebodyError, match="expected a number of seconds above 0"):
        fb.export_fmu(model, tmp_path / "arm.fmu", step=0.0)


def test_without_a_compiler_there_are_sources(tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.warns(fb.FreebodyWarning, match="sources only"):
        fb.export_fmu(fb.load("2R"), tmp_path / "arm.fmu")
    with zipfile.ZipFile(tmp_path / "arm.fmu") as archive:
        assert set(archive.namelist()) == {"modelDescription.xml", "sources/x2R.c"}


def test_the_command_and_that_the_same_robot_gives_the_same_file(tmp_path):
    for name in ("a.fmu", "b.fmu"):
        assert run(["convert", "2R", str(tmp_path / name)]) == 0
    one, two = ((tmp_path / name).read_bytes() for name in ("a.fmu", "b.fmu"))
    assert one == two
