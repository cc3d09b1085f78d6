"""Names of a model's numbers, families of robots, numbers as inputs of kernels, and derivatives by
them."""

from __future__ import annotations

import copy
import functools
import inspect
import pickle
from typing import Any

import numpy as np
import pytest

import freebody as fb
from freebody import MissingValueError
from support import generate
from support.helpers import numbers, raises_own, refused
from support.public_calls import arguments, functions_of_states, public_calls, state

ROBOTS = ("ur5e", "2R", "RP", "iiwa14", "four_bar", "panda")


def values_of(model: fb.Model) -> dict[str, Any]:
    return {r.name: r.value for r in fb.parameters(model) if r.value is not None}


@pytest.mark.parametrize("name", ROBOTS)
def test_every_number_bound_to_its_own_value_is_the_same_model(name):
    model = fb.load(name)
    assert model.bind(values_of(model)) == model


@pytest.mark.parametrize("seed", [2, 4])
def test_every_number_can_be_changed_and_is_then_read_back(seed):
    model = generate.model(seed)
    before = values_of(model)
    for record in list(fb.parameters(model))[seed::11]:
        if (
            record.limit
            or record.name.endswith(".scale")
            or record.name.startswith("payload.inertia")
        ):
            continue  # a load's inertia alone is no rigid body's
        if record.name.startswith("gravity.direction"):
            continue  # its length is 1
        value = record.value * 1.0001 if record.value else 0.001
        after = values_of(model.bind({record.name: value}))
        assert after[record.name] == pytest.approx(value, rel=1e-12)
        for name in set(before) & set(after) - {record.name}:
            assert after[name] == pytest.approx(before[name], rel=1e-9, abs=1e-12), (
                record.name,
                name,
            )


def test_inertia_is_told_in_the_axes_of_the_link():
    """Centres of mass, each in its link's axes, make that of the robot."""
    model = generate.model(4)
    known, q = fb.parameters(model), fb.random_state(model, 1)[0]
    parts = [part for body in model.bodies for part in body.inertias]
    assert any(part.placement.steps for part in parts)  # links that are no body of their own
    moment = np.zeros(3)
    for link in (part.link for part in parts):
        T = numbers(model, "forward_kinematics", q, frame=link)
        com = [known[f"{link}.com.{x}"].value for x in "xyz"]
        moment += known[f"{link}.mass"].value * (T[:3, :3] @ com + T[:3, 3])
    np.testing.assert_allclose(moment, model.mass * numbers(model, "center_of_mass", q), atol=1e-12)


@pytest.mark.parametrize("scale", [1e60, [1.0, 1e60]])
def test_a_scale_makes_no_number_that_no_file_may_hold(scale):
    with pytest.raises(fb.FreebodyError, match=r"scale: 1e\+60 makes a mass or inertia too large"):
        fb.load("ur5e").bind({"forearm_link.scale": scale})


def test_mass_keeps_centre_and_inertia_and_scale_scales_both():
    model = fb.load("ur5e")
    heavy, scaled = model.bind({"forearm_link.mass": 5.0}), model.bind({"forearm_link.scale": 2.0})
    old, a, b = (fb.parameters(m) for m in (model, heavy, scaled))
    for name in ("com.x", "inertia.xx", "inertia.yz"):
        assert a[f"forearm_link.{name}"].value == old[f"forearm_link.{name}"].value
    assert b["forearm_link.mass"].value == 2.0 * old["forearm_link.mass"].value
    assert b["forearm_link.inertia.xx"].value == 2.0 * old["forearm_link.inertia.xx"].value
    assert b["forearm_link.scale"].value == 1.0


def test_an_entry_of_a_dh_table_moves_all_that_hangs_on_it():
    rows = [{"a": 0.4, "d": 0.1, "alpha": 0.3, "m": 2.0, "com": (-0.2, 0, 0)}, {"a": 0.3, "m": 1.0}]
    changed = [{**rows[0], "a": 0.5}, rows[1]]
    for convention in ("standard", "modified"):
        model = fb.dh(rows, convention=convention)
        assert model.bind({"joint1.a": 0.5}) == fb.dh(changed, convention=convention)
        zero = model.bind({"joint2.d": 0.2})
        assert zero == fb.dh([rows[0], {**rows[1], "d": 0.2}], convention=convention)


def test_what_is_fixed_to_a_frame_moves_with_it():
    model = (
        fb.load("2R").with_frame("flange", (0.1, 0.0)).replace(tip="flange").with_payload(mass=1.0)
    )
    moved = model.bind({"flange.placement.x": 0.3})
    q = np.array([0.3, 0.4])
    again = (
        fb.load("2R").with_frame("flange", (0.3, 0.0)).replace(tip="flange").with_payload(mass=1.0)
    )
    assert moved == again
    assert np.array_equal(fb.gravity_torque(moved, q), fb.gravity_torque(again, q))


def test_a_load_that_is_not_there_has_numbers_all_the_same():
    model = fb.load("ur5e")
    assert fb.parameters(model)["payload.mass"].value == 0.0
    assert model.bind({"payload.mass": 2.0, "payload.com.z": 0.1}) == model.with_payload(
        mass=2.0, com=(0, 0, 0.1)
    )


def test_a_payload_that_is_nothing_is_none():
    model = fb.load("ur5e")
    family = model.bind({"payload.mass": [0.0, 2.0]})
    empty = model.with_payload(mass=0.0)
    for same in (family[0], empty, model.with_payload(mass=1.0).bind({"payload.mass": 0.0})):
        assert same == model == same
        assert hash(same) == hash(model)
        values = {r.name: r.value for r in fb.parameters(same)}
        assert values == {r.name: r.value for r in fb.parameters(model)} | {"payload.scale": 1.0}
    for other in (
        family[1],
        model.with_payload(mass=0.0, name="tool"),  # whose numbers only this robot has
        model.with_payload(mass=0.0, frame="frame3"),
        model.with_payload(mass=0.0, com=(0.0, 0.0, 0.1)),
    ):
        assert other != model


def test_a_symbol_is_found_by_its_name_and_by_its_place():
    model = fb.load("2R")
    assert "m1" in fb.parameters(model).names
    assert "link1.mass" not in fb.parameters(model).names
    assert model.bind({"link1.mass": 3.0}) == model.bind(m1=3.0)
    assert fb.parameters(model)["link1.mass"] == fb.parameters(model)["m1"]


def test_names_with_dots_are_given_in_parts_and_shared_ones_say_what_they_belong_to():
    load = fb.load("2R").with_payload(mass=1.0, name="a.b")
    assert fb.parameters(load.bind({("a.b", "mass"): 3.0}))["a.b", "mass"].value == 3.0
    twice = fb.load("2R").with_payload(mass=1.0).with_payload(mass=2.0)
    names = [
        n for n in fb.parameters(twice).names if n.endswith("payload.mass") or "payload.mass (" in n
    ]
    assert [fb.parameters(twice)[n].value for n in names] == [1.0, 2.0]
    with pytest.raises(fb.FreebodyError, match=r"several things have a number 'payload.mass'"):
        twice.bind({"payload.mass": 1.0})


def test_patterns_leave_out_what_is_structural_and_limits():
    known = fb.parameters(fb.load("ur5e"))
    names = [r.name for r in known.matching("elbow_joint.*")]
    assert "elbow_joint.a" in names
    assert "elbow_joint.d" not in names
    assert "elbow_joint.limits.upper" not in names
    assert [r.name for r in known.matching("elbow_joint.d")] == ["elbow_joint.d"]
    with pytest.raises(fb.FreebodyError, match="no parameter of 'ur5e' matches"):
        known.matching("forarm*")


def test_the_table_is_read_by_people_and_pages():
    known = fb.parameters(fb.load("2R").replace(name="x").with_payload(mass=1.0, name="<b>"))
    assert "m1" in repr(known)
    assert "kg m²" in repr(known)
    assert "<b>" not in known._repr_html_()
    assert "&lt;b&gt;" in known._repr_html_()
    assert known.values.shape == (len(known),)


# ---------------------------------------------------------------- families
def assert_near(found: Any, expected: Any, cond: float = 1.0, least: float = 0.0) -> None:
    """To 1e-13 of the sample's largest entry, or of `least` where all are zero but for rounding.

    Inverses are as good as the condition of what is inverted.
    """
    found, expected = np.asarray(found), np.asarray(expected)
    assert found.shape == expected.shape
    scale = np.abs(expected).reshape(len(expected), -1).max(axis=1, initial=least)
    apart = np.abs(found - expected).reshape(len(expected), -1).max(axis=1, initial=0.0)
    assert (apart <= 1e-13 * cond * scale).all(), (apart / scale).max()


def random_family(model: fb.Model, shape: tuple[int, ...] = (2,), seed: int = 0) -> fb.Model:
    rng = np.random.default_rng(seed)
    changed: dict[str, Any] = {}
    for r in fb.parameters(model):
        if (
            not r.value
            or r.limit
            or r.structural
            or (".inertia." in r.name and "rotor" not in r.name)
        ):
            continue
        if r.name.startswith("gravity.direction"):
            continue
        factor = 1.0 + 0.1 * rng.uniform(-1.0, 1.0, shape)
        changed[r.name] = r.value * factor
    return model.bind({**changed, "payload.mass": rng.uniform(0.5, 1.0, shape)})


ONE_ROBOT = {
    *(
        "assemble",
        "assembly_modes",
        "loop_velocity",
        "loop_acceleration",
        "mobility",
        "input_output",
    ),
    *(
        "inverse_velocity",
        "inverse_acceleration",
        "free_body_diagram",
    ),
    *("kinematic_diagram", "dexterity", "ellipsoids", "linearize"),
}
WHOLE_RUNS = {"simulate", "inverse_kinematics", "deflection", "natural_frequencies"}
"""Of test_simulate_many.py, test_calibrated_arms.py, test_compliant_loops.py: they return more than
arrays."""
OF_STRUCTURE = {"neutral", "random_state", "parameters", "integrate", "difference"}
"""Functions of no number of a model."""


def with_limits(model: fb.Model) -> fb.Model:
    name = next(r.name for r in fb.parameters(model) if r.name.endswith("limits.upper"))
    return model.bind({name: [3.0, 4.0]})


def with_drives(model: fb.Model) -> fb.Model:
    joint = next(body.joint.name for body in model.bodies if body.kind.nv == 1)
    numbers = {
        "viscous": [0.1, 0.2],
        "rotor": [1e-3, 2e-3],
        "gear": 10.0,
        "stiffness": [1.0, 2.0],
        "rest": 0.1,
    }
    return model.with_drive(joint, coulomb=0.1, **numbers)


OF_INVERSE = {
    "reactions",
    "mass_matrix_inverse",
    "operational_space_inertia",
    "operational_space_bias",
}


def _results(found: Any) -> tuple[Any, ...]:
    """A function's results, one or several."""
    if hasattr(found, "multipliers"):
        return found.wrenches, found.multipliers, found.qdd, found.tau
    return found if isinstance(found, tuple) else (found,)


FAMILIES = [random_family, with_limits, with_drives]


@pytest.mark.sample(1)
@pytest.mark.parametrize("family_of", FAMILIES)
@pytest.mark.parametrize(
    ("seed", "dim"), [(1, 2), pytest.param(24, 3, marks=pytest.mark.long)], ids=["plane", "space"]
)
def test_a_family_gives_what_its_members_give(seed, dim, family_of):
    _as_its_members(seed, dim, family_of)


@pytest.mark.sample(1)
@pytest.mark.usefixtures("numpy_kernels")
@pytest.mark.parametrize("family_of", FAMILIES)
def test_a_family_in_space_gives_what_its_members_give(family_of):
    """Compiled, as the one in the plane, among the long tests."""
    _as_its_members(24, 3, family_of)


def _as_its_members(seed, dim, family_of):
    """Of every function the shape and, to 1e-13, the numbers, also of those that read no number
    that differs."""
    model = generate.model(seed, dim)
    family = family_of(model)
    assert family.family == (2,)
    samples = state(model, seed, (3, 1))
    load = {model.frame_names[-1]: np.linspace(1.0, 2.0, 6 if model.dim == 3 else 3)}
    cond = [np.linalg.cond(fb.mass_matrix(family[i], samples["q"])).max() for i in range(2)]
    for name in sorted(set(functions_of_states()) - ONE_ROBOT - OF_STRUCTURE - WHOLE_RUNS):
        given = {argument: samples[key] for argument, key in arguments(name).items()}
        if "wrenches" in inspect.signature(getattr(fb, name)).parameters:
            given["wrenches"] = load
        call = functools.partial(getattr(fb, name), **given)
        try:
            whole = call(model=family)
        except fb.FreebodyError as problem:
            assert "is a family of robots" not in str(problem), name  # noqa: PT017
            with pytest.raises(type(problem)):
                call(model=family[0])
            continue
        inverse = name.startswith("forward_dynamics") or name in OF_INVERSE
        for i in range(2):
            one = call(model=family[i])
            for a, b in zip(_results(whole), _results(one), strict=True):
                for x, y in zip(
                    *(z.values() if isinstance(z, dict) else (z,) for z in (a, b)), strict=True
                ):
                    assert x.shape == (3, 2, *y.shape[2:]), name
                    assert_near(x[:, i], y[:, 0], cond[i] if inverse else 1.0, least=1.0)


def test_shapes_broadcast_as_numpy_does():
    model = fb.load("2R").bind(m2=np.array([[1.0], [2.0], [3.0]]))
    q = np.full((4, 2), 0.3)
    tau = fb.gravity_torque(model, q)
    assert model.family == (3, 1)
    assert tau.shape == (3, 4, 2)
    assert np.allclose(tau[1], fb.gravity_torque(model[1, 0], q), atol=1e-13)
    assert fb.forward_kinematics(model, q).shape == (3, 4, 3, 3)
    assert model.mass.shape == (3, 1)
    assert model.gravity.shape == (3, 1, 2)
    assert model.limits.lower.shape == (3, 1, 2)
    assert model[1].family == (1,)
    assert model[0, 0].family == ()
    with pytest.raises(fb.FreebodyError, match="do not broadcast"):
        fb.gravity_torque(fb.load("2R").bind(m2=[1.0, 2.0, 3.0]), q)


def test_a_family_is_a_value():
    model = fb.load("ur5e")
    masses = np.array([1.0, 2.0])
    family = model.bind({"forearm_link.mass": masses})
    masses[0] = 9.0
    assert family[0] == model.bind({"forearm_link.mass": 1.0})
    again = pickle.loads(pickle.dumps(family))
    assert again == family
    assert hash(again) == hash(family)
    assert copy.deepcopy(family) == family
    assert family != model.bind({"forearm_link.mass": [1.0, 2.5]})
    with pytest.raises(ValueError, match="read-only"):
        family.bodies[2].inertias[0].inertia.mass.array[0] = 3.0
    with pytest.raises(TypeError):
        iter(family)
    refused("'ur5e' is one robot, not a family: it has no member 0.", lambda: model[0])


def test_the_ways_to_a_family():
    model, q = fb.load("ur5e"), np.full(6, 0.4)
    loads = model.with_payload(mass=np.array([1.0, 2.0]), com=np.array([[0, 0, 0.1], [0, 0, 0.2]]))
    assert loads[1] == model.with_payload(mass=2.0, com=(0, 0, 0.2))
    driven = model.with_drive("elbow_joint", viscous=[0.1, 0.2], rotor=1e-4, gear=100.0)
    tau = fb.inverse_dynamics(driven, q, q, q)
    assert np.allclose(tau[1] - tau[0], [0, 0, 0.04, 0, 0, 0], atol=1e-12)
    field = model.replace(gravity=np.array([[0, 0, -9.81], [0, 0, -1.6]]))
    assert np.allclose(field.gravity, [[0, 0, -9.81], [0, 0, -1.6]])
    for i in range(2):
        assert np.allclose(
            fb.gravity_torque(field, q)[i], fb.gravity_torque(field[i], q), atol=1e-12
        )


def test_lists_of_vectors_are_what_their_arrays_are():
    """Three members, so that rows and columns are as many."""
    model, rows = fb.load("ur5e"), np.arange(1.0, 10.0).reshape(3, 3) ** 2
    for some in (rows, rows[:2]):
        for given in (some.tolist(), tuple(map(tuple, some)), list(some)):
            assert model.with_payload(mass=2.0, com=given) == model.with_payload(mass=2.0, com=some)
            assert model.replace(gravity=given) == model.replace(gravity=some)
    assert model.with_payload(mass=2.0, com=[0.0, 0.0, [0.1, 0.2]])[1] == model.with_payload(
        mass=2.0, com=[0.0, 0.0, 0.2]
    )
    assert model.with_payload(mass=np.array(2.0)) == model.with_payload(mass=2.0)
    assert model.replace(gravity=np.array(1.6)) == model.replace(gravity=1.6)
    for com in (
        0.1,
        np.array(0.1),
        [],
        [0, 0],
        [[0, 0], [0, 0], [0.1, 0.2]],
        [[0, 0], [0, 0, 0.1]],
    ):
        with pytest.raises(fb.FreebodyError, match="with_payload: com"):
            model.with_payload(mass=2.0, com=com)
    for gravity in (1j, np.array(None), {1.0}, [[0, 0], [0, 0, 1.0]]):
        with pytest.raises(fb.FreebodyError, match="gravity: "):
            model.replace(gravity=gravity)


def test_kernels_of_members_that_differ_in_limits_alone_are_compiled():
    model = fb.load("ur5e")
    family = with_limits(model)
    q = np.linspace(0.1, 0.6, 6)
    for dtype, apart in (("float64", 1e-12), ("float32", 1e-4)):
        kernel = fb.kernel(family, "gravity_torque", dtype=dtype)
        assert kernel.kernel.target == fb.kernel(model, "gravity_torque").target
        assert kernel.values.shape == (2, 1)
        assert np.allclose(
            kernel(q), np.broadcast_to(fb.gravity_torque(model, q), (2, 6)), atol=apart
        )


def test_members_on_other_slopes_have_gravity_in_other_directions():
    model, vectors = (
        fb.load("ur5e"),
        np.array([[0.0, 0, -9.81], [0, 3.0, -9.0], [1.6, 0, 0], [0, 0, 0]]),
    )
    family = model.replace(gravity=vectors)
    assert np.allclose(family.gravity, vectors, rtol=1e-15)
    q, qd, qdd = fb.random_state(model, 0, (5, 1))
    tau, again = fb.inverse_dynamics(family, q, qd, qdd), fb.kernel(family, "inverse_dynamics")
    for i, vector in enumerate(vectors):
        one = fb.inverse_dynamics(model.replace(gravity=vector), q, qd, qdd)[:, 0]
        assert_near(tau[:, i], one)
        assert_near(again(q, qd, qdd)[:, i], one)
    tilted = model.bind({"gravity.direction.x": 0.6, "gravity.direction.z": [-0.8, -0.8]})
    assert np.allclose(tilted.gravity, 9.81 * np.array([[0.6, 0, -0.8]] * 2), rtol=1e-15)
    assert not [
        name for name in fb.kernel(model, "bias", inputs="g*").parameters if "direction" in name
    ]
    for values in ({"x": 0.6}, {"x": 0.6, "z": [-0.8, -0.7]}):
        with pytest.raises(
            fb.FreebodyError, match=r"gravity.direction has length 1?\.?.*; it must be 1"
        ):
            model.bind({f"gravity.direction.{x}": value for x, value in values.items()})


@pytest.mark.parametrize(
    "change",
    [
        lambda m: m.bind({"gravity": [1.0, 2.0, 3.0]}),
        lambda m: m.replace(gravity=np.full((3, 3), [0.0, 0.0, -1.0])),
        lambda m: m.with_payload(mass=[1.0, 2.0, 3.0]),
        lambda m: m.with_drive("elbow_joint", viscous=[1.0, 2.0, 3.0]),
    ],
    ids=["bind", "replace", "with_payload", "with_drive"],
)
def test_arrays_that_make_no_family_are_refused_where_they_are_given(change):
    family = fb.load("ur5e").bind({"forearm_link.mass": [1.0, 2.0]})
    with pytest.raises(fb.FreebodyError, match=r"shapes .*\(2,\).* do not broadcast to one family"):
        change(family)
    assert change(family[0]).family == (3,)


def test_a_family_says_that_it_is_one():
    one = fb.load("2R")
    assert "family" not in repr(one)
    assert repr(one.bind(m1=np.ones((3, 2)))).endswith("dim 2; a family of shape (3, 2)>")


def test_members_are_checked_one_by_one():
    model = fb.load("ur5e")
    with pytest.raises(fb.FreebodyError, match=r"mass -1 kg is negative \(member 1\)"):
        model.bind({"forearm_link.mass": [1.0, -1.0]})
    with pytest.raises(fb.FreebodyError, match=r"nan \(member 2\)"):
        model.bind({"forearm_link.mass": [1.0, 1.0, np.nan]})
    light = fb.load("2R").bind(m2=[1.0, 0.0], I2=[0.1, 0.0])
    with pytest.raises(
        fb.FreebodyError, match=r"\(member 1\) is singular: joint 'joint2' moves no inertia"
    ):
        fb.forward_dynamics(light, [0.1, 0.2], [0, 0], [0, 0])
    with pytest.raises(fb.FreebodyError, match=r"no mass \(member 0\)"):
        fb.center_of_mass(fb.planar("R", l=[1], lc=[1], m=[1], I=[0]).bind(m1=[0.0, 1.0]), [0.1])


@pytest.mark.parametrize("name", sorted(ONE_ROBOT - {"inverse_velocity", "inverse_acceleration"}))
def test_what_is_about_one_robot_refuses_a_family(name):
    family = fb.load("2R").bind(m2=[1.0, 2.0])
    with raises_own(
        TypeError, match=rf"{name}: '2R' is a family of robots, shape \(2,\).*model\[0\]"
    ):
        public_calls()[name](family, state(fb.load("2R"), 0))


def test_all_else_refuses_a_family(tmp_path):
    family = fb.load("2R").bind(m2=[1.0, 2.0])
    for call in (
        lambda: fb.save(family, tmp_path / "x.toml"),
        lambda: fb.equations(family),
        lambda: fb.derive(family),
        lambda: fb.base_parameters(family),
        lambda: fb.singularities(family),
        lambda: fb.study(family),
        lambda: fb.check(family, "x = 1"),
        lambda: fb.inverse_velocity(family, [0.1, 0.2], [0, 0, 0]),
        lambda: fb.source(family, "inverse_dynamics", "c"),
        lambda: fb.reactions(
            fb.load("four_bar").bind(l1=[0.2, 0.25]), *np.zeros((2, 3)), tau=np.zeros(3)
        ),
        lambda: fb.forward_dynamics(fb.load("four_bar").bind(l1=[0.2, 0.25]), *np.zeros((3, 3))),
    ):
        with raises_own(TypeError, match="take a member"):
            call()


# ---------------------------------------------------------------- inputs and derivatives
def test_numbers_as_inputs_are_the_model_with_other_numbers():
    model = fb.load("ur5e")
    kernel = fb.kernel(
        model, "inverse_dynamics", inputs=["*.mass", "*.com.*", "*.inertia.*", "*.a", "*.d", "g"]
    )
    q, qd, qdd = fb.random_state(model, 0, (5,))
    assert np.allclose(
        kernel(q, qd, qdd), fb.inverse_dynamics(model, q, qd, qdd), rtol=1e-13, atol=1e-12
    )
    p = kernel.values * np.linspace(1.0, 1.1, 5)[:, None]
    assert p.shape == (5, len(kernel.parameters))
    found = kernel(q, qd, qdd, p)
    for i in (0, 4):
        bound = model.bind(dict(zip(kernel.parameters, p[i], strict=True)))
        assert np.allclose(
            found[i], fb.inverse_dynamics(bound, q[i], qd[i], qdd[i]), rtol=1e-12, atol=1e-12
        )
    some = kernel(q, qd, qdd, p={"forearm_link.mass": 3.0})
    bound = model.bind({"forearm_link.mass": 3.0})
    assert np.allclose(some, fb.inverse_dynamics(bound, q, qd, qdd), rtol=1e-13, atol=1e-12)


@pytest.mark.parametrize("names", [["payload.mass"], ["*.mass", "*.com.*"]])
def test_all_ways_to_call_with_numbers_are_one(names):
    model = fb.load("ur5e")
    kernel = fb.kernel(model, "inverse_dynamics", inputs=names)
    states, p = fb.random_state(model, 0), np.array(kernel.values) + 0.01
    named, out = dict(zip(kernel.parameters, p, strict=True)), np.empty(6)
    expected = kernel.kernel(*states, p)
    assert not np.array_equal(expected, kernel(*states))
    assert np.array_equal(kernel(*states), kernel.kernel(*states, kernel.values))
    for again in (kernel, pickle.loads(pickle.dumps(kernel)), copy.deepcopy(kernel)):
        assert np.array_equal(again(*states, p), expected)
        assert np.array_equal(again(*states, p=p), expected)
        assert np.array_equal(again(*states, p=named), expected)
        assert np.array_equal(again(*states, list(p)), expected)
        assert np.array_equal(again(*states, np.array([p, p]))[1], expected)
        assert np.array_equal(again(*states, p=named, threads=1), expected)
        assert again(*states, p, out=out) is out
        assert again(*states, p=p, out=out) is out
        assert np.array_equal(out, expected)
    each = {
        kernel.parameters[0]: np.array([[1.0], [2.0]]),
        kernel.parameters[-1]: np.array([0.1, 0.2, 0.3]),
    }
    numbers = kernel.numbers(each)
    assert numbers.shape == ((2, 3, len(p)) if len(p) > 1 else (3, 1))
    assert np.array_equal(numbers[..., -1], np.broadcast_to([0.1, 0.2, 0.3], numbers.shape[:-1]))
    with pytest.raises(fb.FreebodyError, match="expected 4"):
        kernel(*states, p, p)


@pytest.mark.parametrize("number", [2.5, np.float64(2.5), 2, np.float32(2.5)])
def test_numbers_of_any_kind_by_name(number):
    kernel, q = (
        fb.kernel(fb.load("2R"), "gravity_torque", inputs=["m1", "m2"]),
        np.array([0.3, -0.4]),
    )
    p = np.array(kernel.values)
    p[1] = number
    for name in ("m2", ("m2",), "link2.mass"):
        assert kernel(q, p={name: number}).tobytes() == kernel(q, p).tobytes()
        with pytest.raises(fb.FreebodyError, match="'l1' is not an input"):
            kernel(q, p={name: number, "l1": 1.0})
    assert kernel.values[1] != p[1]


@pytest.mark.sample(1)
@pytest.mark.parametrize("seed", [4, 9])
def test_any_number_is_an_input_of_any_formula(seed):
    model = generate.model(seed)
    names = [r.name for r in fb.parameters(model) if not r.limit]
    rng = np.random.default_rng(seed)
    known = fb.parameters(model)
    small = {
        n: known[n].value + 1e-3 * rng.uniform()
        for n in names
        if ".inertia." not in n or "rotor" in n
    }
    small = {n: x for n, x in small.items() if not n.startswith(("payload.", "gravity.direction."))}
    bound = model.bind(small)
    quantities = ["inverse_dynamics", "kinetic_energy", "forward_kinematics"]
    kernel = fb.kernel(model, quantities, inputs=names)
    assert list(kernel.parameters) == names
    s = state(model, seed)
    arrays = [s[a.name] for a in kernel.program.inputs[:-1]]
    for a, b in zip(kernel(*arrays, p=small), fb.kernel(bound, quantities)(*arrays), strict=True):
        assert np.allclose(a, b, rtol=1e-12, atol=1e-12)


def test_symbols_without_values_are_inputs():
    model, ones = fb.planar("RR"), np.ones(2)
    kernel = fb.kernel(model, "inverse_dynamics", inputs=list(model.parameters))
    values = {name: 0.5 + 0.1 * k for k, name in enumerate(model.parameters)}
    bound = model.bind(values)
    assert np.allclose(
        kernel(ones, ones, ones, p=values), fb.inverse_dynamics(bound, ones, ones, ones), rtol=1e-13
    )
    with pytest.raises(fb.FreebodyError, match="need a value for I1"):
        kernel(ones, ones, ones)
    others = "need a value for I1, I2, l1, l2, lc1, lc2, m2. Give them with model.bind"
    for less, some in ((model, ["m1"]), (model.bind(m1=[1.0, 2.0]), [])):
        with pytest.raises(MissingValueError, match=others):
            fb.kernel(less, "inverse_dynamics", inputs=some)


def test_closed_chains_have_numbers_as_inputs():
    model = fb.load("four_bar")
    q = fb.assemble(model)
    kernel = fb.kernel(model, "forward_dynamics", inputs=["m*", "l*"])
    heavy = model.bind(m1=1.7)
    zero = np.zeros(3)
    expected = fb.kernel(heavy, "forward_dynamics")(q, zero, zero)
    assert np.allclose(kernel(q, zero, zero, p={"m1": 1.7}), expected, rtol=1e-10, atol=1e-10)


def test_wrong_inputs_are_refused():
    model = fb.load("ur5e")
    with pytest.raises(fb.FreebodyError, match=r"'elbow_joint.limits.upper' is a limit"):
        fb.kernel(model, "inverse_dynamics", inputs="elbow_joint.limits.upper")
    with pytest.raises(fb.FreebodyError, match=r"no parameter 'forearm_link.mas'"):
        fb.kernel(model, "inverse_dynamics", inputs=["forearm_link.mas"])
    kernel = fb.kernel(model, "inverse_dynamics", inputs="forearm_link.mass")
    with pytest.raises(fb.FreebodyError, match=r"'payload.mass' is not an input of this kernel"):
        kernel(*np.zeros((3, 6)), p={"payload.mass": 1.0})
    with pytest.raises(fb.FreebodyError, match="no input 'p' in by="):
        fb.kernel(model, "inverse_dynamics", by="p")
    with pytest.raises(fb.FreebodyError, match=r"limits.lower' is a limit, which no kernel reads"):
        fb.kernel(fb.load("ur5e"), "inverse_dynamics", inputs="*.limits.*")


def test_a_number_beyond_the_range_of_32_bits_is_refused():
    model = fb.load("ur5e").bind({"forearm_link.mass": [1.0, 1e39]})
    words = r"'forearm_link.mass' is 1e\+39 \(member 1\), which is beyond the range of float32"
    with pytest.raises(fb.FreebodyError, match=words):
        fb.kernel(model, "inverse_dynamics", dtype="float32")
    assert fb.kernel(model[0], "inverse_dynamics", dtype="float32").dtype == np.float32


@pytest.mark.parametrize(
    "name", ["inverse_dynamics", "forward_dynamics", "forward_kinematics", "potential_energy"]
)
def test_derivatives_by_any_number_and_any_input(name):
    """Against differences of fourth order: exact to 1e-10 of the largest entry where rounding
    allows."""
    model = fb.load("2R").bind(m1=1.0)
    inputs = [
        r.name for r in fb.parameters(model) if not (r.limit or r.structural or "payload" in r.name)
    ]
    kernel = fb.kernel(model, name, inputs=inputs, by="p")
    q, qd, tau = fb.random_state(model, 3)
    arrays = (q, qd, tau)[: len(kernel.program.inputs) - 1]
    value, slope = kernel(*arrays)
    p = kernel.values
    for k in range(len(inputs)):
        step = np.zeros_like(p)
        step[k] = 1e-3
        moved = [kernel(*arrays, p + i * step)[0] for i in (-2, -1, 1, 2)]
        difference = (moved[0] - 8 * moved[1] + 8 * moved[2] - moved[3]) / 12e-3
        assert np.allclose(
            slope[..., k], difference, rtol=1e-8, atol=1e-8 * (1 + abs(value).max())
        ), inputs[k]


def test_derivatives_agree_with_those_that_are_there():
    model = generate.model(4)  # on a free base: positions have more entries than rates
    s = state(model, 4)
    found = fb.kernel(model, "inverse_dynamics", by=("q", "qd", "qdd"))(s["q"], s["qd"], s["qdd"])
    expected = fb.inverse_dynamics_derivatives(model, s["q"], s["qd"], s["qdd"])
    for a, b in zip(found[1:], expected, strict=True):
        assert np.allclose(a, b, rtol=1e-10, atol=1e-10 * abs(b).max())


def test_derivatives_of_derivatives_keep_their_slopes_apart():
    model = fb.load("2R")
    q, qd, qdd = fb.random_state(model, 0)
    found = fb.kernel(model, "inverse_dynamics_derivatives", by="q")(q, qd, qdd)
    expected = fb.inverse_dynamics_second_derivatives(model, q, qd, qdd)
    assert np.allclose(found[3], expected[0], rtol=1e-11, atol=1e-12)
    assert np.allclose(found[5], expected[3], rtol=1e-11, atol=1e-12)


def test_values_by_name_that_are_no_numbers_or_of_no_common_shape_are_refused():
    kernel, z = fb.kernel(fb.load("2R"), "inverse_dynamics", inputs=["m1", "m2"]), [0.1, 0.2]
    refused(
        "fb.kernel: p['m1'] is 'heavy', expected real numbers.",
        lambda: kernel(z, z, z, p={"m1": "heavy"}),
    )
    refused(
        "fb.kernel: the values of p do not broadcast together: 'm1' (3,), 'm2' (2,).",
        lambda: kernel(z, z, z, p={"m1": [1.0, 2.0, 3.0], "m2": [1.0, 2.0]}),
    )
    assert kernel(z, z, z, p={"m1": 1, "m2": [1.0, 2.0]}).shape == (2, 2)


def test_a_name_that_is_like_no_symbol_is_answered_with_all_names():
    with pytest.raises(
        fb.FreebodyError,
        match=r"no parameter 'nothing' in 'ur5e'\. Parameters: g, gravity\.direction\.x",
    ):
        fb.load("ur5e").bind(nothing=1)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize(
    ("value", "words"),
    [
        (np.ma.array([1.0, 1e6], mask=[False, True]), "masked entries"),
        (np.array([1.0 + 1.0j]), "real numbers|complex"),
        (["1", "2"], "real numbers|<U1"),
        ([1.0, None], "real numbers|object"),
        ([[1.0], [1.0, 2.0]], "real numbers|different lengths"),
    ],
)
def test_numbers_of_members_are_numbers_that_are_there(value, words):
    model = fb.load("2R")
    kernel = fb.kernel(model, "gravity_torque", inputs="m1")
    for take in (
        lambda: model.bind(m1=value),
        lambda: model.with_payload(mass=value),
        lambda: kernel([0.1, 0.2], p={"m1": value}),
    ):
        with pytest.raises(fb.FreebodyError, match=words):
            take()


def test_what_picks_no_member_is_refused():
    """As an array without numbers is where a family is made."""
    family = fb.load("ur5e").bind({"forearm_link.mass": [1.0, 2.0]})
    for index in (slice(0, 0), np.array([False, False]), [], 2, (0, 0), "a", 1.0, np.array([True])):
        with pytest.raises(
            fb.FreebodyError, match=r"selects no member of a family of shape \(2,\)"
        ) as caught:
            family[index]
        assert isinstance(caught.value, IndexError)


STEPS = {
    "rk4_step": (),
    "semi_implicit_step": (),
    "implicit_step": (),
    "implicit_feedback_step": (np.zeros(2), np.zeros(2), np.full(2, 1e4), np.full(2, 1e2)),
}


@pytest.mark.sample(1)
@pytest.mark.parametrize("name", STEPS)
def test_steps_of_a_family_are_those_of_its_members(name):
    """With derivatives, and in 32 bits to what these hold."""
    family = random_family(fb.load("2R").with_drive("joint1", viscous=0.1, stiffness=2.0, rest=0.1))
    q, qd, tau = fb.random_state(fb.load("2R"), 0, (5, 1))
    step = fb.kernel(family, name, by=("q", "p"))
    short = fb.kernel(family, name, by=("q", "p"), dtype="float32")
    found, rounded = (k(q, qd, tau, 1e-3, *STEPS[name]) for k in (step, short))
    assert found[3].shape == (5, 2, 2, len(step.parameters))
    one = fb.kernel(family[0], name, by=("q", "p"), inputs=list(step.parameters))
    for i in range(2):
        expected = one(*(x[:, 0] for x in (q, qd, tau)), 1e-3, *STEPS[name], step.values[i])
        for a, b, c in zip(found, expected, rounded, strict=True):
            assert_near(a[:, i], b)
            assert c.dtype == np.float32
            assert np.abs(c[:, i] - b).max() <= 1e-5 * np.abs(b).max()


@pytest.mark.parametrize("option", ["inputs", "by"])
def test_names_that_are_no_names_are_refused(option):
    with pytest.raises(
        fb.FreebodyError, match=rf"fb.kernel: {option}= is int 3, expected a name or a list"
    ):
        fb.kernel(fb.load("2R"), "inverse_dynamics", **{option: 3})
