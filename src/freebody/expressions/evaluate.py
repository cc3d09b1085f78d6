"""The value of an expression over any scalars: one walk, and a table of rules for each kind of
scalar."""

from __future__ import annotations

import operator
from collections.abc import Callable, Iterable, Mapping
from functools import reduce
from typing import Any

from freebody.errors import FreebodyError
from freebody.expressions.nodes import (
    Expression,
    Negative,
    Number,
    Power,
    Product,
    Quotient,
    Sourced,
    Sum,
)

Rule = Callable[[Any, Callable[[Expression], Any]], Any]
"""The value of a node, given the node and a function that gives the values of its parts."""

Rules = Mapping[type, Rule]


class NoValue(FreebodyError, ValueError):
    """A piece of an expression that has no value: `node`, the innermost one."""

    def __init__(self, problem: str, node: Expression | None = None):
        self.problem, self.node = problem, node
        super().__init__(problem)


def evaluate(node: Expression, rules: Rules, known: Mapping[Expression, Any] | None = None) -> Any:
    """The value of an expression, by the rules for the types of its nodes; `known`: values of nodes
    that are not computed again. Raises NoValue."""

    def at(part: Expression) -> Any:
        if known is not None and (found := known.get(part)) is not None:
            return found
        rule = rules.get(type(part))
        if rule is None:
            raise NoValue(f"{part} is for print only.", part)
        try:
            return rule(part, at)
        except NoValue as problem:
            problem.node = problem.node or part
            raise

    return at(node)


def _total(terms: Iterable[Any]) -> Any:
    return reduce(operator.add, terms)


def _product(factors: Iterable[Any]) -> Any:
    return reduce(operator.mul, factors)


def arithmetic(
    number: Callable[[Any], Any],
    total: Callable[[Iterable[Any]], Any] = _total,
    product: Callable[[Iterable[Any]], Any] = _product,
    negative: Callable[[Any], Any] = operator.neg,
    quotient: Callable[[Any, Any], Any] = operator.truediv,
    power: Callable[[Any, int], Any] = operator.pow,
) -> dict[type, Rule]:
    """The rules of arithmetic: `number` makes a scalar of a fraction, the others work with scalars,
    by default by their own operators."""
    return {
        Number: lambda node, at: number(node.value),
        Sum: lambda node, at: total(map(at, node.terms)),
        Product: lambda node, at: product(map(at, node.factors)),
        Negative: lambda node, at: negative(at(node.operand)),
        Sourced: lambda node, at: at(node.operand),
        Quotient: lambda node, at: quotient(at(node.above), at(node.below)),
        Power: lambda node, at: power(at(node.base), node.exponent),
    }
