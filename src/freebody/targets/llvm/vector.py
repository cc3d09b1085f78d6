"""Vector functions of doubles written as arithmetic: values with operators that emit LLVM text.

Nothing is contracted or reordered, so that a difference that is exact stays exact; `fma` rounds
once where the CPU has it and twice where it has not, and what is built on it must do with either.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from freebody.targets.llvm.lanes import DOUBLE, Lanes

TO_INTEGER = 6755399441055744.0
"""1.5 * 2**52: after adding it, the low bits are the nearest integer."""


class LaneValue:
    """A vector in a block of LLVM text: of reals ("v"), 64-bit integers ("i") or truth values
    ("mask")."""

    __slots__ = ("block", "kind", "name")

    def __init__(self, block: Block, kind: str, name: str):
        self.block, self.kind, self.name = block, kind, name

    def _with(self, operation: str, other: LaneValue | float, swapped: bool = False) -> LaneValue:
        x, y = self, self.block.lifted(other, self.kind)
        if swapped:
            x, y = y, x
        return self.block.value(
            self.kind, f"{operation} {self.block.types[self.kind]} {x.name}, {y.name}"
        )

    def __add__(self, other: LaneValue | float) -> LaneValue:
        return self._with("fadd" if self.kind == "v" else "add", other)

    def __sub__(self, other: LaneValue | float) -> LaneValue:
        return self._with("fsub" if self.kind == "v" else "sub", other)

    def __rsub__(self, other: float) -> LaneValue:
        return self._with("fsub" if self.kind == "v" else "sub", other, swapped=True)

    def __mul__(self, other: LaneValue | float) -> LaneValue:
        return self._with("fmul", other)

    def __truediv__(self, other: LaneValue | float) -> LaneValue:
        return self._with("fdiv", other)

    def __rtruediv__(self, other: float) -> LaneValue:
        return self._with("fdiv", other, swapped=True)

    __radd__, __rmul__ = __add__, __mul__

    def __neg__(self) -> LaneValue:
        return self.block.value("v", f"fneg {self.block.types['v']} {self.name}")

    def __and__(self, other: LaneValue | int) -> LaneValue:
        return self._with("and", other)

    def __or__(self, other: LaneValue | int) -> LaneValue:
        return self._with("or", other)

    def __xor__(self, other: LaneValue | int) -> LaneValue:
        return self._with("xor", other)

    def __lshift__(self, count: int) -> LaneValue:
        return self._with("shl", count)

    def __rshift__(self, count: int) -> LaneValue:
        """Logical shift right: zeros enter at the top, whatever the sign."""
        return self._with("lshr", count)

    def __lt__(self, other: LaneValue | float) -> LaneValue:
        return self._compared("olt", other)

    def __gt__(self, other: LaneValue | float) -> LaneValue:
        return self._compared("ogt", other)

    def equals(self, other: LaneValue | float) -> LaneValue:
        """Whether two reals are equal; false for NaN."""
        return self._compared("oeq", other)

    def unordered(self, other: LaneValue) -> LaneValue:
        """Whether one of two reals is NaN."""
        return self._compared("uno", other)

    def _compared(self, how: str, other: LaneValue | float) -> LaneValue:
        y = self.block.lifted(other, "v")
        return self.block.value("mask", f"fcmp {how} {self.block.types['v']} {self.name}, {y.name}")

    @property
    def bits(self) -> LaneValue:
        """The integer that has the same 64 bits as a real."""
        types = self.block.types
        return self.block.value("i", f"bitcast {types['v']} {self.name} to {types['i']}")

    @property
    def real(self) -> LaneValue:
        """The real that has the same 64 bits as an integer."""
        types = self.block.types
        return self.block.value("v", f"bitcast {types['i']} {self.name} to {types['v']}")


class Block:
    """Lines of LLVM text of one function."""

    def __init__(self, lanes: Lanes, fma: bool):
        self.lanes, self.fused = lanes, fma
        self.types = {"v": lanes.v, "i": lanes.i, "mask": lanes.mask}
        self.lines: list[str] = []

    def value(self, kind: str, text: str) -> LaneValue:
        """A new value computed by an instruction, which is emitted."""
        name = f"%t{len(self.lines)}"
        self.lines.append(f"  {name} = {text}")
        return LaneValue(self, kind, name)

    def lifted(self, x: LaneValue | float, kind: str) -> LaneValue:
        """A constant as a value in every lane; values unchanged."""
        if isinstance(x, LaneValue):
            return x
        constant = self.lanes.constant(x) if kind == "v" else self.lanes.whole(int(x))
        return LaneValue(self, kind, constant)

    def fma(self, x: LaneValue, y: LaneValue | float, z: LaneValue | float) -> LaneValue:
        """Fused multiply-add x y + z where the machine has it."""
        y, z = self.lifted(y, "v"), self.lifted(z, "v")
        if not self.fused:
            return x * y + z
        v = self.types["v"]
        return self.value(
            "v", f"call {v} @llvm.fma.{self.lanes.suffix}({v} {x.name}, {v} {y.name}, {v} {z.name})"
        )

    def horner(self, coefficients: Sequence[float], z: LaneValue) -> LaneValue:
        """The value of a polynomial in z, highest coefficient first."""
        last = self.lifted(coefficients[0], "v")
        for coefficient in coefficients[1:]:
            last = self.fma(last, z, coefficient)
        return last

    def where(self, condition: LaneValue, x: LaneValue | float, y: LaneValue | float) -> LaneValue:
        """The value x in lanes where the condition holds, else y."""
        x, y = self.lifted(x, "v"), self.lifted(y, "v")
        v, mask = self.types["v"], self.types["mask"]
        return self.value("v", f"select {mask} {condition.name}, {v} {x.name}, {v} {y.name}")

    def absolute(self, x: LaneValue) -> LaneValue:
        """Absolute value of a real."""
        return (x.bits & (2**63 - 1)).real

    def signed(self, size: LaneValue, sign: LaneValue) -> LaneValue:
        """`size`, which is not negative, with the sign of another value."""
        return ((sign.bits & -(2**63)) | size.bits).real

    def sqrt(self, x: LaneValue) -> LaneValue:
        """Square root of a real."""
        v = self.types["v"]
        return self.value("v", f"call {v} @llvm.sqrt.{self.lanes.suffix}({v} {x.name})")

    def power_of_two(self, whole: LaneValue) -> LaneValue:
        """The power 2^k of a real k that is a whole number from -1022 to 1023."""
        return (((whole + TO_INTEGER).bits + 1023) << 52).real


def function(name: str, arity: int, make: Callable[..., LaneValue], lanes: Lanes, fma: bool) -> str:
    """LLVM text of a vector function `name` that `make(block, *values)` computes in doubles."""
    block = Block(replace(lanes, real=DOUBLE), fma)
    given = [LaneValue(block, "v", f"%x{k}") for k in range(arity)]
    if lanes.real is not DOUBLE:
        given = [block.value("v", f"fpext {lanes.v} {x.name} to {block.types['v']}") for x in given]
    result = make(block, *given)
    if lanes.real is not DOUBLE:
        result = block.value("v", f"fptrunc {block.types['v']} {result.name} to {lanes.v}")
    taken = ", ".join(f"{lanes.v} %x{k}" for k in range(arity))
    lines = [f"define internal {lanes.v} {name}({taken}) #2 {{", *block.lines]
    v, n = block.types["v"], block.lanes.suffix
    declared = [f"declare {v} @llvm.sqrt.{n}({v})", f"declare {v} @llvm.fma.{n}({v}, {v}, {v})"]
    return "\n".join([*lines, f"  ret {lanes.v} {result.name}", "}", *declared, ""])
