"""A number type and a vector of it, as LLVM writes them."""

from __future__ import annotations

import struct
from dataclasses import dataclass
from typing import Any


def loaded(
    name: str, kind: str, base: str, index: str | int, *, of: str = "", align: int = 8
) -> str:
    """Lines that load an entry of a table; of: the type in which entries are counted, if
    another."""
    at = f"  {name}.p = getelementptr {of or kind}, ptr {base}, i64 {index}"
    return f"{at}\n  {name} = load {kind}, ptr {name}.p, align {align}"


def stored(
    at: str, kind: str, value: str, base: str, index: str | int, *, of: str = "", align: int = 8
) -> str:
    """Lines that store an entry of a table, whose address is named `at`; of: the type in which
    entries are counted, if another."""
    place = f"  {at} = getelementptr {of or kind}, ptr {base}, i64 {index}"
    return f"{place}\n  store {kind} {value}, ptr {at}, align {align}"


@dataclass(frozen=True)
class Real:
    """A floating-point type: its name in LLVM and NumPy, its number and code in NumPy's C
    interface, and its number of binary digits."""

    name: str
    dtype: str
    bits: int
    digits: int
    number: int
    code: str

    @property
    def size(self) -> int:
        """Number of bytes of the type."""
        return self.bits // 8

    @property
    def epsilon(self) -> float:
        """The distance from 1 to the next larger number."""
        return 2.0 ** (1 - self.digits)

    @property
    def integer(self) -> str:
        """LLVM's integer type with as many bits as the number type."""
        return f"i{self.bits}"

    def constant(self, value: float) -> str:
        """A number in LLVM's exact notation: the bits of a double of the same value, for any
        type."""
        nearest = struct.unpack(self.code, struct.pack(self.code, value))[0]
        return f"0x{struct.unpack('<Q', struct.pack('<d', nearest))[0]:016X}"


DOUBLE = Real("double", "float64", 64, 53, 12, "<d")
FLOAT = Real("float", "float32", 32, 24, 11, "<f")
REALS = {real.dtype: real for real in (DOUBLE, FLOAT)}
"""Number types by NumPy's name."""


@dataclass(frozen=True)
class Lanes:
    """A vector of `width` numbers, one for each of `width` samples."""

    real: Real
    width: int

    @property
    def v(self) -> str:
        """LLVM's type of the vector of numbers."""
        return f"<{self.width} x {self.real.name}>"

    @property
    def i(self) -> str:
        """LLVM's type of a vector of integers of as many bits."""
        return f"<{self.width} x {self.real.integer}>"

    @property
    def mask(self) -> str:
        """LLVM's type of a vector of truth values."""
        return f"<{self.width} x i1>"

    @property
    def suffix(self) -> str:
        """The suffix of LLVM's own functions for this vector type."""
        return f"v{self.width}f{self.real.bits}"

    @property
    def size(self) -> int:
        """Number of bytes of the vector, which is also its alignment."""
        return self.real.size * self.width

    def constant(self, value: float) -> str:
        """A vector of equal numbers."""
        return self._equal(self.real.name, self.real.constant(value))

    def whole(self, value: int) -> str:
        """A vector of equal integers."""
        return self._equal(self.real.integer, value)

    def _equal(self, kind: str, text: Any) -> str:
        return "<" + ", ".join([f"{kind} {text}"] * self.width) + ">"


@dataclass(frozen=True)
class OneLane(Lanes):
    """A single number in place of a vector, for code of machines whose threads are the lanes."""

    width: int = 1

    @property
    def v(self) -> str:
        """LLVM's type of the number."""
        return self.real.name

    @property
    def i(self) -> str:
        """LLVM's type of an integer of as many bits."""
        return self.real.integer

    @property
    def mask(self) -> str:
        """LLVM's type of a truth value."""
        return "i1"

    @property
    def suffix(self) -> str:
        """The suffix of LLVM's own functions for this number type."""
        return f"f{self.real.bits}"

    def _equal(self, kind: str, text: Any) -> str:
        return str(text)
