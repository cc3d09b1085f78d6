"""Robots by their kind: each template moves as the closed forms of its kind say, with numbers of
one's own."""

import numpy as np
import pytest

import freebody as fb
from support.command import run
from support.helpers import close, numbers, poses

pytestmark = pytest.mark.usefixtures("numpy_kernels")


TEMPLATES = ("delta", "five_bar", "gantry", "palletiser", "scara", "six_axis")


def at(model: fb.Model, frame: str, q) -> np.ndarray:
    return poses(model, np.atleast_2d(q))[frame][0]


def test_a_bundled_robot_is_its_template():
    assert fb.load("scara").parameters == {"g": 9.81}  # its numbers stand in the place of names
    five_bar = fb.load("five_bar")
    assert five_bar.formulas == ()
    named = {name: x for name, x in five_bar.parameters.items() if name != "g"}
    for one, two in (
        (fb.load("scara"), fb.template("scara")),
        (five_bar, fb.template("five_bar", **named)),
    ):
        q, qd, _ = fb.random_state(one, 1, 3)
        for name, given in (("mass_matrix", (q,)), ("bias", (q, qd)), ("forward_kinematics", (q,))):
            np.testing.assert_array_equal(numbers(two, name, *given), numbers(one, name, *given))


SMALL = """
[template]
name = "scara"

[template.numbers]
h = 0.5
l1 = 0.2

[template.joints]
joint1.limits = { lower = "-90 deg", upper = 1 }
joint3.friction = { viscous = 2, coulomb = 3 }

[parameters]
m1 = 3
I2 = "m2*l2^2/12"

[[payload]]
name = "load"
frame = "hand"
mass = 1
"""


def loaded(text: str) -> fb.Model:
    return fb.load(text=text, format="toml", physical="ignore")


def test_a_file_names_a_template(tmp_path):
    """It is the template with numbers bound: numbers in the place of names, in what follows from
    them too; values for other names; limits, drives, loads."""
    model = loaded(SMALL)
    twin = fb.template("scara", h=0.5, l1=0.2, m1=3, I2="m2*l2^2/12")
    assert model.parameters == {
        name: x for name, x in twin.parameters.items() if name not in ("h", "l1", "x1")
    }
    assert [x.name for x in model.formulas] == ["I2", "x2"]
    assert model.tip == twin.tip
    q, _, _ = fb.random_state(twin, 1, 3)
    loaded_twin = twin.with_payload(1.0, frame="hand")
    close(numbers(model, "mass_matrix", q), numbers(loaded_twin, "mass_matrix", q), 1e-14)
    given = {x.name: x.value for x in fb.parameters(model)}
    assert given["joint1.limits.lower"] == pytest.approx(-np.pi / 2, abs=1e-15)
    assert (given["joint1.limits.upper"], given["joint3.limits.upper"]) == (1.0, 0.195)
    assert (given["joint3.friction.coulomb"], given["joint1.friction.coulomb"]) == (3.0, 0.0)
    fb.save(model, tmp_path / "small.toml")
    assert fb.load(tmp_path / "small.toml", physical="ignore") == model
    assert loaded(SMALL.replace("m1 = 3", "m1 = 4")).parameters["m1"] == 4.0


def test_a_number_stays_in_formulas_that_others_follow(tmp_path):
    """Of a formula over a number and a name the name remains: it can still be another, and a file
    keeps it."""
    model = loaded('[template]\nname = "delta"\n[template.numbers]\nl1 = 0.4\n')
    twin = fb.template("delta", l1=0.4)
    fb.save(model, tmp_path / "delta.toml")
    assert fb.load(tmp_path / "delta.toml", physical="ignore") == model
    assert "l1" not in model.parameters
    for mass in (0.4, 0.7):
        one, two = model.bind(m1=mass).parameters, twin.bind(m1=mass).parameters
        assert one == {name: pytest.approx(two[name], rel=1e-15) for name in one}
        assert one["I1"] == pytest.approx(mass * 0.4**2 / 12, rel=1e-14)


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ('"scara"', '"skara"', "text:3: no template 'skara' in .template.. Did you mean 'scara'"),
        ("l1 = 0.2", "l9 = 0.2", "text:7: no parameter 'l9' in .template.numbers."),
        ("l1 = 0.2", 'l1 = "m1"', "text:7: .template.numbers.: l1 is 'm1', expected a number"),
        ("l1 = 0.2", "m1 = 2", "text:7: .* m1 has another value below .parameters.; keep one"),
        ("joint1.l", "joint9.l", "text:10: no joint 'joint9' in .template.joints."),
        ("viscous", "viscose", "text:11: no key 'viscose' in .template.joints., 'joint3', frict"),
        ("m1 = 3", "m1 = 3\nl7 = 1", "text:15: no parameter 'l7'"),
        ('"hand"', '"hant"', "text:19: no frame 'hant'"),
        ("[template]", "dim = 2\n[template]", "text:2: the template 'scara' has dim = 3; remove"),
        ("[template]", "[planar]\nword='R'\n[template]", "describes the whole robot"),
        ("h = 0.5", "I1 = -1", "text:2: .*link 'arm'"),
    ],
)
def test_what_is_wrong_in_such_a_file(old, new, told):
    with pytest.raises((fb.FileError, fb.ModelError), match=told):
        fb.load(text=SMALL.replace(old, new, 1), format="toml", physical="refuse")


def test_numbers_take_the_place_of_formulas():
    """The centres and inertias that a template finds by formulas may be one's own, too."""
    for name in ("delta", "palletiser", "scara", "six_axis"):
        own = fb.template(name)
        found = [x.name for x in own.formulas if x.name[0] in "Ix" or x.name.startswith("lc")]
        assert found, name
        given = {key: 1.1 * own.parameters[key] for key in found}
        model = fb.template(name, **given)
        assert model.parameters == own.parameters | given, name
        assert {x.name for x in model.formulas} == {x.name for x in own.formulas} - set(found)
    halved = fb.template("delta", l1=0.5, I1=0.004)
    assert (halved.parameters["lc1"], halved.parameters["I1"]) == (0.25, 0.004)


def test_a_template_with_all_masses_of_ones_own_is_not_estimated():
    numbers = {"l1": 0.3, "l2": 0.3, "l3": 0.5, "l4": 0.5, "m1": 1, "m2": 1, "m3": 0.5, "m4": 0.5}

    def of_file(numbers: dict[str, float]) -> fb.Model:
        given = "\n".join(f"{name} = {x}" for name, x in numbers.items())
        return loaded(f'[template]\nname = "five_bar"\n[template.numbers]\n{given}\n')

    for make in (lambda given: fb.template("five_bar", **given), of_file):
        assert not make(numbers).is_estimated
        assert make({"m1": 1}).is_estimated
        left = make({name: x for name, x in numbers.items() if name != "m4"})
        assert left.is_estimated
        (doubt,) = (x for x in left.doubts if x.kind == "estimated inertias")
        assert doubt.text.endswith(f"; still so for {left.bodies[-1].name}.")


@pytest.mark.sample(1)
@pytest.mark.parametrize("name", TEMPLATES)
def test_each_number_may_be_another(name):
    own = fb.template(name).parameters
    for key, value in own.items():
        if key != "g":
            assert fb.template(name, **{key: 1.1 * value}).parameters[key] == 1.1 * value, key


def test_gantry():
    model = fb.template("gantry", m1=7, m2=5, m3=3, height=4, length=1.5)
    M = numbers(model, "mass_matrix", np.array([[0.1, 0.2, 0.3]]))[0]
    np.testing.assert_array_equal(M, np.diag([15.0, 8.0, 3.0]))
    close(at(model, "tool", [0.1, 0.2, 0.3])[:3, 3], [0.1, 0.2, 4 + 0.3 - 1.5], 1e-15)


def test_six_axis():
    """Upright at zero, the forearm forwards; the wrist's axes meet, and so there are eight
    branches."""
    sizes = {"d1": 0.5, "a1": 0.2, "a2": 0.7, "a3": 0.05, "d4": 0.65, "d6": 0.12}
    model = fb.template("six_axis", **sizes)
    d1, a1, a2, a3, d4, d6 = sizes.values()
    T = at(model, model.tip or "", np.zeros(6))
    close(T[:3, 3], [a1 + d4 + d6, 0.0, d1 + a2 + a3], 1e-12)
    q = np.array([0.3, 0.2, 0.4, 0.5, 0.6, 0.7])
    assert len(fb.inverse_kinematics(model, at(model, model.tip or "", q)).q) == 8


def test_delta():
    """Clavel's inverse kinematics: each crank reaches its corner by a rod's length."""
    R, r, l1, l2 = 0.25, 0.06, 0.3, 0.7
    model = fb.template("delta", R=R, r=r, l1=l1, l2=l2)
    goal = np.array([0.05, -0.08, -0.6])
    q = dict(zip(model.position_names, fb.assemble(model), strict=True))
    q |= dict(zip("xyz", goal, strict=True))
    closed = fb.assemble(model, np.array(list(q.values())), free=["theta1", "theta2", "theta3"])
    for k, angle in enumerate(np.deg2rad([0, 120, 240]), start=1):
        turned = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
        x, y = turned @ goal[:2]
        E, F, G = R - r - x, goal[2], (l2**2 - l1**2 - (R - r - x) ** 2 - y**2 - goal[2] ** 2)
        theta = closed[model.position_names.index(f"theta{k}")]
        # (R + l1 cos - r - x)² + y² + (-l1 sin - z)² = l2²
        assert 2 * l1 * (E * np.cos(theta) + F * np.sin(theta)) == pytest.approx(G, abs=1e-12)
    assert fb.mobility(model, closed).instantaneous == 3


def test_palletiser():
    """The hand stays level, and the forearm as the rocker, wherever the drives are."""
    model = fb.template("palletiser", l1=1.1, l2=1.3, s=0.25)
    home = dict(zip(model.position_names, fb.assemble(model), strict=True))
    driven = set(model.driven_names)
    moved = home | {"turn": 0.4, "shoulder": -1.2, "drive": 0.5, "hand_turn": 0.3}
    q = fb.assemble(
        model, np.array(list(moved.values())), free=[x for x in home if x not in driven]
    )
    assert driven == {"turn", "shoulder", "drive", "hand_turn"}
    T = at(model, "hand", q)
    close(T[:3, 2], [0.0, 0.0, 1.0], 1e-10)
    reach = 0.2 + 1.1 * np.cos(1.2) + 1.3 * np.cos(0.5)
    height = 0.8 + 1.1 * np.sin(1.2) - 1.3 * np.sin(0.5)
    close(T[:3, 3], [reach * np.cos(0.4), reach * np.sin(0.4), height], 1e-10)


def test_what_is_not_known():
    with pytest.raises(fb.UnknownNameError, match="no template 'detla'"):
        fb.template("detla")
    with pytest.raises(fb.UnknownNameError, match="no template 'detla'"):
        fb.load("template:detla")
    with pytest.raises(fb.UnknownNameError, match="l9"):
        fb.template("delta", l9=1.0)


def test_the_command_line(capsys):
    assert run(["show", "template:gantry", "--parameter", "m3=33"]) == 0
    assert "33" in capsys.readouterr().out
    assert run(["show", "template:crane"]) == 2
    assert "no template 'crane'" in capsys.readouterr().err
