"""Consistent rates and accelerations against projections by singular values; single calls, batches,
careful samples."""

from __future__ import annotations

import numpy as np
import pytest

import freebody as fb
from freebody import FreebodyError, LoopError
from support.helpers import close
from support.loop_scales import rate_scale

MECHANISMS = [
    "four_bar",
    "slider_crank",
    "five_bar_rods",
    "double_four_bar",
    "3RRR",
    "bricard",
    "stewart",
]


def _states(name: str, samples: int = 9):
    model = fb.load(name)
    motion = fb.default_motion(model, samples=samples)
    return model, motion.q, motion.qd


@pytest.mark.sample(2)
@pytest.mark.parametrize("name", MECHANISMS)
def test_the_nearest_that_keep_the_loops_closed(name: str):
    """x - given has no part along any motion, over angular rates, and Φ_q x = c."""
    model, q, qd = _states(name)
    given = np.random.default_rng(3).normal(size=qd.shape)
    phi, scale = fb.kernel(model, "constraint_jacobian")(q), rate_scale(model)
    c = fb.kernel(model, "constraint_bias")(q, qd)
    for found, right in (
        (fb.loop_velocity(model, q, given), 0.0 * c),
        (fb.loop_acceleration(model, q, qd, given), c),
    ):
        for J, x, start, r in zip(phi, found, given, right, strict=True):
            A = J * scale
            expected = start / scale + np.linalg.pinv(A, rcond=1e-9) @ (r - J @ start)
            close(x / scale, expected, 1e-11, 1.0 + np.abs(expected).max())


@pytest.mark.sample(4)
@pytest.mark.parametrize("name", MECHANISMS)
def test_a_few_rates_tell_the_others(name: str):
    model, q, qd = _states(name)
    names = fb.mobility(model, q[4]).independent
    index = [model.velocity_names.index(x) for x in names]
    values = {x: qd[:, k] for x, k in zip(names, index, strict=True)}
    close(fb.loop_velocity(model, q, values), qd, 1e-11, 1.0 + np.abs(qd).max())
    # one value too many that agrees with the others, and one that does not
    more = next(k for k in range(model.nv) if k not in index and np.abs(qd[:, k]).max() > 1e-3)
    values[model.velocity_names[more]] = qd[:, more]
    close(fb.loop_velocity(model, q, values), qd, 1e-11, 1.0 + np.abs(qd).max())
    values[model.velocity_names[more]] = qd[:, more] + 0.1 * (np.arange(len(q)) == 4)
    with pytest.raises(LoopError, match="does not allow the values given at sample 4"):
        fb.loop_velocity(model, q, values)
    if len(names) > 1:
        with pytest.raises(FreebodyError, match="free to move"):
            fb.loop_velocity(model, q, {names[0]: 1.0})


@pytest.mark.parametrize("name", MECHANISMS)
def test_single_calls_and_batches_are_one(name: str):
    model, q, qd = _states(name)
    given = np.random.default_rng(4).normal(size=(3, 1, model.nv))
    rates, second = fb.loop_velocity(model, q, given), fb.loop_acceleration(model, q, qd, given)
    assert rates.shape == second.shape == (3, 9, model.nv)
    for k in (0, 5):
        np.testing.assert_array_equal(fb.loop_velocity(model, q[k], given[1, 0]), rates[1, k])
        np.testing.assert_array_equal(
            fb.loop_acceleration(model, q[k], qd[k], given[1, 0]), second[1, k]
        )


@pytest.mark.sample(1)
@pytest.mark.parametrize("name", MECHANISMS)
def test_numbers_of_32_bits_tell_rates_and_forces_too(name: str):
    """What is allowed to be left of equations is measured by their rounding, not by that of 64
    bits."""
    model, q, qd = _states(name, samples=30)
    q, qd = q.astype(np.float32), qd.astype(np.float32)
    x = np.random.default_rng(3).normal(size=qd.shape).astype(np.float32)
    given = {"q": q, "qd": qd, "x": x}
    for quantity in ("loop_velocity", "loop_acceleration", "drive_torques", "loop_multipliers"):
        fine, coarse = (fb.kernel(model, quantity, dtype=d) for d in ("float64", "float32"))
        arrays = [given[a.name] for a in coarse.program.inputs]
        found = coarse(*arrays)
        assert found.dtype == np.float32
        assert np.isfinite(found).all()
        exact = fine(*(_closed_in_64_bits(model, q) if a is q else a for a in arrays))
        size = np.abs(exact).max(axis=-1, keepdims=True)
        off = np.abs(found - exact) / size
        assert np.median(off) < 1e-6
        assert off.max() < 1e-4


def _closed_in_64_bits(model: fb.Model, q: np.ndarray) -> np.ndarray:
    return fb.assemble(model, q.astype(float))


def test_one_careful_sample_among_many():
    """A parallelogram that is almost flat takes the careful way, its neighbours do not."""
    flat = fb.load("four_bar").bind(l1=0.3, l3=0.3, l2=1.0, d=1.0)
    angles = np.array([0.7, 1e-4, 0.9])
    starts = np.stack([angles, -angles, angles], axis=-1)
    q = fb.assemble(flat, starts, free=("coupler_pin", "rocker_pin"))
    expected = np.array([1.0, -1.0, 1.0])
    for given in ({"crank_pin": 1.0}, expected):
        found = fb.loop_velocity(flat, q, given)
        close(found, np.broadcast_to(expected, (3, 3)), 1e-7, 1.0)
    for dtype in ("float64", "float32"):
        quick = fb.kernel(flat, "loop_velocity", dtype=dtype)(q, expected)
        assert np.isnan(quick).any(axis=-1).tolist() == [False, True, False]
    q[1] += 0.01
    with pytest.raises(LoopError, match=r"is open by .* sample 1"):
        fb.loop_velocity(flat, q, expected)


def test_a_joint_that_no_loop_feels_must_be_told():
    """A pendulum on the coupler: its column of Φ_q is zero, whatever the position."""
    numbers = {"l": [0.3, 0.8, 0.6, 0.2], "lc": [0.1] * 4, "m": [1.0] * 4, "I": [0.1] * 4}
    chain = fb.planar("RRRR", **numbers).with_frame("mount", (0.9, 0.0), frame="base")
    model = chain.with_frame("pin", (0.6, 0.0), frame="link3").with_loop(
        "closing", "point", ("mount", "pin")
    )
    q = fb.assemble(model, [1.0, -1.0, -0.8, 0.3])
    crank, pendulum = model.velocity_names[0], model.velocity_names[3]
    with pytest.raises(FreebodyError, match=f"given for {crank} leave .* free to move"):
        fb.loop_velocity(model, q, {crank: 1.0})
    with pytest.raises(FreebodyError, match=r"given for nothing leave .* free to move"):
        fb.loop_velocity(model, q, {})
    found = fb.loop_velocity(model, q, {crank: 1.0, pendulum: 2.0})
    close(fb.kernel(model, "constraint_jacobian")(q) @ found, np.zeros(2), 1e-14, 1.0)
    assert (found[0], found[3]) == (1.0, 2.0)
    close(fb.loop_velocity(model, q, found), found, 1e-14, 1.0)
