"""Sizing: the front is exact for one joint, as good as many random choices for all, and every
choice keeps every limit; what is rejected says why."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import product
from typing import Any

import numpy as np
import pytest

import freebody as fb

LIFE = 6000.0
Drives = dict[str, tuple[fb.Motor, fb.Gear]]
Candidate = tuple[float, fb.Motor, fb.Gear]


def price(*chosen: fb.Motor | fb.Gear) -> float:
    return sum(part.price or 0.0 for part in chosen)


def parts(motors: int, gears: int, seed: int = 0) -> fb.PartCatalogue:
    """Motors and gears of many sizes, heavier and dearer with their torque."""
    rng = np.random.default_rng(seed)
    some_motors, some_gears = [], []
    for k in range(motors):
        torque, speed = 0.05 * 10 ** (2.3 * rng.random()), rng.uniform(250.0, 630.0)
        peak = torque * rng.uniform(2.5, 3.5)
        some_motors.append(
            fb.Motor(
                f"M{k}", inertia=1e-4 * torque**1.3 * rng.uniform(1.0, 5.0),
                continuous_torque=torque, peak_torque=peak, max_speed=speed,
                mass=0.3 + torque * rng.uniform(0.6, 1.3),
                price=80.0 + torque * rng.uniform(50, 130),
                peak_curve=((0.0, peak), (0.6 * speed, peak), (speed, 0.4 * peak)),
                continuous_curve=((0.0, torque), (speed, 0.8 * torque)) if k % 3 == 0 else (),
            )
        )  # fmt: skip
    for k in range(gears):
        rated = 5.0 * 10 ** (2.0 * rng.random())
        some_gears.append(
            fb.Gear(
                f"G{k}", efficiency=rng.uniform(0.65, 0.9), inertia=1e-6 * rated,
                mass=0.1 + rated / 60.0, ratio=float(rng.choice([50, 80, 100, 120, 160])),
                price=200.0 + rated * rng.uniform(1.4, 2.8), peak_torque=2.2 * rated,
                average_torque=1.3 * rated, rated_torque=rated, rated_speed=209.0,
                rated_life=7000.0, max_speed=680.0, average_speed=370.0,
                kind=("strain wave", "cycloidal")[k % 2],
            )
        )  # fmt: skip
    return fb.PartCatalogue(tuple(some_motors), tuple(some_gears))


def cycles(arm: fb.Model, count: int, samples: int = 120) -> list[fb.Segment]:
    """Loops through random postures, each second one loaded."""
    rng, found = np.random.default_rng(5), []
    for k in range(count):
        q = rng.uniform(-1.2, 1.2, (3, arm.nq))
        motion = fb.quintic(arm, [*q, q[0]], acceleration=rng.uniform(2.0, 4.0))
        t = np.linspace(motion.t[0], motion.t[-1], samples)
        motion = fb.Motion.of(arm, t, *motion.at(t))
        found.append(fb.Segment(motion, payload=4.0 * (k % 2) or None, dwell=0.2 * k))
    return found


def test_the_front_of_one_joint_is_exact():
    """Every pair by itself, by another function: what the front has, and nothing better."""
    arm = fb.load("2R")
    duty, catalogue = cycles(arm, 2), parts(9, 5, seed=3)
    joint = arm.joint_names[1]
    found = fb.size(arm, duty, catalogue, joints=[joint], life=LIFE, margin=1.1)
    every = {}
    for motor, gear in product(catalogue.motors, catalogue.gears):
        margin = fb.drive_loads(arm, duty, {joint: (motor, gear)}, life=LIFE).margin
        every[motor.name, gear.name] = (motor.mass + gear.mass, price(motor, gear), margin)
    good = {name: x for name, x in every.items() if x[2] >= 1.1}
    assert 5 < len(good) < len(every)
    best = {
        name
        for name, x in good.items()
        if not any(y[0] <= x[0] and y[1] <= x[1] and y[2] >= x[2] and y != x for y in good.values())
    }
    chosen = {tuple(part.name for part in x.drives[joint]): x for x in found.choices}
    assert chosen.keys() == best
    for name, choice in chosen.items():
        assert (choice.mass, choice.price, choice.margin) == pytest.approx(every[name])
    rejected = {(x.motor, x.gear): x for x in found.rejected(joint)}
    assert rejected.keys() == every.keys() - good.keys()
    for name, one in rejected.items():
        assert 1.0 / one.share == pytest.approx(every[name][2])
        assert one.limit in one.text
    uses = found.pair_uses(joint)
    assert uses.max("limit").sel(motor="M3", gear="G2").item() == pytest.approx(
        1.0 / every["M3", "G2"][2]
    )


def test_the_front_of_two_joints_has_nothing_worse_than_all_pairs_have():
    """Every pair at the tip with every pair at the base, which carries it: each choice that was
    found is one of which no other is better in everything, and the lightest, the cheapest and the
    safest are among them."""
    arm = fb.load("2R")
    duty, catalogue = cycles(arm, 2), parts(14, 6, seed=1)
    found = fb.size(arm, duty, catalogue, life=LIFE)
    inner, outer = arm.joint_names
    every = []
    for margin, *pair in candidates(found, outer, {}):
        carried: Any = {outer: pair}
        for other, *drive in candidates(found, inner, carried):
            both = (*pair, *drive)
            every.append((sum(x.mass for x in both), price(*both), -min(margin, other)))
    all_pairs = np.array(every)
    assert len(all_pairs) > 100
    mine = np.array([[x.mass, x.price, -x.margin] for x in found.choices])
    least = 1e-9 * np.abs(mine).max(axis=0)
    for one in mine:
        assert not (
            (all_pairs <= one + least).all(axis=1) & (all_pairs < one - least).any(axis=1)
        ).any()
    assert mine.min(axis=0) == pytest.approx(all_pairs.min(axis=0), rel=1e-12)


@pytest.mark.sample(2)
@pytest.mark.parametrize("seed", [13, 4, 8, 9, 11, 12, 15, 20, 23])
def test_the_front_of_three_joints_is_that_of_an_exhaustive_search(seed: int):
    """All pairs of all joints, one inside the other, from small catalogues of strong
    motors; of other seeds less than eleven choices suffice."""
    arm = fb.load("3R")
    rng, many = np.random.default_rng(seed), parts(60, 30, seed=seed)
    strong = [x for x in many.motors if x.continuous_torque > 4.0]
    stiff = [x for x in many.gears if (x.rated_torque or 0.0) > 60.0]
    few = fb.PartCatalogue(
        tuple(strong[k] for k in rng.permutation(len(strong))[: 3 + seed % 2]),
        tuple(stiff[k] for k in rng.permutation(len(stiff))[:2]),
    )
    found = fb.size(arm, cycles(arm, 2, samples=40), few, life=LIFE)
    every = np.array(list(whole_choices(found, arm.joint_names[::-1], {}, np.inf)))
    assert len(every) > 10
    every = np.unique(every.round(9), axis=0)  # sums in another order differ by rounding
    signs, mine = [1.0, 1.0, -1.0], [[x.mass, x.price, x.margin] for x in found.choices]
    costs = every * signs
    better = [((costs <= x) & (costs < x).any(axis=1)[:, None]).all(axis=1).any() for x in costs]
    best = np.unique(every[~np.array(better)], axis=0)
    assert found.tolerance == 0.0
    assert np.unique(np.array(mine, dtype=float), axis=0) == pytest.approx(best, rel=1e-9)


def whole_choices(
    found: Any, joints: Sequence[str], drives: Drives, least: float
) -> Iterator[tuple[float, float, float]]:
    """The mass, price and margin of every choice that suffices, from the tip to the base."""
    if not joints:
        chosen = [part for pair in drives.values() for part in pair]
        yield sum(part.mass for part in chosen), price(*chosen), least
        return
    for margin, *pair in candidates(found, joints[0], drives):
        more: Any = {**drives, joints[0]: tuple(pair)}
        yield from whole_choices(found, joints[1:], more, min(least, margin))


def test_a_front_that_is_not_complete_is_so_within_its_tolerance():
    """Of a catalogue too large to compare all: of random choices, none is better than a listed one
    by more than was told."""
    arm = fb.load("3R")
    found = fb.size(arm, cycles(arm, 2), parts(25, 12), life=LIFE)
    assert 0.0 < found.tolerance < 0.1
    assert any("too many choices to compare all" in words for words in found.notices)
    mine = np.array([[x.mass, x.price, x.margin] for x in found.choices], dtype=float)
    rng, within = np.random.default_rng(2), 1.0 + found.tolerance
    for _ in range(6):
        drives: Drives = {}
        least = np.inf
        for joint in reversed(arm.joint_names):
            pool = candidates(found, joint, drives)
            margin, motor, gear = pool[min(int(rng.exponential(8.0)), len(pool) - 1)]
            drives[joint], least = (motor, gear), min(least, margin)
        chosen = [part for pair in drives.values() for part in pair]
        mass, cost = sum(part.mass for part in chosen), price(*chosen)
        near = (mine[:, 0] <= within * mass) & (mine[:, 1] <= within * cost)
        assert (near & (mine[:, 2] >= least / within)).any()


def test_the_front_is_whole_where_no_joint_carries_drives():
    """All drives stand on the ground: the sums of every joint's own front, however many."""
    arm = fb.load("3R")
    ground: Any = dict.fromkeys(arm.joint_names)
    found = fb.size(arm, cycles(arm, 2), parts(14, 8), life=LIFE, mounts=ground)
    assert found.tolerance == 0.0
    every = np.array([[0.0, 0.0, -np.inf]])
    for joint in arm.joint_names:
        own = np.array([(sum(x.mass for x in pair), price(*pair), -margin)
                        for margin, *pair in candidates(found, joint, {})])  # fmt: skip
        both = every[:, None, :2] + own[:, :2], np.maximum(every[:, None, 2], own[:, 2])
        every = front(np.dstack([both[0], both[1]]).reshape(-1, 3))
    mine = np.array([[x.mass, x.price, -x.margin] for x in found.choices], dtype=float)
    assert np.unique(mine, axis=0) == pytest.approx(np.unique(every, axis=0), rel=1e-9)


def front(costs: np.ndarray) -> np.ndarray:
    """Those rows of which no other is smaller in something and nowhere larger."""
    costs = np.unique(costs.round(9), axis=0)
    kept = [x for x in costs if not ((costs <= x).all(axis=1) & (costs < x).any(axis=1)).any()]
    return np.array(kept)


def test_choices_keep_every_limit_and_their_model_is_the_robot():
    arm = fb.load("ur5e").without("friction")
    duty, catalogue = cycles(arm, 2), parts(20, 8)
    found = fb.size(arm, duty, catalogue, life=LIFE)
    assert len(found.choices) > 5
    for choice in found.choices[::9]:
        loads = found.drive_loads(choice)
        assert loads.margin == pytest.approx(choice.margin)
        assert loads.passed
        assert loads.uses.max() == loads.uses.sel(joint=choice.joint, limit=choice.limit)
        carried = choice.mass - sum(x.mass for x in choice.drives["shoulder_pan_joint"])
        assert loads.model.mass == pytest.approx(arm.mass + carried)
    lightest = found.choices[0]
    assert "the lightest" in repr(found)
    motion = duty[0].motion
    tau = fb.inverse_dynamics(found.drive_loads().model, motion.q, motion.qd, motion.qdd)
    N = np.array([gear.factor for _, gear in lightest.drives.values()])
    got = found.drive_loads().data["motor_torque"].values[: len(tau)] * N
    assert np.abs(got - tau).max() < 1e-11 * np.abs(tau).max()


@pytest.mark.parametrize(
    "draws", [(1, 1, 1, 1, 2, 5), pytest.param((2, 4, 5, 5, 5, 10), marks=pytest.mark.long)]
)
def test_no_random_choice_is_better(draws: tuple[int, ...]):
    """Random choices, joint by joint from the tip among what suffices there, some of each joint
    behind each of those before: none is lighter, cheaper and safer than a choice that was found by
    more than its tolerance tells, none lighter than the lightest or much cheaper than the
    cheapest."""
    arm = fb.load("ur5e").without("friction")
    duty, catalogue = cycles(arm, 1), parts(16, 8)
    found = fb.size(arm, duty, catalogue, life=LIFE)
    mine = np.array([[x.mass, x.price, x.margin] for x in found.choices], dtype=float)
    rng = np.random.default_rng(1)

    def drawn(joints: Sequence[str], drives: Drives, least: float) -> Iterator[list[float]]:
        if not joints:
            chosen = [part for pair in drives.values() for part in pair]
            yield [sum(part.mass for part in chosen), price(*chosen), least]
            return
        pool = candidates(found, joints[0], drives)
        for _ in range(draws[-len(joints)]):
            margin, *pair = pool[min(int(rng.exponential(3.0)), len(pool) - 1)]
            more: Any = {**drives, joints[0]: tuple(pair)}
            yield from drawn(joints[1:], more, min(least, margin))

    random = np.array(list(drawn(arm.joint_names[::-1], {}, np.inf)))
    assert len(random) == np.prod(draws)
    mass, cost, margin = (random[:, None, k] / mine[:, k] for k in range(3))
    within = 1.0 + found.tolerance + 1e-9
    near = (mass * within >= 1.0) & (cost * within >= 1.0) & (margin <= within)
    assert near.any(axis=1).all()
    ahead = (mass < 1.0 - 1e-9) & (cost < 1.0 - 1e-9) & (margin > 1.0 + 1e-9)
    assert not ahead.any()
    assert mine[:, 0].min() <= random[:, 0].min() * (1.0 + 1e-9)
    assert mine[:, 1].min() <= random[:, 1].min() * within


def candidates(found: Any, joint: str, drives: Drives) -> list[Candidate]:
    """The pairs that suffice for a joint that carries drives, the lightest first: evenly drawn ones
    are far from the best."""
    uses = found.pair_uses(joint, drives).max("limit")
    pairs = [
        (1.0 / float(uses[m, g]), found.catalogue.motors[m], found.catalogue.gears[g])
        for m, g in np.argwhere(uses.values <= 1.0)
    ]
    return sorted(pairs, key=lambda x: x[1].mass + x[2].mass)


def test_heavier_drives_further_out_need_more_further_in():
    """Drives on the ground load nothing, so the robot needs no more than lighter ones."""
    arm = fb.load("ur5e").without("friction")
    duty, catalogue = cycles(arm, 1), parts(16, 8)
    riding = fb.size(arm, duty, catalogue)
    on_ground = fb.size(arm, duty, catalogue, mounts=dict.fromkeys(arm.joint_names))
    assert on_ground.choices[0].mass < riding.choices[0].mass
    greedy = [fb.size(arm, duty, catalogue, joints=[name]).choices[0] for name in arm.joint_names]
    assert on_ground.choices[0].mass == pytest.approx(sum(x.mass for x in greedy))
    assert on_ground.drive_loads().model.mass == pytest.approx(arm.mass)


@pytest.mark.parametrize(
    "payload",
    [
        4.0,
        {"mass": 4.0, "com": [0.1, 0.0], "inertia": 0.3},
        fb.Inertia(4.0, (0.1, 0.0), (0.3,)),
    ],
    ids=["mass", "table", "inertia"],
)
def test_the_heaviest_payloads_use_up_the_margin(payload: Any):
    """What `drive_loads` says of cycles with payloads so heavy: the margin is just kept, and with
    a hundredth more it is not; the limit is the one that is told."""
    arm = fb.load("2R")
    empty, loaded = cycles(arm, 2)

    def times(factor: float) -> list[fb.Segment]:
        given: Any = payload
        if isinstance(given, dict):
            given = {**given, "mass": 4.0 * factor, "inertia": 0.3 * factor}
        elif isinstance(given, fb.Inertia):
            given = fb.Inertia(4.0 * factor, given.com, (0.3 * factor,))
        else:
            given = given * factor
        return [empty, fb.Segment(loaded.motion, payload=given, dwell=loaded.dwell)]

    found = fb.size(arm, times(1.0), parts(9, 5, seed=3), life=LIFE, margin=1.1)
    for choice in found.choices[:: max(1, len(found.choices) - 1)]:
        most = found.heaviest(choice)
        assert 1.0 <= most.factor < 100.0
        assert most.masses == pytest.approx([4.0 * most.factor])
        just, more = (
            fb.drive_loads(arm, times(most.factor * x), choice.drives, life=LIFE)
            for x in (1.0, 1.01)
        )
        assert 1.1 <= just.margin < 1.1 * 1.001
        assert more.margin < 1.1
        assert more.uses.max() == more.uses.sel(joint=most.joint, limit=most.limit)
        assert most.limit in repr(most)


def test_the_heaviest_payload_does_not_depend_on_the_one_that_is_given():
    """A gram, of which drives bear thousands, is no payload without a limit."""
    arm = fb.load("2R")
    (empty,) = cycles(arm, 1)
    gram, kilogram = (
        fb.size(arm, fb.Segment(empty.motion, payload=m), parts(9, 5, seed=3)) for m in (1e-3, 1.0)
    )
    drives = kilogram.choices[0]
    few = gram.heaviest(drives).masses
    assert few == pytest.approx(kilogram.heaviest(drives).masses, rel=3e-4)


def test_without_a_payload_none_could_be_heavier():
    arm = fb.load("2R")
    with pytest.raises(fb.FreebodyError, match="carries a payload that could be heavier"):
        fb.size(arm, cycles(arm, 1)[0], parts(9, 5, seed=3)).heaviest()


def test_a_catalogue_that_does_not_suffice_says_for_what():
    arm = fb.load("ur5e").without("friction")
    duty, whole = cycles(arm, 1), parts(16, 8)
    weak = fb.PartCatalogue(
        tuple(sorted(whole.motors, key=lambda m: m.peak_torque)[:3]), whole.gears
    )
    found = fb.size(arm, duty, weak)
    assert found.choices == ()
    assert "No motor with a gear of the catalogue suffices for joint" in found.notices[0]
    assert "% of its" in found.notices[0]
    with pytest.raises(fb.FreebodyError, match="there is no choice"):
        found.drive_loads()
    assert found.rejected("shoulder_lift_joint")


def test_gears_that_fit_some_motors_and_screws():
    slide = fb.load("cart_pole")
    motor = fb.Motor("M", 1e-5, 1.0, 3.0, 400.0, 1.0)
    other = fb.Motor("N", 1e-5, 0.5, 1.0, 400.0, 0.5)
    screw = fb.Gear("S", efficiency=0.9, inertia=1e-6, mass=1.0, lead=0.01, fits=("M",))
    turning = fb.Gear("T", efficiency=0.9, inertia=1e-6, mass=1.0, ratio=10.0)
    joint = slide.driven_names[0]
    q = np.zeros((2, slide.nq))
    q[1, 0] = 0.3
    motion = fb.quintic(slide, [q[0], q[1]], acceleration=1.0)
    found = fb.size(slide, motion, fb.PartCatalogue((motor, other), (screw, turning)))
    (choice,) = found.choices
    assert [part.name for part in choice.drives[joint]] == ["M", "S"]
    assert choice.price is None
    assert "Prices do not count" in found.notices[0]
    assert "S is not made for N." in [x.text for x in found.rejected(joint)]
    with pytest.raises(fb.FreebodyError, match=f"no gear of the catalogue suits joint '{joint}'"):
        fb.size(slide, motion, fb.PartCatalogue((motor,), (turning,)))
    with pytest.raises(fb.FreebodyError, match="has no motor; add"):
        fb.size(slide, motion, fb.PartCatalogue((), (turning,)))
    assert not math.isnan(choice.margin)
    with pytest.raises(fb.FreebodyError, match="life is -1 h, expected 0 or more"):
        fb.size(slide, motion, fb.PartCatalogue((motor,), (screw,)), life=-1.0)


def test_a_motor_that_is_too_slow_is_told_of_its_speed():
    """Beyond its top speed it gives no torque at all, which is no reason of its own."""
    arm = fb.load("ur5e")
    motion = fb.quintic(arm, [np.zeros(arm.nq), 0.5 * np.ones(arm.nq)], [0.0, 1.0])
    strong = {"inertia": 1e-6, "continuous_torque": 900.0, "peak_torque": 2000.0, "mass": 0.0}
    few = fb.PartCatalogue(
        (fb.Motor("slow", max_speed=30.0, **strong), fb.Motor("quick", max_speed=900.0, **strong)),
        (fb.Gear("G", 0.9, 0.0, 0.0, ratio=50.0),),
    )
    found = fb.size(arm, motion, few, joints=["elbow_joint"])
    (one,) = found.rejected("elbow_joint")
    assert (one.motor, one.limit) == ("slow", "speed")
    assert one.share == pytest.approx(np.abs(motion.qd).max() * 50.0 / 30.0, rel=1e-9)


def test_what_holds_a_free_base_is_told():
    model = fb.load("2R", base="free")
    q = np.zeros((50, model.nq))
    q[:, -1] = np.linspace(0.0, 1.0, 50) ** 3
    motion = fb.Motion.of(model, np.linspace(0.0, 1.0, 50), q)
    motor = fb.Motor("M", 1e-4, 200.0, 600.0, 900.0, 0.0)
    gear = fb.Gear("G", 0.9, 0.0, 0.0, ratio=50.0)
    catalogue = fb.PartCatalogue((motor,), (gear,))
    for found in (
        fb.drive_loads(model, motion, {"joint2": (motor, gear)}),
        fb.size(model, motion, catalogue, joints=["joint2"]),
    ):
        assert any("Joint 'base' has no motor of its own" in words for words in found.notices)
