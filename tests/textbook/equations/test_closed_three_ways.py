"""One mechanism told three ways, as a tree and loops cut here, or there, or as free bodies and
constraints only, moves and presses the same. And its twin in space, and equations too many, change
nothing."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import freebody as fb
from support.closed_chains import (
    GROUND,
    Mechanism,
    built,
    coordinates,
    drives,
    mechanism_of,
    moving,
    pin_reactions,
    ring,
)
from support.helpers import close, numbers

pytestmark = pytest.mark.usefixtures("numpy_kernels")

BUNDLED = ("four_bar", "slider_crank", "five_bar", "double_four_bar", "3RRR")


def spanning_trees(mechanism: Mechanism) -> list[list[str]]:
    """Two choices of pins that connect all parts to the ground: the first ones found, and the last
    ones."""

    def tree(pins: list) -> list[str]:
        group = {name: name for name in (GROUND, *mechanism.parts)}
        chosen = []
        for pin in pins:
            old, new = group[pin.a], group[pin.b]
            if old != new and pin.kind != "distance":
                chosen.append(pin.name)
                group = {name: new if g == old else g for name, g in group.items()}
        return chosen

    pins = list(mechanism.pins)
    return [tree(pins), tree(pins[::-1])]


def random_closed(model: fb.Model, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """A closed state, away from the extremes of its assembly."""
    _, qd, _ = fb.random_state(model, seed)
    start = fb.neutral(model)
    if model.name == "double_four_bar":  # stretched it could go any way
        start[:] = [1.1 if body.name.startswith("crank") else -1.1 for body in model.bodies]
    way = 0.3 * np.random.default_rng(seed).uniform(-1, 1, size=model.nv)
    q = fb.assemble(model, fb.integrate(model, start, way))
    return q, fb.loop_velocity(model, q, qd)


def compare(
    mechanism: Mechanism, seed: int, tolerance: float = 1e-9, model: fb.Model | None = None
) -> None:
    """Accelerations, energies, reactions of the mechanism by all of its models, in a state of the
    model, or any."""
    rng = np.random.default_rng(seed)
    trees = spanning_trees(mechanism)
    first = model or built(mechanism, trees[0])
    state = moving(mechanism, first, *random_closed(first, seed), at="" if model else "@")
    torques = {name: float(rng.normal(scale=3.0)) for name in mechanism.driven}
    load = {
        f"{part}@": 2 * rng.normal(size=6 if mechanism.dim == 3 else 3)
        for part in list(mechanism.parts)[:2]
    }
    results = []
    for tree in (*trees, None):
        model = built(mechanism, tree)
        q, qd = coordinates(mechanism, model, state)
        again = moving(mechanism, model, q, qd)
        for part in mechanism.parts:  # it is the same state
            close(again.T[part], state.T[part], 1e-12, 1.0)
            close(again.V[part], state.V[part], 1e-11, 1.0)
        tau, wrenches = drives(mechanism, model, state, torques)
        wrenches |= load
        qdd = fb.forward_dynamics(model, q, qd, tau, wrenches)
        found = fb.reactions(model, q, qd, tau=tau, wrenches=wrenches)
        assert found.balance < 1e-9
        close(found.qdd, qdd, 1e-12)
        assert found.determined.all()
        for joint in model.joint_names:
            if joint.startswith("free_"):
                close(found[joint], 0 * found[joint], 1e-9, float(np.abs(found.wrenches).max()))
        bodies = [
            numbers(model, "acceleration", q, qd, qdd, frame=f"{part}@") for part in mechanism.parts
        ]
        pressed = pin_reactions(mechanism, model, state, found, torques)
        results.append(
            (
                np.array(bodies),
                np.array([pressed[pin.name] for pin in mechanism.pins]),
                np.array([fb.kinetic_energy(model, q, qd), fb.potential_energy(model, q)]),
            )
        )
    for other in results[1:]:
        for a, b, what in zip(
            other, results[0], ("accelerations", "reactions", "energies"), strict=True
        ):
            close(a, b, tolerance, what=f"{mechanism.name}: {what}")


@pytest.mark.sample(1)
@pytest.mark.parametrize("name", BUNDLED)
def test_bundled_plane(name):
    model = fb.load(name).replace(gravity=[1.0, -9.0])
    compare(mechanism_of(model), 1, model=model)


def test_bundled_rods_held_at_distances():
    # a loop of kind distance can be no joint: here the tree and the free bodies
    model = fb.load("five_bar_rods")
    compare(mechanism_of(model), 1, model=model)


@pytest.mark.sample(1)
@pytest.mark.parametrize("seed", range(2))
def test_rings_in_space(seed):
    compare(ring(seed), seed)


@pytest.mark.long
@pytest.mark.parametrize("seed", range(2, 60))
def test_more_rings_in_space(seed):
    compare(ring(seed), seed, 1e-8)


@pytest.mark.sample(1)
@pytest.mark.parametrize("name", ["four_bar", "slider_crank", "five_bar"])
def test_twins_in_space(name):
    """Pins that hold all six directions: the plane's other equations are redundant, and change
    nothing."""
    plane = fb.load(name)
    space = plane.to_space()
    q, qd = random_closed(plane, 3)
    rng = np.random.default_rng(1)
    tau = rng.normal(size=plane.nv) * [name in plane.actuated for name in plane.joint_names]
    six = rng.normal(size=3)
    qdd = fb.forward_dynamics(plane, q, qd, tau, {"P" if name != "slider_crank" else "slider": six})
    load = {"P" if name != "slider_crank" else "slider": [*six[:2], 0, 0, 0, six[2]]}
    close(fb.forward_dynamics(space, q, qd, tau, load), qdd, 1e-12)
    here = fb.mobility(plane, q)
    there = fb.mobility(space, q)
    assert there.generic == there.instantaneous == here.generic
    assert there.gruebler == here.gruebler - 3
    assert len(there.redundant) == 3
    assert here.redundant == ()
    loop = plane.loops[0].name
    # what a plane cannot tell: the force out of it, and the moments about its axes
    assert set(there.redundant) == {f"{loop}.fz", f"{loop}.mx", f"{loop}.my"}
    flat = fb.reactions(plane, q, qd, tau=tau, wrenches={next(iter(load)): six})
    found = fb.reactions(space, q, qd, tau=tau, wrenches=load)
    assert found.balance < 1e-9
    close(found.wrenches[:, [0, 1, 5]], flat.wrenches, 1e-9)
    assert found.determined[:, [0, 1, 5]].all()
    # every pin that the loop runs through shares what is not determined: least, here nothing
    in_loop = found.determined[:, [2, 3, 4]]
    assert not in_loop.all()
    close(
        found.wrenches[:, [2, 3, 4]],
        0 * found.wrenches[:, [2, 3, 4]],
        1e-9,
        float(np.abs(flat.wrenches).max()),
    )


@pytest.mark.sample(2)
@pytest.mark.parametrize(
    "name", ["four_bar", "slider_crank", "five_bar", "double_four_bar", "stewart"]
)
def test_a_loop_twice_changes_nothing(name):
    model = fb.load(name)
    model = model.replace(actuated=model.joint_names)
    q, qd = random_closed(model, 5) if name != "stewart" else stewart_state(model)
    loop = model.loops[0]
    axis = {"axis": loop.axis} if loop.axis else {}
    twice = model.with_loop("again", loop.kind, loop.frames, **axis)
    tau = np.random.default_rng(2).normal(size=model.nv)
    once = fb.reactions(model, q, qd, tau=tau)
    both = fb.reactions(twice, q, qd, tau=tau)
    close(both.qdd, once.qdd, 1e-12)
    close(fb.forward_dynamics(twice, q, qd, tau), fb.forward_dynamics(model, q, qd, tau), 1e-12)
    # the two share what one carried, in equal parts, and neither is determined; all others are what
    # they were
    joints = len(model.joint_names)
    close(both.wrenches[:joints], once.wrenches[:joints], 1e-9)
    close(both[loop.name], once[loop.name] / 2, 1e-9, float(np.abs(once.wrenches).max()))
    close(both["again"], both[loop.name], 1e-9, float(np.abs(once.wrenches).max()))
    assert both.determined[:joints].all()
    shared = both.names.index(loop.name)
    dim = model.dim
    assert not both.determined[shared, :dim].any()
    assert not both.determined[-1, :dim].any()
    assert fb.mobility(twice, q).redundant == tuple(f"again.f{x}" for x in "xyz"[:dim])


def stewart_state(model: fb.Model) -> tuple[np.ndarray, np.ndarray]:
    q = fb.neutral(model)
    q[2] = 0.55
    q = fb.assemble(model, q, free=[j for j in model.joint_names if j != "pose"])
    return q, fb.loop_velocity(model, q, np.random.default_rng(3).normal(size=model.nv))


def test_a_third_crank_is_redundant_and_carries_nothing_that_is_determined():
    """A parallelogram with a third crank of no mass: one equation too many, the same motion."""
    bar = fb.Inertia(1.0, (0.5, 0.0), (1 / 12,))
    from support.closed_chains import Pin, homogeneous

    def at(x):
        return homogeneous(np.eye(2), (x, 0.0))

    pins = [
        Pin("O1", "revolute", GROUND, at(0.0), "crank1", at(0.0), (1.0,)),
        Pin("O2", "revolute", GROUND, at(1.0), "crank2", at(0.0), (1.0,)),
        Pin("A1", "revolute", "crank1", at(1.0), "coupler", at(0.0), (1.0,)),
        Pin("A2", "revolute", "crank2", at(1.0), "coupler", at(1.0), (1.0,)),
    ]
    two = Mechanism(
        2, {"crank1": bar, "crank2": bar, "coupler": bar}, tuple(pins), (0.0, -9.81), ("O1",)
    )
    more = (
        Pin("O3", "revolute", GROUND, at(0.4), "crank3", at(0.0), (1.0,)),
        Pin("A3", "revolute", "crank3", at(1.0), "coupler", at(0.4), (1.0,)),
    )
    three = replace(two, parts={**two.parts, "crank3": None}, pins=two.pins + more)
    a, b = built(two, ["O1", "O2", "A1"]), built(three, ["O1", "O2", "A1", "O3"])
    q, qd = np.array([1.1, 1.1, -1.1]), np.array([0.7, 0.7, -0.7])
    state = moving(two, a, *_ordered(a, two, q, qd))
    state.T["crank3"], state.V["crank3"] = _third(1.1, 0.7)
    q_a, qd_a = coordinates(two, a, state)
    q_b, qd_b = coordinates(three, b, state)
    here, there = fb.mobility(a, q_a), fb.mobility(b, q_b)
    assert (here.gruebler, here.generic, here.redundant) == (1, 1, ())
    assert (there.gruebler, there.generic) == (0, 1)
    assert len(there.redundant) == 1
    first = fb.reactions(a, q_a, qd_a, tau=_only(a, "O1", 2.0))
    second = fb.reactions(b, q_b, qd_b, tau=_only(b, "O1", 2.0))
    for part in ("crank1", "crank2", "coupler"):
        close(
            fb.acceleration(b, q_b, qd_b, second.qdd, f"{part}@"),
            fb.acceleration(a, q_a, qd_a, first.qdd, f"{part}@"),
            1e-12,
        )
    assert first.determined.all()
    assert not second.determined.all()
    assert first.balance < 1e-9
    assert second.balance < 1e-9
    free = built(three, None)
    q_f, qd_f = coordinates(three, free, state)
    _, load = drives(three, free, state, {"O1": 2.0})
    third = fb.reactions(free, q_f, qd_f, tau=np.zeros(free.nv), wrenches=load)
    for part in ("crank1", "crank2", "coupler"):
        close(
            fb.acceleration(free, q_f, qd_f, third.qdd, f"{part}@"),
            fb.acceleration(a, q_a, qd_a, first.qdd, f"{part}@"),
            1e-11,
        )


def _ordered(model, mechanism, q, qd):
    order = {"crank1": 0, "crank2": 1, "coupler": 2}
    k = [order[body.name] for body in model.bodies]
    return q[k], qd[k]


def _third(angle, rate):
    s, c = np.sin(angle), np.cos(angle)
    T = np.array([[c, -s, 0.4], [s, c, 0.0], [0.0, 0.0, 1.0]])
    return T, np.array([0.0, 0.0, rate])


def _only(model, name, value):
    return value * np.array([joint == name for joint in model.joint_names], dtype=float)
