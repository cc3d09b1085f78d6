"""What the steps of a derivation say fits the arm: slides where there are some, moments given once
and used."""

import re

import pytest

import freebody as fb
from support.printed_lines import derived

SLIDES = {
    "lagrange": "a prismatic joint adds nothing",
    "newton-euler": "u_i is the direction in which joint i slides",
}


@pytest.mark.sample(2)
@pytest.mark.parametrize("method", SLIDES)
@pytest.mark.parametrize("word", ["RR", "PP", "RP", "PR", "RPR"])
def test_slides_are_spoken_of_where_there_are_some(word: str, method: str):
    said = " ".join(fb.derive(fb.planar(word), method).text().split())
    assert (SLIDES[method] in said) == ("P" in word)


@pytest.mark.sample(2)
@pytest.mark.parametrize("word", ["RR", "RP", "PR", "PP", "RPP", "PPR"])
def test_every_moment_that_is_eliminated_is_given_and_used(word: str):
    """A moment passes inward; that of a slide at the base, which the ground takes, is a result
    too."""
    text = fb.derive(fb.planar(word), "newton-euler").text()
    steps = {
        int(match[1]): match[2]
        for match in re.finditer(
            r"Eliminate the reactions at joint (\d)(.*?)(?=\n\d+\. )", text, re.DOTALL
        )
    }
    assert sorted(steps) == list(range(1, len(word) + 1))
    digits = "₀₁₂₃"
    for i, step in steps.items():
        name = f"τ{digits[i]}" if word[i - 1] == "R" else f"n{digits[i - 1]}{digits[i]}"
        given = re.findall(rf"^\s+{name} = ", step, re.MULTILINE)
        assert len(given) == 1, (name, step)
        assert f" {name} = " in text.split("Substitute the motion")[-i], name
        if i > 1:
            assert re.search(rf" = .*{name}|^\s+[+−].*{name}", steps[i - 1], re.MULTILINE) or word[
                : i - 1
            ] == "P" * (i - 1), (name, steps[i - 1])


@pytest.mark.sample(2)
@pytest.mark.parametrize("method", ["newton-euler", "recursive"])
@pytest.mark.parametrize("word", ["PR", "RP", "RPR", "PP", "RR", "PPR"])
def test_coriolis_is_spoken_of_where_something_slides_on_a_turning_body(word: str, method: str):
    said = " ".join(fb.derive(fb.planar(word), method).text().split())
    assert ("Coriolis acceleration" in said) == ("RP" in word)


def test_the_inertia_of_a_point_is_not_listed():
    """Euler's equation of a point has none either."""
    said = derived("gantry_crane", "newton-euler").text()
    assert not re.search(r"I[₁₂₃₄] = ", said)
    assert "I₂ = [" in derived("furuta", "newton-euler").text()


@pytest.mark.sample(1)
@pytest.mark.parametrize("method", ["newton-euler", "recursive", "lagrange", "kane", "statics"])
def test_a_joint_without_motor_is_spoken_of_in_every_method(method: str):
    said = " ".join(derived("acrobot", method).text().split())
    assert re.findall("angle (θ.), passive", said) == ["θ₁"]
    assert "no motor" in said
    if method != "statics":
        assert "Joint 1 has no motor. An equation with 0 on the left is a condition" in said
    assert "condition on the motion" not in derived("2R", method).text()


def given(name: str, method: str | None = None) -> str:
    return derived(name, method).given


@pytest.mark.sample(1)
@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("2R", "the motor torques are sought."),
        ("RP", "the motor torque and force are sought."),
        ("cart_pole", "the motor force is sought; joint 2 has no motor"),
        ("four_bar", "Given the motor torque, the accelerations and the forces in the loop are"),
        ("gantry_crane", "joints 3 and 4 have no motor, and the motion must satisfy their"),
    ],
)
def test_motors_are_counted_by_what_they_give(name, said):
    assert said in given(name)


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("2R", "each measured from the previous link, at the ground from the x axis."),
        ("RP", "The angle is positive anticlockwise, measured from the x axis."),
        ("cart_pole", "the drawing and the vectors show from which line."),
        ("reaction_wheel", "the drawing and the vectors show from which line."),
    ],
)
def test_angles_are_said_to_begin_where_they_do(name, said):
    assert said in given(name)


def test_many_joints_are_told_together():
    said = given("stewart")
    assert "begin at the ground (1 to 6, 7 to 9, 10 to 12, " in said
    assert "replaced by joints 1 to 6; between them are bodies 1 to 5, without mass" in said
    assert "Joint i joins body i to body i-1. Joints 1, 2 and 4 are revolute" in given("scara")


def test_masses_that_are_numbers_are_listed_and_have_a_unit():
    gyro = fb.load("gyro")
    for method in ("newton-euler", "lagrange", "recursive", "kane"):
        assert "m₂ = 1\n" in fb.derive(gyro, method).text()
    assert "Numbers without a unit are in SI units." in given("gyro")
    assert "SI units" not in given("2R")
    assert not re.search(r"m₂ = |I₂ = ", derived("2R", "lagrange").text())


def test_the_table_leaves_out_what_no_equation_has():
    table = [str(x) for row in derived("2R", "statics").glossary for x in row.symbols]
    assert "lc₁" in table
    assert "I₁" not in table
    assert "z" in [str(x) for r in derived("2R", "recursive").glossary for x in r.symbols]
    words = {str(x): row.words for row in fb.derive(fb.load("cart_pole"), "statics").glossary
             for x in row.symbols}  # fmt: skip
    assert words["l₂"].endswith("body 2; also distance from joint 2 to the tip")
    words = {str(x): r.words for r in fb.derive(fb.load("stanford")).glossary for x in r.symbols}
    assert words["d₁"] == "distance from joint 1 to joint 2"


@pytest.mark.sample(1)
@pytest.mark.parametrize(
    ("name", "units"),
    [("five_bar", ["m", "N"]), ("five_bar_rods", ["m²", "N/m"]), ("bricard", ["m, 1", "N, N m"])],
)
def test_loop_equations_and_their_multipliers_have_units(name, units):
    rows = derived(name, "lagrange-first-kind").glossary
    assert [r.unit for r in rows if str(r.symbols[0]) in ("Φ_k", "λ_k")] == units


def test_one_loop_is_told_in_the_singular():
    text = derived("five_bar", "newton-euler").text()
    assert "Cut the loop: its force is unknown" in text
    assert "the loops" not in text
    assert "n₀₁ is 0 by the equation" in fb.derive(fb.load("cart_pole"), "recursive").text()


def test_terms_of_drives_are_told():
    text = " ".join(fb.derive(fb.load("puma560", physical="ignore")).text().split())
    assert "The other terms are those of the joint's rotor and friction." in text
    ball = " ".join(fb.derive(fb.load("ball_and_beam")).text().split())
    assert ball.count("The other terms are those of the joint's rotor.") == 1


def test_an_inverse_is_in_lowest_terms():
    text = fb.derive(fb.load("cart_pole"), "kinematics").text()
    assert "K = [1, −cos θ₂/(sin θ₂); 0, 1/(l₂ sin θ₂)]" in text
    assert "det J = −(d₂ + l₂)\n" in fb.derive(fb.load("RP"), "kinematics").text().replace(" │", "")


def test_a_component_of_the_tip_is_not_said_to_be_its_motion():
    told = "only ẋ is counted of the tip"
    assert told in " ".join(derived("four_bar", "kinematics").text().split())
    assert "counted" not in derived("five_bar", "kinematics").text()


def test_many_coordinates_are_not_a_column():
    stewart, small = derived("stewart"), derived("four_bar")
    assert not stewart.steps[0].equations
    assert "q holds the joint variables" in stewart.steps[0].reason
    assert len(small.steps[0].equations) == 2


def test_a_count_below_one_is_not_the_last_word():
    told = "With redundant ones it moves all the same"
    assert told in " ".join(derived("bricard").text().split())
    assert told not in derived("four_bar").text()


def test_one_body_is_spoken_of_as_one():
    text = fb.derive(fb.load("pendulum"), "lagrange-first-kind", coordinates="absolute").text()
    assert "1 body has 3 coordinates; 2 constraints leave 1" in text
    assert re.search(r"φ̇₁, φ̈₁ +its velocity and acceleration", text)


def test_each_force_that_is_handed_inward_is_that_of_the_body_before():
    """f_01, not f_10, of whatever method gives it by itself."""
    text = fb.derive(fb.planar("RR"), "recursive").text()
    assert re.findall("f([₀-₉]{2}) = ", text) == ["₁₂", "₀₁"]
    assert "accelerate body" in " ".join(text.split())
    assert "has no mass" not in text


def test_a_centre_of_mass_that_is_the_origin_needs_no_place():
    said = " ".join(fb.derive(fb.load("quadrotor")).text().split())
    assert "inertia about the centre of mass" in said
    assert "from the body's origin" not in said
