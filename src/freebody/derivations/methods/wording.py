"""Reasons of steps, in words that follow the structure of the arm."""

from __future__ import annotations

from freebody.derivations.methods.setting import Setting


def free_body(s: Setting, i: int) -> str:
    """What acts on body i, and which laws are written."""
    acting = f"On body {s.numbers[i]} act: {'; '.join(_acting(s, i))}."
    if s.numbers[i] > 1:
        return acting
    about = "the moments about it" if s.planar else "the moments about it, as vectors,"
    return f"{acting} The forces accelerate the centre of mass (Newton), {about} change the angular velocity (Euler)."


def _acting(s: Setting, i: int) -> list[str]:
    n, parent = s.numbers[i], s.numbers[s.tree.bodies[i].parent]
    held = f"the reaction f_{parent},{n} of {'the ground' if parent == 0 else f'body {parent}'} at joint {n}"
    acting = [held]
    if s.planar and s.turns(i):
        acting.append(f"the torque τ_{n}")
    else:
        acting.append(f"the moment n_{parent},{n} there")
    for k in s.tree.children(i):
        c = s.numbers[k]
        what = f"-f_{n},{c} and -τ_{c}" if s.planar and s.turns(k) else f"-f_{n},{c} and -n_{n},{c}"
        acting.append(f"{what}, the opposite of what it does to body {c} at joint {c}")
    if s.weighs:
        acting.append("its weight")
    if s.loaded(i):
        acting.append("the load f at the tip")
    return acting


def listed(items: list[str]) -> str:
    """a, b and c."""
    return items[0] if len(items) == 1 else f"{', '.join(items[:-1])} and {items[-1]}"


def eliminated(s: Setting, i: int) -> str:
    """How the reaction at joint i leaves the equations."""
    n = s.numbers[i]
    first = f"Newton's equation of body {n} gives the force at joint {n}"
    if s.tree.children(i):
        first += ", the forces on the next bodies being known"
    if not s.turns(i):
        moment = (
            ""
            if s.planar and s.tree.bodies[i].parent < 0
            else "; Euler's equation gives the moment of the guide"
        )
        return f"{first}{moment}; the motor's force is the part along the slide, u_{n} · f."
    if s.planar:
        return f"{first}; put into Euler's equation it leaves the torque τ_{n} and nothing unknown."
    return f"{first}; put into Euler's equation it gives the moment, whose part about the axis is the torque τ_{n}."


def substituted(s: Setting, i: int, reactions: bool) -> str:
    """What is put in where."""
    motor = f"the {'torque' if s.turns(i) else 'force'} of motor {s.numbers[i]}"
    bearing = "bearing" if s.turns(i) else "guide"
    what = "force" if s.planar and s.turns(i) else "force and the moment"
    carried = f"the {what} that the {bearing} of joint {s.numbers[i]} passes on, and " if reactions else ""
    return f"With the vectors put in: {carried}{motor}, sorted by accelerations and rates."
