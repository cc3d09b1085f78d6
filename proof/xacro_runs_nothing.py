"""A xacro file whose expression would run a shell command under ROS's own tool is refused, and the
command does not run."""

from pathlib import Path

import freebody as fb

TEXT = """<robot xmlns:xacro="http://ros.org/wiki/xacro" name="r"><link name="a"/>
<xacro:property name="x" value="${(lambda: __import__('os').system('touch ran'))()}"/>
<link name="b${x}"/></robot>"""
reason = "the file was read"
try:
    fb.load(text=TEXT, format="xacro")
except fb.FileError as error:
    reason = str(error)
print(reason)
assert "is not allowed (Lambda)" in reason
assert not Path("ran").exists()
