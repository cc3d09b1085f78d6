"""Bodies of a robot with a joint of several coordinates: counted as in the derivation, where a body
without mass stands between its axes, or as the links of the robot's file."""

from __future__ import annotations

import pytest

import freebody as fb

CRANE = fb.load("gantry_crane")
SAID = "Bodies are counted as the links of the robot's file."


@pytest.mark.sample(2)
@pytest.mark.parametrize(
    ("as_derived", "as_in_the_file"),
    [
        ("T4 = ½ m vc4²", "T3 = ½ m vc3²"),
        ("V4 = -m g l cos θ3 cos θ4", "V3 = -m g l cos θ3 cos θ4"),
        ("T = T1 + T2 + T4", "T = T1 + T2 + T3"),
        ("V = m g zc4", "V = m g zc3"),
        ("rc4 = [x + l s4, y + l s3 c4, -l c3 c4]", "rc3 = [x + l s4, y + l s3 c4, -l c3 c4]"),
        ("L = T1 + T2 + T4 - V4", "L = T1 + T2 + T3 - V3"),
    ],
)
def test_both_ways_to_count_bodies_are_right(as_derived: str, as_in_the_file: str):
    assert SAID not in fb.check(CRANE, as_derived).text
    verdict = fb.check(CRANE, as_in_the_file)
    assert verdict, verdict
    assert SAID in verdict.text


@pytest.mark.sample(3)
@pytest.mark.parametrize(
    "line",
    [
        "T3 = m vc3²",
        "T3 = ½ m (ẋ² + ẏ²)",
        "T4 = ½ m (ẋ² + ẏ²)",
        "T = T1 + T2",
        "V3 = m g l cos θ3 cos θ4",
        "rc3 = [x + l s4, y - l s3 c4, -l c3 c4]",
        "T3 = T4",
        "T4 = T3",
    ],
)
def test_a_wrong_line_is_wrong_in_both(line: str):
    assert not fb.check(CRANE, line)


def test_what_is_missing_is_told_of_the_link_that_is_meant():
    text = fb.check(CRANE, "T3 = ½ m (ẋ² + ẏ²)").text
    assert "T3, the kinetic energy of body 3, counted as the links of the robot's file" in text
    assert "‘½ m l² θ̇₄²’ is missing" in text
