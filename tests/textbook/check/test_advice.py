"""What errors advise when a name is not known: the likely one, and none rather than an absurd
one."""

import re

import pytest

import freebody as fb

NOTES = [
    "theta1",
    "theta2",
    "theta1_d",
    "theta2_d",
    "m1",
    "lc1",
    "I1",
    "l1",
    "m2",
    "lc2",
    "I2",
    "l2",
    "g",
]


def meant(name: str, known: list[str]) -> str | None:
    """The name that the error for an unknown one proposes."""
    said = str(fb.UnknownNameError("name", name, "the list", known))
    found = re.search(r"Did you mean '([^']*)'\?", said)
    return found and found[1]


@pytest.mark.parametrize(
    "name", ["J2", "beta", "kg", "RR", "x", "alpha", "k1", "anything", "z" * 5000, ""]
)
def test_no_absurd_advice(name: str):
    assert meant(name, [*NOTES, "3RRR", "2R"]) is None


@pytest.mark.parametrize(
    ("name", "known", "expected"),
    [
        ("L1", NOTES, "l1"), ("m3", NOTES, "m2"), ("lc_1", NOTES, "lc1"), ("l11", NOTES, "l1"),
        ("forearn", ["arm", "forearm"], "forearm"), ("hnad", ["hand", "base"], "hand"),
        ("tpi", ["tip"], "tip"),
        ("inverse", ["bias", "inverse_dynamics"], "inverse_dynamics"),
        ("fix", ["free", "fixed"], "fixed"),
        ("link7", ["link1", "link6", "link5"], "link6"), ("ur5", ["ur5e", "puma560"], "ur5e"),
        ("crankpin", ["crank_pin"], "crank_pin"), ("2r", ["2R", "3R"], "2R"),
        ("alfa", ["a", "alpha"], "alpha"),
    ],
)  # fmt: skip
def test_misspelt_names_are_recognised(name: str, known: list[str], expected: str):
    assert meant(name, known) == expected


@pytest.mark.parametrize("answer", ["H12 = J2", "H12 = \\beta", "G1 = kg l1"])
def test_check_gives_no_absurd_advice(answer: str):
    with pytest.raises(fb.AnswerError) as problem:
        fb.check(fb.planar("RR"), answer)
    assert "Did you mean" not in str(problem.value)
    assert "names=" not in str(problem.value)


def test_a_capital_for_the_cosine_or_sine_is_explained():
    arm = fb.planar("RR")
    for line in ("H12 = m2 (lc2^2 + l1 lc2 C2) + I2", "G2 = m2 g lc2 C12"):
        verdict = fb.check(arm, line)
        assert verdict
        assert "is read as a cosine" in verdict.text
    assert "write c2 for the cosine" in fb.check(arm, "H12 = m2 (lc2^2 + 2 l1 lc2 C2) + I2").text
    assert fb.check(
        arm, "tau2 = H21 theta1_dd + H22 theta2_dd + C2 + G2"
    )  # where the velocity term is meant
    with pytest.raises(fb.AnswerError, match="The cosine of the angle is written c123"):
        fb.check(fb.planar("RRR"), "x = l1*C123")
    with pytest.raises(fb.AnswerError, match="The sine of the angle is written s2"):
        fb.check(arm, "h = m2 l1 lc2 S2")


def test_an_offset_called_d1_is_no_coordinate():
    """A revolute joint's constant of the table may have the name of a slide."""
    for convention in ("standard", "modified"):
        arm = fb.dh(
            [
                {"a": "a1", "d": "d1", "m": "m1", "com": ["c1x", 0, 0]},
                {"a": "a2", "d": "d2", "m": "m2"},
            ],
            convention=convention,
        )
        assert fb.check(arm, str(fb.equations(arm)))
    planar = fb.planar("RR", l=["d1", "d2"])
    assert fb.check(planar, "H12 = m2 (lc2^2 + d1 lc2 cos(theta2)) + I2")
    assert not fb.check(planar, "H12 = m2 (lc2^2 + d2 lc2 cos(theta2)) + I2")
