"""Which joints move no inertia: the quick verdict agrees with what a look at the mass matrix
finds."""

from __future__ import annotations

import numpy as np
import pytest

import freebody as fb
from freebody import (
    SingularError,
)
from freebody.trees import special_joints
from support import generate


def in_full(model: fb.Model, monkeypatch: pytest.MonkeyPatch) -> tuple[str, ...]:
    """The verdict without the quick one."""
    with monkeypatch.context() as patch:
        patch.setattr(special_joints, "_all_sound", lambda model: False)
        return special_joints.massless(fb.Model(**model.__getstate__()))


def arm(rng: np.random.Generator) -> fb.Model:
    """An arm of bars, points and bodies without mass, of very different sizes, with rotors here and
    there."""
    rows = []
    solid = rng.random() < 0.5
    for _ in range(4):
        size, a = 10.0 ** rng.uniform(-7, 1), rng.choice([0.0, 0.3])
        factor = size * (0.1 if solid else rng.choice([0.0, 1e-4, 0.1]))
        tensor = factor * np.array(
            [1.0, 0.0, 0.0, 1.0, 0.0, 1.0 if solid else rng.choice([0.0, 1.0])]
        )
        rows.append(
            {
                "a": a,
                "alpha": rng.choice([0.0, np.pi / 2, 0.4]),
                "m": size * (solid or rng.choice([0.0, 1.0, 1.0])),
            }
            | {
                "com": (rng.choice([-a, -a / 2]), 0.0, 0.0),
                "I": tuple(tensor),
                "joint": rng.choice(["R", "R", "P"]),
            }
            | {"rotor": rng.choice([0.0, 1e-4])}
        )
    return fb.dh(rows, convention="standard", physical="ignore")


def test_the_quick_verdict_is_never_kinder(monkeypatch):
    rng = np.random.default_rng(2)
    sure = idle = 0
    for _ in range(150):
        model = arm(rng)
        found = in_full(model, monkeypatch)
        sure += special_joints._all_sound(model)
        idle += found != ()
        assert special_joints.massless(model) == found
    assert sure > 20
    assert idle > 20


@pytest.mark.parametrize("seed", range(12))
def test_random_trees_have_the_same_verdict(seed: int, monkeypatch):
    model = generate.model(seed, 2 + seed % 2)
    assert special_joints.massless(model) == in_full(model, monkeypatch)


def test_a_negative_mass_is_looked_at_in_full():
    """Each body alone resists its joint; but the second takes away what the first has."""
    spin = (0.0, 0.0, 0.0, 0.0, 0.0, 0.1)
    rows = [
        {"a": 0.5, "m": 0.0, "I": spin},
        {"a": 0.5, "m": -0.4, "com": (-0.5, 0.0, 0.0), "I": spin},
    ]
    model = fb.dh(rows, convention="standard", physical="ignore")
    assert special_joints.massless(model) == ("joint1",)


def test_a_rotor_that_takes_the_inertia_away_is_seen():
    spin = (0.1, 0.0, 0.0, 0.1, 0.0, 0.1)
    rows = [{"a": 0.5, "m": 2.0, "com": (-0.5, 0.0, 0.0), "I": spin, "rotor": -0.1}]
    model = fb.dh(rows, convention="standard", physical="ignore")
    assert special_joints.massless(model) == ("joint1",)


def test_a_new_payload_is_no_reason_to_lower_the_tree(monkeypatch):
    model = fb.load("ur5e")
    q = np.zeros(6)
    fb.forward_dynamics(model.with_payload(mass=1.0), q, q, q)

    def never(*args: object) -> None:
        raise AssertionError

    monkeypatch.setattr(special_joints, "lower", never)
    loaded = model.with_payload(mass=2.0)
    tau = fb.inverse_dynamics(loaded, q, q, np.ones(6))
    np.testing.assert_allclose(fb.forward_dynamics(loaded, q, q, tau), np.ones(6), rtol=1e-9)


def test_a_payload_of_a_pointlike_last_link_is_seen():
    still = fb.planar("RR", l=[1, 1], lc=[0.5, 0], m=[1, 0], I=[0.1, 0])
    with pytest.raises(SingularError, match="joint2"):
        fb.forward_dynamics(still, [0.1, 0.2], [0.0, 0.0], [0.0, 0.0])
    loaded = still.with_payload(mass=1.0)
    assert np.isfinite(fb.forward_dynamics(loaded, [0.1, 0.2], [0.0, 0.0], [0.0, 0.0])).all()


def refused(model: fb.Model) -> None:
    """Its first joint moves no inertia."""
    state = np.ones((3, model.nv))
    with pytest.raises(SingularError, match="joint 'joint1' moves no inertia"):
        fb.forward_dynamics(model, *state)


def test_a_rod_along_the_axis_of_its_joint_is_seen(tmp_path):
    """All three products of inertia count where the axis is none of the frame's own."""
    file = tmp_path / "rod.toml"
    file.write_text(
        """
        name = "rod"
        link = [
            { name = "base" },
            { name = "rod", mass = 1, com = [0, 0, 0], inertia = [2, -1, -1, 2, -1, 2] },
        ]
        [[joint]]
        name = "joint1"
        kind = "revolute"
        parent = "base"
        child = "rod"
        axis = [1, 1, 1]
        """
    )
    refused(fb.load(file))


def test_what_a_heavy_body_far_away_hides_is_seen():
    """Two joints on one axis: what the first carries alone is lost in the rounding of the rest."""
    refused(
        fb.planar("RRR", l=[0.0, 1e2, 1.0], lc=[0.0] * 3, m=[1e-4, 1.0, 1e6], I=[1e-4, 1.0, 1.0])
    )


def test_a_new_payload_is_seen_to_move_inertia_without_the_mass_matrix(monkeypatch):
    """In a loop over payloads this would take fifty times what the forward dynamics take."""
    arm, q = fb.load("ur5e"), 0.3 * np.ones(6)
    monkeypatch.setattr(special_joints, "crba", None)
    heavy = arm.with_payload(3.0).bind({"forearm_link.mass": 2.5})
    qdd = fb.forward_dynamics(heavy, q, q, q)
    assert fb.inverse_dynamics(heavy, q, q, qdd) == pytest.approx(q, abs=1e-11)


@pytest.mark.parametrize(
    ("model", "usual"),
    [
        (
            fb.planar("RRR", l=[1, 0, 1], lc=[0.5] * 3, m=[1] * 3, I=[0.1] * 3),
            ({"m2": 1.0, "I2": 0.1}, {"m3": 1.0, "I3": 0.1}),
        ),
        (
            fb.planar("RPR", l=[1, 0, 1], lc=[0.5] * 3, m=[1] * 3, I=[0.1] * 3),
            ({"m2": 1.0, "I2": 0.1}, {"m3": 1.0, "I3": 0.1}),
        ),
        (fb.load("ur5e"), ({"forearm_link.scale": 1.0}, {"wrist_3_link.scale": 1.0})),
        (fb.load("quadrotor"), ()),
    ],
    ids=["RRR", "RPR", "ur5e", "quadrotor"],
)
def test_what_bodies_weigh_alone_finds_no_robot_sound_that_is_not(model, usual, monkeypatch):
    """From a usual link to none the verdict is that of the mass matrix, whatever was seen without
    it."""
    assert special_joints._all_sound(model)
    for link in usual:
        for size in (*10.0 ** -np.arange(0.0, 25.0, 2.0), 0.0):
            less = model.bind({name: size * value for name, value in link.items()})
            alone = special_joints._all_sound(less)
            with monkeypatch.context() as without:
                without.setattr(special_joints, "_all_sound", lambda _: False)
                names = special_joints.massless(less)
            assert not (alone and names), (link, size, names)
        assert not alone
