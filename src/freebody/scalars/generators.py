"""Names of a ring's generators: symbols, sines and cosines of angles, signs of rates. What needs to
know which of them one is asks here, and takes no name apart itself."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from freebody.scalars.trig import Trig

WAVES = ("sin", "cos")
SIGN = "sgn"


def waves_of(angle: str) -> tuple[str, str]:
    """The sine and the cosine of an angle."""
    return f"sin_{angle}", f"cos_{angle}"


def sign_of(rate: str) -> str:
    """Name of the generator that is the sign of a rate."""
    return f"{SIGN}_{rate}"


@lru_cache(maxsize=8192)
def function_of(generator: str) -> str:
    """Function of a generator: sin, cos or sgn; "" of a symbol."""
    function, _, symbol = generator.partition("_")
    return function if symbol and function in (*WAVES, SIGN) else ""


@lru_cache(maxsize=8192)
def symbol_of(generator: str) -> str:
    """The angle whose sine or cosine, or the rate whose sign a generator is; a symbol itself."""
    function = function_of(generator)
    return generator.removeprefix(f"{function}_") if function else generator


def generators_in(*polynomials: Trig) -> set[str]:
    """The generators in polynomials."""
    return {name for x in polynomials for powers, _ in x.terms() for name in powers}


def symbols_in(*polynomials: Trig) -> set[str]:
    """The symbols in polynomials, those in sines, cosines and signs among them."""
    return set(map(symbol_of, generators_in(*polynomials)))
