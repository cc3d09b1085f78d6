"""Errors as students make them, each with where one is warned of it: caught, and told why."""

import math
import re
import tomllib
from pathlib import Path
from typing import Any

import pytest

import freebody as fb

ERRORS = tomllib.loads(
    (Path(__file__).parents[2] / "student_errors.toml").read_text(encoding="utf-8")
)["error"]
ROBOTS = {
    "cart": lambda: fb.planar("PR", m=["mc", "mp"], lc=[0, "l"], l=[0, "l"], I=[0, 0]),
    "geared": lambda: fb.planar("R", m=["m"], lc=["lc"], I=["I"]).with_drive(
        "joint1", rotor="Im", gear="r"
    ),
    "rubbed": lambda: fb.planar("R").with_drive("joint1", viscous="b"),
    "space": lambda: fb.dh(
        [{"alpha": math.pi / 2, "a": "a1", "m": "m1"}, {"a": "a2", "m": "m2"}],
        convention="standard",
    ),
}


def robot(error: dict[str, Any]) -> fb.Model:
    name = error.get("robot", "RR")
    return ROBOTS[name]() if name in ROBOTS else fb.planar(name)


@pytest.mark.sample(6)
@pytest.mark.parametrize("error", ERRORS, ids=lambda error: error["error"])
def test_an_error_of_students_is_caught_and_explained(error: dict[str, Any]):
    verdict = fb.check(robot(error), error["answer"])
    assert not verdict
    assert re.search(error["reason"], verdict.text), verdict


def test_there_are_enough_of_them():
    assert len(ERRORS) >= 40
    assert len({error["answer"] for error in ERRORS}) == len(ERRORS)
    assert all(error["source"] for error in ERRORS)
