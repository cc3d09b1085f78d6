"""LLVM text of a vector sine and cosine.

Cody-Waite reduction to |r| <= pi/4 by multiples of pi/2, then the minimax polynomials of fdlibm's __kernel_sin and
__kernel_cos; within 2 ulp for |x| <= 1e5. Where the CPU has no fused multiply-add, the reduction subtracts four terms
of 33 bits whose products with the quadrant are exact. Larger arguments, NaN and infinities take libm's `sin` and
`cos`, lane by lane, behind a branch that is rarely taken. The sine is computed of |x| and signed at the end, so that
sin(-0.0) is -0.0.
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
  %odd = trunc {i} %quadrant to <{width} x i1>
  %s.abs = select <{width} x i1> %odd, {v} %c, {v} %s
  %c.abs = select <{width} x i1> %odd, {v} %s, {v} %c
  %s.turn = shl {i} %quadrant, {n(62)}
  %s.flip0 = and {i} %s.turn, {n(-(2**63))}
  %s.flip = xor {i} %s.flip0, %sign
  %next = add {i} %quadrant, {n(1)}
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
  %large = fcmp ugt {v} %a, {c(LARGEST)}
  %large.bits = bitcast <{width} x i1> %large to i{width}
  %any = icmp ne i{width} %large.bits, 0
  br i1 %any, label %lane, label %done
lane:
  %l = phi i64 [ 0, %entry ], [ %l.next, %lane.end ]
  %here = extractelement <{width} x i1> %large, i64 %l
  br i1 %here, label %slow, label %lane.end
slow:
  %px.l = getelementptr double, ptr %px, i64 %l
  %x.l = load double, ptr %px.l, align 8
  %s.l = call double @sin(double %x.l)
  %c.l = call double @cos(double %x.l)
  %psin.l = getelementptr double, ptr %psin, i64 %l
  %pcos.l = getelementptr double, ptr %pcos, i64 %l
  store double %s.l, ptr %psin.l, align 8
  store double %c.l, ptr %pcos.l, align 8
  br label %lane.end
lane.end:
  %l.next = add i64 %l, 1
  %more = icmp ult i64 %l.next, {width}
  br i1 %more, label %lane, label %done
done:
  ret void
}}
declare double @sin(double)
declare double @cos(double)
declare {v} @llvm.fma.v{width}f64({v}, {v}, {v})
""")
    return "\n".join(lines)
