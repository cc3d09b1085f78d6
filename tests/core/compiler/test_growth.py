"""How work grows, counted: operations with the joints, kernels with the numbers, memory with the
batch. No clock."""

from __future__ import annotations

import tracemalloc

import numpy as np
import pytest

import freebody as fb
from support.generate import odd_chain
from support.robots import loaded


def chain(n: int) -> fb.Model:
    """Revolute joints whose axes turn by an odd angle from one to the next, so that nothing folds
    away."""
    rows = [
        {
            "a": 0.3,
            "d": 0.1,
            "alpha": 0.4 + 0.1 * (i % 7),
            "m": 1.0,
            "com": (-0.1, 0.02, 0.03),
            "I": [0.02, 0.0, 0.0, 0.02, 0.0, 0.02],
        }
        for i in range(n)
    ]
    return fb.dh(rows, convention="standard")


def operations(n: int, quantity: str) -> int:
    return sum(fb.kernel(chain(n), quantity, target="numpy").program.operations.values())


LINEAR = ("forward_kinematics", "jacobian", "inverse_dynamics", "potential_energy", "mass_product")
SQUARE = {
    "mass_matrix": range(18, 40, 7),  # the angles come again every 7th joint
    "inverse_dynamics_derivatives": range(6, 16, 3),
}


@pytest.mark.parametrize("quantity", LINEAR)
def test_each_joint_costs_the_same(quantity: str):
    costs = np.diff([operations(n, quantity) for n in (6, 9, 12, 15)])
    assert costs.max() <= 1.03 * costs.min(), costs


@pytest.mark.sample(1)
@pytest.mark.parametrize(("quantity", "joints"), SQUARE.items())
def test_each_joint_costs_as_much_more_than_the_one_before(quantity: str, joints: range):
    """What a further joint costs grows by the same amount: the square of their number, and no
    more."""
    more = np.diff([operations(n, quantity) for n in joints], 2)
    assert 0 < more.min() <= more.max() <= 1.2 * more.min(), more


def test_robots_without_zeros():
    """Operations of 30 joints with axes in any direction: from frame to frame, in the robot's own
    frames, they are 27 000 and 8 700."""
    model = loaded(odd_chain(30, 1))
    for quantity, most in (("mass_matrix", 11_200), ("inverse_dynamics", 5_200)):
        program = fb.kernel(model, quantity, target="numpy").program
        assert sum(program.operations.values()) < most, quantity


def test_robots_of_one_structure_compile_once():
    """Whatever their numbers, and however often each of them changes."""
    q = np.full(4, 0.3)
    robot = chain(4)
    expected = fb.inverse_dynamics(robot, q, q, q)
    known = dict(robot.structure.kernels)
    for k in range(1, 30):
        robot = robot.bind({f"link{1 + k % 4}.mass": 1.0 + 0.1 * k}).with_payload(0.01 * k)
        assert not np.array_equal(fb.inverse_dynamics(robot, q, q, q), expected)
    assert robot.structure.kernels == known


@pytest.mark.parametrize("threads", [1, 2])
def test_a_call_into_given_arrays_takes_no_memory_that_grows_with_the_batch(threads: int):
    kernel = fb.kernel(chain(4), ["inverse_dynamics", "mass_matrix"])

    def peak(batch: int) -> int:
        given = [np.full((batch, 4), 0.1 * k) for k in range(3)]
        out = np.empty((batch, 4)), np.empty((batch, 4, 4))
        kernel(*given, out=out, threads=threads)
        tracemalloc.start()
        kernel(*given, out=out, threads=threads)
        taken = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        return taken

    assert (
        peak(100_000) < peak(1_000) + 20_000
    )  # bytes; a hundredth of what one more array would take
