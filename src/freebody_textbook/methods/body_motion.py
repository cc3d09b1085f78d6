"""The steps that give each body's angular velocity and the motion of its centre of mass."""

from __future__ import annotations

from freebody.expressions import expression as ex
from freebody.expressions.expression import eq
from freebody_textbook.derivation import Step
from freebody_textbook.methods.setting import Setting
from freebody_textbook.methods.step_reasons import added_rates, coriolis


def motion(s: Setting) -> list[Step]:
    """Angular velocities, velocities and accelerations of the centres of mass."""
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
    """What the terms of an acceleration are."""
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
