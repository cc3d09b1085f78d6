"""The ends of the scale in every public function: no joints, one joint, no samples, no rows."""

from __future__ import annotations

import numpy as np
import pytest

import freebody as fb
from freebody import Model

BLOCK = """name = "block"
[[link]]
name = "block"
mass = 2
com = [0.1, 0.2, 0.3]
inertia = [0.1, 0, 0, 0.1, 0, 0.1]
"""
KINEMATIC = (
    "forward_kinematics",
    "velocity",
    "acceleration",
    "jacobian",
    "jacobian_dot",
    "jacobian_derivatives",
)
NEEDS_JOINTS = (
    "centroidal_momentum_matrix",
    "operational_space_inertia",
    "operational_space_bias",
    "tip_wrench",
)
FUNCTIONS = {
    **dict.fromkeys(
        ("forward_kinematics", "jacobian", "jacobian_derivatives", "center_of_mass"), 1
    ),
    **dict.fromkeys(("velocity", "jacobian_dot", "coriolis_matrix", "bias", "momentum"), 2),
    **dict.fromkeys(("acceleration", "inverse_dynamics", "forward_dynamics", "joint_wrenches"), 3),
    **dict.fromkeys(("inverse_dynamics_derivatives", "inverse_dynamics_second_derivatives"), 3),
    **dict.fromkeys(
        ("forward_dynamics_derivatives", "forward_dynamics_parameter_derivatives", "regressor"), 3
    ),
    **dict.fromkeys(("mass_matrix", "mass_matrix_inverse", "gravity_torque", "static_torque"), 1),
    **dict.fromkeys(("potential_energy", "centroidal_momentum_matrix"), 1),
    **dict.fromkeys(("kinetic_energy", "energy_regressor"), 2),
}
"""How many of q, qd, qdd each takes."""


@pytest.fixture
def block(tmp_path) -> Model:
    path = tmp_path / "block.toml"
    path.write_text(BLOCK)
    return fb.load(path)


def shapes(
    model: Model, function: str, batch: tuple[int, ...], frame: str
) -> list[tuple[int, ...]]:
    """Core shapes of the results, which must have the batch in front."""
    state = fb.random_state(model, 1, batch)[: FUNCTIONS[function]]
    options = {"frame": frame} if function in KINEMATIC else {}
    for _ in range(2):  # at first, and once the kernel is known
        result = getattr(fb, function)(model, *state, **options)
        results = [np.asarray(x) for x in (result if isinstance(result, tuple) else (result,))]
        assert all(x.shape[: len(batch)] == batch and np.isfinite(x).all() for x in results)
    return [x.shape[len(batch) :] for x in results]


@pytest.mark.parametrize("function", [name for name in FUNCTIONS if name not in NEEDS_JOINTS])
def test_a_robot_without_joints(block: Model, function: str):
    cores = {
        str(shapes(block, function, batch, "block")) for batch in ((), (3,), (0,), (2, 0), (2, 3))
    }
    assert len(cores) == 1


def test_a_robot_without_joints_knows_its_place(block: Model):
    none = np.zeros((3, 0))
    assert fb.dexterity(block, none, "block").singular_values.shape == (3, 0)
    assert not fb.ellipsoids(block, none, "block").singular_values.any()
    assert fb.jacobian(block, none, "block").shape == (3, 6, 0)
    assert fb.center_of_mass(block, none).tolist() == [[0.1, 0.2, 0.3]] * 3
    with pytest.raises(
        fb.FreebodyError, match=r"^no link that moves has a mass, so there is no centre of mass; "
    ):
        fb.centroidal_momentum_matrix(block, none)


@pytest.mark.sample(4)
@pytest.mark.parametrize("function", FUNCTIONS)
@pytest.mark.parametrize("word", ["R", "P"])
def test_one_joint_and_no_samples(word: str, function: str):
    model = fb.planar(word, l=[1], lc=[0.5], m=[1], I=[0.1])
    for arm in (model, model.to_space()):
        cores = {
            str(shapes(arm, function, batch, "tip")) for batch in ((), (1,), (0,), (2, 0), (3,))
        }
        assert len(cores) == 1


def test_one_row_at_least_and_each_once():
    model = fb.planar("RR", l=[1, 1], lc=[0.5, 0.5], m=[1, 1], I=[0.1, 0.1])
    for rows, given in (((), "()"), (("vx", "vx"), "('vx', 'vx')"), ("vx", "'vx'")):
        with pytest.raises(fb.FreebodyError) as refusal:
            fb.operational_space_inertia(model, [0.1, 0.2], rows=rows)
        assert (
            str(refusal.value)
            == f"rows is {given}, expected one or several of vx, vy, w, each once."
        )


def test_singular_samples_are_named():
    model = fb.planar("RR", l=[1, 1], lc=[0.5, 0.5], m=[1, 1], I=[0.1, 0.1])
    q = np.array([[0.1, 0.2], [0.3, 0.0]])
    with pytest.raises(
        fb.FreebodyError,
        match=r"^operational_space_bias: frame 'tip' of 'RR' is at a singularity at sample 1: ",
    ):
        fb.operational_space_bias(model, q, q, rows=("vx", "vy"))
    with pytest.raises(
        fb.FreebodyError, match=r"^tip_wrench: the Jacobian of 'RR' is singular at sample 1: "
    ):
        fb.tip_wrench(model, q, q)
