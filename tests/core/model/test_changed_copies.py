"""A changed copy of a model of which much is known: the same model, to the last bit, as one of a
model of which nothing is."""

from __future__ import annotations

import copy
import pickle
import tempfile
import weakref
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path
from threading import Barrier

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import freebody as fb
from freebody import FreebodyError, MissingValueError
from support import generate
from support.robots import Joint, Link, Robot, loaded, shift

ROBOTS: dict[str, Callable[[], fb.Model]] = {
    "ur5e": lambda: fb.load("ur5e"),
    "four_bar": lambda: fb.load("four_bar"),
    "random, in space": lambda: generate.model(4, 3),
    "random, in the plane": lambda: generate.model(3, 2),
    "a joint with a number of its own": lambda: screw(),
}


def screw() -> fb.Model:
    """A helical joint, whose pitch is a number, that carries a link on a revolute one."""
    heavy = fb.Inertia.box(2.0, (0.1, 0.2, 0.3)).moved_to((0.1, 0.0, 0.02))
    turn = Joint(
        "turn",
        "helical",
        "base",
        "nut",
        shift(0.1, 0.0, 0.2),
        axis=(0.0, 0.0, 1.0),
        numbers=(0.01,),
    )
    elbow = Joint("elbow", "revolute", "nut", "arm", shift(0.3, 0.0, 0.0), axis=(0.0, 1.0, 0.0))
    links = (Link("base"), Link("nut", heavy), Link("arm", heavy))
    return loaded(Robot("screw", 3, links, (turn, elbow), (9.81, (0.0, 0.0, -1.0))))


def changed(model: fb.Model, rng: np.random.Generator) -> fb.Model:
    """A copy with something else: what leaves the structure as it is, what makes another, what
    makes a family."""
    x = float(rng.uniform(0.1, 0.5))
    joint, frame = rng.choice(model.joint_names), rng.choice(model.frame_names)
    usual = [r.name for r in fb.parameters(model) if not r.limit and ".inertia." not in r.name]
    number, g = (
        str(rng.choice(usual)),
        next(r.name for r in fb.parameters(model) if r.unit == "m/s²"),
    )
    ways = [
        lambda: model.with_payload(mass=x, com=(x,) * model.dim, frame=frame, name=f"load {x}"),
        lambda: model.bind({number: x}),
        lambda: model.bind({number: x}),
        lambda: model.bind({number: 0.0}),
        lambda: model.bind({number: np.array([x, 2.0 * x])}),
        lambda: model.bind({g: x}),
        lambda: model.with_drive(joint, viscous=rng.choice([0.0, x])),
        lambda: model.without("friction"),
        lambda: model.with_frame(f"frame {x}", (x,) * model.dim, frame=frame),
        lambda: model[0] if model.family else model.without("springs", "rotors"),
    ]
    try:
        return ways[rng.integers(len(ways))]()
    except FreebodyError:  # no one-axis joint, no rigid body, a placement of its own
        return model


def is_edited(model: fb.Model) -> bool:
    """Whether its numbers were found before its pieces."""
    return "_edits" in model.__dict__


@pytest.mark.sample(1)
@pytest.mark.parametrize("name", ROBOTS)
def test_numbers_and_structure_are_those_found_anew(name: str):
    rng = np.random.default_rng(7)
    start, edited = ROBOTS[name](), 0
    met = [start]
    for _ in range(120):
        model = changed(met[rng.integers(len(met))], rng)
        met.append(model if rng.random() < 0.9 else start)
        if rng.random() < 0.7:  # others stay unread, as copies of copies are
            edited += is_edited(model)
            numbers = model.numbers if rng.random() < 0.5 else None  # or the pieces first
            anew = pickle.loads(pickle.dumps(model))
            assert numbers is None or numbers is model.numbers
            assert model.structure is anew.structure
            assert model.numbers.tobytes() == anew.numbers.tobytes()
            assert model.numbers.shape == anew.numbers.shape
    assert edited > 10


def outcome(change: Callable[[fb.Model], fb.Model], model: fb.Model) -> fb.Model | str:
    """The changed copy, or what was said instead."""
    try:
        return change(model)
    except FreebodyError as error:
        return f"{type(error).__name__}: {error}"


def same(change: Callable[[fb.Model], fb.Model], known: fb.Model) -> bool:
    """Holds a changed copy of a model whose numbers are known against one of a model of which
    nothing is; whether it was edited."""
    quick, anew = outcome(change, known), outcome(change, pickle.loads(pickle.dumps(known)))
    if isinstance(anew, str):
        assert quick == anew
        return False
    assert isinstance(quick, fb.Model)
    edited = is_edited(quick)
    if quick is not known:
        assert quick.structure is anew.structure
        assert quick.numbers.tobytes() == anew.numbers.tobytes()
    assert quick == anew
    assert repr(quick) == repr(anew)
    assert pickle.loads(pickle.dumps(quick)) == anew
    return edited


@pytest.mark.sample(1)
@pytest.mark.parametrize("name", ROBOTS)
def test_each_number_is_changed_as_in_a_model_of_which_nothing_is_known(name: str):
    model = ROBOTS[name]()
    assert model.numbers.size
    records = [r for r in fb.parameters(model) if not r.limit][::3]
    edited = {r.name: same(lambda m, r=r: m.bind({r.name: 0.37}), model) for r in records}
    assert sum(edited.values()) > 0.25 * len(records)
    for r in records[:: max(1, len(records) // 8)]:
        for value in (0.0, -0.2, 3, np.float64(0.3), r.value, np.nan, 1e70, "l", True):
            same(lambda m, r=r, value=value: m.bind({r.name: value}), model)


def test_a_right_angle_or_a_length_that_comes_or_goes_is_another_structure():
    model = fb.load("ur5e")
    model.numbers
    for length in (0.3, 0.0, -0.2, 0.0):
        for before in (
            model,
            model.bind({"elbow_joint.d": 0.1}),
            model.bind({"elbow_joint.a": 0.0}),
        ):
            same(lambda m, x=length: m.bind({"elbow_joint.a": x}), before)
            same(lambda m, x=length: m.bind({"elbow_joint.d": x, "wrist_1_joint.a": x}), before)
    assert model.bind({"elbow_joint.a": 0.0}).structure is not model.structure
    assert model.bind({"elbow_joint.a": 0.1}).structure is model.structure


def test_rows_of_changes_are_those_of_a_model_of_which_nothing_is_known():
    model, load = fb.load("ur5e"), fb.Inertia.box(2.0, (0.1, 0.2, 0.3))
    model.numbers
    changes: list[Callable[[fb.Model], fb.Model]] = [
        lambda m: m.bind({"forearm_link.mass": 3.0}).bind({"elbow_joint.a": -0.3}),
        lambda m: m.bind({"elbow_joint.a": -0.3}).bind({"elbow_joint.a": -0.392}),
        lambda m: m.with_payload(load).bind({"payload.com.x": 0.2, "forearm_link.mass": 1.0}),
        lambda m: m.bind({"elbow_joint.a": -0.3}).with_payload(load, frame="frame3"),
        lambda m: m.bind({"gravity": 1.6}).with_payload(mass=1.0).with_payload(mass=2.0),
        lambda m: m.bind({"elbow_joint.a": -0.3, "payload.mass": 2.0, "payload.com.z": 0.1}),
        lambda m: m.bind({"payload.com.z": 0.1}).bind({"payload.mass": 2.0}),
        lambda m: m.bind({"g": 1.6}).bind({"payload.mass": 2.0}),
        lambda m: m.bind({"g": 1.6, "payload.mass": 2.0}),
        lambda m: m.bind({"payload.mass": 0.0}),
        lambda m: m.with_payload(mass=0.0),
        lambda m: m.with_payload(mass=1.0, frame="nowhere"),
        lambda m: m.with_payload(mass=1.0, frame=["frame3"]),
        lambda m: m.with_drive(["elbow_joint"], rest=0.1),
        lambda m: m.with_payload(fb.Inertia(1.0, (0.0,) * 3, (1.0, 0.0, 0.0, 1.0, 0.0, 5.0))),
        lambda m: m.with_payload(fb.Inertia.point(1.0, (0.0, 0.0))),
        lambda m: m.bind({"forearm_link.mass": 3.0, ("forearm_link", "mass"): 2.0}),
        lambda m: m.bind({"g": 3.0, "gravity": 2.0}),
        lambda m: m.bind({"gravity": 2.0}).bind(g=3.0),
        lambda m: m.bind({"forearm_link.mass": 3.0}).bind({"forearm_link.scale": 2.0}),
        lambda m: m.bind({"forearm_link.scale": 2.0}).bind({"forearm_link.scale": 2.0}),
        lambda m: m.bind({"elbow_joint.alpha": 0.3}).bind({"elbow_joint.a": 0.4}),
        lambda m: m.bind({"elbow_joint.a": 0.4}).bind({"elbow_joint.alpha": 0.3}),
        lambda m: m.with_drive("elbow_joint", viscous=0.1).with_drive("elbow_joint", gear=3.0),
        lambda m: m.with_drive("elbow_joint", rest=0.1),
        lambda m: m.bind({"elbow_joint.a": -0.3}).bind({"forearm_link.mass": [1.0, 2.0]})[1],
        lambda m: m.bind({"elbow_joint.a": -0.3}).without("friction").bind({"elbow_joint.d": 0.1}),
    ]
    edited = 0
    for driven in (model, model.with_drive("elbow_joint", viscous=0.3)):
        driven.numbers
        for _ in range(3):  # a load is edited in when it has been asked for before
            edited = sum(same(change, driven) for change in changes)
    assert edited > 10
    named = model.bind({"elbow_joint.a": -0.3}).with_payload(load)
    assert is_edited(named)
    assert is_edited(model.bind({"g": 1.6, "payload.mass": 2.0}))
    assert fb.parameters(named) == fb.parameters(pickle.loads(pickle.dumps(named)))


def test_calls_of_an_edited_copy_look_at_none_of_its_pieces():
    model = fb.load("ur5e")
    state = fb.random_state(model, 1)
    fb.inverse_dynamics(model, *state), fb.forward_dynamics(model, *state)
    for change in (
        lambda: model.bind({"elbow_joint.a": -0.3}),
        lambda: model.bind({"elbow_joint.a": -0.3}).bind({"forearm_link.mass": 1.0}),
        lambda: model.with_payload(mass=2.0),
        lambda: model.bind({"gravity": 2.0}),
    ):
        change(), change()
        copy = change()
        tau = fb.inverse_dynamics(copy, *state)
        np.testing.assert_allclose(fb.forward_dynamics(copy, *state[:2], tau), state[2], atol=1e-9)
        assert "bodies" not in copy.__dict__
        assert copy.frame().name == model.frame().name
        assert fb.inverse_dynamics(copy, *state).tobytes() == tau.tobytes()


def test_threads_that_look_at_a_copy_see_the_same_pieces():
    model = fb.load("ur5e")
    model.numbers
    for k in range(20):
        copy, start = model.bind({"elbow_joint.a": -0.3 - 0.01 * k}), Barrier(8)

        def look(name: str, copy: fb.Model = copy, start: Barrier = start) -> object:
            start.wait()
            return getattr(copy, name)

        with ThreadPoolExecutor(8) as pool:
            found = list(pool.map(look, ["bodies", "frames"] * 4))
        assert {id(x) for x in found} == {id(copy.bodies), id(copy.frames)}
        (part,) = copy.bodies[2].inertias
        assert any(frame.placement is part.placement for frame in copy.frames)


def test_an_edited_copy_has_no_other_attributes_than_a_model():
    model = fb.load("ur5e")
    model.numbers
    copied = copy.copy(model.bind({"elbow_joint.a": -0.3}))
    assert copied == model.bind({"elbow_joint.a": -0.3})
    assert replace(model.bind({"elbow_joint.a": -0.3}), name="other") == copied
    for thing in (model, model.bind({"elbow_joint.a": -0.3}), object.__new__(fb.Model)):
        with pytest.raises(AttributeError, match="'Model' object has no attribute 'bodie'"):
            thing.bodie
    with pytest.raises(AttributeError, match="'bodies'"):
        object.__new__(fb.Model).bodies


def test_the_first_copy_lends_its_numbers_to_the_next():
    model = fb.load("ur5e")
    q = np.zeros(6)
    taus = [fb.inverse_dynamics(model.with_payload(mass=m), q, q, q) for m in (1.0, 2.0, 3.0)]
    np.testing.assert_allclose(taus[2] - taus[1], taus[1] - taus[0], atol=1e-12)
    assert np.abs(taus[1] - taus[0]).max() > 1.0
    np.testing.assert_allclose(
        fb.inverse_dynamics(model, q, q, q), 2.0 * taus[0] - taus[1], atol=1e-12
    )


def test_a_row_of_changes_keeps_no_row_of_models():
    model = fb.load("ur5e")
    model.numbers
    met = [weakref.ref(model)]
    for k in range(30):
        model = model.bind({"forearm_link.mass": 1.0 + k})
        model = model.bind({"elbow_joint.alpha": 1.0 + k}) if k % 7 == 3 else model
        if k == 10:
            fb.inverse_dynamics(model, *fb.random_state(model, 1))
        met.append(weakref.ref(model))
    assert sum(ref() is not None for ref in met) == 1
    assert model.bodies[2].inertias[0].inertia.mass == 30.0
    rows = weakref.ref(model.__dict__["_layout"].rows)
    assert rows() is not None
    del model
    assert rows() is None  # nothing in it refers back to it


def test_a_value_that_is_missing_is_named_though_the_origin_had_it():
    model = fb.planar("RR", l=[1, 1], lc=[0.5, 0.5], m=[1, 1], I=[0.1, 0.1])
    fb.inverse_dynamics(model, [0.1, 0.2], [0.0, 0.0], [0.0, 0.0])
    loaded = model.with_payload(fb.Inertia.of("load", (0.0, 0.0), 0.0))
    with pytest.raises(MissingValueError, match="load"):
        fb.inverse_dynamics(loaded, [0.1, 0.2], [0.0, 0.0], [0.0, 0.0])


def test_a_frame_and_the_inertia_in_it_keep_one_placement_when_a_length_changes():
    arm = fb.load("ur5e").bind({"elbow_joint.a": -0.5})
    (part,) = arm.bodies[2].inertias
    assert [frame.placement is part.placement for frame in arm.frames].count(True) == 1
    assert part.placement.steps[1] is arm.bodies[3].joint.placement.steps[1]


@pytest.mark.parametrize("pitch", [np.pi / 2, -np.pi / 2])
@pytest.mark.parametrize("roll", [0.4, -2.5])
def test_angles_of_an_upright_placement_are_its_own(pitch: float, roll: float):
    """Where pitch is a right angle, roll and yaw turn about one line: the roll has it all."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "r.toml"
        file.write_text(
            'name = "r"\ndim = 3\n[[link]]\nname = "ground"\n[[link]]\nname = "arm"\nmass = 1\n'
            'com = [0.1, 0, 0]\ninertia = [0.02, 0, 0, 0.03, 0, 0.03]\n[[joint]]\nname = "j"\n'
            'kind = "revolute"\nparent = "ground"\nchild = "arm"\naxis = "z"\n'
            f"origin = [0.1, 0.2, 0.3]\nrpy = [{roll}, {pitch!r}, 0.3]\n"
        )
        model = fb.load(file)
    numbers = {row.name: row.value for row in fb.parameters(model)}
    angles = {name: float(numbers[f"j.placement.{name}"]) for name in ("roll", "pitch", "yaw")}
    again = model.bind({f"j.placement.{name}": x + 0.0 for name, x in angles.items()})
    x, y, z = (angles[name] for name in ("roll", "pitch", "yaw"))
    R = Rotation.from_euler("xyz", [x, y, z]).as_matrix()
    for robot in (model, again):
        T = fb.forward_kinematics(robot, [0.0], frame="arm")
        np.testing.assert_allclose(T[:3, :3], R, atol=1e-9)
