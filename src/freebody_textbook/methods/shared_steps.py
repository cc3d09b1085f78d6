"""Derivation steps that several methods share: vectors along the bodies, motion of the bodies, and
joints that follow others."""

from __future__ import annotations

from collections.abc import Mapping

from freebody.elementary import Scalar
from freebody.errors import listed
from freebody.expressions import expression as ex
from freebody.expressions.expression import Equation, Expression, eq
from freebody.expressions.nodes import Words
from freebody.expressions.printed_names import vec
from freebody_textbook.derivation import Step
from freebody_textbook.methods.setting import Setting
from freebody_textbook.methods.step_reasons import added_rates, coriolis, drive


def geometry(setting: Setting, rotations: bool = False, inertias: bool = True) -> Step:
    """Step: vectors along the bodies and directions of the joints; in space also inertias and, if
    asked for, rotations."""
    lines: list[Equation] = []
    for i in setting.order:
        lines += _vectors(setting, i)
        if not setting.planar:
            lines += _in_space(setting, i, rotations)
        lines += measured(setting, i, inertias)
    reach = (
        "s_i points from joint i to the next joint (or the tip), "
        "s_ci from joint i to the centre of mass of body i"
    )
    if setting.planar:
        slides = any(map(setting.slides, setting.order))
        along = ", and u_i is the direction in which joint i slides" if slides else ""
        reason = f"{reach}{along}; components are along x and y."
    else:
        turned = "; R takes components from one body's axes to another's" if rotations else ""
        if setting.weighs and not rotations:
            turned = ", and so is gravity, R turning it from the world's axes"
        still = (
            "each is given in the axes of body i, in which it does not change unless a joint slides"
        )
        reason = f"{reach}; {still}{turned}."
    return Step("The vectors", reason, tuple(lines), figure="vectors")


def _vectors(s: Setting, i: int) -> list[Equation]:
    children = s.tree.children(i)
    lines = [eq(s.reach_name(i, k), s.column(s.to_child(i, k))) for k in children]
    if s.loaded(i):
        lines.append(eq(s.tip_name(), s.column(s.to_tip(i))))
    if i in s.weighted:
        lines.append(eq(s.centre_name(i), s.column(s.centre(i))))
    if not s.turns(i) or not s.planar:
        lines.append(eq(s.axis_name(i), s.column(s.axis(i))))
    return lines


def measured(s: Setting, i: int, inertia: bool) -> list[Equation]:
    """Equations of the mass and, if asked for, the inertia of body i, where these are no symbols
    of the model; an inertia in space is always written out as a matrix."""
    if i not in s.weighted:
        return []
    rows = [(s.mass_name(i), s.show(s.mass(i)))]
    if inertia and not s.is_point(i):
        value = s.show(s.inertia(i)) if s.planar else _matrix(s, s.inertia(i))
        rows.append((s.inertia_name(i), value))
    names = set(s.symbols.ring.names)
    return [
        eq(name, value)
        for name, value in rows
        if isinstance(value, ex.Matrix) or not (isinstance(name, ex.Symbol) and name.name in names)
    ]


def _in_space(s: Setting, i: int, rotations: bool) -> list[Equation]:
    lines = []
    if rotations:
        R = s.motion.joints[i][0]
        back = [[R[c][r] for c in range(3)] for r in range(3)]
        lines.append(eq(s.rotation_name(s.tree.bodies[i].parent, i), _matrix(s, back)))
    elif s.weighs:
        field = ex.mul(s.rotation_name(-1, i), vec("g"))
        lines.append(eq(field, s.column(s.gravity(i))))
    return lines


def _matrix(s: Setting, rows: list[list[Scalar]] | tuple) -> Expression:
    return ex.matrix([[s.show(x) for x in row] for row in rows])


def moment_of(force: Expression, arm: Expression) -> Expression:
    """Printed moment arm × force, with signs moved to the front."""
    for x, rest in ((force, arm), (arm, force)):
        if isinstance(x, ex.Negative):
            one, other = (x.operand, rest) if x is force else (rest, x.operand)
            return ex.neg(moment_of(one, other))
    return ex.cross(arm, force)


def motion(s: Setting) -> list[Step]:
    """Steps: angular velocities, and velocities and accelerations of the centres of mass."""
    own = "" if s.planar else ", given in each body's own axes"
    w = [eq(s.angular_name("omega", i), s.angular(s.motion.w[i])) for i in s.order]
    wd = [eq(s.angular_name("omega", i, "_d"), s.angular(s.motion.wd[i])) for i in s.order]
    v = [eq(s.name("vc", i), s.column(s.centre_velocity(i))) for i in s.weighted]
    vd = [eq(s.name("vc", i, "_d"), s.column(s.centre_acceleration(i))) for i in s.weighted]
    still = all(s.column(s.centre_velocity(i)) == ex.ZERO for i in s.weighted)
    return [
        Step(
            "Angular velocities and accelerations",
            f"{added_rates(s)}.",
            (*w, *wd),
            {"RR": ("3.16", "3.17")}.get(s.cited, () if s.planar else ("6.16", "6.20")),
        ),
        Step(
            "Velocities of the centres of mass",
            "Joints turn the bodies about their centres of mass, which do not move."
            if still
            else f"They are the time derivatives of the centres' positions{own}.",
            tuple(v),
            {"R": ("3.8",), "RR": ("3.18", "3.19")}.get(s.cited, () if s.planar else ("6.19",)),
            figure="velocities",
        ),
        Step(
            "Accelerations of the centres of mass",
            "They do not move." if still else _second(s),
            tuple(vd),
            {"R": ("3.9",)}.get(s.cited, () if s.planar else ("6.22",)),
            figure="accelerations",
        ),
    ]


def _second(s: Setting) -> str:
    """A sentence on the terms in an acceleration."""
    extra = coriolis(s, s.order)
    if extra:
        return (
            "A second time derivative; a point that slides on a rotating body also has the "
            f"Coriolis acceleration {extra}."
        )
    if not any(map(s.turns, s.order)):
        return "A second time derivative."
    if s.planar:
        return (
            "A second time derivative: what turns contributes, for each length, a part with its "
            "angular acceleration at right angles to the length (tangential), and one with the "
            "square of its angular velocity along it, towards the joint (centripetal)."
        )
    return (
        "A second time derivative: terms with accelerations, and products of velocities, "
        "since the axes turn."
    )


def shared_motors(
    s: Setting, drives: Mapping[int, Scalar], values: Mapping[int, Scalar] | None = None
) -> list[Step]:
    """Steps for each group of joints moved by one motor; drives: torques of friction and springs;
    values: of the motors, if known."""
    return [_shared(s, i, drives[i], values) for i in s.coupled]


def _shared(s: Setting, i: int, drives: Scalar, values: Mapping[int, Scalar] | None) -> Step:
    parts = [
        ex.mul(
            s.show(s.ratio(k)),
            s.along(k, s.joint_moment(k), s.force_name(s.tree.bodies[k].parent, k)),
        )
        for k in s.together(i)
    ]
    line = eq(s.motor(i), ex.add(*parts, s.show(drives)))
    value = s.show(values[i]) if values else ex.words("")
    if not isinstance(value, Words):
        line = ex.chain(*line.sides, value)
    shares = [f"{_times(s, k)}that at joint {s.numbers[k]}" for k in s.together(i)[1:]]
    reason = (
        f"{following(s, i)}. {_work(s, i)}: the part of the reaction at joint {s.numbers[i]} that "
        f"does work, plus {listed(shares)}. The reactions include the forces of what couples these "
        f"joints.{drive(s, i)}"
    )
    title = "One motor for" if s.driven(i) else "The common equation of"
    return Step(f"{title} {joints(s, i)}", reason, (line,))


def _times(s: Setting, k: int) -> str:
    return "" if s.ratio(k) == 1.0 else f"{s.ratio(k):.15g} times "


def _work(s: Setting, i: int) -> str:
    if not s.driven(i):
        return "No motor drives them, so that together the joints do no work, and this is zero"
    return (
        f"In every motion the motor of joint {s.numbers[i]} does the work of all these joints. "
        f"Divided by the rate of joint {s.numbers[i]} it is the motor's {s.words(i).effort}"
    )


def following(s: Setting, i: int, what: str = "the rate") -> str:
    """A clause, without a full stop, on the joints that move with a multiple of the rate of body
    i's joint."""
    others = s.together(i)[1:]
    factors = listed([f"{s.ratio(k):.15g}" for k in others])
    have = "has" if len(others) == 1 else "have"
    times = "" if factors == "1" else f"{factors} times "
    numbers = listed([str(s.numbers[k]) for k in others])
    return f"Joint{'s' * (len(others) > 1)} {numbers} {have} {times}{what} of joint {s.numbers[i]}"


def joints(s: Setting, i: int) -> str:
    """Phrase for the joint of body i and those that follow it: joints 1 and 2."""
    return f"joints {listed(map(str, sorted(s.numbers[k] for k in s.together(i))))}"
