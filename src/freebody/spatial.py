"""Rigid-body algebra in the plane and in space under the same names, over any scalars.

Vectors are tuples of scalars, matrices tuples of rows. *Linear* vectors (positions, velocities,
forces) have `dim` entries; *angular* ones (rates, moments) have 3 in space and 1 in the plane. An
algorithm is given `plane` or `space` and never asks which: that is how the notes' planar recursion
(4.6-4.15) and the spatial one (6.16-6.29) are one text.

Notation: R = R_PB takes components in B to components in P; p is the origin of B in P.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from functools import cache, reduce
from typing import Any

from freebody.elementary import Scalar, cos, sin

Vector = tuple[Scalar, ...]
Matrix = tuple[Vector, ...]


# ---------------------------------------------------------------- vectors and matrices of any size
def add(*vectors: Vector) -> Vector:
    """Sum of vectors, entry by entry."""
    if len(vectors) == 2:
        a, b = vectors
        if len(a) == len(b) == 3:  # most are: tracing and lowering spend their time here
            return a[0] + b[0], a[1] + b[1], a[2] + b[2]
        return tuple([x + y for x, y in zip(a, b, strict=True)])
    return tuple(reduce(lambda x, y: x + y, column) for column in zip(*vectors, strict=True))


def sub(a: Vector, b: Vector) -> Vector:
    """Difference a - b of two vectors."""
    return tuple(x - y for x, y in zip(a, b, strict=True))


def neg(a: Vector) -> Vector:
    """Opposite -a of a vector."""
    return tuple(-x for x in a)


def scale(s: Scalar, a: Vector) -> Vector:
    """A vector times a scalar, s a."""
    if len(a) == 3:  # as in `add`
        return s * a[0], s * a[1], s * a[2]
    return tuple(s * x for x in a)


def dot(a: Vector, b: Vector) -> Scalar:
    """Dot product a · b of two vectors."""
    if len(a) == len(b) == 3:  # as in `add`
        return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
    return reduce(lambda x, y: x + y, (x * y for x, y in zip(a, b, strict=True)))


def unit(vector: Iterable[float]) -> tuple[float, ...]:
    """The unit vector along finite numbers, not all zero, of any size; exact along a coordinate
    axis."""
    entries = tuple(float(x) + 0.0 for x in vector)  # no -0
    length = math.hypot(*entries)
    if abs(length - 1.0) < 1e-15:
        return entries
    if not 1e-150 < length < 1e150:  # where digits are lost, or the length overflows
        largest = max(map(abs, entries))
        entries = tuple(x / largest for x in entries)
        length = math.hypot(*entries)
    return tuple(x / length for x in entries)


def combine(vectors: tuple[Vector, ...], weights: Vector) -> Vector:
    """Linear combination Σ weights[k] vectors[k]."""
    return add(*(scale(s, v) for v, s in zip(vectors, weights, strict=True)))


def times(A: Matrix, x: Vector) -> Vector:
    """Matrix times vector, A x."""
    if len(x) == 3:  # as in `add`
        a, b, c = x
        return tuple([row[0] * a + row[1] * b + row[2] * c for row in A])
    return tuple([dot(row, x) for row in A])


def transposed(A: Matrix, columns: int = 0) -> Matrix:
    """Transpose Aᵀ; `columns`, those of A, have to be said where A may have no rows."""
    return tuple(zip(*A, strict=True)) if A else ((),) * columns


def product(A: Matrix, B: Matrix) -> Matrix:
    """Product A B of two matrices."""
    columns = transposed(B)
    return tuple(tuple(dot(row, column) for column in columns) for row in A)


def plus(A: Matrix, B: Matrix) -> Matrix:
    """Sum A + B of two matrices."""
    return tuple(add(a, b) for a, b in zip(A, B, strict=True))


def congruence(A: Matrix, X: Matrix) -> Matrix:
    """The product Xᵀ A X for a symmetric A; only the upper triangle is computed, the lower
    mirrored."""
    right, left = product(A, X), transposed(X)
    return symmetric(len(left), lambda i, j: dot(left[i], tuple(row[j] for row in right)))


def symmetric(n: int, entry: Any) -> Matrix:
    """The symmetric n×n matrix whose upper triangle is entry(i, j), i <= j."""
    upper = {(i, j): entry(i, j) for i in range(n) for j in range(i, n)}
    return tuple(tuple(upper[min(i, j), max(i, j)] for j in range(n)) for i in range(n))


@cache
def identity(n: int) -> Matrix:
    """Unit matrix with n rows."""
    return tuple(tuple(1.0 if i == j else 0.0 for j in range(n)) for i in range(n))


class Space:
    """Vector algebra of three dimensions: angular vectors are 3-vectors, inertias symmetric 3×3
    matrices."""

    dim = 3
    six = 6
    axes = "xyz"
    zero: Vector = (0.0, 0.0, 0.0)
    zero_angular: Vector = (0.0, 0.0, 0.0)
    no_inertia: Any = ((0.0,) * 3,) * 3

    def cross(self, w: Vector, r: Vector) -> Vector:
        """The velocity ω × r that an angular rate gives to a point."""
        return (w[1] * r[2] - w[2] * r[1], w[2] * r[0] - w[0] * r[2], w[0] * r[1] - w[1] * r[0])

    moment = cross
    """Moment r × f of a force."""
    cross_angular = cross
    """ω₁ × ω₂ of two angular vectors."""

    def turn(self, R: Matrix, w: Vector) -> Vector:
        """The components R ω of an angular vector in turned axes."""
        return times(R, w)

    def rotation(self, axis: Vector, angle: Scalar) -> Matrix:
        """Rotation by an angle about a constant unit axis (Rodrigues)."""
        s, c = sin(angle), cos(angle)
        x, y, z = axis
        rest = 1.0 - c
        return (
            (_square(x, c), x * y * rest - z * s, x * z * rest + y * s),
            (x * y * rest + z * s, _square(y, c), y * z * rest - x * s),
            (x * z * rest - y * s, y * z * rest + x * s, _square(z, c)),
        )

    def quaternion(self, q: Vector) -> Matrix:
        """Rotation of a quaternion w, x, y, z of any length but zero."""
        w, x, y, z = q
        s = 2.0 / (w * w + x * x + y * y + z * z)
        return (
            (1.0 - s * (y * y + z * z), s * (x * y - w * z), s * (x * z + w * y)),
            (s * (x * y + w * z), 1.0 - s * (x * x + z * z), s * (y * z - w * x)),
            (s * (x * z - w * y), s * (y * z + w * x), 1.0 - s * (x * x + y * y)),
        )

    def rates(self, w: Vector, wd: Vector) -> Matrix:
        """The matrix [ω̇×] + [ω×][ω×], whose product with r is the acceleration of r relative to
        the origin, as in (4.5), (6.21)."""
        xx, yy, zz = w[0] * w[0], w[1] * w[1], w[2] * w[2]
        xy, yz, xz = w[0] * w[1], w[1] * w[2], w[0] * w[2]
        return (
            (-(yy + zz), xy - wd[2], xz + wd[1]),
            (xy + wd[2], -(xx + zz), yz - wd[0]),
            (xz - wd[1], yz + wd[0], -(xx + yy)),
        )

    def inertia_times(self, inertia: Matrix, w: Vector) -> Vector:
        """The angular momentum I ω about the centre of mass."""
        return times(inertia, w)

    def euler(self, inertia: Matrix, w: Vector, wd: Vector) -> Vector:
        """The moment I ω̇ + ω × I ω about the centre of mass (6.2), (6.29)."""
        return add(times(inertia, wd), self.cross(w, times(inertia, w)))

    def coriolis(self, inertia: Matrix, h: Vector, w: Vector, v: Vector) -> Matrix:
        """The matrix -ω×Σ - h×v× with Σ = ½ tr(I) 1 - I, by which a body's angular momentum about
        the origin changes with turning axes.

        It is the only full block of the body's Coriolis matrix ½ ((v×*) I - I (v×) + (I v)×̄*).
        """
        half = 0.5 * (inertia[0][0] + inertia[1][1] + inertia[2][2])
        sigma = symmetric(3, lambda i, j: half - inertia[i][j] if i == j else -inertia[i][j])
        across = dot(h, v)
        # sigma is symmetric, so its rows are its columns
        turning = transposed(tuple(self.cross(w, row) for row in sigma))
        return tuple(
            tuple((across if i == j else 0.0) - v[i] * h[j] - turning[i][j] for j in range(3))
            for i in range(3)
        )

    def turned_inertia(self, R: Matrix, inertia: Matrix) -> Matrix:
        """The inertia R I Rᵀ in turned axes (6.3)."""
        a, b, c = R
        Ia, Ib, Ic = times(inertia, a), times(inertia, b), times(inertia, c)
        xy, xz, yz = dot(a, Ib), dot(a, Ic), dot(b, Ic)
        return ((dot(a, Ia), xy, xz), (xy, dot(b, Ib), yz), (xz, yz, dot(c, Ic)))

    def steiner(self, m: Scalar, h: Vector, p: Vector) -> Matrix:
        """The increase of an inertia when the point that it is about moves from a body's origin to
        one from which that origin is at p (mass m, first moment h about the origin) (1.19)."""
        # the inertia of first moments a, b is (a·b) 1 - a bᵀ, made symmetric
        (x, y, z), (hx, hy, hz) = p, h
        mx, my, mz = m * x, m * y, m * z
        xx, yy, zz = x * (mx + 2.0 * hx), y * (my + 2.0 * hy), z * (mz + 2.0 * hz)
        xy = -(mx * y + x * hy + hx * y)
        xz = -(mx * z + x * hz + hx * z)
        yz = -(my * z + y * hz + hy * z)
        return ((yy + zz, xy, xz), (xy, xx + zz, yz), (xz, yz, xx + yy))

    def plus_inertia(self, a: Matrix, b: Matrix) -> Matrix:
        """Sum of two inertias about the same point."""
        (xx, xy, xz), (_, yy, yz), (_, _, zz) = a
        xy, xz, yz = xy + b[0][1], xz + b[0][2], yz + b[1][2]
        return ((xx + b[0][0], xy, xz), (xy, yy + b[1][1], yz), (xz, yz, zz + b[2][2]))

    def skew(self, r: Vector) -> Matrix:
        """The matrix of r × f as a function of f: angular rows, linear columns."""
        x, y, z = r
        return ((0.0, -z, y), (z, 0.0, -x), (-y, x, 0.0))

    def inertia_matrix(self, inertia: Matrix) -> Matrix:
        """The inertia as a matrix over angular components."""
        return inertia


class Plane:
    """Vector algebra of two dimensions: angular vectors have one entry, inertias are numbers."""

    dim = 2
    six = 3
    axes = "xy"
    zero: Vector = (0.0, 0.0)
    zero_angular: Vector = (0.0,)
    no_inertia: Any = 0.0

    def cross(self, w: Vector, r: Vector) -> Vector:
        """Cross product of an angular velocity and a vector, ω z × r."""
        return (-w[0] * r[1], w[0] * r[0])

    def moment(self, r: Vector, f: Vector) -> Vector:
        """The scalar cross product of two planar vectors, r_x f_y - r_y f_x."""
        return (r[0] * f[1] - r[1] * f[0],)

    def cross_angular(self, w1: Vector, w2: Vector) -> Vector:
        """The cross product of two angular vectors, which is zero in the plane since all are
        parallel."""
        return (0.0,)

    def turn(self, R: Matrix, w: Vector) -> Vector:
        """An angular vector in turned axes, which in the plane is unchanged."""
        return w

    def rotation(self, axis: Vector, angle: Scalar) -> Matrix:
        """Rotation by an angle about ±z."""
        s, c = axis[0] * sin(angle), cos(angle)
        return ((c, -s), (s, c))

    def rates(self, w: Vector, wd: Vector) -> Matrix:
        """The matrix ω̇ z× + ω z× (ω z×), as in (4.10)."""
        ww = -(w[0] * w[0])
        return ((ww, -wd[0]), (wd[0], ww))

    def inertia_times(self, inertia: Scalar, w: Vector) -> Vector:
        """Angular momentum I ω about the centre of mass."""
        return (inertia * w[0],)

    def euler(self, inertia: Scalar, w: Vector, wd: Vector) -> Vector:
        """Moment about the centre of mass, I ω̇ (3.2)."""
        return (inertia * wd[0],)

    def coriolis(self, inertia: Scalar, h: Vector, w: Vector, v: Vector) -> Matrix:
        """Angular block of the Coriolis matrix: h · v, as a 1×1 matrix."""
        return ((dot(h, v),),)

    def turned_inertia(self, R: Matrix, inertia: Scalar) -> Scalar:
        """The inertia in turned axes, which in the plane is the same number."""
        return inertia

    def steiner(self, m: Scalar, h: Vector, p: Vector) -> Scalar:
        """The inertia that a shift by p adds: m p² + 2 p·h (1.19)."""
        return m * dot(p, p) + 2.0 * dot(p, h)

    def plus_inertia(self, a: Scalar, b: Scalar) -> Scalar:
        """Sum of two moments of inertia."""
        return a + b

    def skew(self, r: Vector) -> Matrix:
        """The row matrix of r × f as a function of f."""
        return ((-r[1], r[0]),)

    def inertia_matrix(self, inertia: Scalar) -> Matrix:
        """Moment of inertia as a 1×1 matrix."""
        return ((inertia,),)


plane = Plane()
space = Space()
AnySpace = Plane | Space


def of_dimension(dim: int) -> AnySpace:
    """`plane` for 2, `space` for 3."""
    return {2: plane, 3: space}[dim]


def compose(Rp: tuple[Matrix, Vector], Sr: tuple[Matrix, Vector]) -> tuple[Matrix, Vector]:
    """The pose T_AB T_BC as (R, p)."""
    (R, p), (S, r) = Rp, Sr
    return product(R, S), add(p, times(R, r))


def _square(x: float, c: Scalar) -> Scalar:
    """The diagonal entry x² + (1 - x²) cos of a rotation about an axis with component x, exact for
    coordinate axes."""
    return 1.0 if x in (1.0, -1.0) else c if x == 0.0 else x * x + (1.0 - x * x) * c
