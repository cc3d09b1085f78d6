"""A user's own functions, compiled: their values, shapes and derivatives, and what they may not
do."""

import inspect
import itertools
import math
import pickle

import numpy as np
import pytest

import freebody as fb
from freebody import FreebodyError, KindError, UnknownNameError
from freebody import math as fm
from support.extras import extra
from support.helpers import raises_own


def law(q, qd, goal, kp, kd):
    """PD with friction compensation, saturated at a limit of each joint."""
    return [
        fm.clip(kp * (g - x) - kd * v + 0.5 * fm.tanh(v / 0.05), -limit, limit)
        for x, v, g, limit in zip(q, qd, goal, (20.0, 20.0, 10.0), strict=True)
    ]


LAW = {"q": 3, "qd": (3,), "goal": (3,), "kp": (), "kd": ()}


def states(n, seed=0):
    rng = np.random.default_rng(seed)
    return *rng.normal(size=(3, n, 3)), rng.uniform(1, 30, n), rng.uniform(0, 3, n)


@pytest.mark.parametrize("target", ["cpu", "numpy"])
def test_a_controller_is_what_it_says(target):
    kernel = fb.compile(law, LAW, {"tau": 3}, target=target)
    given = states(101)
    columns = [x.T for x in given]
    np.testing.assert_allclose(
        kernel(*given), np.stack(law(*columns), axis=-1), rtol=1e-13, atol=1e-13
    )
    assert np.abs(kernel(*given)).max() == 20.0
    assert (np.abs(kernel(*given)).max(axis=0) == [20.0, 20.0, 10.0]).all()


def test_it_is_a_kernel():
    kernel = fb.compile(law, LAW, {"tau": 3})
    given = states(5000)
    whole = kernel(*given)
    out = np.empty_like(whole)
    assert kernel(*given, out=out, threads=2) is out
    np.testing.assert_array_equal(out, whole)
    np.testing.assert_array_equal(
        kernel(*given[:3], 5.0, 1.0)[7], kernel(*(x[7] for x in given[:3]), 5.0, 1.0)
    )
    again = pickle.loads(pickle.dumps(kernel))
    np.testing.assert_array_equal(again(*given), whole)
    bad = given[0].copy()
    bad[3, 1] = np.nan
    assert np.isnan(kernel(bad, *given[1:])).nonzero()[0].tolist() == [3, 3, 3]
    with raises_own(
        ValueError, match=r"law: the batch shapes do not broadcast together: q \(7,\), qd \(5000,\)"
    ):
        kernel(given[0][:7], *given[1:])


@pytest.mark.parametrize(
    ("samples", "out", "words"),
    [
        (0, np.zeros(4), r"law: out has shape \(4,\), expected \(3,\)"),
        (5, np.zeros(3), r"law: out has shape \(3,\), expected \(5, 3\)"),
        (5000, np.zeros((5000, 4)), r"law: out has shape \(5000, 4\), expected \(5000, 3\)"),
        (0, [1.0], r"law: out is list \[1.0\], expected an array of float64 of shape \(3,\)"),
        (0, (np.zeros(3),) * 2, r"law: out holds 2 arrays, expected 1: tau \(3,\)"),
        (0, np.zeros(3, dtype=int), r"law: out holds int64 values, expected float64"),
        (0, np.broadcast_to(0.0, 3), r"law: out cannot be written to; give a copy of it"),
    ],
)
def test_what_cannot_be_written_to_is_said(samples: int, out: object, words: str):
    given = states(samples) if samples else [x[0] for x in states(1)]
    with pytest.raises(fb.FreebodyError, match=words):
        fb.compile(law, LAW, {"tau": 3})(*given, out=out)


def test_in_32_bits():
    given = states(50)
    single = fb.compile(law, LAW, {"tau": 3}, dtype="float32")(*given)
    assert single.dtype == np.float32
    np.testing.assert_allclose(
        single, fb.compile(law, LAW, {"tau": 3})(*given), rtol=1e-5, atol=1e-4
    )


def smooth(x, y, s):
    """Everything with a derivative everywhere, over complex numbers too."""
    r = [
        fm.sin(x[0] * y[0][1]) + fm.exp(-x[1]),
        fm.log(3.0 + x[0] ** 2) * s,
        fm.sqrt(2.0 + x[1]) / (s + 4.0),
    ]
    return {"r": r, "c": fm.tanh(y[1][0] * s) * fm.cos(x[1]) - x[0] ** -2}


def test_derivatives_against_complex_step():
    inputs = {"x": 2, "y": (2, 2), "s": ()}
    kernel = fb.compile(smooth, inputs, by=("s", "x", "y"))
    names = [str(a) for a in kernel.program.outputs]
    assert names == [
        "r(3)", "c()", "dr_ds(3)", "dr_dx(3, 2)", "dr_dy(3, 2, 2)", "dc_ds()", "dc_dx(2)",
        "dc_dy(2, 2)",
    ]  # fmt: skip
    rng = np.random.default_rng(1)
    x, y, s = rng.uniform(0.3, 1, (20, 2)), rng.uniform(0.3, 1, (20, 2, 2)), rng.uniform(0.3, 1, 20)
    found = dict(zip((a.name for a in kernel.program.outputs), kernel(x, y, s), strict=True))
    flat = np.concatenate([s[:, None], x, y.reshape(20, 4)], axis=1)
    step = 1e-200
    for k in range(7):
        z = flat.astype(complex)
        z[:, k] += 1j * step
        moved = smooth(z[:, 1:3].T, z[:, 3:].T.reshape(2, 2, 20), z[:, 0])
        for name, of_s, of_x, of_y, expected in (
            ("r", "dr_ds", "dr_dx", "dr_dy", np.stack(moved["r"], axis=-1)),
            ("c", "dc_ds", "dc_dx", "dc_dy", moved["c"]),
        ):
            core = found[name].shape
            columns = [found[of_s].reshape(*core, 1), found[of_x], found[of_y].reshape(*core, 4)]
            np.testing.assert_allclose(found[name], expected.real, rtol=1e-13)
            np.testing.assert_allclose(
                np.concatenate(columns, axis=-1)[..., k],
                expected.imag / step,
                rtol=1e-12,
                atol=1e-13,
            )


def test_the_derivative_of_a_choice_is_that_of_what_is_chosen():
    kernel = fb.compile(
        lambda x: {
            "a": fm.where(fm.less(x, 0.0), fm.sqrt(x - 1.0), 3.0 * x),
            "b": fm.clip(2.0 * x, -1.0, 1.0),
            "c": abs(x),
        },
        {"x": ()},
        by="x",
    )
    x = np.array([-2.0, -0.25, 0.0, 0.25, 2.0])
    *_, da, db, dc = kernel(x)
    np.testing.assert_array_equal(da, [np.nan, np.nan, 3, 3, 3])
    np.testing.assert_array_equal(db, [0, 2, 2, 2, 0])
    np.testing.assert_array_equal(dc, [-1, -1, 0, 1, 1])


def test_composed_functions_of_every_kind_of_scalar():
    rng = np.random.default_rng(3)
    a, b = rng.normal(size=(2, 400))
    a[:5], b[:5] = [0.0, 0.0, 1.0, -1.0, 1e-300], [0.0, 1.0, 0.0, 0.0, 1e-300]
    b[5:50] = a[5:50]
    expected = {
        "tan": np.tan(a), "atan": np.arctan(a), "clip": np.clip(a, -0.5, 0.25),
        "hypot": np.hypot(a, b),
        "greater": a > b, "greater_equal": a >= b, "not_equal": a != b, "logical_not": a == 0,
        "logical_and": (a != 0) & (b != 0), "logical_or": (a != 0) | (b != 0),
    }  # fmt: skip
    given = {"tan": "a", "atan": "a", "clip": "abc", "logical_not": "a"}
    assert set(expected) == {
        n
        for n, f in vars(fm).items()
        if n in fm.__all__ and getattr(f, "__module__", "") == fm.__name__
    }
    for name, value in expected.items():
        operands = {"a": a, "b": -0.5 if name == "clip" else b, "c": 0.25}
        chosen = [operands[x] for x in given.get(name, "ab")]
        function = getattr(fm, name)
        kernel = fb.compile(
            lambda a, b, f=function, chosen=chosen: f(*(a, b, 0.25)[: len(chosen)]),
            {"a": (), "b": ()},
        )
        np.testing.assert_allclose(function(*chosen), value.astype(float), rtol=1e-15, err_msg=name)
        np.testing.assert_allclose(
            kernel(a, operands["b"]), value.astype(float), rtol=1e-15, err_msg=name
        )


def test_an_infinite_bound_is_none():
    x = np.array([-5.0, 0.0, 5.0])
    for low, high in itertools.product((-np.inf, -1.0), (np.inf, 2.0)):
        kernel = fb.compile(lambda x, low=low, high=high: fm.clip(x, low, high), {"x": ()})
        np.testing.assert_array_equal(kernel(x), np.clip(x, low, high))
        np.testing.assert_array_equal(fm.clip(x, low, high), np.clip(x, low, high))


def test_hypot_neither_overflows_nor_has_a_singular_derivative():
    kernel = fb.compile(fm.hypot, {"x": (), "y": ()}, by=("x", "y"))
    r, dx, dy = kernel(np.array([0.0, 3e200, 3e-200]), np.array([0.0, 4e200, 4e-200]))
    np.testing.assert_allclose(r, [0.0, 5e200, 5e-200], rtol=1e-15)
    np.testing.assert_allclose([dx, dy], [[0, 0.6, 0.6], [0, 0.8, 0.8]], rtol=1e-14)


@pytest.mark.parametrize(
    ("returned", "outputs", "shapes"),
    [
        (lambda x: x[0], None, {"result": ()}),
        (lambda x: x, None, {"result": (2,)}),
        (lambda x: [x, (1.0, x[1])], None, {"result": (2, 2)}),
        (lambda x: np.array([x, x, x]), None, {"result": (3, 2)}),
        (lambda x: np.array(x) @ np.ones((2, 4)), None, {"result": (4,)}),
        (lambda x: np.array(x[0]), None, {"result": ()}),
        (lambda x: {"a": x, "b": 1}, None, {"a": (2,), "b": ()}),
        (lambda x: (x, x[0]), {"a": 2, "b": ()}, {"a": (2,), "b": ()}),
        (lambda x: {"b": x[0], "a": x}, {"a": 2, "b": ()}, {"a": (2,), "b": ()}),
        (lambda x: (x,), {"a": (1, 2)}, {"a": (1, 2)}),
        (lambda x: (), {"a": 0}, {"a": (0,)}),
    ],
)
def test_outputs(returned, outputs, shapes):
    kernel = fb.compile(returned, {"x": 2}, outputs)
    assert {a.name: a.shape for a in kernel.program.outputs} == shapes
    found = kernel(np.ones((3, 2)))
    assert [np.shape(y) for y in (found if isinstance(found, tuple) else (found,))] == [
        (3, *s) for s in shapes.values()
    ]


def endless(x):
    return endless(x)


@pytest.mark.parametrize("by", [(), "x"])
@pytest.mark.parametrize(
    ("function", "message"),
    [
        (
            lambda x: x[0] if x[0] > 0 else x[1],
            r"never on values; freebody.math chooses by value, with where\(",
        ),
        (lambda x: x[0] if x[0] else x[1], "never on values"),
        (lambda x: 1.0 if x[0] == x[1] else 2.0, "== of a traced scalar"),
        (lambda x: 1.0 if x[0] != x[1] else 2.0, "== of a traced scalar"),
        (lambda x: max(x), "a comparison of a traced scalar"),
        (
            lambda x: np.sin(x[0]),
            r"cannot be recorded: .* those of freebody.math \(freebody.math.sin, where, …\)",
        ),
        (lambda x: np.sin(np.array(x)), "those of freebody.math"),
        (lambda x: np.linalg.norm(x), "those of freebody.math"),
        (lambda x: np.linalg.inv(np.array([x, x])), "those of freebody.math"),
        (lambda x: np.ones(3) * x[0], "cannot be recorded: .*np.array makes arrays"),
        (lambda x: math.sin(x[0]), r"float\(\) of a traced scalar|must be real number"),
        (lambda x: math.floor(x[0]), "of a traced scalar|must be real number"),
        (lambda x: [1.0, 2.0][int(x[0])], "cannot be recorded"),
        (lambda x: x[0] ** 0.5, r"whole number from -64 to 64; else there are sqrt\(x\)"),
        (lambda x: x[0] / 0, "division by the constant 0"),
        (lambda x: x[0] * math.inf, "constants must be finite"),
        (lambda x: x[0] * 10**5000, "beyond 1.8e308 .*: constants must be finite"),
        (lambda x: fb.kernel(fb.load("2R"), "bias")(x, x), r"expected real numbers\. "),
        (lambda x: fm.log(x[0] * 0), r"log\(0.0\) has no finite value"),
        (endless, "endless calls itself without end"),
    ],
)
def test_what_a_function_may_not_do(function, message, by):
    with raises_own(TypeError, match=message):
        fb.compile(function, {"x": 2}, by=by)


def test_scalars_of_another_trace_are_refused():
    kept = []
    fb.compile(lambda x: kept.append(x) or x, {"x": ()})
    with raises_own(TypeError, match="scalars of two traces were mixed"):
        fb.compile(lambda x: x + kept[0], {"x": ()})
    with raises_own(TypeError, match="scalars of two traces were mixed"):
        fb.compile(lambda x: kept[0], {"x": ()})


@pytest.mark.parametrize(
    ("returned", "outputs", "message"),
    [
        (lambda x: None, None, "returned result with NoneType None where a scalar was expected"),
        (lambda x: "ab", None, "returned result with str 'ab' where a scalar"),
        (
            lambda x: (x, x[0]),
            None,
            r"entries of different shapes, \(2,\) and \(\). Several outputs are returned as a dict",
        ),
        (lambda x: 1j, None, "returned result with complex 1j"),
        (lambda x: x, {"a": 3}, r"returned a of shape \(2,\), expected \(3,\)"),
        (lambda x: (x,), {"a": 2}, r"returned a of shape \(1, 2\), expected \(2,\)"),
        (
            lambda x: (x, x),
            {"a": 2, "b": 2, "c": 2},
            r"returned 2 values, expected a tuple of a\(2\), b\(2\) and c\(2\)",
        ),
        (lambda x: 1.0, {"a": 2, "b": 2}, r"returned float, expected a tuple of a\(2\) and b\(2\)"),
        (
            lambda x: {"a": x},
            {"a": 2, "b": 2},
            r"returned a dict of a, expected one of a\(2\) and b\(2\)",
        ),
        (lambda x: {}, {"a": 2}, r"returned a dict of nothing, expected one of a\(2\)"),
    ],
)
def test_results_that_do_not_fit(returned, outputs, message):
    with raises_own(ValueError, match=message):
        fb.compile(returned, {"x": 2}, outputs)


@pytest.mark.parametrize(
    ("arguments", "error", "message"),
    [
        ((3, {"x": 2}), KindError, "fb.compile: function is int 3, expected a function of scalars"),
        (
            (lambda x: x, ["x"]),
            KindError,
            r"inputs is list \['x'\], expected a dict of names and core shapes",
        ),
        (
            (lambda x: x, {"x": 2}, {}),
            KindError,
            "outputs is dict {}, expected a dict of names and core shapes",
        ),
        (
            (lambda x: x, {"x": -1}),
            FreebodyError,
            r"core shape of input x is -1, expected .*: \(6,\) for a vector",
        ),
        ((lambda x: x, {"x": 2.5}), FreebodyError, "core shape of input x is 2.5"),
        ((lambda x: x, {"x": True}), FreebodyError, "core shape of input x is True"),
        ((lambda x: x, {"x": "6"}), FreebodyError, "core shape of input x is '6'"),
        ((lambda x: x, {"x": (2, None)}), FreebodyError, r"core shape of input x is \(2, None\)"),
        (
            (lambda **k: 1.0, {"x[0]": 2}),
            FreebodyError,
            r"input name 'x\[0\]' is not a word of letters a-z",
        ),
        ((lambda x: x, {"x": 2}, {"a\n": 2}), FreebodyError, "output name"),
        ((lambda x: {"a-b": x}, {"x": 2}), FreebodyError, "output name 'a-b' is not a word"),
        (
            (lambda x, y: x, {"x": 2}),
            FreebodyError,
            r"compiled\(x, y\) is called with its inputs by name, x: missing .* 'y'",
        ),
        (
            (lambda x: x, {"x": 2, "y": 2}),
            FreebodyError,
            r"compiled\(x\) is called with its inputs by name, x and y",
        ),
    ],
)
def test_arguments_are_checked(arguments, error, message):
    with pytest.raises(error, match=message):
        fb.compile(*arguments)


def test_differentiation_by_what_is_there():
    with pytest.raises(UnknownNameError, match="no input 'z' in by="):
        fb.compile(lambda x: x, {"x": 2}, by="z")
    with raises_own(
        ValueError, match="da_dx is both an output of compiled and a derivative; rename it"
    ):
        fb.compile(lambda x: {"a": x, "da_dx": x}, {"x": 2}, by="x")
    assert len(fb.compile(lambda x: x, {"x": 2}, by=("x", "x")).program.outputs) == 2


def test_numbers_and_arrays_take_the_same_functions():
    assert fm.clip(3.0, -1.0, 1.0) == 1.0
    assert fm.where(fm.less(1, 2), 5.0, 6.0) == 5.0
    np.testing.assert_array_equal(fm.maximum(np.arange(3), 1), [1, 1, 2])
    assert fm.pi == math.pi
    assert fb.math is fm


# ---------------------------------------------------------------- formulas inside
def computed_torque(arm):
    inverse = fb.formula(arm, "inverse_dynamics")

    def law(q, qd, goal, kp, kd):
        return inverse(q, qd, [kp * (g - x) - kd * v for x, v, g in zip(q, qd, goal, strict=True)])

    return law


def test_a_law_with_the_dynamics_inside():
    arm = fb.load("ur5e")
    n, inputs = 6, {"q": 6, "qd": 6, "goal": 6, "kp": (), "kd": ()}
    q, qd, goal = np.random.default_rng(0).normal(size=(3, 40, n))
    asked = 30.0 * (goal - q) - 4.0 * qd
    tau, by_q, by_qd = fb.compile(computed_torque(arm), inputs, {"tau": 6}, by=("q", "qd"))(
        q, qd, goal, 30.0, 4.0
    )
    np.testing.assert_allclose(tau, fb.inverse_dynamics(arm, q, qd, asked), rtol=1e-12, atol=1e-11)
    of_q, of_qd, M = fb.inverse_dynamics_derivatives(arm, q, qd, asked)
    np.testing.assert_allclose(by_q, of_q - 30.0 * M, rtol=1e-11, atol=1e-11)
    np.testing.assert_allclose(by_qd, of_qd - 4.0 * M, rtol=1e-11, atol=1e-11)


@pytest.mark.sample(1)
@pytest.mark.parametrize(
    ("robot", "name", "options"),
    [
        ("ur5e", "mass_matrix", {}),
        ("ur5e", "jacobian", {"frame": "wrist_3_link", "reference": "body"}),
        ("ur5e", "inverse_dynamics", {"wrench_frames": ["wrist_3_link", "forearm_link"]}),
        ("2R", "forward_dynamics", {}),
        ("2R", "kinetic_energy", {}),  # a number, no vector
        ("2R", "inverse_dynamics_derivatives", {}),
        ("five_bar", "forward_dynamics", {}),
    ],
)
def test_formulas_are_the_kernels(robot, name, options):
    model = fb.load(robot)
    kernel, function = fb.kernel(model, name, **options), fb.formula(model, name, **options)
    inputs = {a.name: a.shape for a in kernel.program.inputs}
    parameters = [inspect.Parameter(x, inspect.Parameter.POSITIONAL_OR_KEYWORD) for x in inputs]

    def called(**given):
        found = function(*(given[x] for x in inputs))
        names = [a.name for a in kernel.program.outputs]
        return dict(zip(names, found if len(names) > 1 else (found,), strict=True))

    called.__signature__ = inspect.Signature(parameters)
    own = fb.compile(called, inputs)
    rng = np.random.default_rng(2)
    given = [rng.normal(size=(9, *shape)) for shape in inputs.values()]
    expected = kernel(*given)
    columns = [np.moveaxis(x, 0, -1) for x in given]  # arrays over the samples
    direct = function(*columns)
    if not isinstance(expected, tuple):
        expected, direct = (expected,), (direct,)
    results = own(*given) if len(expected) > 1 else (own(*given),)
    for found, by_arrays, exact in zip(results, direct, expected, strict=True):
        np.testing.assert_allclose(found, exact, rtol=1e-11, atol=1e-11)
        np.testing.assert_allclose(
            np.broadcast_to(by_arrays_stacked(by_arrays), exact.shape), exact, rtol=1e-9, atol=1e-9
        )


def by_arrays_stacked(nested):
    """Nested tuples of arrays over the samples, the samples first."""
    if not isinstance(nested, tuple):
        return np.broadcast_to(nested, 9)
    return np.stack([by_arrays_stacked(x) for x in nested], axis=1)


def test_formulas_say_what_is_wrong():
    arm = fb.load("2R")
    function = fb.formula(arm, "inverse_dynamics")
    with pytest.raises(
        FreebodyError,
        match=r"inverse_dynamics: 2 arguments given, expected 3: q\(2\), qd\(2\), qdd\(2\)",
    ):
        function([0, 0], [0, 0])
    with pytest.raises(
        FreebodyError, match=r"inverse_dynamics: qd has shape \(3,\), expected \(2,\)"
    ):
        function([0, 0], [0, 0, 0], [0, 0])
    with pytest.raises(FreebodyError, match=r"inverse_dynamics: q has shape \(\), expected \(2,\)"):
        function(0.0, [0, 0], [0, 0])
    with pytest.raises(FreebodyError, match="give the name of one quantity"):
        fb.formula(arm, ["bias", "mass_matrix"])
    with pytest.raises(UnknownNameError, match="no quantity 'inertia'"):
        fb.formula(arm, "inertia")
    with pytest.raises(
        FreebodyError, match=r"formula: .2R. is a family of robots, .*take a member, model\[0\]"
    ):
        fb.formula(arm.bind({"m1": [1.0, 2.0]}), "bias")
    with pytest.raises(
        KindError, match=r"formula: the first argument is str 'ur5e', expected a Model"
    ):
        fb.formula("ur5e", "bias")


# ---------------------------------------------------------------- ways out
def test_own_functions_go_out_as_text_and_to_jax(tmp_path):
    kernel = fb.compile(smooth, {"x": 2, "y": (2, 2), "s": ()}, by="x")
    rng = np.random.default_rng(4)
    given = [rng.uniform(0.3, 1, (7, *shape)) for shape in ((2,), (2, 2), ())]
    expected = kernel(*given)
    scope: dict = {}
    exec(fb.source(kernel), scope)
    ways = [scope["smooth"](*given)]
    jax = extra("jax", "JAX", "jax")
    with jax.enable_x64(True):
        ways.append([np.asarray(x) for x in fb.to_jax(kernel)(*given)])
        by_jax = jax.vmap(jax.jacfwd(lambda *x: fb.to_jax(kernel)(*x)[0]))(*given)
    for results in ways:
        for found, exact in zip(results, expected, strict=True):
            np.testing.assert_allclose(found, exact, rtol=1e-13, atol=1e-13)
    np.testing.assert_allclose(by_jax, expected[2], rtol=1e-12, atol=1e-13)
    with pytest.raises(
        FreebodyError, match=r"fb.to_jax: a kernel has its quantities already; give no names"
    ):
        fb.to_jax(kernel, "bias")
    with pytest.raises(
        FreebodyError, match=r"to_jax: give the quantities, such as 'inverse_dynamics'"
    ):
        fb.to_jax(fb.load("2R"))


@pytest.mark.parametrize(
    ("inputs", "outputs", "by", "words"),
    [
        ({"q": 10**9}, None, (), "the inputs have 1000000000 entries, at most 1000000"),
        ({"q": (1000, 1000), "s": ()}, None, (), "the inputs have 1000001 entries"),
        ({"q": 2}, {"y": 10**9}, (), "the outputs have 1000000000 entries"),
        ({"q": 1200}, {"y": 1200}, "q", "the derivatives of y have 1440000 entries"),
    ],
)
def test_sizes_that_no_memory_holds_are_refused_before_it_is_taken(inputs, outputs, by, words):
    with pytest.raises(fb.FreebodyError, match=words):
        fb.compile(lambda **x: x["q"], inputs, outputs, by=by)
