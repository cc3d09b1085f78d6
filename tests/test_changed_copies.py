"""A changed copy of a model takes over what is known of the pieces that stay: the same bits as
found anew."""

from __future__ import annotations

import gc
import pickle
import weakref
from collections.abc import Callable

import numpy as np
import pytest

import freebody as fb
from freebody.errors import FreebodyError, MissingValueError
from freebody.model.placement import Placement, Shift
from freebody.model.places import get, put_at
from support import generate

ROBOTS: dict[str, Callable[[], fb.Model]] = {
    "ur5e": lambda: fb.load("ur5e"),
    "four_bar": lambda: fb.load("four_bar"),
    "random, in space": lambda: generate.model(4, 3),
    "random, in the plane": lambda: generate.model(3, 2),
}


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


@pytest.mark.parametrize("name", ROBOTS)
def test_numbers_and_structure_are_those_found_anew(name: str):
    rng = np.random.default_rng(7)
    start, inherited = ROBOTS[name](), 0
    met = [start]
    for _ in range(120):
        model = changed(met[rng.integers(len(met))], rng)
        met.append(model if rng.random() < 0.9 else start)
        if rng.random() < 0.7:  # others stay unread, as copies of copies are
            inherited += "made from" in model.__dict__
            anew = pickle.loads(pickle.dumps(model))
            assert model.structure is anew.structure
            assert model.numbers.tobytes() == anew.numbers.tobytes()
            assert model.numbers.shape == anew.numbers.shape
    assert inherited > 20


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
    met = [weakref.ref(model)]
    for k in range(30):
        model = model.bind({"forearm_link.mass": 1.0 + k})
        if k == 10:
            fb.inverse_dynamics(model, *fb.random_state(model, 1))
        met.append(weakref.ref(model))
    assert (
        sum(ref() is not None for ref in met) == 2
    )  # the last, and the one whose numbers are known
    fb.inverse_dynamics(model, *fb.random_state(model, 1))
    gc.collect()
    assert sum(ref() is not None for ref in met) == 1


def test_a_value_that_is_missing_is_named_though_the_origin_had_it():
    model = fb.planar("RR", l=[1, 1], lc=[0.5, 0.5], m=[1, 1], I=[0.1, 0.1])
    fb.inverse_dynamics(model, [0.1, 0.2], [0.0, 0.0], [0.0, 0.0])
    loaded = model.with_payload(fb.Inertia.of("load", (0.0, 0.0), 0.0))
    with pytest.raises(MissingValueError, match="load"):
        fb.inverse_dynamics(loaded, [0.1, 0.2], [0.0, 0.0], [0.0, 0.0])


def test_what_was_one_object_at_several_places_is_one_again():
    twice = Shift((1.0, 2.0, 3.0))
    things = (Placement((twice,)), (Placement((twice, twice)), twice), Shift((1.0, 5.0, 6.0)))
    first, again, other = (0, "steps", 0, "by", 0), (1, 1, "by", 0), (2, "by", 0)
    found = put_at(things, (first, (1, 0, "steps", 1, "by", 0), again, other), 7.0)
    assert found == (
        Placement((Shift((7.0, 2.0, 3.0)),)),
        (Placement((twice, Shift((7.0, 2.0, 3.0)))), Shift((7.0, 2.0, 3.0))),
        Shift((7.0, 5.0, 6.0)),
    )
    assert get(found, first[:3]) is get(found, again[:2])
    assert things[0].steps[0] is twice
    assert twice.by == (1.0, 2.0, 3.0)


def test_one_object_reached_in_two_ways_is_changed_in_each_way():
    shared = Shift((1.0, 2.0, 3.0))
    found = put_at((shared, shared), ((0, "by", 0), (1, "by", 1)), 7.0)
    assert found == (Shift((7.0, 2.0, 3.0)), Shift((1.0, 7.0, 3.0)))


def test_a_frame_and_the_inertia_in_it_keep_one_placement_when_a_length_changes():
    arm = fb.load("ur5e").bind({"elbow_joint.a": -0.5})
    (part,) = arm.bodies[2].inertias
    assert [frame.placement is part.placement for frame in arm.frames].count(True) == 1
    assert part.placement.steps[1] is arm.bodies[3].joint.placement.steps[1]
