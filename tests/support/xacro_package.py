"""A package with robots in xacro."""

from __future__ import annotations

from pathlib import Path

HEAD = '<robot name="arm" xmlns:xacro="http://ros.org/wiki/xacro">'


def package(tmp_path: Path) -> Path:
    """A package as robots have them: arm_description/urdf/, with parts below it."""
    parts = tmp_path / "arm_description" / "urdf" / "parts"
    parts.mkdir(parents=True)
    (parts / "part.xacro").write_text(
        f'{HEAD}<xacro:property name="length" value="0.25"/><xacro:macro name="part" params="n">'
        '<link name="part${n}"/></xacro:macro></robot>'
    )
    for name in "ab":
        (parts / f"more_{name}.xacro").write_text(f'{HEAD}<link name="{name}"/></robot>')
    (parts / "n.yaml").write_text(
        "a: [1, 2.5]\nb: {c: text}\nturn: !degrees 90\nlength: !millimeters 2*3\n"
    )
    return parts.parent


def written(folder: Path, inside: str, name: str = "arm.urdf.xacro") -> Path:
    """The path of a file in the folder with what is inside of its robot."""
    path = folder / name
    path.write_text(f"{HEAD}\n{inside}\n</robot>")
    return path
