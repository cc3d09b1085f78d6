"""What a simulation is given as torque acts as given: tables row by row, jumps where said,
controllers held."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from scipy.integrate import solve_ivp

import freebody as fb
from freebody import FreebodyError

ROD = fb.planar("R", l=[1], lc=[0.5], m=[1], I=[0.75], g=0)  # 1 kg m² about its pin


def on_table(model: fb.Model, q: np.ndarray, t: np.ndarray, table: np.ndarray) -> np.ndarray:
    """Oracle: (q, q̇) at the end, from forward dynamics, knot by knot as tightly as floats
    allow."""
    y, n = np.concatenate([q, np.zeros(model.nv)]), model.nq
    for a, b, first, last in zip(t[:-1], t[1:], table[:-1], table[1:], strict=True):

        def rate(now: float, y: np.ndarray, a=a, b=b, first=first, last=last) -> np.ndarray:
            tau = first + (now - a) / (b - a) * (last - first)
            return np.concatenate([y[n:], fb.forward_dynamics(model, y[:n], y[n:], tau)])

        y = solve_ivp(rate, (a, b), y, method="DOP853", rtol=3e-14, atol=1e-15).y[:, -1]
    return y


def test_one_sample_of_a_torque_table_is_not_stepped_over():
    """50 N m at one of 201 times over 2 s: straight lines to its neighbours hold 0.5 N m s, on 1 kg
    m²."""
    t = np.linspace(0, 2, 201)
    for row in (0, 1, 37, 100, 199):
        table = np.zeros((201, 1))
        table[row] = 50.0
        share = 0.5 if row == 0 else 1.0
        found = fb.simulate(ROD, [0], [0], t, table)
        assert found["qd"].values[-1, 0] == pytest.approx(0.5 * share, rel=1e-12)
        np.testing.assert_array_equal(found["tau"].values, table)


def test_one_sample_of_a_torque_table_is_not_stepped_over_in_a_closed_chain():
    """A strut keeps the elbow at its angle: both links turn as one body."""
    arm = fb.planar("RR", l=[1, 1], lc=[0.5, 0.5], m=[1, 1], I=[0.75, 0.75], g=0)
    model = arm.with_loop("strut", "distance", ("base", "tip"), distance=2 * np.sin(0.5))
    start = fb.assemble(model, [0.3, np.pi - 1.0], free=["joint2"])
    inertia = fb.mass_matrix(arm, start)[0, 0]
    t, table = np.linspace(0, 2, 201), np.zeros((201, 2))
    table[37, 0] = 50.0
    found = fb.simulate(model, start, [0, 0], t, table)
    assert found["qd"].values[-1, 0] == pytest.approx(0.5 / inertia, rel=1e-9)


@pytest.mark.sample(1)
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_a_random_table_lands_within_ten_times_the_tolerance(seed: int):
    model, t = fb.load("ur5e"), np.linspace(0, 1, 21)
    rng = np.random.default_rng(seed)
    q = rng.uniform(-2, 2, 6)
    table = fb.gravity_torque(model, q) + rng.normal(size=(21, 6)) * [15, 15, 10, 0.5, 0.5, 0.05]
    exact = on_table(model, q, t, table)
    for tolerance in (1e-4, 1e-7, 1e-10):
        found = fb.simulate(model, q, np.zeros(6), t, table, tolerance=tolerance)
        off = np.concatenate([found["q"].values[-1], found["qd"].values[-1]]) - exact
        assert np.abs(off).max() < 10 * tolerance * np.abs(exact).max()


def test_jumps_of_a_function_at_its_breakpoints():
    """A pulse of 1 ms in 10 s, by either convention of what the value at a jump is, is seen only
    where it is said."""
    for pulse in (lambda t: 4.001 <= t < 4.002, lambda t: 4.001 < t <= 4.002):
        torque = lambda t, q, qd, pulse=pulse: [500.0 * pulse(t)]
        assert (
            fb.simulate(ROD, [0], [0], [0, 10], torque)["qd"].values[-1, 0] == 0.0
        )  # what breakpoints are for
        found = fb.simulate(ROD, [0], [0], [0, 10], torque, breakpoints=[4.002, 4.001, 30.0])
        assert found["qd"].values[-1, 0] == pytest.approx(0.5, rel=1e-10)
        fine = fb.simulate(ROD, [0], [0], [3.9, 4.1], torque, max_step=5e-4, tolerance=1e-6)
        assert fine["qd"].values[-1, 0] == pytest.approx(0.5, rel=1e-3)


@pytest.mark.parametrize("options", [{"step": 0.01}, {"sample_time": 0.05}])
@pytest.mark.parametrize("count", [1, 2])
def test_a_function_may_work_in_place(options: dict[str, float], count: int):
    """What it does to its arguments is not done to the motion."""

    def in_place(t: float, q: np.ndarray, qd: np.ndarray) -> np.ndarray:
        q -= 0.1
        q *= -30.0
        return q

    t, start = np.linspace(0.0, 0.2, 3), np.full((count, 1), 0.3)[0 if count == 1 else ...]
    found = fb.simulate(ROD, start, 0.0 * start, t, in_place, **options)
    right = fb.simulate(ROD, start, 0.0 * start, t, lambda t, q, qd: -30.0 * (q - 0.1), **options)
    np.testing.assert_allclose(found.q.values, right.q.values, rtol=1e-9)


def test_a_sampled_controller_is_called_at_its_instants_and_held():
    """PD on a double integrator, exactly discretised: x' = x + v h + u h²/2, v' = v + u h."""
    calls = []

    def controller(t: float, q: np.ndarray, qd: np.ndarray) -> np.ndarray:
        calls.append(t)
        return -40.0 * q - 9.0 * qd

    h = 0.05
    t = np.linspace(0, 1.0, 41)
    found = fb.simulate(ROD, [1.0], [0.0], t, controller, sample_time=h)
    x, v, exact, torques = 1.0, 0.0, [1.0], []
    for _ in range(20):
        u = -40.0 * x - 9.0 * v
        torques += [u, u]
        x, v = x + v * h + 0.5 * u * h**2, v + u * h
        exact.append(x)
    np.testing.assert_allclose(calls, h * np.arange(20), atol=1e-15)
    np.testing.assert_allclose(found["q"].values[::2, 0], exact, atol=1e-11)
    np.testing.assert_allclose(found["tau"].values[:-1, 0], torques, atol=1e-9)
    assert found["tau"].values[-1, 0] == found["tau"].values[-2, 0]


def test_a_function_may_return_the_same_array_again():
    buffer = np.zeros(1)

    def controller(t: float, q: np.ndarray, qd: np.ndarray) -> np.ndarray:
        buffer[:] = t
        return buffer

    found = fb.simulate(ROD, [0], [0], [0, 0.5, 1.0], controller, sample_time=0.5)
    np.testing.assert_array_equal(found["tau"].values[:, 0], [0.0, 0.5, 0.5])


@pytest.mark.parametrize(
    ("torque", "options", "problem"),
    [
        (
            None,
            {"sample_time": 0.1},
            r"simulate: sample_time= applies only to a torque that is a function",
        ),
        (
            [0.0],
            {"breakpoints": [0.5]},
            r"simulate: breakpoints= applies only to a torque that is a function",
        ),
        ("f", {"sample_time": 0.0}, r"simulate: sample_time is 0, expected a number of seconds"),
        (
            "f",
            {"sample_time": 1e-9},
            r"sample_time is 1e-09 s, 1e\+09 instants in this run; 1000000 are the most",
        ),
        ("f", {"sample_time": 0.1, "breakpoints": [0.5]}, r"exclude each other; give one of them"),
        ("f", {"breakpoints": 0.5}, r"breakpoints has shape \(\), expected a list of times"),
        ("f", {"breakpoints": [np.nan]}, r"breakpoints is nan"),
        ("f", {"max_step": 0.0}, r"simulate: max_step is 0, expected a number of seconds"),
    ],
)
def test_options_that_mean_nothing_are_refused(torque, options, problem):
    given = (lambda t, q, qd: [0.0]) if torque == "f" else torque
    with pytest.raises(FreebodyError, match=problem):
        fb.simulate(ROD, [0], [0], [0, 1], given, **options)


def test_a_table_whose_rows_carry_other_times_is_refused():
    t = np.linspace(0, 1, 11)
    table = np.sin(3 * t)[:, None]
    plain = fb.simulate(ROD, [0], [0], t, table)

    def kinds(times: np.ndarray) -> dict[str, object]:
        frame = pd.DataFrame(table, columns=["joint1"], index=times)
        array = xr.DataArray(
            table, {"time": times, "coordinate": ["joint1"]}, ("time", "coordinate")
        )
        return {
            "frame": frame,
            "index of durations": frame.set_index(pd.to_timedelta(times, "s")),
            "array": array,
            "array, transposed": array.T,
            "dict of series": {"joint1": frame["joint1"]},
            "dataset": xr.Dataset({"joint1": array[:, 0].drop_vars("coordinate")}),
        }

    for name, given in kinds(t).items():
        np.testing.assert_array_equal(fb.simulate(ROD, [0], [0], t, given)["qd"], plain["qd"], name)
    for name, given in kinds(2 * t).items():
        with pytest.raises(
            FreebodyError,
            match=r"labelled with other times than t: row 10 with 2, where t\[10\] = 1 s",
        ):
            assert fb.simulate(ROD, [0], [0], t, given) is name
    rows = pd.DataFrame(
        table, columns=["joint1"], index=range(40, 51)
    )  # cut out of a longer one: no times
    np.testing.assert_array_equal(fb.simulate(ROD, [0], [0], t, rows)["qd"], plain["qd"])
    np.testing.assert_array_equal(fb.simulate(ROD, [0], [0], t, plain["tau"])["qd"], plain["qd"])
