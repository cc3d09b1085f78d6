"""Text in other languages: compiled or run by the language's own tool, it gives what the kernel
gives.

Which languages there are, and their tables of words and operations, `targets.text` says; a program
of every operation, and one laid out as no robot asks for, are traced here.
"""

from __future__ import annotations

import ctypes
import dataclasses
import json
import os
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
import typer

import freebody as fb
from freebody.cli.app import app
from freebody.kernels.formulas import FORMULAS
from freebody.math import epsilon, less, less_equal, maximum, minimum, sign, sin, sqrt, where
from freebody.program import Argument, Program, trace
from freebody.scalars.expr import Expr
from freebody.scalars.operations import OPERATIONS
from freebody.targets.text import LANGUAGES, SourceUnit
from freebody.targets.text.language import called
from freebody.targets.text.statements import Spelling, lines, statements, words_of
from freebody.ways_out.exports import vectors
from freebody.ways_out.program_description import MEANINGS
from support.browser import browser
from support.closed_chains import built, ring
from support.command import run
from support.exported import NEEDS, TOOL, passes, require, self_test
from support.extras import extra
from support.generate import model as mechanism


def module_of(language: str) -> ModuleType:
    """The file of a language."""
    emit = LANGUAGES[language].emit
    return sys.modules[getattr(emit, "func", emit).__module__]


def having(table: str) -> list[str]:
    """Languages whose file has a table or bound of that name: a new one is among them by itself."""
    return [language for language in LANGUAGES if hasattr(module_of(language), table)]


def package(program: Program, folder: Path, language: str, dtype: str = "float64") -> None:
    """As fb.export does it, of any program."""
    files = LANGUAGES[language].package(
        SourceUnit(program, program.name, dtype=dtype), vectors(program, dtype)
    )
    for name, text in files.items():
        (folder / name).write_text(text, encoding="ascii")


def compiled(folder: Path, word: str) -> ctypes.CDLL:
    """The C of a package as a library."""
    command = ["cc", "-std=c99", "-O1", "-shared", "-fPIC", f"{word}.c", "-o", f"{word}.so", "-lm"]
    subprocess.run(command, cwd=folder, check=True)
    return ctypes.CDLL(str(folder / f"{word}.so"))


def pointer(array: np.ndarray) -> ctypes._Pointer:
    return array.ctypes.data_as(ctypes.POINTER(ctypes.c_double))


ROBOTS = {
    "arm": lambda: fb.load("ur5e"),
    "plane": lambda: fb.planar(
        "RPR", l=[0.4, 0.3, 0.2], lc=[0.2, 0.1, 0.1], m=[2, 1, 1], I=[0.1, 0.1, 0.1]
    ),
    "stewart": lambda: fb.load("stewart"),
}


# ---------------------------------------------------------------- each language runs
@pytest.mark.sample(1)
@pytest.mark.parametrize("language", [x for x in LANGUAGES if x not in ("casadi", "jax", "cuda")])
def test_a_package_passes_its_own_test_and_its_test_can_fail(language, tmp_path):
    fb.export(
        ROBOTS["plane"](), ("inverse_dynamics", "mass_matrix", "kinetic_energy"), tmp_path, language
    )
    word = "inverse_dynamics_mass_matrix_kinetic_energy"
    require(language)
    passes(tmp_path, language, word)
    wrong = 0
    for path in tmp_path.glob(f"{word}.*"):
        text = path.read_text(encoding="ascii")
        path.write_text(text.replace("9.81", "9.8101"), encoding="ascii")
        wrong += text.count("9.81")
    assert wrong
    done = self_test(tmp_path, language, word)
    assert done.returncode != 0, done.stdout
    assert "FAILED" in done.stdout


@pytest.mark.sample(2)
@pytest.mark.parametrize("language", having("FUNCTIONS"))
def test_no_input_has_the_name_of_a_function_that_the_text_calls(language, tmp_path):
    module = module_of(language)
    names = sorted(called(module.FUNCTIONS, getattr(module, "_HELPERS", {})) - {"if"})[:24]
    law = fb.compile(
        lambda **x: {"y": fb.math.minimum(sum(map(fb.math.tanh, x.values())), 1.0)},
        dict.fromkeys(names, ()),
    )
    fb.export(law, out=tmp_path, language=language, name="law")
    require(language)
    passes(tmp_path, language, "law")


def everything() -> Program:
    """Every operation there is, on inputs of every shape."""

    def body(q, k, A):
        known = {1: (q[0],), 2: (q[0], A[1][1]), 3: (q[0], A[0][1], k)}
        made = []
        for op, record in OPERATIONS.items():
            operands = known[record.arity]
            if op in ("sqrt", "log", "asin", "acos"):
                operands = (operands[0] * operands[0] / 8.0 + 0.25,)
            graph = operands[0].graph
            made.append(Expr(graph, record.node(graph, *(x.index for x in operands))))
        total = sum(made[1:], made[0])
        # NaN that arises on the way is not hidden, is not 0, and is less than nothing
        nan = sqrt(-1.0 - k * k)
        later = k + 17.25  # operands that may be swapped are ordered by age
        made += [less(f(x, nan), 99.0) for f in (minimum, maximum) for x in (1.0, later)]
        made += [where(nan, 2.0, 3.0), less(nan, 5.0), less_equal(5.0, nan)]
        made += [less(epsilon(k), x) for x in (2e-16, 3e-16, 1.1e-7, 1.3e-7)]
        return (
            made,
            [[total, -total, q[1]], [k, 0.0, -2.5e-7]],
            [q[0] - (k - A[0][0]) / (A[1][0] - q[1])],
            k,
            [],
        )

    outputs = [
        Argument("y", (len(OPERATIONS) + 11,)),
        Argument("Y", (2, 3)),
        Argument("z", (1,)),
        Argument("s", ()),
    ]
    inputs = [Argument("q", (2,)), Argument("k", ()), Argument("A", (2, 2)), Argument("none", (0,))]
    return trace(
        "everything",
        lambda q, k, A, _: body(q, k, A),
        inputs,
        [*outputs, Argument("nothing", (0,))],
    )


@pytest.mark.sample(1)
@pytest.mark.parametrize("language", LANGUAGES)
def test_every_operation_in_every_language(language, tmp_path):
    program = everything()
    assert set(program.operations) == set(OPERATIONS)
    for dtype in LANGUAGES[language].dtypes:
        package(program, tmp_path, language, dtype)
        if shutil.which(TOOL[language]):
            if language in NEEDS:
                extra(NEEDS[language])
            passes(tmp_path, language, "everything")
    require(language)


FLATTENED = {
    "numpy": (".reshape(*batch, 2, 2)", ""),
    "jax": (".reshape(*batch, 2, 2)", ""),
    "casadi": ("ca.vertcat(ca.horzcat", "ca.horzcat(ca.horzcat"),
    "matlab": ("end\n", "  M = M(:);\nend\n"),
}
"""Of languages whose arrays have shapes, what makes a matrix a row of its entries."""


@pytest.mark.sample(2)
@pytest.mark.parametrize("language", FLATTENED)
def test_a_matrix_that_lost_its_shape_fails_its_test(language, tmp_path):
    written = fb.export(fb.load("2R"), "mass_matrix", tmp_path, language)
    require(language)
    passes(tmp_path, language, "mass_matrix")
    text = written[0].read_text(encoding="ascii")
    changed = text.replace(*FLATTENED[language])
    assert changed != text
    written[0].write_text(changed, encoding="ascii")
    for compiled in tmp_path.rglob("__pycache__/*.pyc"):  # of the same size, in the same second
        compiled.unlink()
    done = self_test(tmp_path, language, "mass_matrix")
    assert done.returncode != 0
    assert "FAILED" in done.stdout


@pytest.mark.parametrize("language", ["casadi", "numpy"])
def test_inputs_that_are_matrices(language, tmp_path):
    fb.export(ROBOTS["arm"](), "inverse_kinematics", tmp_path, language)
    require(language)
    passes(tmp_path, language, "inverse_kinematics")


@pytest.mark.sample(1)
@pytest.mark.parametrize("language", having("LONGEST"))
def test_long_programs_are_cut_and_compute_the_same(language, tmp_path, monkeypatch):
    monkeypatch.setattr(module_of(language), "LONGEST", 60)
    fb.export(ROBOTS["arm"](), ("forward_dynamics", "mass_matrix"), tmp_path, language, name="cut")
    text = "".join(path.read_text() for path in tmp_path.glob("cut.*"))
    assert len(set(re.findall(r"cut_part\d+", text))) > 10
    require(language)
    passes(tmp_path, language, "cut")


def test_a_language_that_marks_its_variables_marks_each():
    spelling = Spelling(
        dict.fromkeys(OPERATIONS, "f({a})") | {"atan2": "f({a}, {b})"},
        repr,
        lambda word, argument, k: f"${word}[{k}]",
        lambda word, argument, k: f"${word}[{k}]",
        "my ${word} = {text};",
        "{word} = {text};",
        "",
        variable="${word}",
    )
    unit = SourceUnit(everything(), "everything")
    words = words_of(unit, ())
    written = "\n".join(lines(statements(unit, words, spelling, ()), spelling, ""))
    assert len(re.findall(r"\$\w", written)) > 100
    assert not re.search(r"(?<![\w$.])(?!my |f\()[a-z]\w*", written)  # no word without its mark


# ---------------------------------------------------------------- C beside the kernel
@pytest.mark.sample(1)
@pytest.mark.parametrize("robot", ROBOTS)
@pytest.mark.parametrize("dtype", ["float64", "float32"])
def test_c_gives_what_the_kernel_gives(robot, dtype, tmp_path):
    require("c")
    model = ROBOTS[robot]()
    names = [
        "forward_dynamics",
        "mass_matrix",
        "constraint_jacobian" if model.loops else "inverse_dynamics",
    ]
    fb.export(model, names, tmp_path, dtype=dtype, name="f")
    passes(tmp_path, "c", "f")
    if dtype == "float32":
        return
    kernel = fb.kernel(
        model, names, target="numpy" if model.loops else None
    )  # LLVM takes seconds for that
    given = vectors(kernel.program, dtype, model).inputs
    expected = kernel(*given)
    library = compiled(tmp_path, "f")
    for i in range(len(given[0])):
        outs = [np.zeros(argument.shape) for argument in kernel.program.outputs]
        assert (
            library.f(*(pointer(np.ascontiguousarray(x[i])) for x in given), *map(pointer, outs))
            == 0
        )
        for found, wanted in zip(outs, expected, strict=True):
            np.testing.assert_allclose(found, wanted[i], rtol=0, atol=1e-12 * np.abs(wanted).max())


def test_arrays_of_c_may_overlap_and_what_is_not_finite_gives_nan(tmp_path):
    require("c")
    model = ROBOTS["arm"]()
    fb.export(model, "inverse_dynamics", tmp_path)
    library = compiled(tmp_path, "inverse_dynamics")
    q, qd, qdd = fb.random_state(model, 1)
    expected = fb.inverse_dynamics(model, q, qd, qdd)
    shared = qdd.copy()
    assert library.inverse_dynamics(pointer(q), pointer(qd), pointer(shared), pointer(shared)) == 0
    np.testing.assert_allclose(shared, expected, atol=1e-12 * np.abs(expected).max())
    for bad in (np.nan, np.inf, -np.inf):
        tau, wrong = np.zeros(6), qd.copy()
        wrong[5] = bad
        assert library.inverse_dynamics(pointer(q), pointer(wrong), pointer(qdd), pointer(tau)) == 1
        assert np.isnan(tau).all()


@pytest.mark.parametrize("language", ["c", "javascript"])
def test_an_input_that_is_a_result_is_read_before_anything_is_written(language, tmp_path):
    require(language)
    x, y = Argument("x", (4,)), Argument("y", (4,))

    def turned(x):
        product = x[0] * x[1]  # read once, and a result
        return ([x[1], product, product + x[2], x[0]],)

    program = trace("turned", turned, [x], [y])
    package(program, tmp_path, language)
    if language == "c":
        values = np.array([1.0, 2.0, 3.0, 4.0])
        assert compiled(tmp_path, "turned").turned(pointer(values), pointer(values)) == 0
        assert values.tolist() == [2.0, 2.0, 5.0, 1.0]
    else:
        text = (
            'import { turned } from "./turned.mjs"; const x = [1, 2, 3, 4]; turned(x, x); '
            "console.log(String(x));"
        )
        (tmp_path / "try.mjs").write_text(text)
        done = subprocess.run(
            ["node", "try.mjs"], cwd=tmp_path, capture_output=True, text=True, check=True
        )
        assert done.stdout.strip() == "2,2,5,1"


def test_a_ring_that_does_not_close_near_every_random_position(tmp_path):
    """One of the forty tries of this ring closes nowhere; the export was refused, as if it were
    singular everywhere."""
    made = ring(1)
    model = built(made, [pin.name for pin in made.pins[:-1]])
    fb.export(model, "semi_implicit_step", tmp_path, "numpy")
    passes(tmp_path, "numpy", "semi_implicit_step")


@pytest.mark.sample(1)
@pytest.mark.parametrize(
    ("language", "closed"), [("c", False), ("javascript", True), ("matlab", True), ("numpy", False)]
)
def test_every_quantity(language, closed, tmp_path):
    """Of a robot with a quaternion, and of a linkage, all in one text."""
    require(language)
    model = fb.load("five_bar") if closed else mechanism(24)
    assert closed or model.nq > model.nv
    loops = ("constraint", "constrained_dynamics", "reaction_wrenches")
    own = "closed" if closed else "open"
    names = [
        x
        for x in FORMULAS
        if FORMULAS[x].chains in ("all", own) and (closed or not x.startswith(loops))
    ]
    long = ("second_derivatives", "parameter_derivatives")  # each longer than all others together
    fb.export(model, [x for x in names if not x.endswith(long)], tmp_path, language, name="f")
    passes(tmp_path, language, "f")


DUAL = """#include "inverse_dynamics.hpp"
#include <cstdio>
struct Dual {
    double value, slope;
    Dual(double v = 0.0, double s = 0.0) : value(v), slope(s) {}
};
inline Dual operator+(Dual a, Dual b) { return Dual(a.value + b.value, a.slope + b.slope); }
inline Dual operator-(Dual a, Dual b) { return Dual(a.value - b.value, a.slope - b.slope); }
inline Dual operator-(Dual a) { return Dual(-a.value, -a.slope); }
inline Dual operator*(Dual a, Dual b)
{
    return Dual(a.value*b.value, a.slope*b.value + a.value*b.slope);
}
inline bool operator==(Dual a, Dual b) { return a.value == b.value; }
inline Dual sin(Dual a) { return Dual(std::sin(a.value), std::cos(a.value)*a.slope); }
inline Dual cos(Dual a) { return Dual(std::cos(a.value), -std::sin(a.value)*a.slope); }
int main()
{
    float q[3] = {0.3f, -0.2f, 0.9f}, qd[3] = {1.0f, 2.0f, -1.0f};
    float qdd[3] = {0.5f, 0.0f, 1.0f}, tau[3];
    if (inverse_dynamics(q, qd, qdd, tau) != 0) return 1;
    std::printf("%.9g %.9g %.9g\\n", double(tau[0]), double(tau[1]), double(tau[2]));
    for (int k = 0; k < 3; k++) {
        Dual x[3] = {0.3, -0.2, 0.9}, v[3] = {1.0, 2.0, -1.0}, a[3] = {0.5, 0.0, 1.0}, t[3];
        x[k].slope = 1.0;
        if (inverse_dynamics(x, v, a, t) != 0) return 1;
        std::printf("%.17g %.17g %.17g\\n", t[0].slope, t[1].slope, t[2].slope);
    }
    q[1] = NAN;
    return inverse_dynamics(q, qd, qdd, tau) == 1 && tau[0] != tau[0] ? 0 : 1;
}
"""


def test_the_template_of_cpp_takes_float_and_a_scalar_that_differentiates(tmp_path):
    require("cpp")
    model = ROBOTS["plane"]()
    fb.export(model, "inverse_dynamics", tmp_path, "cpp")
    (tmp_path / "dual.cpp").write_text(DUAL)
    flags = ["-std=c++11", "-Wall", "-Wextra", "-pedantic", "-Werror"]
    subprocess.run(["c++", *flags, "dual.cpp", "-o", "dual"], cwd=tmp_path, check=True)
    done = subprocess.run([tmp_path / "dual"], capture_output=True, text=True, check=True)
    tau, *columns = np.array([line.split() for line in done.stdout.splitlines()], dtype=float)
    state = np.array([[0.3, -0.2, 0.9], [1, 2, -1], [0.5, 0, 1]])
    np.testing.assert_allclose(tau, fb.inverse_dynamics(model, *state), rtol=1e-5, atol=1e-5)
    by_q = fb.inverse_dynamics_derivatives(model, *state)[0]
    np.testing.assert_allclose(np.transpose(columns), by_q, rtol=0, atol=1e-12 * np.abs(by_q).max())


def test_numbers_of_the_robot_are_arguments_where_asked(tmp_path):
    require("c")
    model = fb.load("ur5e")
    inputs = ["payload.mass", "forearm_link.mass", "forearm_link.com.*", "gravity"]
    fb.export(model, "inverse_dynamics", tmp_path, inputs=inputs)
    passes(tmp_path, "c", "inverse_dynamics")
    kernel = fb.kernel(model, "inverse_dynamics", inputs=inputs)
    originals = json.loads((tmp_path / "names.json").read_text())["numbers"]
    assert list(originals.values()) == list(fb.parameters(model).names)
    listed = re.findall(r"p \[\d+\] (\w+)", (tmp_path / "inverse_dynamics.h").read_text())
    assert [originals[word] for word in listed] == list(kernel.parameters)
    head = (tmp_path / "inverse_dynamics.h").read_text()
    assert "Gravity: in p." in head
    k = kernel.parameters.index("forearm_link.mass")
    assert f"p [{k}] forearm_link_mass, here 2.846 kg" in head
    changed = {"payload.mass": 2.5, "forearm_link.mass": 4.0, "forearm_link.com.x": -0.1}
    p = np.ascontiguousarray(kernel.numbers(changed), dtype=float)
    state = fb.random_state(model, 3)
    tau = np.zeros(6)
    library = compiled(tmp_path, "inverse_dynamics")
    assert library.inverse_dynamics(*map(pointer, state), pointer(p), pointer(tau)) == 0
    expected = fb.inverse_dynamics(model.bind(changed), *state)
    np.testing.assert_allclose(tau, expected, rtol=0, atol=1e-12 * np.abs(expected).max())
    symbolic = fb.source(
        fb.load("RRP"), "inverse_dynamics", "c", inputs=["*"]
    )  # symbols need no value
    assert re.search(r"p \[\d+\] l1 \(m\)", symbolic)


def test_the_vectors_of_a_kernel_with_inputs_are_near_the_robots_own_numbers(tmp_path):
    """A robot with a negative mass, which random numbers would give, tests nothing that will ever
    be called."""
    require("c")
    model = fb.load("ur5e").with_payload(2.0, com=[0, 0, 0.1])
    kernel = fb.kernel(model, "forward_dynamics", inputs=["payload.*", "*.mass"], target="numpy")
    text = fb.source(kernel, language="c")
    k = kernel.parameters.index("upper_arm_link.mass")
    assert f"p [{k}] upper_arm_link_mass, here 8.058 kg" in text
    fb.export(kernel, out=tmp_path)
    passes(tmp_path, "c", "forward_dynamics")
    tables = (tmp_path / "forward_dynamics_test.c").read_text()
    rows = re.search(r"given3\[5\]\[\d+\] = \{(.*?)\n\};", tables, re.DOTALL)[1]
    p = np.array(
        [[float(x) for x in row.strip(" {},").split(", ")] for row in rows.strip().splitlines()]
    )
    assert p.shape == (5, len(kernel.parameters))
    off = np.abs(p - kernel.values)
    assert (off <= 0.1 * np.maximum(np.abs(kernel.values), 0.1) + 1e-15).all()
    assert (off > 0).any()
    names = json.loads((tmp_path / "names.json").read_text())
    listed = re.findall(r"p \[\d+\] (\w+)", text)
    assert [names["numbers"][word] for word in listed] == list(kernel.parameters)


@pytest.mark.sample(1)
@pytest.mark.parametrize("name", ["five_bar", "bricard"])
def test_rates_and_forces_of_loops_in_32_bits(name, tmp_path):
    """Of Bricard's loop one equation follows from the others, as exactly as numbers of 32 bits
    can."""
    require("c")
    model = fb.load(name)
    names = ["loop_velocity", "loop_acceleration", "drive_torques"]
    fb.export(model, names, tmp_path, dtype="float32", name="f")
    passes(tmp_path, "c", "f")
    given = vectors(fb.kernel(model, names, target="numpy").program, "float32", model).inputs
    library, outs = compiled(tmp_path, "f"), np.zeros((3, model.nv), np.float32)
    for sample in zip(*(x.astype(np.float32) for x in given), strict=True):
        outs[:] = 0.0
        assert library.f(*map(pointer, (*sample, *outs))) == 0
        assert np.isfinite(outs).all()
        assert outs.any(axis=-1).all()


def test_the_self_test_of_loop_equations_asks_for_agreement():
    """Where all loops are closed their equations are rounding, of which any other would do."""
    model = fb.load("five_bar")
    for name in ("constraint", "constraint_rate", "constraint_bias", "inverse_dynamics"):
        kernel = fb.kernel(model, name, target="numpy")
        assert max(vectors(kernel.program, "float64", model).tolerances) < 1e-11, name


def test_clang_has_no_warning_either(tmp_path):
    if shutil.which("clang") is None:
        pytest.skip("clang is not installed")
    package(everything(), tmp_path, "c", "float32")
    flags = ["-std=c99", "-Wall", "-Wextra", "-Wconversion", "-pedantic", "-Werror", "-c"]
    for name in ("everything.c", "everything_test.c"):
        subprocess.run(["clang", *flags, name], cwd=tmp_path, check=True)


def test_javascript_that_is_not_given_finite_numbers_gives_nan(tmp_path):
    require("javascript")
    fb.export(
        ROBOTS["plane"](), ("inverse_dynamics", "mass_matrix"), tmp_path, "javascript", name="f"
    )
    program = (
        'import { f } from "./f.mjs"; const M = new Float64Array(9), t = new Float64Array(3);'
        "const [a, b] = f([0, 0, 0], [0, NaN, 0], [0, 0, 0], t, M);"
        "console.log(a === t && b === M && [...a, ...b].every(Number.isNaN));"
    )
    (tmp_path / "try.mjs").write_text(program)
    done = subprocess.run(
        ["node", "try.mjs"], cwd=tmp_path, capture_output=True, text=True, check=True
    )
    assert done.stdout.strip() == "true"


# ---------------------------------------------------------------- words
WORDS = (
    "double", "let", "fn", "end", "t1", "t2", "w", "sin", "cos_a_0", "n", "x", "i", "function",
    "self",
    "given0", "sign_of", "all_finite", "fill", "q_0", "q", "batch", "xp", "ca", "np", "S", "f64",
    "zeros",
    "tan", "int",
)  # fmt: skip


@pytest.mark.sample(2)
@pytest.mark.parametrize("language", [x for x in LANGUAGES if x != "jax"])  # its words are NumPy's
def test_arguments_that_are_called_like_the_languages_own_words(language, tmp_path):
    inputs = [Argument(word, (2,)) for word in WORDS]

    def mixed(*args):
        return [[sign(sin(a[0])) + a[1] * args[0][0] for a in args] for _ in WORDS]

    outputs = [
        Argument(word, (len(WORDS),)) for word in WORDS
    ]  # an output may be called like an input
    program = trace("switch", mixed, inputs, outputs)
    package(program, tmp_path, language)
    require(language)
    (word,) = {path.name.partition("_test")[0] for path in tmp_path.glob("*_test.*")}
    passes(tmp_path, language, word)


@pytest.mark.long
@pytest.mark.parametrize("language", LANGUAGES)
@pytest.mark.parametrize(
    "name",
    ["bad", "found0", "d1", "printf", "main", "sys", "numpy", "names", "exit", "index", "off"],
)
def test_functions_that_are_called_like_what_stands_in_a_self_test(language, name, tmp_path):
    require(language)
    fb.export(ROBOTS["plane"](), "inverse_dynamics", tmp_path, language, name=name)
    (word,) = {path.name.partition("_test")[0] for path in tmp_path.glob("*_test.*")}
    passes(tmp_path, language, word)


def test_an_option_that_there_is_not_is_refused_by_its_name():
    with pytest.raises(
        fb.FreebodyError,
        match=r"^no option 'frames' in fb\.source\. Did you mean 'frame'\? Options: frame",
    ):
        fb.source(fb.load("2R"), "jacobian", frames="tip")


def test_every_language_is_named_where_people_look():
    command = next(
        c for c in typer.main.get_group(app).commands["export"].params if c.name == "language"
    )
    for text in (PAGE, fb.source.__doc__, command.help):
        assert {x for x in LANGUAGES if re.search(rf"\b{x}\b", text)} == set(LANGUAGES)


def test_names_of_a_robot_are_words_in_the_text_and_as_they_were_in_names_json(tmp_path):
    hostile = 'tool"""\n*/ int x; /* %{ θ\\'
    model = dataclasses.replace(
        fb.load("2R").bind(l1=1, l2=1, lc1=0.5, lc2=0.5, m1=1, m2=1, I1=1, I2=1), name=hostile
    )
    for language in LANGUAGES:
        text = fb.source(model, "inverse_dynamics", language)
        assert text.isascii()
        assert "int x;" not in text
    fb.export(model, "inverse_dynamics", tmp_path / "out")
    names = json.loads((tmp_path / "out" / "names.json").read_text())
    assert list(names["robot"].values()) == [hostile]
    assert set(tmp_path.iterdir()) == {tmp_path / "out"}


def test_functions_of_a_robot_share_a_folder(tmp_path):
    """What the second writes over says nothing of the first that is lost."""
    model = fb.load("2R")
    fb.export(model, "mass_matrix", tmp_path, inputs=["*.mass"])
    names = (tmp_path / "names.json").read_text()
    fb.export(model, "gravity_torque", tmp_path)
    assert (tmp_path / "names.json").read_text() == names
    assert "of gravity_torque" in (tmp_path / "README.txt").read_text()
    require("c")
    passes(tmp_path, "c", "mass_matrix")
    passes(tmp_path, "c", "gravity_torque")


@pytest.mark.parametrize("name", ["a b", "", "int main", "θ", "lambda", "../x"])
def test_a_function_has_a_word_for_a_name(name):
    with pytest.raises(fb.FreebodyError, match="is not a valid function name"):
        fb.source(ROBOTS["plane"](), "bias", "c", name=name)


# ---------------------------------------------------------------- the text itself
def test_text_is_the_same_in_every_process(tmp_path):
    code = (
        "import freebody as fb, hashlib, pathlib, sys; m = fb.load('ur5e')\n"
        "from freebody.targets.text import LANGUAGES; out = pathlib.Path(sys.argv[1])\n"
        "t = ''.join(fb.source(m, ('forward_dynamics', 'jacobian'), x) for x in LANGUAGES)\n"
        "fb.export(m, 'rk4_step', out, inputs=['payload.*', 'gravity'])\n"
        "t += ''.join(p.read_text() for p in sorted(out.iterdir()) if p.name != 'manifest.json')\n"
        "print(hashlib.sha256(t.encode()).hexdigest())"
    )
    found = {
        subprocess.run(
            [sys.executable, "-c", code, str(tmp_path / seed)],
            env=os.environ | {"PYTHONHASHSEED": seed},
            capture_output=True, text=True, check=True,
        ).stdout
        for seed in ("1", "2")
    }  # fmt: skip
    assert len(found) == 1


def test_the_head_says_what_is_needed_to_call_it():
    model = fb.load("ur5e")
    head = fb.source(
        model,
        ("inverse_dynamics", "jacobian"),
        "c",
        wrench_frames=["wrist_3_link"],
        frame="forearm_link",
    )
    head = head.partition("*/")[0]
    for line in (
        "qd(6): rates (rad/s", "wrench0(6): wrench on the frame wrist_3_link",
        "inverse_dynamics_tau(6): torques",
        "jacobian_J(6, 6): Jacobian",
        "3 elbow_joint: revolute, q [2], qd [2], carries forearm_link on upper_arm_link",
        "The frame is forearm_link; axes: world.", "operations: ",
        "Gravity: [0, 0, -9.81] m/s^2, world axes.",
    ):  # fmt: skip
        assert line in head, line
    count = int(re.search(r"(\d+) operations", head)[1])
    kernel = fb.kernel(
        model,
        ("inverse_dynamics", "jacobian"),
        wrench_frames=["wrist_3_link"],
        frame="forearm_link",
    )
    assert count == pytest.approx(sum(kernel.program.operations.values()), rel=0.05)


def test_sections_follow_the_recursion():
    text = fb.source(fb.load("ur5e"), "inverse_dynamics", "c")
    titles = re.findall(r"/\* (outward|inward), (?:up )?to joint (\d) (\w+) \*/", text)
    assert titles == [
        ("outward", str(k), fb.load("ur5e").joint_names[k - 1]) for k in range(1, 6)
    ] + [("inward", str(k), fb.load("ur5e").joint_names[k - 1]) for k in range(6, 0, -1)]


def test_source_of_a_kernel_of_ones_own():
    kernel = fb.compile(lambda x: [x[0] * sin(x[1])], {"x": 2}, {"y": 1}, target="numpy")
    text = fb.source(kernel, language="c", name="mine")
    assert "int mine(const double x[2], double y[1])" in text
    with pytest.raises(fb.FreebodyError, match="a kernel has its quantities already"):
        fb.source(kernel, "bias", "c")


# ---------------------------------------------------------------- refusals, and the command
def test_what_cannot_be_written_is_refused():
    model = ROBOTS["plane"]()
    with pytest.raises(
        fb.FreebodyError, match=r"no language 'fortran' in fb.source. Languages: c, cpp"
    ):
        fb.source(model, "bias", "fortran")
    with pytest.raises(
        fb.FreebodyError, match=r"language 'matlab' has no dtype 'float32'; it has float64"
    ):
        fb.source(model, "bias", "matlab", dtype="float32")
    says = {
        r"no quantity 'bia' in fb\.source": lambda: fb.source(model, "bia", "c"),
        r"fb\.export: names is int 3": lambda: fb.export(model, 3, "x"),
        r"fb\.source: the quantity 'bias' is asked for twice": lambda: fb.source(
            model, ["bias", "bias"]
        ),
        r"fb\.source: frame='tip' has no meaning": lambda: fb.source(model, "bias", frame="tip"),
        r"fb\.source: inputs= is int 3": lambda: fb.source(model, "bias", inputs=3),
        r"fb\.export: out is None, expected the name": lambda: fb.export(model, "bias", None),
        r"fb\.source: inverse_dynamics_derivatives: 'five_bar' is a closed chain": lambda: (
            fb.source(fb.load("five_bar"), "inverse_dynamics_derivatives")
        ),
    }
    for message, call in says.items():
        with pytest.raises(fb.FreebodyError, match=message):
            call()
    family = model.bind(m1=[1.0, 2.0])
    for of_many in (family, fb.kernel(family, "bias", target="numpy")):
        with pytest.raises(
            fb.FreebodyError, match=r"fb\.source: 'RPR' is a family of robots.*model\[0\]"
        ):
            fb.source(of_many, None if of_many is not family else "bias", "c")
    with pytest.raises(fb.FreebodyError, match="give the quantities"):
        fb.source(model, language="c")
    with pytest.raises(fb.FreebodyError, match=r"fb.source\(fb.load\('ur5e'\)"):
        fb.source("ur5e", "bias", "c")
    heavy = fb.compile(lambda x: [1e39 * x[0]], {"x": 1}, {"y": 1}, target="numpy")
    with pytest.raises(fb.FreebodyError, match="beyond the range of float32"):
        fb.source(heavy, language="c", dtype="float32")


def test_what_has_no_value_anywhere_is_refused_before_a_file_is_written(tmp_path):
    massless = fb.planar("R", l=[1], lc=[0], m=[0], I=[0])
    with pytest.raises(fb.FreebodyError, match="divides by zero in every state"):
        fb.export(massless, "forward_dynamics", tmp_path / "out")
    root = fb.compile(lambda x: [sqrt(-1.0 - x[0] * x[0])], {"x": 1}, {"y": 1}, target="numpy")
    with pytest.raises(fb.FreebodyError, match="infinite or NaN at all of 40 random inputs"):
        fb.export(root, out=tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_the_command(tmp_path, capsys):
    out = tmp_path / "out"
    arguments = [
        "export",
        "ur5e",
        "inverse_dynamics",
        "mass_matrix",
        "--out",
        str(out),
        "--name",
        "arm",
    ]
    assert run([*arguments, "--wrench", "wrist_3_link"]) == 0
    assert {"arm.c", "arm.h", "arm_test.c", "README.txt", "names.json", "manifest.json"} == {
        path.name for path in out.iterdir()
    }
    assert run([*arguments, "--language", "fortran"]) == 2
    assert "error: no language 'fortran' in fb.export." in capsys.readouterr().err
    slopes = [
        "export",
        "2R",
        "inverse_dynamics",
        "--input",
        "m2",
        "--by",
        "p",
        "--out",
        str(tmp_path / "slopes"),
    ]
    assert run(slopes) == 0
    assert "dtau_dp[2]" in (tmp_path / "slopes/inverse_dynamics.h").read_text()
    one_row = [
        "export",
        "ur5e",
        "operational_space_inertia",
        "--row",
        "vz",
        "--out",
        str(tmp_path / "row"),
    ]
    assert run(one_row) == 0
    assert "Lambda[1]" in (tmp_path / "row/operational_space_inertia.h").read_text()
    (out / "arm.c").write_text("mine")
    assert run(arguments) == 2
    assert (out / "arm.c").read_text() == "mine"


# ---------------------------------------------------------------- the examples of the docs
DOCS = Path(__file__).parents[2] / "docs"
PAGE = (DOCS / "exports.md").read_text(encoding="utf-8")


def block(page: str, language: str) -> str:
    """The first example in a language."""
    text = (DOCS / page).read_text(encoding="utf-8")
    return re.findall(rf"```{language}\n(.*?)```", text, re.DOTALL)[0]


def test_the_controller_of_the_docs_reaches_its_goal(tmp_path, monkeypatch):
    require("c")
    monkeypatch.chdir(tmp_path)
    for command in re.findall(
        r"^\$ freebody (.*)$", block("controller.md", "console"), re.MULTILINE
    ):
        assert run(shlex.split(command)) == 0
    Path("loop.c").write_text(block("controller.md", "c"))
    strict = block("controller.md", "sh").replace(
        "-O2", "-O0 -Wall -Wextra -Wconversion -pedantic -Werror"
    )
    done = subprocess.run(strict, shell=True, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr


def test_the_piece_of_text_in_the_docs_is_in_the_text():
    assert block("exports.md", "c") in fb.source(fb.load("ur5e"), "inverse_dynamics", "c")


@pytest.mark.browser
def test_the_page_of_the_docs_moves_under_its_own_policy(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    exec(block("web-page.md", "python"), {})
    with browser(tmp_path / "profile") as chromium:
        chromium.set_script_timeout(20)
        chromium.get((tmp_path / "pendulum.html").as_uri())
        seen = chromium.execute_async_script(
            "const done = arguments[0], links = document.getElementById('links');"
            "const at = () => links.getAttribute('points'), before = at();"
            "const look = () => at() === before ? setTimeout(look, 20) : done([before, at()]); "
            "look();"
        )
        energies = chromium.execute_script(
            "const energy = () => Number(document.getElementById('energy').textContent), first = "
            "energy();"
            "for (let k = 0; k < 60; k++) draw(); const kept = energy();"
            "const friction = document.getElementById('slider2'); friction.value = 0.5;"
            "friction.dispatchEvent(new Event('input')); for (let k = 0; k < 60; k++) draw();"
            "return [first, kept, energy()];"
        )
        assert chromium.get_log("browser") == []
    assert all(re.fullmatch(r"0,0( -?[\d.e-]+,-?[\d.e-]+){2}", points) for points in seen)
    first, kept, last = energies
    assert first == pytest.approx(kept, abs=2e-3)  # nothing rubs
    assert last < kept - 0.1


def test_the_head_tells_what_the_letters_stand_for_and_no_others():
    text = fb.source(fb.load("ur5e"), "inverse_dynamics", "c")
    head, _, body = text.partition("*/")
    told = set(re.findall(r"^ \*   (\w+) [a-z]", head, re.MULTILINE)) & set(MEANINGS)
    words = re.findall(r"const double (?:minus_)?([A-Za-z]+)\d_[xyz]", body)
    assert told == set(words)
