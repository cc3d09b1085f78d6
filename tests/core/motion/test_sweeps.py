"""Sweeps: what they reduce is what the public functions give of every point, whichever way the
table is cut."""

from __future__ import annotations

import tracemalloc

import numpy as np
import pytest

import freebody as fb
from support.command import run as run_command

ARM = fb.planar("RR", l=[0.4, 0.3], lc=[0.2, 0.15], m=[2.0, 1.0], I=[0.03, 0.01])
STATES = dict(zip(("q", "qd", "qdd"), fb.random_state(ARM, 3, 150), strict=True))
MASSES, LENGTHS = np.linspace(0.5, 3.0, 4), np.linspace(0.2, 0.6, 3)
OVER = {"m2": MASSES, "l1": LENGTHS, "state": STATES}


WITHIN = 0.5 / 64
"""Relative error of a quantile, by a histogram of 64 bins for each doubling."""


def torques() -> np.ndarray:
    """At every point (4, 3, 150, 2), robot by robot."""
    return np.array(
        [
            [fb.inverse_dynamics(ARM.bind(m2=m, l1=length), **STATES) for length in LENGTHS]
            for m in MASSES
        ]
    )


def test_every_value_is_that_of_the_robot():
    found = fb.sweep(ARM, "inverse_dynamics", over=OVER)
    assert found.tau.dims == ("m2", "l1", "state", "coordinate")
    assert np.allclose(found.tau, torques(), rtol=1e-12, atol=1e-13)
    assert (found.m2.values == MASSES).all()
    assert found.failed.sum() == 0
    two = fb.sweep(ARM, ["inverse_dynamics", "kinetic_energy"], over=OVER)
    assert np.allclose(two.inverse_dynamics_tau, found.tau, rtol=1e-12, atol=1e-13)
    assert two.inverse_dynamics_tau.dims == found.tau.dims
    few = {**OVER, "state": {name: x[:5] for name, x in STATES.items()}}
    assert np.allclose(fb.sweep(ARM, "inverse_dynamics", over=few).tau, torques()[:, :, :5])


def test_reductions_are_those_of_numpy():
    names = ["max", "min", "peak", "mean", "rms", "p0", "p50", "p99.5", "p100"]
    every = torques()
    for along, axes in (("state", (2,)), (("m2", "state"), (0, 2)), (["l1", "m2", "state"], None)):
        found = fb.sweep(ARM, "inverse_dynamics", over=OVER, reduce=names, along=along)
        axis = axes or (0, 1, 2)
        for name, by_numpy in {
            "max": every.max(axis),
            "min": every.min(axis),
            "peak": abs(every).max(axis),
            "mean": every.mean(axis),
            "rms": np.sqrt((every**2).mean(axis)),
        }.items():
            assert np.allclose(found[f"tau_{name}"], by_numpy, rtol=1e-12, atol=1e-13), name
        for share in (0, 50, 99.5, 100):
            exact = np.percentile(every, share, axis, method="inverted_cdf")
            assert np.allclose(found[f"tau_p{share}"], exact, rtol=1.0001 * WITHIN, atol=0)


def test_places_lead_to_the_value():
    every = torques()
    for reduction, key in (("argmax", every), ("argmin", -every), ("argpeak", abs(every))):
        found = fb.sweep(
            ARM, "inverse_dynamics", over=OVER, reduce=reduction, along=["m2", "state"]
        )
        for length in range(3):
            for joint in range(2):
                at = {"l1": length, "coordinate": joint}
                place = found.isel(at)
                m, s = (int(place[f"tau_{reduction}_{axis}"]) for axis in ("m2", "state"))
                assert key[m, length, s, joint] == pytest.approx(key[:, length, :, joint].max())
                assert float(place[f"tau_{reduction}_m2_value"]) == MASSES[m]
                assert (place[f"tau_{reduction}_qd"].values == STATES["qd"][s]).all()


def test_of_equal_values_the_first_is_told():
    """Also where they are in several blocks."""
    names = ["argmax", "argmin", "argpeak"]
    found = fb.sweep(
        ARM, lambda model, q: np.ones(q.shape[:-1]), over={"q": STATES["q"]}, reduce=names, block=7
    )
    assert all(found[f"result_{name}_q"] == 0 for name in names)


def test_ways_to_say_the_same():
    """A formula, a function of Python, and one that is compiled."""
    at = {"qd": [0.1, 0.2], "qdd": [0.0, 0.3]}
    over = {"m2": MASSES, "q": STATES["q"]}
    a = fb.sweep(ARM, "inverse_dynamics", over=over, at=at, reduce="max")
    b = fb.sweep(
        ARM, lambda model, q: {"tau": fb.inverse_dynamics(model, q, *at.values())},
        over=over, reduce="max",
    )  # fmt: skip
    assert np.allclose(a.tau_max, b.tau_max, rtol=1e-13)
    cost = fb.compile(lambda x, y: x * y, {"x": (), "y": ()}, {"cost": ()})
    products = fb.sweep(ARM, cost, over={"x": [1.0, 2.0], "y": [3.0, 4.0]})
    assert products.cost.values.tolist() == [[3.0, 4.0], [6.0, 8.0]]
    motion = fb.default_motion(ARM)
    one = fb.sweep(ARM, "inverse_dynamics", over={"motion": motion}, reduce="peak")
    states = {"q": motion.q, "qd": motion.qd, "qdd": motion.qdd}
    two = fb.sweep(ARM, "inverse_dynamics", over={"state": states}, reduce="peak")
    assert (one.tau_peak == two.tau_peak).all()


def test_what_is_gathered_of_many_short_rows_is_not_held():
    """A histogram of each would be 143 kB."""
    over = {"m2": np.linspace(0.5, 3.0, 1500), "q": STATES["q"][:4]}
    tracemalloc.start()
    fb.sweep(ARM, "gravity_torque", over=over, reduce="p90")
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert most < 1500 * 143e3 / 2


def test_points_without_a_value_are_told_and_left_out():
    over = {"m2": [1.0, -1.0, 2.0], "state": STATES}
    with pytest.warns(fb.FreebodyWarning, match="150 of 450 points have no value"):
        found = fb.sweep(ARM, "inverse_dynamics", over=over, reduce=["max", "mean", "argmax"])
    assert found.failed.values.tolist() == [0, 150, 0]
    assert np.isnan(found.tau_max.values[1]).all()
    assert (found.tau_argmax_state.values[1] == -1).all()
    assert np.isfinite(found.tau_mean.values[[0, 2]]).all()
    assert "at m2 1, state 0" in found.attrs["failures"][0]
    assert "mass -1 kg is negative. Bind" in found.attrs["failures"][0]
    over = {"m2": [1.0, -1.0, -2.0], "state": STATES}
    with pytest.warns(fb.FreebodyWarning):
        told = fb.sweep(ARM, "inverse_dynamics", over=over, reduce="max", block=100).failures
    assert [text.split(" is")[0] for text in told] == [
        f"at m2 {k}, state 0: 'RR': link 'link2': mass -{k} kg" for k in (1, 2)
    ]

    def picky(model: fb.Model, q: np.ndarray) -> np.ndarray:
        if (q > 3.0).any():
            raise fb.FreebodyError("too far")
        return q

    with pytest.warns(fb.FreebodyWarning, match="too far"):
        some = fb.sweep(ARM, picky, over={"q": [0.0, 4.0, 1.0, 2.0, 9.0]}, reduce="max")
    assert int(some.failed) == 2
    assert float(some["picky_max"]) == 2.0


def picky_everywhere(model: fb.Model, q: np.ndarray) -> np.ndarray:
    raise fb.FreebodyError("nowhere")


@pytest.mark.parametrize(
    ("words", "function", "arguments"),
    [
        ("the function needs qd and qdd", "inverse_dynamics", {"over": {"q": STATES["q"]}}),
        ("no parameter 'm9'", "mass_matrix", {"over": {"m9": [1.0], "q": STATES["q"]}}),
        ("no reduction 'most'", "mass_matrix", {"over": {"q": STATES["q"]}, "reduce": "most"}),
        ("no axis 'r'", "mass_matrix", {"over": {"q": STATES["q"]}, "reduce": "max", "along": "r"}),
        ("along= names axes that", "mass_matrix", {"over": {"q": STATES["q"]}, "along": "q"}),
        ("expected", "mass_matrix", {"over": {"q": np.zeros(3)}}),
        ("nan", "mass_matrix", {"over": {"q": [[0.0, np.nan]]}}),
        ("has no value", "mass_matrix", {"over": {"q": np.zeros((0, 2))}}),
        ("two axes", "mass_matrix", {"over": {"a": {"q": STATES["q"]}, "q": STATES["q"]}}),
        ("by over and by at", "mass_matrix", {"over": {"q": STATES["q"]}, "at": {"q": [0, 0]}}),
        ("different lengths", "mass_matrix", {"over": {"a": {"q": [[0, 0]], "m1": [1, 2]}}}),
        ("over is", "mass_matrix", {"over": [STATES["q"]]}),
        ("block is", "mass_matrix", {"over": {"q": STATES["q"]}, "block": 0}),
        ("result's name", "mass_matrix", {"over": {"M": {"q": STATES["q"]}}}),
        ("nowhere", picky_everywhere, {"over": {"q": [1.0, 2.0]}}),
        ("function is", 3, {"over": {"q": [1.0]}}),
        ("batch in front", lambda model, q: q.sum(), {"over": {"q": [1.0, 2.0]}}),
        ("those of a formula", picky_everywhere, {"over": {"q": [1.0]}, "frame": "tip"}),
    ],
)  # fmt: skip
def test_refusals(words, function, arguments):
    with pytest.raises(fb.FreebodyError, match=words):
        fb.sweep(ARM, function, **arguments)


def test_closed_chains_and_families_are_refused():
    with pytest.raises(fb.FreebodyError, match="closed chain"):
        fb.sweep(fb.load("five_bar"), "mass_matrix", over={"q": np.zeros((2, 4))})
    with pytest.raises(fb.FreebodyError, match="family"):
        fb.sweep(ARM.bind(m2=[1.0, 2.0]), "mass_matrix", over={"q": STATES["q"]})


def test_the_command_prints_and_writes_what_the_function_returns(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    asked = "sweep 2R inverse_dynamics --over m2=1:3:3 --over l1=0.2:0.4:2 --states 50 --seed 4"
    assert run_command([*asked.split(), "--reduce", "peak, rms", "--out", "t.csv"]) == 0
    assert "2R: 300 points." in capsys.readouterr().out
    head, *rows = (tmp_path / "t.csv").read_text().splitlines()
    assert head.split(",")[:3] == ["m2", "l1", "tau_peak joint1"]
    arm = fb.load("2R")
    states = dict(zip(("q", "qd", "qdd"), fb.random_state(arm, 4, 50), strict=True))
    over = {"m2": [1.0, 2.0, 3.0], "l1": [0.2, 0.4], "state": states}
    found = fb.sweep(arm, "inverse_dynamics", over=over, reduce=["peak", "rms"])
    table = np.array([[float(x) for x in row.split(",")] for row in rows])
    assert np.allclose(table[:, 2:4], found.tau_peak.values.reshape(6, 2), rtol=1e-5)
    assert np.allclose(table[:, 4:6], found.tau_rms.values.reshape(6, 2), rtol=1e-5)


def test_the_command_spreads_robots_over_ranges(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    asked = "sweep 2R gravity_torque --over m2=1:3 --over l1=0.2:0.4 --samples 8 --over g=9:10:2"
    assert run_command([*asked.split(), "--states", "20", "--seed", "4", "--out", "t.csv"]) == 0
    head, *rows = (tmp_path / "t.csv").read_text().splitlines()
    assert head.split(",")[:3] == ["g", "m2", "l1"]
    arm, designs = fb.load("2R"), fb.samples(8, {"m2": (1, 3), "l1": (0.2, 0.4)}, seed=4)
    q, _, _ = fb.random_state(arm, 4, 20)
    over = {"g": [9.0, 10.0], "design": designs, "q": q}
    found = fb.sweep(arm, "gravity_torque", over=over, reduce="peak")
    table = np.array([[float(x) for x in row.split(",")] for row in rows])
    assert np.allclose(table[8:, 1], designs["m2"], rtol=1e-5)
    assert np.allclose(table[:, 3:5], found.g_peak.values.reshape(16, 2), rtol=1e-5)
    capsys.readouterr()
    for words, wrong in (
        ("has no COUNT", ["--over", "m2=1:3"]),
        ("give --over NAME=LOW:HIGH", ["--samples", "3"]),
        ("no method 'halton'", ["--over", "m2=1:3", "--samples", "3", "--method", "halton"]),
    ):
        assert run_command(["sweep", "2R", "gravity_torque", *wrong]) == 2
        assert words in capsys.readouterr().err


def test_the_command_takes_motions(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert run_command(["plan", "2R", "0, 0; 1.2, 0.5", "--acceleration", "2"]) == 0
    asked = "sweep 2R inverse_dynamics --motion motion.csv --reduce max,argmax --out t.csv"
    assert run_command(asked.split()) == 0
    head, row = (tmp_path / "t.csv").read_text().splitlines()
    assert "tau_argmax_state joint1" in head.split(",")
    arm = fb.load("2R")
    motion = fb.read_motion(arm, "motion.csv")
    found = fb.sweep(arm, "inverse_dynamics", over={"m": motion}, reduce="max")
    assert np.allclose([float(x) for x in row.split(",")[:2]], found.tau_max, rtol=1e-5)


def test_the_command_tells_failures_and_mistakes(capsys):
    assert run_command(["sweep", "2R", "mass_matrix", "--over", "m2=-1:1:2", "--states", "3"]) == 1
    assert "mass -1 kg is negative" in capsys.readouterr().out
    for text in ("m2=1", "m2", "m2=a:2:3", "m2=1:2:0", "=1:2:3", "m2=1:2:3:4"):
        assert run_command(["sweep", "2R", "mass_matrix", "--over", text]) == 2
        assert "NAME=LOW:HIGH:COUNT" in capsys.readouterr().err
    assert run_command(["sweep", "2R", "mass_matrix", "--states", "3", "--motion", "x.csv"]) == 2
    assert "give one of them" in capsys.readouterr().err


@pytest.mark.parametrize("method", ["sobol", "latin-hypercube", "random"])
def test_samples_fill_their_ranges(method):
    ranges = {"m2": (1.0, 3.0), "q": (np.array([-1.0, 0.0]), np.array([1.0, 0.5]))}
    found = fb.samples(256, ranges, method=method, seed=4)
    assert found["m2"].shape == (256,)
    assert found["q"].shape == (256, 2)
    for name, (low, high) in ranges.items():
        assert ((found[name] >= low) & (found[name] <= high)).all()
    assert all((fb.samples(256, ranges, method=method, seed=4)[x] == found[x]).all() for x in found)
    assert (fb.samples(256, ranges, method=method, seed=5)["m2"] != found["m2"]).any()
    parts = np.bincount(((found["m2"] - 1.0) * 128).astype(int), minlength=256)
    assert (parts.max() == 1) == (method != "random")


def test_a_sweep_of_any_length_begins_at_once():
    def stop(told: str, share: float) -> None:
        raise KeyboardInterrupt

    ranges = {name: (-np.ones(2), np.ones(2)) for name in ("q", "qd", "qdd")}
    over = {"m2": MASSES, "state": fb.samples(10**12, ranges, method="random")}
    with pytest.raises(KeyboardInterrupt):
        fb.sweep(ARM, "inverse_dynamics", over=over, reduce="max", progress=stop, block=1000)


def test_a_latin_hypercube_is_made_as_a_whole():
    with pytest.raises(fb.FreebodyError, match="'latin-hypercube' do not fit into memory, and are"):
        fb.samples(10**15, {"m2": (0, 1)}, method="latin-hypercube").at(slice(0, 1))


def test_samples_refuse():
    for words, call in (
        ("no method", lambda: fb.samples(4, {"a": (0, 1)}, method="halton")),
        ("count is", lambda: fb.samples(0, {"a": (0, 1)})),
        ("ranges is", lambda: fb.samples(4, {})),
        ("low <= high", lambda: fb.samples(4, {"a": (1, 0)})),
        ("a pair", lambda: fb.samples(4, {"a": 3})),
    ):
        with pytest.raises(fb.FreebodyError, match=words):
            call()
