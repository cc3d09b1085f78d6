"""Descents towards poses by a kernel: as those by matrices, within limits, and past half turns."""

from __future__ import annotations

import numpy as np
import pytest

import freebody as fb
from freebody.inverse.problem.numerical_solver import (
    NumericalSolver,
    descend_by_kernel,
    descent_kernel,
)
from freebody.inverse.problem.task import Task


def by_matrices(solver):
    """The same without a kernel."""
    other = NumericalSolver(solver.model, solver.frame, solver.task, solver.still)
    vars(other)["descent"] = None
    return other


@pytest.mark.parametrize("rows", [(0, 1, 2, 3, 4, 5), (0, 1, 2, 5)])
def test_as_by_matrices(rows):
    """With as many rows as joints and fewer: what is reached, by how many of the starts."""
    model = fb.load("ur5e")
    solver = NumericalSolver(model, model.frame().name, Task(3, rows))
    q, _, _ = fb.random_state(model, 0, 30)
    starts, _, _ = fb.random_state(model, 1, 30)
    T = fb.forward_kinematics(model, q)
    assert solver.descent is not None
    found = []
    for one in (solver, by_matrices(solver)):
        x, left = one.solve(T, starts)
        there = left < 1e-12
        assert (one.miss(x, T)[there] < 1e-10).all()
        assert there.sum() > 10
        found.append(int(there.sum()))
        x, left = one.solve(T, starts, within=True)
        assert ((x >= model.limits.lower) & (x <= model.limits.upper)).all()
    assert abs(found[0] - found[1]) <= 6
    near, left = solver.solve(T, q + 1e-3)
    assert np.abs(near - q).max() < 1e-2
    assert left.max() < 1e-12


def test_half_a_turn_is_not_nothing():
    """There the axis of what is missing is lost, and its length is the longest."""
    arm = fb.planar("RRR", l=[1.0, 0.7, 0.4], lc=[0.3] * 3, m=[1.0] * 3, I=[0.1] * 3)
    solver = NumericalSolver(arm, arm.frame().name, Task(2, (2,)))
    q = np.array([[0.3, 0.4, 0.5]])
    T = fb.forward_kinematics(arm, q)
    T[:, :2, :2] *= -1.0
    _, left = solver.solve(T, q, iterations=1)
    assert left[0] == pytest.approx(2.0, abs=1e-6)
    moved, left = solver.solve(T, q + [[0.1, -0.2, 0.3]], iterations=100)
    assert left[0] < 1e-12
    assert solver.miss(moved, T)[0] < 1e-10


def test_each_start_of_its_own_robot():
    """Numbers for each start: as by the kernel of each member."""
    arm = fb.planar("RRR", l=[1.0, 0.7, 0.4], lc=[0.3] * 3, m=[1.0] * 3, I=[0.1] * 3)
    family = arm.bind(l1=[0.9, 1.0, 1.1])
    columns = [0, 1, 2]
    T = fb.forward_kinematics(arm, np.array([[0.3, 0.8, 0.5]] * 3))
    starts = np.array([[0.4, 0.7, 0.4]] * 3)
    every = descent_kernel(family, arm.frame().name, (0, 1, 2), columns)
    assert every is not None
    found, left = descend_by_kernel(
        every, starts, T, (1.0, 1.0), None, numbers=every.numbers[0].reshape(3, -1)
    )
    assert left.max() < 1e-12
    for k in range(3):
        assert np.abs(fb.forward_kinematics(family[k], found[k]) - T[k]).max() < 1e-12
    assert np.ptp(found[:, 0]) > 1e-2
