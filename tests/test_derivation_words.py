"""What the steps of a derivation say fits the arm: slides where there are some, moments given once
and used."""

import re

import pytest

import freebody as fb

SLIDES = {
    "lagrange": "a prismatic joint adds nothing",
    "newton-euler": "u_i is the direction in which joint i slides",
}


@pytest.mark.parametrize("method", SLIDES)
@pytest.mark.parametrize("word", ["RR", "PP", "RP", "PR", "RPR"])
def test_slides_are_spoken_of_where_there_are_some(word: str, method: str):
    said = " ".join(fb.derive(fb.planar(word), method).text().split())
    assert (SLIDES[method] in said) == ("P" in word)


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


@pytest.mark.parametrize("method", ["newton-euler", "recursive"])
@pytest.mark.parametrize("word", ["PR", "RP", "RPR", "PP", "RR", "PPR"])
def test_coriolis_is_spoken_of_where_something_slides_on_a_turning_body(word: str, method: str):
    said = " ".join(fb.derive(fb.planar(word), method).text().split())
    assert ("Coriolis acceleration" in said) == ("RP" in word)


def test_the_inertia_of_a_point_is_not_listed():
    """Euler's equation of a point has none either."""
    said = fb.derive(fb.load("gantry_crane"), "newton-euler").text()
    assert not re.search(r"I[₁₂₃₄] = ", said)
    assert "I₂ = [" in fb.derive(fb.load("furuta"), "newton-euler").text()


@pytest.mark.parametrize("method", ["newton-euler", "recursive", "lagrange", "kane", "statics"])
def test_a_joint_without_motor_is_spoken_of_in_every_method(method: str):
    said = " ".join(fb.derive(fb.load("acrobot"), method).text().split())
    assert "passive" in said
    assert "no motor" in said
    if method != "statics":
        assert "Joint 1 has no motor. An equation with 0 on the left is a condition" in said
    assert "condition on the motion" not in fb.derive(fb.load("2R"), method).text()
