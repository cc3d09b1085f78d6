"""The squares of the speeds of the centres of mass, which the kinetic energies need."""

from __future__ import annotations

from itertools import combinations

from freebody.expressions import expression as ex
from freebody.expressions.expression import Expression
from freebody.expressions.nodes import Symbol, Words
from freebody.expressions.polynomials.directions import cosine, directed, sine
from freebody.spatial import dot
from freebody_textbook.derivation import Step
from freebody_textbook.methods.setting import Setting
from freebody_textbook.render.rows import part

PAIRS = 3
"""Pairs of parts of a velocity up to which their products are written down."""


def speed_squared(s: Setting, i: int) -> Expression | None:
    """v_c² of body i; none where it is too long to read, or 0."""
    v = s.centre_velocity(i)
    value = s.show_moved(dot(v, v))
    return None if value == ex.ZERO or isinstance(value, Words) else value


def squared_speeds(s: Setting) -> list[Step]:
    """v_ci² of each body: its components squared and added up, then shortened; none where they are
    too long to read, or nothing moves."""
    lines, mixed = [], False
    for i in s.weighted if s.planar or not s.tree.loops else ():
        value = speed_squared(s, i)
        if value is None:
            continue
        spelt = _spelt(s, i) if s.planar else None
        mixed |= spelt is not None
        lines.append(ex.eq(_square(s, i), *([] if spelt is None else [spelt]), value))
    if not lines:
        return []
    reason = "The squares of the components added up"
    if s.planar and any(map(s.turns, s.order)):
        reason += "; by sin² + cos² = 1 a part's own angle drops out of its square"
    reason += "."
    if mixed:
        reason += (
            " Of two parts that turn by different angles two products of sines and cosines are "
            "left, which add up to the cosine or the sine of the difference of the angles. Such a "
            "line has first these products, then their sum."
        )
    return [Step("Squares of the velocities", reason, tuple(lines))]


def _square(s: Setting, i: int) -> Expression:
    """v² of body i's centre of mass, in the plane by the components."""
    name = s.name("vc", i)
    if not s.planar or not isinstance(name, Symbol):
        return ex.power(name, 2)
    return ex.add(*(ex.power(part(name, axis), 2) for axis in "xy"))


def _spelt(s: Setting, i: int) -> Expression | None:
    """The square of a sum of parts, products of sines and cosines left as they come; none where
    there are no such products, or too many to read."""
    parts = directed(s.layout, [s.symbols.element(x) for x in s.centre_velocity(i)])
    pairs = list(combinations(parts, 2))
    if len(pairs) > PAIRS or not any(one.angle and other.angle for one, other in pairs):
        return None
    terms = [s.show_moved(part.square) for part in parts]
    for one, other in pairs:
        for own, theirs, sign, function in (
            (one.along, other.along, 1, cosine),
            (one.across, other.across, 1, cosine),
            (one.across, other.along, 1, sine),
            (one.along, other.across, -1, sine),
        ):
            if not (own.is_zero or theirs.is_zero):
                speeds = s.show_moved(own), s.show_moved(theirs)
                terms.append(ex.mul(2 * sign, *speeds, function(one, other)))
    return ex.add(*terms)
