"""Mass, centre of mass and moment of inertia of a rigid body, and the shapes of textbooks (notes,
1.15-1.20)."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from decimal import Context, Decimal
from functools import reduce
from typing import Any

import numpy as np

from freebody.elementary import Scalar
from freebody.errors import MissingValueError, ModelError
from freebody.model.families import Members, arrays_in, common_shape, members, of_member, taken
from freebody.model.parameters import (
    LARGEST,
    Parameter,
    ParameterProduct,
    Quantity,
    each_parameter,
    finite,
    quantity,
)
from freebody.model.placement import rotation_matrix
from freebody.model.quantity_reader import VALUES, QuantityReader
from freebody.outputs.display import counted
from freebody.outputs.number_text import compared
from freebody.spatial import Vector

# of the largest eigenvalue: how negative a pseudo-inertia may be before it is called not physical
_TOLERANCE = 1e-9
_MARGIN = 1e-12  # of minors, far above their rounding
_EXACT = Context(prec=700)
"""Digits from the largest to the smallest number that there is: no sum is rounded."""


@dataclass(frozen=True)
class Inertia:
    """Mass properties in some frame: `mass` (kg), `com` (m), `tensor` about the com (kg m²), axes
    of the frame.

    In space `tensor` holds ixx, ixy, ixz, iyy, iyz, izz (symmetric matrix entries, no sign
    convention of products of inertia); in the plane one number. Entries are numbers, parameters, or
    arrays with a number for each member of a family.
    """

    mass: Quantity
    com: tuple[Quantity, ...]
    tensor: tuple[Quantity, ...]

    def __post_init__(self) -> None:
        if (len(self.com), len(self.tensor)) not in ((3, 6), (2, 1)):
            raise ModelError(
                f"Inertia: com has {len(self.com)} and tensor {len(self.tensor)} entries; give 3 "
                f"and 6 (ixx, ixy, ixz, iyy, iyz, izz) in space, 2 and 1 in the plane."
            )
        if type(self.com) is type(self.tensor) is tuple and _are_plain(
            (self.mass, *self.com, *self.tensor)
        ):
            return
        for name, values in (("mass", (self.mass,)), ("com", self.com), ("tensor", self.tensor)):
            cleaned = tuple([_number(x, f"Inertia: {name}") for x in values])
            object.__setattr__(self, name, cleaned[0] if name == "mass" else cleaned)

    @property
    def dim(self) -> int:
        """Dimension of the inertia, 2 or 3."""
        return len(self.com)

    @property
    def is_family(self) -> bool:
        """Whether some number has a value for each member of a family."""
        return bool(arrays_in((self.mass, self.com, self.tensor)))

    # ------------------------------------------------------------ constructors
    @staticmethod
    def of(
        mass: Quantity | str,
        com: Sequence[Quantity | str],
        tensor: Quantity | str | Sequence[Quantity | str] | Sequence[Sequence[float]] | np.ndarray,
    ) -> Inertia:
        """Inertia from a mass, a com and a tensor about it: a number (plane), 6 entries ixx, ixy,
        ixz, iyy, iyz, izz or 3×3."""
        given: Any = tensor
        entries: tuple[object, ...]
        if isinstance(given, str | Parameter) or np.ndim(given) == 0:
            entries = (given,)
        elif len(given) == 3 and np.shape(given) == (3, 3):
            entries = _upper(np.asarray(given, dtype=float))
        else:
            entries = tuple(given)
        return Inertia(
            quantity(mass, "Inertia: mass"),
            tuple(quantity(c, "Inertia: com") for c in com),
            tuple(quantity(t, "Inertia: tensor") for t in entries),
        )

    @staticmethod
    def nothing(dim: int = 3) -> Inertia:
        """Inertia of a body without mass."""
        return Inertia(0.0, (0.0,) * dim, (0.0,) * (6 if dim == 3 else 1))

    @staticmethod
    def point(mass: Any, com: Sequence[Any] = (0.0, 0.0, 0.0)) -> Inertia:
        """A particle at `com`; two entries make it planar."""
        return Inertia(mass, tuple(com), (0.0,) * (6 if len(com) == 3 else 1))

    @staticmethod
    def disc(mass: float, radius: float, dim: int = 3) -> Inertia:
        """Thin uniform disc in the xy plane, about its centre: I_G = m r²/2 about z."""
        r2 = radius * radius
        return _shape(mass, dim, mass * r2 / 4, mass * r2 / 4, mass * r2 / 2)

    @staticmethod
    def ring(mass: float, radius: float, dim: int = 3) -> Inertia:
        """Thin ring in the xy plane: I_G = m r² about z."""
        r2 = radius * radius
        return _shape(mass, dim, mass * r2 / 2, mass * r2 / 2, mass * r2)

    @staticmethod
    def bar(mass: float, length: float, dim: int = 3) -> Inertia:
        """Thin uniform bar along x, about its middle: I_G = m l²/12."""
        l2 = length * length
        return _shape(mass, dim, 0.0, mass * l2 / 12, mass * l2 / 12)

    @staticmethod
    def box(mass: Any, size: Sequence[float]) -> Inertia:
        """Uniform box with sides along the axes; two sides make a planar rectangle."""
        if len(size) not in (2, 3):
            raise ModelError(
                f"Inertia.box: size has {counted(len(size), 'entry')}, expected 3, or 2 in the "
                f"plane."
            )
        x, y, z = (side * side for side in (*size, 0.0)[:3])
        return _shape(
            mass, len(size), mass * (y + z) / 12, mass * (x + z) / 12, mass * (x + y) / 12
        )

    @staticmethod
    def cylinder(mass: float, radius: float, length: float) -> Inertia:
        """Inertia of a solid cylinder along z."""
        r2 = radius * radius
        across = mass * (3 * r2 + length * length) / 12
        return _shape(mass, 3, across, across, mass * r2 / 2)

    @staticmethod
    def sphere(mass: float, radius: float) -> Inertia:
        """Inertia of a solid sphere."""
        return _shape(mass, 3, *(0.4 * mass * (radius * radius),) * 3)

    # ------------------------------------------------------------ numbers
    def numbers(self) -> tuple[float, np.ndarray, np.ndarray]:
        """(mass, com (dim,), tensor about the com (3, 3) or (1, 1)) as numbers."""
        missing = [name for p in each_parameter(self) for name in p.missing]
        if missing:
            raise MissingValueError("Inertia", missing)
        if self.is_family:
            raise ModelError(
                "Inertia: it holds the numbers of several members; take one member of the model, "
                "model[i]."
            )
        m, c, t = self.lower(VALUES)
        return (
            float(m),
            np.array(c, dtype=float),
            np.array(t if self.dim == 3 else [[t]], dtype=float),
        )

    def lower(self, reader: QuantityReader) -> tuple[Scalar, Vector, Scalar]:
        """(mass, com, tensor) in scalars: a 3×3 matrix in space, a number in the plane."""
        return in_shape(self.dim, reader.quantities((self.mass, *self.com, *self.tensor)))

    def about(self, point: Sequence[float]) -> np.ndarray:
        """Tensor (3, 3), or (1, 1) in the plane, about a point of the frame: parallel axis theorem
        (1.19)."""
        m, c, tensor = self.numbers()
        return tensor + _steiner(m, np.asarray(point, dtype=float) - c)

    def placed(
        self,
        rotation: np.ndarray | Sequence[Sequence[float]],
        position: np.ndarray | Sequence[float],
    ) -> Inertia:
        """The inertia of this body in frame A, given the pose R_AB (dim, dim), p_AB (dim,) in m of
        its own frame B."""
        m, c, tensor = self.numbers()
        R = rotation_matrix(rotation, "Inertia.placed")
        turned = R @ tensor @ R.T if self.dim == 3 else tensor
        com = tuple(decimal_sum((*row, p)) for row, p in zip(R * c, position, strict=True))
        return Inertia(m, com, _upper(turned))

    def moved_to(self, com: Sequence[Quantity | str]) -> Inertia:
        """The inertia of this body with its centre of mass elsewhere."""
        return Inertia(self.mass, tuple(quantity(x, "Inertia: com") for x in com), self.tensor)

    def __add__(self, other: Inertia) -> Inertia:
        """Two bodies as one, both in the same frame."""
        return combined((self, other))

    def fault(self) -> str | None:
        """Why no rigid body has this inertia, or None. Of parameters without value nothing is
        known."""
        if is_surely_physical(self.mass, self.tensor):
            return None
        unknown = any(p.value is None for p in each_parameter(self))
        m, tensor = _known(self.mass), None
        if not unknown:
            m, _, tensor = self.numbers()
        if m < 0:
            return f"mass {m:g} kg is negative"
        if self.dim == 2:
            about = _known(self.tensor[0]) if tensor is None else tensor[0, 0]
            return f"moment of inertia {about:g} kg m² is negative" if about < 0 else None
        if tensor is None:
            return None
        principal = np.sort(np.linalg.eigvalsh(tensor))
        sigma = principal.sum() / 2 - principal
        if sigma.min() >= -_TOLERANCE * max(abs(sigma).max(), m):
            return None
        a, b, c = principal
        if a < -_TOLERANCE * abs(c):
            return f"principal moment {a:g} kg m² is negative"
        x, y, z = compared(a, b, c, digits=6, holds=lambda a, b, c: a + b < c)
        return (
            f"principal moments {x}, {y}, {z} kg m² break the triangle inequality ({x} + {y} < {z})"
        )


def in_shape(dim: int, entries: Sequence[Scalar]) -> tuple[Scalar, Vector, Scalar]:
    """(mass, com, tensor) of mass, com and tensor entry by entry."""
    if dim == 2:
        m, x, y, zz = entries
        return m, (x, y), zz
    m, x, y, z, xx, xy, xz, yy, yz, zz = entries
    return m, (x, y, z), ((xx, xy, xz), (xy, yy, yz), (xz, yz, zz))


def is_surely_physical(mass: Any, tensor: Sequence[Any]) -> bool:
    """Whether the second moments are positive by a margin or diagonal, found without their
    eigenvalues."""
    if type(mass) is not float or mass < 0.0 or {float} != {*map(type, tensor)}:
        return False
    if len(tensor) == 1:
        return tensor[0] >= 0.0
    xx, xy, xz, yy, yz, zz = tensor
    half = 0.5 * (xx + yy + zz)
    a, b, c, d, e, f = half - xx, half - yy, half - zz, xy * xy, xz * xz, yz * yz
    if min(a, b, c) < 0.0:
        return False
    if d == e == f == 0.0:
        return True
    size = a + b + c
    minors = min(a * b - d, a * c - e, b * c - f)
    determinant = a * b * c - a * f - b * e - c * d - 2.0 * xy * xz * yz
    return minors > _MARGIN * size**2 and determinant > _MARGIN * size**3


def _are_plain(values: tuple[Any, ...]) -> bool:
    """Whether all are floats that no number of a robot exceeds; NaN does."""
    return {*map(type, values)} == {float} and sum(map(abs, values)) <= LARGEST


def _number(x: Any, owner: str) -> Quantity:
    if type(x) is float and -LARGEST <= x <= LARGEST:  # most are
        return x
    if isinstance(x, (Parameter, Members)):
        return x
    if isinstance(x, ParameterProduct):
        return x  # type: ignore[return-value]  # until its parameters have values
    return members(x, owner, LARGEST) if isinstance(x, np.ndarray) and x.ndim else finite(x, owner)


def _known(x: Quantity) -> float:
    """A value; NaN where there is none, which no comparison finds negative."""
    value = x.value if isinstance(x, Parameter) else x
    return value if isinstance(value, float) else math.nan


def faults(inertia: Inertia) -> str | None:
    """`Inertia.fault`, of a family that of the first member that has one, by its index."""
    if is_surely_physical(inertia.mass, inertia.tensor):
        return None
    arrays = arrays_in(inertia)
    if not arrays:
        return inertia.fault()
    shape = common_shape(arrays, "Inertia")
    for index in _doubtful(inertia, shape):
        fault = taken(inertia, shape, index).fault()
        if fault:
            return f"{fault}{of_member(index)}"
    return None


def _doubtful(inertia: Inertia, shape: tuple[int, ...]) -> list[tuple[int, ...]]:
    """Members that a look at all of them at once does not find physical."""
    if any(p.value is None for p in each_parameter(inertia)):
        return []
    m, _, t = inertia.lower(VALUES)
    m = np.broadcast_to(m, shape)
    if inertia.dim == 2:
        sound = (m >= 0.0) & (np.broadcast_to(t, shape) >= 0.0)
    else:
        tensor = np.stack([np.broadcast_to(x, shape) for row in t for x in row], axis=-1)
        principal = np.linalg.eigvalsh(tensor.reshape(*shape, 3, 3))
        sound = (m >= 0.0) & (principal[..., 0] + principal[..., 1] >= principal[..., 2])
    return [tuple(map(int, index)) for index in np.argwhere(~sound)]


def combined(parts: Sequence[Inertia]) -> Inertia:
    """Several bodies in one frame as one rigid body: centre of mass (1.15) and parallel axes
    (1.19)."""
    if not parts:
        raise ModelError("combined: give at least one Inertia.")
    numbers = [part.numbers() for part in parts]
    if len({part.dim for part in parts}) > 1:
        raise ModelError("combined: planar and spatial inertias cannot be mixed.")
    mass = decimal_sum(m for m, _, _ in numbers)
    moment = sum((m * c for m, c, _ in numbers), np.zeros(parts[0].dim))
    if mass == 0.0 and moment.any():
        raise ModelError(
            "combined: the masses cancel out but not their moments, so there is no centre of mass."
        )
    com = moment / mass if mass else np.zeros(parts[0].dim)
    tensor = sum(t + _steiner(m, c - com) for m, c, t in numbers)
    return Inertia(mass, tuple(com), _upper(np.asarray(tensor)))


def decimal_sum(numbers: Iterable[float]) -> float:
    """The sum of numbers as they are written in decimals, rounded once: of 1.05 and 2.3 it is 3.35,
    where floats add up to 3.3499999999999996."""
    return float(reduce(_EXACT.add, (Decimal(repr(float(x))) for x in numbers), Decimal(0)))


def _steiner(m: float, d: np.ndarray) -> np.ndarray:
    """Inertia that is added by moving a mass by d, by Steiner's theorem: m (d² 1 - d dᵀ), or m d²
    in the plane."""
    return m * (d @ d * np.eye(3) - np.outer(d, d)) if len(d) == 3 else np.array([[m * (d @ d)]])


def _upper(tensor: np.ndarray) -> tuple[float, ...]:
    """Entries of a symmetric matrix in stored order."""
    if tensor.shape == (1, 1):
        return (float(tensor[0, 0]),)
    if not np.allclose(
        tensor, tensor.T, rtol=0, atol=1e-12 * max(1e-300, float(abs(tensor).max()))
    ):
        raise ModelError("Inertia: the 3×3 tensor is not symmetric.")
    return tuple(float(tensor[i, j]) for i, j in ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)))


# squares above are products: a product that overflows is infinite and refused as such, a power
# raises OverflowError
def _shape(mass: float, dim: int, xx: float, yy: float, zz: float) -> Inertia:
    return Inertia(mass, (0.0,) * dim, (xx, 0.0, 0.0, yy, 0.0, zz) if dim == 3 else (zz,))
