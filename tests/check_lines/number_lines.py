"""Results in numbers at a state, of small robots from the derivation here, of large ones from
freebody's kernels, which `check` does not use."""

import math
import random
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

import freebody as fb

from .robots import mechanism
from .spellings import named, spelling

LARGE = ("ur5e", "stanford", "iiwa14", "puma560", "panda")


def _of_large(robot: str, rng: random.Random, count: int) -> Iterator[tuple[str, dict[str, Any]]]:
    model = fb.load(robot, physical="ignore")
    for _ in range(count):
        q = np.zeros(model.nv)
        told = []
        for i in range(model.nv):
            if robot == "panda" and i > 6:
                continue
            if (robot, i) == ("stanford", 2):
                q[i] = rng.choice((0.4, 0.5, 0.6))
                told.append(f"d3 = {q[i]} m")
                continue
            degrees = rng.choice((-90, -60, -30, 15, 20, 30, 45, 60, 75))
            q[i] = math.radians(degrees)
            told.append(f"theta{i + 1} = {degrees}°")
        if rng.random() < 0.5:
            i = rng.randrange(1, 5)
            number = fb.gravity_torque(model, q)[i]
            name, unit = f"G{i + 1}", "N" if (robot, i) == ("stanford", 2) else "N m"
        else:
            i = rng.randrange(3)
            number = fb.forward_kinematics(model, q)[i, 3]
            name, unit = "xyz"[i], "m"
        shown = f"{number:.4g}"
        if "e" not in shown and abs(number) > 1e-3:
            yield f"{name} = {shown} {unit} at {', '.join(told)}", {}


UNITS = {
    "H": "kg m^2",
    "G": "N m",
    "c": "N m",
    "tau": "N m",
    "T": "J",
    "V": "J",
    "x": "m",
    "y": "m",
    "z": "m",
    "omega": "rad/s",
    "f": "N",
    "E": "J",
    "d": "m",
}
TURNING = ("pendulum", "2R", "3R", "elbow_arm", "pendubot", "slider_crank", "four_bar", "five_bar")


def number_lines(
    robot: str, rng: random.Random, count: int
) -> Iterator[tuple[str, dict[str, Any]]]:
    """Numbers at a state, with the values of the robot's file: answers and options of `check`."""
    if robot in LARGE:
        yield from _of_large(robot, rng, count)
    if robot not in TURNING:
        return
    m = mechanism(robot)
    wanted = [
        x for x in m.quantities if x.rstrip("0123456789") in ("H", "G", "tau", "V", "T", "x", "y")
    ]
    driven = [x for x in m.coordinates if x not in m.passive] if m.loops else list(m.coordinates)
    while count:
        env: dict[str, Any] = {"one": 1.0, **m.values}
        if m.loops:
            if robot != "slider_crank":
                return
            degrees = {"th1": rng.choice((20, 30, 40, 60, 75, 100, 135))}
            a = math.radians(degrees["th1"])
            env["d3"] = 0.2 * math.cos(a) + math.sqrt(0.36 - 0.04 * math.sin(a) ** 2)
            key, value = "d3", env["d3"]
        else:
            degrees = {x: rng.choice((-60, -30, 15, 20, 30, 45, 60, 75, 90, 120)) for x in driven}
            env |= {x: math.radians(y) for x, y in degrees.items()}
            rates = {x: rng.choice((0.5, 1, 1.5, 2, -1)) for x in driven}
            accelerations = {x: rng.choice((0, 0.5, 1, 3)) for x in driven}
            env |= {x + "_d": y for x, y in rates.items()} | {
                x + "_dd": y for x, y in accelerations.items()
            }
            key = rng.choice(wanted)
            if key.startswith("tau") and m.passive:
                continue
            value = float(np.asarray(m.compiled([key])(env)[0]))
            if abs(value) < 1e-2:
                continue
        state = ", ".join(
            f"θ{x[2:].translate(str.maketrans('1234', '₁₂₃₄'))} = {y}°" for x, y in degrees.items()
        )
        if not m.loops and key.startswith(("tau", "T")):
            state += "".join(f", dtheta{x[2:]} = {y} rad/s" for x, y in rates.items())
        if key.startswith("tau"):
            state += "".join(f", ddtheta{x[2:]} = {y} rad/s^2" for x, y in accelerations.items())
        unit = UNITS[key.rstrip("0123456789")]
        digits = rng.choice((3, 4, 5))
        s = spelling(rng, rng.choice(("plain", "code")))
        shown = f"{value:.{digits}g}"
        if "e" in shown:
            continue
        count -= 1
        name = named(key, replace(s, argument=False))
        where = rng.random()
        if where < 0.4:
            yield (f"{name} = {shown} {unit} at {state}", {})
        elif where < 0.7:
            yield (f"At {state}:\n{name} = {shown} {unit}", {})
        else:
            at = {x.replace("th", "theta"): f"{y} deg" for x, y in degrees.items()}
            if not m.loops:
                at |= {f"theta{x[2:]}_d": y for x, y in rates.items()}
                at |= {f"theta{x[2:]}_dd": y for x, y in accelerations.items()}
            yield (f"{name} = {shown} {unit}", {"at": at})
