"""`fb.identify` on simulated arms, whose masses and friction are known."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

import freebody as fb
from support.simulated_logs import arm, exact_log, log, motion, with_random_numbers

pytestmark = pytest.mark.usefixtures("numpy_kernels")

FRICTION = ("viscous", "coulomb", "offset")
ARM = arm()


def truth(model, found):
    """The true values of all parameters, by name."""
    pi = fb.inertial_parameters(model)
    drives = {body.joint.name: body.joint.drive for body in model.bodies}
    base = found.combinations @ [pi[name] for name in found.inertial_names]
    names = [x.name for x in found.parameters if x.kind == "inertial"]
    values = dict(zip(names, base, strict=True))
    for x in found.parameters[len(names) :]:
        joint, _, law = x.name.partition(".")
        numbers = [getattr(drives[joint], name) for name in law.split("*")]
        values[x.name] = float(np.prod(numbers))
    return values


def held(found, model, kind):
    """Whether each stated interval holds the true value."""
    true = truth(model, found)
    return [
        x.lower <= true[x.name] <= x.upper
        for x in found.parameters
        if x.kind == kind and not np.isnan(x.lower)
    ]


def coverage(count, friction, fitted, start=0, **options):
    """Shares of intervals that hold, of inertial and of friction's, of the joints whose law of
    friction does not fit, and of the logs that seem to be of another structure."""
    hits, wrong, alarms = {"inertial": [], "friction": []}, 0, 0
    for seed in range(start, start + count):
        rng = np.random.default_rng(seed)
        model = with_random_numbers(ARM, rng, friction)
        found = fb.identify(ARM, log(model, rng), friction=fitted, **options)
        for kind, hit in hits.items():
            hit += held(found, model, kind)
        wrong += sum(not x.law_fits for x in found.joints)
        alarms += not found.structure.fits or found.structure.delay is not None
    shares = np.mean(hits["inertial"]), np.mean(hits["friction"] or [1.0])
    return *shares, wrong / (3 * count), alarms / count


def exact(model, bare, rotors, smooth=0.0):
    rng = np.random.default_rng(3)
    made = exact_log(model, rng, duration=30.0)
    found = fb.identify(bare, made, friction=("viscous", "coulomb"), rotors=rotors, smooth=smooth)
    true = truth(model, found)
    return found, max(abs(x.value - true[x.name]) for x in found.parameters)


def test_exact_data_give_exact_parameters():
    model = with_random_numbers(ARM, np.random.default_rng(5))
    found, error = exact(model, ARM, True)
    assert error < 1e-9
    assert all(x.lower <= x.value <= x.upper for x in found.parameters)


@pytest.mark.long
@pytest.mark.parametrize(
    ("robot", "rotors", "count"),
    [("puma560", False, 36), ("ur5e", False, 36), ("ur5e", True, 40), ("panda", False, 43)],
)
def test_the_count_of_base_parameters_is_the_published_one(robot, rotors, count):
    """Puma: 36 (Khalil, Bennis 1994); Panda: 43 (Gaz and others 2019), its hand held."""
    if robot == "panda":
        bare = fb.dh(PANDA, convention="modified", name="panda_arm")
    else:
        bare = fb.load(robot, physical="ignore")
    model = with_random_numbers(bare, np.random.default_rng(2))
    if not rotors:
        model = model.without("rotors")
    found, error = exact(model, bare, rotors)
    assert sum(x.kind == "inertial" for x in found.parameters) == count
    assert error < 1e-9


PANDA = [
    {"a": a, "d": d, "alpha": alpha * np.pi / 2}
    for a, d, alpha in [
        (0.0, 0.333, 0), (0.0, 0.0, -1), (0.0, 0.316, 1), (0.0825, 0.0, 1),
        (-0.0825, 0.384, -1), (0.0, 0.0, 1), (0.088, 0.0, 1),
    ]
]  # fmt: skip


def test_intervals_hold_about_as_often_as_they_say():
    inertial, friction, wrong, alarms = coverage(12, FRICTION, FRICTION)
    assert inertial > 0.88
    assert friction > 0.88
    assert wrong == 0.0
    assert alarms == 0.0


def test_friction_that_no_law_describes_leaves_intervals_of_bodies_right():
    inertial, _, wrong, _ = coverage(6, (*FRICTION, "stribeck"), FRICTION)
    assert inertial > 0.88
    assert wrong > 0.8


@pytest.mark.long
@pytest.mark.parametrize("laws", [FRICTION, (*FRICTION, "load")])
def test_intervals_hold_in_95_of_100_cases(laws):
    inertial, friction, wrong, alarms = coverage(200, laws, laws)
    assert 0.93 <= inertial <= 0.97
    assert 0.93 <= friction <= 0.97
    assert wrong < 0.01
    assert alarms <= 0.02


@pytest.mark.long
def test_friction_outside_the_family_leaves_inertial_intervals():
    inertial, _, wrong, alarms = coverage(200, (*FRICTION, "stribeck"), FRICTION)
    assert inertial >= 0.93
    assert wrong > 0.95
    assert alarms <= 0.03


def test_a_law_of_friction_that_does_not_fit_is_told_and_its_intervals_withdrawn():
    rng = np.random.default_rng(1)
    model = with_random_numbers(ARM, rng, (*FRICTION, "stribeck"))
    found = fb.identify(ARM, log(model, rng, noise=0.005), friction=FRICTION)
    wrong = [x.joint for x in found.joints if not x.law_fits]
    assert wrong
    own = [x for x in found.parameters if x.name.startswith(wrong[0]) and x.kind == "friction"]
    assert all(np.isnan(x.lower) and x.withdrawn for x in own)
    assert any("The law of friction does not fit at" in x for x in found.notices)
    shape = {**dict.fromkeys(FRICTION), "stribeck": {"stribeck_speed": 0.15}}
    rng = np.random.default_rng(1)
    model = with_random_numbers(ARM, rng, (*FRICTION, "stribeck"))
    right = fb.identify(ARM, log(model, rng, noise=0.005), friction=shape)
    assert all(x.law_fits for x in right.joints)


def test_the_model_is_physical_and_predicts_what_it_has_not_seen():
    rng = np.random.default_rng(4)
    model = with_random_numbers(ARM, rng, (*FRICTION, "load"))
    used, unseen = log(model, rng), log(model, rng)
    found = fb.identify(ARM, used, validate=unseen)
    assert found.outcome == "predicts"
    assert found.trusted
    _, q, qd, qdd = motion(3, rng)
    tau = fb.inverse_dynamics(model, q, qd, qdd)
    gap = fb.inverse_dynamics(found.model, q, qd, qdd) - tau
    assert np.all(np.sqrt(np.mean(gap**2, axis=0)) < 0.02 * np.sqrt(np.mean(tau**2, axis=0)))
    for x in found.joints:
        assert x.validation == pytest.approx(x.model, rel=0.3)
        assert x.model < 1.1 * x.regression + 1e-3
    for body in found.model.bodies:
        assert body.inertias[0].inertia.fault() is None
        drive = body.joint.drive
        assert min(drive.viscous, drive.coulomb, drive.cube_root, drive.quadratic, drive.rotor) >= 0
        assert 0.0 <= drive.load_friction < 1.0
    assert any("mass matrix is positive definite in every posture" in x for x in found.notices)
    assert any("every interval holds 0, quadratic and cube_root (" in x for x in found.next)
    assert np.all(np.linalg.eigvalsh(fb.mass_matrix(found.model, q)) > 0.0)


def test_what_no_mass_was_given_for_is_a_guess_that_the_model_carries_along(tmp_path):
    rng = np.random.default_rng(6)
    model = with_random_numbers(ARM, rng)
    found = fb.identify(ARM, log(model, rng), friction=FRICTION)
    assert "single masses are not told" in found.verdict
    assert found.verdict.startswith("Not validated")
    assert not found.trusted
    assert any("guesses from its geometry" in x for x in found.notices)
    assert "link2.m" in found.prior_alone
    assert "link2.hx" not in [x for x in found.prior_alone if x.startswith("joint")]
    fb.save(found.model, tmp_path / "arm.toml")
    again = fb.load(str(tmp_path / "arm.toml"))
    assert again == found.model
    assert again.is_estimated
    known = fb.identify(ARM, log(model, rng), friction=FRICTION, prior=[3.0, 2.5, 2.0])
    masses = [body.inertias[0].inertia.mass for body in known.model.bodies]
    np.testing.assert_allclose(masses, [3.0, 2.5, 2.0], rtol=1.0)
    assert "near the given ones" in known.verdict


def test_gains_of_currents_are_found_up_to_a_factor_or_with_known_masses():
    rng = np.random.default_rng(8)
    model = with_random_numbers(ARM, rng, FRICTION)
    gains = np.array([12.0, 9.0, 7.0])
    used, unseen = (log(model, rng, gains=gains) for _ in range(2))
    unknown = fb.identify(ARM, used, validate=unseen, friction=FRICTION)
    assert not unknown.scale_known
    assert not unknown.trusted
    assert any(x.startswith("The scale is not told") for x in unknown.notices)
    relative = unknown.gains / gains
    np.testing.assert_allclose(relative / relative.mean(), 1.0, rtol=0.02)
    assert unknown.scale == (0.0, np.inf)
    known = fb.identify(ARM, used, validate=unseen, friction=FRICTION, prior=model)
    np.testing.assert_allclose(known.gains, gains, rtol=0.06)
    assert any("that the given masses alone tell" in x for x in known.notices)
    assert not known.trusted
    assert "% alone" in known.verdict
    true = truth(model, known)
    base = [x for x in known.parameters if x.kind == "inertial"]
    assert np.mean([x.lower < true[x.name] < x.upper for x in base]) > 0.85


def test_a_load_of_known_mass_tells_the_scale_of_gains():
    rng = np.random.default_rng(103)  # whose bodies lie on the other side of estimated shapes
    model = with_random_numbers(ARM, rng, FRICTION)
    gains = np.array([12.0, 9.0, 7.0])
    empty = log(model, rng, gains=gains)
    loaded = log(model.with_payload(3.0, com=[0.03, 0.02, 0.05]), rng, gains=gains)
    found = fb.identify(ARM, empty, friction=FRICTION, loaded=loaded, load=3.0)
    assert found.scale_known
    assert found.scale[0] > 0.97
    np.testing.assert_allclose(found.gains, gains, rtol=0.01)
    assert any("that the load of 3 kg tells" in x for x in found.notices)
    with pytest.raises(fb.FreebodyError, match="do not show the load"):
        fb.identify(ARM, empty, friction=FRICTION, loaded=empty, load=3.0)
    with pytest.raises(fb.FreebodyError, match="go together"):
        fb.identify(ARM, empty, load=3.0)


def test_gains_from_known_bodies_are_right_on_average_and_from_masses_within_what_is_said():
    gains, of_bodies, of_masses = np.array([12.0, 9.0, 7.0]), [], []
    for seed in range(4, 8):  # with 5, gains held at first were wrong by a factor of 100
        rng = np.random.default_rng(seed)
        model = with_random_numbers(ARM, rng, FRICTION)
        used = log(model, rng, gains=gains)
        masses = [body.inertias[0].inertia.mass for body in model.bodies]
        for prior, found in ((model, of_bodies), (masses, of_masses)):
            known = fb.identify(ARM, used, friction=FRICTION, prior=prior)
            found.append(np.log(known.gains / gains))
            np.testing.assert_allclose(np.ptp(found[-1]), 0.0, atol=0.05)
    assert abs(np.mean(of_bodies)) < 0.02
    assert np.all(np.abs(of_masses) < 0.5)


EXCHANGED = [1, 0, 2]
WRONG = {
    "sign of torques": (lambda x: replace(x, torque=x.torque * [1, -1, 1]), "pushes.* joint2:"),
    "sign of a joint": (
        lambda x: replace(x, position=x.position * [1, -1, 1], velocity=x.velocity * [1, -1, 1]),
        "pushes.* joint2:",
    ),
    "columns of torques": (lambda x: replace(x, torque=x.torque[:, EXCHANGED]), "pushes.* joint1"),
    "torques in N cm": (lambda x: replace(x, torque=x.torque * [1, 100, 1]), "No robot of this"),
}


@pytest.mark.sample(2)
@pytest.mark.parametrize("name", WRONG)
def test_torques_that_no_robot_gives_are_told_and_not_trusted(name):
    change, said = WRONG[name]
    rng = np.random.default_rng(11)
    model = with_random_numbers(ARM, rng, FRICTION)
    used, unseen = log(model, rng), log(model, rng)
    good = fb.identify(ARM, used, validate=unseen, friction=FRICTION)
    assert good.trusted
    assert not any("pushes" in x or "No robot" in x for x in good.notices)
    found = fb.identify(ARM, change(used), validate=change(unseen), friction=FRICTION)
    assert found.outcome == "fails"
    assert any(re.search(said, x) for x in found.notices)
    assert found.verdict.startswith("Does not predict")


def test_a_load_that_was_not_said_is_told():
    rng = np.random.default_rng(11)
    model = with_random_numbers(ARM, rng, FRICTION)
    carrying = log(model.with_payload(2.0), rng)
    found = fb.identify(ARM, log(model, rng), validate=carrying, friction=FRICTION)
    assert found.outcome == "fails"
    assert any("carries the same in all logs" in x for x in found.next)


def test_springs_of_the_model_are_known():
    rng = np.random.default_rng(9)
    model = with_random_numbers(ARM, rng).with_drive("joint2", stiffness=20.0, rest=0.3)
    sprung = ARM.with_drive("joint2", stiffness=20.0, rest=0.3)
    made = exact_log(model, rng)
    found = fb.identify(sprung, made, friction=("viscous", "coulomb"), smooth=0.0)
    true = truth(model, found)
    assert max(abs(x.value - true[x.name]) for x in found.parameters) < 1e-9
    assert found.model.bodies[1].joint.drive.stiffness == 20.0


def test_what_a_motion_does_not_tell_is_named():
    rng = np.random.default_rng(10)
    model = with_random_numbers(fb.load("scara"), rng)
    found = fb.identify(fb.load("scara"), log(model, rng), friction=FRICTION)
    # the weight of the quill and a constant torque of its drive are the same
    assert np.isnan(found["quill.m"].lower)
    assert np.isnan(found["joint3.offset"].lower)
    assert "quill.m" in found.untold
    assert not np.isnan(found["joint1.viscous"].lower)


def test_one_parameter_and_the_report():
    rng = np.random.default_rng(11)
    found = fb.identify(ARM, log(with_random_numbers(ARM, rng), rng), friction=FRICTION)
    assert found.combination("link3.Izz") == {"link3.Izz": 1.0}
    assert found.written("link3.Izz") == "link3.Izz"
    terms = found.written("link2.hx").split(" + ")
    assert terms[0] == "link2.hx"
    assert "0.4 link3.m" in terms or "0.4 link2.m" in terms
    text = str(found)
    assert "joint2.coulomb" in text
    assert found.verdict in text
    with pytest.raises(fb.UnknownNameError, match=r"link3\.Izz"):
        found["link3.izz"]


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"friction": ("viscos",)}, "Did you mean 'viscous'"),
        ({"friction": ("stribeck",)}, 'friction={"stribeck": {"stribeck_speed": …}}'),
        ({"friction": ("efficiency",)}, "Take 'load' for losses in a gear"),
        ({"friction": {"coulomb": {"speed": 1.0}}}, "no number 'speed'"),
        ({"prior": [1.0, 2.0]}, "expected one above 0 kg for each of the bodies link1, link2"),
        ({"prior": fb.load("2R")}, "it needs those of 'arm'"),
        ({"cutoff": 60.0}, "less than half the sampling rate"),
    ],
)
def test_what_cannot_be_identified_is_refused_with_the_remedy(options, said):
    rng = np.random.default_rng(0)
    used = log(with_random_numbers(ARM, rng), rng, duration=5.0)
    with pytest.raises(fb.FreebodyError) as refused:
        fb.identify(ARM, used, **options)
    assert said in str(refused.value)


def test_logs_that_tell_nothing_are_refused():
    rng = np.random.default_rng(0)
    model = with_random_numbers(ARM, rng)
    short = log(model, rng, duration=2.5)
    with pytest.raises(fb.FreebodyError, match="too few to tell its friction"):
        fb.identify(ARM, short)
    kept = log(model, rng, duration=5.0)
    columns = ("time", "position", "velocity", "torque", "measured")
    for function, every in (("identify", 5), ("detect_collisions", 2)):
        slow = replace(kept, **{name: getattr(kept, name)[::every] for name in columns})
        with pytest.raises(fb.FreebodyError, match=rf"{function}: .* {100 // every} samples"):
            getattr(fb, function)(model, slow)
    with pytest.raises(fb.FreebodyError, match="give at least one log"):
        fb.identify(ARM, [])
    with pytest.raises(fb.FreebodyError, match="expected those of the model in its order"):
        fb.identify(fb.load("2R"), short)
    with pytest.raises(fb.FreebodyError, match="logs are read of joints that turn or slide"):
        fb.identify(fb.load("quadrotor"), short)
    mixed = [log(model, rng), log(model, rng, gains=np.ones(3))]
    with pytest.raises(fb.FreebodyError, match="give torque constants"):
        fb.identify(ARM, mixed)


def test_no_friction_by_load_is_looked_for_where_a_joint_follows_another():
    """Two fingers of which one follows the other: what each transmits is not determined. The other
    usual laws are found."""
    fixed = {f"panda_joint{k}": x for k, x in enumerate([0.0, 0.3, 0.0, -1.8, 0.0, 1.6, 0.0], 1)}
    hand = fb.load("panda").with_locked(fixed)
    run = log(hand.with_drive("panda_finger_joint1", viscous=2.0), np.random.default_rng(0))
    found = fb.identify(hand, run)
    laws = {x.name.partition(".")[2] for x in found.parameters if x.kind == "friction"}
    assert laws == {"viscous", "coulomb", "offset", "cube_root", "quadratic"}
    viscous = found["panda_finger_joint1.viscous"]
    assert viscous.lower < 2.3 < viscous.upper  # with 0.3 of the other finger
    for function in (fb.identify, fb.identify_payload):
        with pytest.raises(fb.FreebodyError, match=r"_joint2' follows .*--lock"):
            function(hand, run, friction=["viscous", "load"])
