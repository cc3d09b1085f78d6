"""Exponential function, logarithm and hyperbolic tangent, over the whole range of doubles, each
within 2 ulp.

Overflow gives infinity and underflow a subnormal or 0, as the functions of C do; NaN gives NaN.
"""

from __future__ import annotations

from freebody.targets.llvm.vector import TO_INTEGER, Block, Value

_LN2_HIGH, _LN2_LOW = 6.93147180369123816490e-01, 1.90821492927058770002e-10
"""The first has 21 zero bits at its end: its products with exponents are exact."""

# (exp r - 1 - r) / r² on |r| <= ln 2 / 2, interpolated at Chebyshev's nodes: relative error of exp
# 3e-19
_EXP = (
    2.09147553258932e-09,
    2.5105312729622103e-08,
    2.755727347871858e-07,
    2.755725517000089e-06,
    2.480158732567746e-05,
    0.0001984126987500228,
    0.0013888888888883711,
    0.008333333333326084,
    0.04166666666666667,
    0.1666666666666667,
    0.5,
)
# fdlibm's e_log.c: (log(1 + f) - log(1 - f)) / s - 2 in s², s = f / (2 + f)
_LOG = (
    1.479819860511658591e-01,
    1.531383769920937332e-01,
    1.818357216161805012e-01,
    2.222219843214978396e-01,
    2.857142874366239149e-01,
    3.999999999940941908e-01,
    6.666666666666735130e-01,
)
# Cephes' tanh.c (S. L. Moshier): tanh x = x + x³ P(x²) / Q(x²) for |x| < 0.625
_TANH_P = (-9.64399179425052238628e-1, -9.92877231001918586564e1, -1.61468768441708447952e3)
_TANH_Q = (1.0, 1.12811678491632931402e2, 2.23548839060100448583e3, 4.84406305325125486048e3)


def exp(b: Block, x: Value) -> Value:
    """e^x within 1 ulp: x = k ln 2 + r, e^x = 2^k (1 + r + r² P(r))."""
    x = b.where(x > 720.0, 720.0, b.where(x < -760.0, -760.0, x))
    k = b.fma(x, 1.4426950408889634, TO_INTEGER) - TO_INTEGER
    high = x - k * _LN2_HIGH  # exact
    low = k * _LN2_LOW
    r = high - low
    rest = r * r * b.horner(_EXP, r) - low
    whole = high + 1.0
    mantissa = whole + ((high - (whole - 1.0)) + rest)
    half = (
        b.fma(k, 0.5, TO_INTEGER) - TO_INTEGER
    )  # in two steps, since 2^k may be out of range where e^x is not
    return mantissa * b.power_of_two(half) * b.power_of_two(k - half)


def log(b: Block, x: Value) -> Value:
    """Natural logarithm within 1 ulp, after fdlibm: -infinity of 0, NaN where negative."""
    small = x < 2.2250738585072014e-308
    normal = b.where(small, x * 2.0**54, x)
    # x = 2^k m, m from sqrt(1/2) on
    shifted = normal.bits + (0x3FF0000000000000 - 0x3FE6A09E667F3BCD)
    # the exponent's bits as those of a real: 2^52 + exponent
    k = ((shifted >> 52) | 0x4330000000000000).real - b.where(
        small, 2.0**52 + 1023.0 + 54.0, 2.0**52 + 1023.0
    )
    m = ((shifted & (2**52 - 1)) + 0x3FE6A09E667F3BCD).real
    f = m - 1.0
    half_square = f * f * 0.5
    s = f / (f + 2.0)
    z = s * s
    series = z * b.horner(_LOG, z)
    found = k * _LN2_HIGH - ((half_square - (s * (half_square + series) + k * _LN2_LOW)) - f)
    found = b.where(x.equals(float("inf")), x, found)
    return b.where(x > 0.0, found, b.where(x.equals(0.0), float("-inf"), (x - x) / (x - x)))


def tanh(b: Block, x: Value) -> Value:
    """Hyperbolic tangent within 2 ulp: a quotient of polynomials near 0, 1 - 2 / (e^2|x| + 1)
    beyond 0.625."""
    a = b.absolute(x)
    z = a * a
    near = a < 0.625
    quotient = b.where(near, z * b.horner(_TANH_P, z), 2.0) / b.where(
        near, b.horner(_TANH_Q, z), exp(b, a + a) + 1.0
    )
    return b.signed(b.where(near, a + a * quotient, 1.0 - quotient), x)
