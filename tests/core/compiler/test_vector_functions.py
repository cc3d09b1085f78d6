"""Exponential, logarithm, hyperbolic tangent and inverse trigonometric functions in vector code
against mpmath, sine and cosine against integer arithmetic of 1400 bits.

A CPU without fused multiply-add has to be feigned, so the host is patched; each function is traced
by itself.
"""

import dataclasses
import itertools
import math
import sys
from fractions import Fraction

import numpy as np
import pytest

import freebody as fb
from freebody.elementary import FUNCTIONS
from freebody.math import cos, sin
from freebody.program import Argument, trace
from freebody.targets import compile_program
from freebody.targets.llvm import machine
from freebody.targets.llvm.machine import Machine
from support.extras import extra

mpmath = extra("mpmath")

LARGEST = {"exp": 0.8, "log": 0.8, "tanh": 1.4, "atan2": 1.4, "asin": 0.7, "acos": 0.7}
"""Error in units of the last place; the documentation states the next whole number."""
EXACT = {
    "exp": mpmath.exp,
    "log": mpmath.log,
    "tanh": mpmath.tanh,
    "atan2": mpmath.atan2,
    "asin": mpmath.asin,
    "acos": mpmath.acos,
}
SPECIAL = (
    0.0,
    -0.0,
    5e-324,
    -5e-324,
    1e-310,
    0.5,
    -0.5,
    1.0,
    -1.0,
    2.0,
    -2.0,
    1e300,
    -1.7e308,
    math.inf,
    -math.inf,
    math.nan,
)


pytestmark = pytest.mark.usefixtures("memory_only")


def compiled(name, arity=1, width=None, title=None, of=lambda *x: x):
    """The function of a name of its inputs, or of what `of` makes of them."""
    inputs = [Argument(x, ()) for x in "xyzuvw"[:arity]]
    program = trace(
        title or f"just_{name}", lambda *x: (FUNCTIONS[name](*of(*x)),), inputs, [Argument("r", ())]
    )
    return compile_program(program, target="cpu", width=width)


def anywhere(rng, n):
    """Finite doubles of any exponent."""
    x = rng.integers(0, 2**63, 2 * n, dtype=np.int64).view(np.float64)
    return x[np.isfinite(x)][:n] * rng.choice([-1.0, 1.0], n)


def near(rng, centre, n):
    """On both sides of a number, at all distances."""
    return centre + rng.choice([-1.0, 1.0], n) * 10.0 ** rng.uniform(-17, -0.3, n)


def samples(name, rng, n):
    """Arguments of the function, the places among them where its code changes its way, and the ends
    of its domain."""
    if name == "exp":
        ends = [
            709.782712893384,
            709.7827128933841,
            -708.3964185322641,
            -745.1332191019411,
            -745.1332191019412,
        ]
        return (
            np.concatenate(
                [
                    rng.uniform(-746, 710, n),
                    rng.uniform(-1, 1, n),
                    near(rng, 0, n),
                    anywhere(rng, n),
                    ends,
                ]
            ),
        )
    if name == "log":
        subnormal = rng.integers(1, 2**52, n) * 5e-324
        ends = [
            5e-324,
            2.2250738585072014e-308,
            math.sqrt(0.5),
            math.sqrt(2.0),
            1.7976931348623157e308,
        ]
        return (
            np.concatenate(
                [
                    abs(anywhere(rng, n)),
                    rng.uniform(0.5, 2, n),
                    abs(near(rng, 1, n)),
                    subnormal,
                    ends,
                ]
            ),
        )
    if name == "tanh":
        return (
            np.concatenate(
                [
                    anywhere(rng, n),
                    rng.uniform(-20, 20, n),
                    near(rng, 0.625, n),
                    rng.uniform(0, 1, n),
                    [0.625],
                ]
            ),
        )
    if name == "atan2":
        y, x = (
            np.concatenate([rng.normal(size=n), anywhere(rng, n), near(rng, 0, n)])
            for _ in range(2)
        )
        borders = rng.choice([0.4375, 0.6875, 1.0, 16 / 11, 16 / 7], 3 * n) * near(rng, 1, 3 * n)
        huge, ratio = (
            rng.uniform(2.0**1022, 2.0**1023, n),
            rng.uniform(0.3, 3.0, n),
        )  # their sums overflow
        return np.concatenate([y, 0.25 * x * borders, huge * 0.5 * ratio]), np.concatenate(
            [x, 0.25 * x, huge]
        )
    inside = np.concatenate(
        [rng.uniform(-1, 1, n), near(rng, 0, n), near(rng, 0.5, n), -near(rng, 0.5, n)]
    )
    ends = 1.0 - 10.0 ** rng.uniform(-16, -1, n)
    return (
        np.concatenate(
            [
                inside[abs(inside) <= 1],
                ends,
                -ends,
                anywhere(rng, n) * 2.0**-1024,
                [1.0, -1.0, 0.5, -0.5],
            ]
        ),
    )


def errors(name, kernel, columns):
    """Error of each sample in units of the last place of the exact value, the largest double for
    what is beyond it."""
    found = kernel(*columns)
    assert found.dtype == np.float64
    with mpmath.workprec(140):
        for row in zip(found.tolist(), *(c.tolist() for c in columns), strict=True):
            exact = EXACT[name](*map(mpmath.mpf, row[1:]))
            nearest = float(exact)
            if math.isinf(nearest):
                yield 0.0 if row[0] == nearest else math.inf, row
            else:
                yield float(abs(exact - row[0]) / math.ulp(nearest)), row


@pytest.mark.sample(4)
@pytest.mark.parametrize("width", [2, 4, 8])
@pytest.mark.parametrize("name", LARGEST)
def test_within_the_stated_error(name, width):
    columns = samples(name, np.random.default_rng(width), 150)
    worst, row = max(errors(name, compiled(name, len(columns), width), columns))
    assert worst <= LARGEST[name], row


def test_angles_of_every_octant_have_all_digits():
    """What pi/2, pi/4 and atan 1/2 lack as doubles is added: without it the error of these passes
    1."""
    y, x = np.random.default_rng(7).normal(size=(2, 3000))
    beyond = abs(np.arctan2(y, x)) > 0.42
    worst, row = max(errors("atan2", compiled("atan2", 2), (y[beyond], x[beyond])))
    assert worst <= 0.9, row


@pytest.mark.parametrize("name", LARGEST)
def test_without_fused_multiply_add(name, monkeypatch):
    whole = machine.Host.machine
    monkeypatch.setattr(
        machine.Host, "machine", lambda *a, **k: dataclasses.replace(whole(*a, **k), fma=False)
    )
    columns = samples(name, np.random.default_rng(1), 150)
    kernel = compiled(name, len(columns), 4, f"bare_{name}")
    assert "@llvm.fma.v4f64(<4 x double> %" not in kernel.source
    worst, row = max(errors(name, kernel, columns))
    assert worst <= LARGEST[name], row


@pytest.mark.long
@pytest.mark.parametrize("name", LARGEST)
def test_within_the_stated_error_everywhere(name):
    columns = samples(name, np.random.default_rng(5), 50_000)
    worst, row = max(errors(name, compiled(name, len(columns)), columns))
    assert worst <= LARGEST[name], row


@pytest.mark.sample(5)
@pytest.mark.parametrize("width", [2, 4, 8])
@pytest.mark.parametrize("name", LARGEST)
def test_special_values_are_those_of_c(name, width):
    """Zeros with their signs, infinities and NaN, made inside: an input that is not finite is
    another matter."""
    arity = 2 if name == "atan2" else 1
    kernel = compiled(
        name,
        2 * arity,
        width,
        f"special_{name}",
        lambda *x: [a / b for a, b in zip(x[::2], x[1::2], strict=True)],
    )
    quotients = {
        math.inf: (1.0, 0.0),
        -math.inf: (-1.0, 0.0),
        math.nan: (0.0, 0.0),
    }
    rows = list(itertools.product(SPECIAL, repeat=arity))
    columns = [
        np.array(c)
        for c in zip(
            *([p for x in row for p in quotients.get(x, (x, 1.0))] for row in rows), strict=True
        )
    ]
    wanted = {"atan2": np.arctan2, "asin": np.arcsin, "acos": np.arccos}.get(name) or getattr(
        np, name
    )
    with np.errstate(all="ignore"):
        expected = wanted(*np.array(rows).T)
    found = kernel(*columns)
    np.testing.assert_array_equal(np.isnan(found), np.isnan(expected))
    number = ~np.isnan(expected)
    np.testing.assert_array_equal(np.signbit(found[number]), np.signbit(expected[number]))
    np.testing.assert_allclose(found[number], expected[number], rtol=5e-16, atol=5e-324)


@pytest.mark.sample(1)
@pytest.mark.parametrize("name", LARGEST)
def test_functions_stand_in_long_programs(name):
    """Many calls, in several segments, beside sines: the same bits as one call of each."""
    arity = 2 if name == "atan2" else 1
    rng = np.random.default_rng(3)
    columns = rng.uniform(0.1, 0.9, (200, arity, 13))
    flat = columns.reshape(200 * arity, 13).T

    def many(x):
        calls = [
            FUNCTIONS[name](*(FUNCTIONS["sin"](v) for v in x[arity * k : arity * (k + 1)]))
            for k in range(200)
        ]
        return (calls,)

    program = trace("many", many, [Argument("x", (200 * arity,))], [Argument("r", (200,))])
    sines = compile_program(
        trace("s", lambda x: (FUNCTIONS["sin"](x),), [Argument("x", ())], [Argument("r", ())])
    )
    np.testing.assert_array_equal(
        compile_program(program)(flat).T,
        compiled(name, arity)(*(sines(columns[:, k]) for k in range(arity))),
    )


@pytest.mark.parametrize("name", LARGEST)
def test_of_uniform_inputs_once_a_call(name):
    """The code for a single lane gives the bits that the vector code gives."""
    arity = 2 if name == "atan2" else 1
    x = np.random.default_rng(4).uniform(0.1, 0.9, (30, arity))
    program = trace(
        f"uniform_{name}",
        lambda p, y: (FUNCTIONS[name](*p) + 0.0 * y, y),
        [Argument("p", (arity,), uniform=True), Argument("y", ())],
        [Argument("r", ()), Argument("s", ())],
    )
    kernel = compile_program(program)
    once = [kernel(row, np.zeros(3))[0] for row in x]
    np.testing.assert_array_equal(np.array(once)[:, 0], compiled(name, arity)(*x.T))


@pytest.mark.parametrize("name", LARGEST)
def test_float32_is_the_double_rounded(name):
    """Within half a unit in the last place and a little: computed in doubles, rounded at the
    end."""
    arity = 2 if name == "atan2" else 1
    rng = np.random.default_rng(6)
    columns = [rng.uniform(0.01, 0.99, 4000).astype(np.float32) for _ in range(arity)]
    inputs = [Argument(x, ()) for x in "xy"[:arity]]
    program = trace(
        f"single_{name}", lambda *x: (FUNCTIONS[name](*x),), inputs, [Argument("r", ())]
    )
    found = compile_program(program, dtype="float32")(*columns)
    assert found.dtype == np.float32
    exact = compiled(name, arity)(*(c.astype(float) for c in columns))
    assert (abs(found - exact) / np.spacing(abs(exact).astype(np.float32))).max() <= 0.5001


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


@pytest.mark.sample(1)
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


@pytest.mark.sample(1)
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


def test_sine_and_cosine_without_fused_multiply_add(monkeypatch):
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
