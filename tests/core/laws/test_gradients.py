"""Programs of gradients (reverse mode) against those of derivatives by slopes (forward mode)."""

from __future__ import annotations

import sys

import numpy as np
import pytest

import freebody as fb
from freebody import FreebodyError, elementary
from freebody.math import atan2, log, maximum, sin, sqrt, where
from freebody.program import Argument, trace
from freebody.program.derivative import gradient, jacobian
from freebody.scalars.operations import OPERATIONS
from freebody.targets import compile_program, settings


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


def agree(program, by, of, seed=0, given=None):
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
    agree(program, every, outputs)
    agree(program, every[-1:], outputs[:1])


def test_the_gradient_of_a_gradient():
    program = fb.kernel(fb.load("2R"), "inverse_dynamics").program
    first = gradient(program, (0, 1), (0,))
    agree(first, (0, 1, 2, 3), (0, 1))
    agree(gradient(first, (0, 3), (1,)), (0, 1, 4), (0, 1))


@pytest.mark.parametrize("name", sorted(elementary.FUNCTIONS))
def test_every_function(name):
    arity = OPERATIONS[name].arity
    inputs = [Argument(x, ()) for x in "xyz"[:arity]]
    program = trace(
        "f", lambda *x: (elementary.FUNCTIONS[name](*x) * x[0],), inputs, [Argument("r", ())]
    )
    given = list(np.random.default_rng(3).uniform(0.1, 0.9, (arity, 5)))
    agree(program, tuple(range(arity)), (0,), given=given)


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
