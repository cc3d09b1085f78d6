"""Planar words against closed forms, DH tables against their matrices, and what both refuse."""

from __future__ import annotations

import math
from itertools import product

import numpy as np
import pytest

import freebody as fb
from freebody import Inertia, Limits, Parameter
from support.generate import random_inertia
from support.helpers import close, numbers, refused

pytestmark = pytest.mark.usefixtures("numpy_kernels")

L, LC, MASS, I_G = [0.7, 0.5, 0.4], [0.3, 0.2, 0.25], [2.0, 1.5, 0.8], [0.05, 0.03, 0.01]
LIMITS = (
    "limits must be (lower, upper), or fb.Limits(lower, upper, velocity, effort) with those of "
    "speed and effort too;"
)
WORDS = ["".join(w) for n in (1, 2, 3) for w in product("RP", repeat=n)]


def arm(word: str, **options) -> fb.Model:
    n = len(word)
    return fb.planar(word, l=L[:n], lc=LC[:n], m=MASS[:n], I=I_G[:n], **options)


# ---------------------------------------------------------------- words
def planar_pose(x: float, y: float, angle: float) -> np.ndarray:
    s, c = math.sin(angle), math.cos(angle)
    return np.array([[c, -s, x], [s, c, y], [0, 0, 1]])


def chain(word: str, q: np.ndarray, angles: list[float] | None = None) -> list[np.ndarray]:
    """Poses of the link frames and of the tip, from the geometry as the conventions tell it."""
    T, poses = np.eye(3), []
    for i, letter in enumerate(word):
        constant = (
            angles[i]
            if angles
            else math.pi / 2
            if letter == "P" and i and word[i - 1] == "P"
            else 0.0
        )
        T = T @ planar_pose(L[i - 1] if i else 0.0, 0, constant)
        T = T @ (planar_pose(0, 0, q[i]) if letter == "R" else planar_pose(q[i], 0, 0))
        poses.append(T)
    return [*poses, T @ planar_pose(L[len(word) - 1], 0, 0)]


@pytest.mark.parametrize("word", WORDS)
@pytest.mark.parametrize("angles", [None, [0.3, -0.8, 2.0]], ids=["default", "angles"])
def test_geometry_of_a_word(word: str, angles: list[float] | None):
    angles = angles and angles[: len(word)]
    model = arm(word, angles=angles)
    q, qd, _ = fb.random_state(model, len(word))
    assert (model.dim, model.nv, model.tip) == (2, len(word), "tip")
    for name, T in zip(
        [*(f"link{i + 1}" for i in range(len(word))), "tip"], chain(word, q, angles), strict=True
    ):
        close(fb.forward_kinematics(model, q, name), T, 1e-14, 1.0, name)
    # energies of uniform fields: centres of mass at x = lc
    V = sum(
        m * 9.81 * (T @ [lc, 0, 1])[1]
        for m, lc, T in zip(MASS, LC, chain(word, q, angles)[:-1], strict=False)
    )
    assert fb.potential_energy(model, q) == pytest.approx(V)
    h = 1e-6
    ahead, behind = (chain(word, q + s * h * qd, angles) for s in (1, -1))
    T2 = 0.0
    for m, lc, inertia, A, B in zip(MASS, LC, I_G, ahead[:-1], behind[:-1], strict=False):
        v = ((A - B) @ [lc, 0, 1])[:2] / (2 * h)
        turned = math.atan2((B[:2, :2].T @ A[:2, :2])[1, 0], (B[:2, :2].T @ A[:2, :2])[0, 0]) / (
            2 * h
        )
        T2 += m * v @ v + inertia * turned**2
    assert fb.kinetic_energy(model, q, qd) == pytest.approx(T2 / 2, rel=1e-7)


def test_words_that_have_a_name():
    """PP is the Cartesian arm, PR a cart with a pendulum, RP an arm that extends."""
    q = np.array([0.4, 0.9])
    cartesian = fb.planar("PP", lc=[0, 0], m=[2, 1], I=[1, 1])
    assert fb.forward_kinematics(cartesian, q)[:2, 2] == pytest.approx([0.4, 0.9])
    assert fb.mass_matrix(cartesian, q) == pytest.approx(np.diag([3.0, 1.0]))
    assert fb.gravity_torque(cartesian, q) == pytest.approx([0, 9.81])
    cart = fb.planar("PR", l=[0, 1], lc=[0, 1], m=[2, 1], I=[0, 0])
    assert fb.mass_matrix(cart, q) == pytest.approx(
        np.array([[3, -math.sin(0.9)], [-math.sin(0.9), 1]])
    )
    assert fb.gravity_torque(cart, q) == pytest.approx([0, 9.81 * math.cos(0.9)])
    extends = fb.planar("RP", l=[0, 0], lc=[0.5, 0], m=[1, 2], I=[0.1, 0])
    assert fb.mass_matrix(extends, q) == pytest.approx(np.diag([0.1 + 0.25 + 2 * 0.81, 2.0]))
    assert fb.coriolis_matrix(extends, q, [1.0, 2.0]) @ [1.0, 2.0] == pytest.approx(
        [2 * 2 * 0.9 * 2.0, -2 * 0.9]
    )


def test_two_revolute_links_in_closed_form():
    """The notes' (3.8) to (3.12) and (2.19) with numbers."""
    model = arm("RR")
    (l1, l2, _), (lc1, lc2, _), (m1, m2, _), (I1, I2, _) = L, LC, MASS, I_G
    q, qd = np.array([0.4, 0.9]), np.array([0.7, -1.1])
    s1, c1, s2, c2 = math.sin(q[0]), math.cos(q[0]), math.sin(q[1]), math.cos(q[1])
    s12, c12 = math.sin(q.sum()), math.cos(q.sum())
    H11 = m1 * lc1**2 + I1 + m2 * (l1**2 + lc2**2 + 2 * l1 * lc2 * c2) + I2
    H12 = m2 * (lc2**2 + l1 * lc2 * c2) + I2
    H22 = m2 * lc2**2 + I2
    close(fb.mass_matrix(model, q), [[H11, H12], [H12, H22]], 1e-14)
    h = m2 * l1 * lc2 * s2
    close(
        fb.coriolis_matrix(model, q, qd),
        [[-h * qd[1], -h * (qd[0] + qd[1])], [h * qd[0], 0]],
        1e-14,
    )
    G = 9.81 * np.array([m1 * lc1 * c1 + m2 * (lc2 * c12 + l1 * c1), m2 * lc2 * c12])
    close(fb.gravity_torque(model, q), G, 1e-14)
    J = [[-l1 * s1 - l2 * s12, -l2 * s12], [l1 * c1 + l2 * c12, l2 * c12], [1, 1]]
    close(fb.jacobian(model, q), J, 1e-14)


def test_names_without_numbers():
    model = fb.planar("RPR")
    assert model.name == "RPR"
    assert model.missing == tuple(
        sorted(["I1", "I2", "I3", "l1", "l3", "lc1", "lc2", "lc3", "m1", "m2", "m3"])
    )
    assert model.parameters["g"] == 9.81
    assert fb.planar("PP", l=[None, 2.0]).parameters["l2"] == 2.0
    assert "l1" not in fb.planar("PP").parameters  # a slide has no length unless it is given
    assert set(fb.planar("R", l=["a"], lc=["b"], m=["c"], I=["d"], g="gee").parameters) == {
        "a",
        "b",
        "c",
        "d",
        "gee",
    }
    assert fb.planar("R", l=[Parameter("x", 2.0)]).parameters["x"] == 2.0


def test_options_of_a_word():
    drive = fb.Drive(viscous=2.0, rotor=0.1, gear=10.0)
    model = arm("RR", limits=[(-1, 1), None], drives=[None, drive], g=[1.0, 0.0], name="two")
    assert model.limits.lower.tolist() == [-1, -math.inf]
    assert arm("R", limits=[Limits(-1, 2, 3, 4)]).limits.effort.tolist() == [4]
    assert model.gravity.tolist() == [1, 0]
    assert model.name == "two"
    z = np.zeros(2)
    assert fb.inverse_dynamics(model, z, [0, 1], z)[1] - fb.inverse_dynamics(model, z, z, z)[
        1
    ] == pytest.approx(2.0)
    bare = arm("RR", g=[1.0, 0.0])
    assert (fb.mass_matrix(model, z) - fb.mass_matrix(bare, z)).tolist() == [
        [0, 0],
        [0, pytest.approx(10.0)],
    ]


def test_refusals_of_words():
    letters = "must be made of the letters R and P, such as 'RR' or 'RP'."
    for word in ("", "RX", "rr", 5, None):
        refused(f"planar: the word {word!r} {letters}", lambda word=word: fb.planar(word))
    refused(
        "planar: l must have 2 entries, one per joint; got [1].", lambda: fb.planar("RR", l=[1])
    )
    refused("planar: m must have 2 entries, one per joint; got 3.", lambda: fb.planar("RR", m=3))
    refused(
        "planar: I must have 2 entries, one per joint; got 'ab'.", lambda: fb.planar("RR", I="ab")
    )
    refused(
        "planar: angles must have 2 entries, one per joint; got [0.1].",
        lambda: fb.planar("RR", angles=[0.1]),
    )
    refused("planar: angles[0]: 'a' is not a number.", lambda: fb.planar("RR", angles=["a", 0]))
    refused("planar: l[1]: nan is not a finite number.", lambda: fb.planar("RR", l=[1, math.nan]))
    refused(
        "gravity: a vector of 2 entries in world axes is needed, not 3.",
        lambda: fb.planar("R", g=[0, 0, -1]),
    )
    refused(
        "'RR': joint 'joint1': lower limit 1 is above upper -1; swap them, or leave "
        "both out where there are none.",
        lambda: fb.planar("RR", limits=[(1, -1), None]),
    )
    for given in ((1,), (0, 1, 2), 3):
        refused(
            f"planar: limits[0]: {LIMITS} got {given!r}.",
            lambda given=given: fb.planar("RR", limits=[given, None]),
        )
    refused(
        "planar: limits[1]: limits: 'a' is not a number.",
        lambda: fb.planar("RR", limits=[None, ("a", 1)]),
    )
    refused(
        "planar: drives[0] is (1, 2), expected a Drive such as Drive(viscous=0.1).",
        lambda: fb.planar("RR", drives=[(1, 2), None]),
    )
    refused(
        "'R': link 'link1': mass -1 kg is negative. Correct it, or accept it with physical='warn'.",
        lambda: fb.planar("R", l=[1], lc=[1], m=[-1], I=[1]),
    )
    with pytest.raises(
        fb.FreebodyError,
        match=r"^parameter name 'a b' must be a word of letters, digits and _, such as 'l1'\.$",
    ):
        fb.planar("R", l=["a b"])


# ---------------------------------------------------------------- DH tables
def rz(t: float) -> np.ndarray:
    T = np.eye(4)
    T[:2, :2] = [[math.cos(t), -math.sin(t)], [math.sin(t), math.cos(t)]]
    return T


def rx(t: float) -> np.ndarray:
    T = np.eye(4)
    T[1:3, 1:3] = [[math.cos(t), -math.sin(t)], [math.sin(t), math.cos(t)]]
    return T


def move(x: float, z: float) -> np.ndarray:
    T = np.eye(4)
    T[0, 3], T[2, 3] = x, z
    return T


def table(seed: int, n: int) -> list[dict]:
    rng = np.random.default_rng(seed)
    rows = []
    for _ in range(n):
        inertia = random_inertia(rng)
        quarter = bool(rng.random() < 0.5)
        rows.append(
            {
                "joint": str(rng.choice(["R", "R", "P"])),
                "theta": float(rng.normal()),
                "d": float(rng.normal()),
                "a": float(rng.normal()),
                "alpha": math.pi / 2 * int(rng.integers(-1, 3)) if quarter else float(rng.normal()),
                "m": inertia.mass,
                "com": inertia.com,
                "I": inertia.tensor,
                "rotor": 1e-3,
                "gear": float(rng.uniform(1, 100)),
                "friction": (0.1, 0.2),
            }
        )
    return rows


def dh_frames(rows: list[dict], q: np.ndarray, convention: str) -> list[np.ndarray]:
    """T_0i by the four elementary matrices."""
    T, frames = np.eye(4), []
    for row, x in zip(rows, q, strict=True):
        theta, d = row["theta"], row["d"]
        theta, d = (theta + x, d) if row["joint"] == "R" else (theta, d + x)
        about_z = rz(theta) @ move(0, d)
        about_x = rx(row["alpha"]) @ move(row["a"], 0)
        T = T @ (about_z @ about_x if convention == "standard" else about_x @ about_z)
        frames.append(T)
    return frames


@pytest.mark.parametrize("convention", ["standard", "modified"])
@pytest.mark.parametrize("seed", range(8))
def test_dh_frames_and_energies(convention: str, seed: int):
    rows = table(seed, 1 + seed % 6)
    model = fb.dh(rows, convention=convention)
    q, qd, _ = fb.random_state(model, seed)
    frames = dh_frames(rows, q, convention)
    for i, T in enumerate(frames):
        close(
            numbers(model, "forward_kinematics", q, frame=f"frame{i + 1}"),
            T,
            1e-13,
            1.0,
            f"frame {i + 1}",
        )
    assert model.tip == f"frame{len(rows)}"
    # the centre of mass and the tensor are in DH frame i
    V = sum(
        row["m"] * 9.81 * (T @ [*row["com"], 1])[2] for row, T in zip(rows, frames, strict=True)
    )
    assert numbers(model, "potential_energy", q) == pytest.approx(V)
    h = 1e-6
    ahead, behind = (dh_frames(rows, q + s * h * qd, convention) for s in (1, -1))
    twice = 0.0
    for row, A, T, B, rate in zip(rows, ahead, frames, behind, qd, strict=True):
        Td = (A - B) / (2 * h)
        v = (Td @ [*row["com"], 1])[:3]
        S = T[:3, :3].T @ Td[:3, :3]
        w = np.array([S[2, 1], S[0, 2], S[1, 0]])
        xx, xy, xz, yy, yz, zz = row["I"]
        twice += row["m"] * v @ v + w @ np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) @ w
        twice += row["rotor"] * (row["gear"] * rate) ** 2
    assert numbers(model, "kinetic_energy", q, qd) == pytest.approx(twice / 2, rel=1e-7)


@pytest.mark.parametrize("seed", range(6))
def test_one_arm_in_both_conventions(seed: int):
    """Modified row i holds a and alpha of standard row i - 1; its frame i is the standard one
    before Tx Rx."""
    n = 5
    rows = table(seed, n)
    shifted = []
    for i, row in enumerate(rows):
        a, alpha = (rows[i - 1]["a"], rows[i - 1]["alpha"]) if i else (0.0, 0.0)
        back = move(row["a"], 0) @ rx(row["alpha"])
        placed = Inertia.of(row["m"], row["com"], row["I"]).placed(back[:3, :3], back[:3, 3])
        shifted.append({**row, "a": a, "alpha": alpha, "com": placed.com, "I": placed.tensor})
    standard, modified = fb.dh(rows, convention="standard"), fb.dh(shifted, convention="modified")
    q, qd, qdd = fb.random_state(standard, seed, 3)
    for name in ("inverse_dynamics", "joint_wrenches"):
        found = numbers(modified, name, q, qd, qdd)
        expected = numbers(standard, name, q, qd, qdd)
        if (
            name == "joint_wrenches"
        ):  # modified frames sit at d_i along the joint's axis: forces are the same
            found, expected = found[..., :3], expected[..., :3]
        close(found, expected, 1e-12, 1.0, name)
    close(numbers(modified, "mass_matrix", q), numbers(standard, "mass_matrix", q), 1e-12, 1.0, "M")
    end = move(rows[-1]["a"], 0) @ rx(rows[-1]["alpha"])
    tip = numbers(modified, "forward_kinematics", q) @ end
    close(tip, numbers(standard, "forward_kinematics", q), 1e-12, 1.0, "tip")


def test_standard_reactions_act_on_the_joint_axis():
    """At the origin of frame i - 1: the base's joint at the world's origin, whatever d is."""
    model = fb.dh([{"d": 0.5, "a": 0.3, "m": 2.0}], convention="standard")
    W = fb.joint_wrenches(model, [0.0], [0.0], [0.0])[0]
    assert pytest.approx([0, 0, 2 * 9.81, 0, -0.3 * 2 * 9.81, 0]) == W


def test_right_angles_are_exact():
    model = fb.dh([{"alpha": math.pi / 2 + 5e-13}, {"alpha": -math.pi / 2}], convention="standard")
    T = fb.forward_kinematics(model, [0.0, 0.0], "frame1")
    assert T[:3, :3].tolist() == [[1, 0, 0], [0, 0, -1], [0, 1, 0]]
    off = fb.dh([{"alpha": math.pi / 2 + 1e-9}], convention="standard")
    assert fb.forward_kinematics(off, [0.0])[1, 1] == pytest.approx(-1e-9)


def test_letters_in_a_table():
    row = {
        "d": "d1",
        "a": "a1",
        "m": "m1",
        "com": ("c1x", 0, 0),
        "I": ("I1xx", 0, 0, "I1yy", 0, "I1zz"),
    }
    model = fb.dh([row], convention="standard", gravity="g")
    assert set(model.missing) == {"d1", "a1", "m1", "c1x", "I1xx", "I1yy", "I1zz", "g"}
    bound = model.bind(d1=0.1, a1=0.2, m1=2, c1x=-0.1, I1xx=0.1, I1yy=0.1, I1zz=0.1, g=9.81)
    assert fb.mass_matrix(bound, [0.3])[0, 0] == pytest.approx(0.1 + 2 * 0.01)
    angle = fb.dh(
        [{"alpha": "alpha1", "a": 1.0}, {"m": 1.0, "com": (1.0, 0.0, 0.0)}], convention="standard"
    )
    assert fb.forward_kinematics(angle.bind(alpha1=math.pi / 2), [0.0, math.pi / 2])[
        :3, 3
    ] == pytest.approx([1, 0, 0])


def test_refusals_of_tables():
    def dh(*rows, convention="standard", **options):
        return lambda: fb.dh(list(rows), convention=convention, **options)

    refused(
        "no convention 'craig' in dh. Conventions: standard, modified.", dh({}, convention="craig")
    )
    refused("dh: the table has no rows; give one per joint.", dh())
    keys = (
        "Keys: joint, name, theta, d, a, alpha, m, com, I, rotor, gear, friction, limits, passive."
    )
    refused(f"no key 'alfa' in dh row 2. Did you mean 'alpha'? {keys}", dh({}, {"alfa": 1}))
    refused("dh row 1: joint is 'Q', expected 'R' or 'P'.", dh({"joint": "Q"}))
    refused("dh row 1: com or I without a mass; add m.", dh({"com": (0, 0, 0)}))
    refused("dh row 2: com is (0, 0), expected 3 entries.", dh({}, {"m": 1, "com": (0, 0)}))
    refused("dh row 1: a: nan is not a finite number.", dh({"a": math.nan}))
    refused("dh row 1: com is 3, expected 3 entries.", dh({"m": 1, "com": 3}))
    refused(f"dh row 1: {LIMITS} got 3.", dh({"limits": 3}))
    of_toml = {"lower": -1, "upper": 1}
    refused(f"dh row 1: {LIMITS} got {of_toml}.", dh({"limits": of_toml}))
    refused(
        "dh row 1: friction must be viscous, or (viscous, coulomb); got (1, 2, 3).",
        dh({"friction": (1, 2, 3)}),
    )
    refused(
        "dh row 1: Inertia: the 3×3 tensor is not symmetric.",
        dh({"m": 1, "I": [[1, 1, 0], [0, 1, 0], [0, 0, 1]]}),
    )
    refused(
        "gravity: a vector of 3 entries in world axes is needed, not 2.", dh({}, gravity=[0, 1])
    )
    refused("'dh': two links are called 'arm'; rename one.", dh({"name": "arm"}, {"name": "arm"}))
    refused(
        "'dh': joint 'joint1': lower limit 2 is above upper 1; swap them, or leave "
        "both out where there are none.",
        dh({"limits": (2, 1)}),
    )
    refused(
        "'dh': link 'link1': principal moments 0.1, 0.1, 0.5 kg m² break the triangle inequality "
        "(0.1 + 0.1 < 0.5). "
        "Correct it, or accept it with physical='warn'.",
        dh({"m": 1, "I": [0.1, 0, 0, 0.1, 0, 0.5]}),
    )
    with pytest.raises(TypeError):
        fb.dh([{}])  # the convention is said by the caller, never guessed


@pytest.mark.parametrize(
    "rows",
    [
        "RR",
        3,
        None,
        [1.0, 2.0],
        [["a", 1.0]],
        {"a": 1.0},
        np.eye(2),
        b"ab",
        iter([{"a": 1.0}]),
        [{"a": 1.0}, None],
    ],
    ids=lambda rows: type(rows).__name__,
)
def test_what_is_no_table_of_rows_is_refused_with_what_to_write(rows):
    with pytest.raises(fb.FreebodyError, match="expected a list of dicts, one per joint"):
        fb.dh(rows, convention="standard")
