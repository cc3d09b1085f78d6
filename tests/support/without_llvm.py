"""Freebody where llvmlite is not installed: everything is computed by NumPy, within the limits of
Python in a browser.

Run in a process of its own, `python -m support.without_llvm`, whose path begins with a folder that
holds `HIDES` as `sitecustomize.py`: what a process has compiled before cannot be taken back.
"""

from __future__ import annotations

import json
import os
import shlex
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

import freebody as fb
from support import command
from support.public_calls import public_calls, state
from support.simulated_logs import log as simulated

HIDES = """
import importlib.metadata
import os
import subprocess
import sys
import threading

for absent in ("llvmlite", "fcntl", "pwd", "resource"):
    sys.modules[absent] = None  # an import fails, and a search finds nothing
found = importlib.metadata.Distribution.from_name


def from_name(name):
    if name == "llvmlite":
        raise importlib.metadata.PackageNotFoundError(name)
    return found(name)


importlib.metadata.Distribution.from_name = from_name


def no_thread(self):
    raise RuntimeError("can't start new thread")


def no_process(*words, **options):
    raise OSError(138, "emscripten does not support processes.")


threading.Thread.start = no_thread
subprocess.Popen.__init__ = no_process
os.fork = no_process
os.environ["PATH"] = ""
os.cpu_count = lambda: 1
del os.sched_getaffinity
"""
"""Takes away what Pyodide does not have under WebAssembly, in the words in which it refuses."""

ELSEWHERE = ("study", "compare", "singularity_loci")
"""Functions that take long, and that what else is walked, or has a test of its own, calls."""

LOOPS = ("assemble", "loop_velocity", "loop_acceleration", "input_output")
"""Functions of closed chains alone."""

Q = np.array([0.1, -1.0, 0.9, 0.3, 0.7, 0.1])
MOVED = Q + 0.2
STEPS = np.linspace(0.0, 0.02, 3)
LIMITS: dict[str, Any] = {"velocity": 1.0, "acceleration": 2.0}


def calls(arm: fb.Model) -> dict[str, Callable[[], Any]]:
    """A call of each public function that takes no state of a robot, but of those that
    `ELSEWHERE` names."""
    two = fb.load("2R")
    shoulder, crank = fb.planar("RR"), fb.load("slider_crank")
    motion = fb.default_motion(arm, samples=21)
    corner = fb.forward_kinematics(arm, Q)[:3, 3]
    kernel = fb.kernel(two, "inverse_dynamics")
    parts = fb.catalogue("invented")
    return {
        "inertia_from": lambda: fb.inertia_from(1.0, (0, 0, 0), np.eye(3), (0, 0, 0)),
        "integrated_inertia": lambda: fb.integrated_inertia(lambda x: (x, 0.0, 0.0), [(0, 1)]),
        "parameters": lambda: fb.parameters(arm),
        "planar": lambda: fb.planar("RP"),
        "dh": lambda: fb.dh([{"a": 1.0}], convention="standard"),
        "load": lambda: fb.load("panda"),
        "save": lambda: fb.save(arm, "arm.toml"),
        "losses": lambda: fb.losses(arm, "urdf"),
        "export_fmu": lambda: fb.export_fmu(two, "arm.fmu"),
        "template": lambda: fb.template("scara"),
        "models": fb.models,
        "doctor": lambda: fb.doctor("ur5e"),
        "same_robot": lambda: fb.same_robot(arm, arm),
        "inertial_parameters": lambda: fb.inertial_parameters(arm),
        "discrete_lqr": lambda: fb.discrete_lqr(
            *([[1.0, 0.1], [0, 1]], [[0.0], [0.1]], np.eye(2), [[1.0]])
        ),
        "base_parameters": lambda: fb.base_parameters(arm),
        "quat_wxyz": lambda: fb.quat_wxyz(np.eye(3)),
        "rotation": lambda: fb.rotation("xyz", (0.1, 0.2, 0.3)),
        "singularities": lambda: fb.singularities(shoulder),
        "workspace": lambda: fb.workspace(arm, corner),
        "kernel": lambda: fb.kernel(arm, "bias", inputs="*.mass"),
        "export": lambda: fb.export(two, "bias", "c", "c"),
        "source": lambda: [
            fb.source(two, "bias", language) for language in ("numpy", "jax", "casadi", "c")
        ],
        "to_torch": lambda: None,  # has no test without PyTorch; it calls kernels as they are
        "to_jax": lambda: fb.to_jax(two, "mass_matrix")(np.zeros((3, 2), "f4")),
        "compile": lambda: fb.compile(lambda x: x * x, {"x": ()})(2.0),
        "formula": lambda: fb.formula(two, "bias")([0.1, 0.2], [0.3, 0.4]),
        "equations": lambda: fb.equations(shoulder).text(),
        "loop_equations": lambda: fb.loop_equations(fb.load("five_bar")),
        "derive": lambda: fb.derive(two).html(),
        "check": lambda: fb.check(two, "M11 = 1"),
        "payload": lambda: fb.payload(arm, [motion, motion]),
        "load_diagram": lambda: fb.load_diagram(arm, Q, offsets=[0.0, 0.1]).svg,
        "quantities": lambda: fb.quantities(shoulder),
        "relation": lambda: fb.relation(fb.quantities(shoulder), "tau = H11"),
        "sampled_trajectory": lambda: fb.sampled_trajectory(np.arange(8.0), np.ones((8, 2))),
        "trajectory": lambda: fb.trajectory("t", "t^2"),
        "vector_function": lambda: fb.vector_function(["x^2"], ["x"]).jacobian,
        "smoothed": lambda: fb.smoothed(arm, motion, cutoff=1.0),
        "default_motion": lambda: fb.default_motion(arm),
        "write_motion": lambda: fb.write_motion(arm, motion, "motion.csv"),
        "read_motion": lambda: fb.read_motion(arm, "motion.csv"),
        "read_waypoints": lambda: (
            Path("way.csv").write_text("joint1,joint2\n0,0\n1,1\n"),
            fb.read_waypoints(two, "way.csv"),
        ),
        "read_log": lambda: fb.read_log(
            {"t": 0.1 * np.arange(60), "q": np.sin(np.arange(60)), "tau": np.cos(np.arange(60))}
        ),
        "read_poses": lambda: fb.read_poses(
            {"q1": [0.1], "q2": [0.2], "x": [1.0], "y": [0.0], "z": [0.5]}, two
        ),
        "excitation": lambda: fb.excitation(two, 4.0, harmonics=2, **LIMITS),
        "catalogue": lambda: fb.catalogue("invented"),
        "mean_load": lambda: fb.mean_load([1.0, 2.0], [1.0, 1.0], [1.0, 1.0], 3.0),
        "drive_loads": lambda: fb.drive_loads(
            arm, motion, {arm.joint_names[0]: (parts.motors[8], parts.gears[12])}
        ),
        "emergency_stops": lambda: fb.emergency_stops(
            arm, motion, {arm.joint_names[0]: (parts.motors[8], parts.gears[12])}
        ),
        "size": lambda: fb.size(arm, motion, parts, joints=arm.joint_names[:1]),
        "bearing_loads": lambda: fb.bearing_loads(arm, motion),
        "floor_loads": lambda: fb.floor_loads(arm, motion),
        "load_table": lambda: fb.load_table(arm, motion),
        "quintic": lambda: fb.quintic(arm, [Q, MOVED], **LIMITS),
        "trapezoid": lambda: fb.trapezoid(arm, [Q, MOVED], **LIMITS),
        "s_curve": lambda: fb.s_curve(arm, [Q, MOVED], jerk=9.0, **LIMITS),
        "spline": lambda: fb.spline(arm, [Q, MOVED], **LIMITS),
        "dwell": lambda: fb.dwell(arm, Q, 1.0),
        "line": lambda: fb.line(arm, Q, corner + 0.02, 1.0, task="position"),
        "arc": lambda: fb.arc(
            arm, Q, corner + (0, 0.02, 0.01), corner + 0.02, 1.0, task="position"
        ),
        "blend": lambda: fb.blend(
            arm, Q, [corner + (0, 0.02, 0), corner + 0.02], 0.005, 1.0, task="position"
        ),
        "exceeded_limits": lambda: fb.exceeded_limits(arm, motion, velocity=0.1),
        "time_optimal": lambda: fb.time_optimal(arm, motion, points=51, **LIMITS),
        "samples": lambda: fb.samples(8, {"q": (-np.ones(3), np.ones(3))}),
        "sweep": lambda: fb.sweep(
            arm, "bias", over={"g": [1.0, 2.0]}, at={"q": Q, "qd": Q}, reduce="peak"
        ),
        "singularity_diagram": lambda: fb.singularity_diagram(crank),
        "ellipsoid_diagram": lambda: fb.ellipsoid_diagram(arm, Q),
        "map_diagram": lambda: fb.map_diagram(
            two, np.stack(np.mgrid[:2, :2], axis=-1) * 0.5, np.eye(2)
        ),
        "assembly_modes": lambda: fb.assembly_modes(
            crank, fb.assemble(crank), free=["rod_pin", "guide"]
        ),
        "identify": lambda: fb.identify(
            two, simulated(two, np.random.default_rng(0)), friction=["viscous"]
        ),
        "identify_payload": lambda: fb.identify_payload(
            two, simulated(two, np.random.default_rng(0)), friction=["viscous"]
        ),
        "detect_collisions": lambda: fb.detect_collisions(
            two, simulated(two, np.random.default_rng(0))
        ),
        "calibrate": lambda: fb.calibrate(arm, *_poses(arm)),
        "notes_figure": lambda: fb.notes_figure("1.1"),
        "the kernel's text": lambda: kernel.source,
    }


def _poses(arm: fb.Model) -> tuple[np.ndarray, np.ndarray]:
    """Readings of joints and points of the tip, as an instrument in the world's axes sees it."""
    q, _, _ = fb.random_state(arm, 0, 40)
    return q, fb.forward_kinematics(arm, q)[:, :3, 3]


def commands() -> dict[str, list[str]]:
    """The example of each command's help, in words, but of those that `ELSEWHERE` names."""
    return {
        name: shlex.split(command.example(text))
        for name, text in command.commands().items()
        if name not in ELSEWHERE
    }


def walked() -> dict[str, str]:
    """Each public function and command, and what was wrong with it, or nothing."""
    arm, closed = fb.load("ur5e"), fb.load("four_bar")
    found = {}

    def tried(name: str, call: Callable[[], Any]) -> None:
        try:
            call()
        except Exception as problem:
            found[name] = f"{type(problem).__name__}: {problem}"
        else:
            found[name] = ""

    here = {False: (arm, state(arm, 3)), True: (closed, state(closed, 3))}
    of_states = {
        name: lambda call=call, name=name: call(*here[name in LOOPS])
        for name, call in public_calls().items()
    }
    for name, call in (of_states | calls(arm)).items():
        tried(name, call)
    for name, words in commands().items():
        status, said = command.told(words)
        found[f"freebody {name}"] = said if status else ""
    return found


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        json.dump(walked(), sys.stdout)
