"""A usual value for each symbol, for examples in numbers."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

from freebody.scalars.trig import Trig

_VALUES = {
    "l": (0.5, 0.4, 0.3, 0.2), "lc": (0.2, 0.15, 0.12, 0.1), "m": (3.0, 2.0, 1.5, 1.0),
    "I": (0.08, 0.05, 0.03, 0.02),
    "theta": (0.4, 0.9, -0.6, 0.7), "d": (0.25, 0.35, 0.15, 0.45),
}  # fmt: skip
_RATES, _SECONDS = (1.2, -0.7, 0.9, -1.4), (2.0, 1.5, -1.1, 0.8)


def typical(
    names: Sequence[str], given: Mapping[str, float | None] | None = None
) -> dict[str, float]:
    """A usual value for each symbol; those given stay."""
    return {
        name: typical_value(name, (given or {}).get(name), 0, k) for k, name in enumerate(names)
    }


def occurs(name: str, x: Trig) -> bool:
    """Whether a polynomial has a symbol, or its sine or cosine, in it."""
    index, degrees = x.ring.index, x.poly.degrees()
    return any(n in index and degrees[index[n]] > 0 for n in (name, f"sin_{name}", f"cos_{name}"))


def typical_value(name: str, given: float | None, shift: int, k: int) -> float:
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
