"""Numbers at which an answer and the right one differ."""

from __future__ import annotations

import math

from freebody.expressions.nodes import Expression, nodes
from freebody.expressions.printed_names import sym
from freebody.outputs.number_text import shortest
from freebody_textbook.check.algebra.answer_tree import Named, Wave
from freebody_textbook.check.algebra.quotients import Value, pair
from freebody_textbook.check.asked.right_equations import RightEquations
from freebody_textbook.check.states.state_values import StateValues
from freebody_textbook.check.verdict import Example
from freebody_textbook.closed_chains.first_kind import MULTIPLIER
from freebody_textbook.relations.formula_values import occurs, typical_value


def example(setting: RightEquations, yours: Value, right: Value) -> Example | None:
    """Values of the symbols that occur, and both results; None where no try tells them apart."""
    pieces = (*pair(yours), *pair(right))
    used = [name for name in setting.ring.names if any(occurs(name, x) for x in pieces)]
    given = setting.symbols.model.parameters
    for shift in range(4):
        values = {
            name: typical_value(name, given.get(name), shift, k) for k, name in enumerate(used)
        }
        try:
            a, b = float(yours.evaluate(values)), float(right.evaluate(values))
        except (OverflowError, ZeroDivisionError):
            return None
        if f"{a:.4g}" != f"{b:.4g}":
            return Example(values, a, b)
    return Example(values, a, b) if used and not math.isclose(a, b, rel_tol=1e-12) else None


def example_at(
    setting: RightEquations,
    states: StateValues,
    k: int,
    tree: Expression,
    right: Value,
) -> Example | None:
    """One of the states, and both results there: the values of the symbols that a tree and the
    right value have; None where one of them is no number."""
    written = [y for x in nodes(tree) if isinstance(x, Named) for y in pair(x.value)]
    waves = {name for x in nodes(tree) if isinstance(x, Wave) for name, _ in x.angle}

    def is_told(name: str) -> bool:
        """Multipliers only where the answer has them."""
        of = written if name.startswith(MULTIPLIER) else [*written, *pair(right)]
        return name in waves or any(occurs(name, piece) for piece in of)

    values = {
        name: float(f"{states.generator(name)[k]:.4g}")
        for name in setting.ring.names
        if is_told(name)
    }
    sides = states.at(tree, {}), states.of(right)
    yours, own = (0.0 if x.vanishes[k] else float(x.value[k]) for x in sides)
    return Example(values, yours, own) if math.isfinite(yours + own) else None


def sentence(found: Example) -> str:
    """For example, with θ₁ = 0.4, l₁ = 0.5: yours 1.2, right 1.3."""
    at = ", ".join(f"{sym(name)} = {shortest(value)}" for name, value in found.values.items())
    digits = next(
        (d for d in (4, 6, 9, 15) if f"{found.yours:.{d}g}" != f"{found.right:.{d}g}"), 17
    )
    yours, right = (shortest(x, digits) for x in (found.yours, found.right))
    numbers = f"yours is {yours}, the right one {right}"
    return f"For example, at {at}: {numbers}." if at else f"In numbers: {numbers}."
