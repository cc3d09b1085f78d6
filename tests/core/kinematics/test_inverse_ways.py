"""The ways of inverse kinematics one by one, against each other: closed forms and searches, kernels
and what is computed one target at a time.

The public function takes the way that is best and has no option for another, so ways are taken out
of its reach here.
"""

from __future__ import annotations

import numpy as np
import pytest

import freebody as fb
from freebody.algorithms.closed_form_inverse.quartic import zeros
from freebody.inverse import inverse_kinematics as module
from freebody.inverse.problem.numerical_solver import (
    NumericalSolver,
    descend_by_kernel,
    descent_kernel,
)
from freebody.inverse.problem.task import Task
from freebody.inverse.ways import by_closed_form
from support.arms import (
    POSES,
    apart,
    arm,
    checked,
    holds,
    meeting,
    parallel,
    puma_like,
    skew,
)


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


def test_zeros_of_degree_two():
    """As many as the polynomial changes sign, none of them far off, double ones too."""
    rng = np.random.default_rng(0)
    a0, a1, b1, a2, b2 = a = rng.normal(size=(5, 3000))
    a[3:, :500] *= 1e-4
    a[1, 500:700] = 0.0

    def value(x):
        return a0 + a1 * np.cos(x) + b1 * np.sin(x) + a2 * np.cos(2 * x) + b2 * np.sin(2 * x)

    found = zeros(tuple(value(2 * np.pi * k / 5) for k in range(5)))
    grid = np.linspace(-np.pi, np.pi, 4000, endpoint=False)[:, None]
    changes = (np.sign(value(grid)) != np.sign(value(np.roll(grid, 1)))).sum(axis=0)
    clear = np.array([c for _, _, c in found])
    sure = (np.abs(clear) > 1e-5).all(axis=0)
    assert sure.sum() > 2900
    assert ((clear > 0).sum(axis=0) == changes)[sure].all()
    for sine, cosine, c in found:
        assert np.abs(value(np.arctan2(sine, cosine)))[(c > 0) & sure].max() < 1e-13
    # (1 - cos(x - 1)) (2 - cos x) touches 0 at 1
    twice = [(1 - np.cos(x - 1.0)) * (2.0 - np.cos(x)) for x in 2 * np.pi * np.arange(5) / 5]
    angles = [np.arctan2(s, c) for s, c, clear in zeros(tuple(twice)) if clear > -1e-9]
    assert len(angles) == 2
    assert np.allclose(angles, 1.0, atol=1e-6)


@pytest.mark.sample(1)
@pytest.mark.parametrize("kind", ["an industrial arm", "like a UR, backwards", "a SCARA"])
@pytest.mark.usefixtures("numpy_kernels")
def test_many_targets_as_few(kind, monkeypatch):
    """The kernel says what is said where every candidate is looked at: singular poses, targets out
    of reach and beyond limits among them."""
    model, again = (arm(POSES[kind][0](np.random.default_rng(7)), 7) for _ in range(2))
    q, _, _ = fb.random_state(model, 5, 100)
    q[:9] *= 0.0  # as singular as it gets
    T = fb.forward_kinematics(model, q)
    T[10:14, :3, 3] += 30.0
    many = fb.inverse_kinematics(model, T, q0=q[40])
    assert many.residual[np.isfinite(many.residual)].max() < 1e-12
    monkeypatch.setattr(by_closed_form, "branch_kernel", lambda *_: None)
    few = fb.inverse_kinematics(again, T, q0=q[40])
    assert (many.count == few.count).all()
    assert (many.valid.sum(axis=-1) == many.count).all()
    assert not many.count[10:14].any()
    assert np.allclose(many.distance, few.distance)
    assert (many.distance[10:14] > 20).all()
    assert many.method == few.method
    assert many.notes == few.notes
    for i, row in enumerate(many.q):
        for x, name in zip(row[many.valid[i]], many.branches[i][many.valid[i]], strict=True):
            same = [apart(model, x, other) < 1e-6 for other in few.q[i][few.valid[i]]]
            assert sum(same) == 1
            assert few.branches[i][few.valid[i]][same] == [name]


def test_many_positions_of_a_robot_with_more(monkeypatch):
    """Joints that do not move the target stay where they were asked to stay."""
    model, again = fb.load("ur5e"), fb.load("ur5e")
    q, _, _ = fb.random_state(model, 5, 50)
    p = fb.forward_kinematics(model, q, frame="wrist_1_link")[:, :3, 3]
    q0 = np.full(6, 0.5)
    many = fb.inverse_kinematics(model, p, frame="wrist_1_link", q0=q0)
    assert many.method.startswith("closed form")
    assert (many.q[many.valid][:, 3:] == 0.5).all()
    monkeypatch.setattr(by_closed_form, "branch_kernel", lambda *_: None)
    few = fb.inverse_kinematics(again, p, frame="wrist_1_link", q0=q0)
    assert (many.count == few.count).all()
    assert many.notes == few.notes


GENERAL = {
    **{
        f"{word} and a wrist": lambda rng, w=word: skew(w, rng) + meeting(3, rng)
        for word in ("RRR", "RRP", "PRP")
    },
    "a shoulder and RRR": lambda rng: meeting(3, rng) + skew("RRR", rng),
    "Puma-like": puma_like,
    "UR-like": lambda rng: skew("R", rng) + parallel(3, rng) + meeting(2, rng),
    "UR-like, backwards": lambda rng: (skew("R", rng) + parallel(3, rng) + meeting(2, rng))[::-1],
    **{
        f"position by {word}": lambda rng, w=word: skew(w, rng)
        for word in ("RRR", "RRP", "RPR", "PRR", "RPP", "PPP")
    },
}


@pytest.mark.sample(1)
@pytest.mark.usefixtures("numpy_kernels")
@pytest.mark.parametrize("kind", GENERAL)
@pytest.mark.parametrize("seed", range(3))
def test_general_geometry(kind, seed, monkeypatch):
    """Any axes, base, link frames and tool: in closed form, and a search from many starts finds
    nothing more."""
    axes = GENERAL[kind](np.random.default_rng(seed))
    model = arm(axes, seed)
    q, _, _ = fb.random_state(model, seed)
    T = fb.forward_kinematics(model, q)
    task = "pose" if len(axes) == 6 else "position"
    found = checked(model, T, task=task)
    assert found.method.startswith("closed form")
    assert holds(model, found.q, q)
    monkeypatch.setattr(module, "_form", lambda _: None)
    searched = checked(model, T, task=task, starts=100)
    assert all(holds(model, found.q, other, 1e-5) for other in searched.q)


@pytest.mark.usefixtures("numpy_kernels")
def test_a_pose_by_three_joints_above_the_first(monkeypatch):
    """There the position leaves joint 1 where it is, and the orientation alone tells where that
    has to be; where nothing can stand anywhere, what is not found is not sought from many starts.
    """
    half = np.pi / 2
    rows = [{"d": 0.4, "alpha": half}, {"a": 0.5}, {"a": 0.5}]
    model = fb.dh(
        [{"m": 1.0, "com": [0, 0, 0], "I": [0] * 6, **row} for row in rows], convention="standard"
    )
    q = np.array([0.7, np.pi / 3, np.pi / 3])
    T = fb.forward_kinematics(model, q)
    assert np.abs(T[:2, 3]).max() < 1e-15
    found = checked(model, T)
    assert holds(model, found.q, q)
    q[1] = 0.4
    T = fb.forward_kinematics(model, q)
    T[2, 3] += 0.05
    monkeypatch.setattr(by_closed_form, "by_search", None)
    assert len(fb.inverse_kinematics(model, T)) == 0


@pytest.mark.usefixtures("numpy_kernels")
def test_few_doubtful_targets_are_looked_at_without_the_others(monkeypatch: pytest.MonkeyPatch):
    """One of a hundred sent them all the careful way; what is said is the same."""
    model = fb.load("ur5e")
    q, _, _ = fb.random_state(model, 7, 60)
    T = fb.forward_kinematics(model, q)
    aligned = q[:3].copy()
    aligned[:, 4] = 0.0, 1e-7, -1e-4  # two axes of the wrist in line, or nearly
    T[[4, 17, 59]] = fb.forward_kinematics(model, aligned)
    T[[8, 30], :3, 3] *= 50.0  # out of reach
    fresh = fb.inverse_kinematics(fb.load("ur5e"), T)  # all of them the careful way
    fb.inverse_kinematics(model, T[:2])
    seen, closer = [], by_closed_form.by_closed_form
    monkeypatch.setattr(
        "freebody.inverse.inverse_kinematics.by_closed_form",
        lambda problem, form: seen.append(len(problem.target)) or closer(problem, form),
    )
    found = fb.inverse_kinematics(model, T.reshape(6, 10, 4, 4))
    assert seen == [4]  # 1e-4 is clear
    assert found.q.shape == (6, 10, *fresh.q.shape[1:])
    for name in ("q", "residual", "within_limits", "distance", "valid", "branches", "count"):
        one, other = getattr(found, name), getattr(fresh, name)
        np.testing.assert_array_equal(one.reshape(other.shape), other, err_msg=name)
    assert found.notes == fresh.notes
    assert any(note.startswith("Target 8: ") for note in found.notes)
    assert (found.distance.ravel()[[8, 30]] > 1.0).all()
    bad = T.copy()
    bad[5, 0, 0] = np.nan
    with pytest.raises(fb.FreebodyError, match=r"target is nan at sample 5 at component \(0, 0\)"):
        fb.inverse_kinematics(model, bad)
    bad[5] = 2.0 * T[5]
    with pytest.raises(fb.FreebodyError, match="target is not a pose"):
        fb.inverse_kinematics(model, bad)
