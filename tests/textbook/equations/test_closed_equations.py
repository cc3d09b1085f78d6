"""Loop equations: what each kind holds, and their derivatives against differences of the equations
themselves."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import pytest

import freebody as fb
from support.generate import model as tree
from support.generate import random_inertia, random_placement
from support.helpers import close, numbers, path, poses, rate, second_rate, state
from support.robots import Joint, Link, Mount, Robot, loaded

pytestmark = pytest.mark.usefixtures("numpy_kernels")

HELD = {
    2: {"revolute": 2, "prismatic": 2, "point": 2, "fixed": 3, "distance": 1},
    3: {
        "revolute": 5,
        "prismatic": 5,
        "universal": 4,
        "spherical": 3,
        "fixed": 6,
        "distance": 1,
    },
}
"""How many motions each kind of loop takes away, by the dimension of the space."""
KINDS = [(kind, dim) for dim, held in HELD.items() for kind in held]
HAVE_AXIS = {("prismatic", 2), ("prismatic", 3), ("revolute", 3)}
H = 0.01


@lru_cache(maxsize=64)
def looped(seed: int, dim: int, kinds: tuple[str, ...] = ()) -> fb.Model:
    """A random tree with loops between random frames, which nothing closes."""
    model = tree(seed, dim)
    rng = np.random.default_rng([seed, dim, 5])
    for k, kind in enumerate(kinds or rng.choice([*HELD[dim]], size=2)):
        while True:
            a, b = (str(x) for x in rng.choice(model.frame_names, size=2, replace=False))
            if model.frame(a).body != model.frame(b).body:
                break
        axis = tuple(rng.normal(size=dim)) if (str(kind), dim) in HAVE_AXIS else ()
        if k % 2 and axis:
            axis = tuple(np.eye(dim)[int(rng.integers(dim))] * rng.choice([-1.0, 1.0]))
        distance = float(rng.uniform(0.2, 1.5)) if kind == "distance" else None
        model = model.with_loop(f"loop{k}", str(kind), (a, b), axis=axis, distance=distance)
    return model


SEEDS = [(seed, dim) for seed in range(12) for dim in (2, 3)]


@pytest.mark.sample(9)
@pytest.mark.parametrize(("kind", "dim"), KINDS)
@pytest.mark.parametrize("seed", [1, 6, 11])
def test_derivatives_of_every_kind(kind, dim, seed):
    check_derivatives(looped(seed, dim, (kind, kind)), seed)


@pytest.mark.sample(9)
@pytest.mark.parametrize(("seed", "dim"), SEEDS)
def test_derivatives_of_mixed_loops(seed, dim):
    check_derivatives(looped(seed, dim), seed)


def check_derivatives(model: fb.Model, seed: int) -> None:
    """Φ̇ = Φ_q q̇ and Φ̈ = Φ_q q̈ - c along motions through states that are not closed; and the
    third derivative."""
    q, qd, qdd = state(model, seed, 4)
    qs, qds = path(model, q, qd, qdd, H)
    phi = numbers(model, "constraint", qs)
    J, c = numbers(model, "constraint_jacobian", q), numbers(model, "constraint_bias", q, qd)
    assert J.shape == (4, model.tree.constraints, model.nv)
    size = 1.0 + float(np.abs(phi).max())
    close(np.einsum("bmk,bk->bm", J, qd), rate(phi, H), 1e-9, size, "first")
    close(numbers(model, "constraint_rate", q, qd), rate(phi, H), 1e-9, size, "first")
    close(np.einsum("bmk,bk->bm", J, qdd) - c, second_rate(phi, H), 1e-8, 10 * size, "second")
    # with q⃛ = 0 the third derivative of Φ is the rate of Φ_q q̈ - c at constant q̈
    second = np.einsum("tbmk,bk->tbm", numbers(model, "constraint_jacobian", qs), qdd)
    second = second - numbers(model, "constraint_bias", qs, qds)
    close(numbers(model, "constraint_jerk", q, qd, qdd), rate(second, H), 1e-8, 10 * size, "third")


@pytest.mark.parametrize(("seed", "dim"), SEEDS[:8])
def test_the_kernels_say_what_the_formulas_say(seed, dim):
    model = looped(seed, dim)
    q, qd, _ = state(model, seed, 3)
    for name, arrays in (
        ("constraint", (q,)),
        ("constraint_jacobian", (q,)),
        ("constraint_bias", (q, qd)),
    ):
        expected = numbers(model, name, *arrays)
        close(
            fb.kernel(model, name)(*arrays),
            expected,
            1e-12,
            1.0 + float(np.abs(expected).max()),
            name,
        )


@pytest.mark.sample(5)
@pytest.mark.parametrize(("seed", "dim"), SEEDS)
def test_power_of_the_multipliers(seed, dim):
    """-Φ_qᵀ λ is what the loops' wrenches do to the joints."""
    model = looped(seed, dim)
    q, qd, qdd = (x[0] for x in state(model, seed, 1))
    lam = np.random.default_rng(seed).normal(size=model.tree.constraints)
    J = numbers(model, "constraint_jacobian", q)
    wrenches = fb.kernel(model, "reaction_wrenches")(q, qd, qdd, lam)
    power = 0.0
    for loop, w in zip(model.loops, wrenches[len(model.joint_names) :], strict=True):
        a, b = loop.frames
        v_a, v_b = (fb.velocity(model, q, qd, frame) for frame in (a, b))
        arm = (poses(model, q)[b] - poses(model, q)[a])[: model.dim, 3]
        if loop.kind in ("revolute", "universal", "spherical", "point", "fixed"):
            arm = 0.0 * arm  # open, it presses at each origin; closed, they are one
        turned = v_a[2] * np.array([-arm[1], arm[0]]) if model.dim == 2 else np.cross(v_a[3:], arm)
        # on A acts the opposite, on the same line
        power += w @ v_b - w @ (v_a + np.concatenate([turned, 0 * v_a[model.dim :]]))
    close(power, -lam @ J @ qd, 1e-10, 1.0 + float(np.abs(lam @ J).max()))


# ---------------------------------------------------------------- what the kinds mean
def test_every_kind_is_tried():
    model = fb.load("2R")
    with pytest.raises(fb.UnknownNameError) as told:
        model.with_loop("again", "knot", (model.tip, model.tip))
    kinds = str(told.value).rpartition("kinds: ")[2].rstrip(".").split(", ")
    assert set(HELD[2]) | set(HELD[3]) == set(kinds)


@pytest.mark.sample(7)
@pytest.mark.parametrize(("kind", "dim"), KINDS)
def test_what_a_loop_holds(kind, dim):
    """Closed loops, seen in the poses of their frames."""
    model, q = hung(kind, dim)
    T = poses(model, q)
    A, B = T["A"], T["B"]
    R, r = A[:3, :3].T @ B[:3, :3], A[:3, :3].T @ (B[:3, 3] - A[:3, 3])
    axis = np.array([*model.loops[0].axis, 0.0][:3]) if model.loops[0].axis else np.zeros(3)
    if kind in ("revolute", "universal", "spherical", "point", "fixed"):
        close(r, np.zeros(3), 1e-12, 1.0)
    if kind == "distance":
        close(np.linalg.norm(r), 0.7, 1e-12)
    if kind == "prismatic":
        close(np.cross(axis, r), np.zeros(3), 1e-12, 1.0)
        assert abs(axis @ r) > 1e-3
    if kind in ("prismatic", "fixed"):
        close(R, np.eye(3), 1e-12)
    if kind == "revolute" and dim == 3:
        close(R @ axis, axis, 1e-12)
        assert np.abs(R - np.eye(3)).max() > 1e-3
    if kind == "universal":
        close(R[0, 1], 0.0, 1e-12, 1.0)  # x of A across y of B
    held = HELD[dim][kind]
    assert model.tree.constraints == held
    found = fb.mobility(model, q)
    freedom = 6 if dim == 3 else 3
    assert found.gruebler == found.instantaneous == found.generic == freedom - held


def hung(kind: str, dim: int) -> tuple[fb.Model, np.ndarray]:
    """A free body whose frame B is held against frame A of the ground by a loop, and a closed
    position of it."""
    rng = np.random.default_rng([dim, *kind.encode()])
    model = loaded(
        Robot(
            "hung",
            dim,
            (Link("ground"), Link("body", random_inertia(rng, dim))),
            (Joint("free", "free" if dim == 3 else "planar", "ground", "body"),),
            9.81,
            (
                Mount("A", "ground", random_placement(rng, dim, True)),
                Mount("B", "body", random_placement(rng, dim, True)),
            ),
        )
    )
    axis = tuple(rng.normal(size=dim)) if (str(kind), dim) in HAVE_AXIS else ()
    model = model.with_loop(
        "hold", kind, ("A", "B"), axis=axis, distance=0.7 if kind == "distance" else None
    )
    return model, fb.assemble(model, fb.random_state(model, 3)[0])


@pytest.mark.sample(1)
@pytest.mark.parametrize("dim", [2, 3])
def test_a_joint_and_its_loop(dim):
    """A body on a pin, and the same body free with a loop of that kind: the multipliers are the
    pin's wrench."""
    for kind in ("revolute", "prismatic", "fixed", *(("universal", "spherical")[: 2 * (dim - 2)])):
        model, q = hung(kind, dim)
        qd = fb.loop_velocity(model, q, np.random.default_rng(1).normal(size=model.nv))
        found = fb.reactions(model, q, qd, tau=np.zeros(model.nv))
        assert found.balance < 1e-12
        assert found.determined.all()
        if kind == "universal":  # and no moment about either axis
            T = poses(model, q)
            close(T["A"][:3, 0] @ found["hold"][3:], 0.0, 1e-9, 1.0)
            close(T["B"][:3, 1] @ found["hold"][3:], 0.0, 1e-9, 1.0)
        if kind in ("revolute", "spherical"):  # and no moment about the axis
            turning = found["hold"][dim:]
            R = poses(model, q)["A"][:3, :3]
            if dim == 2 or kind == "spherical":
                close(turning, 0 * turning, 1e-9, 1.0)
            else:
                close((R @ model.loops[0].axis) @ turning, 0.0, 1e-9, 1.0)
        if kind == "prismatic":
            along = poses(model, q)["A"][:dim, :dim] @ model.loops[0].axis
            close(along @ found["hold"][:dim], 0.0, 1e-9, 10.0)


def test_the_tension_of_a_rod_is_its_multiplier():
    model, q = hung("distance", 2)
    qd = fb.loop_velocity(model, q, [0.3, -0.2, 0.5])
    found = fb.reactions(model, q, qd, tau=[0, 0, 0])
    close(np.linalg.norm(found["hold"][:2]), abs(found.multipliers[0]), 1e-12)
    T = poses(model, q)
    r = (T["B"] - T["A"])[:2, 3]
    close(found["hold"][:2], -found.multipliers[0] * r / 0.7, 1e-12)  # λ > 0 pulls B towards A
