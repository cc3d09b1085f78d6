"""All inverse kinematics branches side by side in one kernel: each reaches its target, none is
missing, and what is said to be none is none."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

import freebody as fb
from freebody import FreebodyError
from support.arms import POSES, apart, arm, meeting, skew
from support.exported import passes, require


def planar(word, lengths):
    n = len(word)
    return fb.planar(word, l=lengths, lc=[0.3] * n, m=[1.0] * n, I=[0.1] * n)


def reached(model, found, target):
    """How far forward kinematics takes each valid branch (N, k) from its target; 0 of others."""
    q, valid, _ = found
    T = fb.forward_kinematics(model, np.nan_to_num(q))
    return np.where(valid == 1.0, np.abs(T - target[:, None]).max(axis=(-1, -2)), 0.0)


def own(model, found, q):
    """How far the nearest branch (N,) is from the position that made the target."""
    return np.array(
        [
            min((apart(model, x, q[i]) for x in rows if np.isfinite(x).all()), default=np.inf)
            for i, rows in enumerate(found[0])
        ]
    )


@pytest.mark.sample(1)
@pytest.mark.parametrize("seed", [0, 1, pytest.param(2, marks=pytest.mark.long)])
@pytest.mark.parametrize("kind", POSES)
@pytest.mark.usefixtures("numpy_kernels")
def test_every_branch(kind, seed):
    """Robots that nobody tuned the recipes to, in frames that nobody would choose."""
    make, count = POSES[kind]
    axes = make(np.random.default_rng(seed))
    model = arm(axes, seed)
    k = fb.kernel(model, "inverse_kinematics", target="numpy")
    q, _, _ = fb.random_state(model, seed, 60)
    T = fb.forward_kinematics(model, q)
    held = [q[:, -1] if kind.endswith("last held") else q[:, 0]] if len(axes) == 7 else []
    found = k(T, *held)
    assert found[0].shape == (60, count, len(axes))
    assert reached(model, found, T).max() < 1e-11
    assert (np.isfinite(found[0]).all(axis=-1) == (found[1] == 1.0)).all()
    clear = np.abs(found[2]).min(axis=1) > 1e-6
    assert clear.sum() > 50
    assert own(model, found, q)[clear].max() < 1e-6
    assert ((found[2] > 0) == (found[1] == 1.0))[clear].all()
    if not held:
        careful = fb.inverse_kinematics(model, T[clear], task="pose")
        assert (careful.count == found[1][clear].sum(axis=1)).all()
    else:
        at = 6 if kind.endswith("last held") else 0
        there = found[0][found[1] == 1.0]
        rows = np.broadcast_to(held[0][:, None], found[1].shape)[found[1] == 1.0]
        assert (there[:, at] == rows).all()


@pytest.mark.parametrize("word", ["RR", "RP", "PR", "PP", "RRR", "RRP", "RPR", "PRR", "PPR", "PRP"])
@pytest.mark.usefixtures("numpy_kernels")
def test_planar_words(word):
    model = planar(word, [0.7, 0.6, 0.3][: len(word)])
    rows = {} if len(word) == 3 else {"rows": ("vx", "vy")}
    k = fb.kernel(model, "inverse_kinematics", target="numpy", **rows)
    q, _, _ = fb.random_state(model, 1, 50)
    T = fb.forward_kinematics(model, q)
    found = k(T)
    assert own(model, found, q).max() < 1e-6
    asked = T if len(word) == 3 else T[:, :2, 2]
    careful = fb.inverse_kinematics(model, asked)
    assert (careful.count == found[1].sum(axis=1)).all()


@pytest.mark.parametrize("word", ["RRR", "RRP", "PPP"])
def test_position_and_orientation_alone(word):
    rng = np.random.default_rng(3)
    axes = meeting(2, rng) + skew(word[2], rng) if word[0] == "R" else skew(word, rng)
    model = arm(axes, 4)
    k = fb.kernel(model, "inverse_kinematics", rows=("vx", "vy", "vz"), target="numpy")
    q, _, _ = fb.random_state(model, 2, 40)
    T = fb.forward_kinematics(model, q)
    assert own(model, k(T), q).max() < 1e-6
    if word == "RRR":
        k = fb.kernel(model, "inverse_kinematics", rows=("wx", "wy", "wz"), target="numpy")
        assert own(model, k(T), q).max() < 1e-6


@pytest.mark.sample(1)
@pytest.mark.parametrize("name", ["ur5e", "puma560", "scara", "panda", "iiwa14"])
def test_bundled(name):
    """Compiled, in 64 and 32 bits; the same as the formula over arrays."""
    model = fb.load(name, physical="ignore")
    q, _, _ = fb.random_state(model, 3, 2000)
    T = fb.forward_kinematics(model, q)
    given = [T, q[:, 6]] if name in ("panda", "iiwa14") else [T]
    found = fb.kernel(model, "inverse_kinematics")(*given)
    assert reached(model, found, T)[np.abs(found[2]) > 1e-6].max() < 1e-12
    used = np.delete(found[0], [7], axis=-1) if name == "panda" else found[0]
    moving = q[:, : used.shape[-1]]
    way = np.abs(used - moving[:, None])
    turning = np.array([b.kind.name == "revolute" for b in model.bodies])[: used.shape[-1]]
    way = np.where(turning, np.abs((way + np.pi) % (2 * np.pi) - np.pi), way)
    assert np.nanmin(way.max(axis=-1), axis=1).max() < 1e-5
    rough = fb.kernel(model, "inverse_kinematics", dtype="float32")(*given)
    clear = np.abs(found[2]).min(axis=1) > 1e-2
    assert (rough[1] == found[1])[clear].mean() > 0.999


SINGULAR = {
    "wrist straight": [0.3, -1.0, 0.9, 0.4, 0.0, 0.2],
    "elbow straight": [0.3, -1.0, 0.0, 0.4, 1.0, 0.2],
    "home": [0.0] * 6,
}


@pytest.mark.sample(7)
@pytest.mark.parametrize("name", ["ur5e", "puma560"])
@pytest.mark.parametrize("where", SINGULAR)
@pytest.mark.parametrize("away", [0.0, 1e-12, 1e-9, 1e-7, 1e-4])
def test_at_singular_poses(name, where, away):
    """What is called a branch is one there too, and what is lost is not clear."""
    model = fb.load(name, physical="ignore")
    q = np.array(SINGULAR[where]) + away
    T = fb.forward_kinematics(model, q)[None]
    found = fb.kernel(model, "inverse_kinematics")(T)
    assert reached(model, found, T).max() < 3e-10
    if away < 1e-8 and not (name == "puma560" and where == "elbow straight"):  # not there: a3
        assert np.abs(found[2]).min() < 1e-6
    if np.abs(found[2]).min() > 1e-6:
        assert own(model, found, q[None])[0] < 1e-6


@pytest.mark.parametrize("bend", [1e-3, 1e-5, 1e-7, 1e-8])
def test_nothing_is_lost_where_circles_are_small(bend):
    """An iiwa whose elbow is nearly straight: the shoulder goes round axis 5 in a tiny circle."""
    model = fb.load("iiwa14")
    q, _, _ = fb.random_state(model, 2, 300)
    q[:, 3] = bend
    T = fb.forward_kinematics(model, q)
    found = fb.kernel(model, "inverse_kinematics", target="numpy")(T, q[:, 6])
    if bend > 1e-6:  # below, rounding may lose a branch, which is not clear
        assert (found[1].sum(axis=1) == 8).all()
        assert reached(model, found, T).max() < 1e-13
    assert reached(model, found, T).max() < 3e-10
    assert (np.abs(found[2]).min(axis=1) < 1e-5).all()


def test_what_is_no_target():
    """NaN, reflections, shears, and points beyond the arm: no branch, and no neighbour touched."""
    model = fb.load("ur5e")
    k = fb.kernel(model, "inverse_kinematics")
    good = fb.forward_kinematics(model, [0.3, -1.0, 0.9, 0.4, 0.7, 0.2])
    mirrored = good @ np.diag([1.0, 1.0, -1.0, 1.0])
    sheared = good.copy()
    sheared[0, 1] += 1e-6
    far = good.copy()
    far[0, 3] += 3.0
    nothing = good.copy()
    nothing[2, 2] = np.nan
    q, valid, _ = k(np.stack([good, mirrored, sheared, far, nothing, good]))
    assert (valid[0] == valid[5]).all()
    assert valid[0].sum() == 8
    assert not valid[1:4].any()
    assert np.isnan(q[1:5]).all()
    assert np.isnan(valid[4]).all()


def test_at_the_edge():
    """A 2R at its full reach has one posture, found twice, and none a little farther out."""
    model = planar("RR", [0.7, 0.5])
    k = fb.kernel(model, "inverse_kinematics", rows=("vx", "vy"), target="numpy")
    for reach, there in ((1.2, True), (1.2 + 1e-9, False), (1.2 - 1e-9, True), (0.1, False)):
        T = np.array([[1.0, 0.0, reach * 0.6], [0.0, 1.0, reach * 0.8], [0.0, 0.0, 1.0]])
        _, valid, clear = k(T)
        assert bool(valid.all()) is there
        assert (clear < 1e-6).all()


def test_what_has_none():
    generic = arm(skew("RRRRRR", np.random.default_rng(1)), 1)
    ur = fb.load("ur5e")
    for words, model, options in (
        ("no closed form is known", generic, {}),
        ("no closed form is known", ur, {"rows": ("vx",)}),
        ("can be no inputs", ur, {"inputs": "elbow_joint.a"}),
        ("closed chain", fb.load("five_bar"), {}),
    ):
        with pytest.raises(FreebodyError, match=words):
            fb.kernel(model, "inverse_kinematics", **options)
    # masses move no joint
    k = fb.kernel(ur, "inverse_kinematics", inputs="*.mass", target="numpy")
    T = fb.forward_kinematics(ur, [0.3, -1.0, 0.9, 0.4, 0.7, 0.2])
    assert k(T)[1].sum() == 8


@pytest.mark.sample(1)
@pytest.mark.parametrize(("name", "language"), [("ur5e", "c"), ("panda", "javascript")])
def test_exports(name, language, tmp_path):
    """As C and JavaScript, by their own tests."""
    require(language)
    fb.export(fb.load(name), "inverse_kinematics", tmp_path, language)
    passes(tmp_path, language, "inverse_kinematics")


def test_derivatives_of_branches():
    """Along the redundancy the tip stands still; by the target, the Jacobian undoes what is
    done."""
    panda = fb.load("panda")
    q = np.array([0.1, -0.4, 0.2, -2.0, 0.1, 1.7, 0.8, 0.0])
    T = fb.forward_kinematics(panda, q)
    k = fb.kernel(panda, "inverse_kinematics", by="redundancy", target="numpy")
    branches, valid, _, along, *_ = k(T, 0.8)
    assert valid.any()
    for x, rate, good in zip(branches, along, valid, strict=True):
        if good:
            assert rate[6] == 1.0
            assert np.abs(fb.jacobian(panda, x) @ rate).max() < 1e-9
    ur = fb.load("ur5e")
    T = fb.forward_kinematics(ur, [0.3, -1.0, 0.9, 0.4, 0.7, 0.2])
    k = fb.kernel(ur, "inverse_kinematics", by="target", target="numpy")
    branches, valid, _, slopes, *_ = k(T)
    assert valid.all()
    assert slopes.shape == (8, 6, 16)
    moved = slopes.reshape(8, 6, 4, 4)[:, :, :3, 3]  # by x, y, z of the target
    for x, slope in zip(branches, moved, strict=True):
        assert np.abs(fb.jacobian(ur, x) @ slope - np.eye(6)[:, :3]).max() < 1e-9


@pytest.mark.sample(11)
@pytest.mark.parametrize("seed", range(40))
def test_right_angles_and_axes_that_fall_together(seed):
    """Arms of right angles, many of which have joints that repeat each other: either the recipe
    gives the position that made the target, or it says that this is not clear, or there is none."""
    rng = np.random.default_rng(seed)
    axes, p = [], np.zeros(3)
    for _ in range(6):
        axes.append(("R", np.eye(3)[rng.integers(3)], p.copy()))
        p = p + np.eye(3)[rng.integers(3)] * rng.choice([0.0, 0.0, 1.0, 0.5])
    if seed % 2:
        c = rng.normal(size=3)
        axes[3:] = [("R", np.eye(3)[k], c) for k in (2, 1, 2)]
    model = arm(axes, seed)
    try:
        formula = fb.formula(model, "inverse_kinematics")
    except FreebodyError as refusal:
        assert "no closed form is known" in str(refusal)  # noqa: PT017
        return
    q, _, _ = fb.random_state(model, seed, 20)
    T = fb.forward_kinematics(model, q)
    with np.errstate(all="ignore"):
        found = formula(np.moveaxis(T, 0, -1))
    count = len(found[0])
    x, valid, clearance = (
        np.broadcast_to(np.moveaxis(np.array(part), -1, 0), s)
        for part, s in zip(found, ((20, count, 6), (20, count), (20, count)), strict=True)
    )
    clear = np.abs(clearance).min(axis=1) > 1e-6
    assert reached(model, (x, valid, clearance), T).max() < 3e-10
    assert ((clearance > 0) == (valid == 1.0))[clear].all()
    if clear.any():
        assert own(model, (x, valid, clearance), q)[clear].max() < 1e-5


def test_one_call_as_the_first_as_a_batch():
    """The function's answers are the same whatever was called before, and in a batch: quick ones,
    with and without q0, and those that are looked at."""
    model = fb.load("ur5e")
    q, _, _ = fb.random_state(model, 8, 40)
    q[3], q[4, 4] = 0.0, 0.0
    T = fb.forward_kinematics(model, q)
    for more in ({}, {"q0": q[5]}, {"q0": q[6], "limits": "ignore"}, {"limits": "drop"}):
        whole = fb.inverse_kinematics(model, T, **more)
        for i in range(8):
            first = fb.inverse_kinematics(fb.load("ur5e"), T[i], **more)
            again = fb.inverse_kinematics(model, T[i], **more)
            assert again == first
            assert (whole.q[i][whole.valid[i]] == first.q).all()
            assert (whole.branches[i][whole.valid[i]] == first.branches).all()
            assert (whole.within_limits[i][whole.valid[i]] == first.within_limits).all()
    listed = fb.inverse_kinematics(model, T[0].tolist(), q0=list(q[5]))
    assert listed == fb.inverse_kinematics(model, T[0], q0=q[5])


def test_whole_turns_by_the_kernel():
    """Next to q0, and a turn farther where that leads into the limits, as for one target whose
    candidates are all looked at."""
    limits = [(-4.0, 2.0), (-9.0, 9.0)]
    model = fb.planar("RR", l=[1.0, 0.7], lc=[0.3] * 2, m=[1.0] * 2, I=[0.1] * 2, limits=limits)
    rng = np.random.default_rng(0)
    for q0 in ([-3.9, 8.0], [1.9, -8.0], [0.0, 0.0], [3.0, 0.0]):
        points = fb.forward_kinematics(model, rng.uniform(-3, 3, (30, 2)))[:, :2, 2]
        found = fb.inverse_kinematics(model, points, q0=q0)
        for (low, high), x, near in zip(limits, np.moveaxis(found.q, -1, 0), q0, strict=True):
            for turned in (x - 2 * np.pi, x + 2 * np.pi):
                inside = (turned >= low) & (turned <= high)
                better = inside & ((np.abs(turned - near) < np.abs(x - near) - 1e-9) | (x > high))
                assert not better.any()
                assert not (inside & (x < low)).any()


@pytest.mark.sample(1)
@pytest.mark.parametrize("name", ["panda", "iiwa14"])
def test_redundancy(name):
    """All branches for a position of the joint that is given, one or many; without it, of each
    branch the nearest to q0: no position found by a fine search of that joint is nearer."""
    model = fb.load(name)
    q, _, _ = fb.random_state(model, 4, 12)
    q[:, 7:] = 0.0
    T = fb.forward_kinematics(model, q)
    given = fb.inverse_kinematics(model, T, redundancy=q[:, 6], q0=np.zeros(model.nq))
    assert given.residual[given.valid].max() < 1e-12
    for i in range(12):
        rows = given.q[i][given.valid[i]]
        assert (rows[:, 6] == q[i, 6]).all()
        way = (rows - q[i] + np.pi) % (2 * np.pi) - np.pi
        assert np.abs(way).max(axis=-1).min() < 1e-5
    one = fb.inverse_kinematics(model, T[0], redundancy=q[0, 6], q0=np.zeros(model.nq))
    assert (one.q == given.q[0][given.valid[0]]).all()
    many = fb.inverse_kinematics(model, T[0], redundancy=np.linspace(-1, 1, 7))
    assert many.q.shape[:1] == (7,)
    low, high = model.limits.lower, model.limits.upper
    q0 = np.clip(q + 0.1 * np.sin(np.arange(model.nq)), low, high)
    for i in range(3):
        near = fb.inverse_kinematics(model, T[i], q0=q0[i])
        assert near.within_limits.all()
        far = np.linalg.norm(near.q - q0[i], axis=-1)
        assert (np.diff(far) >= 0).all()
        assert far[0] <= np.linalg.norm(q[i] - q0[i]) + 1e-9
        fine = fb.inverse_kinematics(
            model, T[i], q0=q0[i], redundancy=np.linspace(low[6], high[6], 3000), limits="drop"
        )
        assert far[0] <= np.linalg.norm(fine.q[fine.valid] - q0[i], axis=-1).min() + 1e-9
    outside = fb.inverse_kinematics(model, T[0] + np.diag([0, 0, 1.0], 1) * 2.0, redundancy=0.3)
    assert outside.distance > 0.5


def test_redundancy_refused():
    for words, model, value in (
        ("'ur5e' with frame 'frame6' and this task is none", fb.load("ur5e"), 0.1),
        (
            "do not broadcast together: target \\(3,\\), redundancy \\(2,\\)",
            fb.load("panda"),
            [0, 1],
        ),
        ("redundancy is nan", fb.load("panda"), np.nan),
    ):
        T = np.broadcast_to(fb.forward_kinematics(model, fb.neutral(model)), (3, 4, 4))
        with pytest.raises(FreebodyError, match=words):
            fb.inverse_kinematics(model, T, redundancy=value)


def test_the_nearest():
    """Of a batch, of one, and where there is none."""
    model = fb.load("ur5e")
    q, _, _ = fb.random_state(model, 4, 5)
    T = fb.forward_kinematics(model, q)
    T[4, :3, 3] *= 9
    guess = q + 0.01
    found = fb.inverse_kinematics(model, T, q0=guess[0])
    assert np.abs(found.nearest(guess[0])[0] - q[0]).max() < 1e-9
    assert np.isnan(found.nearest(guess)[4]).all()
    assert np.isfinite(found.nearest(guess)[:4]).all()
    one = fb.inverse_kinematics(model, T[1], q0=guess[1])
    assert np.abs(one.nearest(guess[1]) - q[1]).max() < 1e-9
    assert np.isnan(fb.inverse_kinematics(model, T[4]).nearest(q[0])).all()
    with pytest.raises(FreebodyError, match="q has shape"):
        one.nearest([0.0])


def test_what_is_refused_at_first_is_refused_later():
    """Targets that are no poses, and arguments by names, after good ones have been answered."""
    for name, more in (("ur5e", {}), ("panda", {"redundancy": 0.3})):
        model = fb.load(name)
        good = fb.forward_kinematics(model, fb.random_state(model, 1)[0])
        fb.inverse_kinematics(model, good, **more)
        bad = [good.copy() for _ in range(4)]
        bad[0][3, 3], bad[1][3, 0], bad[2][0, 0], bad[3][0, 3] = 2.0, 1e-5, 3.0, np.nan
        for T in bad:
            for target in (T, np.stack([good, T])):
                with pytest.raises(FreebodyError, match="target"):
                    fb.inverse_kinematics(model, target, **more)
        with pytest.raises(FreebodyError, match="q0"):
            fb.inverse_kinematics(model, good, q0=np.full(model.nq, np.nan), **more)
    named = xr.DataArray([0.1, 0.2], dims="joint", coords={"joint": ["a", "b"]})
    with pytest.raises(FreebodyError, match="read by position"):
        fb.inverse_kinematics(model, np.stack([good] * 2), redundancy=named)
