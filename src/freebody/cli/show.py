"""The command `freebody show`."""

from __future__ import annotations

from typing import TYPE_CHECKING

from freebody.cli import options, terminal
from freebody.model import joint_table
from freebody.model.doubt_rules.aspects import ALL
from freebody.model.doubts import Doubt, capital, doubts_used
from freebody.model.parameters import Parameter
from freebody.outputs.display import TextTable

if TYPE_CHECKING:
    from rich.tree import Tree

    from freebody.model.model import Model


EXAMPLE = "Example: freebody show ur5e"

_DEEPEST = 24
"""Levels that the tree indents by; what is deeper says what it is on."""


@options.collected(
    wrench="show tells what the robot is made of, and computes no forces.",
    speed="show tells what the robot is made of; there is no motion.",
)
def show(robot: options.GivenRobot) -> None:
    """Show what a robot is made of: bodies, joints, limits, masses, frames, and how its file was
    read."""
    model = robot.load()
    out = terminal.out()
    out.print(_heading(model))
    if model.about:
        out.print(model.about)
    if model.source:
        out.print(f"source: {model.source}")
    out.print()
    out.print(_tree(model))
    out.print()
    terminal.table(joint_table.table(model))
    out.print()
    if model.loops:
        terminal.table(_loops(model))
        out.print(_mobility(model), soft_wrap=True)
        if not any(body.joint.passive for body in model.bodies):
            out.print(_UNSAID, soft_wrap=True)
        out.print()
    out.print(f"frames: {', '.join(model.frame_names)}")
    numbers = _numbers(model)
    if numbers:
        out.print(f"numbers: {numbers}; others by --parameter NAME=VALUE", soft_wrap=True)
    if model.formulas:
        out.print(f"formulas: {', '.join(f'{x.name} = {x.text}' for x in model.formulas)}")
    for notice in model.notices:
        if not isinstance(notice, Doubt) and notice.kind not in ("physical", "drive"):
            out.print(f"note: {notice}", soft_wrap=True)  # those have been printed in yellow
    for doubt in doubts_used(model, *ALL):
        out.print(capital(doubt.text), soft_wrap=True)


def _numbers(model: Model) -> str:
    """The named numbers of a robot with their values, but gravity's, which the heading has, and
    those that follow by formulas."""
    others = {"g", *(formula.name for formula in model.formulas)}
    return ", ".join(
        name if value is None else f"{name} = {value:.6g}"
        for name, value in sorted(model.parameters.items())
        if name not in others
    )


_UNSAID = (
    "  driven: all joints, because none is marked as passive; the torques are then distributed "
    "over more drives than the motion may need. Mark passive joints (passive = true), or name the "
    "drives: model.replace(actuated=[...])"
)


def _heading(model: Model) -> str:
    space = "in the plane" if model.dim == 2 else "in space"
    if model.missing:
        mass = f"parameters without value: {', '.join(model.missing)}"
    else:
        gravity = ", ".join(f"{x:g}" for x in model.gravity)
        mass = (
            f"{model.mass:.6g} kg{', estimated' if model.is_estimated else ''}; "
            f"gravity [{gravity}] m/s²"
        )
    end = f"tip {model.tip}" if model.tip else "no single tip"
    return (
        f"{model.name}: {len(model.bodies)} bodies {space}, nq = {model.nq}, nv = {model.nv}, "
        f"{mass}, {end}"
    )


def _tree(model: Model) -> Tree:
    from rich.text import Text
    from rich.tree import Tree

    roots = (frame.name for frame in model.frames if frame.body < 0 and not frame.parent)
    root = Tree(Text(next(roots, "world")))  # of a floating base
    carried: dict[int, list[int]] = {}
    for k, body in enumerate(model.bodies):
        carried.setdefault(body.parent, []).append(k)
    waiting = [(k, 0, root) for k in reversed(carried.get(-1, []))]
    while waiting:
        k, depth, above = waiting.pop()
        body = model.bodies[k]
        where = f" on {model.bodies[body.parent].name}" if depth > _DEEPEST else ""
        branch = above.add(Text(f"{body.name}  ({body.joint.name}, {body.joint.kind}){where}"))
        outer = branch if depth < _DEEPEST else above
        waiting += [(child, depth + 1, outer) for child in reversed(carried.get(k, []))]
    return root


def _loops(model: Model) -> TextTable:
    rows = []
    for loop in model.loops:
        distance = loop.distance.name if isinstance(loop.distance, Parameter) else loop.distance
        length = f"{distance:.4g} m" if isinstance(distance, float) else distance or ""
        axis = " ".join(f"{x:.4g}" for x in loop.axis)
        rows.append((loop.name, loop.kind, loop.frames[1], loop.frames[0], axis, length))
    return TextTable(("loop", "kind", "holds", "to", "axis", "distance"), rows)


def _mobility(model: Model) -> str:
    """The number of degrees of freedom at the model's home position, as text."""
    if model.missing:
        return f"degrees of freedom need values for {', '.join(model.missing)}"
    from freebody.errors import LoopError
    from freebody.loops.assembly import assemble
    from freebody.loops.mobility import mobility

    try:
        return str(mobility(model, assemble(model)))
    except LoopError as problem:
        return f"not closed: {problem}"
