"""LLVM text of a vector sine and cosine.

Cody-Waite reduction to |r| <= pi/4 by multiples of pi/2, then the minimax polynomials of fdlibm's
__kernel_sin and __kernel_cos: within 2 ulp for |x| <= 1e5. Where the CPU has no fused multiply-add,
the reduction subtracts four terms of 33 bits whose products with the quadrant are exact. Larger
arguments are reduced after Payne and Hanek (product with the bits of 2/pi that matter), lane by
lane, behind a branch that is rarely taken: within 4 ulp for every finite argument, where libm is
not. Infinity and NaN give NaN. The sine is computed of |x| and signed at the end, so that sin(-0.0)
is -0.0. Nothing outside the text is called, so the bits are the same on every system.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from freebody.program.segments import SinCos
from freebody.targets.llvm.lanes import DOUBLE, FLOAT, Lanes


@dataclass(frozen=True)
class _Series:
    """The polynomials for sine and cosine of a number type: highest coefficients first, in z = r
    r."""

    sine: tuple[float, ...]
    cosine: tuple[float, ...]
    half_pi: tuple[float, ...]
    """pi/2 in parts, for fused multiply-add."""
    to_integer: float
    """Number after whose addition the low bits are the nearest integer."""


_SERIES = {
    DOUBLE: _Series(
        sine=(
            1.58969099521155010221e-10,
            -2.50507602534068634195e-08,
            2.75573137070700676789e-06,
            -1.98412698298579493134e-04,
            8.33333333332248946124e-03,
            -1.66666666666666324348e-01,
        ),
        cosine=(
            -1.13596475577881948265e-11,
            2.08757232129817482790e-09,
            -2.75573143513906633035e-07,
            2.48015872894767294178e-05,
            -1.38888888888741095749e-03,
            4.16666666666666019037e-02,
        ),
        half_pi=(1.5707963267948966, 6.123233995736766e-17, -1.4973849048591833e-33),
        to_integer=1.5 * 2**52,
    ),
    FLOAT: _Series(
        sine=(-1.9515295891e-4, 8.3321608736e-3, -1.6666654611e-1),
        cosine=(2.443315711809948e-5, -1.388731625493765e-3, 4.166664568298827e-2),
        half_pi=(1.5707963705062866, -4.371138828673793e-08, -1.7151245100059665e-15),
        to_integer=1.5 * 2**23,
    ),
}
LARGEST = 1e5
"""Arguments up to here are reduced in vector code."""

# pi/2 in three parts of 33 bits with the rest
_PIO2_SPLIT = (
    1.57079632673412561417e00,
    6.07710050630396597660e-11,
    2.02226624871116645580e-21,
    8.47842766036889956997e-32,
)
_TWO_OVER_PI = (  # 1216 bits of its fraction, 64 a word
    0xA2F9836E4E441529,
    0xFC2757D1F534DDC0,
    0xDB6295993C439041,
    0xFE5163ABDEBBC561,
    0xB7246E3A424DD2E0,
    0x06492EEA09D1921C,
    0xFE1DEB1CB129A73E,
    0xE88235F52EBB4484,
    0xE99C7026B45F7E41,
    0x3991D639835339F4,
    0x9C845F8BBDF9283B,
    0x1FF897FFDE05980F,
    0xEF2F118B5A0A6D1F,
    0x6D367ECF27CB09B7,
    0x4F463F669E5FEA2D,
    0x7527BAC7EBE5F17B,
    0x3D0739F78A5292EA,
    0x6BFB5FB11F8D5D08,
    0x56033046FC7B6BAB,
)


def reduction() -> str:
    """LLVM text of `{ double, i64 } @reduce(double x)`: the remainder of a large x after multiples
    of pi/2, and the quadrant."""
    return _REDUCE


def sincos(lanes: Lanes, fma: bool) -> str:
    """LLVM text of `void @sincos.v8f64(ptr x, ptr sine, ptr cosine)`, each a vector of numbers, for
    arguments of any size."""
    code = VectorCode(lanes, fma)
    v = lanes.v
    arguments = ", ".join(f"ptr noalias %{name}0" for name in ("px", "psin", "pcos"))
    code.lines.append(f"""\
define internal void @sincos.{lanes.suffix}({arguments}) #0 {{
  %x0 = load {v}, ptr %px0, align {lanes.size}""")
    code.reduce(0)
    code.lines.append(_large_lanes(lanes))
    code.polynomials(0, "%r", "%q")
    code.store(0)
    return "\n".join(
        [*code.lines, "  ret void\n}", f"declare {v} @llvm.fma.{lanes.suffix}({v}, {v}, {v})\n"]
    )


def sines(name: str, steps: Sequence[SinCos], lanes: Lanes, fma: bool) -> str:
    """LLVM text of `void name(ptr tile)`: sines and cosines of slots of the tile, none of which is
    another's argument.

    One look at all arguments decides between straight code and a call of `@sincos.…` for each: the
    bits are the same.
    """
    code = VectorCode(lanes, fma)
    v, mask, calls = lanes.v, lanes.mask, []
    code.lines.append(f"define internal void {name}(ptr noalias %tile, ptr %uniform) #1 {{")
    for k, step in enumerate(steps):
        for letter, slot in (("x", step.argument), ("sin", step.sine), ("cos", step.cosine)):
            code.lines.append(f"  %p{letter}{k} = getelementptr {v}, ptr %tile, i64 {slot}")
        code.lines.append(f"  %x{k} = load {v}, ptr %px{k}, align {lanes.size}")
        calls.append(f"  call void @sincos.{lanes.suffix}(ptr %px{k}, ptr %psin{k}, ptr %pcos{k})")
    large = ""
    for k in range(len(steps)):
        code.reduce(k)
        code.lines.append(f"  %large{k} = fcmp ugt {v} %a{k}, {lanes.constant(LARGEST)}")
        if large:
            code.lines.append(f"  %either{k} = or {mask} {large}, %large{k}")
        large = f"%either{k}" if large else f"%large{k}"
    code.lines.append(f"""\
  %bits = bitcast {mask} {large} to i{lanes.width}
  %any = icmp ne i{lanes.width} %bits, 0
  br i1 %any, label %general, label %straight
general:""")
    code.lines += [*calls, "  ret void\nstraight:"]
    for k in range(len(steps)):
        code.polynomials(k, f"%r{k}", f"%quadrant{k}")
        code.store(k)
    code.lines.append("  ret void\n}\n")
    return "\n".join(code.lines)


class VectorCode:
    """Vector code of sines and cosines in the making; names of the values of argument k end in
    k."""

    def __init__(self, lanes: Lanes, fma: bool):
        self.lanes, self.fma = lanes, fma
        self.lines: list[str] = []

    def multiply_add(self, result: str, x: str, y: str, z: str) -> str:
        """Emit x y + z under a given name, fused where the machine can."""
        v = self.lanes.v
        if self.fma:
            text = f"  {result} = call {v} @llvm.fma.{self.lanes.suffix}({v} {x}, {v} {y}, {v} {z})"
        else:
            text = f"  {result}.p = fmul {v} {x}, {y}\n  {result} = fadd {v} {result}.p, {z}"
        self.lines.append(text)
        return result

    def horner(self, name: str, coefficients: tuple[float, ...], z: str) -> str:
        """The name of the polynomial's value at z, highest coefficient first, whose code is
        emitted."""
        last = self.lanes.constant(coefficients[0])
        for k, coefficient in enumerate(coefficients[1:]):
            last = self.multiply_add(f"{name}.{k}", last, z, self.lanes.constant(coefficient))
        return last

    def reduce(self, k: int) -> None:
        """Emit the reduction of %x: its sign, its absolute value %a, the quadrant in the low bits
        of %quadrant, and the remainder %r."""
        v, i, top = self.lanes.v, self.lanes.i, self.lanes.real.bits - 1
        self.lines.append(f"""\
  %x.bits{k} = bitcast {v} %x{k} to {i}
  %sign{k} = and {i} %x.bits{k}, {self.lanes.whole(-(2**top))}
  %a.bits{k} = and {i} %x.bits{k}, {self.lanes.whole(2**top - 1)}
  %a{k} = bitcast {i} %a.bits{k} to {v}""")
        if self.fma or self.lanes.real == DOUBLE:
            self.subtract(f"%a{k}", f"%quadrant{k}", f"%r{k}", k)
            return
        # what is exact in parts of 33 bits would need many of 8
        wide = VectorCode(replace(self.lanes, real=DOUBLE), self.fma)
        wide.lines = self.lines
        self.lines.append(f"  %wide{k} = fpext {v} %a{k} to {wide.lanes.v}")
        wide.subtract(f"%wide{k}", f"%wide.q{k}", f"%wide.r{k}", k)
        self.lines.append(f"  %quadrant{k} = trunc {wide.lanes.i} %wide.q{k} to {i}")
        self.lines.append(f"  %r{k} = fptrunc {wide.lanes.v} %wide.r{k} to {v}")

    def subtract(self, a: str, quadrant: str, rest: str, k: int) -> None:
        """Emit the subtraction of multiples of pi/2 from a: their number in the low bits of
        `quadrant`, and the remainder `rest`."""
        series, constant = _SERIES[self.lanes.real], self.lanes.constant
        v, up = self.lanes.v, constant(series.to_integer)
        self.multiply_add(f"%shifted{k}", a, constant(0.6366197723675814), up)
        self.lines.append(f"""\
  {quadrant} = bitcast {v} %shifted{k} to {self.lanes.i}
  %k{k} = fsub {v} %shifted{k}, {up}
  %minus.k{k} = fneg {v} %k{k}""")
        parts = series.half_pi if self.fma else _PIO2_SPLIT
        last = a
        for term, part in enumerate(parts, 1):
            name = rest if term == len(parts) else f"{rest}.{term}"
            last = self.multiply_add(name, f"%minus.k{k}", constant(part), last)

    def polynomials(self, k: int, r: str, q: str) -> None:
        """Emit %sine and %cosine of r, turned by q quadrants."""
        v, i, series = self.lanes.v, self.lanes.i, _SERIES[self.lanes.real]
        top = self.lanes.real.bits - 1
        self.lines.append(f"  %z{k} = fmul {v} {r}, {r}\n  %zr{k} = fmul {v} %z{k}, {r}")
        self.multiply_add(f"%s{k}", f"%zr{k}", self.horner(f"%ps{k}", series.sine, f"%z{k}"), r)
        cosine = self.horner(f"%pc{k}", (*series.cosine, -0.5, 1.0), f"%z{k}")
        self.lines.append(f"""\
  %odd{k} = trunc {i} {q} to {self.lanes.mask}
  %s.abs{k} = select {self.lanes.mask} %odd{k}, {v} {cosine}, {v} %s{k}
  %c.abs{k} = select {self.lanes.mask} %odd{k}, {v} %s{k}, {v} {cosine}
  %s.turn{k} = shl {i} {q}, {self.lanes.whole(top - 1)}
  %s.flip0{k} = and {i} %s.turn{k}, {self.lanes.whole(-(2**top))}
  %s.flip{k} = xor {i} %s.flip0{k}, %sign{k}
  %next{k} = add {i} {q}, {self.lanes.whole(1)}
  %c.turn{k} = shl {i} %next{k}, {self.lanes.whole(top - 1)}
  %c.flip{k} = and {i} %c.turn{k}, {self.lanes.whole(-(2**top))}
  %s.bits0{k} = bitcast {v} %s.abs{k} to {i}
  %c.bits0{k} = bitcast {v} %c.abs{k} to {i}
  %s.bits{k} = xor {i} %s.bits0{k}, %s.flip{k}
  %c.bits{k} = xor {i} %c.bits0{k}, %c.flip{k}
  %sine{k} = bitcast {i} %s.bits{k} to {v}
  %cosine{k} = bitcast {i} %c.bits{k} to {v}""")

    def store(self, k: int) -> None:
        """Emit the stores of %sine and %cosine to where %psin and %pcos point."""
        v, size = self.lanes.v, self.lanes.size
        self.lines.append(f"""\
  store {v} %sine{k}, ptr %psin{k}, align {size}
  store {v} %cosine{k}, ptr %pcos{k}, align {size}""")


def _large_lanes(lanes: Lanes) -> str:
    """LLVM lines for %r and %q, the reduced argument and the quadrant, computed by the slow method
    in lanes that need it."""
    v, i, mask, kind = lanes.v, lanes.i, lanes.mask, lanes.real.name
    lines = [
        f"  %large = fcmp ugt {v} %a0, {lanes.constant(LARGEST)}",
        f"  %safe = select {mask} %large, {v} %a0, {v} {lanes.constant(2 * LARGEST)}",
    ]
    reduced, quadrants = "poison", "poison"
    for lane in range(lanes.width):
        x, r, q = f"%safe{lane}", f"%lane.r{lane}", f"%lane.q{lane}"
        lines.append(f"  {x} = extractelement {v} %safe, i64 {lane}")
        if lanes.real != DOUBLE:
            lines.append(f"  {x}.wide = fpext {kind} {x} to double")
            x = f"{x}.wide"
        lines += [
            f"  %both{lane} = call {{ double, i64 }} @reduce(double {x})",
            f"  {r} = extractvalue {{ double, i64 }} %both{lane}, 0",
            f"  {q} = extractvalue {{ double, i64 }} %both{lane}, 1",
        ]
        if lanes.real != DOUBLE:
            lines.append(f"  {r}.short = fptrunc double {r} to {kind}")
            lines.append(f"  {q}.short = trunc i64 {q} to {lanes.real.integer}")
            r, q = f"{r}.short", f"{q}.short"
        lines += [
            f"  %slow.r{lane} = insertelement {v} {reduced}, {kind} {r}, i64 {lane}",
            f"  %slow.q{lane} = insertelement {i} {quadrants}, {lanes.real.integer} {q}, i64 "
            f"{lane}",
        ]
        reduced, quadrants = f"%slow.r{lane}", f"%slow.q{lane}"
    lines += [
        f"  %r = select {mask} %large, {v} {reduced}, {v} %r0",
        f"  %q = select {mask} %large, {i} {quadrants}, {i} %quadrant0",
    ]
    return "\n".join(lines)


# a = m 2^e. Of 2/pi the bits above 2^(2-e) give multiples of 4 quadrants; 192 bits from there times
# m are a 2/pi modulo 4, with 2 bits of quadrant and 190 of fraction. At least 60 of the upper 126
# are left in the worst case.
_WORDS = ", ".join(f"i64 {word}" for word in (0, *_TWO_OVER_PI))
_REDUCE = f"""\
@two_over_pi = internal constant [{len(_TWO_OVER_PI) + 1} x i64] [{_WORDS}]
define internal {{ double, i64 }} @reduce(double %a) #0 {{
  %bits = bitcast double %a to i64
  %exponent = lshr i64 %bits, 52
  %fraction = and i64 %bits, {2**52 - 1}
  %m = or i64 %fraction, {2**52}
  %position = sub i64 %exponent, {1075 + 2 - 64}
  %word = lshr i64 %position, 6
  %shift = and i64 %position, 63
  %p0 = getelementptr i64, ptr @two_over_pi, i64 %word
  %p1 = getelementptr i64, ptr %p0, i64 1
  %p2 = getelementptr i64, ptr %p0, i64 2
  %p3 = getelementptr i64, ptr %p0, i64 3
  %t0 = load i64, ptr %p0, align 8
  %t1 = load i64, ptr %p1, align 8
  %t2 = load i64, ptr %p2, align 8
  %t3 = load i64, ptr %p3, align 8
  %w0 = call i64 @llvm.fshl.i64(i64 %t0, i64 %t1, i64 %shift)
  %w1 = call i64 @llvm.fshl.i64(i64 %t1, i64 %t2, i64 %shift)
  %w2 = call i64 @llvm.fshl.i64(i64 %t2, i64 %t3, i64 %shift)
  %wide.m = zext i64 %m to i128
  %wide.w1 = zext i64 %w1 to i128
  %wide.w2 = zext i64 %w2 to i128
  %low = mul i128 %wide.m, %wide.w2
  %low.carry = lshr i128 %low, 64
  %middle0 = mul i128 %wide.m, %wide.w1
  %middle = add i128 %middle0, %low.carry
  %middle.carry = lshr i128 %middle, 64
  %carry = trunc i128 %middle.carry to i64
  %high0 = mul i64 %m, %w0
  %high = add i64 %high0, %carry
  %rounded = add i64 %high, {2**61}
  %quadrant = lshr i64 %rounded, 62
  %whole = shl i64 %quadrant, 62
  %rest = sub i64 %high, %whole
  %wide.rest = sext i64 %rest to i128
  %upper = shl i128 %wide.rest, 64
  %lower = and i128 %middle, {2**64 - 1}
  %f = or i128 %upper, %lower
  %negative = icmp slt i128 %f, 0
  %minus.f = sub i128 0, %f
  %f.abs = select i1 %negative, i128 %minus.f, i128 %f
  %zeros = call i128 @llvm.ctlz.i128(i128 %f.abs, i1 false)
  %normal = shl i128 %f.abs, %zeros
  %top = lshr i128 %normal, 65
  %digits = trunc i128 %top to i64
  %mantissa = sitofp i64 %digits to double
  %zeros64 = trunc i128 %zeros to i64
  %scale.exponent = sub i64 {1023 - 61}, %zeros64
  %scale.bits = shl i64 %scale.exponent, 52
  %scale = bitcast i64 %scale.bits to double
  %f.double = fmul double %mantissa, %scale
  %r.abs = fmul double %f.double, {DOUBLE.constant(_SERIES[DOUBLE].half_pi[0])}
  %r.minus = fneg double %r.abs
  %r.signed = select i1 %negative, double %r.minus, double %r.abs
  %nothing = fsub double %a, %a
  %r = fadd double %r.signed, %nothing
  %result0 = insertvalue {{ double, i64 }} poison, double %r, 0
  %result = insertvalue {{ double, i64 }} %result0, i64 %quadrant, 1
  ret {{ double, i64 }} %result
}}
declare i64 @llvm.fshl.i64(i64, i64, i64)
declare i128 @llvm.ctlz.i128(i128, i1)
"""
