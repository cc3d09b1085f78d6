"""Programs of derivatives against complex steps of the program itself, and the ways to them against
each other."""

from __future__ import annotations

import numpy as np
import pytest

import freebody as fb
from freebody.program.derivative import applied, applied_back, directional, jacobian
from freebody.program.evaluate import evaluated
from freebody.targets import compile_program
from freebody.ways_out import differentials
from freebody.ways_out.differentials import Differentiable, length, of_quantities
from freebody.ways_out.kernel import requested

STEP = 1e-30


def by_complex_steps(program, by, arrays):
    """The derivatives of each output by each of some inputs, for one sample, of functions that
    NumPy has for complex numbers."""
    found = []
    for k in by:
        columns = []
        for place in np.ndindex(arrays[k].shape):
            moved = [array.astype(complex) for array in arrays]
            moved[k][place] += 1j * STEP
            outputs = evaluated(program, [as_tuples(array) for array in moved])
            columns.append([np.imag(np.array(output, dtype=complex)) / STEP for output in outputs])
        found.append(
            [
                np.stack(parts, axis=-1).reshape(*parts[0].shape, *arrays[k].shape)
                for parts in zip(*columns, strict=True)
            ]
        )
    return [found[j][i] for i in range(len(program.outputs)) for j in range(len(by))]


def as_tuples(array):
    return tuple(map(as_tuples, array)) if array.ndim else array[()]


def given(program, seed=5):
    rng = np.random.default_rng(seed)
    return [rng.normal(size=argument.shape) for argument in program.inputs]


def quantity(model, names, **options):
    meant = requested("test", model, names, options)
    return of_quantities(meant), meant.given


CASES = {
    "inverse dynamics": ("ur5e", "inverse_dynamics", {}),
    "forward dynamics": ("2R", "forward_dynamics", {}),
    "forward dynamics of a free base": ("quadrotor", "forward_dynamics", {}),
    "inverse dynamics of a free base": ("quadrotor", "inverse_dynamics", {}),
    "wrenches": ("ur5e", "inverse_dynamics", {"wrench_frames": ["wrist_3_link"]}),
    "several": ("2R", ["inverse_dynamics", "mass_matrix", "kinetic_energy"], {}),
    "a closed chain": ("four_bar", "forward_dynamics", {}),
    "a step": ("2R", "rk4_step", {}),
}


@pytest.mark.parametrize(("robot", "names", "options"), CASES.values(), ids=CASES)
def test_jacobians_are_those_by_complex_steps(robot, names, options):
    """Also of quaternions off unit length, by all four of their coordinates."""
    function, _ = quantity(fb.load(robot), names, **options)
    program = function.program
    arrays = given(program)
    every = tuple(range(len(program.inputs)))
    for by in [*((k,) for k in every), every]:
        expected = by_complex_steps(program, by, arrays)
        assert function.jacobian(by).whole
        for way in function.ways(by):
            agree(run(way, arrays), expected)
        agree(columns(program, by, arrays), expected)


def test_jacobians_times_vectors():
    """And their transpose: products of the matrices themselves."""
    function, _ = quantity(fb.load("2R"), ["inverse_dynamics", "mass_matrix", "kinetic_energy"])
    program, by, of = function.program, (0, 1), (0, 2)
    arrays, rng = given(program), np.random.default_rng(3)
    table = jacobian(program, by)
    tables = run(table, arrays)
    matrix = {k: np.hstack([tables[2 * k + j].reshape(-1, 2) for j in range(2)]) for k in of}
    rates = rng.normal(size=(2, 3, 2))
    for k, made in zip(of, run(applied(table, program, by, of, 3), [*arrays, *rates]), strict=True):
        expected = matrix[k] @ np.hstack(rates).T
        np.testing.assert_allclose(made, expected.reshape(*program.outputs[k].shape, 3), rtol=1e-12)
    weights = rng.normal(size=(3, 2)), rng.normal(size=3)
    found = run(applied_back(table, program, by, of, 3), [*arrays, *weights])
    expected = weights[0] @ matrix[0] + weights[1][:, None] * matrix[2]
    np.testing.assert_allclose(np.hstack(found), expected, rtol=1e-12)


def five_links():
    ones = [1.0] * 5
    return fb.planar("RRRRR", l=ones, lc=ones, m=ones, I=ones)


def test_which_products_are_in_the_program():
    """Those of a transpose up to two thirds of it, others up to half; none that make it too
    long."""
    of_five, _ = quantity(five_links(), "inverse_dynamics")
    entries, own = 5 * 15, length(of_five.jacobian((0, 1, 2)).function.program)
    assert own < 2 * 5 * entries < 2 * own < 2 * 15 * entries
    assert of_five.applied((0, 1, 2), (0,), 5, back=True)
    assert not of_five.applied((0, 1, 2), (0,), 15, back=True)
    assert not of_five.applied((0, 1, 2), (0,), 5)
    assert of_five.applied((0, 1, 2), (0,), 2)


def test_products_do_not_make_a_long_program_longer(monkeypatch):
    of_five, _ = quantity(five_links(), "inverse_dynamics")
    own = length(of_five.jacobian((0, 1, 2)).function.program)
    monkeypatch.setattr(differentials, "LONGEST", own + 2 * 5 * 5 * 15 - 1)
    assert not of_five.applied((0, 1, 2), (0,), 5, back=True)
    monkeypatch.setattr(differentials, "LONGEST", own)
    assert of_five.applied((0, 1, 2), (0,), 2, back=True)


def run(program, arrays):
    results = compile_program(program, target="numpy")(*arrays)
    return results if isinstance(results, tuple) else (results,)


def columns(program, by, arrays):
    """The Jacobian from what unit vectors do."""
    along = compile_program(directional(program, by), target="numpy")
    found = []
    for k in by:
        shape = program.inputs[k].shape
        size = program.inputs[k].size
        rates = [
            np.eye(size).reshape(size, *shape) if j == k else np.zeros(program.inputs[j].shape)
            for j in by
        ]
        results = along(*arrays, *rates)
        results = results if isinstance(results, tuple) else (results,)
        found.append([np.moveaxis(x, 0, -1).reshape(*x.shape[1:], *shape) for x in results])
    return [found[j][i] for i in range(len(program.outputs)) for j in range(len(by))]


def agree(found, expected):
    for result, wanted in zip(found, expected, strict=True):
        np.testing.assert_allclose(
            result, wanted, rtol=1e-10, atol=1e-11 * (np.abs(wanted).max() + 1e-300)
        )


def test_derivatives_by_numbers_of_the_model_and_of_derivatives():
    """By p, and twice; the mass matrix is linear in the masses."""
    model = fb.load("ur5e")
    function, inputs = quantity(model, "inverse_dynamics", inputs=["*.mass", "forearm_link.com.x"])
    arrays = [*given(function.program)[:3], np.array(inputs.values)]
    twice = function.jacobian((0,)).function.jacobian((3,))
    agree(
        run(twice.function.program, arrays),
        by_complex_steps(function.jacobian((0,)).function.program, (3,), arrays),
    )


def test_the_shorter_way_is_taken():
    """Of a robot with many joints the formula's; of one input those parts of it that count."""
    model = fb.load("panda")
    inverse, _ = quantity(model, "inverse_dynamics")
    whole = differentials.length(inverse.jacobian((0, 1, 2)).function.program)
    assert whole < 0.7 * differentials.length(jacobian(inverse.program, (0, 1, 2)))
    assert differentials.length(inverse.jacobian((2,)).function.program) < 0.2 * whole


def test_what_would_be_too_long_comes_in_columns():
    function, _ = quantity(fb.load("panda"), "rk4_step")
    found = function.jacobian((0, 1))
    assert not found.whole
    assert differentials.length(found.function.program) < differentials.LONGEST
    arrays = given(function.program)
    assert found.function.program.inputs[-1].shape == arrays[1].shape


def test_inputs_may_have_any_names():
    kernel = fb.compile(lambda along0, slope0_0: along0 * slope0_0, {"along0": (), "slope0_0": ()})
    function = Differentiable(kernel.program)
    assert [float(x) for x in run(function.jacobian((0, 1)).function.program, [2.0, 3.0])] == [
        3.0,
        2.0,
    ]
    assert [float(x) for x in run(directional(kernel.program, (0,)), [2.0, 3.0, 5.0])] == [15.0]
