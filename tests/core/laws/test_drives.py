"""Laws of drives: each as a law of its own, by its record, and all of them in a robot."""

import inspect

import numpy as np
import pytest
from scipy.special import ellipk, lambertw

import freebody as fb
from freebody import FreebodyError, ModelError
from freebody.model.drives import LAWS, NUMBERS
from freebody.model.drives.acting import ActingLaw, DriveScalars, every_law
from freebody.model.drives.law_numbers import LawNumbers
from freebody.model.tree import Coordinates
from freebody.motion.smooth_friction import simple_friction
from support.exported import passes, require

VALUES = {
    "viscous": 0.4, "coulomb": 0.3, "rotor": 1e-3, "gear": 20.0, "stiffness": 5.0, "rest": 0.2,
    "stribeck": 0.5, "stribeck_speed": 0.3, "offset": 0.1, "asymmetric": 0.07, "quadratic": 0.2,
    "cube_root": 0.6, "saturating": 0.35, "saturating_speed": 0.4,
    "hardening": 3.0, "hardening_rest": -0.1,
    "cogging": 0.25, "cogging_count": 6.0, "cogging_phase": 0.7,
    "load_friction": 0.15, "efficiency": 0.8, "back_efficiency": 0.7,
}  # fmt: skip
"""A number for each of all laws."""
EVERY = [law for law in LAWS.values() if law.losses is None]
"""All laws but the losses of what is transmitted, which have tests of their own."""
TORQUES = [law for law in EVERY if law.torque is not None]
STATES = [(0.3, 0.5), (-0.7, 0.05), (0.1, -0.2), (0.6, -2.0)]


def named(law):
    return law.name


def drive_of(*laws):
    """A drive with these laws at coordinate 0."""
    acting = [x for x in every_law(VALUES.__getitem__) if x.law in laws]
    return DriveScalars(tuple(acting), Coordinates((0,), (0,), 1.0, 0.0))


def numbers(*laws):
    """The numbers of laws, as a drive takes them."""
    return {number.name: VALUES[number.name] for law in laws for number in law.numbers}


def arm(*laws):
    """A planar arm with the laws in its first and last joint."""
    drive = fb.Drive(**numbers(*laws))
    return fb.planar(
        "RRP",
        m=[1.0, 2.0, 0.5], lc=[0.3, 0.2, 0.1], l=[0.7, 0.6, 0.4], I=[0.1, 0.2, 0.05],
        drives=[drive, None, drive],
    )  # fmt: skip


def block(**given):
    """A mass of 2 kg that slides without weight under a drive."""
    slide = fb.planar("P", l=[0], lc=[0], m=[2], I=[0], drives=[fb.Drive(**given)])
    return slide.replace(gravity=0.0)


Q, QD, QDD = [0.3, -0.5, 0.2], [0.8, 0.4, -0.6], [1.0, -2.0, 0.7]


def test_every_number_is_tried():
    assert VALUES.keys() == NUMBERS.keys()


def test_type_checkers_see_every_number():
    seen = inspect.signature(LawNumbers).parameters
    assert {name: x.default for name, x in seen.items()} == {
        name: number.default for name, number in NUMBERS.items()
    }
    assert list(LawNumbers.__annotations__) == list(NUMBERS)


# ------------------------------------------------------------ each law alone
@pytest.mark.parametrize("law", TORQUES, ids=named)
def test_slopes_are_the_derivatives_of_the_torque(law):
    drive, h = drive_of(law), 1e-6
    for q, qd in STATES:
        by_position, by_rate = drive.slopes((q,), (qd,))
        above, below = (drive.torque((q + s,), (qd,)) for s in (h, -h))
        assert by_position == pytest.approx((above - below) / (2 * h), rel=1e-7, abs=1e-9)
        above, below = (drive.torque((q,), (qd + s,)) for s in (h, -h))
        assert by_rate == pytest.approx((above - below) / (2 * h), rel=1e-7, abs=1e-9)


@pytest.mark.parametrize("law", EVERY, ids=named)
def test_a_law_is_linear_in_its_parameters_and_in_the_sign(law):
    (x,) = drive_of(law).laws
    for q, qd in STATES:
        if law.torque is not None:
            parts = zip(law.parameter_values(x.p), law.torques(x.p, q, qd, 0.4), strict=True)
            expected = law.torque(x.p, q, qd, 0.4)
            assert sum(value * torque for value, torque in parts) == pytest.approx(expected)
            still, forward, back = (law.torque(x.p, q, qd, s) for s in (0.0, 1.0, -1.0))
            assert forward + back == pytest.approx(2 * still, abs=1e-15)
            assert law.signed or forward == still
        if law.energy is not None:
            parts = [
                [value * unit for value, unit in zip(law.parameter_values(x.p), units, strict=True)]
                for units in (law.energies(x.p, q), law.energies(x.p, 0.0))
            ]
            change = law.energy(x.p, q) - law.energy(x.p, 0.0)
            assert sum(parts[0]) - sum(parts[1]) == pytest.approx(change)
    entries = [np.asarray(value) for value in law.parameter_values(x.p)]
    found = numbers(law) | law.numbers_of(entries, VALUES, "here")
    assert {name: float(value) for name, value in found.items()} == pytest.approx(numbers(law))


@pytest.mark.parametrize("law", TORQUES, ids=named)
def test_what_a_law_takes_is_stored_or_lost(law):
    drive, h = drive_of(law), 1e-6
    for q, qd in STATES:
        torque = drive.torque((q,), (qd,))
        if law.energy is not None:
            above, below = (drive.energy((q + s,)) for s in (h, -h))
            assert torque == pytest.approx((above - below) / (2 * h), rel=1e-7)
        elif law.numbers[0].refused is not None:  # friction, which only resists
            assert torque * qd > 0.0


@pytest.mark.parametrize("law", TORQUES, ids=named)
def test_a_law_seen_from_the_other_direction(law):
    """Where the joint counts the other way, or from another zero, the torque is the same."""
    (x,) = drive_of(law).laws
    own = tuple(numbers(law).values())
    for flip, offset in ((-1.0, 0.0), (1.0, 0.3), (-1.0, -0.4)):
        other = dict(zip(numbers(law), law.counted_otherwise(own, flip, offset), strict=True))
        p = law.scalars_of(other.__getitem__)
        for q, qd in STATES:
            expected = flip * law.torque(x.p, q, qd, np.sign(qd))
            found = law.torque(p, flip * q + offset, flip * qd, flip * np.sign(qd))
            assert found == pytest.approx(expected, abs=1e-14)


def test_the_law_itself():
    rate, v = 0.25, VALUES["stribeck_speed"]
    expected = {
        "stribeck": 0.5 * np.exp(-((rate / v) ** 2)), "cube_root": 0.6 * rate ** (1 / 3),
        "offset": 0.1, "asymmetric": 0.07 * rate, "quadratic": 0.2 * rate**2,
        "hardening": 3.0 * 0.5**3, "viscous": 0.4 * rate, "coulomb": 0.3, "spring": 5.0 * 0.2,
        "cogging": 0.25 * np.sin(6.0 * 0.4 - 0.7), "saturating": 0.35 * rate / (1.0 + rate / 0.4),
    }  # fmt: skip
    assert {law.name: drive_of(law).torque((0.4,), (rate,)) for law in TORQUES} == pytest.approx(
        expected
    )
    assert drive_of(LAWS["cube_root"]).torque((0.0,), (0.0,)) == 0.0
    assert drive_of(LAWS["rotor"]).inertia == pytest.approx(1e-3 * 400)


# ------------------------------------------------------------ in a robot
@pytest.fixture(scope="module")
def whole():
    return arm(*EVERY)


def test_forward_dynamics_undoes_inverse_dynamics(whole):
    tau = fb.inverse_dynamics(whole, Q, QD, QDD)
    np.testing.assert_allclose(fb.forward_dynamics(whole, Q, QD, tau), QDD, rtol=1e-12)
    plain = fb.inverse_dynamics(arm(), Q, QD, QDD)
    own = [
        drive_of(*EVERY).torque((Q[k],), (QD[k],)) + 0.4 * QDD[k] if k != 1 else 0.0
        for k in range(3)
    ]
    np.testing.assert_allclose(tau - plain, own, rtol=1e-12)


def test_derivatives_are_those_of_the_dynamics(whole):
    tau, h = fb.inverse_dynamics(whole, Q, QD, QDD), 1e-6
    ways = (
        (fb.inverse_dynamics_derivatives, fb.inverse_dynamics, QDD),
        (fb.forward_dynamics_derivatives, fb.forward_dynamics, tau),
    )
    for derivatives, function, last in ways:
        state = np.array([Q, QD, last])
        for k, found in enumerate(derivatives(whole, *state)):
            shifts = np.zeros((3, 3, 3))
            shifts[np.arange(3), k, np.arange(3)] = h
            above, below = (
                function(whole, *np.moveaxis(state + s, 1, 0)) for s in (shifts, -shifts)
            )
            np.testing.assert_allclose(found, (above - below).T / (2 * h), rtol=1e-6, atol=1e-7)


def test_the_regressor_has_a_column_for_each_parameter_of_a_law(whole):
    pi = fb.inertial_parameters(whole)
    names = [name.removeprefix("joint1.") for name in pi if name.startswith("joint1.")]
    assert names == [name for law in EVERY for name in law.parameters]
    tau = fb.inverse_dynamics(whole, Q, QD, QDD)
    Y = fb.regressor(whole, Q, QD, QDD)
    np.testing.assert_allclose(Y @ np.array(list(pi.values())), tau, rtol=1e-12)
    again = whole.with_inertial_parameters(pi)
    np.testing.assert_allclose(fb.inverse_dynamics(again, Q, QD, QDD), tau, rtol=1e-12)
    fewer = fb.inertial_parameters(arm(LAWS["viscous"], LAWS["stribeck"]))
    usual = [name for law in EVERY if law.usual for name in law.parameters]
    assert [n.partition(".")[2] for n in fewer if "joint1." in n] == [*usual, "stribeck"]


def test_energy_is_what_the_torque_gives_less_what_friction_takes(whole):
    tau, h = [1.0, -2.0, 0.5], 1e-6
    qdd = fb.forward_dynamics(whole, Q, QD, tau)

    def energy(t):
        q = np.add(Q, t * np.array(QD)) + 0.5 * t * t * qdd
        qd = np.add(QD, t * qdd)
        return fb.kinetic_energy(whole, q, qd) + fb.potential_energy(whole, q)

    rubbing = drive_of(*(law for law in EVERY if law.feature == "friction"))
    lost = sum(QD[k] * rubbing.torque((Q[k],), (QD[k],)) for k in (0, 2))
    gained = (energy(h) - energy(-h)) / (2 * h)
    assert gained == pytest.approx(np.dot(tau, QD) - lost, rel=1e-7)


def test_numbers_by_name_families_and_features(whole):
    tau = fb.inverse_dynamics(whole, Q, QD, QDD)
    changed = whole.bind({"joint1.friction.stribeck_speed": 0.9, "joint3.spring.hardening": 7.0})
    other = whole.with_drive("joint1", stribeck_speed=0.9).with_drive("joint3", hardening=7.0)
    np.testing.assert_array_equal(
        fb.inverse_dynamics(changed, Q, QD, QDD), fb.inverse_dynamics(other, Q, QD, QDD)
    )
    several = whole.with_drive("joint1", stribeck=np.array([0.0, 0.5]))
    each = [whole.with_drive("joint1", stribeck=x) for x in (0.0, 0.5)]
    np.testing.assert_allclose(
        fb.inverse_dynamics(several, Q, QD, QDD),
        [fb.inverse_dynamics(model, Q, QD, QDD) for model in each],
        rtol=1e-13,
    )
    np.testing.assert_allclose(fb.inverse_dynamics(several[1], Q, QD, QDD), tau, rtol=1e-13)
    bare = whole.without("friction", "rotors", "springs")
    np.testing.assert_allclose(
        fb.inverse_dynamics(bare, Q, QD, QDD), fb.inverse_dynamics(arm(), Q, QD, QDD), rtol=1e-13
    )


def test_a_law_that_is_none_costs_nothing():
    usual, more = arm(LAWS["viscous"]), arm(LAWS["viscous"], LAWS["stribeck"])
    none = more.with_drive("joint1", stribeck=0.0).with_drive("joint3", stribeck=0.0)
    sizes = [
        sum(fb.kernel(model, "forward_dynamics").program.operations.values())
        for model in (usual, none, more)
    ]
    assert sizes[0] == sizes[1] < sizes[2]
    assert fb.kernel(more, "inverse_dynamics").program.operations["exp"] == 2  # of two joints
    assert none.structure is usual.structure


def test_files_have_all_numbers(whole, tmp_path):
    fb.save(whole, tmp_path / "arm.toml")
    again = fb.load(tmp_path / "arm.toml")
    for k in (0, 2):
        assert again.bodies[k].joint.drive == whole.bodies[k].joint.drive
    text = (tmp_path / "arm.toml").read_text()
    assert text.count("stribeck_speed") == 2
    fb.save(arm(LAWS["viscous"]), tmp_path / "plain.toml")
    assert "stribeck" not in (tmp_path / "plain.toml").read_text()
    (tmp_path / "lacking.toml").write_text(text.replace("stribeck_speed = 0.3, ", "", 1))
    with pytest.raises(FreebodyError, match="stribeck_speed"):
        fb.load(tmp_path / "lacking.toml")


def test_what_no_drive_has():
    arm = fb.planar("R")
    for given, words in (
        ({"stribeck": 0.1}, r"joint 'joint1': stribeck_speed is 0; give a number above 0\."),
        ({"quadratic": -1.0}, r"quadratic friction -1 is negative; give it as 0 or more\."),
    ):
        with pytest.raises(ModelError, match=words):
            arm.with_drive("joint1", **given)
    with pytest.raises(FreebodyError, match=r"^no number 'colomb' in a drive\. Did you mean 'cou"):
        arm.with_drive("joint1", colomb=1.0)


ALONE = [
    (law, number)
    for law in LAWS.values()
    for number in law.numbers[1:]
    if not number.waits and number.below == np.inf
]


@pytest.mark.parametrize(("law", "number"), ALONE, ids=lambda x: x.name)
def test_a_number_without_its_strength_is_refused(law, number):
    """As files refuse it; where the strength is given too, or was before, it is taken."""
    alone, arm = {number.name: VALUES[number.name]}, fb.planar("R")
    words = rf"{number.name} is given without {law.strength}, without which it has no effect; give"
    with pytest.raises(ModelError, match=f"^Drive: {words}"):
        fb.Drive(**alone)
    with pytest.raises(ModelError, match=f"joint 'joint1': {words}"):
        arm.with_drive("joint1", **alone)
    label = f"joint1.{number.label}"
    if label in [x.name for x in fb.parameters(arm)]:  # numbers that are listed may be bound
        assert (
            fb.parameters(arm.bind({label: alone[number.name]}))[label].value == VALUES[number.name]
        )
    whole = {x.name: VALUES[x.name] for x in law.numbers}
    assert getattr(fb.Drive(**whole), number.name) == VALUES[number.name]
    off = arm.with_drive("joint1", **whole).with_drive("joint1", **{law.strength: 0.0})
    again = off.with_drive("joint1", viscous=1.0)  # what stands there from before is no matter
    with pytest.raises(ModelError, match=words):
        again.with_drive("joint1", **alone)
    arm.with_drive("joint1", **whole).with_drive("joint1", **alone)


def test_a_gear_may_wait_for_its_rotor_and_turn_the_other_way():
    arm = fb.planar("R", m=[1], l=[1], lc=[0.5], I=[0.1])
    there, back = (
        arm.with_drive("joint1", gear=n).with_drive("joint1", rotor=0.1) for n in (5, -5)
    )
    assert fb.mass_matrix(there, [0.3]) == fb.mass_matrix(back, [0.3])
    text = PENDULUM.format(drive="rotor = { inertia = 1, gear = 0 }")
    with pytest.raises(FreebodyError, match=r"joint 'a': gear is 0; give the ratio"):
        fb.load(text=text, format="toml", physical="ignore")


@pytest.mark.parametrize(
    "give",
    [
        *(lambda x, name=name: fb.Drive(**{name: x}) for name in VALUES),
        lambda x: fb.Limits(lower=x),
        lambda x: fb.planar("R", m=[x]),
        lambda x: fb.planar("R").with_drive("joint1", viscous=np.array([0.5, x], dtype=type(x))),
        lambda x: fb.planar("R").with_payload(x),
        lambda x: fb.planar("R").bind(m1=x),
        lambda x: fb.planar("R").with_strut("s", ("base", "tip"), stiffness=x),
        lambda x: fb.planar("R").replace(gravity=x),
        lambda x: fb.Bearing("b", "ball", x),
        lambda x: fb.export_fmu(fb.load("2R"), "x.fmu", step=x),
    ],
)
@pytest.mark.parametrize("value", [True, np.True_])
def test_booleans_are_no_numbers(give, value):
    words = r"True_? is (not|neither)|not an array of real n|holds bool v|is (np\.)?True_?, expect"
    with pytest.raises(FreebodyError, match=words):
        give(value)


PENDULUM = """
[[link]]
name = "ground"
[[link]]
name = "bob"
mass = 2.0
com = [0.3, 0.1, 0]
[[joint]]
name = "a"
kind = "revolute"
parent = "ground"
child = "bob"
axis = "y"
{drive}
"""
SLIDE = """
[[link]]
name = "rail"
[[link]]
name = "cart"
mass = 2
[[link]]
name = "arm"
mass = 1
[[joint]]
name = "x"
kind = "{kind}"
parent = "rail"
child = "cart"
axis = "x"
{drive}
[[joint]]
name = "y"
kind = "{kind}"
parent = "cart"
child = "arm"
axis = "y"
mimic = {{ joint = "x", offset = {offset} }}
[home]
x = {home}
"""


@pytest.mark.usefixtures("numpy_kernels")
@pytest.mark.parametrize("law", list(LAWS.values()), ids=named)
def test_numbers_of_files_are_refused_or_computed_with(law):
    """Also where the policy is to ignore what no joint has."""
    for number in law.numbers:
        for value in (0.0, -0.5):
            drive = [
                f"{table}.{key} = {value if x is number else VALUES[x.name]}"
                for x in law.numbers
                for table, key in [x.place]
            ]
            text = PENDULUM.format(drive="\n".join(drive))
            fault = number.refused(value) if number.strict and number.refused else None
            if fault:
                with pytest.raises(FreebodyError, match=r"joint .a.: "):
                    fb.load(text=text, format="toml", physical="ignore")
                continue
            model = fb.load(text=text, format="toml", physical="ignore")
            assert np.isfinite(fb.inverse_dynamics(model, [0.4], [0.3], [1.0])).all()


def test_numbers_of_a_slide_are_no_angles():
    good = {"kind": "prismatic", "drive": "", "offset": 0.1, "home": 0.2}
    fb.load(text=SLIDE.format(**good), format="toml")
    for wrong in (
        {"drive": 'spring = { stiffness = 3, rest = "30 deg" }'},
        {"drive": 'friction = { stribeck = 0.1, stribeck_speed = "30 deg/s" }'},
        {"offset": '"30 deg"'},
        {"home": '"30 deg"'},
    ):
        with pytest.raises(FreebodyError, match=r"is '30 deg(/s)?', expected a number"):
            fb.load(text=SLIDE.format(**good | wrong), format="toml")
        turning = fb.load(text=SLIDE.format(**good | wrong | {"kind": "revolute"}), format="toml")
        assert turning.nv == 1


@pytest.mark.parametrize("precision", ["float32", "float64"])
def test_kernels_of_both_precisions(whole, precision):
    found = fb.kernel(whole, "inverse_dynamics", dtype=precision)(Q, QD, QDD)
    expected = fb.inverse_dynamics(whole, Q, QD, QDD)
    np.testing.assert_allclose(found, expected, rtol=1e-5 if precision == "float32" else 1e-13)


@pytest.mark.sample(2)
@pytest.mark.parametrize("language", ["c", "javascript", "jax"])
def test_source_text_of_all_laws(whole, language, tmp_path):
    fb.export(whole, "inverse_dynamics", tmp_path, language)
    require(language)
    passes(tmp_path, language, "inverse_dynamics")


def test_numbers_of_laws_as_inputs(whole):
    names = ["joint1.friction.stribeck_speed", "joint3.spring.hardening"]
    kernel = fb.kernel(whole, "inverse_dynamics", inputs=names)
    changed = whole.bind(dict(zip(names, (0.9, 7.0), strict=True)))
    found = kernel(Q, QD, QDD, [0.9, 7.0])
    np.testing.assert_allclose(found, fb.inverse_dynamics(changed, Q, QD, QDD), rtol=1e-13)


def test_derivations_have_the_laws_that_are_polynomials():
    text = fb.equations(
        fb.planar("RP", drives=[fb.Drive(asymmetric="e", offset="o"), fb.Drive(quadratic="c")])
    ).text()
    assert "+ o + e sgn(θ̇₁) θ̇₁" in text
    assert "+ c ḋ₂² sgn(ḋ₂)" in text
    for drive, words in (
        (fb.Drive(stribeck=0.1, stribeck_speed=0.2), "the Stribeck friction at body 'link1' has n"),
        (fb.Drive(stribeck="l", stribeck_speed="v"), "the Stribeck friction has no closed form"),
        (fb.Drive(cogging="a", cogging_count="n"), "the cogging torque has no closed form"),
        (fb.Drive(cogging="a", cogging_count=840), "the cogging torque at body 'link1' has no cl"),
        (fb.Drive(cogging="a", cogging_count=2.5), "the cogging torque at body 'link1' has no cl"),
    ):
        with pytest.raises(FreebodyError, match=f"^{words}"):
            fb.derive(fb.planar("R", drives=[drive]))


def test_derivations_tell_what_stores_energy():
    drive = fb.Drive(stiffness="k", hardening="h", cogging="a", cogging_count=3)
    model = fb.planar("R", drives=[drive])
    text = " ".join(fb.derive(model, "lagrange").text().split())
    assert "potential energy of the springs and cogging torques" in text
    assert "half its stiffness times the square of its deflection; that of a hardening" in text
    assert "is its amplitude over the number of cogs in a turn, times 1 less the cosine" in text
    assert "a sin 3θ₁ cogging torque of joint 1" in text
    text = " ".join(fb.derive(model, "newton-euler").text().split())
    assert "The other terms are those of the joint's spring and cogging torque." in text
    answer = "tau1 = (m1 lc1^2 + I1) ddtheta1 + m1 g lc1 cos(theta1) + {} sin(3 theta1)"
    model = fb.planar("R", drives=[fb.Drive(cogging="a", cogging_count=3)])
    assert "V_s = ⅓ a (1 − cos 3θ₁)" in fb.derive(model, "lagrange").text()
    assert fb.check(model, answer.format("a"))
    assert not fb.check(model, answer.format("3 a"))


# ------------------------------------------------------------ in motion
def test_friction_that_no_plan_knows_is_refused():
    with pytest.raises(
        FreebodyError, match=r"^plan: the quadratic friction of body 'link1' is nei"
    ):
        simple_friction("plan", block(quadratic=0.2))


RUBBING = {
    "stribeck": {"coulomb": 0.3, "stribeck": 0.8, "stribeck_speed": 0.2},
    "stribeck alone": {"stribeck": 0.8, "stribeck_speed": 0.2, "viscous": 0.1},
    "two directions": {"offset": 0.3, "coulomb": 0.5, "quadratic": 0.4, "asymmetric": 0.2},
}


@pytest.mark.sample(1)
@pytest.mark.parametrize("name", RUBBING)
def test_dry_friction_is_the_limit_of_smooth_friction(name):
    model = block(**RUBBING[name])
    push = fb.compile(lambda t: [1.5 * fb.math.sin(3.0 * t)], {"t": ()}, {"tau": 1})
    given = model, [0.0], [0.0], np.linspace(0.0, 4.0, 9), push
    dry = fb.simulate(*given, friction="dry").q.values
    assert np.ptp(dry) > 0.01
    apart = [
        np.abs(fb.simulate(*given, friction_width=width, tolerance=1e-8).q.values - dry).max()
        for width in (1e-3, 1e-4)
    ]
    assert apart[1] < 3e-3
    assert apart[0] / apart[1] > 6.0
    steps = {"method": "implicit", "step": 1e-3, "friction_width": 1e-4}
    assert np.abs(fb.simulate(*given, **steps).q.values - dry).max() < 6e-3


def test_closed_forms_of_what_slows_down():
    t, m = np.array([0.0, 0.5, 1.0, 3.0]), 2.0
    for friction in ("smooth", "dry"):
        run = fb.simulate(block(quadratic=0.6), [0.0], [1.5], t, friction=friction)
        assert run.qd.values[:, 0] == pytest.approx(1.5 / (1 + 0.6 * 1.5 * t / m), rel=1e-7)
    left = np.maximum(0.5 ** (2 / 3) - 2 * 0.9 / (3 * m) * t, 0.0) ** 1.5
    for more in ({"friction": "dry"}, {}, {"method": "implicit", "step": 1e-3}):
        run = fb.simulate(block(cube_root=0.9), [0.0], [0.5], t, **more)
        assert run.qd.values[:, 0] == pytest.approx(left, abs=1e-5)
    run = fb.simulate(block(asymmetric=0.3, viscous=0.5), [0.0], [[1.0], [-1.0]], t)
    expected = [np.exp(-0.8 * t / m), -np.exp(-0.2 * t / m)]
    assert run.qd.values[..., 0] == pytest.approx(np.array(expected), rel=1e-7)


def test_saturating_friction_slows_down_by_lambert_w():
    """m v' = -c v / (1 + v/u) has the solution v + u log v = v(0) + u log v(0) - c u t / m."""
    t, u, start = np.array([0.0, 0.5, 1.0, 3.0]), 0.4, 1.5
    expected = u * lambertw(start / u * np.exp(start / u - 0.9 * t / 2.0)).real
    model = block(saturating=0.9, saturating_speed=u)
    for more, error in (
        ({}, 1e-8),
        ({"friction": "dry"}, 1e-8),
        ({"method": "rk4", "step": 1e-3}, 1e-10),
        ({"method": "implicit", "step": 1e-3}, 1e-4),
    ):
        run = fb.simulate(model, [0.0], [[start], [-start]], t, **more)
        assert run.qd.values[..., 0] == pytest.approx(np.array([expected, -expected]), abs=error)


def test_what_rests_is_held_up_to_the_whole_of_dry_friction():
    def moved(model, push):
        run = fb.simulate(model, [0.0], [0.0], [0.0, 3.0], [push], friction="dry")
        return run.q.values[-1, 0]

    hard = block(coulomb=0.3, stribeck=0.8, stribeck_speed=0.2)
    assert moved(hard, 1.09) == 0.0
    assert moved(hard, 1.2) > 0.3  # what moves is held less
    askew = block(coulomb=0.5, offset=0.3)
    found = [np.sign(moved(askew, push)) for push in (0.79, 0.81, -0.19, -0.21)]
    assert found == [0.0, 1.0, 0.0, -1.0]


def test_a_hardening_spring_keeps_its_energy():
    model = block(hardening=4.0, hardening_rest=0.1, stiffness=2.0)
    run = fb.simulate(model, [0.9], [0.0], np.linspace(0.0, 6.0, 13))
    energy = (run.kinetic_energy + run.potential_energy).values
    assert energy == pytest.approx(energy[0], rel=1e-8)
    assert energy[0] == pytest.approx(0.8**4 + 0.9**2)


def test_what_swings_in_a_cog_is_a_pendulum():
    """Of mass m and amplitude a the angle n q swings as a pendulum's does, with a n / m for g/l."""
    model = block(cogging=3.0, cogging_count=10.0, cogging_phase=0.5)
    t = 4.0 * ellipk(np.sin(0.6) ** 2) / np.sqrt(3.0 * 10.0 / 2.0) * np.array([0.0, 0.5, 1.0, 4.0])
    expected = (0.5 + 1.2 * np.array([1.0, -1.0, 1.0, 1.0])) / 10.0
    for more, error in (
        ({}, 1e-8),
        ({"method": "rk4", "step": 1e-3}, 1e-8),
        ({"method": "implicit", "step": 1e-3}, 1e-4),
    ):
        run = fb.simulate(model, [expected[0]], [0.0], t, **more)
        assert run.q.values[:, 0] == pytest.approx(expected, abs=error)
    energy = (run.kinetic_energy + run.potential_energy).values
    assert energy[0] == pytest.approx(3.0 / 10.0 * (1.0 - np.cos(1.2)))


def test_implicit_steps_over_cogs_stay_bounded():
    """Half of a cog pushes away, which may leave no inverse to what the steps divide by."""
    model = block(cogging=2.0, cogging_count=100.0)
    t = np.linspace(0.0, 10.0, 11)
    run = fb.simulate(model, [[1e-3]], [[0.2], [0.3], [0.6]], t, method="implicit", step=0.1)
    energy = (run.kinetic_energy + run.potential_energy).values
    assert (energy.max(axis=1) < 2.0 * energy[:, 0]).all()


def test_time_optimal_motions_see_every_cog():
    drive = fb.Drive(cogging=3.0, cogging_count=700.0)
    model = fb.planar("R", m=[1.0], lc=[0.3], l=[0.5], I=[0.1], drives=[drive])
    given = {"torque": 12.0, "velocity": 8.0}
    with pytest.raises(FreebodyError, match=r"^time_optimal: between two points of the grid the c"):
        fb.time_optimal(model, [[0.0], [0.3]], points=61, **given)
    motion = fb.time_optimal(model, [[0.0], [0.3]], points=301, **given)
    q, qd, qdd = motion.at(np.linspace(*motion.t[[0, -1]], 20001))
    assert np.abs(fb.inverse_dynamics(model, q, qd, qdd)).max() < 12.0 * (1 + 1e-3)


def test_stops_and_smooth_friction_under_a_python_function():
    """The friction is counted once, whoever calls the torque."""
    slide = fb.planar(
        "P", l=[0], lc=[0], m=[2], I=[0], limits=[(-9, 9)], drives=[fb.Drive(coulomb=0.5)]
    ).replace(gravity=0.0)
    law = fb.compile(lambda t: [0.1 * fb.math.sin(t)], {"t": ()}, {"tau": 1})
    given = slide, [0.0], [1.0], [0.0, 1.0]
    more = {"restitution": 0.5, "method": "rk4", "step": 1e-3}
    one = fb.simulate(*given, law, **more).q.values[-1, 0]
    other = fb.simulate(*given, lambda t, q, qd: np.array([0.1 * np.sin(t)]), **more)
    assert other.q.values[-1, 0] == pytest.approx(one, abs=1e-9)


def test_acting_laws_are_told_by_their_strength():
    assert [x.law.name for x in every_law(VALUES.__getitem__)] == list(LAWS)
    idle = every_law(dict.fromkeys(NUMBERS, 0.0).__getitem__)
    assert all(isinstance(x, ActingLaw) and x.law.usual for x in idle)
