"""Sine and cosine of kernels against integer arithmetic of 1400 bits.

A CPU without fused multiply-add has to be feigned: that test patches what is known of the host.
"""

from __future__ import annotations

import math
import sys
from fractions import Fraction

import numpy as np
import pytest

import freebody as fb
from freebody.math import cos, sin
from freebody.targets.llvm import machine
from freebody.targets.llvm.machine import Machine

pytestmark = pytest.mark.usefixtures("memory_only")


BITS = 1400  # fixed point: 1024 bits for the largest double, the rest for its smallest sine


def _arctangent_of_inverse(n):
    power = (1 << BITS) // n
    total, k = power, 3
    while power:
        power //= -n * n
        total, k = total + power // k, k + 2
    return total


HALF_PI = 8 * _arctangent_of_inverse(5) - 2 * _arctangent_of_inverse(239)


def exact_sine_and_cosine(x):
    """Sine and cosine of a double as fractions, by integer arithmetic."""
    fixed = int(Fraction(x) * 2**BITS)
    turns = (2 * fixed + HALF_PI) // (2 * HALF_PI)
    r = fixed - turns * HALF_PI
    terms, k = [1 << BITS], 1
    while terms[-1]:
        terms.append((terms[-1] * r >> BITS) // k)
        k += 1
        if terms[-1] == -1:
            break
    c = sum(t * (-1) ** (i // 2) for i, t in enumerate(terms) if i % 2 == 0)
    s = sum(t * (-1) ** (i // 2) for i, t in enumerate(terms) if i % 2 == 1)
    s, c = {0: (s, c), 1: (c, -s), 2: (-s, -c), 3: (-c, s)}[turns % 4]
    return Fraction(s, 2**BITS), Fraction(c, 2**BITS)


def ulps(value, exact):
    return abs(Fraction(float(value)) - exact) / Fraction(math.ulp(float(exact)))


def both(width):
    """A kernel of sine and cosine."""
    return fb.compile(
        lambda x: (sin(x), cos(x)), {"x": ()}, {"s": (), "c": ()}, target="cpu", width=width
    )


@pytest.mark.parametrize("width", [2, 4, 8])
def test_sine_and_cosine_within_two_ulp(width):
    rng = np.random.default_rng(1)
    halves = np.arange(1, 63662, 97) * (math.pi / 2)  # where cancellation is worst
    x = np.concatenate(
        [
            rng.uniform(-1e5, 1e5, 400),
            rng.uniform(-4, 4, 400),
            halves[:600],
            np.nextafter(halves[:200], 0.0),
            np.arange(-40, 40) * (math.pi / 4),
            10.0 ** rng.uniform(-310, 5, 100),
            [1e-300, 5e-324, 1e5, -1e5, 99999.99999999999, 0.7853981633974483, 0.785398163397448],
        ]
    )
    for value, s, c in zip(x, *both(width)(x), strict=True):
        sine, cosine = exact_sine_and_cosine(value)
        assert ulps(s, sine) <= 2, value
        assert ulps(c, cosine) <= 2, value


@pytest.mark.parametrize("width", [2, 4, 8])
def test_sine_and_cosine_of_large_arguments(width):
    rng = np.random.default_rng(2)
    x = np.concatenate(
        [
            [
                1e5 * (1 + 1e-15),
                1e15,
                -1e15,
                1e16,
                1e100,
                1e300,
                -sys.float_info.max,
                6381956970095103 * 2.0**797,
            ],
            10.0 ** rng.uniform(5, 308, 200),
        ]
    )
    x = np.stack([x, rng.uniform(-3, 3, len(x))], axis=1).ravel()  # large and small in one vector
    for value, s, c in zip(x, *both(width)(x), strict=True):
        sine, cosine = exact_sine_and_cosine(value)
        assert ulps(s, sine) <= 4, value
        assert ulps(c, cosine) <= 4, value


def test_sine_keeps_the_sign_of_zero():
    s, c = both(8)(np.array([0.0, -0.0, -5e-324]))
    assert np.signbit(s).tolist() == [False, True, True]
    assert c.tolist() == [1.0, 1.0, 1.0]


@pytest.mark.parametrize("width", [2, 4, 8])
def test_overflow_before_a_sine_is_nan(width):
    compiled = fb.compile(
        lambda x: (sin(x * x), cos(x * x)), {"x": ()}, {"s": (), "c": ()}, target="cpu", width=width
    )
    s, c = compiled(np.array([1e200, 1.0]))
    assert np.isnan([s[0], c[0]]).all()
    assert np.isfinite([s[1], c[1]]).all()


def test_without_fused_multiply_add(monkeypatch):
    monkeypatch.setattr(
        machine.Host, "machine", lambda self, width, real: Machine(4, False, self.x86, real)
    )
    compiled = fb.compile(
        lambda x: (sin(x), cos(x)), {"x": ()}, {"sine": (), "cosine": ()}, target="cpu", width=4
    )
    assert "@llvm.fma.v4f64(<4 x double> %" not in compiled.source
    rng = np.random.default_rng(3)
    halves = np.arange(1, 63662, 211) * (math.pi / 2)
    x = np.concatenate([rng.uniform(-1e5, 1e5, 300), halves, [-0.0, 1e-300, 1e15]])
    for value, s, c in zip(x, *compiled(x), strict=True):
        sine, cosine = exact_sine_and_cosine(value)
        assert ulps(s, sine) <= 2, value
        assert ulps(c, cosine) <= 2, value
