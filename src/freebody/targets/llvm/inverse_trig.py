"""Arc tangent of a quotient, arc sine and arc cosine, over the whole range of doubles, each within
2 ulp.

The polynomials are those of fdlibm; quadrants and signed zeros are those of C's functions.
"""

from __future__ import annotations

from typing import Any

from freebody.targets.llvm.vector import Block, Value

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


def atan2(b: Block, y: Value, x: Value) -> Value:
    """The angle of (x, y): the arc tangent of the smaller over the larger, then mirrored into its
    octant."""
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


def asin(b: Block, x: Value) -> Value:
    """Arc sine, NaN beyond 1 and -1."""
    near, high, low = _arc(b, b.absolute(x))
    constant = _pair(b, near, (0.0, 0.0), _HALF_PI)
    return b.signed(_turned(constant, b.where(near, 1.0, -1.0), high, low), x)


def acos(b: Block, x: Value) -> Value:
    """Arc cosine, NaN beyond 1 and -1."""
    near, high, low = _arc(b, b.absolute(x))
    right = x > 0.0
    constant = _pair(b, near, _HALF_PI, _pair(b, right, (0.0, 0.0), _PI))
    sign = b.signed(b.lifted(1.0, "v"), x)
    return _turned(constant, b.where(near, -sign, sign), high, low)


def _arc(b: Block, a: Value) -> tuple[Value, Value, Value]:
    """Of a = |x|: whether a < 1/2, and high + low: asin a there, acos a = 2 asin sqrt((1 - a) / 2)
    beyond."""
    near = a < 0.5
    z = b.where(near, a * a, (1.0 - a) * 0.5)
    root = b.sqrt(z)
    ratio = z * b.horner(_ASIN_P, z) / b.horner(_ASIN_Q, z)
    first = (root.bits & -(2**32)).real  # its square is exact
    missing = (z - first * first) / (root + first + 1e-300)  # 0 where a is 1
    beyond = missing + root * ratio
    return near, b.where(near, a, first + first), b.where(near, a * ratio, beyond + beyond)


def _turned(constant: tuple[Value, Value], sign: Value, high: Value, low: Value) -> Value:
    """constant + sign (high + low), rounded once."""
    total, rest = _sum(constant[0], sign * high)
    return total + (rest + (sign * low + constant[1]))


def _sum(x: Value, y: Value) -> tuple[Value, Value]:
    """x + y and what is lost by rounding it, where x is the larger or 0."""
    total = x + y
    return total, (x - total) + y


def _pair(b: Block, condition: Value, x: Any, y: Any) -> tuple[Value, Value]:
    """One of two numbers of two parts."""
    return b.where(condition, x[0], y[0]), b.where(condition, x[1], y[1])
