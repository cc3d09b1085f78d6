"""The first kind in absolute coordinates: the forces in the joints leave, and what remains is what
other methods find; the printed equations hold for motions and forces of the kernels."""

from __future__ import annotations

import numpy as np
import pytest

import freebody as fb
from freebody.expressions.expression import Equation, eq
from freebody.expressions.polynomials.symbols import symbols
from freebody_textbook.closed_chains.absolute import AbsoluteCoordinates
from freebody_textbook.closed_chains.loop_equations import LoopEquations
from freebody_textbook.closed_chains.multiplier_equations import FirstKind
from freebody_textbook.derivation import Derivation
from freebody_textbook.methods.absolute_coordinates import BackToJoints
from freebody_textbook.methods.body_by_body import SolvedReactions
from freebody_textbook.methods.loop_forces_on_bodies import LoopReactions
from freebody_textbook.methods.loops_and_multipliers import Loops
from freebody_textbook.methods.setting import Setting
from support.methods import agree
from support.printed_values import evaluate
from support.robots import Joint, Link, Mount, Robot, loaded, shift, turn
from support.symbolic import spatial_arm, with_values

pytestmark = pytest.mark.usefixtures("numpy_kernels")

METHOD = "lagrange-first-kind"


def absolute(model: fb.Model, **options: object) -> Derivation:
    return fb.derive(model, METHOD, coordinates="absolute", **options)


def lines_of(derivation: Derivation, operation: str) -> list[Equation]:
    return [x for s in derivation.steps if s.operation.startswith(operation) for x in s.equations]


@pytest.mark.sample(3)
@pytest.mark.parametrize("word", ["R", "P", "RR", "RP", "PR", "RRP"])
@pytest.mark.parametrize("load", [False, True])
def test_open_chains_end_in_the_second_kind(word, load):
    model = fb.planar(word)
    assert agree(absolute(model, load=load), fb.derive(model, "lagrange", load=load))


@pytest.mark.sample(3)
@pytest.mark.parametrize(
    "name", ["four_bar", "slider_crank", "five_bar", "five_bar_rods", "double_four_bar", "3RRR"]
)
def test_closed_chains_end_in_the_first_kind_of_the_joints(name):
    derivation = absolute(fb.load(name))
    loops = LoopEquations(derivation.equations.symbols)
    assert list(derivation.tau) == FirstKind(loops, derivation.equations).forces


def test_friction_springs_and_rotors_act_along_the_joints():
    drive = fb.Drive(viscous="b1", coulomb="k1", rotor="J1", stiffness="s1", rest="r1")
    model = fb.planar("RP", drives=[drive, fb.Drive(viscous="b2")])
    derivation = absolute(model)
    assert agree(derivation, fb.derive(model, "lagrange"))
    assert "Q₂ = τ₂ − b₂ ḋ₂" in map(str, lines_of(derivation, "Forces along"))
    assert "m₂ ẍ₂ = cos(φ₁) Q₂ + sin(φ₁) λ₃" in map(str, lines_of(derivation, "The equations of"))


def turned_slide() -> fb.Model:
    """A slide on a turned frame of an arm whose base is turned, too."""
    links = (
        Link("ground"),
        Link("arm", fb.Inertia.of(2.0, (0.2, 0.1), 0.3)),
        Link("rod", fb.Inertia.of(1.0, (0.3, -0.1), 0.1)),
    )
    at = shift(0.5, 0.1).then(turn("z", -np.pi / 3))
    joints = (
        Joint("pin", "revolute", "ground", "arm", turn("z", np.pi / 2), (1.0,)),
        Joint("slide", "prismatic", "arm", "rod", at, (0.0, 1.0)),
    )
    gravity = (fb.Parameter("g", 9.81), (0.0, -1.0))
    end = Mount("end", "rod", shift(0.5, 0.0))
    return loaded(Robot("turned", 2, links, joints, gravity, (end,), tip="end"))


STATES = {
    "RPR": lambda: with_values(fb.planar("RPR")),
    "turned": turned_slide,
    **{name: lambda name=name: fb.load(name) for name in ("five_bar", "slider_crank", "3RRR")},
}


@pytest.mark.sample(3)
@pytest.mark.parametrize("name", STATES)
def test_printed_equations_hold_for_motions_and_reactions(name):
    """(5.29) solved in absolute coordinates: accelerations are those of forward dynamics, the
    multipliers the reactions of Newton and Euler, and every printed line holds."""
    model = STATES[name]()
    rng = np.random.default_rng(4)
    q, qd, _ = fb.random_state(model, seed=3)
    if model.loops:
        q = fb.assemble(model)
        qd = fb.loop_velocity(model, q, rng.normal(size=model.nv))
    tau = rng.normal(size=model.nv) * [x in model.driven_names for x in model.velocity_names]
    qdd = fb.forward_dynamics(model, q, qd, tau)
    derivation = absolute(model)
    setting = Setting(symbols(model, extra=derivation.equations.symbols.extra))
    loops = Loops(setting)
    motors = {i: f"tau{setting.numbers[i]}" for i in setting.order if setting.driven(i)}
    given = AbsoluteCoordinates(setting.symbols, motors)
    back = BackToJoints(setting, given, loops)
    rates = setting.symbols.rates
    known = setting.symbols.values(q, qd, qdd) | {f"tau{k}": x for k, x in enumerate(tau, 1)}
    for x, poly in zip(given.names, back.placed, strict=True):
        velocity = poly.along(rates)
        known[x] = poly.evaluate(known)
        known[x + "_d"] = velocity.evaluate(known)
        known[x + "_dd"] = velocity.along(rates).evaluate(known)
    for i in given.bodies:  # constant turns, which the polynomials leave out
        R = np.array([[float(x.evaluate(known)) for x in map(setting.symbols.element, row)]
                      for row in setting.world[i][0]])  # fmt: skip
        known[given.names_of(i)[2]] = np.arctan2(R[1, 0], R[0, 0])
    m = len(given.Phi)
    idle = known | {f"lam{k}": 0.0 for k in range(1, m + 1)}
    M = np.diag([x.evaluate(known) for x in given.M])
    Phi_q = np.array([[x.evaluate(known) for x in row] for row in given.Phi_q])
    n = [x.evaluate(idle) for x in given.forces]
    c = [x.evaluate(known) for x in given.c]
    solved = np.linalg.solve(np.block([[M, Phi_q.T], [Phi_q, np.zeros((m, m))]]), [*n, *c])
    found = [known[x + "_dd"] for x in given.names]
    np.testing.assert_allclose(solved[: len(n)], found, rtol=1e-8, atol=1e-8)
    known |= {f"lam{k}": x for k, x in enumerate(solved[len(n) :], 1)} | {"pi": np.pi}
    reactions = LoopReactions(setting, loops) if model.loops else SolvedReactions(setting)
    for i in given.joints:
        name = setting.force_name(setting.tree.bodies[i].parent, i)
        (line,) = [x for x in lines_of(derivation, "Meaning") if x.lhs == name]
        f = [setting.symbols.element(x).evaluate(known) for x in reactions.f[i]]
        np.testing.assert_allclose(evaluate(line, known), f, rtol=1e-7, atol=1e-7)
    for line in lines_of(derivation, "The equations of body"):
        left, right = (evaluate(eq(side), known) for side in line.sides)
        assert left == pytest.approx(right, rel=1e-8, abs=1e-8)
    for line in lines_of(derivation, "The constraints"):
        assert evaluate(eq(line.sides[1]), known) == pytest.approx(0.0, abs=1e-9)
    for line in lines_of(derivation, "Back to"):
        if str(line.lhs)[0] in "xy" or str(line.lhs)[0] == "φ":
            left, right = (evaluate(eq(side), known) for side in line.sides)
            assert np.sin((left - right) / 2) == pytest.approx(0.0, abs=1e-9)


def test_constant_turns_are_told():
    derivation = absolute(turned_slide())
    back = [str(x) for x in lines_of(derivation, "Back to")]
    assert "φ₁ = θ₁ + π/2" in back
    assert "φ₂ = θ₁ + π/6" in back
    assert "θ₁ = φ₁ − π/2" in map(str, lines_of(derivation, "Forces along"))
    assert "Φ₄ = −φ₁ + φ₂ + π/3 = 0" in map(str, lines_of(derivation, "The constraints"))


def test_a_platform_that_nothing_holds_has_no_joint():
    derivation = absolute(fb.load("3RRR"))
    assert "No joint holds body 3." in next(
        s.reason for s in derivation.steps if s.operation == "The constraints"
    )
    assert "f = n − m = 21 − 18 = 3" in map(str, lines_of(derivation, "Degrees of freedom"))


def test_what_absolute_coordinates_do_not_serve():
    with pytest.raises(fb.FreebodyError, match="is in space; leave coordinates out"):
        absolute(spatial_arm(1, 2))
    with pytest.raises(fb.FreebodyError, match="'x1' stands for two quantities"):
        absolute(fb.planar("R", l=["x1"]))
