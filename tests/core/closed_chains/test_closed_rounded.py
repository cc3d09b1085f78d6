"""Machines as files describe them: redundant, with numbers rounded. They move as the machine that
is meant."""

from __future__ import annotations

import re
from functools import lru_cache
from importlib.resources import files
from pathlib import Path

import numpy as np
import pytest

import freebody as fb
from freebody import LoopError, Model
from support.helpers import close
from support.linkages import four_bar_text
from support.robots import loaded

DIGITS = (9, 6, 4)
TURN = {
    "exact": f"{np.pi / 2!r}",
    "1.570796327": "1.570796327",
    "1.5708": "1.5708",
    "1.571": "1.571",
}


# ---------------------------------------------------------------- three cranks
LENGTH = np.sqrt(2.0) / 3.0
AT = (0.0, 0.4 / np.sqrt(3.0), np.sqrt(2.0) / 2.0)  # along the ground, and along the rod
SLOPE = 0.4


@lru_cache(maxsize=8)
def three_cranks(digits: int | None) -> Model:
    """Three parallel cranks of one length on one rod, on sloping ground: one motion, one equation
    too many."""

    def r(x: float) -> float:
        return float(x) if digits is None else round(float(x), digits)

    ground = [(r(s * np.cos(SLOPE)), r(s * np.sin(SLOPE))) for s in AT]
    links = [("crank1", 1.0), ("rod", 2.0), ("crank2", 1.1), ("crank3", 0.9)]
    text = ['name = "three_cranks"', "dim = 2", '[[link]]\nname = "ground"']
    text += [
        f'[[link]]\nname = "{name}"\nmass = {mass}\ncom = [0.2, 0.0]\n'
        f"shape = {{ bar = {{ length = 0.4 }} }}"
        for name, mass in links
    ]
    text += [
        f'[[joint]]\nname = "{name}"\nkind = "revolute"\nparent = "{parent}"\nchild = "{child}"\n'
        f"origin = [{x!r}, {y!r}]" + ("\npassive = true" if passive else "")
        for name, parent, child, (x, y), passive in (
            ("O1", "ground", "crank1", ground[0], False),
            ("A1", "crank1", "rod", (r(LENGTH), 0.0), True),
            ("O2", "ground", "crank2", ground[1], True),
            ("O3", "ground", "crank3", ground[2], True),
        )
    ]
    for k in (1, 2):
        text += [
            f'[[frame]]\nname = "end{k}"\nparent = "crank{k + 1}"\norigin = [{r(LENGTH)!r}, 0.0]',
            f'[[frame]]\nname = "eye{k}"\nparent = "rod"\norigin = [{r(AT[k])!r}, 0.0]',
            f'[[loop]]\nname = "pin{k}"\nkind = "point"\nframes = ["eye{k}", "end{k}"]',
        ]
    text += ["[home]\nO1 = 1.1\nA1 = -0.7\nO2 = 1.1\nO3 = 1.1"]
    return loaded("\n".join(text))


def exact_cranks(angle: float, rate: float) -> tuple[np.ndarray, np.ndarray]:
    """q, q̇ of the machine that is meant: all cranks alike, the rod as the ground."""
    return np.array([angle, SLOPE - angle, angle, angle]), rate * np.array([1.0, -1.0, 1.0, 1.0])


@pytest.mark.sample(1)
@pytest.mark.parametrize("digits", DIGITS)
@pytest.mark.parametrize(
    "angle", [1.1, 0.9, 2.2, np.pi / 2 + SLOPE, -1.3, -np.pi / 2 + SLOPE, -2.0]
)
def test_three_rounded_cranks_move_as_one(digits, angle):
    """Also upright and hanging, where two equations that would do elsewhere do not."""
    meant, model = three_cranks(None), three_cranks(digits)
    q, qd = exact_cranks(angle, 1.7)
    expected = fb.forward_dynamics(meant, q, qd, np.array([0.3, 0, 0, 0]))
    at = fb.assemble(model, q, free=["A1", "O2", "O3"])
    close(at, q, 20 * 10.0**-digits)
    found = fb.mobility(model, at)
    assert (found.generic, found.instantaneous, found.rank, len(found.redundant)) == (1, 1, 3, 1)
    rates = fb.loop_velocity(model, at, {"O1": 1.7})
    close(rates, qd, 30 * 10.0**-digits)
    qdd = fb.forward_dynamics(model, at, rates, np.array([0.3, 0, 0, 0]))
    close(qdd, expected, 1e-3, float(np.abs(expected).max()))
    # and back
    tau = fb.inverse_dynamics(model, at, rates, qdd)
    close(tau, [0.3, 0, 0, 0], 1e-9)
    forces = fb.reactions(model, at, rates, tau=tau)
    meant_forces = fb.reactions(meant, q, qd, tau=np.array([0.3, 0, 0, 0]))
    assert np.array_equal(forces.determined, meant_forces.determined)
    close(forces.wrenches, meant_forces.wrenches, 2e-3, float(np.abs(meant_forces.wrenches).max()))
    assert forces.balance < max(1e-9, 10.0**-digits)  # a force across the gap that rounding leaves


@pytest.mark.parametrize("digits", DIGITS)
def test_three_rounded_cranks_fall(digits):
    """Through less than a turn between its change points, as the machine that is meant."""
    t = np.linspace(0.0, 0.25, 6)
    q, qd = exact_cranks(SLOPE - 0.5, 0.0)
    meant = fb.simulate(three_cranks(None), q, qd, t, tolerance=1e-9)
    model = three_cranks(digits)
    at = fb.assemble(model, q, free=["A1", "O2", "O3"])
    motion = fb.simulate(model, at, qd, t, tolerance=1e-9)
    assert abs(float(meant.q[-1, 0] - q[0])) > 0.3
    close(motion.q.values, meant.q.values, 1e-3 if digits == 4 else 1e-5)
    energy = (motion.kinetic_energy + motion.potential_energy).values
    assert np.abs(energy - energy[0]).max() < max(1e-7, 10.0**-digits) * float(np.abs(energy).max())


@pytest.mark.sample(1)
@pytest.mark.parametrize(("digits", "within"), [(9, 1e-6), (4, 2e-3)])
def test_three_rounded_cranks_pass_their_change_point(digits, within):
    """Where all cranks lie along the ground the machine is singular; rounding must not throw it
    onto another way."""
    t = np.linspace(0.0, 0.15, 4)
    q, qd = exact_cranks(SLOPE + 0.1, -1.0)
    meant = fb.simulate(three_cranks(None), q, qd, t)
    assert float(meant.q[-1, 0]) < SLOPE - 0.3
    model = three_cranks(digits)
    at = fb.assemble(model, q, free=["A1", "O2", "O3"])
    motion = fb.simulate(model, at, fb.loop_velocity(model, at, {"O1": -1.0}), t)
    close(motion.q.values, meant.q.values, within, 1.0)  # rad


@pytest.mark.sample(1)
@pytest.mark.parametrize("digits", DIGITS)
def test_bricards_loop_with_rounded_lengths_and_twists(digits):
    rng = np.random.default_rng(digits)
    text = (files("freebody.robots") / "bricard.toml").read_text(encoding="utf-8")

    def rounding() -> float:
        return float(rng.uniform(-0.5, 0.5)) * 10.0**-digits

    text = re.sub(r"a = 1\.0", lambda _: f"a = {1.0 + rounding()!r}", text)
    text = re.sub(r'"(-?)90 deg"', lambda sign: f"{sign[1]}{np.pi / 2 + rounding()!r}", text)
    meant, model = fb.load("bricard"), loaded(text)
    q, at = fb.assemble(meant), fb.assemble(model)
    close(at, q, 3 * 10.0**-digits + 1e-7)
    found = fb.mobility(model, at)
    assert (found.generic, found.rank, found.redundant) == (1, 4, fb.mobility(meant, q).redundant)
    assert 0.0 < max(found.misfit) < 3 * 10.0**-digits
    qdd = [
        fb.forward_dynamics(m, x, fb.loop_velocity(m, x, {"joint1": 1.0}), np.zeros(5))
        for m, x in ((meant, q), (model, at))
    ]
    close(qdd[1], qdd[0], 1e-3, float(np.abs(qdd[0]).max()))


# ---------------------------------------------------------------- a four-bar linkage in space
@lru_cache(maxsize=8)
def four_bar(turn: str) -> Model:
    return loaded(four_bar_text(TURN[turn]))


@pytest.mark.sample(1)
@pytest.mark.parametrize("turn", ["1.570796327", "1.5708", "1.571"])
@pytest.mark.parametrize("crank", [1.0, 2.5, -0.4])
def test_a_four_bar_with_rounded_right_angles_moves_as_the_one_that_is_meant(turn, crank):
    meant, model = four_bar("exact"), four_bar(turn)
    guess = {"j1": crank, "j2": -0.6 - crank + 1.0, "j3": -1.6}
    free = ["j2", "j3"]
    q, at = fb.assemble(meant, guess, free), fb.assemble(model, guess, free)
    close(at, q, 1e-3)
    found = fb.mobility(model, at)
    assert (found.generic, found.instantaneous, found.rank) == (1, 1, 2)
    assert found.redundant == ("closing.fy", "closing.mx", "closing.my")
    rounded_by = abs(float(TURN[turn]) - np.pi / 2)
    assert rounded_by / 3 < found.misfit[1] < 3 * rounded_by
    assert found.misfit[0] < 3 * rounded_by
    assert f"leave them open by up to {found.misfit[0]:.2g} m and {found.misfit[1]:.2g} rad" in str(
        found
    )
    assert fb.mobility(meant, q).misfit == (0.0, 0.0)
    rates = [fb.loop_velocity(m, p, {"j1": 2.0}) for m, p in ((meant, q), (model, at))]
    close(rates[1], rates[0], 1e-3)
    tau = [0.2, 0.0, 0.0]
    expected = fb.forward_dynamics(meant, q, rates[0], tau)
    qdd = fb.forward_dynamics(model, at, rates[1], tau)
    close(qdd, expected, 1e-3, float(np.abs(expected).max()))
    close(fb.inverse_dynamics(model, at, rates[1], qdd), tau, 1e-9)
    forces, meant_forces = (
        fb.reactions(m, p, v, tau=tau) for m, p, v in ((model, at, rates[1]), (meant, q, rates[0]))
    )
    close(forces.wrenches, meant_forces.wrenches, 2e-3, float(np.abs(meant_forces.wrenches).max()))
    assert np.array_equal(forces.determined, meant_forces.determined)


@pytest.mark.sample(1)
@pytest.mark.parametrize("turn", ["1.570796327", "1.5708", "1.571"])
def test_a_four_bar_with_rounded_right_angles_falls(turn):
    t = np.linspace(0.0, 0.6, 7)
    motions = []
    for model in (four_bar("exact"), four_bar(turn)):
        q = fb.assemble(model)
        motions.append(fb.simulate(model, q, np.zeros(3), t, tolerance=1e-9))
    meant, motion = motions
    assert abs(float(meant.q[-1, 0] - meant.q[0, 0])) > 1.0
    close(motion.q.values, meant.q.values, 1e-3)
    energy = (motion.kinetic_energy + motion.potential_energy).values
    assert np.abs(energy - energy[0]).max() < 1e-3 * float(np.ptp(motion.kinetic_energy.values))


# ---------------------------------------------------------------- what is meant by the tolerance
def test_the_tolerance_is_said_in_toml_in_load_and_in_python_and_saved(tmp_path):
    text = four_bar_text(TURN["1.5708"], loop_tolerance='[1e-4, "0.01 deg"]')
    model = loaded(text)
    assert model.loop_tolerance == (1e-4, np.radians(0.01))
    fb.save(model, tmp_path / "saved.toml")
    assert fb.load(tmp_path / "saved.toml").loop_tolerance == model.loop_tolerance
    assert loaded(text, loop_tolerance=(2e-4, 0.0)).loop_tolerance == (2e-4, 0.0)
    plain = loaded(four_bar_text(TURN["1.5708"]))
    assert plain.loop_tolerance is None
    assert "loop_tolerance" not in _saved(plain, tmp_path)
    assert plain.replace(loop_tolerance=(1e-3, 1e-3)).loop_tolerance == (1e-3, 1e-3)
    tree = plain.opened
    again = tree.with_loop(
        "x", "revolute", ("pin", "end"), axis=(0, 0, 1), loop_tolerance=(1e-5, 1e-5)
    )
    assert again.loop_tolerance == (1e-5, 1e-5)
    for bad in ((1e-3,), (-1.0, 0.0), (np.nan, 0.0), "fine", 3.0):
        with pytest.raises(
            fb.FreebodyError, match=r"loop_tolerance is .*, expected \(metres, radians\)"
        ):
            plain.replace(loop_tolerance=bad)
    with pytest.raises(fb.FreebodyError, match=r"\.toml:3: .*loop_tolerance is \(-1\.0, 0\.0\)"):
        loaded(four_bar_text("0", loop_tolerance="[-1, 0]"))


def _saved(model: Model, folder: Path) -> str:
    fb.save(model, folder / "plain.toml")
    return (folder / "plain.toml").read_text(encoding="utf-8")


def test_numbers_taken_at_their_word_do_not_move():
    """What is no rounding by the tolerance that is stated is refused, or stuck, with a reason that
    is true."""
    for tolerance in ((0.0, 0.0), (1e-6, 1e-6)):
        model = loaded(four_bar_text(TURN["1.571"]), loop_tolerance=tolerance)
        assert fb.mobility(model, fb.assemble(model)).generic == 0
        model = loaded(four_bar_text(TURN["1.5708"]), loop_tolerance=tolerance)
        with pytest.raises(
            LoopError,
            match=r"stays open by .* m, at the nearest .* loop_tolerance=\(metres, radians\)",
        ):
            fb.assemble(model)


def test_a_machine_that_does_not_fit_within_the_tolerance_is_not_redundant():
    """A third crank shorter by a hundredth is no rounding: the machine is stuck, at best."""
    model = three_cranks(None)
    wrong = loaded(_saved_text(model).replace(repr(float(LENGTH)), repr(float(LENGTH + 0.01)), 1))
    found = fb.mobility(wrong, fb.assemble(wrong, exact_cranks(1.1, 0.0)[0]))
    assert (found.generic, found.misfit) == (0, (0.0, 0.0))


def _saved_text(model: Model) -> str:
    import tempfile

    with tempfile.TemporaryDirectory() as folder:
        return _saved(model, Path(folder))


def test_a_small_mechanism_is_not_taken_for_rounding():
    """Cranks of a hundredth of the rod between them turn only together, small as they are."""
    small = {"l1": 0.01, "l2": 1.0, "l3": 0.012}
    arm = fb.planar(
        "RRR", l=list(small.values()), lc=[0.0, 0.5, 0.0], m=[0.1, 1.0, 0.1], I=[0.001, 0.1, 0.001]
    )
    model = arm.with_frame("pin", [1.0, 0.0], frame="base").with_loop(
        "closing", "point", ("pin", "tip")
    )
    twice = model.with_loop("again", "point", ("pin", "tip"))
    q = fb.assemble(twice, [1.0, -1.0, 1.0])
    found = fb.mobility(twice, q)
    assert (found.generic, found.rank, found.misfit) == (1, 2, (0.0, 0.0))
    close(
        fb.forward_dynamics(twice, q, np.zeros(3), np.zeros(3)),
        fb.forward_dynamics(model, q, np.zeros(3), np.zeros(3)),
        1e-9,
    )
