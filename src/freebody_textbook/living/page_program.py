"""A JavaScript function of everything that a page shows: input the symbols of the equations, output
the values of names and lines."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Sequence
from numbers import Real
from typing import Any

import numpy as np

from freebody import elementary
from freebody.arrays import Array
from freebody.expressions.evaluate import Rules, arithmetic, evaluate
from freebody.expressions.expression import Expression, Function, Symbol
from freebody.program import Argument, Program, trace
from freebody.program.passes import drop_dead, share_reciprocals
from freebody.program.program import evaluated, values
from freebody.scalars.expr import Expr, Graph
from freebody.targets.text import LANGUAGES, SourceUnit
from freebody_textbook.relations.formula_values import rank

NAME = "live"
"""The name of the function: y = live(x, y)."""

_FUNCTIONS = {"sin": elementary.sin, "cos": elementary.cos, "sgn": elementary.sign}


def entries(x: Any) -> tuple[Any, ...]:
    """The entries of a vector; a scalar as a single entry."""
    return tuple(x) if rank(x) else (x,)


class PageProgram:
    """A program for a page: each requested value gets places in its output y; at the end it is
    written as JavaScript.

    names: of all symbols. form: of a polynomial, the formula by which it is evaluated.
    """

    def __init__(self, names: Iterable[str], form: Callable[[Any], Expression]):
        self._graph, self._form = Graph(), form
        self.inputs = {name: self._graph.input(name) for name in names}
        self._places: dict[int, int] = {}
        self._operands: dict[Any, Any] = {}  # of polynomials and formulas: most are asked for often
        self._rules: Rules = {
            **arithmetic(lambda number: number.numerator / number.denominator),
            Symbol: lambda node, at: self.inputs[node.name],
            Function: lambda node, at: _FUNCTIONS[node.name](at(node.argument)),
        }

    def places(self, value: Any) -> list[int]:
        """The places in the output y of a value's entries; equal entries share one."""
        indices = [self._graph.operand(self._scalar(x)) for x in entries(value)]
        return [self._places.setdefault(index, len(self._places)) for index in indices]

    def _scalar(self, x: Any) -> Any:
        if isinstance(x, Expr | Real):
            return x
        if x not in self._operands:
            formula = x if isinstance(x, Expression) else self._form(x)
            self._operands[x] = evaluate(formula, self._rules)
        return self._operands[x]

    @property
    def size(self) -> int:
        """Number of outputs in y."""
        return len(self._places)

    def _program(self, results: Iterable[int]) -> Program:
        graph, wanted = self._graph, tuple(results)
        return drop_dead(
            Program(
                NAME,
                (Argument("x", (len(self.inputs),)),),
                (Argument("y", (len(wanted),)),),
                tuple(graph.op), tuple(graph.a), tuple(graph.b), tuple(graph.values), wanted,
                tuple(graph.c),
            )
        )  # fmt: skip

    @property
    def used(self) -> frozenset[str]:
        """Names of the symbols on which the requested values depend."""
        program, names = self._program(self._places), tuple(self.inputs)
        return frozenset(
            names[a] for op, a in zip(program.op, program.a, strict=True) if op == "input"
        )

    def at_random(self, scalars: Sequence[Any], **given: float) -> Array:
        """Values (k, 4) of scalars at four random states, the same at each call, with some names at
        given values."""
        program = self._program(self._graph.operand(self._scalar(x)) for x in scalars)
        states = np.random.default_rng(20191).uniform(0.3, 1.7, (len(self.inputs), 4))
        for name, value in given.items():
            states[list(self.inputs).index(name)] = value
        held = values(program, (tuple(states),))
        return np.array([np.broadcast_to(held[i], 4) for i in program.results]).reshape(-1, 4)

    def source(self, inputs: Sequence[str]) -> str:
        """JavaScript text of the function; its argument x holds the symbols `inputs` in order."""
        whole = self._program(self._places)

        def live(x: Sequence[Any]) -> dict[str, Any]:
            given = dict(zip(inputs, x, strict=True))
            (found,) = evaluated(whole, (tuple(given.get(name, 0.0) for name in self.inputs),))
            return {"y": np.array(found, dtype=object)}

        program = share_reciprocals(trace(NAME, live, (Argument("x", (len(inputs),)),), None))
        return _CONSTANTS.sub(
            _in_one, LANGUAGES["javascript-script"].emit(SourceUnit(program, NAME))
        )


_CONSTANTS = re.compile(r"(?m)(?:^ *const [^\n]*;\n)+")


def _in_one(lines: re.Match[str]) -> str:
    """Several declarations joined to one without blanks, as `const` would be a third of a long
    program."""
    declared = [line.strip().removeprefix("const ")[:-1] for line in lines[0].splitlines()]
    joined = _BLANKS.sub(r"\1", ",\n".join(declared))
    return f"const {joined};\n"


_BLANKS = re.compile(r" ([-+*/=]) (?![-+])")
"""Around an operator, but where it would join another."""
