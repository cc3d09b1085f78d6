"""A closed chain's motion depends on where it is, not on the home that its file gives.

Homes are flat, singular, on another branch of the motion, open, or good; at one and the same closed
position mobility, accelerations and torques are the same from all of them, of exact mechanisms and
of rounded ones.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator

import numpy as np
import pytest

import freebody as fb
from freebody import Model, SingularError
from support.helpers import close
from support.linkages import four_bar_text, linkage
from support.robots import loaded

GRAVITY = 9.81


# ---------------------------------------------------------------- parallelograms in a row
def parallelograms(
    spans: list[float],
    crank: float = 1.0,
    *,
    slope: float = 0.0,
    third: float | None = None,
    digits: int | None = None,
    masses: Iterator[float] | None = None,
) -> Model:
    """Cranks of one length on ground that slopes, joined by a coupler as long as each span.

    Bars are uniform, of 1 kg, or of the masses given. third: where, along the first span, a further
    crank is pinned: one equation too many. digits: of every length and place, as files print them.
    """

    def printed(x: float) -> float:
        return float(x) if digits is None else round(float(x), digits)

    def at(s: float) -> str:
        return f"[{printed(s * np.cos(slope))!r}, {printed(s * np.sin(slope))!r}]"

    text = ['name = "row"', "dim = 2", '[[link]]\nname = "ground"']

    def bar(name: str, parent: str, child: str, origin: str, length: float) -> None:
        mass = next(masses) if masses else 1.0
        text.append(
            f'[[link]]\nname = "{child}"\nmass = {mass!r}\ncom = [{length / 2!r}, 0.0]\n'
            f"inertia = {mass * length**2 / 12!r}\n"
            f'[[joint]]\nname = "{name}"\nkind = "revolute"\nparent = "{parent}"\n'
            f'child = "{child}"\norigin = {origin}'
        )

    def pin(name: str, rod: str, along: float, arm: str) -> None:
        text.append(
            f'[[frame]]\nname = "eye{name}"\nparent = "{rod}"\norigin = [{printed(along)!r}, 0.0]\n'
            f'[[frame]]\nname = "end{name}"\nparent = "{arm}"\n'
            f"origin = [{printed(crank)!r}, 0.0]\n"
            f'[[loop]]\nname = "{name}"\nkind = "revolute"\nframes = ["end{name}", "eye{name}"]'
        )

    for k, s in enumerate(np.concatenate([[0.0], np.cumsum(spans)])):
        bar(f"O{k}", "ground", f"crank{k}", at(float(s)), crank)
        if k < len(spans):
            bar(f"A{k}", f"crank{k}", f"coupler{k}", f"[{printed(crank)!r}, 0.0]", spans[k])
    if third is not None:
        bar("X", "ground", "crankX", at(third), crank)
        pin("LX", "coupler0", third, "crankX")
    for k, span in enumerate(spans):
        pin(f"L{k}", f"coupler{k}", span, f"crank{k + 1}")
    return loaded("\n".join(text))


def abreast(model: Model, angle: float, slope: float = 0.0) -> np.ndarray:
    """q with all cranks at one angle, the couplers along the ground."""
    return np.array([slope - angle if x[0] == "A" else angle for x in model.position_names])


def from_home(model: Model, q: np.ndarray | None) -> Model:
    """The same robot, from a file with another home."""
    names = model.position_names
    home = () if q is None else tuple(zip(names, map(float, q), strict=True))
    return dataclasses.replace(model, home=home)


@pytest.mark.sample(1)
@pytest.mark.parametrize(
    "count", [1, 2, 6, 8, *(pytest.param(n, marks=pytest.mark.long) for n in (7, 13, 20, 40))]
)
def test_equal_parallelograms_fall_as_one_crank(count):
    """(n/3 + k) q̈ = -(n/2 + k) g cos q of n cranks and k couplers, all bars of 1 m and 1 kg."""
    model = parallelograms([1.0] * count)
    at, sense = abreast(model, 1.0), abreast(model, 1.0)
    cranks = count + 1
    weight = (cranks / 2 + count) * GRAVITY
    expected = -weight / (cranks / 3 + count) * np.cos(1.0) * sense
    aside = np.where(np.arange(model.nv) == 0, 0.0, at)
    for home in (None, abreast(model, np.pi / 2), abreast(model, 1e-3), aside):
        robot = from_home(model, home)
        mobility = fb.mobility(robot, at)
        assert (mobility.generic, mobility.rank, mobility.redundant) == (1, 2 * count, ())
        still = np.zeros(model.nv)
        close(fb.forward_dynamics(robot, at, still, still), expected, 1e-10)
        found = fb.kernel(robot, "forward_dynamics")(at, still, still)
        assert np.isnan(found).all() or np.abs(found - expected).max() < 1e-10


@pytest.mark.parametrize("count", [2, pytest.param(6, marks=pytest.mark.long)])
def test_equal_parallelograms_from_a_flat_home_keep_their_energy(count):
    """Over ten seconds with a turn that passes the flat position again and again."""
    model = parallelograms([1.0] * count)
    q, qd = abreast(model, np.pi / 2), -abreast(model, 1.0)
    motion = fb.simulate(model, q, qd, np.linspace(0.0, 10.0, 41), tolerance=1e-11)
    energy = (motion.kinetic_energy + motion.potential_energy).values
    assert np.abs(energy - energy[0]).max() < 1e-8 * float(motion.kinetic_energy.max())
    assert float(motion.loop_gap.max()) < 1e-9
    assert float(np.abs(motion.q[:, 0]).max()) > 6.0


# ---------------------------------------------------------------- whatever the home
def row(seed: int) -> tuple[Model, np.ndarray, list[np.ndarray | None], float]:
    """A row of parallelograms, perhaps redundant and rounded: (model, a guess near a closed
    position, homes, what rounding may change)."""
    rng = np.random.default_rng([seed, 7])
    count, crank = int(rng.integers(1, 8 if seed % 8 == 0 else 4)), float(rng.uniform(0.3, 1.5))
    spans = rng.uniform(0.4, 1.6, size=count).tolist() if seed % 3 else [crank] * count
    third = float(rng.uniform(0.3, 0.7)) * spans[0] if seed % 2 else None
    digits = None if third is None else (None, 9, 6, 4)[int(rng.integers(4))]
    slope = float(rng.uniform(-1.0, 1.0))
    weights = iter(rng.uniform(0.5, 2.0, size=40).tolist())
    given = {"slope": slope, "third": third, "digits": digits, "masses": weights}
    model = parallelograms(spans, crank, **given)
    angles = slope + rng.choice([-1.0, 1.0], size=2) * rng.uniform(0.5, 2.6, size=2)
    guess, other = (abreast(model, angle, slope) for angle in angles)
    flat, near = (abreast(model, slope + away, slope) for away in (0.0, 1e-3))
    folded = np.where([x == "O0" for x in model.position_names], slope, guess)
    homes = [None, flat, near, folded, other, rng.uniform(-np.pi, np.pi, size=model.nq)]
    return model, guess, homes, 0.0 if digits is None else 200 * 10.0**-digits


def hinges(seed: int) -> tuple[Model, np.ndarray, list[np.ndarray | None], float]:
    """A planar four-bar in space, its right angles rounded."""
    rng = np.random.default_rng([seed, 8])
    digits = int(rng.choice([9, 6, 4]))
    model = loaded(four_bar_text(repr(round(np.pi / 2, digits))))
    guess = np.array([1.0, -0.6, -1.6])
    crossed = np.array([1.0, -2.0, 1.6])
    homes = [None, crossed, rng.uniform(-np.pi, np.pi, size=3), np.array([2.0, -1.6, -1.6])]
    return model, guess, homes, 200 * 10.0**-digits


def any_linkage(seed: int) -> tuple[Model, np.ndarray, list[np.ndarray | None], float]:
    """A random tree of links with one or two loops."""
    model, guess = linkage(seed)
    rng = np.random.default_rng([seed, 9])
    others = [rng.uniform(-np.pi, np.pi, size=model.nq) for _ in range(2)]
    return model, guess, [None, *others, guess + rng.normal(scale=1e-3, size=model.nq)], 0.0


def answers(model: Model, q: np.ndarray, qd: np.ndarray) -> list[np.ndarray | str]:
    """What is asked of a closed position; a refusal by its words, which are those of the place."""
    found: list[np.ndarray | str] = []

    def ask(question) -> None:
        try:
            found.append(question())
        except fb.FreebodyError as error:
            found.append(str(error))

    mobility = fb.mobility(model, q)
    found.append(np.array([mobility.generic, mobility.instantaneous, mobility.rank], dtype=float))
    rates = fb.loop_velocity(model, q, qd)
    still = np.zeros(model.nv)
    ask(lambda: rates)
    ask(lambda: fb.forward_dynamics(model, q, rates, still))
    ask(lambda: fb.inverse_dynamics(model, q, still, still))
    ask(lambda: fb.assemble(model, q))
    return found


def examine(seed: int) -> bool:
    """Whether there was something to compare."""
    make = (row, row, hinges, any_linkage)[seed % 4]
    model, guess, homes, rounding = make(seed)
    good = from_home(model, guess)
    try:
        q = fb.assemble(good, guess)
    except fb.LoopError:
        return False
    qd = np.random.default_rng(seed).normal(size=model.nv)
    expected = answers(good, q, qd)
    for home in homes:
        found = answers(from_home(model, home), q, qd)
        for value, other in zip(found, expected, strict=True):
            if isinstance(value, str) or isinstance(other, str):
                assert value == other, home
            else:
                size = 1.0 + float(np.abs(other).max())
                close(value, other, 1e-8 + rounding, size, f"from the home {home}")
    return True


@pytest.mark.sample(1)
@pytest.mark.usefixtures("numpy_kernels")
@pytest.mark.parametrize("seed", range(16))
def test_answers_do_not_depend_on_the_home(seed):
    examine(seed)


@pytest.mark.long
@pytest.mark.usefixtures("numpy_kernels")
def test_answers_do_not_depend_on_the_home_of_three_hundred_mechanisms():
    assert sum(map(examine, range(16, 400))) > 300


# ---------------------------------------------------------------- ten seconds of machines
def governor() -> Model:
    """A flyball governor: a spindle, two arms with balls, two rods to a sleeve that slides on the
    spindle. Its loops in space are redundant."""
    text = ['name = "governor"', "dim = 3"]
    text += [f'[[link]]\nname = "{name}"' for name in ("ground",)]
    body = '[[link]]\nname = "{}"\nmass = {}\ncom = [{}, 0, 0]\ninertia = [{}, 0, 0, {}, 0, {}]'
    text += [
        body.format("spindle", 2.0, 0, 2e-3, 2e-3, 1.5e-3),
        body.format("sleeve", 0.7, 0, 4e-4, 4e-4, 6e-4),
    ]
    joint = '[[joint]]\nname = "{}"\nkind = "{}"\nparent = "{}"\nchild = "{}"\naxis = {}\n'
    text += [
        joint.format("spin", "revolute", "ground", "spindle", "[0, 0, 1]"),
        joint.format("lift", "prismatic", "spindle", "sleeve", "[0, 0, 1]"),
    ]
    for side, turn in ((1, 0.0), (-1, np.pi)):
        text += [
            body.format(f"arm{side}", 1.1, 0.25, 1e-4, 8e-3, 8e-3),
            body.format(f"rod{side}", 0.3, 0.15, 5e-5, 2e-3, 2e-3),
            joint.format(f"arm{side}", "revolute", "spindle", f"arm{side}", "[0, 1, 0]")
            + f"origin = [{0.02 * side!r}, 0, 0]\nrpy = [0, 0, {turn!r}]",
            joint.format(f"rod{side}", "revolute", f"arm{side}", f"rod{side}", "[0, 1, 0]")
            + "origin = [0.31, 0, 0]",
            f'[[frame]]\nname = "eye{side}"\nparent = "sleeve"\n'
            f"origin = [{0.02 * side!r}, 0, 0]\nrpy = [0, 0, {turn!r}]",
            f'[[frame]]\nname = "end{side}"\nparent = "rod{side}"\norigin = [0.31, 0, 0]',
            f'[[loop]]\nname = "pin{side}"\nkind = "revolute"\nframes = ["eye{side}", "end{side}"]'
            "\naxis = [0, 1, 0]",
        ]
    return loaded("\n".join(text))


def machine(name: str) -> tuple[Model, np.ndarray, np.ndarray, list[np.ndarray | None]]:
    """(model, a closed position, rates from which it swings or turns, homes)."""
    rng = np.random.default_rng(11)
    if name == "governor":
        model, a = governor(), 1.0
        by_name = {"spin": 0.0, "lift": -0.62 * np.sin(a)}
        by_name |= {f"arm{k}": a for k in (1, -1)} | {f"rod{k}": np.pi - 2 * a for k in (1, -1)}
        guess = np.array([by_name[x] for x in model.position_names])
        q = fb.assemble(from_home(model, guess), guess)
        rates = {x: {"spin": 12.0}.get(x, 0.0) for x in model.velocity_names}
        qd = fb.loop_velocity(model, q, [rates[x] for x in model.velocity_names])
    elif name == "slider_crank":
        numbers = {"l1": 0.17, "lc1": 0.05, "m1": 0.9, "I1": 0.011, "l2": 0.43, "lc2": 0.2}
        model = fb.load(name).bind(**numbers, m2=0.7, I2=0.014, m3=1.3)
        q = fb.assemble(
            model, {"crank_pin": 2.0, "rod_pin": -2.4, "guide": 0.35}, ["rod_pin", "guide"]
        )
        qd = fb.loop_velocity(model, q, {"crank_pin": 3.0})
    else:
        model = fb.load(name)
        q = fb.assemble(model)
        qd = fb.loop_velocity(model, q, {fb.mobility(model, q).independent[0]: 1.0})
    homes = [None, q, *(rng.uniform(-np.pi, np.pi, size=model.nq) for _ in range(3))]
    return model, q, qd, homes


@pytest.mark.long
@pytest.mark.parametrize("name", ["governor", "slider_crank", "bricard"])
def test_machines_keep_their_loops_and_energy_from_any_home(name):
    model, q, qd, homes = machine(name)
    ends = []
    for home in homes:
        robot = from_home(model, home)
        motion = fb.simulate(robot, q, qd, np.linspace(0.0, 10.0, 101), tolerance=1e-11)
        energy = (motion.kinetic_energy + motion.potential_energy).values
        assert np.abs(energy - energy[0]).max() < 1e-8 * max(float(np.abs(energy).max()), 1.0)
        assert float(motion.loop_gap.max()) < 1e-9
        assert float(motion.q.std("time").max()) > 0.05
        ends.append(motion.q.values[-1])
    for end in ends:
        close(end, ends[0], 1e-6, 1.0)


# ---------------------------------------------------------------- at rest, near a change point
@pytest.mark.sample(3)
@pytest.mark.parametrize(("digits", "angle"), [(4, 0.1), (4, 0.15), (6, 0.03), (None, 1e-3)])
def test_near_a_change_point_what_is_held_stays_and_what_is_let_go_falls(digits, angle):
    """At rest no velocity tells the branch; the equations do, until rounding leaves nothing."""
    model = parallelograms([1.0], 0.7, third=0.4, slope=0.3, digits=digits)
    exact = parallelograms([1.0], 0.7, third=0.4, slope=0.3)
    q, still = fb.assemble(model, abreast(model, 0.3 + angle, 0.3)), np.zeros(4)
    held = fb.forward_dynamics(model, q, still, fb.static_torque(model, q))
    assert np.abs(held).max() < 1e-6
    falls = fb.forward_dynamics(model, q, still, still)
    expected = fb.forward_dynamics(exact, abreast(exact, 0.3 + angle, 0.3), still, still)
    close(falls, expected, 1e-2)


def test_in_the_change_point_of_rounded_numbers_a_mechanism_at_rest_is_refused():
    model = parallelograms([1.0], 0.7, third=0.4, slope=0.3, digits=4)
    q, still = fb.assemble(model, abreast(model, 0.33, 0.3)), np.zeros(4)
    with pytest.raises(SingularError, match="no longer determines how the motion continues"):
        fb.forward_dynamics(model, q, still, still)
