"""Joints that follow others, q_k = ratio · q_j + offset: one coordinate and one motor move them
all. The motor's row of the equations is that of its own joint plus each follower's times its
ratio."""

from __future__ import annotations

from collections.abc import Mapping

from freebody.elementary import Scalar
from freebody.errors import listed
from freebody.expressions import expression as ex
from freebody.expressions.expression import eq
from freebody.expressions.nodes import Words
from freebody_textbook.derivation import Step
from freebody_textbook.methods.setting import Setting
from freebody_textbook.methods.step_reasons import drive


def coupled(s: Setting) -> list[int]:
    """The bodies whose joints others follow."""
    return [i for i in s.leaders if not s.is_alone(i)]


def shared_motors(
    s: Setting, drives: Mapping[int, Scalar], values: Mapping[int, Scalar] | None = None
) -> list[Step]:
    """A step for each group of joints that move together; drives: what friction and the like take;
    values: of the motors, where they are told."""
    return [_shared(s, i, drives[i], values) for i in coupled(s)]


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
    """What part of the rate of body i's joint those that follow it have, without a full stop."""
    others = s.together(i)[1:]
    factors = listed([f"{s.ratio(k):.15g}" for k in others])
    have = "has" if len(others) == 1 else "have"
    times = "" if factors == "1" else f"{factors} times "
    numbers = listed([str(s.numbers[k]) for k in others])
    return f"Joint{'s' * (len(others) > 1)} {numbers} {have} {times}{what} of joint {s.numbers[i]}"


def joints(s: Setting, i: int) -> str:
    """joints 1 and 2: that of body i, and those that follow it."""
    return f"joints {listed(map(str, sorted(s.numbers[k] for k in s.together(i))))}"
