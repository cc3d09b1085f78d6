"""Derivations of bodies that nothing holds, and of spherical joints, by angles for quaternions."""

from __future__ import annotations

import pickle
from typing import Any

import numpy as np
import pytest

import freebody as fb
from freebody import Inertia, Model
from support.methods import METHODS, agree
from support.printed_values import evaluate, is_a, parts
from support.robots import Joint, Link, Robot, loaded

SYMBOLIC = Inertia.of("m", ["a", 0, "c"], ["Ixx", 0, "Ixz", "Iyy", 0, "Izz"])
PLAIN = Inertia.of("M", [0, 0, 0], ["J", 0, 0, "J", 0, "J"])
HOOK = Inertia.of(0.7, [0.1, 0, 0], [0.02, 0, 0.01, 0.03, 0, 0.04])
DOWN = (9.81, (0.0, 0.0, -1.0))
NUMBERS = {"m": 1.3, "a": 0.2, "c": -0.4, "Ixx": 0.9, "Ixz": 0.1, "Iyy": 1.1, "Izz": 0.7} | {
    "M": 2.0,
    "J": 0.6,
}


def bodies(*kinds: str) -> Model:
    """Bodies on the ground by such joints, the first with its centre of mass aside."""
    names = [f"body{k}" for k in range(1, len(kinds) + 1)]
    links = [Link(name, x) for name, x in zip(names, (SYMBOLIC, PLAIN), strict=False)]
    joints = [Joint(f"joint_{n}", kind, "base", n) for n, kind in zip(names, kinds, strict=True)]
    made = Robot("bodies", 3, (Link("base"), *links), tuple(joints), DOWN)
    return loaded(made)


def turned(angles: np.ndarray) -> np.ndarray:
    """R_z R_y R_x of yaw, pitch and roll."""
    (a, b, c), (x, y, z) = angles, np.eye(3)

    def turn(angle: float, axis: np.ndarray) -> np.ndarray:
        K = np.cross(np.eye(3), axis)
        return np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K

    return turn(a, z) @ turn(b, y) @ turn(c, x)


def as_quaternion(R: np.ndarray) -> np.ndarray:
    """w, x, y, z of a rotation by less than half a turn."""
    axis = np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
    w = np.sqrt(1 + np.trace(R)) / 2
    return np.array([w, *(axis / (4 * w))])


def lines(derivation, operation: str) -> dict[str, Any]:
    """The equations of the steps whose heading begins so, by the name on the left."""
    return {
        line.lhs.name: line
        for step in derivation.steps
        if step.operation.startswith(operation)
        for line in step.equations
        if is_a(line.lhs, "Symbol")
    }


class State:
    """A random state of one free body, by angles and by quaternion; rates by small differences."""

    def __init__(self, seed: int = 0):
        rng = np.random.default_rng(seed)
        self.p, self.angles = rng.normal(size=3), rng.uniform(-0.7, 0.7, 3)
        self.rates, self.v, self.vd, self.wd = rng.normal(size=(4, 3))
        h = 1e-6
        R, later, before = (turned(self.angles + d * self.rates) for d in (0, h, -h))
        W = R.T @ (later - before) / (2 * h)
        self.R, self.w = R, np.array([W[2, 1], W[0, 2], W[1, 0]])
        self.q = as_quaternion(R)

    def known(self, names: tuple[str, ...]) -> dict[str, float]:
        """By the names of a derivation of one body: coordinates, v and ω, numbers."""
        known = dict(zip(names, (*self.p, *self.angles), strict=True)) | {"g": 9.81}
        known |= dict(zip([f"{x}_d" for x in names[3:]], self.rates, strict=True))
        for letter, plain, second in (("v", self.v, self.vd), ("omega", self.w, self.wd)):
            for axis, a, b in zip("xyz", plain, second, strict=True):
                known |= {f"{letter}_{axis}": a, f"{letter}_{axis}_d": b}
        known |= {f"q_{x}": value for x, value in zip("wxyz", self.q, strict=True)}
        return known | NUMBERS


def with_numbers(model: Model) -> Model:
    """With the values of those of the numbers that it has."""
    return model.bind(**{name: NUMBERS[name] for name in model.missing})


QUADROTOR = fb.load("quadrotor")
LOADED = {
    "point": QUADROTOR.with_payload(mass=0.1, com=(0.1, 0, 0)),
    "box": QUADROTOR.with_payload(mass=2.0, com=(0.1, -0.2, 0.3), box=(0.3, 0.2, 0.1)),
    "tool": QUADROTOR.with_tool("hook", (0, 0.1, -0.4), inertia=HOOK),
    "two": QUADROTOR.with_payload(mass=1.0, com=(0.2, 0, 0)).with_payload(0.5, frame="rotor2"),
    "letters": with_numbers(bodies("free")).with_payload(HOOK),
    "none": QUADROTOR.with_payload(mass=0.0),
}


@pytest.mark.sample(4)
@pytest.mark.parametrize(
    "model",
    [QUADROTOR, bodies("free"), *LOADED.values()],
    ids=["quadrotor", "own", *LOADED],
)
def test_the_printed_equations_are_inverse_dynamics_in_the_axes_of_the_body(model):
    """f and n as printed, against recursive Newton-Euler of the free joint itself."""
    derivation, state = fb.derive(model), State()
    symbols = derivation.equations.symbols
    known = state.known(symbols.coordinates)
    known |= {name: x for name, x in symbols.model.parameters.items() if x is not None}
    printed = lines(derivation, "The equations of motion")
    f, n = ([evaluate(printed[f"{x}_{a}"].rhs, known) for a in "xyz"] for x in "fn")
    numbers = with_numbers(model)
    x = (*state.p, *state.q), (*state.v, *state.w), (*state.vd, *state.wd)
    q, qd, qdd = map(np.array, x)
    wanted = fb.inverse_dynamics(numbers, q, qd, qdd)
    level = (0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0)
    at = fb.center_of_mass(numbers, level)
    np.testing.assert_allclose(f, wanted[:3], atol=1e-9)
    np.testing.assert_allclose(np.add(n, np.cross(at, f)), wanted[3:], atol=1e-9)


def test_the_printed_kinematics_are_those_of_the_free_joint():
    """ω by the angles' rates and back; R and the rates of the quaternion."""
    derivation, state = fb.derive(fb.load("quadrotor")), State(1)
    names = derivation.equations.symbols.coordinates
    known = state.known(names)
    angles = lines(derivation, "Rates of the angles")
    w = [evaluate(angles[f"omega_{a}"].rhs, known) for a in "xyz"]
    np.testing.assert_allclose(w, state.w, atol=1e-8)
    back = [evaluate(angles[f"{x}_d"].rhs, known) for x in names[3:]]
    np.testing.assert_allclose(back, state.rates, atol=1e-8)
    four = lines(derivation, "A quaternion")
    for place in (lines(derivation, "Position")["R"], four["R"]):
        np.testing.assert_allclose(evaluate(place, known), state.R, atol=1e-9)
    rates = [evaluate(four[f"q_{x}_d"].rhs, known) for x in "wxyz"]
    h = 1e-6
    ends = (as_quaternion(turned(state.angles + d * state.rates)) for d in (h, -h))
    np.testing.assert_allclose(rates, np.subtract(*ends) / (2 * h), atol=1e-8)


@pytest.mark.sample(1)
@pytest.mark.parametrize("kinds", [("free", "free"), ("spherical", "free")])
def test_every_method_ends_in_the_same_polynomials(kinds):
    model = bodies(*kinds)
    first = fb.derive(model, "newton-euler")
    for tau, closed in zip(first.tau, first.equations.tau, strict=True):
        assert (tau - closed).is_zero
    assert agree(first, fb.derive(model, "lagrange"))


def test_thrusts_of_the_quadrotor():
    """(6.10), (6.11): what four rotors give, and what they do not."""
    derivation = fb.derive(fb.load("quadrotor"))
    step = next(step for step in derivation.steps if "thrusts" in step.operation)
    printed = lines(derivation, "Force and moment")
    thrusts = {f"T{k}": x for k, x in enumerate((3.2, 1.4, 2.5, 3.6), 1)}  # the notes' numbers
    f, n = (evaluate(printed[name], thrusts) for name in "fn")
    np.testing.assert_allclose((*f, *n), (0, 0, 10.7, -1.1, -0.35, 0), atol=1e-12)
    assert step.reason.endswith("no force along x, no force along y and no moment about z.")
    assert not any("thrusts" in s.operation for s in fb.derive(bodies("free")).steps)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(
    "model", [QUADROTOR, LOADED["point"], LOADED["none"]], ids=["bare", "loaded", "none"]
)
def test_every_method_makes_a_page_of_the_quadrotor(model, method):
    assert "<svg" in fb.derive(model, method).html()


def test_a_free_body_with_its_load_is_one_body():
    model, two = LOADED["point"], bodies("free", "free").with_payload(HOOK, frame="body2")
    assert "The body is body and payload as one rigid body" in fb.derive(model).given
    assert "Body 6 is body and payload as one" in fb.derive(model, "lagrange").given
    assert "Body 2 is body2 and payload as one" in fb.derive(two).given


def test_each_symbol_is_in_the_table():
    for model in (fb.load("quadrotor"), bodies("free", "free")):
        derivation = fb.derive(model)
        told = {x.name for row in derivation.glossary for x in row.symbols if is_a(x, "Symbol")}
        used = {
            node.name.removesuffix("_d").removesuffix("_d")
            for step in derivation.steps
            for line in step.equations
            for node in parts(line)
            if is_a(node, "Symbol")
        }
        components = {x for x in used if x.split("_")[0].rstrip("12") in ("f", "n")}
        assert used - told - components - {"g", "m"} == set()
        assert "singular" in derivation.text()


def test_spherical_joints_say_that_angles_stand_for_them():
    told = fb.derive(bodies("spherical"), "lagrange").given
    assert "are yaw, pitch and roll" in told
    assert "singular where the cosine of θ_2 vanishes" in told


def test_what_a_free_body_has_not_is_refused():
    model = fb.load("quadrotor")
    with pytest.raises(fb.FreebodyError, match="a free body has no pivot"):
        fb.derive(model, route="pivot")
    with pytest.raises(fb.FreebodyError, match="leave load out"):
        fb.derive(model, load=True)
    with pytest.raises(fb.FreebodyError, match="need coordinates that are numbers"):
        fb.equations(model)


def test_symbols_with_angles_are_pickled():
    derivation = fb.derive(bodies("free"), "kane")
    assert pickle.loads(pickle.dumps(derivation.equations.symbols)) == derivation.equations.symbols


def test_gyroscopic_moment_is_commented():
    gyro, said = fb.load("gyro"), "The bearing carries them, at right angles to the axis of joint 1"
    for method in ("newton-euler", "recursive"):
        steps = fb.derive(gyro, method).steps
        assert any(said in step.reason for step in steps)
    arm = fb.derive(fb.load("elbow_arm"), "newton-euler")
    assert "gyroscopic moment: the angular momentum" in " ".join(arm.text().split())
    assert not any("No centre of mass moves" in step.reason for step in arm.steps)
    swung = fb.derive(fb.load("furuta"), "newton-euler")
    assert not any("No centre of mass moves" in step.reason for step in swung.steps)
