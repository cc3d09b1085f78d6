"""Scalars that carry their first and second time derivative, so that kinematics can be
differentiated along a motion.

An algorithm over any scalar, fed with `Jet`s of q(t), returns poses with their exact rates and
accelerations; nothing of the velocity and acceleration recursions goes into them.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from freebody.elementary import Scalar, cos, sin


@dataclass(frozen=True)
class Jet:
    """A value with its first two time derivatives: x, ẋ, ẍ."""

    x: Scalar
    xd: Scalar
    xdd: Scalar
    __array_ufunc__ = None  # arrays leave the arithmetic to this class

    def __add__(self, other: Scalar) -> Jet:
        o = jet(other)
        return Jet(self.x + o.x, self.xd + o.xd, self.xdd + o.xdd)

    def __mul__(self, other: Scalar) -> Jet:
        if not isinstance(other, Jet):
            return Jet(self.x * other, self.xd * other, self.xdd * other)
        o = other
        return Jet(
            self.x * o.x,
            self.xd * o.x + self.x * o.xd,
            self.xdd * o.x + 2.0 * self.xd * o.xd + self.x * o.xdd,
        )

    __radd__, __rmul__ = __add__, __mul__

    def __neg__(self) -> Jet:
        return self * -1.0

    def __sub__(self, other: Scalar) -> Jet:
        return self + -jet(other)

    def __rsub__(self, other: Scalar) -> Jet:
        return jet(other) + -self

    def __truediv__(self, other: Scalar) -> Jet:
        return self * jet(other)._through(lambda x: (1.0 / x, -1.0 / (x * x), 2.0 / (x * x * x)))

    def __rtruediv__(self, other: Scalar) -> Jet:
        return jet(other) / self

    def elementary(self, name: str, operands: tuple[Any, ...]) -> Jet:
        """The sine or cosine of a jet, which are all the functions that kinematics needs."""
        return self._through(_DERIVATIVES[name])

    def _through(self, function: Any) -> Jet:
        """A function of a jet with its derivatives: f(x), f' ẋ, f'' ẋ² + f' ẍ."""
        f, slope, bend = function(self.x)
        return Jet(f, slope * self.xd, bend * (self.xd * self.xd) + slope * self.xdd)


_DERIVATIVES: dict[str, Any] = {
    "sin": lambda x: (sin(x), cos(x), -sin(x)),
    "cos": lambda x: (cos(x), -sin(x), -cos(x)),
}
"""Value, first and second derivative."""


def jet(x: Scalar) -> Jet:
    """A jet unchanged; a constant as a jet with zero derivatives."""
    return x if isinstance(x, Jet) else Jet(x, 0.0, 0.0)


def parts(nested: Any) -> tuple[Any, Any, Any]:
    """Three nested tuples from one of jets: of the values, and of the first and second
    derivatives."""
    if isinstance(nested, tuple):
        first, second, third = zip(*map(parts, nested), strict=True)
        return first, second, third
    of = jet(nested)
    return of.x, of.xd, of.xdd
