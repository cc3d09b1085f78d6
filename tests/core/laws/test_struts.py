"""Struts between two points: virtual work, power, derivatives, reactions, files, families; beside
MuJoCo's tendons, Drake's springs, and closed forms."""

from __future__ import annotations

import numpy as np
import pytest

import freebody as fb
from support import generate
from support.exported import passes, require
from support.extras import extra
from support.helpers import close, refused
from support.springs import loaded

GAS = {"stiffness": 60.0, "rest": 0.4, "damping": 3.0, "preload": -12.0}
H = 1e-6


@pytest.fixture
def numpy_kernels(monkeypatch):
    """Kernels of NumPy: compiling takes longer than computing here."""
    monkeypatch.setenv("FREEBODY_TARGET", "numpy")


def strutted(model: fb.Model, seed: int, count: int = 2) -> fb.Model:
    """The model with struts between random points of its bodies and of the ground."""
    rng = np.random.default_rng(seed)
    links = [*(f.name for f in model.frames if f.body < 0)][:1]  # a free base has none
    links += [body.name for body in model.bodies]
    for k in range(count):
        ends = rng.choice(len(links), size=2, replace=False)
        for end, side in zip(ends, "ab", strict=True):
            at = rng.normal(scale=0.4, size=model.dim)
            model = model.with_frame(f"{side}{k}", at, frame=links[end])
        own = {name: x * float(rng.uniform(0.5, 1.5)) for name, x in GAS.items()}
        model = model.with_strut(f"strut{k}", (f"a{k}", f"b{k}"), **own)
    return model


def along(model, value, q):
    """Derivative (..., nv) of a value of q along each direction of the tangent space."""
    steps = H * np.eye(model.nv)
    ahead, behind = (
        np.array([value(fb.integrate(model, q, s * step)) for step in steps]) for s in (1, -1)
    )
    return np.moveaxis((ahead - behind) / (2 * H), 0, -1)


TREES = [(seed, dim) for dim in (2, 3) for seed in (1, 4, 9)]
LARGE = [pytest.param(*of, marks=pytest.mark.long) for of in TREES]
"""A tree of 30 coordinates, whose second derivatives take as long as a hundred other tests."""


@pytest.mark.sample(1)
@pytest.mark.usefixtures("numpy_kernels")
@pytest.mark.parametrize(("seed", "dim"), TREES)
def test_virtual_work_and_power(seed, dim):
    bare = generate.model(seed, dim)
    model = strutted(bare, seed)
    q, qd, qdd = fb.random_state(model, seed)
    length, rate, tension = fb.strut_states(model, q, qd)
    slope = along(model, lambda at: fb.strut_states(model, at, qd)[0], q)
    close(rate, slope @ qd, 1e-6, what="rate of the lengths")
    numbers = np.array([strut.numbers for strut in model.struts], dtype=float).T
    stiffness, rest, damping, preload = numbers
    close(tension, preload + stiffness * (length - rest) + damping * rate, 1e-12)
    tau = fb.inverse_dynamics(model, q, qd, qdd)
    close(tau - fb.inverse_dynamics(bare, q, qd, qdd), tension @ slope, 1e-6, np.abs(tau).max())
    close(fb.bias(model, q, qd) - fb.bias(bare, q, qd), tension @ slope, 1e-6, np.abs(tau).max())
    close(fb.gravity_torque(model, q), fb.gravity_torque(bare, q), 0.0)
    at_rest = preload + stiffness * (length - rest)
    more = fb.static_torque(model, q) - fb.static_torque(bare, q)
    close(more, at_rest @ slope, 1e-6, np.abs(tau).max())
    stored = fb.potential_energy(model, q) - fb.potential_energy(bare, q)
    stretch = length - rest
    assert stored == pytest.approx(np.sum(0.5 * stiffness * stretch**2 + preload * stretch))
    if not bare.passive:
        close(fb.forward_dynamics(model, q, qd, tau), qdd, 1e-6, what="forward dynamics")


@pytest.mark.usefixtures("numpy_kernels")
@pytest.mark.parametrize(("seed", "dim"), [(2, 3), *LARGE])
def test_derivatives_and_reactions(seed, dim):
    model = strutted(generate.model(seed, dim), seed).without("friction")
    q, qd, qdd = fb.random_state(model, seed)
    by_q, by_qd, _ = fb.inverse_dynamics_derivatives(model, q, qd, qdd)
    size = np.abs(by_q).max()
    expected = along(model, lambda at: fb.inverse_dynamics(model, at, qd, qdd), q)
    close(by_q, expected, 1e-6, size, "by q")
    faster = [
        fb.inverse_dynamics(model, q, qd + step, qdd)
        - fb.inverse_dynamics(model, q, qd - step, qdd)
        for step in H * np.eye(model.nv)
    ]
    close(by_qd, np.array(faster).T / (2 * H), 1e-6, size, "by q̇")
    torques = fb.formula(model, "inverse_dynamics")
    along_last = [*qd[:-1], complex(qd[-1], 1e-30)]  # by a complex step
    stepped = [complex(x).imag * 1e30 for x in torques(tuple(q), tuple(along_last), tuple(qdd))]
    close(by_qd[:, -1], stepped, 1e-12, size, "by the last rate")
    twice = fb.inverse_dynamics_second_derivatives(model, q, qd, qdd)[0]
    second = along(model, lambda at: fb.inverse_dynamics_derivatives(model, at, qd, qdd)[0], q)
    close(twice, second, 1e-5, size, "twice by q")
    found = fb.reactions(model, q, qd, qdd=qdd)
    assert found.balance < 1e-9  # each body's balance has the struts' forces at their points


def test_a_long_chain_is_solved_by_articulated_bodies():
    n = 26
    rod = fb.planar("R" * n, l=[0.2] * n, lc=[0.1] * n, m=[1.0] * n, I=[0.01] * n)
    model = rod.with_strut("stay", (rod.frame_names[0], rod.bodies[20].name), **GAS)
    q, qd, qdd = fb.random_state(model, 2)
    close(fb.forward_dynamics(model, q, qd, fb.inverse_dynamics(model, q, qd, qdd)), qdd, 1e-7)


# ---------------------------------------------------------------- closed forms
def flap() -> fb.Model:
    """A flap of 6 kg, hinged at the origin, that a strut from (0.1, -0.3) pushes at 0.25 m."""
    arm = fb.planar("R", l=[0.8], lc=[0.4], m=[6.0], I=[0.3])
    arm = arm.with_frame("foot", [0.1, -0.3], frame=arm.frame_names[0])
    return arm.with_frame("head", [0.25, 0.0], frame=arm.bodies[0].name)


def test_a_gas_spring_under_a_flap():
    spring = {"stiffness": 200.0, "rest": 0.5, "preload": -300.0}
    model = flap().with_strut("gas", ("foot", "head"), **spring)
    angle = np.linspace(-0.4, 1.3, 7)
    head = 0.25 * np.array([np.cos(angle), np.sin(angle)]).T
    arm = head - [0.1, -0.3]
    length = np.linalg.norm(arm, axis=-1)
    force = 300.0 - 200.0 * (length - 0.5)  # with which it pushes
    lever = (head[:, 0] * arm[:, 1] - head[:, 1] * arm[:, 0]) / length
    weight = 6.0 * 9.81 * 0.4 * np.cos(angle)
    close(fb.static_torque(model, angle[:, None])[:, 0], weight - force * lever, 1e-12)


def test_a_spring_of_no_free_length_balances_a_weight_everywhere():
    # k b c = m g l, one end b above the hinge (Carwardine's spring of the Anglepoise)
    arm = fb.planar("R", l=[0.8], lc=[0.4], m=[6.0], I=[0.3])
    arm = arm.with_frame("above", [0.0, 0.3], frame=arm.frame_names[0])
    arm = arm.with_frame("hook", [0.2, 0.0], frame=arm.bodies[0].name)
    stiffness = 6.0 * 9.81 * 0.4 / (0.3 * 0.2)
    model = arm.with_strut("spring", ("above", "hook"), stiffness=stiffness)
    assert np.abs(fb.static_torque(model, np.linspace(-3, 3, 9)[:, None])).max() < 1e-12


def test_an_ideal_damper_takes_what_energy_is_lost():
    model = flap().with_strut("gas", ("foot", "head"), **GAS)
    t = np.linspace(0, 2, 401)
    recorded = ("q", "qd", "kinetic_energy", "potential_energy")
    run = fb.simulate(model, [0.9], [0.0], t, record=recorded)
    energy = run["kinetic_energy"].values + run["potential_energy"].values
    q, qd = run["q"].values, run["qd"].values
    lost = GAS["damping"] * fb.strut_states(model, q, qd)[1][:, 0] ** 2
    work = np.concatenate([[0.0], np.cumsum((lost[1:] + lost[:-1]) / 2 * np.diff(t))])
    close(energy[0] - energy, work, 1e-3)
    assert work[-1] > 0.5
    for method in ("rk4", "implicit"):
        other = fb.simulate(model, [0.9], [0.0], t, method=method, step=1e-3)
        close(other["q"].values, q, 1e-4)


# ---------------------------------------------------------------- closed chains
@pytest.mark.parametrize("name", ["four_bar", pytest.param("stewart", marks=pytest.mark.long)])
def test_closed_chains(name):
    bare, (q, qd), _ = loaded(name) if name == "four_bar" else stewart()
    model = strutted(bare, 3)
    # V's derivative along every motion of the loops is the drives' power at rest
    tau = fb.static_torque(model, q)
    ahead, behind = (
        fb.potential_energy(model, fb.assemble(model, fb.integrate(model, q, s * 1e-5 * qd)))
        for s in (1, -1)
    )
    assert tau @ qd == pytest.approx((ahead - behind) / 2e-5, rel=1e-5)
    qdd = fb.loop_acceleration(model, q, qd, np.zeros(model.nv))
    needed = fb.inverse_dynamics(model, q, qd, qdd)
    close(fb.forward_dynamics(model, q, qd, needed), qdd, 1e-7)
    found = fb.reactions(model, q, qd, qdd=qdd)
    assert found.balance < 1e-9
    # as generalized forces that somebody else gives
    tension = fb.strut_states(model, q, qd)[2]
    slope = along(model, lambda at: fb.strut_states(model, at, qd)[0], q)
    other = fb.inverse_dynamics(bare, q, qd, qdd, forces=-tension @ slope)
    close(needed, other, 1e-6)


def stewart():
    """The platform in motion."""
    model = fb.load("stewart")
    q = fb.neutral(model)
    q[2], q[[9, 12, 15, 18, 21, 24]] = 0.9, 1.0
    q = fb.assemble(model, q, free=[n for n in model.joint_names if n != "pose"])
    qd = fb.loop_velocity(model, q, np.random.default_rng(5).normal(size=model.nv))
    return model, (q, qd), None


# ---------------------------------------------------------------- other programs
TENDONS = """<mujoco><option gravity="0 0 -9.81"/><compiler angle="radian"/><worldbody>
<site name="foot" pos="0.3 0.1 0"/>
<body name="upper" pos="0 0 1"><joint name="shoulder" type="ball"/>
<inertial pos="0.1 0 -0.2" mass="2" fullinertia="0.04 0.05 0.02 0.001 0.002 0.003"/>
<site name="upper" pos="0.1 0.05 -0.15"/>
<body name="fore" pos="0 0 -0.5"><joint name="elbow" axis="0 1 0"/>
<inertial pos="0 0.05 -0.2" mass="1" diaginertia="0.02 0.02 0.01"/>
<site pos="0.05 0 -0.3"/>
<body name="hand" pos="0 0 -0.4"><joint name="slide" type="slide" axis="0.6 0 -0.8"/>
<inertial pos="0 0 -0.05" mass="0.5" diaginertia="0.002 0.002 0.001"/>
<site name="hand" pos="0 0.02 -0.1"/></body></body></body></worldbody>
<tendon><spatial name="gas" stiffness="70" damping="4" springlength="0.5">
<site site="foot"/><site site="hand"/></spatial>
<spatial name="elbow" stiffness="30" damping="2" springlength="0.2">
<site site="upper"/><site site="{}"/></spatial>
<spatial name="measured"><site site="foot"/><site site="upper"/></spatial></tendon></mujoco>"""


def test_tendons_of_mujoco():
    mujoco = extra("mujoco", "MuJoCo")
    text = TENDONS.format("wrist").replace('<site pos="0.05', '<site name="wrist" pos="0.05')
    model = fb.load(text=text, format="mjcf")
    # joints, links and tendons may have the same names there
    assert model.strut_names == ("gas", "elbow_tendon")
    assert model.struts[1].frames == ("upper_site", "wrist")
    theirs = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(theirs)
    for seed in range(3):
        q, qd, qdd = fb.random_state(model, seed)
        data.qpos[:], data.qvel[:], data.qacc[:] = q, qd, qdd
        mujoco.mj_inverse(theirs, data)
        close(fb.inverse_dynamics(model, q, qd, qdd), data.qfrc_inverse, 1e-9)
        lengths, rates, _ = fb.strut_states(model, q, qd)
        close(lengths, data.ten_length[:2], 1e-12)
        close(rates, data.ten_velocity[:2], 1e-10)
    more = text.replace('springlength="0.2"', 'springlength="0.2 0.3"')
    left = fb.load(text=more, format="mjcf")
    assert left.strut_names == ("gas",)
    assert any("what tendons do" in str(x) and "left out: elbow" in str(x) for x in left.notices)


def test_springs_of_drake():
    parsing, plants, tree = (
        extra(f"pydrake.multibody.{name}", "Drake") for name in ("parsing", "plant", "tree")
    )
    urdf = """<robot name="two"><link name="base"/>{}</robot>""".format(
        "".join(
            f"""<link name="l{k}"><inertial><origin xyz="0.1 0.02 -0.2"/><mass value="{k}"/>
<inertia ixx="0.04" iyy="0.05" izz="0.03" ixy="0.001" ixz="0" iyz="0.002"/></inertial></link>
<joint name="j{k}" type="revolute"><parent link="{"base" if k == 1 else "l1"}"/>
<child link="l{k}"/><origin xyz="0 0 {0.5 * k}"/><axis xyz="{axis}"/>
<limit lower="-3" upper="3" effort="9" velocity="9"/></joint>"""
            for k, axis in ((1, "0 0.6 0.8"), (2, "1 0 0"))
        )
    )
    model = fb.load(text=urdf, format="urdf")
    plant = plants.MultibodyPlant(0.0)
    parsing.Parser(plant).AddModelsFromString(urdf, "urdf")
    plant.WeldFrames(plant.world_frame(), plant.GetFrameByName("base"))
    ends = {"foot": ("base", [0.3, 0.2, -0.1]), "head": ("l2", [0.05, 0.2, -0.3])}
    for name, (link, at) in ends.items():
        model = model.with_frame(name, at, frame=link)
    (a, at_a), (b, at_b) = ends.values()
    bodies = plant.GetBodyByName(a), plant.GetBodyByName(b)
    plant.AddForceElement(tree.LinearSpringDamper(bodies[0], at_a, bodies[1], at_b, 0.4, 60.0, 3.0))
    plant.Finalize()
    model = model.with_strut("gas", ("foot", "head"), **GAS | {"preload": 0.0})
    context = plant.CreateDefaultContext()
    for seed in range(3):
        q, qd, _ = fb.random_state(model, seed)
        plant.SetPositions(context, q)
        plant.SetVelocities(context, qd)
        forces = tree.MultibodyForces(plant)
        plant.CalcForceElementsContribution(context, forces)
        tau = plant.CalcInverseDynamics(context, np.zeros(2), forces)
        close(fb.inverse_dynamics(model, q, qd, np.zeros(2)), tau, 1e-10)


# ---------------------------------------------------------------- the model
def test_numbers_have_names_and_members():
    model = flap().with_strut("gas", ("foot", "head"), **GAS)
    names = [f"gas.{number}" for number in GAS]
    assert {name: fb.parameters(model)[name].value for name in names} == {
        f"gas.{number}": x for number, x in GAS.items()
    }
    other = model.bind({"gas.preload": -20.0, "gas.rest": 0.3})
    assert other.struts[0].numbers == (60.0, 0.3, 3.0, -20.0)
    many = model.bind({"gas.stiffness": np.array([10.0, 60.0])})
    tau = fb.inverse_dynamics(many, [0.5], [0.2], [0.0])
    close(tau[1], fb.inverse_dynamics(model, [0.5], [0.2], [0.0]), 1e-12)
    assert tau[0] != tau[1]
    symbolic = flap().with_strut("gas", ("foot", "head"), stiffness="k", preload=-12.0)
    assert symbolic.missing == ("k",)
    assert symbolic.bind(k=60.0).struts[0].stiffness.value == 60.0
    moved = model.bind({"head.placement.x": 0.3})  # frames of struts count, where nobody names them
    close(fb.strut_states(moved, [0.0], [0.0])[0][0], np.hypot(0.2, 0.3), 1e-12)
    close(fb.strut_states(model.to_space(), [0.5], [0.2]), fb.strut_states(model, [0.5], [0.2]), 0)
    assert model.without("struts") == flap()
    assert model.without("springs", "friction") == model
    assert "strut gas: foot and head" in model._repr_html_()


def test_files(tmp_path):
    text = """
dim = 2
[[link]]
name = "ground"
[[link]]
name = "flap"
mass = 6.0
com = [0.4, 0.0]
inertia = 0.3
[[joint]]
name = "hinge"
kind = "revolute"
parent = "ground"
child = "flap"
[[frame]]
name = "foot"
parent = "ground"
origin = [0.1, -0.3]
[[frame]]
name = "head"
parent = "flap"
origin = [0.25, 0.0]
[[strut]]
name = "gas"
frames = ["foot", "head"]
stiffness = "k"
rest = 0.4
damping = 3.0
preload = -12.0
[parameters]
k = 60.0
"""
    model = fb.load(text=text, format="toml")
    saved = tmp_path / "flap.toml"
    fb.save(model, saved)
    assert fb.load(saved) == model
    q, qd, qdd = [0.5], [0.2], [0.1]
    expected = flap().with_strut("gas", ("foot", "head"), **GAS)
    close(fb.inverse_dynamics(model, q, qd, qdd), fb.inverse_dynamics(expected, q, qd, qdd), 1e-12)
    for old, new, told in (
        ('name = "gas"', 'name = "hinge"', "strut 'hinge': the name is taken or empty"),
        ('"foot", "head"]', '"foot", "ground"]', "are on the same body"),
        ('"foot", "head"]', '"foot", "hood"]', "no frame 'hood' in strut 'gas'"),
        ('"foot", "head"]', '"foot", 3]', "frames must be the names of two frames"),
        ("damping = 3.0", "damping = -3.0", "damping is -3 N s/m; give it as 0 or more"),
        ("rest = 0.4", "length = 0.4", "length"),
    ):
        with pytest.raises(fb.FreebodyError, match=told):
            fb.load(text=text.replace(old, new), format="toml")


def test_what_is_refused():
    model = flap()
    ends = ("foot", "head")
    gas = model.with_strut("gas", ends, **GAS)
    refused(
        "strut 'g': frames 'head' and 'link1' are on the same body, so its length never changes; "
        "name frames of two bodies.",
        lambda: model.with_strut("g", ("head", "link1")),
    )
    refused("strut 'gas': rest is -1 m; give it as 0 or more.",
            lambda: model.with_strut("gas", ends, stiffness=1.0, rest=-1.0))  # fmt: skip
    refused("strut 'gas': the name is taken or empty; choose another.",
            lambda: gas.with_strut("gas", ends))  # fmt: skip
    hinged = (model.frame_names[0], model.bodies[0].name)
    with pytest.raises(fb.ModelError, match=r"'g': frames .* are always at one point"):
        model.with_strut("g", hinged, stiffness=1.0)
    assert model.with_strut("g", (hinged[0], "head")).strut_names == ("g",)  # of constant length
    single = model.with_strut("g", (hinged[0], "head"), stiffness=1.0)
    size = next(x.name for x in fb.parameters(single) if x.name == "head.placement.x")
    for given, where in (
        (0.0, ""),
        ([0.4, 0.0], r" \(member 1\)"),
    ):
        with pytest.raises(fb.ModelError, match=f"always at one point{where}, where"):
            single.bind({size: given})
    for part in (model.with_strut, lambda name, frames: model.with_loop(name, "fixed", frames)):
        for name, frames, text in (
            (3, ends, "the name must be text"),
            ("g", None, "frames must be the names of two frames"),
            ("g", "ab", "frames must be the names of two frames"),
            ("g", ("foot", None), "no frame None"),
        ):
            with pytest.raises(fb.FreebodyError, match=text):
                part(name, frames)
    for call in (fb.regressor, fb.base_parameters, fb.equations, fb.derive):
        with pytest.raises(fb.FreebodyError, match=r'model\.without\("struts"\)'):
            call(gas, [0.1], [0.2], [0.3]) if call is fb.regressor else call(gas)


def test_the_end_of_a_strut_is_no_tip():
    text = """
name = "flap"
[[link]]
name = "wall"
[[link]]
name = "door"
[[joint]]
name = "hinge"
kind = "revolute"
axis = "y"
parent = "wall"
child = "door"
[[frame]]
name = "head"
parent = "door"
origin = [0.25, 0, 0]
"""
    strut = '[[strut]]\nname = "gas"\nframes = ["wall", "head"]\nstiffness = 60\n'
    handle = '[[frame]]\nname = "handle"\nparent = "head"\n'
    tips = [fb.load(text=x, format="toml").tip for x in (text, text + strut, text + handle + strut)]
    assert tips == ["head", "door", "handle"]


def test_a_strut_without_length_is_told():
    arm = fb.planar("R", l=[0.5], lc=[0.2], m=[1.0], I=[0.1])
    arm = arm.with_frame("wall", [0.5, 0.0], frame=arm.frame_names[0])
    model = arm.with_strut("spring", ("wall", arm.tip), stiffness=3.0)
    told = (
        ": strut 'spring' of 'R' has no length{}: both its ends are at one place, and its force "
        "has no direction. Choose another q, or move an end."
    )
    batch, rest = [[0.3], [0.0]], ([0.1], [0.0])
    refused("inverse_dynamics" + told.format(""),
            lambda: fb.inverse_dynamics(model, [0.0], *rest))  # fmt: skip
    refused("forward_dynamics" + told.format(" at sample 1"),
            lambda: fb.forward_dynamics(model, batch, *rest))  # fmt: skip
    refused("simulate" + told.format(""),
            lambda: fb.simulate(model, [0.0], [0.0], [0.0, 0.1]))  # fmt: skip
    refused("payload_map" + told.format(" at sample 1"),
            lambda: fb.payload_map(model, batch, effort=[9.0]))  # fmt: skip
    assert np.isfinite(fb.inverse_dynamics(model, [0.1], [0.1], [0.0])).all()


def test_a_study_counts_struts_as_springs_and_friction():
    model = flap().with_strut("gas", ("foot", "head"), **GAS)
    study = fb.study(model)
    assert all(check.passed for check in study.checks), [c for c in study.checks if not c.passed]
    q, qd = study.data["q"].values, study.data["qd"].values
    spring = fb.static_torque(model, q) - fb.gravity_torque(model, q)
    close(study.data["tau_springs"], spring, 1e-9)
    damping = fb.bias(model, q, qd) - fb.static_torque(model, q)  # a flap alone has no c
    close(study.data["tau_viscous"], damping, 1e-9)
    close(study.data["tau_friction"], damping, 1e-9)


def test_free_bodies_show_the_forces_of_struts():
    model = strutted(generate.model(1, 2), 1)
    q, qd, qdd = fb.random_state(model, 1)
    shown = fb.free_body_diagram(model, q, qd=qd, qdd=qdd)
    assert len([load for body in shown.bodies for load in body.loads if load.other == "strut0"]) > 0
    assert max(body.force_residual for body in shown.bodies) < 1e-9
    assert max(body.moment_residual for body in shown.bodies) < 1e-9


@pytest.mark.parametrize("language", ["c", "javascript"])
def test_exported_code(language, tmp_path):
    require(language)
    model = flap().with_strut("gas", ("foot", "head"), **GAS)
    fb.export(model, ("inverse_dynamics", "strut_states"), tmp_path, language)
    passes(tmp_path, language, "inverse_dynamics_strut_states")
