"""The URDF files of the wheel example-robot-data, and those of them that are refused; the robots of
other wheels with data."""

import sysconfig
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest

ROBOTS = Path(sysconfig.get_path("purelib"), "cmeel.prefix/share/example-robot-data/robots")
FILES = sorted(path.relative_to(ROBOTS).as_posix() for path in ROBOTS.rglob("*.urdf"))
REFUSED = {
    "ur_description/urdf/ur3.urdf": "there are no links",
    "alex_description/urdf/alex_psyonic_hands.urdf": "no joint 'index_q1' in the mimic of "
    "'Left_index_q2'",
}
"""With mimics followed; the second loads with mimic="free"."""
WHEELS = {
    "rtbdata": "rtb-data",
    "robosuite": "robosuite",
    "gymnasium_robotics": "gymnasium-robotics",
    "dm_control": "dm-control",
    "mujoco": "mujoco",
    "pybullet_data": "pybullet",
}
"""Modules with robots' files, and the wheels that bring them, of which the tests need none."""
_SUFFIXES = {".urdf": "<robot", ".xacro": "<robot", ".sdf": "<sdf", ".xml": "<mujoco"}
_ALIKE = "random_urdfs"
"""pybullet's folder of a thousand objects that a program has made; every hundredth is taken."""


def every_robot_file() -> Iterator[Any]:
    """The files of robots in the data wheels, as parameters of a test; a wheel that is missing is
    one that is skipped."""
    for module, wheel in WHEELS.items():
        spec = find_spec(module)
        if spec is None:
            reason = f"{wheel} is not installed: pip install {wheel}"
            yield pytest.param(Path(module), marks=pytest.mark.skip(reason=reason), id=module)
            continue
        for root in map(Path, spec.submodule_search_locations or ()):
            found = sorted(path for path in root.rglob("*") if path.suffix in _SUFFIXES)
            alike = [path for path in found if _ALIKE in path.parts]
            for path in [x for x in found if x not in {*alike}] + alike[::100]:
                if _SUFFIXES[path.suffix] in path.read_text(encoding="utf-8", errors="replace"):
                    yield pytest.param(path, id=f"{module}/{path.relative_to(root).as_posix()}")
