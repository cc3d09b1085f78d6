"""Programs, the half-way product of the compiler: what is traced, checked, printed, and changed by
its passes.

No public function makes a program that is wrong, or shows one between two passes; so these are
called by themselves.
"""

from __future__ import annotations

import dataclasses
import itertools
import math

import pytest

from freebody.math import sin, where
from freebody.program import Argument, Program, ProgramError, passes, trace, verify
from freebody.targets import compile_program
from support.programs import (
    assert_close,
    direct,
    random_program,
    samples,
    swap_kernel,
)


def test_a_program_prints_and_counts():
    program = trace(
        "f",
        lambda q, m: ([sin(q[0]) * m, -3.0],),
        [Argument("q", (2,)), Argument("m", ())],
        [Argument("r", (2,))],
    )
    assert program.listing().splitlines() == [
        "f: q(2), m() -> r(2)",
        "  %0 = q[0]",
        "  %1 = m",
        "  %2 = sin %0",
        "  %3 = mul %1 %2",
        "  %4 = -3.0",
        "  r[0] = %3",
        "  r[1] = %4",
    ]
    assert str(program) == "f: q(2), m() -> r(2); 1 mul, 1 sin"
    assert program.operations == {"sin": 1, "mul": 1}


def test_the_digest_is_of_the_content():
    a, b = (swap_kernel(target="numpy").program for _ in range(2))
    assert a.digest == b.digest
    assert dataclasses.replace(a, constants=(3.0,)).digest != a.digest
    assert dataclasses.replace(a, name="other").digest != a.digest
    chosen = trace(
        "f", lambda q: (where(q[0], q[1], q[2]),), [Argument("q", (3,))], [Argument("r", ())]
    )
    assert dataclasses.replace(chosen, c=tuple(min(k, 1) for k in chosen.c)).digest != chosen.digest


@pytest.mark.parametrize(
    ("returned", "message"),
    [
        (lambda x: x[0], r"f: the traced function returned Expr, expected a tuple .*: r\(2\)"),
        (
            lambda x: (x, x),
            r"returned 2 values, expected a tuple with one entry for each output: r\(2\)",
        ),
        (lambda x: (x[0],), r"output r\(2\) holds a scalar where a sequence of 2 was expected"),
        (lambda x: ((x[0],) * 3,), r"output r\(2\) holds a tuple of 3 where a sequence of 2"),
        (lambda x: ((x[0], "a"),), r"output r\(2\) holds a str of 1|holds str 'a' where a scalar"),
        (lambda x: ((x[0], x),), r"output r\(2\) holds a tuple of 2 where a scalar was expected"),
        (
            lambda x: ((x[0], None),),
            r"output r\(2\) holds NoneType None where a scalar was expected",
        ),
    ],
)
def test_what_a_traced_function_returns_is_checked(returned, message):
    with pytest.raises(ProgramError, match=message):
        trace("f", returned, [Argument("x", (2,))], [Argument("r", (2,))])


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"op": ("input", "input", "magic")}, "unknown operation 'magic'; known: input, const"),
        ({"a": (0, 7, 0)}, "input 7 of 3"),
        ({"a": (0, 1, 2)}, "an operand precedes its use"),
        ({"b": (-1, -1, 2)}, "an operand precedes its use"),
        ({"b": (-1, -1, -1)}, "an operand precedes its use"),
        ({"b": (-1, 0, 1)}, "input 1 of 3"),
        (
            {"c": (-1, -1, 0)},
            r"%2 = add: it has 2 operands, what is left of \(a, b, c\) = \(0, 1, 0\) is -1",
        ),
        ({"b": (-1, -1)}, "op, a, b and c have one entry a node"),
        ({"c": (-1, -1)}, "op, a, b and c have one entry a node"),
        ({"results": (0, 1, 3)}, "a result is a node"),
        ({"results": (0, 1)}, "3 output scalars need as many results"),
        ({"constants": (math.inf,)}, "constants are finite"),
        ({"outputs": ()}, "at least one output"),
        (
            {"inputs": (Argument("q", (3,)), Argument("q", ()))},
            "names of inputs are used once: q, q",
        ),
        ({"inputs": (Argument("q", (-1,)),)}, "negative size"),
    ],
)
def test_the_specification_of_a_program(change, message):
    valid = Program(
        "p",
        (Argument("q", (3,)),),
        (Argument("r", (3,)),),
        ("input", "input", "add"),
        (0, 1, 0),
        (-1, -1, 1),
        (),
        (0, 1, 2),
    )
    assert verify(valid) is valid
    with pytest.raises(ProgramError, match=message):
        verify(dataclasses.replace(valid, **change))


@pytest.mark.parametrize("name", passes.PASSES)
def test_a_pass_keeps_the_meaning(name):
    for seed in range(5):
        program = random_program(seed)
        changed = verify(passes.PASSES[name](program))
        arrays = samples(50)
        assert_close(compile_program(changed, target="numpy")(*arrays), direct(seed, arrays))


def test_quotients_by_one_denominator_share_its_reciprocal():
    program = trace(
        "f", lambda x: ([x[0] / x[2], x[1] / x[2]],), [Argument("x", (3,))], [Argument("y", (2,))]
    )
    assert passes.share_reciprocals(program).operations == {"div": 1, "mul": 2}
    single = trace(
        "f", lambda x: ([x[0] / x[2], x[1] / x[0]],), [Argument("x", (3,))], [Argument("y", (2,))]
    )
    assert passes.share_reciprocals(single) is single


def test_the_schedule_keeps_few_values_alive():
    def sums(x):  # made breadth first: all products, then all sums
        products = [a * b for a, b in itertools.combinations(x, 2)]
        while len(products) > 1:
            products = [
                a + b
                for a, b in itertools.zip_longest(products[::2], products[1::2], fillvalue=0.0)
            ]
        return (products[0],)

    program = trace("sums", sums, [Argument("x", (20,))], [Argument("y", ())])
    assert most_alive(program) > 90
    assert most_alive(passes.schedule(program)) < 15


def most_alive(program):
    last = {i: k for k in range(len(program)) for i in program.operands(k)}
    alive, most = 0, 0
    for k, op in enumerate(program.op):
        ended = sum(
            last[i] == k and program.op[i] not in ("input", "const")
            for i in set(program.operands(k))
        )
        alive += (op not in ("input", "const")) - ended
        most = max(most, alive)
    return most
