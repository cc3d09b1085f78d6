"""LLVM text of a vector sine and cosine.

Cody-Waite reduction to |r| <= pi/4 by multiples of pi/2, then the minimax polynomials of fdlibm's __kernel_sin and
__kernel_cos: within 2 ulp for |x| <= 1e5. Where the CPU has no fused multiply-add, the reduction subtracts four terms
of 33 bits whose products with the quadrant are exact. Larger arguments are reduced after Payne and Hanek
(product with the bits of 2/pi that matter), lane by lane, behind a branch that is rarely taken: within 4 ulp
for every finite argument, where libm is not. Infinity and NaN give NaN. The sine is computed of |x| and
signed at the end, so that sin(-0.0) is -0.0. Nothing outside the text is called, so the bits are the same on
every system.
"""

from __future__ import annotations

import struct

LARGEST = 1e5
"""Arguments up to here are reduced in vector code."""

_SIN = (
    1.58969099521155010221e-10,
    -2.50507602534068634195e-08,
    2.75573137070700676789e-06,
    -1.98412698298579493134e-04,
    8.33333333332248946124e-03,
    -1.66666666666666324348e-01,
)
_COS = (
    -1.13596475577881948265e-11,
    2.08757232129817482790e-09,
    -2.75573143513906633035e-07,
    2.48015872894767294178e-05,
    -1.38888888888741095749e-03,
    4.16666666666666019037e-02,
)
# pi/2 in three doubles, and in three parts of 33 bits with the rest
_PIO2_FMA = (1.5707963267948966, 6.123233995736766e-17, -1.4973849048591833e-33)
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
_TO_INTEGER = 6755399441055744.0  # 1.5 * 2**52: after adding it, the low bits are the nearest integer


def double(value: float) -> str:
    """A double as LLVM reads it exactly."""
    return f"0x{struct.unpack('<Q', struct.pack('<d', value))[0]:016X}"


def splat(width: int, kind: str, text: object) -> str:
    """A constant vector of equal lanes."""
    return "<" + ", ".join([f"{kind} {text}"] * width) + ">"


def sincos(width: int, fma: bool) -> str:
    """`void @sincos(ptr x, ptr sine, ptr cosine)`, each a vector of `width` doubles, and what it calls."""
    v, i = f"<{width} x double>", f"<{width} x i64>"

    def c(value: float) -> str:
        return splat(width, "double", double(value))

    def n(value: int) -> str:
        return splat(width, "i64", value)

    lines: list[str] = []

    def horner(name: str, coefficients: tuple[float, ...]) -> str:
        """Name of the value of the polynomial in %z."""
        last = c(coefficients[0])
        for k, coefficient in enumerate(coefficients[1:]):
            lines.append(multiply_add(f"%{name}{k}", last, "%z", c(coefficient)))
            last = f"%{name}{k}"
        return last

    def multiply_add(result: str, x: str, y: str, z: str) -> str:
        if fma:
            return f"  {result} = call {v} @llvm.fma.v{width}f64({v} {x}, {v} {y}, {v} {z})"
        return f"  {result}.p = fmul {v} {x}, {y}\n  {result} = fadd {v} {result}.p, {z}"

    lines.append(f"""\
define internal void @sincos(ptr noalias %px, ptr noalias %psin, ptr noalias %pcos) #0 {{
entry:
  %x = load {v}, ptr %px, align {8 * width}
  %x.bits = bitcast {v} %x to {i}
  %sign = and {i} %x.bits, {n(-(2**63))}
  %a.bits = and {i} %x.bits, {n(2**63 - 1)}
  %a = bitcast {i} %a.bits to {v}""")
    lines.append(multiply_add("%shifted", "%a", c(0.6366197723675814), c(_TO_INTEGER)))
    lines.append(f"""\
  %quadrant = bitcast {v} %shifted to {i}
  %k = fsub {v} %shifted, {c(_TO_INTEGER)}
  %minus.k = fneg {v} %k""")
    last = "%a"
    for term, part in enumerate(_PIO2_FMA if fma else _PIO2_SPLIT):
        lines.append(multiply_add(f"%r{term}", "%minus.k", c(part), last))
        last = f"%r{term}"
    r = last
    lines.append(_large_lanes(width, r))
    r = "%r"
    lines.append(f"  %z = fmul {v} {r}, {r}\n  %zr = fmul {v} %z, {r}")
    lines.append(multiply_add("%s", "%zr", horner("ps", _SIN), r))
    # 1 - z/2 + z² P(z), with the rounding error of 1 - z/2 put back
    pc = horner("pc", _COS)
    lines.append(f"""\
  %half = fmul {v} %z, {c(0.5)}
  %w = fsub {v} {c(1.0)}, %half
  %w.lost = fsub {v} {c(1.0)}, %w
  %w.rest = fsub {v} %w.lost, %half
  %zz = fmul {v} %z, %z""")
    lines.append(multiply_add("%c.low", "%zz", pc, "%w.rest"))
    lines.append(f"""\
  %c = fadd {v} %w, %c.low
  %odd = trunc {i} %q to <{width} x i1>
  %s.abs = select <{width} x i1> %odd, {v} %c, {v} %s
  %c.abs = select <{width} x i1> %odd, {v} %s, {v} %c
  %s.turn = shl {i} %q, {n(62)}
  %s.flip0 = and {i} %s.turn, {n(-(2**63))}
  %s.flip = xor {i} %s.flip0, %sign
  %next = add {i} %q, {n(1)}
  %c.turn = shl {i} %next, {n(62)}
  %c.flip = and {i} %c.turn, {n(-(2**63))}
  %s.bits0 = bitcast {v} %s.abs to {i}
  %c.bits0 = bitcast {v} %c.abs to {i}
  %s.bits = xor {i} %s.bits0, %s.flip
  %c.bits = xor {i} %c.bits0, %c.flip
  %sine = bitcast {i} %s.bits to {v}
  %cosine = bitcast {i} %c.bits to {v}
  store {v} %sine, ptr %psin, align {8 * width}
  store {v} %cosine, ptr %pcos, align {8 * width}
  ret void
}}
declare {v} @llvm.fma.v{width}f64({v}, {v}, {v})
""")
    return "\n".join([_REDUCE, *lines])


def _large_lanes(width: int, r: str) -> str:
    """%r and %q: the reduced argument and the quadrant, from the slow way in lanes that need it."""
    v, i, mask = f"<{width} x double>", f"<{width} x i64>", f"<{width} x i1>"
    lines = [
        f"  %large = fcmp ugt {v} %a, {splat(width, 'double', double(LARGEST))}",
        f"  %large.bits = bitcast {mask} %large to i{width}",
        f"  %any = icmp ne i{width} %large.bits, 0",
        "  br i1 %any, label %slow, label %polynomials",
        "slow:",
        f"  %safe = select {mask} %large, {v} %a, {v} {splat(width, 'double', double(2 * LARGEST))}",
    ]
    reduced, quadrants = "poison", "poison"
    for lane in range(width):
        lines += [
            f"  %safe{lane} = extractelement {v} %safe, i64 {lane}",
            f"  %both{lane} = call {{ double, i64 }} @reduce(double %safe{lane})",
            f"  %lane.r{lane} = extractvalue {{ double, i64 }} %both{lane}, 0",
            f"  %lane.q{lane} = extractvalue {{ double, i64 }} %both{lane}, 1",
            f"  %slow.r{lane} = insertelement {v} {reduced}, double %lane.r{lane}, i64 {lane}",
            f"  %slow.q{lane} = insertelement {i} {quadrants}, i64 %lane.q{lane}, i64 {lane}",
        ]
        reduced, quadrants = f"%slow.r{lane}", f"%slow.q{lane}"
    lines += [
        f"  %mixed.r = select {mask} %large, {v} {reduced}, {v} {r}",
        f"  %mixed.q = select {mask} %large, {i} {quadrants}, {i} %quadrant",
        "  br label %polynomials",
        "polynomials:",
        f"  %r = phi {v} [ {r}, %entry ], [ %mixed.r, %slow ]",
        f"  %q = phi {i} [ %quadrant, %entry ], [ %mixed.q, %slow ]",
    ]
    return "\n".join(lines)


# a = m 2^e. Of 2/pi the bits above 2^(2-e) give multiples of 4 quadrants; 192 bits from there times m are a
# 2/pi modulo 4, with 2 bits of quadrant and 190 of fraction. At least 60 of the upper 126 are left in the
# worst case.
_REDUCE = f"""\
@two_over_pi = internal constant [{len(_TWO_OVER_PI) + 1} x i64] [i64 0, {", ".join(f"i64 {w}" for w in _TWO_OVER_PI)}]
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
  %r.abs = fmul double %f.double, {double(_PIO2_FMA[0])}
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
