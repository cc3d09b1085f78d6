"""Scalars that carry their first and second time derivative, so that kinematics can be differentiated along a motion.

An algorithm over any scalar, fed with `Jet`s of q(t), returns poses with their exact rates and accelerations; nothing
of the velocity and acceleration recursions goes into them.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

Number = Any
"""A float or an array, one entry a sample."""


@dataclass(frozen=True)
class Jet:
    """x, ẋ, ẍ at one time."""

    x: Number
    xd: Number
    xdd: Number
    __array_ufunc__ = None  # arrays leave the arithmetic to this class

    def __add__(self, other: Number) -> Jet:
        o = jet(other)
        return Jet(self.x + o.x, self.xd + o.xd, self.xdd + o.xdd)

    def __mul__(self, other: Number) -> Jet:
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

    def __sub__(self, other: Number) -> Jet:
        return self + -jet(other)

    def __rsub__(self, other: Number) -> Jet:
        return jet(other) + -self

    def __truediv__(self, other: Number) -> Jet:
        return self * jet(other)._through(lambda x: (1.0 / x, -1.0 / x**2, 2.0 / x**3))

    def __rtruediv__(self, other: Number) -> Jet:
        return jet(other) / self

    def elementary(self, name: str, operands: tuple[Any, ...]) -> Jet:
        """Sine or cosine: all that kinematics needs."""
        return self._through(_DERIVATIVES[name])

    def _through(self, function: Any) -> Jet:
        """f(x), f' ẋ, f'' ẋ² + f' ẍ."""
        f, slope, bend = function(self.x)
        return Jet(f, slope * self.xd, bend * self.xd**2 + slope * self.xdd)


_DERIVATIVES: dict[str, Any] = {
    "sin": lambda x: (np.sin(x), np.cos(x), -np.sin(x)),
    "cos": lambda x: (np.cos(x), -np.sin(x), -np.cos(x)),
}
"""Value, first and second derivative."""


def jet(x: Number) -> Jet:
    """A jet as it is; a constant with derivatives zero."""
    return x if isinstance(x, Jet) else Jet(x, 0.0, 0.0)


def stacked(nested: Any, samples: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Nested tuples of jets as three arrays (samples, *shape)."""
    rows: list[Any] = []
    shape: list[int] = []

    def walk(item: Any, depth: int) -> None:
        if isinstance(item, tuple):
            if len(shape) == depth:
                shape.append(len(item))
            for part in item:
                walk(part, depth + 1)
        else:
            rows.append(jet(item))

    walk(nested, 0)
    size = (samples, *shape)
    first, second, third = (
        np.stack([np.broadcast_to(getattr(r, name), (samples,)) for r in rows], axis=-1).reshape(size)
        for name in ("x", "xd", "xdd")
    )
    return first, second, third
