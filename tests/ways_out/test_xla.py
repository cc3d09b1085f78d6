"""The interface to XLA that kernels in JAX rest on: its layout, its versions, what happens where it
is another, how batches are laid out for it, and the way of long derivatives.
"""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
import textwrap

import numpy as np
import pytest

import freebody as fb
from freebody.targets.xla import layout
from freebody.targets.xla import operation as xla
from freebody.targets.xla.operation import arranged
from freebody.ways_out import differentials
from freebody.ways_out.differentials import Differentiable
from support.extras import extra

jax = extra("jax", "JAX", "jax")


@pytest.fixture(autouse=True)
def doubles():
    with jax.enable_x64(True):
        yield


@pytest.mark.skipif(not shutil.which("cc"), reason="needs a C compiler, to read JAX's header")
def test_offsets_and_numbers_are_those_of_the_header_that_jax_has(tmp_path):
    rows = [
        *(
            (f"offsetof({kind}, {field})", offset)
            for kind, fields in layout.OFFSETS.items()
            for field, offset in fields.items()
        ),
        *((f"{kind}_STRUCT_SIZE", size) for kind, size in layout.SIZES.items()),
        *layout.NUMBERS.items(),
        ("XLA_FFI_API_MAJOR", layout.MAJOR),
    ]
    lines = [f'printf("%lld\\n", (long long)({text}));' for text, _ in rows]
    program = tmp_path / "layout.c"
    program.write_text(
        '#include <stdio.h>\n#include "xla/ffi/api/c_api.h"\nint main(void) {\n'
        + "\n".join(lines)
        + "\nreturn 0;}\n"
    )
    command = ["cc", "-I", jax.ffi.include_dir(), str(program), "-o", str(tmp_path / "layout")]
    subprocess.run(command, check=True, capture_output=True, timeout=60)
    printed = subprocess.run(
        [str(tmp_path / "layout")], check=True, capture_output=True, text=True, timeout=60
    )
    assert [int(x) for x in printed.stdout.split()] == [known for _, known in rows]


def test_the_version_is_read_from_the_header(tmp_path):
    assert layout.version(jax.ffi.include_dir()) == xla.interface().version
    assert layout.version(str(tmp_path)) is None
    header = tmp_path / "xla" / "ffi" / "api" / "c_api.h"
    header.parent.mkdir(parents=True)
    for text, version, fits in (
        ("#define XLA_FFI_API_MAJOR 0\n#define XLA_FFI_API_MINOR 7\n", (0, 7), True),
        ("#define XLA_FFI_API_MAJOR 1\n#define XLA_FFI_API_MINOR 0\n", (1, 0), False),
        ("#define XLA_FFI_API_MAJOR 0\n", None, False),
        ("", None, False),
    ):
        header.write_text(text)
        assert layout.version(str(tmp_path)) == version
        assert layout.fits(version) is fits


def test_a_call_that_is_laid_out_otherwise_is_an_error():
    kernel = fb.kernel(fb.load("2R"), "inverse_dynamics")
    version = xla.interface().version
    assert version is not None
    name = xla._name(kernel, version)
    good = np.zeros((1, 5, 2))
    shape = jax.ShapeDtypeStruct((1, 5, 2), np.float64)
    assert jax.ffi.ffi_call(name, shape)(good, good, good).shape == (1, 5, 2)
    for wrong in (
        [good, good],
        [good, good, good[0]],
        [good, good, good.astype(np.float32)],
        [good] * 4,
    ):
        with pytest.raises(Exception, match="freebody: a call that is laid out in another way"):
            jax.ffi.ffi_call(name, shape)(*wrong)


@pytest.fixture
def another_interface(monkeypatch):
    known = xla.Interface(None, "XLA's interface to compiled functions has version 1.0, known is 0")
    monkeypatch.setattr("freebody.ways_out.in_jax.interface", lambda: known)
    monkeypatch.setattr(xla, "interface", lambda: known)


def test_with_another_interface_jax_calls_python(another_interface):
    """And says so; all else is the same."""
    model = fb.load("2R")
    rng = np.random.default_rng(2)
    q, qd, qdd = rng.normal(size=(3, 4, 2))
    with pytest.warns(
        UserWarning, match=r"fb.to_jax: XLA's interface .* has version 1.0, known is 0: JAX calls"
    ):
        function = fb.to_jax(model, "inverse_dynamics")
    np.testing.assert_array_equal(
        jax.jit(jax.vmap(jax.vmap(function), (None, 0, None)))(q, np.stack([qd, qdd]), qdd),
        fb.kernel(model, "inverse_dynamics")(q, np.stack([qd, qdd]), qdd),
    )
    slope = jax.vmap(jax.jacrev(function))(q, qd, qdd)
    np.testing.assert_allclose(
        slope, fb.inverse_dynamics_derivatives(model, q, qd, qdd)[0], rtol=1e-12
    )


def test_a_kernel_of_numpy_is_called_too():
    kernel = fb.kernel(fb.load("2R"), "mass_matrix", target="numpy")
    function = fb.to_jax(kernel)
    q = np.array([[0.1, 0.2], [0.3, 0.4]])
    assert "pure_callback" in str(jax.make_jaxpr(function)(q))
    np.testing.assert_array_equal(jax.vmap(function)(q), kernel(q))
    assert jax.jacfwd(function)(q[0]).shape == (2, 2, 2)


def test_on_another_platform_python_is_called():
    """The machine code is for the CPU alone."""
    function = fb.to_jax(fb.load("2R"), "mass_matrix")
    traced = jax.jit(function).trace(np.zeros(2))
    assert "freebody_" in traced.lower(lowering_platforms=("cpu",)).as_text()
    # without a GPU there is no way to Python from it, which is as far as JAX gets here
    with pytest.raises(
        ValueError, match="platform for the specified backend cpu is different from"
    ):
        traced.lower(lowering_platforms=("cuda",))


def test_outputs_of_no_size_and_functions_of_nothing():
    nothing = fb.compile(lambda x: {"y": (), "z": x}, {"x": ()}, {"y": 0, "z": ()})
    y, z = fb.to_jax(nothing)(np.array([1.0, 2.0]))
    assert y.shape == (2, 0)
    np.testing.assert_array_equal(z, [1.0, 2.0])
    constant = fb.compile(lambda: 2.5, {})
    assert float(fb.to_jax(constant)()) == 2.5


NO_JAX = """
    import sys
    sys.modules["jax"] = None
    import freebody as fb
    try:
        fb.to_jax(fb.load("2R"), "bias")
    except fb.FreebodyError as problem:
        print(problem)
"""


def test_without_jax_the_error_says_what_to_install():
    done = subprocess.run(
        [sys.executable, "-c", textwrap.dedent(NO_JAX)],
        capture_output=True,
        text=True,
        timeout=60,
        check=True,
    )
    assert re.search(r"JAX is not installed; pip install 'freebody\[jax\]'", done.stdout)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        (([0.0, 0.0], [0.0, 0.0]), r"2 arguments given, expected 3: q\(2\), qd\(2\), qdd\(2\)"),
        (([0.0], [0.0, 0.0], [0.0, 0.0]), r"q has shape \(1,\), expected \(..., 2\)"),
        (([1j, 0.0], [0.0, 0.0], [0.0, 0.0]), "q holds complex numbers, expected real numbers"),
        ((["first", "second"], [0.0, 0.0], [0.0, 0.0]), "q is not an array of numbers"),
        (
            (np.zeros((3, 2)), np.zeros((2, 2)), [0.0, 0.0]),
            r"batch shapes do not broadcast together: q \(3,\), qd \(2,\), qdd \(\)",
        ),
    ],
)
def test_what_does_not_fit_is_refused_in_words(given, message):
    with pytest.raises(fb.FreebodyError, match=message):
        fb.to_jax(fb.load("2R"), "inverse_dynamics")(*given)


def test_matrices_of_very_many_coordinates_are_refused():
    many = fb.load("R" * 65)
    with pytest.raises(
        fb.FreebodyError, match=r"mass_matrix of 65 coordinates is too long for one program"
    ):
        fb.to_jax(many, "mass_matrix")


def test_batches_become_two_axes():
    """Whatever is laid out means the same entries as before."""
    rng = np.random.default_rng(1)
    for _ in range(15):
        whole = rng.integers(1, 5, size=rng.integers(0, 5))
        shapes = [tuple(int(n) if rng.random() < 0.6 else 1 for n in whole) for _ in range(3)]
        arrays = [rng.normal(size=(*shape, 2)) for shape in shapes]
        size, placed, varies = arranged(arrays, shapes)
        batch = np.broadcast_shapes(*shapes)
        for array, new, many in zip(arrays, placed, varies, strict=True):
            assert new.shape[0] in (1, size[0])
            assert new.shape[1] == (size[1] if many else 1)
            np.testing.assert_array_equal(
                np.broadcast_to(new, (*size, 2)).reshape(*batch, 2),
                np.broadcast_to(array, (*batch, 2)),
            )


def test_derivatives_that_come_in_columns(monkeypatch):
    """As those of a step of a larger robot, whose whole Jacobian would be too long a program: the
    same, also twice."""
    model = fb.load("3R")
    q, qd, tau = np.random.default_rng(3).normal(size=(3, 3))

    def results():
        step = fb.to_jax(model, "semi_implicit_step")

        def end(qd, h):
            return step(q, qd, tau, h)[1]

        first = [way(end, (0, 1))(qd, 0.01) for way in (jax.jacfwd, jax.jacrev)]
        return jax.tree.leaves([*first, jax.jacfwd(jax.jacrev(end))(qd, 0.01)])

    whole = results()
    monkeypatch.setattr(differentials, "LONGEST", 10)
    assert not Differentiable(fb.kernel(model, "semi_implicit_step").program).jacobian((1, 3)).whole
    for one, other in zip(results(), whole, strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-11, atol=1e-13)


def test_equal_kernels_are_given_to_xla_once():
    def given():
        fb.to_jax(fb.load("2R"), "mass_matrix")(np.zeros(2))
        return set(xla._given)

    assert given() == given()
