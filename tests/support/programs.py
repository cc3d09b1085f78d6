"""Functions of scalars made by chance, compiled and on plain arrays."""

from __future__ import annotations

import numpy as np

import freebody as fb
from freebody.math import (
    absolute,
    acos,
    atan2,
    cos,
    exp,
    less,
    less_equal,
    log,
    maximum,
    minimum,
    sign,
    sin,
    sqrt,
    tanh,
    where,
)

INPUTS = {"x": (3,), "A": (2, 5), "s": ()}
OUTPUTS = {"y": (4,), "B": (3, 3), "t": ()}


def random_function(seed, length=60):
    """A function of x (3), A (2, 5) and s () with outputs y (4), B (3, 3), t (), bounded so that
    errors stay small."""

    def function(x, A, s):
        rng = np.random.default_rng(seed)
        pool = [*x, *A[0], *A[1], s, 0.0, 1.0, -2.5]
        operations = [
            lambda a, b: 0.5 * (a + b),
            lambda a, b: a - 0.7 * b,
            lambda a, b: sin(a) * b,
            lambda a, b: cos(a) * sin(a) - cos(b),
            lambda a, b: a * b / (2.0 + b * b),
            lambda a, b: b / (1.0 + a**2),
            lambda a, b: sqrt(1.0 + a * a),
            lambda a, b: -a,
            lambda a, b: sign(a - b) * 0.5,
            lambda a, b: sin(sin(a + b)),
            lambda a, b: where(less(a, b), a, 0.5 * b),
            lambda a, b: maximum(minimum(a, 0.8), -absolute(b)),
            lambda a, b: atan2(a, 1.5 + sin(b)) * exp(-b * b),
            lambda a, b: tanh(a) + log(1.0 + b * b),
            lambda a, b: acos(a / (1.0 + absolute(a))) - 1.5 * less_equal(b, a),
        ]
        for _ in range(length):
            a, b = (pool[i] for i in rng.integers(len(pool), size=2))
            pool.append(operations[rng.integers(len(operations))](a, b))
        picks = [pool[i] for i in rng.integers(len(pool), size=14)]
        return picks[:4], [picks[4:7], picks[7:10], picks[10:13]], picks[13]

    function.__name__ = f"random{seed}"
    return function


def random_kernel(seed, length=60, **options):
    """It compiled; options as for fb.compile."""
    return fb.compile(random_function(seed, length), INPUTS, OUTPUTS, **options)


def random_program(seed, length=60):
    """Its program."""
    return random_kernel(seed, length, target="numpy").program


def swap(q):
    """Entries change places."""
    return [q[1], 2.0 * q[0], q[2]]


def swap_kernel(**options):
    """`swap` of three numbers, compiled."""
    return fb.compile(swap, {"q": 3}, {"r": 3}, **options)


def samples(batch, seed=0):
    rng = np.random.default_rng(seed)
    return [
        rng.normal(scale=2.0, size=(*np.atleast_1d(batch).astype(int), *shape))
        for shape in INPUTS.values()
    ]


def direct(seed, arrays, length=60):
    """The same function on plain arrays, one column a scalar."""
    x, A, s = arrays
    batch = np.broadcast_shapes(x.shape[:-1], A.shape[:-2], s.shape)
    columns = [x[..., i] for i in range(3)], [[A[..., i, j] for j in range(5)] for i in range(2)], s
    y, B, t = random_function(seed, length)(*columns)

    def stacked(value, shape):
        flat = (
            [np.broadcast_to(v, batch) for v in np.asarray(value, dtype=object).ravel()]
            if shape
            else [value]
        )
        return np.stack(flat, axis=-1).reshape(batch + shape)

    y = np.stack([np.broadcast_to(v, batch) for v in y], axis=-1)
    B = np.stack([np.broadcast_to(v, batch) for row in B for v in row], axis=-1).reshape(
        *batch, 3, 3
    )
    return y, B, np.broadcast_to(t, batch)


def assert_close(results, expected, tolerance=1e-11):
    for result, reference in zip(results, expected, strict=True):
        assert result.shape == reference.shape
        np.testing.assert_allclose(result, reference, rtol=tolerance, atol=tolerance)


def same_bits(left, right):
    left, right = (x if isinstance(x, tuple) else (x,) for x in (left, right))
    return all(
        np.array_equal(np.asarray(x).view(np.int64), np.asarray(y).view(np.int64))
        for x, y in zip(left, right, strict=True)
    )
