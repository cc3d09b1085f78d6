"""Programs of derivatives against complex steps of the program itself, the ways to them against
each other, and programs of gradients (reverse mode) against derivatives by slopes (forward mode).
"""

from __future__ import annotations

import sys

import numpy as np
import pytest

import freebody as fb
from freebody import FreebodyError, elementary
from freebody.math import atan2, log, maximum, sin, sqrt, where
from freebody.program import Argument, trace
from freebody.program.derivative import applied, applied_back, directional, gradient, jacobian
from freebody.program.program import evaluated
from freebody.scalars.operations import OPERATIONS
from freebody.targets import compile_program, settings
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


@pytest.mark.sample(4)
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


@pytest.fixture(autouse=True)
def without_compiling(monkeypatch):
    monkeypatch.setattr(settings, "TARGET", "numpy")


def weighted(program, by, of, arrays, weights):
    """Σ w ∂y/∂x from the whole Jacobian."""
    tables = compile_program(jacobian(program, by))(*arrays)
    tables = tables if isinstance(tables, tuple) else (tables,)
    found = []
    for k, place in enumerate(by):
        total = 0.0
        for weight, output in zip(weights, of, strict=True):
            table = np.asarray(tables[output * len(by) + k])
            core = len(program.outputs[output].shape)
            axes = program.inputs[place].shape
            flat = (-1, *(program.outputs[output].shape or (1,)), *axes)
            w = np.reshape(
                weight, (-1, *(program.outputs[output].shape or (1,)), *(1,) * len(axes))
            )
            total = total + (np.reshape(table, flat) * w).sum(
                axis=tuple(range(1, 1 + max(core, 1)))
            )
        found.append(total)
    return found


def gradients_agree(program, by, of, seed=0, given=None):
    rng = np.random.default_rng(seed)
    arrays = given or [rng.normal(size=(5, *argument.shape)) for argument in program.inputs]
    weights = [rng.normal(size=(5, *program.outputs[k].shape)) for k in of]
    made = compile_program(gradient(program, by, of))(*arrays, *weights)
    made = made if isinstance(made, tuple) else (made,)
    for found, expected in zip(made, weighted(program, by, of, arrays, weights), strict=True):
        np.testing.assert_allclose(found, expected.reshape(found.shape), rtol=1e-9, atol=1e-9)


QUANTITIES = {
    "inverse dynamics": ("ur5e", "inverse_dynamics", {}),
    "forward dynamics with a load": ("2R", "forward_dynamics", {"wrench_frames": ["tip"]}),
    "a free base": ("quadrotor", "forward_dynamics", {}),
    "several outputs": ("2R", ["jacobian", "kinetic_energy", "mass_matrix"], {}),
    "a closed chain": ("four_bar", "forward_dynamics", {}),
    "a step": ("2R", "rk4_step", {}),
    "numbers of the robot": ("2R", "inverse_dynamics", {"inputs": ["link*.mass", "gravity"]}),
    "a derivative": ("2R", "inverse_dynamics", {"by": "q"}),
}


@pytest.mark.parametrize(("robot", "names", "options"), QUANTITIES.values(), ids=QUANTITIES)
def test_a_gradient_is_the_weighted_sum_of_derivatives(robot, names, options):
    program = fb.kernel(fb.load(robot), names, **options).program
    every, outputs = tuple(range(len(program.inputs))), tuple(range(len(program.outputs)))
    gradients_agree(program, every, outputs)
    gradients_agree(program, every[-1:], outputs[:1])


def test_the_gradient_of_a_gradient():
    program = fb.kernel(fb.load("2R"), "inverse_dynamics").program
    first = gradient(program, (0, 1), (0,))
    gradients_agree(first, (0, 1, 2, 3), (0, 1))
    gradients_agree(gradient(first, (0, 3), (1,)), (0, 1, 4), (0, 1))


@pytest.mark.parametrize("name", sorted(elementary.FUNCTIONS))
def test_every_function(name):
    arity = OPERATIONS[name].arity
    inputs = [Argument(x, ()) for x in "xyz"[:arity]]
    program = trace(
        "f", lambda *x: (elementary.FUNCTIONS[name](*x) * x[0],), inputs, [Argument("r", ())]
    )
    given = list(np.random.default_rng(3).uniform(0.1, 0.9, (arity, 5)))
    gradients_agree(program, tuple(range(arity)), (0,), given=given)


def test_it_is_no_longer_than_a_few_times_the_program_whatever_it_has_inputs():
    """A law of reverse mode (Baur and Strassen): at most five operations for one, whatever the
    number of inputs."""
    for robot in ("ur5e", "panda"):
        program = fb.kernel(fb.load(robot), "inverse_dynamics").program
        made = gradient(program, (0, 1, 2), (0,))
        assert sum(made.operations.values()) <= 5 * sum(program.operations.values())


# ---------------------------------------------------------------- choices
def slopes(function, names, x):
    """Of each argument, at each sample."""
    inputs = [Argument(name, ()) for name in names]
    program = trace("f", lambda *values: (function(*values),), inputs, [Argument("r", ())])
    made = gradient(program, tuple(range(len(names))), (0,))
    columns = [np.asarray(column, dtype=float) for column in x]
    found = compile_program(made)(*columns, np.ones(len(columns[0])))
    return [a.tolist() for a in (found if isinstance(found, tuple) else (found,))]


def test_what_is_not_chosen_has_no_part_in_the_gradient_though_its_derivative_be_infinite():
    x = [[0.0, 4.0, -1.0]]
    root = lambda x: where(x, 1.0, 0.0) * where(elementary.less(0.0, x), sqrt(x), 2.0 * x)
    assert slopes(root, "x", x) == [[0.0, 0.25, 2.0]]
    power = lambda x: where(elementary.less(0.0, x), x * log(x), 0.0)
    assert slopes(power, "x", [[0.0, 1.0]]) == [[0.0, 1.0]]
    share = lambda x, y: where(y, x / y, x)
    assert slopes(share, "xy", [[3.0, 3.0], [0.0, 2.0]]) == [[1.0, 0.5], [0.0, -0.75]]
    angle = lambda x, y: where(elementary.absolute(x) + elementary.absolute(y), atan2(y, x), 0.0)
    assert slopes(angle, "xy", [[0.0, 1.0], [0.0, 0.0]]) == [[0.0, 0.0], [0.0, 1.0]]


def test_a_choice_inside_another():
    def nested(x):
        inner = where(elementary.less(1.0, x), sqrt(x - 1.0), 3.0 * x)
        return where(elementary.less(0.0, x), log(x) * inner, 5.0 * x + maximum(x, -2.0))

    (found,) = slopes(nested, "x", [[2.0, 1.0, 0.5, 0.0, -3.0]])
    expected = [0.5 + np.log(2.0) * 0.5, 3.0, 3.0 + 3.0 * np.log(0.5), 6.0, 5.0]
    np.testing.assert_allclose(found, expected, rtol=1e-14)


def test_a_value_that_is_chosen_here_and_always_there():
    def both(x):
        root = sqrt(x)
        return where(elementary.less(x, 1.0), root, 1.0) + 2.0 * root

    assert slopes(both, "x", [[0.25, 4.0]]) == [[3.0, 0.5]]


def test_a_value_that_is_chosen_by_two():
    def two(x):
        root = sqrt(x)
        return where(elementary.less(x, 1.0), root, 0.0) + where(
            elementary.less(2.0, x), 2.0 * root, 0.0
        )

    assert slopes(two, "x", [[0.25, 1.5, 4.0]]) == [[1.0, 0.0, 0.5]]


def test_the_gradient_by_weights_that_are_zero():
    """Its derivative by the weight is what the weight is a factor of; to skip zeros would lose
    it."""
    program = trace(
        "f",
        lambda x: (where(elementary.less(0.0, x), sqrt(x), sin(x)),),
        [Argument("x", ())],
        [Argument("r", ())],
    )
    second = gradient(gradient(program, (0,), (0,)), (1,), (0,))
    assert compile_program(second)([4.0, 0.0], [0.0, 0.0], [1.0, 1.0]).tolist() == [0.25, 1.0]


# ---------------------------------------------------------------- PyTorch, which runs them
def test_without_pytorch(monkeypatch):
    for name in ("torch", "torch.autograd"):
        monkeypatch.setitem(sys.modules, name, None)
    monkeypatch.delitem(sys.modules, "freebody.targets.torch_operator", raising=False)
    with pytest.raises(FreebodyError, match=r"pip install 'freebody\[torch\]'"):
        fb.to_torch(fb.load("2R"), "bias")
