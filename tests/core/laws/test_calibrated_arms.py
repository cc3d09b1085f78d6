"""Inverse kinematics of arms that are nearly one with a closed form, and of families."""

from __future__ import annotations

import numpy as np
import pytest

import freebody as fb
from support.arms import apart


def calibrated(name, shape, size, seed):
    """A robot whose DH entries are all off by about `size` (m, rad)."""
    model, rng = fb.load(name, physical="ignore"), np.random.default_rng(seed)
    known = fb.parameters(model)
    lengths = [r.name for r in known if r.name.rsplit(".", 1)[-1] in ("a", "d", "alpha", "theta")]
    return model.bind({n: known[n].value + size * rng.normal(size=shape)[()] for n in lengths})


@pytest.mark.sample(1)
@pytest.mark.parametrize("name", ["ur5e", "puma560"])
def test_one_arm(name):
    """Each branch reaches its target, the position that made the target is among them, and a search
    from many starts finds nothing more."""
    model = calibrated(name, (), 1e-3, 1)
    q, _, _ = fb.random_state(model, 1, 30)
    T = fb.forward_kinematics(model, q)
    found = fb.inverse_kinematics(model, T)
    assert "of the arm nearby" in found.method
    assert "nearly one with a closed form" in found.notes[0]
    miss = np.abs(
        fb.forward_kinematics(model, found.q[found.valid]) - T.repeat(found.count, axis=0)
    )
    assert miss.max() < 1e-10
    for i in range(30):
        assert min(apart(model, x, q[i]) for x in found.q[i][found.valid[i]]) < 1e-6
    searched = fb.inverse_kinematics(model, T[:6], starts=96)
    assert searched.method.startswith("Levenberg–Marquardt from 96 starts")
    for i in range(6):
        for x in searched.q[i][searched.valid[i]]:
            assert min(apart(model, x, y) for y in found.q[i][found.valid[i]]) < 1e-6


def test_a_family_has_what_its_members_have():
    """Side by side and one by one: solutions, names, distances of what is out of reach."""
    family = calibrated("ur5e", (3, 2), 1e-3, 2)
    q, _, _ = fb.random_state(fb.load("ur5e"), 3, 6)
    q[:, [2, 4]] = np.clip(np.abs(q[:, [2, 4]]), 0.6, 2.4)  # bent at elbow and wrist
    T = fb.forward_kinematics(fb.load("ur5e"), q)
    T[5, :3, 3] *= 4
    found = fb.inverse_kinematics(family, T[:, None, None])
    assert found.q.shape[:3] == (6, 3, 2)
    assert "of the arm nearby" in found.method
    assert (found.count[:5] > 0).all()
    assert not found.count[5].any()
    assert "6 of 36 have no solution, see distance." in found.notes
    for index in ((0, 0), (2, 1)):
        one = fb.inverse_kinematics(family[index], T)
        assert np.allclose(found.distance[(slice(None), *index)], one.distance, atol=1e-5)
        for i in range(6):
            mine, own = found.valid[(i, *index)], one.valid[i]
            assert mine.sum() == own.sum()
            names = found.branches[(i, *index)][mine]
            for x, name in zip(one.q[i][own], one.branches[i][own], strict=True):
                near = [apart(fb.load("ur5e"), x, y) < 1e-6 for y in found.q[(i, *index)][mine]]
                assert names[near].tolist() == [name]


def test_other_families():
    """In the plane, with limits of their own, and with lengths that differ much: one by one."""
    arm = fb.load("2R")
    longer = arm.bind(l1=np.array([0.5, 1.0, 1.5]))
    points = np.array([[0.9, 0.4], [1.2, 0.3]])
    found = fb.inverse_kinematics(longer, points[:, None])
    T = fb.forward_kinematics(longer, np.nan_to_num(np.moveaxis(found.q, 2, 0)))
    there = np.moveaxis(found.valid, 2, 0)
    target = np.broadcast_to(points[:, None], (2, 3, 2))
    assert np.abs(T[..., :2, 2] - target)[there].max() < 1e-10
    for k in range(3):
        one = fb.inverse_kinematics(longer[k], points)
        assert (found.count[:, k] == one.count).all()
        assert np.allclose(found.distance[:, k], one.distance)
    ur = fb.load("ur5e")
    T = fb.forward_kinematics(ur, np.full(6, 0.4))
    limited = ur.bind({"elbow_joint.limits.upper": [0.1, 3.0]})
    within = fb.inverse_kinematics(limited, T).within_limits
    assert within[0].sum() < within[1].sum()
    with pytest.raises(fb.FreebodyError, match=r"target \(3,\), model.family \(2,\)"):
        fb.inverse_kinematics(limited, np.stack([T] * 3))
    with pytest.raises(fb.FreebodyError, match="redundancy=: 'ur5e' is a family"):
        fb.inverse_kinematics(limited, T, redundancy=0.1)
    empty = fb.inverse_kinematics(limited, np.zeros((0, 1, 4, 4)))
    assert empty.q.shape == (0, 2, 0, 6)
