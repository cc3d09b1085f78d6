"""The inverse position of an arm of two revolute joints in the plane, both branches (2.14,
2.15)."""

from __future__ import annotations

from freebody.expressions import expression as ex
from freebody.expressions.expression import Expression, eq
from freebody.expressions.printed_names import sym
from freebody_textbook.derivation import Step
from freebody_textbook.methods.setting import Setting


def inverse_position(s: Setting) -> list[Step]:
    """One step for the notes' arm with straight links; none for others, which fb.inverse_kinematics
    solves."""
    lengths = _lengths(s)
    if lengths is None:
        return []
    a, b = lengths
    x = sym("x")
    y = sym("y")
    one = sym(s.coordinate(s.order[0]))
    two = sym(s.coordinate(s.order[1]))
    square = ex.add(ex.power(x, 2), ex.power(y, 2))
    over = ex.sub(square, ex.add(ex.power(a, 2), ex.power(b, 2)))
    reach, aside = ex.add(a, ex.mul(b, ex.cos(two))), ex.mul(b, ex.sin(two))
    lines = (
        eq(ex.cos(two), ex.div(over, ex.mul(2, a, b))),
        eq(ex.power(ex.sin(two), 2), ex.sub(1, ex.power(ex.cos(two), 2))),
        eq(ex.mul(square, ex.sin(one)), ex.sub(ex.mul(reach, y), ex.mul(aside, x))),
        eq(ex.mul(square, ex.cos(one)), ex.add(ex.mul(reach, x), ex.mul(aside, y))),
    )
    reason = (
        "The square of the distance to P(x, y) does not depend on the first angle and gives the "
        "cosine of the second. Its sine has two signs, for the elbow on one side or the other; for "
        "each, sine and cosine together determine the quadrant of the first angle (atan2). P can "
        "be reached where the cosine lies between -1 and 1, that is, where its distance from the "
        "base is at least the difference and at most the sum of the lengths."
    )
    return [Step("Inverse position", reason, lines, ("2.14", "2.15"))]


def _lengths(s: Setting) -> tuple[Expression, Expression] | None:
    """l1 and l2 of two straight links on a pivot at the origin."""
    if s.cited != "RR" or s.tip != s.order[1]:
        return None
    first, second = s.order
    at = [
        s.motion.joints[first][1],
        s.motion.joints[second][1],
        s.tip_frame[2],
    ]
    (x0, y0), (a, y1), (b, y2) = ([s.show(x) for x in p] for p in at)
    return (a, b) if all(x == ex.ZERO for x in (x0, y0, y1, y2)) and ex.ZERO not in (a, b) else None
