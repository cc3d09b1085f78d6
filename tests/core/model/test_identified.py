"""Models made of inertial parameters π: what identification estimates goes back into a robot."""

from __future__ import annotations

import numpy as np
import pytest

import freebody as fb
from support import generate
from support.helpers import refused

DRIVE = {"viscous": 0.3, "coulomb": 0.2, "rotor": 1e-4, "gear": 50.0, "stiffness": 2.0, "rest": 0.4}


def robot(kind: str) -> fb.Model:
    if kind == "loaded":
        return (
            fb.load("panda")
            .with_payload(mass=1.5, com=(0.01, 0.02, 0.1))
            .with_drive("panda_joint3", **DRIVE)
        )
    if kind == "particles":
        return fb.planar("RR", l=[0.7, 0.3], lc=[0.7, 0.3], m=[1.1, 2.3], I=[0.0, 0.0])
    return generate.model(4) if kind == "free" else fb.load(kind)


@pytest.mark.sample(2)
@pytest.mark.parametrize("kind", ["loaded", "particles", "free", "ur5e", "four_bar"])
def test_a_robot_made_of_its_own_parameters_moves_alike(kind):
    model = robot(kind)
    pi = fb.inertial_parameters(model)
    again = model.with_inertial_parameters(pi)
    assert again == model.with_inertial_parameters(np.array(list(pi.values())))
    other = fb.inertial_parameters(again)
    assert list(other) == list(pi)
    assert np.allclose(list(other.values()), list(pi.values()), rtol=1e-13, atol=1e-14)
    a, b = (m.opened if m.loops else m for m in (model, again))
    q, qd, qdd = fb.random_state(a, 0, 4)
    for name in ("inverse_dynamics", "forward_dynamics", "kinetic_energy"):
        arrays = (q, qd, qdd)[: 2 if name == "kinetic_energy" else 3]
        expected = fb.kernel(a, name)(*arrays)
        found = fb.kernel(b, name)(*arrays)
        assert np.allclose(found, expected, rtol=1e-13, atol=1e-13 * abs(expected).max()), name


def test_torques_are_those_of_the_regressor():
    model = robot("loaded")
    rng = np.random.default_rng(0)
    pi = np.array(list(fb.inertial_parameters(model).values())) * rng.uniform(0.999, 1.001, (3, 1))
    at = [
        k
        for k, name in enumerate(fb.inertial_parameters(model))
        if name.startswith("panda_joint3.")
    ]
    pi[:, at] *= rng.uniform(0.5, 2.0, (3, 5))  # bodies would not stay physical
    family = model.with_inertial_parameters(pi)
    assert family.family == (3,)
    q, qd, qdd = fb.random_state(model, 1)
    torques = (fb.regressor(model, q, qd, qdd) @ pi[..., None])[..., 0]
    assert np.allclose(fb.inverse_dynamics(family, q, qd, qdd), torques, rtol=1e-12, atol=1e-12)
    one = model.with_inertial_parameters(pi[1])
    assert np.allclose(fb.inverse_dynamics(one, q, qd, qdd), torques[1], rtol=1e-12, atol=1e-12)
    assert fb.parameters(one)["panda_joint3.rotor.gear"].value == 50.0


def test_a_bodys_links_and_loads_become_one(tmp_path):
    model = robot("loaded")
    made = model.with_inertial_parameters(fb.inertial_parameters(model))
    assert [len(body.inertias) for body in made.bodies] == [1] * len(made.bodies)
    assert fb.parameters(made)["payload.mass"].value == 0.0
    assert made.mass == pytest.approx(model.mass, rel=1e-14)
    known = fb.parameters(made)
    assert made.bind({r.name: r.value for r in known}) == made
    heavy = made.bind({f"{made.bodies[3].name}.mass": 9.0})
    assert heavy.mass == pytest.approx(
        made.mass - made.bodies[3].inertias[0].inertia.mass + 9.0, rel=1e-14
    )
    fb.save(made, tmp_path / "made.toml")
    read = fb.inertial_parameters(fb.load(tmp_path / "made.toml"))
    assert list(read.values()) == pytest.approx(
        list(fb.inertial_parameters(made).values()), rel=1e-12, abs=1e-15
    )


def test_what_no_robot_is_is_refused():
    model = fb.load("ur5e")
    pi = fb.inertial_parameters(model)
    first = next(iter(pi))
    body = first.removesuffix(".m")
    refused(
        f"with_inertial_parameters: {body!r}: mass -1 kg is negative. Estimate under the "
        f"constraint that each body "
        "is physical.",
        lambda: model.with_inertial_parameters({**pi, first: -1.0}),
    )
    with pytest.raises(fb.FreebodyError, match="a first moment h without a mass"):
        model.with_inertial_parameters({**pi, first: 0.0, f"{body}.hx": 0.1})
    with pytest.raises(fb.FreebodyError, match=r"triangle inequality .* \(member 1\)"):
        model.with_inertial_parameters({**pi, f"{body}.Izz": np.array([pi[f"{body}.Izz"], 9.0])})
    with pytest.raises(fb.FreebodyError, match=r"pi has shape \(3,\), expected \(..., 60\)"):
        model.with_inertial_parameters([1.0, 2.0, 3.0])
    with pytest.raises(fb.FreebodyError, match="nan"):
        model.with_inertial_parameters({**pi, first: np.nan})
    with pytest.raises(fb.FreebodyError, match=r"pi lacks shoulder_link\.hx"):
        model.with_inertial_parameters({first: 1.0})
    sprung = robot("loaded")
    pi = fb.inertial_parameters(sprung)
    with pytest.raises(fb.FreebodyError, match="'panda_joint3': stiffness_rest without stiffness"):
        sprung.with_inertial_parameters({**pi, "panda_joint3.stiffness": 0.0})


@pytest.mark.parametrize(
    "numbers",
    [{"joint1.rotor.gear": [1.0, 2.0]}, {"joint1.friction.viscous": [0.0, 0.0]}],
    ids=["gear without a rotor", "friction 0"],
)
def test_a_drive_that_does_nothing_has_no_parameters_in_a_family_either(numbers):
    """π had entries of a drive where the columns of the regressor, and the names, had none."""
    arm = fb.load("2R")
    family = arm.bind(numbers)
    pi = fb.inertial_parameters(family)
    assert list(pi) == list(fb.inertial_parameters(arm))
    q = np.array([0.3, -0.4])
    assert fb.regressor(family, q, q, q).shape == (2, 2, len(pi))


def test_a_gear_without_a_rotor_may_be_an_input():
    arm = fb.load("2R")
    kernel = fb.kernel(arm, "regressor", inputs=["joint1.rotor.gear"])
    q = np.array([0.3, -0.4])
    assert np.array_equal(kernel(q, q, q, p=[7.0]), fb.kernel(arm, "regressor")(q, q, q))
