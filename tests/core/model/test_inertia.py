"""Inertias: shapes against quadrature, combination and parallel axes against particles, and what no
body can have."""

from __future__ import annotations

import math
from functools import reduce
from operator import add

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

import freebody as fb
from freebody import Inertia, ModelError, Parameter
from support.generate import random_inertia, random_rotation
from support.helpers import refused

M = 3.0


def tensor_of(masses: np.ndarray, points: np.ndarray, about: np.ndarray) -> np.ndarray:
    """Σ m (r² 1 - r rᵀ)."""
    r = points - about
    return np.einsum(
        "n,nij->ij",
        masses,
        (r**2).sum(-1)[:, None, None] * np.eye(3) - r[:, :, None] * r[:, None, :],
    )


def product_rule(*axes: tuple[np.ndarray, np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Weights and coordinates of a product of one-dimensional rules."""
    grids = np.meshgrid(*(x for x, _ in axes), indexing="ij")
    weights = np.meshgrid(*(w for _, w in axes), indexing="ij")
    return np.prod(weights, axis=0).ravel(), np.stack([g.ravel() for g in grids], -1)


def gauss(a: float, b: float) -> tuple[np.ndarray, np.ndarray]:
    x, w = np.polynomial.legendre.leggauss(4)
    return (a + b) / 2 + (b - a) / 2 * x, w * (b - a) / 2


def circle() -> tuple[np.ndarray, np.ndarray]:
    return np.arange(8) * math.pi / 4, np.full(8, math.pi / 4)


def shapes() -> dict[str, tuple[Inertia, np.ndarray, np.ndarray]]:
    """Each shape with masses and points that integrate quadratics over it exactly."""
    none = (np.zeros(1), np.ones(1))
    r, a = 0.7, 1.3

    def polar(weights: np.ndarray, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """x holds radius, angle, height."""
        points = np.stack([x[:, 0] * np.cos(x[:, 1]), x[:, 0] * np.sin(x[:, 1]), x[:, 2]], -1)
        weights = weights * x[:, 0]
        return M * weights / weights.sum(), points

    def ball(weights: np.ndarray, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """x holds radius, angle, cosine of the latitude's complement."""
        s = np.sqrt(1 - x[:, 2] ** 2)
        points = x[:, :1] * np.stack([s * np.cos(x[:, 1]), s * np.sin(x[:, 1]), x[:, 2]], -1)
        weights = weights * x[:, 0] ** 2
        return M * weights / weights.sum(), points

    def cartesian(weights: np.ndarray, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return M * weights / weights.sum(), x

    rim = (np.array([r]), np.ones(1))
    return {
        "disc": (Inertia.disc(M, r), *polar(*product_rule(gauss(0, r), circle(), none))),
        "ring": (Inertia.ring(M, r), *polar(*product_rule(rim, circle(), none))),
        "bar": (Inertia.bar(M, a), *cartesian(*product_rule(gauss(-a / 2, a / 2), none, none))),
        "box": (
            Inertia.box(M, (a, r, 0.4)),
            *cartesian(*product_rule(gauss(-a / 2, a / 2), gauss(-r / 2, r / 2), gauss(-0.2, 0.2))),
        ),
        "cylinder": (
            Inertia.cylinder(M, r, a),
            *polar(*product_rule(gauss(0, r), circle(), gauss(-a / 2, a / 2))),
        ),
        "sphere": (Inertia.sphere(M, r), *ball(*product_rule(gauss(0, r), circle(), gauss(-1, 1)))),
        "point": (Inertia.point(M), np.array([M]), np.zeros((1, 3))),
    }


SHAPES = shapes()


@pytest.mark.parametrize("name", SHAPES)
def test_shapes_of_the_textbooks(name: str):
    inertia, masses, points = SHAPES[name]
    mass, com, tensor = inertia.numbers()
    assert mass == pytest.approx(masses.sum())
    assert com == pytest.approx(masses @ points / M, abs=1e-15)
    assert tensor == pytest.approx(tensor_of(masses, points, com), abs=1e-15)
    assert inertia.fault() is None


def test_planar_shapes_are_the_z_entries():
    for flat, solid in (
        (Inertia.disc(M, 0.7, dim=2), Inertia.disc(M, 0.7)),
        (Inertia.ring(M, 0.7, dim=2), Inertia.ring(M, 0.7)),
        (Inertia.bar(M, 1.3, dim=2), Inertia.bar(M, 1.3)),
        (Inertia.box(M, (1.3, 0.7)), Inertia.box(M, (1.3, 0.7, 0.4))),
    ):
        assert (flat.dim, solid.dim) == (2, 3)
        assert flat.numbers()[2].shape == (1, 1)
        assert flat.numbers()[2][0, 0] == pytest.approx(solid.numbers()[2][2, 2])
    assert Inertia.point(1.0, (1.0, 2.0)).dim == 2
    assert Inertia.nothing(2).dim == 2


# ---------------------------------------------------------------- sets of particles
coordinates = st.floats(-2, 2, allow_subnormal=False)
clouds = st.integers(1, 6).flatmap(
    lambda n: st.tuples(
        arrays(float, n, elements=st.floats(0.01, 5)), arrays(float, (n, 3), elements=coordinates)
    )
)


@given(clouds, arrays(float, 3, elements=coordinates))
def test_particles_together(cloud: tuple[np.ndarray, np.ndarray], point: np.ndarray):
    masses, points = cloud
    whole = reduce(
        add,
        (
            Inertia.point(float(m), tuple(map(float, p)))
            for m, p in zip(masses, points, strict=True)
        ),
    )
    m, c, tensor = whole.numbers()
    assert m == pytest.approx(masses.sum())
    assert c == pytest.approx(masses @ points / masses.sum(), abs=1e-12)
    assert tensor == pytest.approx(tensor_of(masses, points, c), abs=1e-11)
    assert whole.about(point) == pytest.approx(tensor_of(masses, points, point), abs=1e-10)
    assert whole.fault() is None


@given(st.integers(0, 2**32), st.sampled_from([2, 3]))
def test_sum_does_not_depend_on_order(seed: int, dim: int):
    rng = np.random.default_rng(seed)
    a, b, c = (random_inertia(rng, dim) for _ in range(3))
    for x, y in (((a + b) + c, a + (b + c)), (a + b, b + a), (a + Inertia.nothing(dim), a)):
        for left, right in zip(x.numbers(), y.numbers(), strict=True):
            assert left == pytest.approx(right, abs=1e-13)


@given(st.integers(0, 2**32))
def test_turned_and_moved(seed: int):
    rng = np.random.default_rng(seed)
    inertia = random_inertia(rng)
    R, p = random_rotation(rng), rng.normal(size=3)
    m, c, tensor = inertia.numbers()
    M2, C, T = inertia.placed(R, p).numbers()
    assert (m, C) == (pytest.approx(M2), pytest.approx(R @ c + p))
    assert R @ tensor @ R.T == pytest.approx(T, abs=1e-14)
    back = inertia.placed(R, p).placed(R.T, -R.T @ p)
    assert back.numbers()[2] == pytest.approx(tensor, abs=1e-13)
    x = rng.normal(size=3)
    assert R @ inertia.about(x) @ R.T == pytest.approx(
        inertia.placed(R, p).about(R @ x + p), abs=1e-11
    )


def test_moved_to_and_about_keep_what_they_should():
    bar = Inertia.bar(2.0, 1.0).moved_to((0.5, 0, 0))
    assert bar.com == (0.5, 0.0, 0.0)
    assert bar.about((0, 0, 0))[2, 2] == pytest.approx(2.0 / 3)  # m l²/3 about its end
    assert Inertia.disc(2.0, 1.0, dim=2).moved_to((1, 0)).about((0, 0))[0, 0] == pytest.approx(
        1.0 + 2.0
    )


def test_ways_to_write_a_tensor():
    six = Inertia.of(1.0, (0, 0, 0), (1, 0.1, 0.2, 2, 0.3, 2.5))
    matrix = Inertia.of(1.0, (0, 0, 0), [[1, 0.1, 0.2], [0.1, 2, 0.3], [0.2, 0.3, 2.5]])
    assert six == matrix
    assert six.numbers()[2][0, 2] == 0.2
    named = Inertia.of("m1", ("c1x", 0), "I1")
    assert (named.mass, named.com[0], named.tensor) == (
        Parameter("m1"),
        Parameter("c1x"),
        (Parameter("I1"),),
    )


# ---------------------------------------------------------------- what no body can have


def test_refusals():
    ask = "give 3 and 6 (ixx, ixy, ixz, iyy, iyz, izz) in space, 2 and 1 in the plane."
    refused(
        f"Inertia: com has 3 and tensor 1 entries; {ask}", lambda: Inertia.of(1, (0, 0, 0), 1.0)
    )
    refused(
        f"Inertia: com has 2 and tensor 6 entries; {ask}", lambda: Inertia.of(1, (0, 0), [1] * 6)
    )
    refused(
        f"Inertia: com has 3 and tensor 4 entries; {ask}", lambda: Inertia.of(1, (0, 0, 0), [1] * 4)
    )
    skewed = [[1, 0.1, 0], [0, 1, 0], [0, 0, 1]]
    refused("Inertia: the 3×3 tensor is not symmetric.", lambda: Inertia.of(1, (0, 0, 0), skewed))
    refused("Inertia: mass: nan is not a finite number.", lambda: Inertia.of(math.nan, (0, 0), 1))
    refused("Inertia: com: inf is not a finite number.", lambda: Inertia.of(1, (0, math.inf), 1))
    refused("Inertia: tensor: nan is not a finite number.", lambda: Inertia.of(1, (0, 0), math.nan))
    refused(
        "combined: the masses cancel out but not their moments, so there is no centre of mass.",
        lambda: Inertia.point(1.0, (1, 0, 0)) + Inertia.point(-1.0),
    )
    refused(
        "Inertia.placed: the matrix is not a rotation (R Rᵀ = 1, det R = 1).",
        lambda: Inertia.point(1.0).placed(2 * np.eye(3), (0, 0, 0)),
    )
    refused(
        "Inertia.box: size has 1 entry, expected 3, or 2 in the plane.",
        lambda: Inertia.box(1.0, (1.0,)),
    )
    refused(
        "combined: planar and spatial inertias cannot be mixed.",
        lambda: Inertia.nothing(2) + Inertia.nothing(3),
    )
    with pytest.raises(fb.FreebodyError, match=r"numbers need a value for m1\."):
        Inertia.of("m1", (0, 0), 1).numbers()
    with pytest.raises(ModelError, match=r"parameter name 'm 1' must be a word"):
        Inertia.of("m 1", (0, 0), 1)


@pytest.mark.parametrize(
    ("inertia", "fault"),
    [
        (Inertia.of(-1, (0, 0, 0), [1, 0, 0, 1, 0, 1]), "mass -1 kg is negative"),
        (Inertia.of(1, (0, 0), -2), "moment of inertia -2 kg m² is negative"),
        (
            Inertia.of(1, (0, 0, 0), [-0.5, 0, 0, 1, 0, 1]),
            "principal moment -0.5 kg m² is negative",
        ),
        (
            Inertia.of(1, (0, 0, 0), [0.1, 0, 0, 0.2, 0, 0.5]),
            "principal moments 0.1, 0.2, 0.5 kg m² break the triangle inequality (0.1 + 0.2 < 0.5)",
        ),
        (
            Inertia.of(1, (0, 0, 0), [1, 0.9, 0, 1, 0, 1]),
            "principal moments 0.1, 1, 1.9 kg m² break the triangle inequality (0.1 + 1 < 1.9)",
        ),
    ],
)
def test_faults(inertia: Inertia, fault: str):
    assert inertia.fault() == fault


@pytest.mark.parametrize(
    "inertia",
    [
        Inertia.nothing(),
        Inertia.nothing(2),
        Inertia.point(1.0),
        Inertia.bar(1.0, 2.0),  # two principal moments equal, the third nothing
        Inertia.disc(1.0, 2.0),  # a plate: on the edge of the inequality
        Inertia.of(0.0, (1.0, 0, 0), [1, 0, 0, 1, 0, 1]),  # inertia without mass, such as a rotor's
        Inertia.of(
            1.0, (0, 0, 0), [1e-12, 0, 0, 1e-12, 0, 2.1e-12]
        ),  # below what a file's digits can tell
        Inertia.of("m", (0, 0, 0), [-1, 0, 0, 1, 0, 1]),  # judged when bound
    ],
)
def test_without_fault(inertia: Inertia):
    assert inertia.fault() is None


@given(st.integers(0, 2**32))
def test_no_fault_of_a_body_in_any_axes(seed: int):
    rng = np.random.default_rng(seed)
    for inertia in (
        Inertia.bar(1.0, 1.0),
        Inertia.disc(2.0, 1e-3),
        Inertia.ring(1e3, 10.0),
        random_inertia(rng),
    ):
        assert inertia.placed(random_rotation(rng), rng.normal(size=3)).fault() is None


# ---------------------------------------------------------------- how much rounding is forgiven
def diagonal(mass: float, *moments: float) -> Inertia:
    x, y, z = moments
    return Inertia(mass, (0.0, 0.0, 0.0), (x, 0.0, 0.0, y, 0.0, z))


@pytest.mark.parametrize(("mass", "largest", "counts"), [(1.0, 4.0, 4.0), (2.0, 1e-3, 2.0)])
def test_a_billionth_of_the_largest_is_rounding_and_no_more(
    mass: float, largest: float, counts: float
):
    """Second moments (largest, largest / 4, -s): rounded files have s of the size of their last
    digit."""

    def flat(s: float) -> Inertia:
        x, y, z = largest, largest / 4, -s
        return diagonal(mass, y + z, x + z, x + y)

    assert flat(0.9e-9 * counts).fault() is None
    fault = flat(1.1e-9 * counts).fault()
    assert fault is not None
    assert "break the triangle inequality" in fault


def test_a_moment_is_called_negative_beyond_a_billionth_of_the_largest():
    for small, words in ((0.9e-9, "break the triangle inequality"), (1.1e-9, "is negative")):
        assert words in (diagonal(1.0, -3.0 * small, 1.0, 3.0).fault() or "none")
