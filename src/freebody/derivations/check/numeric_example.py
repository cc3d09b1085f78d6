"""Numbers at which an answer and the right one differ."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence

from freebody.derivations.check.right_equations import RightEquations
from freebody.derivations.check.verdict import Example
from freebody.derivations.expressions.printed_names import sym
from freebody.outputs.numbers import shortest
from freebody.scalars.trig import Trig

_VALUES = {
    "l": (0.5, 0.4, 0.3, 0.2), "lc": (0.2, 0.15, 0.12, 0.1), "m": (3.0, 2.0, 1.5, 1.0),
    "I": (0.08, 0.05, 0.03, 0.02),
    "theta": (0.4, 0.9, -0.6, 0.7), "d": (0.25, 0.35, 0.15, 0.45),
}  # fmt: skip
_RATES, _SECONDS = (1.2, -0.7, 0.9, -1.4), (2.0, 1.5, -1.1, 0.8)


def example(setting: RightEquations, yours: Trig, right: Trig) -> Example | None:
    """Values of the symbols that occur, and both results; None where no try tells them apart."""
    used = [name for name in setting.ring.names if occurs(name, yours) or occurs(name, right)]
    given = setting.symbols.model.parameters
    for shift in range(4):
        values = {name: _value(name, given.get(name), shift, k) for k, name in enumerate(used)}
        try:
            a, b = float(yours.evaluate(values)), float(right.evaluate(values))
        except OverflowError:
            return None
        if f"{a:.4g}" != f"{b:.4g}":
            return Example(values, a, b)
    return Example(values, a, b) if used and not math.isclose(a, b, rel_tol=1e-12) else None


def typical(
    names: Sequence[str], given: Mapping[str, float | None] | None = None
) -> dict[str, float]:
    """A usual value for each symbol; those given stay."""
    return {name: _value(name, (given or {}).get(name), 0, k) for k, name in enumerate(names)}


def occurs(name: str, x: Trig) -> bool:
    """Whether a polynomial has a symbol, or its sine or cosine, in it."""
    index, degrees = x.ring.index, x.poly.degrees()
    return any(n in index and degrees[index[n]] > 0 for n in (name, f"sin_{name}", f"cos_{name}"))


def _value(name: str, given: float | None, shift: int, k: int) -> float:
    """The model's value; else one of a usual size."""
    if given is not None:
        return given
    match = re.fullmatch(r"([A-Za-z]+)(\d+)(_d{1,2})?", name)
    number = (int(match[2]) if match else k) - 1 + shift
    if match and match[3]:
        return (_RATES if match[3] == "_d" else _SECONDS)[number % 4]
    if match and match[1] in _VALUES:
        return _VALUES[match[1]][number % 4]
    return 9.81 if name == "g" else round(0.3 + 0.17 * (number % 5), 2)


def sentence(found: Example) -> str:
    """For example, with θ₁ = 0.4, l₁ = 0.5: yours 1.2, right 1.3."""
    at = ", ".join(f"{sym(name)} = {shortest(value)}" for name, value in found.values.items())
    digits = next(
        (d for d in (4, 6, 9, 15) if f"{found.yours:.{d}g}" != f"{found.right:.{d}g}"), 17
    )
    yours, right = (shortest(x, digits) for x in (found.yours, found.right))
    numbers = f"yours is {yours}, the right one {right}"
    return f"For example, at {at}: {numbers}." if at else f"In numbers: {numbers}."
