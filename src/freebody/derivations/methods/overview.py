"""What stands before the first step: the robot in words, what is sought, and a table of the
symbols."""

from __future__ import annotations

from freebody.derivations.derivation import Meaning
from freebody.derivations.methods.glossary import glossary
from freebody.derivations.methods.method import Method, Worked
from freebody.derivations.methods.setting import Setting
from freebody.derivations.render.literal import literal
from freebody.errors import listed
from freebody.model.gravity import axis_of
from freebody.model.parameters import Parameter
from freebody.model.single_joints import is_taken_apart


def overview(s: Setting, method: Method, worked: Worked) -> tuple[str, tuple[Meaning, ...]]:
    """(what is given and sought, symbols)."""
    forces = method.finds_torques
    gravity = _gravity(s) if forces else []
    axes = _axes(s) if forces or s.planar else ["Vectors have components in the world's axes."]
    robot = worked.robot or (_arm(s), *_composed(s), *_loops(s))
    told = [
        *_about(s),
        *robot,
        *gravity,
        *(() if worked.robot else axes),
        *_load(s),
        worked.sought or _sought(s),
    ]
    return " ".join(told), worked.table or glossary(s, worked.symbols, forces, worked.steps)


def _about(s: Setting) -> list[str]:
    about = s.symbols.model.about
    return [literal(about)] if about else []


def _arm(s: Setting) -> str:
    count = len(s.order)
    robot = "closed chain" if s.tree.loops else "arm"
    kind = f"A planar {robot}" if s.planar else f"A{'n' * (robot == 'arm')} {robot} in space"
    bodies = "one moving body" if count == 1 else f"{count} moving bodies"
    return (
        f"{kind} with {bodies}: {'; '.join(_joint(s, i) for i in s.order)}. The ground is body 0."
    )


def _joint(s: Setting, i: int) -> str:
    n, parent = s.numbers[i], s.numbers[s.tree.bodies[i].parent]
    below = "the ground" if parent == 0 else f"body {parent}"
    how = f"{s.words(i).joint}, {s.words(i).coordinate}"
    passive = "" if s.driven(i) else ", passive"
    return f"joint {n} ({how} {_coordinate(s, i)}{passive}) joins body {n} to {below}"


def _coordinate(s: Setting, i: int) -> str:
    """θ_1 or d_1, or the slide's own name."""
    name, n = s.coordinate(i), s.numbers[i]
    return f"θ_{n}" if name == f"theta{n}" else f"d_{n}" if name == f"d{n}" else name


def _composed(s: Setting) -> list[str]:
    """Which joints were taken apart."""
    told, n = [], 0
    given = s.symbols.given
    for body in given.bodies if given else ():
        taken_apart = is_taken_apart(body, s.symbols.euler)
        first, n = n + 1, n + (body.kind.nv if taken_apart else 1)
        if taken_apart:
            joints = listed([f"joint {k}" for k in range(first, n + 1)])
            links = [f"body {k}" for k in range(first, n)]
            told.append(
                f"The {body.kind.name} joint {literal(body.joint.name)} is replaced by "
                f"{joints}; between them {'is' if len(links) == 1 else 'are'} {listed(links)}, "
                "without mass."
            )
        if taken_apart and body.joint.passive and body.kind.frees(s.symbols.model.dim):
            borne = f": body {n} is borne by the loops alone" if s.tree.loops else ""
            told.append(f"They hold nothing{borne}.")
        if taken_apart and body.kind.quaternion is not None:
            told.append(
                f"θ_{n - 2}, θ_{n - 1} and θ_{n} are yaw, pitch and roll; the equations are "
                f"singular where the cosine of θ_{n - 1} vanishes."
            )
    return told


def _loops(s: Setting) -> list[str]:
    model = s.symbols.model
    if not model.loops:
        return []
    ends = {frame.name: frame.body for frame in model.frames}

    def end(frame: str) -> str:
        return (
            f"{literal(frame)} of {'the ground' if ends[frame] < 0 else f'body {ends[frame] + 1}'}"
        )

    rows = [
        f"{literal(loop.name)} ({loop.kind}) between {end(loop.frames[0])} and "
        f"{end(loop.frames[1])}"
        for loop in model.loops
    ]
    return [f"{'A loop closes' if len(rows) == 1 else 'Loops close'} it: {'; '.join(rows)}."]


def _gravity(s: Setting) -> list[str]:
    if not s.weighs:
        return ["There is no gravity."]
    model = s.symbols.model
    name = (
        "of magnitude g" if isinstance(model.gravity_size, Parameter) else "of the given magnitude"
    )
    axis = axis_of(model.gravity_direction)
    return [f"Gravity {name} acts {f'along {axis}' if axis else 'in a given direction'}."]


def _axes(s: Setting) -> list[str]:
    if s.planar:
        if len(s.order) == 1 or not any(map(s.turns, s.order[1:])):
            return []
        return ["Angles are positive anticlockwise, each measured from the previous link."]
    return [
        "Each body has a frame of its own, fixed to it; its vectors are given by their components "
        "in that frame "
        "(the notes mark them with a prime)."
    ]


def _load(s: Setting) -> list[str]:
    axes = "" if s.planar else ", with components in the world's axes"
    return (
        [f"A force f acts on the {'robot' if s.tree.loops else 'arm'} at its tip P{axes}."]
        if s.load
        else []
    )


def motors(s: Setting) -> str:
    """Torques and forces of the motors: torques, or a force."""
    words = "torques" if all(map(s.turns, s.order)) else "torques and forces"
    if len(s.order) == 1:
        return "torque" if words == "torques" else "force"
    return words


def _sought(s: Setting) -> str:
    verb = "is" if len(s.order) == 1 else "are"
    return f"Given a motion of the joints, the motor {motors(s)} {verb} sought."
