"""Closed chains from inside: which equations and dyads are chosen, what is kept and compiled."""

from __future__ import annotations

import numpy as np
import pytest

import freebody as fb
from freebody import Model, SingularError
from freebody.algorithms.loop_constraints import Counting
from freebody.any_chain.reactions import balance
from freebody.kernels import lookup, structural
from freebody.kernels.formulas import Option
from freebody.kernels.tracing import program
from freebody.loops.assembly import _solutions
from freebody.loops.dyad_decomposition import decomposed
from freebody.loops.independent_equations import independent_rows, partition
from freebody.program import Program
from freebody.targets import compile_program
from support.helpers import close
from support.loop_scales import residual


def distinct(q):
    """Positions up to whole turns."""
    return {tuple(np.round(np.concatenate([np.cos(x), np.sin(x)]), 6) + 0.0) for x in q}


@pytest.mark.parametrize(
    ("name", "free", "steps"),
    [
        ("five_bar", ["B", "D"], ["Triangle"]),
        ("five_bar_rods", ["x", "y"], ["TwoCircles"]),
        ("five_bar_rods", ["theta1", "theta2"], ["Swing", "Swing"]),
        ("four_bar", ["coupler_pin", "rocker_pin"], ["Triangle"]),
        ("four_bar", ["crank_pin", "coupler_pin"], ["Triangle"]),
        ("slider_crank", ["rod_pin", "guide"], ["TurnAndSlide"]),
        ("slider_crank", ["crank_pin", "rod_pin"], ["Triangle"]),
        ("slider_crank", ["crank_pin", "guide"], ["TurnAndSlide"]),
        ("3RRR", ["drive1", "elbow1", "drive2", "elbow2", "drive3", "elbow3"], ["Triangle"] * 3),
    ],
)
def test_dyads_find_what_a_search_finds(name, free, steps):
    model = fb.load(name)
    start = np.linspace(0.3, 0.9, model.nq) if name != "3RRR" else np.linspace(0.02, 0.06, model.nq)
    q = fb.assemble(model, start)
    moving = [model.position_names.index(x) for x in free]
    plan = decomposed(model, moving)
    assert plan is not None
    assert [type(step).__name__ for step in plan.steps] == steps
    found = fb.assembly_modes(model, q, free=free)
    assert len(found) == 2 ** len(steps)
    np.testing.assert_allclose(residual(model, found), 0, atol=1e-12)
    np.testing.assert_allclose(
        np.delete(found, moving, axis=1), np.delete(np.tile(q, (len(found), 1)), moving, axis=1)
    )
    assert len(set(plan.branches(found))) == len(found)
    assert distinct(_solutions(model, q, moving, 200)) == distinct(found)
    np.testing.assert_allclose(found[0], q, atol=1e-9)  # nearest first


def test_two_slides_carry_the_block_of_a_scotch_yoke_to_its_crank_pin(tmp_path):
    file = tmp_path / "yoke.toml"
    file.write_text(
        """
        dim = 2
        link = [{ name = "base" }, { name = "crank" }, { name = "yoke" }, { name = "block" }]
        frame = [{ name = "pin", parent = "crank", origin = [0.3, 0] }]
        joint = [
            { name = "turn", kind = "revolute", parent = "base", child = "crank" },
            { name = "x", kind = "prismatic", parent = "base", child = "yoke", axis = "x" },
            { name = "y", kind = "prismatic", parent = "yoke", child = "block", axis = "y" },
        ]
        """
    )
    model = fb.load(file).with_loop("slot", "revolute", ("pin", "block"))
    plan = decomposed(model, [1, 2])
    assert plan is not None
    found, anywhere = plan.solve(np.array([[0.4, 0.1, -0.2]]))
    assert not anywhere.any()
    np.testing.assert_allclose(found, [[[0.4, 0.3 * np.cos(0.4), 0.3 * np.sin(0.4)]]], atol=1e-15)


def test_what_is_no_row_of_dyads():
    assert decomposed(fb.load("3RRR"), [0, 1, 2, 4, 6, 8]) is None  # all legs at once
    assert decomposed(fb.load("bricard"), range(5)) is None
    assert decomposed(fb.load("2R"), [0, 1]) is None
    four_bar = fb.load("four_bar")
    assert decomposed(four_bar, [0, 1, 2]) is None  # one too many


@pytest.mark.parametrize("name", ["five_bar", "stewart"])
def test_the_balance_sees_every_wrong_wrench(name):
    model = fb.load(name)
    q, still = fb.assemble(model)[None], np.zeros((1, model.nv))
    found = fb.reactions(model, q, still, tau=fb.static_torque(model, q))
    assert np.abs(balance(model, q, still, found.qdd, found.wrenches, {}).force).max() < 1e-9
    for k in range(len(found.names)):
        wrong = found.wrenches.copy()
        wrong[0, k, 0] += 1.0
        off = balance(model, q, still, found.qdd, wrong, {}).force
        np.testing.assert_allclose(np.abs(off).max(), 1.0, atol=1e-9)


def test_a_lane_where_the_choice_fails_is_nan_and_the_function_takes_care():
    """Both distal links of a five-bar in line: cranks do not hold the tip there, though an elbow's
    drive would."""
    model = fb.load("five_bar")
    p = model.parameters
    angle = np.arccos(((p["l3"] + p["l4"]) / 2 - p["b"]) / p["l1"])
    at = {"theta1": np.pi - angle, "B": angle - np.pi, "theta2": angle, "D": np.pi - angle}
    singular = np.array([at[name] for name in model.joint_names])
    q = fb.default_motion(model, samples=9).q.copy()
    alone = fb.static_torque(model, q)
    q[3] = singular
    found = fb.kernel(model, "static_torque")(q)
    np.testing.assert_array_equal(np.isnan(found[:, :2]).all(axis=-1), np.arange(9) == 3)
    np.testing.assert_array_equal(np.delete(found, 3, axis=0), np.delete(alone, 3, axis=0))
    with pytest.raises(
        SingularError, match=r"static_torque: .* at sample 3: it can move with these joints locked"
    ):
        fb.static_torque(model, q)
    # with a third drive the fixed choice still fails there, and another one is taken
    more = model.replace(actuated=["theta1", "theta2", "B"])
    chosen = partition(more)
    assert chosen is not None
    tau = fb.static_torque(more, q)
    assert np.isfinite(tau).all()
    np.testing.assert_array_equal(tau[3], fb.static_torque(more, singular))


@pytest.mark.parametrize("name", ["five_bar", "3RRR"])
def test_one_singular_sample_leaves_the_others(name: str):
    model = fb.load(name)
    motion = fb.default_motion(model, samples=9)
    few = model.replace(actuated=model.actuated[:1])
    assert partition(few) is None
    with pytest.raises(SingularError, match="holds near its home, which a compiled kernel needs"):
        fb.kernel(few, "inverse_dynamics")
    with pytest.raises(SingularError, match="at sample 0: it can move with these joints locked"):
        fb.static_torque(few, motion.q)


def test_a_changed_number_compiles_nothing_anew(monkeypatch: pytest.MonkeyPatch):
    """Another length and mass of the same structure: every function of closed chains has its
    kernels already."""

    def work(model: Model) -> None:
        q = fb.assemble(model, motion.q)
        qd = fb.loop_velocity(model, q, motion.qd)
        qdd = fb.loop_acceleration(model, q, qd, motion.qdd)
        tau = fb.inverse_dynamics(model, q, qd, qdd)
        fb.static_torque(model, q)
        close(fb.forward_dynamics(model, q, qd, tau), qdd, 1e-9, 1.0)
        assert fb.reactions(model, q, qd, qdd=qdd).balance < 1e-12

    model = fb.load("five_bar")
    motion = fb.default_motion(model, samples=9)
    work(model)

    def refused(*args: object, **options: object) -> None:
        raise AssertionError("compiled anew")

    monkeypatch.setattr(structural, "compile_program", refused)
    monkeypatch.setattr(lookup, "compile_program", refused)
    work(model.bind(l1=1.01 * model.parameters["l1"], m3=1.3 * model.parameters["m3"]))
    with pytest.raises(AssertionError, match="compiled anew"):
        fb.assemble(model.to_space())


def _states(name: str, samples: int = 9):
    model = fb.load(name)
    motion = fb.default_motion(model, samples=samples)
    return model, motion.q, motion.qd


@pytest.mark.parametrize("dtype", ["float64", "float32"])
def test_rates_that_contradict_the_loops_and_positions_that_tell_none_are_nan(dtype: str):
    model, q, qd = _states("four_bar")
    program = _held(model, (0, 1))
    kernel = compile_program(program, dtype=dtype)
    assert np.isfinite(kernel(q, qd)).all()
    wrong = qd + np.array([0.0, 0.02, 0.0])
    assert np.isnan(kernel(q, wrong)).all()


def _held(model: fb.Model, held: tuple[int, ...]) -> Program:
    """The rates that those of some coordinates tell, one more than need be."""
    return program(model, ("loop_velocity",), Option(held=held, equations=Counting((0, 1))))


def _state(name: str, samples: int = 9):
    model = fb.load(name)
    motion = fb.default_motion(model, samples=samples)
    return model, motion.q, motion.qd, motion.qdd


@pytest.mark.usefixtures("numpy_kernels")
def test_other_numbers_than_lengths_leave_the_geometry_alone():
    model, q, qd, qdd = _state("stewart")
    fb.inverse_dynamics(model, q, qd, qdd)
    known = dict(model.geometry.facts)
    assert known
    leg = model.joint_names[-1]
    others = (
        model.with_payload(mass=2.0, frame="platform"),
        model.bind({"platform.mass": 3.0}),
        model.replace(gravity=1.6),
        model.replace(name="another"),
        model.replace(actuated=model.joint_names[:3]),
        fb.load("stewart"),
    )
    for other in others:
        assert other.geometry is model.geometry, other
        independent_rows(other)
    assert all(model.geometry.facts[key] is value for key, value in known.items())
    for other in (
        model.bind({f"{leg}.placement.x": 0.123}),
        model.replace(loop_tolerance=(0.0, 0.0)),
        model.opened,
    ):
        assert other.geometry is not model.geometry, other


@pytest.mark.usefixtures("numpy_kernels")
def test_facts_of_one_geometry_are_not_those_of_another():
    """A crank that is longer than the rest together closes nowhere."""
    model = fb.load("four_bar")
    stuck = model.bind(l1=50.0)
    assert partition(model) is not None
    assert partition(stuck) is None
    assert partition(model.bind(m1=50.0)) is partition(model)
