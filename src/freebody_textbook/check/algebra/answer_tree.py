"""Expression trees of answers: the nodes of `nodes`, and two kinds of leaves. Each node knows the
piece of text that it was parsed from."""

from __future__ import annotations

from fractions import Fraction

from freebody.expressions.nodes import Expression
from freebody_textbook.check.algebra.quotients import Value

Angle = tuple[tuple[str, int], ...]
"""A sum of angles: names and whole factors."""


class Named(Expression):
    """A leaf of an expression tree: a name with its value."""

    name: str
    value: Value
    is_derivative: bool = False
    """Whether it is a derivative, named as it is written."""
    is_generator: bool = False
    """Whether the name is the ring's own for the value."""


class Wave(Expression):
    """A leaf of an expression tree: the sin or cos of a sum of angles and a constant."""

    function: str
    angle: Angle
    turn: Fraction = Fraction(0)
