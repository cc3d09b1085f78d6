"""What a joint loses of the torque that it transmits: load-dependent friction and the efficiency of
its gear, as laws of power, and in everything that dynamics go to.

The number of sweeps of forward dynamics is an internal: no state is known for which it is too
small."""

import numpy as np
import pytest

import freebody as fb
from freebody import FreebodyError, ModelError
from support import generate
from support.exported import passes, require
from support.extras import extra

COGS = {"cogging": 0.5, "cogging_count": 4.0, "cogging_phase": 0.3}
SPRINGS = {"stiffness": 2.0, "rest": 0.1, **COGS}
FRICTION = {"coulomb": 0.3, "viscous": 0.2, **SPRINGS}
LOAD = {"load_friction": 0.2}
GEAR = {"efficiency": 0.8, "back_efficiency": 0.6}
BOTH = LOAD | GEAR
ROTOR = {"rotor": 1e-3, "gear": 30.0}


def arm(**given):
    """A planar arm with the drive in its first and last joint."""
    drive = fb.Drive(**given)
    return fb.planar(
        "RRP",
        m=[1.0, 2.0, 0.5], lc=[0.3, 0.2, 0.1], l=[0.7, 0.6, 0.4], I=[0.1, 0.2, 0.05],
        drives=[drive, None, drive],
    )  # fmt: skip


def block(**given):
    """A mass of 2 kg that slides without weight under a drive."""
    slide = fb.planar("P", l=[0], lc=[0], m=[2], I=[0], drives=[fb.Drive(**given)])
    return slide.replace(gravity=0.0)


def lossy(seed, dim, **given):
    """A random mechanism with the drive in every joint of one coordinate that stands alone."""
    model = generate.model(seed, dim)
    pairs = [(b.joint.name, b.joint.mimic.joint) for b in model.bodies if b.joint.mimic]
    coupled = {name for pair in pairs for name in pair}
    for body in model.bodies:
        if body.kind.nv == 1 and body.joint.name not in coupled:
            model = model.with_drive(body.joint.name, **given)
    return model


def states(model, count=40):
    """Random (q, qd, qdd)."""
    rng = np.random.default_rng(len(model.bodies))
    q = fb.integrate(model, fb.neutral(model), rng.normal(size=(count, model.nv)))
    return q, *rng.normal(size=(2, count, model.nv)) * [[[1.0]], [[5.0]]]


MECHANISMS = [(seed, dim) for seed in range(4) for dim in (2, 3)]
Q, QD, QDD = [0.3, -0.5, 0.2], [0.8, 0.4, -0.6], [1.0, -2.0, 0.7]


# ------------------------------------------------------------ laws
@pytest.mark.usefixtures("numpy_kernels")
@pytest.mark.parametrize(("seed", "dim"), MECHANISMS)
@pytest.mark.parametrize("rotor", [{}, ROTOR, {"rotor": 0.3, "gear": 30.0}], ids=str)
def test_forward_dynamics_undoes_inverse_dynamics(seed, dim, rotor):
    model = lossy(seed, dim, **BOTH, **FRICTION, **rotor)
    q, qd, qdd = states(model)
    found = fb.forward_dynamics(model, q, qd, fb.inverse_dynamics(model, q, qd, qdd))
    np.testing.assert_allclose(found, qdd, atol=1e-7 if not rotor else 1e-9)


@pytest.mark.usefixtures("numpy_kernels")
@pytest.mark.parametrize(("seed", "dim"), MECHANISMS)
def test_losses_take_power_and_give_none(seed, dim):
    given = FRICTION | ROTOR
    whole, plain = lossy(seed, dim, **BOTH, **given), lossy(seed, dim, **given)
    q, qd, qdd = states(plain)
    taken = (fb.inverse_dynamics(whole, q, qd, qdd) - fb.inverse_dynamics(plain, q, qd, qdd)) * qd
    assert taken.min() > -1e-12
    lossy_ones = [body for body in whole.bodies if body.joint.drive.load_friction]
    assert taken.max() > 0.1 or not lossy_ones


def test_efficiency_is_a_ratio_of_powers():
    plain, friction = arm(), arm(**FRICTION, **ROTOR)
    q, qd, qdd = states(plain, 200)
    sent = fb.inverse_dynamics(plain, q, qd, qdd)
    power = sent * qd
    found = fb.inverse_dynamics(arm(**GEAR), q, qd, qdd) * qd
    expected = np.where(power > 0, power / 0.8, 0.6 * power)
    np.testing.assert_allclose(found[:, [0, 2]], expected[:, [0, 2]], rtol=1e-12)
    assert (power[:, 0] > 0).any()
    assert (power[:, 0] < 0).any()
    found = fb.inverse_dynamics(arm(**LOAD), q, qd, qdd)
    expected = sent + 0.2 * np.abs(sent) * np.sign(qd)
    np.testing.assert_allclose(found[:, [0, 2]], expected[:, [0, 2]], rtol=1e-12)
    # friction, cogs and rotor are the motor's, the spring is the joint's
    sent = fb.inverse_dynamics(arm(stiffness=2.0, rest=0.1), q, qd, qdd)
    more = fb.inverse_dynamics(arm(**LOAD, **FRICTION, **ROTOR), q, qd, qdd)
    more -= fb.inverse_dynamics(friction, q, qd, qdd)
    expected = 0.2 * np.abs(sent) * np.sign(qd)
    np.testing.assert_allclose(more[:, [0, 2]], expected[:, [0, 2]], rtol=1e-9, atol=1e-12)


def test_two_losses_are_one_behind_the_other():
    sent = 2.0 * 3.0
    for rate in (0.5, -0.5):
        one = [fb.inverse_dynamics(block(**x), [0], [rate], [3.0])[0] for x in (LOAD, GEAR, BOTH)]
        assert one[2] == pytest.approx(one[0] * one[1] / sent)


PENDULUM = """
[[link]]
name = "ground"
[[link]]
name = "bob"
mass = 2.0
com = [0.3, 0.1, 0]
inertia = [0.1, 0, 0, 0.1, 0, 0.1]
[[joint]]
name = "a"
kind = "revolute"
parent = "ground"
child = "bob"
axis = "{axis}"
friction = {{ load = 0.2 }}
rotor = {{ inertia = 1e-3, gear = 30 }}
transmission = {{ efficiency = 0.8, back_efficiency = 0.6 }}
"""


def test_losses_seen_from_the_other_direction():
    one, other = (fb.load(text=PENDULUM.format(axis=axis), format="toml") for axis in ("y", "-y"))
    for qd in (0.7, -0.7):
        tau = fb.inverse_dynamics(one, [0.4], [qd], [2.0])
        opposite = fb.inverse_dynamics(other, [-0.4], [-qd], [-2.0])
        np.testing.assert_allclose(opposite, -tau, rtol=1e-14)
        qdd = fb.forward_dynamics(other, [-0.4], [-qd], -tau)
        np.testing.assert_allclose(qdd, [-2.0], rtol=1e-13)


def test_a_gear_only_reflects_the_rotor():
    tau = [3.0, -1.0, 0.5]
    geared, direct = arm(**BOTH, rotor=1e-3, gear=30.0), arm(**BOTH, rotor=0.9, gear=1.0)
    np.testing.assert_allclose(
        fb.forward_dynamics(geared, Q, QD, tau), fb.forward_dynamics(direct, Q, QD, tau)
    )


def test_closed_forms_of_a_mass_behind_a_gear():
    m, J = 2.0, 0.9
    t = np.linspace(0.0, 1.0, 5)
    model = block(**GEAR, **ROTOR)
    driven = 3.0 / (m / 0.8 + J)
    braked = -3.0 / (0.6 * m + J)
    for tau, rate, expected in ((3.0, 0.1, driven), (-3.0, 9.0, braked), (3.0, -9.0, -braked)):
        qdd = fb.forward_dynamics(model, [0.0], [rate], [tau])
        assert qdd[0] == pytest.approx(expected, rel=1e-14)
        for more in ({}, {"method": "rk4", "step": 1e-2}, {"method": "implicit", "step": 1e-4}):
            run = fb.simulate(model, [0.0], [rate], t, [tau], **more)
            assert run.qd.values[:, 0] == pytest.approx(rate + expected * t, abs=3e-4)
    # a rotor that the load drives: power flows through the gear, out of it there is none
    coasting = fb.forward_dynamics(model, [0.0], [1.0], [0.0])
    assert coasting[0] == 0.0
    slowed = fb.forward_dynamics(block(**GEAR, **ROTOR, viscous=0.5), [0.0], [1.0], [0.0])
    assert slowed[0] == pytest.approx(-0.5 / (0.6 * m + J))


def test_a_gear_holds_what_hardly_pushes():
    """At rest a loss of what is transmitted holds as dry friction does: between the torques that
    would raise and lower the load."""
    model = fb.load(
        text=PENDULUM.format(axis="-y").replace("0.3, 0.1, 0", "0.3, 0, 0"), format="toml"
    )
    weight = fb.gravity_torque(model, [0.0])[0]
    raising, lowering = (
        fb.inverse_dynamics(model, [0.0], [rate], [0.0])[0] for rate in (1e-9, -1e-9)
    )
    assert raising == pytest.approx(weight * 1.2 / 0.8)
    assert lowering == pytest.approx(weight * 0.8 * 0.6)
    for tau, least, most in (
        (raising * 1.01, 1e-3, 1.0), (raising * 0.99, -1e-3, 1e-3),
        (lowering * 1.01, -1e-3, 1e-3), (lowering * 0.99, -1.0, -1e-3),
    ):  # fmt: skip
        steps = {"method": "implicit", "step": 1e-3, "friction_width": 1e-5}
        moved = fb.simulate(model, [0.0], [0.0], [0.0, 1.0], [tau], **steps).q.values[-1, 0]
        assert least < moved < most


# ------------------------------------------------------------ in dynamics
@pytest.fixture(scope="module")
def whole():
    return arm(**BOTH, **FRICTION, **ROTOR)


@pytest.mark.parametrize("rotor", [{}, ROTOR], ids=["no rotor", "rotor"])
def test_derivatives_are_those_of_the_dynamics(rotor):
    model, h = arm(**BOTH, **FRICTION, **rotor), 1e-6
    tau = fb.inverse_dynamics(model, Q, QD, QDD)
    ways = (
        (fb.inverse_dynamics_derivatives, fb.inverse_dynamics, QDD),
        (fb.forward_dynamics_derivatives, fb.forward_dynamics, tau),
        (fb.forward_dynamics_derivatives, fb.forward_dynamics, -tau),
    )
    for derivatives, function, last in ways:
        state = np.array([Q, QD, last])
        for k, found in enumerate(derivatives(model, *state)):
            shifts = np.zeros((3, 3, 3))
            shifts[np.arange(3), k, np.arange(3)] = h
            above, below = (
                function(model, *np.moveaxis(state + s, 1, 0)) for s in (shifts, -shifts)
            )
            np.testing.assert_allclose(found, (above - below).T / (2 * h), rtol=1e-6, atol=1e-7)
    A, B = fb.linearize(model, Q, QD, tau)
    by_q, by_qd, by_tau = fb.forward_dynamics_derivatives(model, Q, QD, tau)
    np.testing.assert_allclose(A[3:], np.hstack([by_q, by_qd]))
    np.testing.assert_allclose(B[3:], by_tau)


def test_long_chains():
    """Chains for which articulated bodies would take fewer operations."""
    n = 26
    model = fb.planar("R" * n, l=[0.1] * n, lc=[0.05] * n, m=[0.2] * n, I=[1e-3] * n)
    for name in model.joint_names[::5]:
        model = model.with_drive(name, **BOTH, **ROTOR)
    q, qd, qdd = np.random.default_rng(0).normal(size=(3, n))
    kernels = {
        name: fb.kernel(model, name, target="numpy")
        for name in ("inverse_dynamics", "forward_dynamics")
    }
    tau = kernels["inverse_dynamics"](q, qd, qdd)
    np.testing.assert_allclose(kernels["forward_dynamics"](q, qd, tau), qdd, rtol=1e-8)


def test_steps_of_many_sizes_and_methods_find_one_motion(whole):
    law = fb.compile(
        lambda t: [20 * fb.math.sin(3 * t), 5 * fb.math.cos(2 * t), 4 * fb.math.sin(5 * t)],
        {"t": ()}, {"tau": 3},
    )  # fmt: skip
    given = whole, Q, [0.0, 0.0, 0.0], [0.0, 1.0], law
    reference = fb.simulate(*given, tolerance=1e-9, friction_width=1e-3).q.values[-1]
    for method, step, allowed in (
        ("rk4", 5e-4, 1e-4), ("semi-implicit", 1e-4, 2e-3), ("implicit", 1e-4, 2e-3),
    ):  # fmt: skip
        steps = {"method": method, "step": step, "friction_width": 1e-3}
        found = fb.simulate(*given, **steps).q.values[-1]
        assert np.abs(found - reference).max() < allowed
    # without losses it would be another motion
    assert (
        np.abs(fb.simulate(arm(**FRICTION, **ROTOR), *given[1:]).q.values[-1] - reference).max()
        > 0.1
    )


def test_numbers_by_name_inputs_and_families(whole):
    tau = fb.inverse_dynamics(whole, Q, QD, QDD)
    names = ["joint1.friction.load", "joint3.transmission.efficiency"]
    values = [0.1, 0.9]
    changed = whole.bind(dict(zip(names, values, strict=True)))
    expected = fb.forward_dynamics(changed, Q, QD, tau)
    other = whole.with_drive("joint1", load_friction=0.1).with_drive("joint3", efficiency=0.9)
    np.testing.assert_array_equal(fb.forward_dynamics(other, Q, QD, tau), expected)
    kernel = fb.kernel(whole, "forward_dynamics", inputs=names)
    np.testing.assert_allclose(kernel(Q, QD, tau, values), expected, rtol=1e-12)
    several = whole.with_drive("joint1", load_friction=np.array([0.0, 0.1]), efficiency=[0.7, 0.9])
    each = [
        whole.with_drive("joint1", load_friction=c, efficiency=e) for c, e in ((0, 0.7), (0.1, 0.9))
    ]
    for function, last in ((fb.inverse_dynamics, QDD), (fb.forward_dynamics, tau)):
        expected = [function(model, Q, QD, last) for model in each]
        np.testing.assert_allclose(function(several, Q, QD, last), expected, rtol=1e-12)
    np.testing.assert_allclose(
        fb.forward_dynamics(whole.without("friction"), Q, QD, tau),
        fb.forward_dynamics(arm(**SPRINGS, **ROTOR), Q, QD, tau),
        rtol=1e-12,
    )


def test_losses_that_are_none_cost_nothing(whole):
    off = dict.fromkeys(BOTH, 0.0)
    none = whole.with_drive("joint1", **off).with_drive("joint3", **off)
    assert none.structure is arm(**FRICTION, **ROTOR).structure


def test_files_have_losses(whole, tmp_path):
    fb.save(whole, tmp_path / "arm.toml")
    again = fb.load(tmp_path / "arm.toml")
    for k in (0, 2):
        assert again.bodies[k].joint.drive == whole.bodies[k].joint.drive


@pytest.mark.parametrize("precision", ["float32", "float64"])
def test_kernels_of_both_precisions(whole, precision):
    tau = fb.inverse_dynamics(whole, Q, QD, QDD)
    found = fb.kernel(whole, "forward_dynamics", dtype=precision)(Q, QD, tau)
    np.testing.assert_allclose(found, QDD, rtol=1e-4 if precision == "float32" else 1e-12)


@pytest.mark.sample(2)
@pytest.mark.parametrize("language", ["c", "javascript", "jax"])
@pytest.mark.parametrize("name", ["inverse_dynamics", "forward_dynamics"])
def test_source_text(whole, language, name, tmp_path):
    fb.export(whole, name, tmp_path, language)
    require(language)
    passes(tmp_path, language, name)


def test_derivatives_in_jax(whole):
    jax = extra("jax")
    tau = fb.inverse_dynamics(whole, Q, QD, QDD)
    for name, last in (("inverse_dynamics", QDD), ("forward_dynamics", tau)):
        with jax.enable_x64(True):
            function = fb.to_jax(whole, name)
            given = [jax.numpy.asarray(np.asarray(x, dtype=float)) for x in (Q, QD, last)]
            found = jax.jacrev(function, argnums=(0, 1, 2))(*given)
        expected = getattr(fb, f"{name}_derivatives")(whole, Q, QD, last)
        for a, b in zip(found, expected, strict=True):
            np.testing.assert_allclose(a, b, rtol=1e-9, atol=1e-9)


# ------------------------------------------------------------ in studies
def test_a_study_has_losses_and_the_pace_with_them(tmp_path):
    drive = fb.Drive(**BOTH, **FRICTION, **ROTOR)
    efforts = [60.0, 90.0, 60.0]
    model = fb.planar(
        "RRP",
        m=[1.0, 2.0, 0.5], lc=[0.3, 0.2, 0.1], l=[0.7, 0.6, 0.4], I=[0.1, 0.2, 0.05],
        drives=[drive, None, drive], limits=[fb.Limits(-2.0, 2.0, 9.0, x) for x in efforts],
    )  # fmt: skip
    study = fb.study(model)
    assert all(check.passed for check in study.checks)
    motion, tau = study.motion, study.data["tau"].values
    free = fb.inverse_dynamics(model.without("friction"), motion.q, motion.qd, motion.qdd)
    np.testing.assert_allclose(study.data["tau_friction"].values, tau - free, atol=1e-12)

    def largest(factor):
        tau = fb.inverse_dynamics(model, motion.q, factor * motion.qd, factor**2 * motion.qdd)
        return (np.abs(tau) / efforts).max()

    factor = study.verdict.factor
    assert 1.0 < factor < 9.0 / np.abs(motion.qd).max()  # a torque's limit, not a speed's
    assert largest(0.999 * factor) < 1.0 < largest(1.001 * factor)
    assert study.save(tmp_path, report=True)


# ------------------------------------------------------------ what is refused
def test_what_locks_itself_is_refused():
    model = fb.planar("R")
    for given, words in (
        ({"load_friction": 1.0}, r"joint 'joint1': load-dependent friction 1 loses all that the "),
        ({"load_friction": -0.1}, r"load-dependent friction -0\.1 is negative"),
        ({"efficiency": 0.5, "back_efficiency": 0.0}, r"back_efficiency .* locks itself, and acc"),
        ({"efficiency": 0.5, "back_efficiency": -0.2}, r"locks itself"),
        ({"efficiency": 1.5, "back_efficiency": 0.5}, r"efficiency of the gear is 1\.5; give a n"),
        ({"efficiency": 0.5}, r"efficiency is given without back_efficiency, which has no default"),
        ({"back_efficiency": 0.5}, r"back_efficiency is given without efficiency, without which"),
    ):
        with pytest.raises(ModelError, match=words):
            model.with_drive("joint1", **given)
    with pytest.raises(ModelError, match=r"^Drive: efficiency is given without back_efficiency"):
        fb.Drive(efficiency=0.5)
    good = model.with_drive("joint1", **BOTH)
    for name, value in (("friction.load", 1.1), ("transmission.back_efficiency", -0.1)):
        with pytest.raises(ModelError, match="locks itself"):
            good.bind({f"joint1.{name}": value})
    text = PENDULUM.format(axis="y").replace("load = 0.2", "load = 1.0")
    with pytest.raises(FreebodyError, match="locks itself"):
        fb.load(text=text, format="toml", physical="ignore")


def test_what_is_not_known_of_losses_is_refused(whole):
    known = r"the load-dependent friction of joint 'joint1' of 'RRP' makes torques other than lin"
    for refused in (
        lambda: fb.regressor(whole, Q, QD, QDD),
        lambda: fb.base_parameters(whole),
        lambda: fb.momentum_observer(whole, Q, QD, QDD, 1e-3, Q, [1.0] * 3),
        lambda: fb.kernel(whole, "bias"),
        lambda: fb.kernel(whole, "inverse_dynamics_second_derivatives"),
        lambda: fb.forward_dynamics(whole, Q, QD, QDD, forces=QDD),
        lambda: fb.simulate(whole, Q, QD, [0.0, 1.0], friction="dry"),
        lambda: fb.simulate(whole, Q, QD, [0.0, 1.0], restitution=0.5),
        lambda: fb.derive(whole),
        lambda: fb.time_optimal(whole, [Q, QD]),
    ):
        with pytest.raises(FreebodyError, match=known):
            refused()
    for refused in (lambda: fb.equations(whole).text(), lambda: fb.check(whole, "tau1 = 0")):
        with pytest.raises(FreebodyError, match=r"^the load-dependent friction at body 'link1' ha"):
            refused()


def test_losses_of_what_loops_and_followers_share_are_refused():
    chain = fb.load("four_bar")
    with pytest.raises(ModelError, match=r"in a closed chain that depends on how its loops share"):
        chain.with_drive(chain.joint_names[0], **LOAD)
    (loop,) = chain.loops
    opened = chain.without("loops")
    geared = opened.with_drive(opened.joint_names[0], **LOAD)
    with pytest.raises(ModelError, match=r"^with_loop: joint .* leave it out, with_drive\('"):
        geared.with_loop("again", loop.kind, loop.frames, axis=loop.axis)
    followed = """
[[link]]
name = "finger"
mass = 1.0
[[joint]]
name = "b"
kind = "revolute"
axis = "z"
parent = "bob"
child = "finger"
mimic = { joint = "a" }
"""
    with pytest.raises(
        FreebodyError, match=r"joint 'a' has .* one follows the other that is not d"
    ):
        fb.load(text=PENDULUM.format(axis="y") + followed, format="toml")
