"""The cross products of the plane that the torques need, by components, and the angles between the
arms in them."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations

from freebody.expressions import expression as ex
from freebody.expressions.expression import Equation, Expression
from freebody.expressions.nodes import Product, Symbol, Words
from freebody.expressions.polynomials.directions import Directed, cosine, directed, sine
from freebody.expressions.printed_names import sym, vec
from freebody.spatial import Vector, dot
from freebody_textbook.derivation import Step
from freebody_textbook.methods.setting import Setting
from freebody_textbook.render.rows import part

FEW = 6
"""Pairs of arms up to which the angle between each two is told."""

Arm = tuple[Expression, Vector]
"""Name and value of a vector along a body."""


def angles_between_arms(s: Setting) -> list[Step]:
    """Products of arms that turn by different angles: sums of products of sines and cosines, which
    are the cosine or sine of the angle between them; none in space, or where there are no such
    arms."""
    arms = _by_angle(s) if s.planar else {}
    pairs = list(combinations(arms.values(), 2))
    if not pairs or len(pairs) > FEW:
        return []
    lines = [line for one, other in pairs for line in _products(s, one, other)]
    reason = (
        "Moments are products of two vectors, each with the angle of its own body. What becomes of "
        "the products of sines and cosines, two arms show: a · b and a × b, by components, are "
        "their lengths times the cosine and the sine of the angle from the one to the other."
    )
    return [Step("Angles between the arms", reason, tuple(lines))]


def _by_angle(s: Setting) -> dict[object, tuple[Expression, Vector, Directed]]:
    """For each angle that arms have the first of these: name, value, and value along the angle."""
    found: dict[object, tuple[Expression, Vector, Directed]] = {}
    for name, value in _arms(s):
        parts = directed(s.layout, [s.symbols.element(x) for x in value])
        if len(parts) == 1 and parts[0].angle and parts[0].across.is_zero:
            found.setdefault(parts[0].angle, (name, value, parts[0]))
    return found


def _arms(s: Setting) -> Iterator[Arm]:
    """Those to the centres of mass, and from joint to joint."""
    for i in s.weighted:
        yield s.centre_name(i), s.centre(i)
    for i in s.order:
        for k in s.tree.children(i):
            yield s.reach_name(i, k), s.to_child(i, k)


def _products(
    s: Setting,
    one: tuple[Expression, Vector, Directed],
    other: tuple[Expression, Vector, Directed],
) -> Iterator[Equation]:
    (a, u, first), (b, v, second) = one, other
    lengths = s.show_moved(first.along), s.show_moved(second.along)
    (moment,) = s.tree.space.moment(u, v)
    (ax, ay), (bx, by) = ([component(s, x, axis) for axis in "xy"] for x in (a, b))
    for product, value, function in (
        (ex.add(ex.mul(ax, bx), ex.mul(ay, by)), dot(u, v), cosine),
        (ex.sub(ex.mul(ax, by), ex.mul(ay, bx)), moment, sine),
    ):
        yield ex.eq(product, ex.mul(*lengths, function(first, second)), s.show_moved(value))


def crossed(s: Setting, arm: Arm, force: Arm) -> Equation:
    """arm × force by components, and what that is with the motion put in."""
    (a, u), (f, v) = arm, force
    mass, rest = _without_mass(f)
    x, y = (component(s, a, axis) for axis in "xy")
    spelt = ex.sub(ex.mul(x, component(s, rest, "y")), ex.mul(y, component(s, rest, "x")))
    (moment,) = s.tree.space.moment(u, v)
    value = s.show_moved(moment)
    sides = (ex.cross(a, f), ex.mul(mass, spelt), *([] if isinstance(value, Words) else [value]))
    return ex.eq(*sides)


def _without_mass(force: Expression) -> tuple[Expression, Expression]:
    """m and v̇ - g of their product."""
    if isinstance(force, Product):
        return ex.mul(*force.factors[:-1]), force.factors[-1]
    return ex.ONE, force


def component(s: Setting, x: Expression, axis: str) -> Expression:
    """The component of an expression of vectors: each vector by the name of its own component,
    gravity by its value."""
    if x == vec("g"):
        return s.show(s.tree.gravity["xy".index(axis)])
    if s.load and x == vec("f"):
        return sym(s.load["xy".index(axis)])
    if isinstance(x, Symbol):
        return part(x, axis) if x.bold else x
    terms = [component(s, term, axis) for term in x.parts]
    if isinstance(x, ex.Sum):
        return ex.add(*terms)
    return ex.neg(*terms) if isinstance(x, ex.Negative) else ex.mul(*terms)
