"""Long chains: reading them takes time in proportion to their links, in whatever order and manner
they are written."""

import time
import warnings
from collections.abc import Callable
from pathlib import Path

import pytest

import freebody as fb
from support.command import run

BODY = (
    '<inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" '
    'izz="1"/></inertial></link>'
)


def urdf(n: int, kind: str = "revolute", reverse: bool = False, mimic: bool = False) -> str:
    """A chain of n joints; `mimic`: each follows the next."""
    parts = ['<link name="l0"/>']
    for k in range(1, n + 1):
        follows = f'<mimic joint="j{k + 1}" multiplier="-1"/>' if mimic and k < n else ""
        parts.append(
            f'<link name="l{k}">{BODY}<joint name="j{k}" type="{kind}"><parent '
            f'link="l{k - 1}"/><child link="l{k}"/>'
            f'<origin xyz="0.1 0 0" rpy="0.1 0 0"/><axis xyz="0 0 1"/>{follows}'
            f'<limit lower="-1" upper="1" effort="1" velocity="1"/></joint>'
        )
    return f'<robot name="chain">{"".join(reversed(parts) if reverse else parts)}</robot>'


def toml(n: int) -> str:
    """A chain of n joints, with a frame on each frame before, a loop, a payload and a home for each
    link."""
    parts = ['[[link]]\nname = "l0"']
    for k in range(1, n + 1):
        parts.append(
            f'[[link]]\nname = "l{k}"\nmass = 1\n[[joint]]\nname = "j{k}"\nkind = "revolute"\n'
            f'parent = "l{k - 1}"\n'
            f'child = "l{k}"\norigin = [0.1, 0, 0]\naxis = "z"\n[[payload]]\nname = "p{k}"\n'
            f'frame = "l{k}"\nmass = 1\n'
            f'[[frame]]\nname = "f{k}"\nparent = "{f"f{k - 1}" if k > 1 else "l1"}"\n'
            "origin = [0, 0.1, 0]\n"
            f'[[loop]]\nname = "c{k}"\nkind = "spherical"\nframes = ["l{k - 1}", "l{k}"]'
        )
    return "\n".join([*parts, "[home]", *(f"j{k} = 0.1" for k in range(1, n + 1))])


def dh(n: int) -> str:
    return "# convention: standard\njoint,theta,a,alpha,m\n" + "R,0,0.1,0.2,1\n" * n


WAYS: dict[str, tuple[str, Callable[[int], str]]] = {
    "links in order": ("urdf", urdf),
    "links in reverse": ("urdf", lambda n: urdf(n, reverse=True)),
    "all joints fixed": ("urdf", lambda n: urdf(n, "fixed")),
    "fixed, in reverse": ("urdf", lambda n: urdf(n, "fixed", reverse=True)),
    "each mimics the next": ("urdf", lambda n: urdf(n, mimic=True)),
    "TOML": ("toml", toml),
    "a DH table": ("csv", dh),
    "a planar word": ("toml", lambda n: f'[planar]\nword = "{"R" * n}"\n'),
}


def seconds(way: str, n: int, folder: Path) -> float:
    """CPU time to read a chain and to ask what one asks of a robot first."""
    suffix, text = WAYS[way]
    path = folder / f"chain{n}.{suffix}"
    path.write_text(text(n))
    start = time.process_time()
    model = fb.load(path)
    assert len(model.limits.lower) == model.nv
    assert len(model.frame_names) > n
    assert len(model.joint_names) in (0, n)
    assert model.missing or model.mass > 0.0
    return time.process_time() - start


@pytest.mark.sample(1)
@pytest.mark.parametrize("way", WAYS)
def test_loading_takes_time_in_proportion_to_the_links(tmp_path, way: str):
    seconds(way, 10, tmp_path)  # what is imported and compiled once
    few, many = (min(seconds(way, n, tmp_path) for _ in range(2)) for n in (200, 1600))
    assert many < 3.0 * 8 * few  # an effort that grows with the square would be 64 times as large


@pytest.mark.long
@pytest.mark.parametrize("way", WAYS)
def test_ten_thousand_links_load_in_five_seconds(tmp_path, way: str):
    seconds(way, 10, tmp_path)
    taken = {n: min(seconds(way, n, tmp_path) for _ in range(2)) for n in (1250, 2500, 5000, 10000)}
    print(way, {n: round(t, 2) for n, t in taken.items()})
    assert taken[10000] < (
        10.0 if way == "TOML" else 5.0
    )  # that one holds 10 000 frames, loops and loads besides
    assert taken[10000] < 2.0 * 8 * taken[1250]


def test_show_of_a_long_chain(tmp_path, capsys):
    path = tmp_path / "chain.urdf"
    path.write_text(urdf(1000, reverse=True))
    start = time.process_time()
    assert run(["show", str(path)]) == 0
    assert time.process_time() - start < 5.0
    text = capsys.readouterr().out
    assert "l1000  (j1000, revolute) on l999" in text
    assert len(text) < 1_000_000  # no line for each level in each line


# ---------------------------------------------------------------- what the short ways must not
# change
def test_links_fixed_in_a_long_row_are_placed_as_one_by_one(tmp_path):
    """100 fixed links, each turned and shifted: the last one's pose is the product of all."""
    path = tmp_path / "row.urdf"
    path.write_text(urdf(100, "fixed"))
    model = fb.load(path)
    R, p = _turned(0.1), [0.1, 0.0, 0.0]
    pose_R, pose_p = [[1.0, 0, 0], [0, 1, 0], [0, 0, 1]], [0.0, 0, 0]
    for _ in range(100):
        pose_p = [pose_p[i] + sum(pose_R[i][k] * p[k] for k in range(3)) for i in range(3)]
        pose_R = [
            [sum(pose_R[i][k] * R[k][j] for k in range(3)) for j in range(3)] for i in range(3)
        ]
    T = fb.forward_kinematics(model, [], "l100")
    assert abs(T[:3, :3] - pose_R).max() < 1e-13
    assert abs(T[:3, 3] - pose_p).max() < 1e-13


def _turned(angle: float) -> list[list[float]]:
    import math

    s, c = math.sin(angle), math.cos(angle)
    return [[1.0, 0, 0], [0, c, -s], [0, s, c]]


def test_mimics_of_mimics_multiply_along_the_chain(tmp_path):
    path = tmp_path / "mimics.urdf"
    path.write_text(urdf(5, mimic=True))
    model = fb.load(path)
    assert model.nv == 1
    assert [at.ratio for at in model.coordinates] == [1.0, -1.0, 1.0, -1.0, 1.0]


def test_a_long_row_of_named_steps_is_refused_and_not_multiplied_out(tmp_path):
    frames = "\n".join(
        f'[[frame]]\nname = "f{k}"\nparent = "{f"f{k - 1}" if k else "link1"}"\n'
        f'origin = ["x{k}", 0]'
        for k in range(1200)
    )
    path = tmp_path / "named.toml"
    path.write_text(f'[planar]\nword = "R"\n{frames}\n')
    with pytest.raises(
        fb.FreebodyError, match="more than 1000 fixed placements with symbolic numbers"
    ):
        fb.load(path)


def test_a_cycle_of_thousands_of_links_is_said_shortly(tmp_path):
    path = tmp_path / "cycle.urdf"
    path.write_text(urdf(2000).replace('<link name="l0"/>', "").replace('"l0"', '"l2000"', 1))
    with (
        warnings.catch_warnings(),
        pytest.raises(fb.FreebodyError, match="the links form a cycle") as refusal,
    ):
        fb.load(path)
    assert len(str(refusal.value)) < 500
