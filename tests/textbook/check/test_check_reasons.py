"""Why a line may be wrong: a sentence for each usual thought, on arms, trees and closed chains."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

import freebody as fb

OWN = """
name = "own"
dim = 2
tip = "hand"
[[link]]
name = "ground"
[[link]]
name = "upper"
mass = "ma"
com = ["ca", 0]
inertia = "Ja"
[[link]]
name = "fore"
mass = "mb"
com = ["e", 0]
inertia = "Jb"
[[joint]]
name = "shoulder"
kind = "revolute"
parent = "ground"
child = "upper"
[[joint]]
name = "elbow"
kind = "revolute"
parent = "upper"
child = "fore"
origin = ["a", 0]
[[frame]]
name = "hand"
parent = "fore"
origin = ["b", 0]
"""
DH = [{"alpha": math.pi / 2, "d": "d1", "m": "m1"}, {"a": "a2", "m": "m2", "com": ["e", 0, 0]}]


@pytest.fixture(scope="module")
def robots(tmp_path_factory: pytest.TempPathFactory) -> dict[str, fb.Model]:
    path: Path = tmp_path_factory.mktemp("robots") / "own.toml"
    path.write_text(OWN, encoding="utf-8")
    bundled = ("four_bar", "slider_crank", "pendulum", "acrobot", "gyro", "cart_pole")
    planar = {word: fb.planar(word) for word in ("RR", "RRR", "RPR", "RP")}
    told = {name: fb.load(name) for name in bundled}
    return {**planar, **told, "own": fb.load(path), "dh": fb.dh(DH, convention="standard")}


THIRD = "by Newton's third law −f{}{} acts on body {}"
NO_MOMENTS, FIXED = "The moments r × f of the forces on body", "if joint {} did not accelerate"
ALONE = "The rate of a joint is relative to the previous link"
WHERE = "here they are along the world's axes"
HALF = "A factor ½ is missing"
SQUARE, VECTORS = "a sum of rates is squared as", "velocities add as vectors"
TWICE, STEINER = "is counted twice", "The parallel-axis theorem is missing"
ABSOLUTE = "were measured from the x axis"

WRONG = [
    # the third law
    ("RR", "f01 = m1 (vc1_d - gravity) - f12", THIRD.format(1, 2, 1)),
    ("RR", "f01x = m1 vc1_dx - f12x", THIRD.format(1, 2, 1)),
    ("RR", "f01 + f12 + m1 gravity = m1 vc1_d", THIRD.format(1, 2, 1)),
    ("RR", "tau1 = tau2 + I1 ω̇1 + sc1 × f01 - (s1 - sc1) × f12", THIRD.format(1, 2, 1)),
    ("RR", "tau1 - tau2 - sc1 × f01 + (s1 - sc1) × f12 = I1 ω̇1", THIRD.format(1, 2, 1)),
    ("RRR", "f12 = m2 (vc2_d - gravity) - f23", THIRD.format(2, 3, 2)),
    ("RPR", "f01 = m1 (vc1_d - gravity) - f12", THIRD.format(1, 2, 1)),
    ("four_bar", "f01 = m1 (vc1_d - gravity) - f12", THIRD.format(1, 2, 1)),
    ("slider_crank", "f01 = m1 (vc1_d - gravity) - f12", THIRD.format(1, 2, 1)),
    ("RR", "tau1 = I1 ω̇1 + sc1 × m1 (vc1_d - gravity) - tau2 + s1 × f12", "moment at joint 2"),
    ("RRR", "M2 = I2 ω̇2 + sc2 × m2 (vc2_d - gravity) + s2 × f23 - M3", "moment at joint 3"),
    ("four_bar", "tau1 = (I1 + m1 lc1²) θ̈1 + m1 g lc1 c1", "reaction of body 2 on body 1"),
    # Euler's equation
    ("RR", "tau2 = I2 ω̇2", NO_MOMENTS),
    ("RR", "tau1 = I1 θ̈1 + I2 (θ̈1 + θ̈2)", NO_MOMENTS),
    ("RRR", "tau3 = I3 (θ̈1 + θ̈2 + θ̈3)", NO_MOMENTS),
    ("RPR", "tau3 = I3 (θ̈1 + θ̈3)", NO_MOMENTS),
    ("own", "tau2 = Jb (θ̈1 + θ̈2)", NO_MOMENTS),
    ("RR", "tau2 = (I2 + m2 lc2²) (θ̈1 + θ̈2) + m2 g lc2 c12", FIXED.format(2)),
    ("RRR", "tau3 = (I3 + m3 lc3²) (θ̈1 + θ̈2 + θ̈3) + m3 g lc3 c123", FIXED.format(3)),
    ("RPR", "tau3 = (I3 + m3 lc3²) (θ̈1 + θ̈3) + m3 g lc3 c13", FIXED.format(3)),
    ("RR", "tau1 = tau2 + I1 ω̇1 + sc1 × m1 (vc1_d - gravity)", "The moment of −f12 on body 1"),
    ("RR", "tau1 = I1 ω̇1 + sc1 × m1 (vc1_d - gravity) + s1 × f12", "The moment of joint 2"),
    ("RR", "tau1 = tau2 + I1 ω̇1 + s1 × f12", "The moment s_c × m (v̇_c − g) of body 1"),
    ("gyro", "M_y = I_y ω̇_y", "The gyroscopic moment is missing"),
    # arms
    ("RR", "tau1 = tau2 + I1 ω̇1 + s1 × m1 (vc1_d - gravity) + sc1 × f12", "arms are swapped"),
    ("RRR", "tau2 = tau3 + I2 ω̇2 + s2 × m2 (vc2_d - gravity) + sc2 × f23", "arms are swapped"),
    ("RR", "tau1 = tau2 + I1 ω̇1 + sc1 × m1 (vc1_d - gravity) + sc1 × f12", "about joint 1 the arm"),
    ("RR", "tau1 = tau2 + I1 ω̇1 + (s1 - sc1) × f01 + sc1 × f12", "body 1 are swapped"),
    ("RR", "tau1 - tau2 - sc1 × f01 - s1 × f12 = I1 ω̇1", "is s − s_c, not s."),
    ("RR", "tau2 = I2 ω̇2 + s2 × m2 (vc2_d - gravity)", "not s to its end"),
    ("RRR", "tau3 = I3 ω̇3 + s3 × f23", "not s to its end"),
    ("RR", "tau2 = I2 ω̇2 + m2 (vc2_d - gravity) × sc2", "the arm comes first"),
    ("RR", "tau2 = I2 ω̇2 + lc2 c12 f12y + lc2 s12 f12x", "The cross product has a minus"),
    ("RR", "tau2 = I2 ω̇2 + lc2 s12 f12y - lc2 c12 f12x", "components are mixed up"),
    ("RR", "G1 = m1 g lc1 c1 + m2 g (lc1 c1 + lc2 c12)", "You wrote lc₁ for l₁"),
    ("own", "G1 = ma g ca c1 + mb g (ca c1 + e c12)", "You wrote ca for a"),
    ("own", "G1 = ma g a c1 + mb g (a c1 + e c12)", "You wrote a for ca"),
    # where the centre of mass is
    ("RR", "V = m1 g lc1 s1 + m2 g l1 s1", "right only if lc₂ = 0: the centre of mass of link2"),
    ("RR", "vc2x = -l1 s1 θ̇1", "lc₂ = 0"),
    ("RP", "F2 = m2 d̈2 - m2 (l1 + d2) θ̇1² + m2 g s1", "lc₂ = 0"),
    (
        "RR",
        "G1 = m2 g l1 c1",
        "right only if lc₁ = 0 and lc₂ = 0: the centres of mass of link1 and",
    ),
    (
        "own",
        "G1 = ma g ca c1 + mb g a c1",
        "right only if e = 0: the centre of mass of fore is not",
    ),
    ("slider_crank", "V = m1 g lc1 s1 + m2 g l1 s1", "the centre of mass of rod"),
    (
        "RR",
        "H11 = I1 + m1 lc1² + m2 (l1² + lc2² + 2 l1 lc2 c2)",
        "moment of inertia of link2 about",
    ),
    # other axes
    ("RR", "f12x = m2 (-l1 θ̇1² c2 + l1 θ̈1 s2 - lc2 (θ̇1+θ̇2)² + g s12)", WHERE),
    ("RR", "f12y = m2 (l1 θ̇1² s2 + l1 θ̈1 c2 + lc2 (θ̈1+θ̈2) + g c12)", WHERE),
    ("RR", "vc2x = l1 s2 θ̇1", WHERE),
    ("dh", "vc2x = -(a2 + e) (s1 c2 θ̇1 + c1 s2 θ̇2)", "right in the world's axes"),
    ("dh", "f01 = fc1 - m1 gravity1 - R12 f12", THIRD.format(1, 2, 1)),
    # moments of inertia
    ("own", "H22 = Jb", STEINER),
    ("own", "H22 = Jb + 2 mb e²", TWICE),
    ("RR", "tau2 = (I2 + m2 lc2²) ω̇2 + sc2 × m2 (vc2_d - gravity)", TWICE),
    ("RR", "tau1 = tau2 + (I1 + m1 lc1²) ω̇1 + sc1 × m1 (vc1_d - gravity) + s1 × f12", TWICE),
    # relative rates for absolute ones, and the other way
    ("RR", "tau2 = I2 θ̈2 + sc2 × m2 (vc2_d - gravity)", ALONE),
    ("RR", "T2 = ½ m2 (l1² θ̇1² + lc2² θ̇2² + 2 l1 lc2 c2 θ̇1 θ̇2) + ½ I2 θ̇2²", ALONE),
    ("RR", "vc2x = -l1 s1 θ̇1 - lc2 s12 θ̇2", ALONE),
    ("RR", "x_d = -l1 s1 θ̇1 - l2 s12 θ̇2", ALONE),
    ("RR", "vc2_dx = -l1 (θ̈1 s1 + θ̇1² c1) - lc2 (θ̈2 s12 + θ̇2² c12)", ALONE),
    ("RR", "f12x = -m2 (l1 (θ̈1 s1 + θ̇1² c1) + lc2 (θ̈2 s12 + θ̇2² c12))", ALONE),
    ("RPR", "vc3x = -(l1 + d2) s1 θ̇1 + ḋ2 c1 - lc3 s13 θ̇3", ALONE),
    ("RPR", "omega3 = θ̇3", "ω₃ = θ̇₁ + θ̇₃"),
    ("acrobot", "omega2 = θ̇2", "ω₂ = θ̇₁ + θ̇₂"),
    ("four_bar", "vc2x = -l1 s1 θ̇1 - lc2 s12 θ̇2", ALONE),
    ("slider_crank", "vc2y = l1 c1 θ̇1 + lc2 c12 θ̇2", ALONE),
    ("own", "H12 = mb a e cos(θ1 - θ2)", ABSOLUTE),
    ("RRR", "x = l1 c1 + l2 c2 + l3 c3", ABSOLUTE),
    # factors
    ("RR", "T1 = m1 lc1² θ̇1² + I1 θ̇1²", HALF),
    ("RR", "T2 = ½ m2 vc2² + ½ I2 (θ̇1² + θ̇2²)", SQUARE),
    ("RRR", "T2 = ½ m2 vc2² + ½ I2 (θ̇1² + θ̇2²)", SQUARE),
    ("RR", "T2 = ½ m2 (l1² θ̇1² + lc2² (θ̇1 + θ̇2)²) + ½ I2 (θ̇1 + θ̇2)²", VECTORS),
    ("own", "T2 = ½ mb (a² θ̇1² + e² (θ̇1 + θ̇2)²) + ½ Jb (θ̇1 + θ̇2)²", VECTORS),
    ("cart_pole", "T = ½ (m1 + m2) ẋ² + ½ m2 l2² θ̇2²", VECTORS),
    ("RPR", "T2 = ½ m2 (ḋ2² + (l1 + d2 + lc2)² θ̇1²) + I2 θ̇1²", HALF),
    ("four_bar", "T2 = m2 vc2^2 + I2 ω2²", HALF),
    ("RP", "vc2_dy = d̈2 s1 + ḋ2 θ̇1 c1 + (l1 + d2 + lc2) (θ̈1 c1 - θ̇1² s1)", "factor of 2"),
    ("RRR", "G1 = m1 g lc1 c1", "of link2 and link3 is missing"),
    ("pendulum", "tau1 = I1 θ̈1 - m1 g lc1 c1 + m1 lc1² θ̈1", "Only the sign of gravity"),
]


@pytest.mark.sample(3)
@pytest.mark.parametrize(("robot", "line", "sentence"), WRONG)
def test_a_thought_is_told(robots: dict[str, fb.Model], robot: str, line: str, sentence: str):
    verdict = fb.check(robots[robot], line)
    assert not verdict
    assert sentence in " ".join(verdict.causes)


UNEXPLAINED = [
    ("RR", "f01 - f12 + m1 gravity = -m1 vc1_d"),
    ("RR", "f12 + m2 gravity = -m2 vc2_d"),
    ("RR", "f01 + 3 f12 + m1 gravity = m1 vc1_d"),
    ("RR", "tau1 = 3 tau2 + I1 ω̇1"),
    ("RRR", "f12 = m2 (vc2_d - gravity) - 2 f23"),
    ("four_bar", "f01 = 2 m1 (vc1_d - gravity) - f12"),
]


@pytest.mark.sample(1)
@pytest.mark.parametrize(("robot", "line"), UNEXPLAINED)
def test_what_no_thought_gives_is_not_explained_by_one(
    robots: dict[str, fb.Model], robot: str, line: str
):
    verdict = fb.check(robots[robot], line)
    assert not verdict
    assert verdict.causes == ()


@pytest.mark.sample(1)
@pytest.mark.parametrize("word", ["RR", "RP", "RPR"])
def test_a_forgotten_centre_of_mass_is_told_where_the_mass_still_counts(word: str):
    """The lines of an arm whose last link has its centre of mass on the joint; where the mass is
    gone too, as in H22 = I2, more than its place was forgotten."""
    last = len(word)
    centres = [*(f"lc{k}" for k in range(1, last)), 0.0]
    printed = str(fb.equations(fb.planar(word, lc=centres))).splitlines()
    lines = [line for line in printed if line[:1] in ("H", "G")]
    assert fb.check(fb.planar(word, lc=centres), "\n".join(lines))
    told = []
    for line in lines:
        causes = " ".join(fb.check(fb.planar(word), line).causes)
        named = sum(f"lc{'₀₁₂₃'[k]} = 0" in causes for k in range(1, last + 1))
        assert named == (f"lc{'₀₁₂₃'[last]} = 0" in causes)
        told.append((line, bool(named)))
    assert any(is_told for _, is_told in told)
    assert all(f"m{'₀₁₂₃'[last]}" in line for line, is_told in told if is_told)


def test_one_forgotten_place_is_not_taken_for_another(robots: dict[str, fb.Model]):
    """Not where the user's own line has it, nor where a length is what places a joint as well."""
    verdicts = [
        fb.check(robots["RR"], "G1 = m1 g lc1 c1 + 2 m2 g (l1 c1 + lc2 c12)"),
        fb.check(robots["RR"], "x = l1 c1"),
        fb.check(fb.planar("RR", l=["l1", "e"], lc=["lc1", "e"]), "x = l1 c1"),
    ]
    assert not any(verdicts)
    assert not [cause for one in verdicts for cause in one.causes if "at its joint" in cause]


def test_the_more_specific_sentence_stands_alone(robots: dict[str, fb.Model]):
    """I2 alone is also what no moment of a force would give: the parallel axis says more."""
    (cause,) = fb.check(robots["RR"], "H22 = I2").causes
    assert STEINER in cause


def test_of_parts_of_a_torque_nothing_is_said_about_forces_that_nobody_wrote(robots):
    """M and g come from energies as well: a wrong sign there is no wrong reaction."""
    for name, line in (
        ("RR", "H12 = -m2 (lc2² + l1 lc2 c2) - I2"),
        ("RPR", "H23 = m3 lc3 s3"),
        ("RR", "G1 = m1 g lc1 c1 + m2 g (l1 c1 - lc2 c12)"),
    ):
        verdict = fb.check(robots[name], line)
        assert verdict.causes == ()
        assert "wrong sign" in verdict.text
    rod = {"lc": "l/2", "I": "m*l^2/12"}
    (cause,) = fb.check(robots["RR"], "H22 = m2 l2²/12", parameters=rod).causes
    assert cause.startswith("Only the moments of inertia about the centres of mass are here")
