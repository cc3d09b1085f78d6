"""Rules that simplify arithmetic while nodes are made, one rule a line of each function; the last
line makes the node.

The normal form that they keep:
- a negation is pulled out of products, quotients and odd functions, and vanishes into the next sum,
  so that
  common subexpressions are found across signs; constant factors are positive, `x - y` has the older
  node first;
- the operands of `+` and `*` are ordered, a constant first;
- `-0.0` is `0.0`, and constants are finite.

Folding `0 * x`, `0 / x` and `x - x` to 0 holds for finite values only; compiled kernels return NaN
for every output of a sample with an input that is not finite, whatever was folded away.
"""

from __future__ import annotations

import math

from freebody.scalars.nodes import ONE, ZERO, GraphError, Nodes


def add(g: Nodes, i: int, j: int) -> int:
    if i > j:
        i, j = j, i
    if i == ZERO:
        return j
    op, value = g.op, g.constant_of
    if i in value and j in value:
        return g.number(value[i] + value[j])
    if op[i] == "neg":
        return neg(g, add(g, g.a[i], g.a[j])) if op[j] == "neg" else sub(g, j, g.a[i])
    if op[j] == "neg":
        return sub(g, i, g.a[j])
    return g.node("add", j, i) if j in value else g.node("add", i, j)


def sub(g: Nodes, i: int, j: int) -> int:
    if i == j:
        return ZERO
    if j == ZERO:
        return i
    if i == ZERO:
        return neg(g, j)
    op, value = g.op, g.constant_of
    if j in value:
        return g.number(value[i] - value[j]) if i in value else add(g, i, g.number(-value[j]))
    if op[j] == "neg":
        return add(g, i, g.a[j])
    if op[i] == "neg":
        return neg(g, add(g, g.a[i], j))
    if i > j and i not in value:
        return neg(g, g.node("sub", j, i))
    return g.node("sub", i, j)


def mul(g: Nodes, i: int, j: int) -> int:
    if i > j:
        i, j = j, i
    if i == ZERO:
        return ZERO
    if i == ONE:
        return j
    op, value = g.op, g.constant_of
    if op[i] == "neg":
        return neg(g, mul(g, g.a[i], j))
    if op[j] == "neg":
        return neg(g, mul(g, i, g.a[j]))
    if j in value:
        i, j = j, i
    if i in value:
        c = value[i]
        if j in value:
            return g.number(c * value[j])
        if c < 0.0:
            return neg(g, mul(g, g.number(-c), j))
        if (
            op[j] == "mul" and g.a[j] in value
        ):  # c1 (c2 x) = (c1 c2) x, unless the product over- or underflows
            both = c * value[g.a[j]]
            if 1e-290 < both < 1e290:
                return mul(g, g.number(both), g.b[j])
    return g.node("mul", i, j)


def div(g: Nodes, i: int, j: int) -> int:
    op, value = g.op, g.constant_of
    if j == ONE or (i == ZERO and j != ZERO):
        return i
    if op[i] == "neg":
        return neg(g, div(g, g.a[i], j))
    if op[j] == "neg":
        return neg(g, div(g, i, g.a[j]))
    if j in value:
        c = value[j]
        if c == 0.0:
            raise GraphError("division by the constant 0 in a traced computation.")
        if i in value:
            return g.number(value[i] / c)
        if c < 0.0:
            return neg(g, div(g, i, g.number(-c)))
        if (
            math.frexp(c)[0] == 0.5 and 1e-300 < c < 1e300
        ):  # a power of two: the reciprocal is exact
            return mul(g, i, g.number(1.0 / c))
    elif i in value and value[i] < 0.0:
        return neg(g, div(g, g.number(-value[i]), j))
    return g.node("div", i, j)


def neg(g: Nodes, i: int) -> int:
    if i in g.constant_of:
        return g.number(-g.constant_of[i])
    if g.op[i] == "neg":
        return g.a[i]
    return g.node("neg", i)
