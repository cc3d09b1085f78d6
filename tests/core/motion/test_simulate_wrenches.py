"""Wrenches that change over the times of a simulation: exact impulses, orders of the methods, the
same for many as for each, and what is refused."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd
import pytest

import freebody as fb
from freebody import FreebodyError, FreebodyWarning

ROD = fb.planar("R", l=[1], lc=[0.5], m=[1], I=[0.75], g=0)  # 1 kg m² about its pin
ARM = fb.planar(
    "RR", l=[0.4, 0.3], lc=[0.2, 0.15], m=[2, 1], I=[0.03, 0.01], drives=[fb.Drive(viscous=0.1)] * 2
)
T = np.linspace(0.0, 0.5, 6)
TABLES = np.random.default_rng(0).normal(size=(4, len(T), 3))
Q = np.array([0.3, 0.4])
LAW = fb.compile(lambda t, q: [-3.0 * x + t for x in q], {"t": (), "q": 2}, {"tau": 2})


def oracle(table: Any, torque: Any = None) -> np.ndarray:
    return fb.simulate(ARM, Q, [0, 0], T, torque, method="DOP853", wrench_tables=table).q.values


@pytest.mark.sample(2)
@pytest.mark.parametrize("method", ["auto", "rk4", "semi-implicit", "implicit", "DOP853", "Radau"])
def test_a_single_sample_gives_its_exact_impulse(method: str):
    """A moment of 3 N m in one row of many: 3 N m times the spacing of the rows, about 1 kg m²."""
    t, pulse = np.linspace(0, 1, 51), np.zeros((51, 3))
    pulse[25, 2] = 3.0
    still = fb.compile(lambda q: [0.0 * q[0]], {"q": 1}, {"tau": 1})
    at_first = (lambda t, q, qd: [1.0 * (t < 0.1)], {"sample_time": 0.35})  # N m, for 0.35 s
    torques = [(None, {}, 0.0), (still, {}, 0.0), (*at_first, 0.35)]
    if method != "implicit":
        torques.append((lambda t, q, qd: 0.0 * q, {}, 0.0))
    for torque, more, impulse in torques:
        given = {"method": method, "wrench_tables": {"tip": pulse}, **more}
        found = fb.simulate(ROD, [0.0], [0.0], t, torque, **given)
        assert found.qd.values[-1, 0] == pytest.approx(3.0 * 0.02 + impulse, rel=1e-9)
        acceleration = found.qdd.values[:, 0] - found.tau.values[:, 0]
        np.testing.assert_allclose(acceleration, pulse[:, 2], atol=1e-9)


@pytest.mark.sample(1)
@pytest.mark.parametrize(("method", "order"), [("rk4", 4), ("semi-implicit", 1), ("implicit", 2)])
def test_orders(method: str, order: int):
    for torque in (None, LAW):
        expected, errors = oracle(TABLES[0], torque), []
        for step in (0.01, 0.005):
            found = fb.simulate(
                ARM, Q, [0, 0], T, torque, method=method, step=step, wrench_tables=TABLES[0]
            )
            errors.append(np.abs(found.q.values - expected).max())
        assert np.log2(errors[0] / errors[1]) == pytest.approx(order, abs=0.5)


def test_many_motions_are_those_of_each():
    constant = {ARM.frame_names[1]: [0.0, 0.3, 0.0]}
    for method in ("auto", "DOP853"):
        found = fb.simulate(
            ARM, Q, [0, 0], T, wrenches=constant, method=method, wrench_tables=TABLES
        )
        assert found.q.dims == ("sample", "time", "position")
        for k in (0, 3):
            alone = fb.simulate(ARM, Q, [0, 0], T, wrenches=constant, wrench_tables=TABLES[k])
            for name in ("q", "qd", "qdd"):
                np.testing.assert_allclose(found[name][k], alone[name], atol=1e-8)
    states = Q + np.arange(4)[:, None]
    each = np.broadcast_to(TABLES[0], TABLES.shape)
    same, other = (
        fb.simulate(ARM, states, [0, 0], T, method="rk4", wrench_tables=w)
        for w in (TABLES[0], each)
    )
    np.testing.assert_array_equal(same.q, other.q)
    np.testing.assert_allclose(same.qdd, other.qdd, rtol=1e-13)


def test_a_table_of_equal_rows_is_a_constant_wrench():
    w = np.array([0.5, -1.0, 0.2])
    for options in ({}, {"friction": "dry"}, {"method": "rk4"}, {"method": "implicit"}):
        constant = fb.simulate(ARM, Q, [0, 0], T, wrenches=w, **options)
        table = fb.simulate(ARM, Q, [0, 0], T, wrench_tables=np.tile(w, (6, 1)), **options)
        np.testing.assert_allclose(table.q, constant.q, atol=1e-9)
        np.testing.assert_allclose(table.qdd, constant.qdd, atol=1e-8)


def test_dry_friction_meets_the_wrench_of_the_time():
    """A rod sticks until the moment, which grows by 1 N m/s, exceeds 0.3 N m."""
    rod = ROD.with_drive(ROD.joint_names[0], coulomb=0.3)
    t, table = np.linspace(0, 0.6, 4), np.zeros((4, 3))
    table[:, 2] = t
    for torque in (None, lambda t, q, qd: 0.0 * q):
        found = fb.simulate(rod, [0], [0], t, torque, friction="dry", wrench_tables=table)
        np.testing.assert_allclose(
            found.qd.values[:, 0], [0, 0, 0.5 * 0.1**2, 0.5 * 0.3**2], atol=1e-6
        )
        np.testing.assert_allclose(found.qdd.values[:, 0], [0, 0, 0.1, 0.3], atol=1e-9)


def test_a_closed_chain():
    model = fb.load("five_bar")
    q, qd = fb.assemble(model), np.zeros(model.nv)
    table = {"P": TABLES[0] * [1, 1, 0.1]}
    t = T / 5
    exact = fb.simulate(model, q, qd, t, wrench_tables=table)
    steps = fb.simulate(model, q, qd, t, method="rk4", step=1e-3, wrench_tables=table)
    np.testing.assert_allclose(steps.q, exact.q, atol=1e-7)
    without = fb.simulate(model, q, qd, t)
    assert np.abs(without.q - exact.q).max() > 1e-4


def test_entries_by_name_are_put_in_order_and_frames_are_named():
    names = ["fx", "fy", "m"]
    turned = pd.DataFrame(TABLES[0], index=pd.Index(T, name="t"), columns=names)[names[::-1]]
    plain = oracle(TABLES[0])
    for given in (turned, {"tip": turned}):
        np.testing.assert_array_equal(oracle(given), plain)
    assert np.abs(oracle({ARM.frame_names[1]: turned}) - plain).max() > 1e-3


def test_what_is_refused_and_told():
    rows = TABLES[0]
    labelled = pd.DataFrame(rows, index=pd.Index(2 * T, name="t"))
    cases = [
        ({"wrench_tables": rows[:5]}, r"wrench_tables\['tip'\] has shape \(5, 3\), .* 6 times"),
        ({"wrench_tables": rows[0]}, r"has shape \(3,\), .* is given as wrenches="),
        ({"wrench_tables": rows, "wrenches": rows[0]}, "both have frame 'tip'"),
        ({"wrench_tables": labelled}, "labelled with other times than t: row 5 with 1,"),
        ({"wrench_tables": np.where(rows < 0, np.nan, rows)}, r"wrench_tables\['tip'\].*nan"),
    ]
    for options, words in cases:
        with pytest.raises(FreebodyError, match=words):
            fb.simulate(ARM, Q, [0, 0], T, **options)
    with pytest.warns(FreebodyWarning, match="for each of 6 motions; .* wrench_tables="):
        fb.simulate(ARM, Q, [0, 0], T, wrenches=rows, step=0.1)
