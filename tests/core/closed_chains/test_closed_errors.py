"""What closed chains are refused for, in words; and batches, dictionaries, files and pickles."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

import freebody as fb
from freebody import (
    FreebodyError,
    LoopError,
    Model,
    NotFiniteError,
    ShapeError,
    SingularError,
    UnknownNameError,
)
from support.helpers import all_driven, close, refused

pytestmark = pytest.mark.usefixtures("numpy_kernels")

CLOSED = ("four_bar", "slider_crank", "five_bar", "five_bar_rods", "3RRR")
STILL = np.zeros(3)


@pytest.fixture(scope="module")
def four_bar() -> Model:
    return fb.load("four_bar")


@pytest.fixture(scope="module")
def q(four_bar: Model) -> np.ndarray:
    return fb.assemble(four_bar, [1.0, -1.0, 1.2])


# ---------------------------------------------------------------- words
def test_a_loop_that_cannot_be_assembled(four_bar):
    # ground 1, crank 0.3, rocker 0.7: a coupler of 5 ends 3 m too far
    refused(
        "assemble: loop 'closing_pin' of 'four_bar' stays open by 3 m, at the nearest position "
        "found; its links may be "
        "too short or too long to meet. Start from another guess, or check lengths and frames.",
        lambda: fb.assemble(four_bar.bind(l2=5.0), [1.0, -1.0, 1.2]),
        LoopError,
    )
    with pytest.raises(
        LoopError, match=r"stays open by .* m, .* or let one of crank_pin, coupler_pin move too\."
    ):
        fb.assemble(four_bar, [1.0, 3.0, 1.2], free=["rocker_pin"])
    with pytest.raises(LoopError, match=r"stays open by 3 m at sample 0,"):
        fb.assemble(four_bar.bind(l2=5.0), [[1.0, -1.0, 1.2]] * 2)


def test_a_loop_that_is_open(four_bar, q):
    open_ = q + [0.0, 0.2, 0.0]
    for name, call in (
        ("forward_dynamics", lambda: fb.forward_dynamics(four_bar, open_, STILL, STILL)),
        ("inverse_dynamics", lambda: fb.inverse_dynamics(four_bar, open_, STILL, STILL)),
        ("static_torque", lambda: fb.static_torque(four_bar, open_)),
        ("reactions", lambda: fb.reactions(four_bar, open_, STILL, tau=STILL)),
        ("mobility", lambda: fb.mobility(four_bar, open_)),
        ("loop_velocity", lambda: fb.loop_velocity(four_bar, open_, STILL)),
        ("input_output", lambda: fb.input_output(four_bar, open_)),
        ("simulate", lambda: fb.simulate(four_bar, open_, STILL, [0.0, 1.0])),
    ):
        refused(
            f"{name}: loop 'closing_pin' of 'four_bar' is open by 0.18 m; close it with "
            f"fb.assemble(model, q).",
            call,
            LoopError,
        )
    with pytest.raises(LoopError, match=r"is open by .* m at sample 2;"):
        fb.forward_dynamics(four_bar, np.array([q, q, open_]), STILL, STILL)


def test_a_loop_that_opens(four_bar, q):
    refused(
        "forward_dynamics: loop 'closing_pin' of 'four_bar' would open at 0.7 m/s; make the rates "
        "consistent with "
        "fb.loop_velocity(model, q, qd).",
        lambda: fb.forward_dynamics(four_bar, q, [0.0, 0.0, 1.0], STILL),
        LoopError,
    )
    refused(
        "inverse_dynamics: loop 'closing_pin' of 'four_bar' would open under these accelerations; "
        "make them consistent "
        "with fb.loop_acceleration(model, q, qd, qdd).",
        lambda: fb.inverse_dynamics(four_bar, q, STILL, [0.0, 0.0, 1.0]),
        LoopError,
    )


def test_a_loop_closed_the_wrong_way_round(four_bar, q):
    model = four_bar.to_space()
    # the coupler's end turned over: its pin points the other way
    turned = model.with_frame("over", rotation=np.diag([1.0, -1.0, -1.0]), frame="P").without(
        "loops"
    )
    turned = turned.with_loop("pin", "revolute", ("rocker_end", "over"), axis=(0.0, 0.0, 1.0))
    refused(
        "mobility: loop 'pin' of 'four_bar' is closed the wrong way round: its frames face "
        "opposite ways; start "
        "fb.assemble from another guess, or turn one frame.",
        lambda: fb.mobility(turned, q),
        LoopError,
    )
    refused(
        "assemble: loop 'pin' of 'four_bar' closes only the wrong way round: its frames face "
        "opposite ways. Start from "
        "another guess, or turn one frame.",
        lambda: fb.assemble(turned, q),
        LoopError,
    )


def test_a_fixed_loop_a_third_of_a_turn_wrong():
    """Three perpendicular axes are so again after a third of a turn about their diagonal; it is no
    closed loop."""
    ball = fb.dh(
        [{}, {"alpha": np.pi / 2}, {"alpha": -np.pi / 2}, {"a": 0.5}], convention="standard"
    )
    model = ball.with_loop("hold", "fixed", (ball.frame_names[0], ball.frame_names[-1]))
    rng = np.random.default_rng(0)
    for _ in range(10):
        try:
            q = fb.assemble(model, rng.uniform(-3, 3, size=model.nq))
        except LoopError:
            continue
        T = fb.forward_kinematics(model, q, ball.frame_names[-1])
        assert np.abs(T[:3, :3] - np.eye(3)).max() < 1e-9


def test_names_shapes_and_numbers(four_bar, q):
    with pytest.raises(
        UnknownNameError, match=r"no coordinate 'crankpin' .* Did you mean 'crank_pin'"
    ):
        fb.assemble(four_bar, q, free=["crankpin"])
    with pytest.raises(UnknownNameError, match="no coordinate 'x' in inverse_dynamics"):
        fb.inverse_dynamics(four_bar, q, STILL, STILL, actuated=["x"])
    with pytest.raises(UnknownNameError, match="no coordinate 'x' in loop_velocity"):
        fb.loop_velocity(four_bar, q, {"x": 1.0})
    with pytest.raises(
        ShapeError, match=r"forward_dynamics: tau has shape \(2,\), expected \(..., 3\)"
    ):
        fb.forward_dynamics(four_bar, q, STILL, [0.0, 0.0])
    with pytest.raises(ShapeError, match=r"assemble: q has shape \(2,\)"):
        fb.assemble(four_bar, [0.0, 1.0])
    with pytest.raises(NotFiniteError, match="reactions: qd is nan for 'crank_pin'"):
        fb.reactions(four_bar, q, [np.nan, 0.0, 0.0], tau=STILL)
    with pytest.raises(NotFiniteError, match="assemble: q is inf"):
        fb.assemble(four_bar, [np.inf, 0.0, 0.0])
    with pytest.raises(UnknownNameError, match="no frame 'Q' in 'four_bar'"):
        fb.forward_dynamics(four_bar, q, STILL, STILL, {"Q": [0.0, 0.0, 0.0]})
    refused(
        "assembly_modes: q has shape (2, 3), expected (3,): one position.",
        lambda: fb.assembly_modes(four_bar, [q, q]),
    )
    refused(
        "assembly_modes: starts is 0, expected at least 1.",
        lambda: fb.assembly_modes(four_bar, q, free=["coupler_pin"], starts=0),
    )
    refused(
        "reactions: give either tau=, the torques, or qdd=, the accelerations.",
        lambda: fb.reactions(four_bar, q, STILL),
    )
    with pytest.raises(
        fb.FreebodyError,
        match=r"no reaction 'pin' in this mechanism\. Reactions: crank_pin, coupler_pin",
    ):
        fb.reactions(four_bar, q, STILL, tau=STILL)["pin"]
    tree = four_bar.opened
    refused(
        "reactions: actuated= chooses among the joints of a closed chain; 'four_bar' has no loops.",
        lambda: fb.reactions(tree, q, STILL, tau=STILL, actuated=["crank_pin"]),
    )
    for bad in (0.0, -1.0, np.nan):
        with pytest.raises(
            fb.FreebodyError, match=r"simulate: tolerance is .*, expected a number above 0"
        ):
            fb.simulate(four_bar, q, STILL, [0.0, 1.0], tolerance=bad)
    for name, call in (
        ("assemble", lambda: fb.assemble(tree, q)),
        ("loop_velocity", lambda: fb.loop_velocity(tree, q, STILL)),
        ("input_output", lambda: fb.input_output(tree, q)),
    ):
        refused(f"{name}: 'four_bar' has no loops; add one with model.with_loop(...).", call)


def test_rates_by_name_are_looked_at(four_bar, q):
    rates = fb.loop_velocity(four_bar, q, {"crank_pin": [1.0, 2.0]})
    close(rates[1], fb.loop_velocity(four_bar, q, {"crank_pin": 2.0}), 0.0)
    with pytest.raises(NotFiniteError, match=r"loop_velocity: rates\['crank_pin'\] is nan"):
        fb.loop_velocity(four_bar, q, {"crank_pin": np.nan})
    with pytest.raises(
        fb.FreebodyError, match=r"rates\['crank_pin'\] is 'a', expected real numbers"
    ):
        fb.loop_velocity(four_bar, q, {"crank_pin": "a"})


def test_reactions_of_accelerations_that_would_open_a_loop(four_bar, q):
    for call in (
        lambda: fb.reactions(four_bar, q, STILL, qdd=[1.0, 0.0, 0.0]),
        lambda: fb.joint_wrenches(four_bar, q, STILL, [1.0, 0.0, 0.0]),
    ):
        with pytest.raises(
            LoopError, match=r"would open under these accelerations; make them consistent"
        ):
            call()


@pytest.mark.parametrize("speed", [0.0, 30.0])
@pytest.mark.parametrize("size", [1.0, 1e4])
def test_fast_and_large_accelerations_that_would_open_a_loop(four_bar, q, speed, size):
    """What an equation misses is compared with its own terms, so that a miss of a thousandth is
    seen at any size, rounding at none."""
    qd = fb.loop_velocity(four_bar, q, {"crank_pin": speed})
    right = fb.loop_acceleration(four_bar, q, qd, {"crank_pin": size})
    wrong = right + [0.0, 1e-3 * float(np.abs(right).max()), 0.0]
    for call in (fb.inverse_dynamics, fb.joint_wrenches):
        call(four_bar, q, qd, right * (1.0 + 1e-10))
        with pytest.raises(LoopError, match="would open under these accelerations"):
            call(four_bar, q, qd, wrong)
    if speed:  # what the rates ask for is a term as well
        with pytest.raises(LoopError, match="would open under these accelerations"):
            fb.inverse_dynamics(four_bar, q, qd, 0.0 * right)


def test_a_tree_moves_in_all_its_coordinates():
    """Without loops there is no equation to count, and every coordinate is independent."""
    found = fb.mobility(fb.load("2R"), [0.3, 0.4])
    assert (found.instantaneous, found.generic, found.gruebler) == (2, 2, 2)
    assert (found.equations, found.rank, found.redundant) == (0, 0, ())
    assert found.independent == ("joint1", "joint2")
    assert not found.singular


def test_what_singularity_loci_refuse():
    five_bar = fb.load("five_bar")
    refused(
        "singularity_loci: 3 rows are chosen and 'five_bar' has 2 degrees of freedom; these must "
        "be equal.",
        lambda: fb.singularity_loci(five_bar, "first", rows=["vx", "vy", "w"]),
    )
    with pytest.raises(NotFiniteError, match=r"singularity_loci: hold\['theta1'\] is nan"):
        fb.singularity_loci(five_bar, "first", hold={"theta1": np.nan})


def test_a_mechanism_that_cannot_move_has_no_study():
    arm = fb.planar("RR", l=[1, 1], lc=[0.5, 0.5], m=[1, 1], I=[0.1, 0.1])
    rigid = arm.with_frame("pin", [1.0, 0.0], frame="base").with_loop(
        "hold", "point", ("pin", "tip")
    )
    refused(
        "default_motion: the loops of 'RR' allow no motion; fb.mobility(model, q) gives its "
        "degrees of freedom.",
        lambda: fb.study(rigid),
    )


def test_the_axis_and_the_distance_of_a_loop_are_numbers():
    arm = fb.planar("RR", l=[1, 1], lc=[0.5, 0.5], m=[1, 1], I=[0.1, 0.1]).with_frame(
        "pin", [1, 0], frame="base"
    )
    for axis in ("x", 3, [[1.0, 0.0]]):
        with pytest.raises(fb.FreebodyError, match=r"loop 'a': axis .* must be 2 finite numbers"):
            arm.with_loop("a", "prismatic", ("pin", "tip"), axis=axis)
    rod = arm.with_loop("rod", "distance", ["pin", "tip"], distance="d")
    assert hash(rod.loops) == hash(
        arm.with_loop("rod", "distance", ("pin", "tip"), distance="d").loops
    )
    for d in (0.0, -1.0):
        with pytest.raises(
            fb.FreebodyError, match=r"loop 'rod': distance is .* m, expected more than 0"
        ):
            rod.bind(d=d)


def test_metres_are_not_wrapped_as_angles_are():
    """With a longest link of 1 m lengths and angles have the same scale; a slide of 2π m is still
    no whole turn."""
    crank = fb.load("slider_crank").bind(l1=1.0, l2=0.99)
    guess = {"crank_pin": 0.3, "rod_pin": -1.0, "guide": -4.0}
    modes = fb.assembly_modes(crank, guess, free=["rod_pin", "guide"])
    assert [fb.mobility(crank, q).generic for q in modes] == [1, 1]


def test_rates_that_say_too_little_or_too_much(four_bar, q):
    text = (
        "leave 'four_bar' free to move; give one for every independent coordinate: "
        "fb.mobility(model, q).independent "
        "names a choice."
    )
    refused(
        f"loop_velocity: the values given for nothing {text}",
        lambda: fb.loop_velocity(four_bar, q, {}),
    )
    refused(
        "loop_velocity: loop 'closing_pin' of 'four_bar' does not allow the values given: they "
        "contradict its "
        "equations; give fewer of them.",
        lambda: fb.loop_velocity(four_bar, q, {"crank_pin": 1.0, "rocker_pin": 1.0}),
        LoopError,
    )
    refused(
        "assembly_modes: 'four_bar' still moves with the other coordinates held, so it has "
        "infinitely many positions; "
        "free fewer coordinates.",
        lambda: fb.assembly_modes(four_bar, q, starts=20),
    )


def test_drives_that_do_not_force_the_motion(four_bar, q):
    refused(
        "inverse_dynamics: the driven joints of 'four_bar' (none) cannot force this motion: it "
        "can move with these joints locked (too few drives, or a singular position of the second "
        "type). Drive another joint: "
        "actuated=[...].",
        lambda: fb.inverse_dynamics(four_bar, q, STILL, STILL, actuated=[]),
        SingularError,
    )
    five = fb.load("five_bar")
    at = fb.assemble(five, {"theta1": 2.0, "B": -1.0, "theta2": 1.0, "D": 1.2})
    with pytest.raises(SingularError, match=r"'five_bar' \(theta1\) cannot force this motion"):
        fb.inverse_dynamics(five, at, np.zeros(4), np.zeros(4), actuated=["theta1"])


def test_a_drive_that_nothing_moves(tmp_path):
    """A differential screw whose two threads are equal: the carriage stands still whatever they
    turn, but for rounding."""
    heavy = "mass = 1\ninertia = [0.1, 0, 0, 0.1, 0, 0.1]\n"
    link = "[[link]]\nname = '{}'\n" + heavy
    joint = "[[joint]]\nname = '{}'\nparent = '{}'\nchild = '{}'\nkind = '{}'\naxis = 'z'\n{}\n"
    frame = "[[frame]]\nname = '{}'\nparent = '{}'\norigin = [0.1, 0, 0]\n"
    path = tmp_path / "jack.toml"
    path.write_text(
        "".join(map(link.format, ("base", "spindle", "nut", "carriage")))
        + joint.format("outer", "base", "spindle", "helical", "pitch = 0.02")
        + joint.format("inner", "spindle", "nut", "helical", "pitch = { name = 'h', value = 0.02 }")
        + joint.format("slide", "base", "carriage", "prismatic", "")
        + "".join(frame.format(*pair) for pair in (("A", "nut"), ("B", "carriage")))
        + "[[loop]]\nname = 'on'\nkind = 'fixed'\nframes = ['A', 'B']\n"
    )
    model = fb.load(path)
    at = fb.assemble(model, [0.4, 0.3, 0.2])
    with pytest.raises(SingularError, match=r"\(slide\) cannot force this motion"):
        fb.inverse_dynamics(model, at, STILL, [0.1, -0.1, 0.0], actuated=["slide"])
    # with another thread it moves, and gives the power that the motion takes
    model = model.bind(h=0.03)
    at = fb.assemble(model, [0.4, 0.3, 0.2])
    motion = np.array([1.0, -1.0, -0.01])
    power = fb.inverse_dynamics(model.opened, at, STILL, motion) @ motion
    for driven in (["slide"], ["outer"]):
        tau = fb.inverse_dynamics(model, at, STILL, motion, actuated=driven)
        close(tau @ motion, power, 1e-12)


def test_motions_without_inertia_are_named():
    """A rod that may spin about its own line: nothing tells its acceleration."""
    model = fb.load("five_bar_rods").bind(m3=0.0)
    q = fb.assemble(model, [2.0, 1.0, 0.0, 0.7])
    # two rods hold the point without mass: nothing is left open
    assert np.isfinite(fb.forward_dynamics(model, q, np.zeros(4), np.zeros(4))).all()
    loose = fb.load("five_bar_rods").bind(m3=0.0).without("loops")
    loose = loose.with_loop("rod3", "distance", ("B", "P"), distance=0.6)
    with pytest.raises(
        SingularError, match=r"its loops let '[xy]' move without moving any inertia\. Give a mass"
    ):
        fb.forward_dynamics(loose, q, np.zeros(4), np.zeros(4))


# ---------------------------------------------------------------- batches, dictionaries, wrenches
def states(model: Model, n: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    rng = np.random.default_rng(7)
    start = fb.neutral(model)
    if model.name.startswith("five_bar"):
        bent = {"theta1": 2.0, "B": -1.0, "theta2": 1.0, "D": 1.2, "x": 0.0, "y": 0.7}
        start = np.array([bent[name] for name in model.joint_names])
    if model.name == "3RRR":
        angles = np.radians([94.6, -115.3, 214.6, -115.3, -25.4, -115.3])
        start = np.concatenate([np.zeros(3), angles]) - 0.2
    q = fb.assemble(model, start + rng.uniform(0.0, 0.4, size=(n, model.nq)))
    qd = fb.loop_velocity(model, q, rng.normal(size=(n, model.nv)))
    return q, qd, rng.normal(size=(n, model.nv))


@pytest.mark.sample(2)
@pytest.mark.parametrize("name", CLOSED)
def test_batches_are_their_samples(name):
    model = all_driven(fb.load(name))
    q, qd, tau = states(model, 6)
    qdd = fb.forward_dynamics(model, q, qd, tau)
    needed = fb.inverse_dynamics(model, q, qd, qdd)
    found = fb.reactions(model, q, qd, tau=tau)
    wide = fb.forward_dynamics(
        model, q.reshape(2, 3, -1), qd.reshape(2, 3, -1), tau.reshape(2, 3, -1)
    )
    close(wide.reshape(6, -1), qdd, 1e-15)
    assert found.balance < 1e-9
    held = fb.static_torque(model, q)
    for k in range(6):
        close(fb.forward_dynamics(model, q[k], qd[k], tau[k]), qdd[k], 1e-12, 1.0)
        close(fb.inverse_dynamics(model, q[k], qd[k], qdd[k]), needed[k], 1e-12, 1.0)
        close(fb.static_torque(model, q[k]), held[k], 1e-12, 1.0)
        one = fb.reactions(model, q[k], qd[k], tau=tau[k])
        close(one.wrenches, found.wrenches[k], 1e-10, float(np.abs(found.wrenches).max()))
        assert (one.determined == found.determined[k]).all()
        close(one.multipliers, found.multipliers[k], 1e-10, float(np.abs(found.multipliers).max()))
    # one position, many torques
    many = fb.forward_dynamics(model, q[0], qd[0], tau)
    close(many[0], qdd[0], 1e-12, 1.0)
    assert many.shape == (6, model.nv)


@pytest.mark.sample(1)
@pytest.mark.parametrize("name", ["four_bar", "stewart"])
def test_no_samples_give_no_results(name):
    model = fb.load(name)
    q, v = np.zeros((0, model.nq)), np.zeros((0, model.nv))
    assert fb.forward_dynamics(model, q, v, v).shape == v.shape
    assert fb.inverse_dynamics(model, q, v, v).shape == v.shape
    assert fb.static_torque(model, q).shape == v.shape
    assert fb.assemble(model, q).shape == q.shape
    assert fb.loop_velocity(model, q, v).shape == v.shape
    assert fb.loop_acceleration(model, q, v, v).shape == v.shape
    six = 3 if model.dim == 2 else 6
    found = fb.reactions(model, q, v, tau=v)
    assert found.wrenches.shape == (0, len(found.names), six)
    assert found.balance == 0.0


def test_dictionaries_do_as_vectors(four_bar, q):
    by_name = dict(zip(four_bar.joint_names, q, strict=True))
    rates = fb.loop_velocity(four_bar, by_name, {"crank_pin": 1.0})
    close(rates, fb.loop_velocity(four_bar, q, {"crank_pin": 1.0}), 0.0)
    named = dict(zip(four_bar.joint_names, rates, strict=True))
    tau = dict.fromkeys(four_bar.joint_names, 0.0) | {"crank_pin": 2.0}
    close(
        fb.forward_dynamics(four_bar, by_name, named, tau),
        fb.forward_dynamics(four_bar, q, rates, [2.0, 0.0, 0.0]),
        0.0,
    )
    close(fb.assemble(four_bar, by_name), q, 1e-15)


def test_wrenches_on_frames(four_bar, q):
    """A moment on the crank is a torque of its pin; forces do work along their frames'
    Jacobians."""
    qd = fb.loop_velocity(four_bar, q, {"crank_pin": 1.3})
    close(
        fb.forward_dynamics(four_bar, q, qd, STILL, {"crank": [0.0, 0.0, 2.0]}),
        fb.forward_dynamics(four_bar, q, qd, [2.0, 0.0, 0.0]),
        1e-12,
    )
    w = np.array([3.0, -1.0, 0.4])
    tip = fb.jacobian(four_bar, q, "P").T @ w
    driven = fb.forward_dynamics(all_driven(four_bar), q, qd, tip)
    close(fb.forward_dynamics(four_bar, q, qd, STILL, w), driven, 1e-12)
    close(
        fb.static_torque(four_bar, q, {"P": w})[0] - fb.static_torque(four_bar, q)[0],
        -w @ fb.velocity(four_bar, q, fb.loop_velocity(four_bar, q, {"crank_pin": 1.0}), "P"),
        1e-12,
        1.0,
    )


# ---------------------------------------------------------------- files and pickles
@pytest.mark.parametrize("name", [*CLOSED, "stewart", "bricard", "double_four_bar"])
def test_saved_and_loaded(name, tmp_path):
    model = fb.load(name)
    fb.save(model, tmp_path / "model.toml")
    again = fb.load(tmp_path / "model.toml")
    assert again.loops == tuple(again.loops)
    assert [(l.name, l.kind, l.frames, l.axis) for l in again.loops] == [
        (l.name, l.kind, l.frames, l.axis) for l in model.loops
    ]
    assert [l.distance for l in again.tree.loops] == [l.distance for l in model.tree.loops]
    assert again.actuated == model.actuated
    q = fb.random_state(model, 1)[0]
    for one, other in ((model, again), (model, pickle.loads(pickle.dumps(model)))):
        close(
            fb.loops.scaled_equations.every_residual(other, q),
            fb.loops.scaled_equations.every_residual(one, q),
            1e-12,
            1.0,
        )
        assert other.actuated == one.actuated


def test_results_and_errors_are_pickled(four_bar, q):
    found = fb.reactions(four_bar, q, STILL, tau=STILL)
    again = pickle.loads(pickle.dumps(found))
    close(again["closing_pin"], found["closing_pin"], 0.0)
    with pytest.raises(LoopError) as caught:
        fb.forward_dynamics(four_bar, q + 1.0, STILL, STILL)
    assert str(pickle.loads(pickle.dumps(caught.value))) == str(caught.value)
    assert str(fb.mobility(four_bar, q)).startswith(
        "four_bar: 1 degree of freedom (Grübler 1, instantaneous 1)\n"
    )


@pytest.mark.parametrize(("joint", "loop"), [("O1", "L1"), ("O3", "L2")])
def test_accelerations_that_open_one_of_two_loops_name_that_one(joint: str, loop: str) -> None:
    model = fb.load("double_four_bar")
    q = fb.assemble(model)
    qdd = np.where(np.array(model.velocity_names) == joint, 1.0, 0.0)
    with pytest.raises(fb.LoopError, match=f"loop '{loop}'"):
        fb.inverse_dynamics(model, q, np.zeros(model.nv), qdd)


def test_a_guess_by_name_may_leave_out_what_may_move(tmp_path):
    """A platform on three legs has two dozen coordinates; one says the drives."""
    model = fb.load("five_bar")
    given = {"theta1": 2.1, "theta2": 1.0}
    home = dict(zip(model.position_names, fb.assemble(model), strict=True))
    q = fb.assemble(model, given, free=["B", "D"])
    assert q[[model.position_names.index(name) for name in given]].tolist() == [2.1, 1.0]
    start = dict(zip(model.position_names, [0.0] * model.nq, strict=True)) | dict(model.home)
    assert q.tolist() == fb.assemble(model, {**start, **given}, free=["B", "D"]).tolist()
    batch = fb.assemble(model, {**given, "theta1": np.array([2.1, 2.0])}, free=["B", "D"])
    assert batch[0].tolist() == q.tolist()
    with pytest.raises(FreebodyError, match="lacks theta2"):
        fb.assemble(model, {"theta1": 2.1}, free=["B", "D"])
    with pytest.raises(FreebodyError, match="no entry 'E'"):
        fb.assemble(model, {**home, "E": 0.0})


def test_a_quaternion_may_be_left_out_as_a_whole():
    model = fb.load("stewart")
    joint = next(b.joint.name for b in model.bodies if b.kind.nq == 7)
    kept = [n for n in model.position_names if not n.startswith(joint + ".")]
    home = dict(zip(model.position_names, fb.assemble(model), strict=True))
    q = fb.assemble(model, {n: home[n] for n in kept}, free=[joint])
    np.testing.assert_allclose(q, list(home.values()), atol=1e-9)
