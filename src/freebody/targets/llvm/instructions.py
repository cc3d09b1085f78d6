"""The LLVM instruction of each operation over a vector of lanes, and functions for operations that
take many: exponential, logarithm, hyperbolic tangent, arc tangent of a quotient, arc sine and arc
cosine.

Each of these is within 2 ulp over the whole range of doubles. Overflow gives infinity and underflow
a subnormal or 0, quadrants and signed zeros are right, as those of C's functions are; NaN gives
NaN. The polynomials of the arcs are those of fdlibm. Sine and cosine stand between segments, see
`sincos`.
"""

from __future__ import annotations

from typing import Any

from freebody.program.program import Program
from freebody.scalars.operations import OPERATIONS
from freebody.targets.llvm.lanes import Lanes
from freebody.targets.llvm.vector import TO_INTEGER, Block, LaneValue, function

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


def _exp(b: Block, x: LaneValue) -> LaneValue:
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


def _log(b: Block, x: LaneValue) -> LaneValue:
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


def _tanh(b: Block, x: LaneValue) -> LaneValue:
    """Hyperbolic tangent within 2 ulp: a quotient of polynomials near 0, 1 - 2 / (e^(2|x|) + 1)
    beyond 0.625."""
    a = b.absolute(x)
    z = a * a
    near = a < 0.625
    quotient = b.where(near, z * b.horner(_TANH_P, z), 2.0) / b.where(
        near, b.horner(_TANH_Q, z), _exp(b, a + a) + 1.0
    )
    return b.signed(b.where(near, a + a * quotient, 1.0 - quotient), x)


_PI = (3.141592653589793, 1.2246467991473532e-16)
_HALF_PI = (1.5707963267948966, 6.123233995736766e-17)
_QUARTER_PI = (0.7853981633974483, 3.061616997868383e-17)
_ATAN_HALF = (0.4636476090008061, 2.2698777452961687e-17)
"""Constants and what they lack."""

# s_atan.c: (atan t - t) / t³ in t² for |t| <= 7/16
_ATAN = (
    -1.62858201153657823623e-02,
    3.65315727442169155270e-02,
    -4.97687799461593236017e-02,
    5.83357013379057348645e-02,
    -6.66107313738753120669e-02,
    7.69187620504482999495e-02,
    -9.09088713343650656196e-02,
    1.11111104054623557880e-01,
    -1.42857142725034663711e-01,
    1.99999999998764832476e-01,
    -3.33333333333329318027e-01,
)
# e_asin.c: (asin x - x) / x in x² for |x| <= 1/2
_ASIN_P = (
    3.47933107596021167570e-05,
    7.91534994289814532176e-04,
    -4.00555345006794114027e-02,
    2.01212532134862925881e-01,
    -3.25565818622400915405e-01,
    1.66666666666666657415e-01,
)
_ASIN_Q = (
    7.70381505559019352791e-02,
    -6.88283971605453293030e-01,
    2.02094576023350569471e00,
    -2.40339491173441421878e00,
    1.0,
)


def _atan2(b: Block, y: LaneValue, x: LaneValue) -> LaneValue:
    """The angle of the point (x, y): the arc tangent of the smaller coordinate over the larger,
    mirrored into its octant."""
    infinity = float("inf")
    across, along = b.absolute(y), b.absolute(x)
    steep = across > along
    n, d = b.where(steep, along, across), b.where(steep, across, along)
    # neither 0/0 nor infinity/infinity, nor an overflow of 2 d + n
    n = b.where(d.equals(infinity), b.where(n.equals(infinity), 1.0, 0.0), n)
    d = b.where(d.equals(infinity), 1.0, b.where(d.equals(0.0), 1.0, d))
    large = d > 2.0**1000
    n, d = b.where(large, n * 2.0**-100, n), b.where(large, d * 2.0**-100, d)
    # atan(n / d) = base + atan t
    beyond_first, beyond_second = n > d * 0.4375, n > d * 0.6875
    top = b.where(beyond_second, n - d, b.where(beyond_first, n + n - d, n))
    bottom = b.where(beyond_second, n + d, b.where(beyond_first, d + d + n, d))
    t = top / bottom
    base = _pair(b, beyond_second, _QUARTER_PI, _pair(b, beyond_first, _ATAN_HALF, (0.0, 0.0)))
    z = t * t
    angle = t + t * z * b.horner(_ATAN, z)
    # an angle of the first octant is added to 0 or pi/2, or taken from pi/2 or pi
    behind = b.signed(b.lifted(1.0, "v"), x) < 0.0
    turn = _pair(b, steep, _HALF_PI, _pair(b, behind, _PI, (0.0, 0.0)))
    way = b.where(steep, b.where(behind, 1.0, -1.0), b.where(behind, -1.0, 1.0))
    turned, rest = _sum(turn[0], way * base[0])
    whole = turned + (way * angle + (rest + (turn[1] + way * base[1])))
    return b.signed(b.where(x.unordered(y), x + y, whole), y)


def _asin(b: Block, x: LaneValue) -> LaneValue:
    """Arc sine; NaN beyond 1 and -1."""
    near, high, low = _arc(b, b.absolute(x))
    constant = _pair(b, near, (0.0, 0.0), _HALF_PI)
    return b.signed(_turned(constant, b.where(near, 1.0, -1.0), high, low), x)


def _acos(b: Block, x: LaneValue) -> LaneValue:
    """Arc cosine; NaN beyond 1 and -1."""
    near, high, low = _arc(b, b.absolute(x))
    right = x > 0.0
    constant = _pair(b, near, _HALF_PI, _pair(b, right, (0.0, 0.0), _PI))
    sign = b.signed(b.lifted(1.0, "v"), x)
    return _turned(constant, b.where(near, -sign, sign), high, low)


def _arc(b: Block, a: LaneValue) -> tuple[LaneValue, LaneValue, LaneValue]:
    """(whether a < 1/2, high, low) for a = |x|: the sum high + low is asin a there, and acos a = 2
    asin sqrt((1 - a) / 2) otherwise."""
    near = a < 0.5
    z = b.where(near, a * a, (1.0 - a) * 0.5)
    root = b.sqrt(z)
    ratio = z * b.horner(_ASIN_P, z) / b.horner(_ASIN_Q, z)
    first = (root.bits & -(2**32)).real  # its square is exact
    missing = (z - first * first) / (root + first + 1e-300)  # 0 where a is 1
    beyond = missing + root * ratio
    return near, b.where(near, a, first + first), b.where(near, a * ratio, beyond + beyond)


def _turned(
    constant: tuple[LaneValue, LaneValue], sign: LaneValue, high: LaneValue, low: LaneValue
) -> LaneValue:
    """The value constant + sign (high + low), rounded once."""
    total, rest = _sum(constant[0], sign * high)
    return total + (rest + (sign * low + constant[1]))


def _sum(x: LaneValue, y: LaneValue) -> tuple[LaneValue, LaneValue]:
    """The sum x + y and its rounding error, where x is the larger or 0."""
    total = x + y
    return total, (x - total) + y


def _pair(b: Block, condition: LaneValue, x: Any, y: Any) -> tuple[LaneValue, LaneValue]:
    """A choice between two numbers that each consist of two parts."""
    return b.where(condition, x[0], y[0]), b.where(condition, x[1], y[1])


FUNCTIONS = {
    "exp": _exp,
    "log": _log,
    "tanh": _tanh,
    "atan2": _atan2,
    "asin": _asin,
    "acos": _acos,
}
"""Operations of many instructions: each is a function of the module where a program has it."""


COMPARISONS = ("less", "less_equal", "equal")
CHOICE = "where by a comparison"
"""The choice by a comparison that stands in the same function: its truth values, `.c`, choose
themselves."""

_FLAG = (
    "{r}.c = fcmp ORDER {v} {a}, {b}\n  {r} = select {mask} {r}.c, {v} {one}, {v} zeroinitializer"
)

# the machine's own minimum and maximum give their second operand where one is NaN
_EXTREMUM = (
    "{r}.c = fcmp ORDER {v} {b}, {a}\n"
    "  {r}.m = select {mask} {r}.c, {v} {b}, {v} {a}\n"
    "  {r}.n = fcmp uno {v} {b}, zeroinitializer\n"
    "  {r} = select {mask} {r}.n, {v} {b}, {v} {r}.m"
)


def _call(name: str) -> str:
    operands = ", ".join(f"{{v}} {{{x}}}" for x in "ab"[: OPERATIONS[name].arity])
    return f"{{r}} = call {{v}} @vector.{name}.{{n}}({operands})"


INSTRUCTION = {
    "add": "{r} = fadd contract {v} {a}, {b}",
    "sub": "{r} = fsub contract {v} {a}, {b}",
    "mul": "{r} = fmul contract {v} {a}, {b}",
    "div": "{r} = fdiv {v} {a}, {b}",
    "neg": "{r} = fneg contract {v} {a}",
    "sqrt": "{r} = call {v} @llvm.sqrt.{n}({v} {a})",
    "sign": (
        "{r}.u = call {v} @llvm.copysign.{n}({v} {one}, {v} {a})\n"
        "  {r}.c = fcmp one {v} {a}, zeroinitializer\n"
        "  {r}.z = fadd {v} {a}, zeroinitializer\n"
        "  {r} = select {mask} {r}.c, {v} {r}.u, {v} {r}.z"
    ),
    "absolute": "{r} = call {v} @llvm.fabs.{n}({v} {a})",
    "less": _FLAG.replace("ORDER", "olt"),
    "less_equal": _FLAG.replace("ORDER", "ole"),
    "equal": _FLAG.replace("ORDER", "oeq"),
    "where": "{r}.c = fcmp une {v} {a}, zeroinitializer\n  {r} = select {mask} {r}.c, {v} {b}, "
    "{v} {c}",
    "minimum": _EXTREMUM.replace("ORDER", "olt"),
    "maximum": _EXTREMUM.replace("ORDER", "ogt"),
    "epsilon": "{r} = fadd {v} {epsilon}, zeroinitializer",
    CHOICE: "{r} = select {mask} {a}.c, {v} {b}, {v} {c}",
} | {name: _call(name) for name in FUNCTIONS}
"""Instructions by operation. Only contraction to fused multiply-add is allowed: other fast-math
flags break range reduction and NaN."""


def instructions(lanes: Lanes) -> dict[str, str]:
    """The instruction of each operation for vectors of a kind, as a template of {0}, the result's
    name, and {1}, … the operands'."""
    words = {"v": lanes.v, "n": lanes.suffix, "mask": lanes.mask, "one": lanes.constant(1.0)}
    words["epsilon"] = lanes.constant(lanes.real.epsilon)
    places = {"r": "{0}", "a": "{1}", "b": "{2}", "c": "{3}"}
    return {op: text.format(**words, **places) for op, text in INSTRUCTION.items()}


def functions(program: Program, lanes: Lanes, fma: bool) -> str:
    """LLVM text of the functions that a program's operations call."""
    return "\n".join(
        function(f"@vector.{name}.{lanes.suffix}", OPERATIONS[name].arity, make, lanes, fma)
        for name, make in FUNCTIONS.items()
        if name in program.operations
    )


def declarations(lanes: Lanes) -> str:
    """Declarations of LLVM's own functions that the instructions call."""
    v, n = lanes.v, lanes.suffix
    return (
        f"declare {v} @llvm.sqrt.{n}({v})\n"
        f"declare {v} @llvm.fabs.{n}({v})\n"
        f"declare {v} @llvm.copysign.{n}({v}, {v})\n"
    )
