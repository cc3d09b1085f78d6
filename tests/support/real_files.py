"""The URDF files of the wheel example-robot-data, and those of them that are refused."""

import sysconfig
from pathlib import Path

ROBOTS = Path(sysconfig.get_path("purelib"), "cmeel.prefix/share/example-robot-data/robots")
FILES = sorted(path.relative_to(ROBOTS).as_posix() for path in ROBOTS.rglob("*.urdf"))
REFUSED = {
    "ur_description/urdf/ur3.urdf": "there are no links",
    "alex_description/urdf/alex_psyonic_hands.urdf": "no joint 'index_q1' in the mimic of "
    "'Left_index_q2'",
}
"""With mimics followed; the second loads with mimic="free"."""
