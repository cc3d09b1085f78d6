"""Closed chains of many kinds against their parts' own equations of motion, constraints by singular
values."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
import pytest

import freebody as fb
from freebody import Model
from support.closed_chains import GROUND, Mechanism, Pin, built, drives, homogeneous, moving
from support.generate import random_inertia
from support.helpers import all_driven, close, numbers
from support.maximal import accelerations

pytestmark = pytest.mark.usefixtures("numpy_kernels")

Z, X, Y = (0.0, 0.0, 1.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)
Row = tuple[str, str, str, Sequence[float]]
"""(kind, part, part, place) and in the plane for slides, in space for pins and slides, an axis."""


def mechanism(name: str, dim: int, rows: Sequence[tuple], driven: Sequence[str]) -> Mechanism:
    """At rest all parts' frames are the world's; a pin is called after its parts."""
    pins, parts = [], {}
    rng = np.random.default_rng([ord(x) for x in name])
    for kind, a, b, at, *more in rows:
        for part in (a, b):
            if part != GROUND and part not in parts:
                parts[part] = random_inertia(rng, dim)
        T = homogeneous(np.eye(dim), at)
        axis = (
            tuple(more[0])
            if more and kind != "distance"
            else ((1.0,) if kind == "revolute" else ())
        )
        length = float(more[0]) if kind == "distance" else None
        T_a = homogeneous(np.eye(dim), more[1]) if kind == "distance" else T
        pins.append(Pin(f"{a}_{b}", kind, a, T_a, b, T, axis, length))
    gravity = (0.0, -9.81) if dim == 2 else (0.3, -0.2, -9.81)
    return Mechanism(dim, parts, tuple(pins), gravity, tuple(driven), name)


def watt() -> Mechanism:
    return mechanism("watt", 2, [
        ("revolute", GROUND, "crank", (0, 0)), ("revolute", "crank", "coupler", (0.3, 0.4)),
        ("revolute", GROUND, "rocker", (0.9, 0)), ("revolute", "coupler", "rocker", (1.0, 0.8)),
        ("revolute", "rocker", "link", (1.4, 0.5)), ("revolute", GROUND, "output", (2.0, 0)),
        ("revolute", "link", "output", (1.9, 0.9)),
    ], ["ground_crank"])  # fmt: skip


def stephenson() -> Mechanism:
    return mechanism("stephenson", 2, [
        ("revolute", GROUND, "crank", (0, 0)), ("revolute", "crank", "coupler", (0.2, 0.3)),
        ("revolute", GROUND, "rocker", (1.0, 0.1)), ("revolute", "coupler", "rocker", (1.1, 0.9)),
        ("revolute", "coupler", "link", (0.6, 1.2)), ("revolute", GROUND, "output", (1.6, -0.2)),
        ("revolute", "link", "output", (1.8, 0.8)),
    ], ["ground_crank"])  # fmt: skip


def offset_slider_crank() -> Mechanism:
    return mechanism("slider", 2, [
        ("revolute", GROUND, "crank", (0, 0)), ("revolute", "crank", "rod", (0.2, 0.25)),
        ("revolute", "rod", "piston", (1.0, 0.15)),
        ("prismatic", GROUND, "piston", (1.0, 0.15), (0.8, 0.6)),
    ], ["ground_crank"])  # fmt: skip


def three_rpr() -> Mechanism:
    rows = []
    for k, (base, top) in enumerate(
        [((0, 0), (0.4, 0.5)), ((1.2, 0.1), (0.8, 0.5)), ((0.5, 1.4), (0.6, 0.8))]
    ):
        way = np.subtract(top, base) / np.linalg.norm(np.subtract(top, base))
        rows += [
            ("revolute", GROUND, f"lower{k}", base),
            ("prismatic", f"lower{k}", f"upper{k}", base, way),
            ("revolute", f"upper{k}", "platform", top),
        ]  # fmt: skip
    return mechanism("3RPR", 2, rows, [f"lower{k}_upper{k}" for k in range(3)])


def scissor_lift() -> Mechanism:
    return mechanism("lift", 2, [
        ("revolute", GROUND, "a1", (0, 0)), ("prismatic", GROUND, "cart", (0.8, 0), (1.0, 0.0)),
        ("revolute", "cart", "b1", (0.8, 0)), ("revolute", "a1", "b1", (0.4, 0.3)),
        ("revolute", "a1", "b2", (0.8, 0.6)), ("revolute", "b1", "a2", (0, 0.6)),
        ("revolute", "a2", "b2", (0.4, 0.9)), ("revolute", "a2", "top", (0.8, 1.2)),
        ("prismatic", "top", "shoe", (0.0, 1.2), (1.0, 0.0)),
        ("revolute", "b2", "shoe", (0.0, 1.2)),
    ], ["ground_cart"])  # fmt: skip


def rods() -> Mechanism:
    """A plate on three rods, one of which is but a distance."""
    return mechanism("rods", 2, [
        ("revolute", GROUND, "one", (0, 0)), ("revolute", "one", "plate", (0.1, 0.7)),
        ("distance", GROUND, "plate", (0.8, 0.8), float(np.hypot(0.2, 0.8)), (1.0, 0.0)),
    ], ["ground_one"])  # fmt: skip


def parallelogram() -> Mechanism:
    """With a third crank: one equation is redundant."""
    return mechanism("three cranks", 2, [
        row for k in range(3) for row in (
            ("revolute", GROUND, f"crank{k}", (float(k), 0)),
            ("revolute", f"crank{k}", "plate", (k + 0.3, 0.6)),
        )
    ], ["ground_crank0"])  # fmt: skip


def floating() -> Mechanism:
    """A four-bar that nothing holds."""
    return mechanism("floating", 3, [
        ("free", GROUND, "base", (0, 0, 0)),
        ("revolute", "base", "crank", (0, 0, 0), Z),
        ("spherical", "crank", "coupler", (0.3, 0.4, 0.1)),
        ("revolute", "base", "rocker", (0.9, 0, 0), Z),
        ("spherical", "rocker", "coupler", (1.0, 0.8, 0.1)),
    ], ["base_crank"])  # fmt: skip


def spherical_four_bar() -> Mechanism:
    """All axes through one point: three equations are redundant."""
    axes = [(0, 0, 1.0), (0.3, 0.2, 1.0), (0.9, 0.3, 1.0), (1.2, -0.2, 1.0)]
    units = [np.array(x) / np.linalg.norm(x) for x in axes]
    return mechanism("spherical four-bar", 3, [
        ("revolute", GROUND, "crank", (0, 0, 0), units[0]),
        ("revolute", "crank", "coupler", (0, 0, 0), units[1]),
        ("revolute", "coupler", "rocker", (0, 0, 0), units[2]),
        ("revolute", GROUND, "rocker", (0, 0, 0), units[3]),
    ], ["ground_crank"])  # fmt: skip


def sarrus() -> Mechanism:
    """Two pairs of links with crossed axes: a table that goes up and down; one equation is
    redundant."""
    return mechanism("sarrus", 3, [
        ("revolute", GROUND, "a", (1, 0, 0), Y), ("revolute", "a", "b", (1.4, 0, 0.5), Y),
        ("revolute", "b", "table", (1, 0, 1), Y), ("revolute", GROUND, "c", (0, 1, 0), X),
        ("revolute", "c", "d", (0, 1.3, 0.5), X), ("revolute", "d", "table", (0, 1, 1), X),
    ], ["ground_a"])  # fmt: skip


def delta() -> Mechanism:
    rows = []
    for k in range(3):
        out = np.array([np.cos(2.1 * k), np.sin(2.1 * k), 0.0])
        side = np.array([-out[1], out[0], 0.0])
        rows.append(("revolute", GROUND, f"arm{k}", 0.2 * out, side))
        for name, sign in ("left", 0.05), ("right", -0.05):
            elbow, foot = (
                0.5 * out + [0, 0, -0.1] + sign * side,
                0.1 * out + [0, 0, -0.7] + sign * side,
            )
            rows += [
                ("spherical", f"arm{k}", f"{name}{k}", elbow),
                ("spherical", f"{name}{k}", "platform", foot),
            ]  # fmt: skip
    return mechanism("delta", 3, rows, [f"ground_arm{k}" for k in range(3)])


def hexapod(size: float) -> Mechanism:
    """Legs of two parts on balls, of any size (m)."""
    rng, rows = np.random.default_rng(8), []
    for k in range(6):
        base = np.array([np.cos(k), np.sin(1.1 * k), 0.1 * rng.normal()])
        top = np.array([0.6 * np.cos(k + 0.5), 0.5 * np.sin(k + 0.4), 1.0 + 0.1 * rng.normal()])
        way = (top - base) / np.linalg.norm(top - base)
        rows += [
            ("spherical", GROUND, f"lower{k}", size * base),
            ("prismatic", f"lower{k}", f"upper{k}", size * base, way),
            ("spherical", f"upper{k}", "platform", size * top),
        ]  # fmt: skip
    return mechanism(f"hexapod {size}", 3, rows, [f"lower{k}_upper{k}" for k in range(6)])


MECHANISMS: dict[str, Callable[[], Mechanism]] = {
    f.__name__: f
    for f in (
        watt, stephenson, offset_slider_crank, three_rpr, scissor_lift, rods, parallelogram,
        floating,
        spherical_four_bar, sarrus, delta,
    )
} | {"small hexapod": lambda: hexapod(0.02), "large hexapod": lambda: hexapod(30.0)}  # fmt: skip


def spanning(told: Mechanism, last_first: bool) -> Model:
    """The model whose tree is made of the first pins that connect all parts, or of the last
    ones."""
    group, chosen = {name: name for name in (GROUND, *told.parts)}, []
    for pin in told.pins[::-1] if last_first else told.pins:
        old, new = group[pin.a], group[pin.b]
        if old != new and pin.kind != "distance":
            chosen.append(pin.name)
            group = {name: new if g == old else g for name, g in group.items()}
    return built(told, chosen)


OTHERS = [
    pytest.param(
        name,
        last_first,
        marks=[pytest.mark.long] if last_first == (k % 2 == 0) or name == "large hexapod" else [],
    )
    for k, name in enumerate(MECHANISMS)
    for last_first in (False, True)
]
"""Of each mechanism one spanning tree, and the other one when there is time."""


def states(model: Model, samples: int = 4) -> tuple[np.ndarray, np.ndarray]:
    """Closed ones about the place of rest."""
    rng = np.random.default_rng(6)
    home = fb.assemble(model, fb.neutral(model))
    way = 0.1 * fb.loop_velocity(model, home, rng.normal(size=(samples, model.nv)))
    q = fb.assemble(model, fb.integrate(model, home, way))
    return q, fb.loop_velocity(model, q, rng.normal(size=(samples, model.nv)))


@pytest.mark.sample(1)
@pytest.mark.parametrize(("name", "last_first"), OTHERS)
def test_parts_move_by_their_own_equations(name: str, last_first: bool):
    """Under torques of the drives and a load; a batch is its samples, to the last bit."""
    told = MECHANISMS[name]()
    model = spanning(told, last_first)
    q, qd = states(model)
    rng = np.random.default_rng(7)
    part = list(told.parts)[-1]
    load = rng.normal(size=6 if told.dim == 3 else 3)
    samples = []
    for k in range(len(q)):
        state = moving(told, model, q[k], qd[k])
        torques = {pin: float(rng.normal()) for pin in told.driven}
        expected = accelerations(told, state, torques, {part: load})
        tau, wrenches = drives(told, model, state, torques)
        wrenches[f"{part}@"] = wrenches.get(f"{part}@", 0.0) + load
        found = fb.forward_dynamics(model, q[k], qd[k], tau, wrenches)
        bodies = [
            numbers(model, "acceleration", q[k], qd[k], found, frame=f"{x}@") for x in told.parts
        ]
        close(np.array(bodies), expected, 1e-9, 1.0 + np.abs(expected).max())
        samples.append((tau, wrenches, found))
    tau, qdd = np.array([x[0] for x in samples]), np.array([x[2] for x in samples])
    loads = {frame: np.array([x[1][frame] for x in samples]) for frame in samples[0][1]}
    np.testing.assert_array_equal(fb.forward_dynamics(model, q, qd, tau, loads), qdd)


@pytest.mark.sample(1)
@pytest.mark.parametrize(
    "name", ["watt", "scissor_lift", "parallelogram", "sarrus", "spherical_four_bar"]
)
def test_forces_say_what_motions_do(name: str):
    """Of drives that force every motion: torques of a motion cause it, and those that hold let
    nothing begin."""
    model = all_driven(spanning(MECHANISMS[name](), True))
    q, qd = states(model)
    qdd = fb.loop_acceleration(model, q, qd, np.ones(model.nv))
    tau = fb.inverse_dynamics(model, q, qd, qdd)
    size = 1.0 + np.abs(qdd).max()
    close(fb.forward_dynamics(model, q, qd, tau), qdd, 1e-9, size)
    found = fb.reactions(model, q, qd, qdd=qdd)
    assert found.balance < 1e-9
    close(found.tau, tau, 1e-9, 1.0 + np.abs(tau).max())
    held = fb.forward_dynamics(model, q, 0.0 * qd, fb.static_torque(model, q))
    close(held, 0.0 * held, 1e-9, size)


def test_a_family_of_a_rounded_machine():
    """Three cranks, the last pivot a little off: every sample takes the careful way, of each member
    its own."""
    exact = all_driven(spanning(parallelogram(), False))
    place = "ground_crank2.placement.x"
    model = exact.bind({place: fb.parameters(exact)[place].value + 2e-4})
    assert fb.mobility(model, fb.assemble(model, fb.neutral(model))).misfit[0] > 1e-5
    q, qd = states(model, 2)
    frame, load = "plate@", np.array([1.0, 2.0, 0.5])
    family = model.with_payload(mass=np.array([0.0, 1.0, 4.0]), frame=frame)
    wrenches = {frame: load}
    for call in (
        lambda m, q, qd: fb.forward_dynamics(m, q, qd, 0.0 * qd, wrenches),
        lambda m, q, qd: fb.static_torque(m, q, wrenches),
        lambda m, q, qd: fb.reactions(m, q, qd, tau=0.0 * qd, wrenches=wrenches).wrenches,
    ):
        found = call(family, q[:, None], qd[:, None])
        for k in range(3):
            expected = call(family[k], q, qd)
            close(found[:, k], expected, 1e-12, 1.0 + np.abs(expected).max())
