"""Names of a ring's generators: symbols, sines and cosines of angles, signs of rates. All code that
needs to know the kind of a generator asks here."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from freebody.scalars.trig import Trig

WAVES = ("sin", "cos")
SIGN = "sgn"


def waves_of(angle: str) -> tuple[str, str]:
    """The names of the generators for sine and cosine of an angle."""
    return f"sin_{angle}", f"cos_{angle}"


def sign_of(rate: str) -> str:
    """The name of the generator for the sign of a rate."""
    return f"{SIGN}_{rate}"


@lru_cache(maxsize=8192)
def function_of(generator: str) -> str:
    """The function of a generator by its name: sin, cos or sgn; "" for a symbol."""
    function, _, symbol = generator.partition("_")
    return function if symbol and function in (*WAVES, SIGN) else ""


@lru_cache(maxsize=8192)
def symbol_of(generator: str) -> str:
    """The angle or rate inside a generator that is a sine, cosine or sign; a symbol itself."""
    function = function_of(generator)
    return generator.removeprefix(f"{function}_") if function else generator


def generators_in(*polynomials: Trig) -> set[str]:
    """The generators that occur in polynomials."""
    return {name for x in polynomials for powers, _ in x.terms() for name in powers}


def symbols_in(*polynomials: Trig) -> set[str]:
    """The symbols that occur in polynomials, also inside sines, cosines and signs."""
    return set(map(symbol_of, generators_in(*polynomials)))
