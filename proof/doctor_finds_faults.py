"""The doctor finds faults planted in a good file: an inertia that no body has, swapped limits, and
an axis that is not a unit vector; in the good file it finds no error."""

import re
from pathlib import Path

import freebody as fb

file = Path("robot.urdf")
fb.save(fb.load("ur5e"), file)
good = file.read_text(encoding="utf-8")
assert fb.doctor(file).sound
planted = {
    "inertia": re.sub(r'ixx="[^"]+"', 'ixx="900"', good, count=1),
    "limits": re.sub(r'lower="([^"]+)" upper="([^"]+)"', r'lower="\2" upper="\1"', good, count=1),
    "axis": re.sub(r'<axis xyz="[^"]+"', '<axis xyz="0 0.6 0.7"', good, count=1),
}
for name, text in planted.items():
    assert text != good, name
    file.write_text(text, encoding="utf-8")
    found = fb.doctor(file).findings[0]
    print(f"{name}: {found.reason}")
    assert found.line
    assert found.severity in ("error", "warning")
