"""PTX: assembled by NVIDIA's own assembler, and its entries run on this processor, thread by
thread.

No test here needs a GPU. Those that do are in test_cuda_device.py, which is run here on an emulated
driver.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path
from time import process_time

import numpy as np
import pytest

import freebody as fb
from freebody.any_chain.kernel_options import chosen_option
from freebody.elementary import FUNCTIONS
from freebody.kernels.formulas import FORMULAS
from freebody.kernels.tracing import program
from freebody.program import Argument, Program, trace
from freebody.scalars.operations import OPERATIONS
from freebody.targets import KernelError, compile_program
from freebody.targets.cuda.driver import missing
from freebody.targets.cuda.emit import TOGETHER, emit
from freebody.targets.cuda.parts import (
    ALIVE,
    FEW,
    FEWEST,
    LARGEST,
    OUTPUTS,
    ROOM,
    part,
    parts,
    prepared,
)
from freebody.targets.cuda.ptx import ptx
from freebody.targets.llvm.machine import host
from freebody.targets.text import SourceUnit, cuda
from freebody.ways_out.exports import vectors
from support import gpu
from support.extras import extra
from support.real_files import ROBOTS

TALOS = ROBOTS / "talos_data/robots/talos_reduced.urdf"
TOLERANCE = {"float64": 1e-13, "float32": 1e-5}
DTYPES = tuple(TOLERANCE)
LONGEST, ASSEMBLED = 40_000, 100_000
"""Nodes of programs for which no compiler, and no assembler, needs a quarter of an hour. Three
derivatives of a Talos are longer than the first, one of them longer than the second."""
STARTED = ("inverse_dynamics", "forward_dynamics")


def robot(name: str) -> fb.Model:
    if name != "talos":
        return fb.load(name)
    if not TALOS.exists():
        pytest.skip("example-robot-data is not installed")
    return fb.load(TALOS, mimic="free", tip="left_sole_link")


def formulas(model: fb.Model) -> list[str]:
    """All quantities that there are of a robot."""
    loops = ("constraint", "constrained_dynamics", "reaction_wrenches")
    own = "closed" if model.loops else "open"
    return [
        x
        for x, formula in FORMULAS.items()
        if formula.chains in ("all", own) and (model.loops or not x.startswith(loops))
    ]


def traced(model: fb.Model, name: str) -> Program:
    return program(model, *chosen_option(model, name))


def require_compiler() -> None:
    if shutil.which("cc") is None or sys.platform != "linux":
        pytest.skip("no C compiler on Linux: the emulated driver is not made")


def agrees(found: np.ndarray, exact: np.ndarray, allowed: float) -> None:
    assert np.isfinite(exact).all()
    assert np.abs(found - exact).max(initial=0.0) <= allowed * (
        np.abs(exact).max(initial=0.0) or 1.0
    )


def gives_what_is_true(model: fb.Model, name: str, dtype: str) -> None:
    """Emulated threads, beside the same program in arithmetic of more digits."""
    made = traced(model, name)
    known = vectors(made, dtype, model)
    given = [x.reshape(-1, *a.shape) for x, a in zip(known.inputs, made.inputs, strict=True)]
    results = gpu.run(made, given, dtype)
    for found, exact, allowed in zip(results, known.outputs, known.tolerances, strict=True):
        agrees(found.reshape(exact.shape), exact, max(allowed, TOLERANCE[dtype]))


# ---------------------------------------------------------------- what a thread computes
@pytest.mark.sample(2)
@pytest.mark.parametrize("dtype", DTYPES)
@pytest.mark.parametrize(
    ("name", "quantity"),
    [
        ("ur5e", "inverse_dynamics"),
        ("ur5e", "forward_dynamics_derivatives"),
        ("panda", "forward_dynamics"),
        ("panda", "rk4_step"),
        ("iiwa14", "inverse_dynamics_derivatives"),
        ("talos", "inverse_dynamics"),
        ("stewart", "constraint_jacobian"),
        ("five_bar", "loop_acceleration"),
        ("bricard", "drive_torques"),
    ],
)
def test_a_thread_computes_what_is_true(name, quantity, dtype):
    gives_what_is_true(robot(name), quantity, dtype)


@pytest.mark.long
@pytest.mark.parametrize("dtype", DTYPES)
@pytest.mark.parametrize("name", ["ur5e", "panda", "talos", "stewart"])
def test_every_formula_of_every_robot(name, dtype):
    model = robot(name)
    for quantity in formulas(model):
        if len(traced(model, quantity)) < LONGEST:
            gives_what_is_true(model, quantity, dtype)


@pytest.mark.sample(5)
@pytest.mark.parametrize("name", [*FUNCTIONS])
@pytest.mark.parametrize("dtype", DTYPES)
def test_operations_have_the_bits_that_the_cpu_gives(name, dtype):
    """So the bounds in units of the last place that hold there hold here."""
    if "fma" not in host().has and host().x86:
        pytest.skip("this processor has no fused multiply-add, which GPUs have")
    arity = OPERATIONS[name].arity if name in OPERATIONS else 1
    inputs = [Argument(x, ()) for x in "abc"[:arity]]
    made = trace(f"just_{name}", lambda *x: (FUNCTIONS[name](*x),), inputs, [Argument("y", ())])
    rng = np.random.default_rng(0)
    anywhere = rng.integers(0, 2**63, 3000, dtype=np.int64).view(np.float64)
    with np.errstate(over="ignore"):
        column = np.concatenate(
            [
                rng.normal(size=3000, scale=4.0), rng.uniform(-1, 1, 3000),
                rng.uniform(-1e6, 1e6, 3000),
                np.where(np.isfinite(anywhere), anywhere, 1e300),
                [0.0, -0.0, 0.5, 1.0, -1.0, 5e-324, 1e5, -1e22, np.pi, np.inf, -np.inf, np.nan],
            ]
        ).astype(dtype)  # fmt: skip
    given = [rng.permutation(column) if k else column for k in range(arity)]
    (found,) = gpu.run(made, given, dtype)
    expected = compile_program(made, target="cpu", dtype=dtype)(*given)
    np.testing.assert_array_equal(np.isnan(found), np.isnan(expected))
    there = ~np.isnan(expected)
    kind = {"float64": np.int64, "float32": np.int32}[dtype]
    np.testing.assert_array_equal(found[there].view(kind), expected[there].view(kind))


# ---------------------------------------------------------------- where it reads and writes
def little() -> Program:
    """Different things of all inputs; an input that is a result, a constant, the same result
    twice."""
    inputs = [Argument("q", (2,)), Argument("A", (2, 2)), Argument("h", ())]
    outputs = [Argument("y", (3,)), Argument("B", (2, 2)), Argument("s", ())]
    return trace(
        "little",
        lambda q, A, h: (
            [q[0] + 2.0 * q[1], A[0][1] * h, 4.0],
            [[A[1][0], q[1]], [q[0] * h, q[0] * h]],
            A[1][1] - h,
        ),
        inputs,
        outputs,
    )


def expected_of(q: np.ndarray, A: np.ndarray, h: np.ndarray) -> tuple[np.ndarray, ...]:
    n = max(len(np.atleast_1d(h)), len(np.atleast_2d(q)))
    q, A, h = np.broadcast_to(q, (n, 2)), np.broadcast_to(A, (n, 2, 2)), np.broadcast_to(h, (n,))
    y = np.stack([q[:, 0] + 2.0 * q[:, 1], A[:, 0, 1] * h, np.full(n, 4.0)], axis=-1)
    B = np.stack([A[:, 1, 0], q[:, 1], q[:, 0] * h, q[:, 0] * h], axis=-1)
    return y, B, (A[:, 1, 1] - h)[:, None]


@pytest.mark.sample(18)
@pytest.mark.parametrize("threads", [1, 7, 32])
@pytest.mark.parametrize("count", [1, 31, 32, 33])
@pytest.mark.parametrize("layout", ["rows", "columns", "apart"])
def test_every_sample_is_read_and_written_in_its_place_and_nothing_else(layout, count, threads):
    made = prepared(little())
    entry = gpu.Emulated(emit({"entry": part(made, range(8))}, "float64"), ["entry"])
    rng = np.random.default_rng(count)
    arrays, kept = [], []

    def room(size: int, fill: float | None) -> np.ndarray:
        """(count, size), in memory of which other numbers are around and between."""
        shape = {"rows": (count, size), "columns": (size, count), "apart": (2 * count, 3 * size)}[
            layout
        ]
        whole = (
            rng.normal(size=(shape[0] + 2, shape[1]))
            if fill is None
            else np.full((shape[0] + 2, shape[1]), fill)
        )
        inner = whole[1:-1]
        kept.append(whole)
        return {"rows": inner, "columns": inner.T, "apart": inner[::2, ::3]}[layout]

    arrays = [room(2, None), room(4, None), room(1, None)[:, 0]]
    outs = [room(3, 7.0), room(4, 7.0), room(1, 7.0)[:, 0]]
    blocks = -(-count // threads)
    entry.launch("entry", gpu.values_of([*arrays, *outs], [1, 1, 0] * 2, count), blocks, threads)
    wanted = expected_of(arrays[0], arrays[1].reshape(count, 2, 2), arrays[2])
    for found, exact in zip(outs, wanted, strict=True):
        np.testing.assert_allclose(found.reshape(exact.shape), exact, rtol=1e-15)
        found[...] = 7.0
    for whole in kept[3:]:
        assert (whole == 7.0).all(), "something else was written"


def many(inputs: int, outputs: int) -> Program:
    """Entry k of the output is k times an input, which come in turn."""
    arrays = [Argument("x", (inputs,))], [Argument("y", (outputs,))]
    return prepared(
        trace("many", lambda x: ([x[k % inputs] * float(k) for k in range(outputs)],), *arrays)
    )


@pytest.mark.sample(1)
@pytest.mark.parametrize("layout", ["rows", "columns"])
def test_arrays_of_many_entries_are_read_and_written_in_their_places(layout):
    n = 2 * TOGETHER + 3
    entry = gpu.Emulated(emit({"entry": part(many(n, n), range(n))}, "float64"), ["entry"])
    given, made = np.random.default_rng(3).normal(size=(9, n)), np.full((11, n), 7.0)
    if layout == "columns":
        given, made = np.asfortranarray(given), np.asfortranarray(made)
    entry.launch("entry", gpu.values_of([given, made[1:-1]], [1, 1], 9), 1)
    np.testing.assert_array_equal(made[1:-1], given * np.arange(n))
    assert (made[[0, -1]] == 7.0).all()


def test_the_time_of_llvm_grows_no_faster_than_the_outputs():
    """LLVM compares addresses in pairs: four times the outputs took it 15 times as long."""

    def seconds(n: int) -> float:
        text = emit({"entry": part(many(2, n), range(n))}, "float64")
        begin = process_time()
        ptx(text)
        return process_time() - begin

    assert seconds(2000) < 9 * seconds(500)


def test_what_is_the_same_for_all_samples_is_broadcast():
    rng = np.random.default_rng(1)
    q, A, h = rng.normal(size=(40, 2)), rng.normal(size=(2, 2)), rng.normal(size=40)
    for found, exact in zip(gpu.run(little(), [q, A, h]), expected_of(q, A, h), strict=True):
        np.testing.assert_allclose(found.reshape(exact.shape), exact, rtol=1e-15)


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_a_sample_with_an_input_that_is_not_finite_is_nan_and_no_other(bad):
    rng = np.random.default_rng(2)
    arrays = [rng.normal(size=(5, *a.shape)) for a in little().inputs]
    for k in range(3):
        wrong = [x.copy() for x in arrays]
        wrong[k].reshape(5, -1)[3, -1] = bad
        for found, fine in zip(gpu.run(little(), wrong), gpu.run(little(), arrays), strict=True):
            assert np.isnan(found[3]).all()
            np.testing.assert_array_equal(np.delete(found, 3, axis=0), np.delete(fine, 3, axis=0))


# ---------------------------------------------------------------- registers
@pytest.mark.sample(1)
@pytest.mark.parametrize("dtype", DTYPES)
@pytest.mark.parametrize("name", ["ur5e", "panda"])
def test_dynamics_spill_nothing(name, dtype, tmp_path):
    model = fb.load(name)
    for quantity in STARTED:
        ((registers, *spilled),) = gpu.assembled(
            fb.source(model, quantity, "cuda", dtype=dtype), tmp_path
        )
        assert registers <= 255
        assert spilled == [0, 0]


@pytest.mark.sample(1)
@pytest.mark.parametrize(
    "quantity", ["inverse_dynamics_derivatives", "forward_dynamics_derivatives"]
)
def test_derivatives_are_divided_until_they_do_not_spill(quantity, tmp_path):
    text = fb.source(fb.load("ur5e"), quantity, "cuda", name="f")
    entries = gpu.assembled(text, tmp_path)
    assert [spilled for _, *spilled in entries] == [[0, 0]] * len(entries)
    assert re.findall(r"\.entry (\w+)\(", text) == [
        f"f_part{k}" for k in range(1, len(entries) + 1)
    ]
    assert len(entries) > 1


def test_parts_are_all_results_once_and_a_program_that_would_cost_too_much_stays_whole():
    for name, divided in (("ur5e", True), ("panda", False)):
        made = prepared(traced(fb.load(name), "inverse_dynamics_derivatives"))
        whole, some = part(made, range(len(made.results))), parts(made, "float64")
        assert sorted(k for piece in some for k in piece.results) == list(range(len(made.results)))
        assert (len(some) > 1) == divided
        assert whole.alive > ROOM["float64"]
        if divided:
            assert max(piece.alive for piece in some) <= ROOM["float64"]
            assert whole.operations < sum(x.operations for x in some) <= LARGEST * whole.operations


def test_constants_that_are_many_are_written_apart_in_loops():
    """In their places and nowhere else, NaN where an input is not finite, of several values and
    outputs."""

    def body(x):
        rows = [[3.0 if (i * j) % 5 else x[0] * float(j + 1) for j in range(60)] for i in range(40)]
        rows[7][:] = [-1.5] * 60
        return rows, [0.0] * 90 + [x[1], 2.0]

    made = trace(
        "many", body, [Argument("x", (2,))], [Argument("A", (40, 60)), Argument("b", (92,))]
    )
    divided = parts(prepared(made), "float64")
    assert [piece.constant for piece in divided] == [True, False]
    assert len(divided[0].results) > FEW > len(divided[1].results)
    given = np.random.default_rng(1).normal(size=(70, 2))
    given[5, 1] = np.inf
    A, b = gpu.run(made, [given])
    for i, x in enumerate(given):
        if i == 5:
            assert np.isnan(A[i]).all()
            assert np.isnan(b[i]).all()
            continue
        rows, others = body(x)
        np.testing.assert_array_equal(A[i].reshape(40, 60), rows)
        np.testing.assert_array_equal(b[i], others)


def test_parts_of_long_programs_are_short_enough_to_assemble():
    """Each of few results and few values alive; all results once; shared work is not repeated
    without end."""
    made = prepared(traced(fb.load("panda"), "inverse_dynamics_second_derivatives"))
    some = parts(made, "float32")
    assert sorted(k for piece in some for k in piece.results) == list(range(len(made.results)))
    computing = [piece for piece in some if not piece.constant]
    assert len(computing) > 1
    for piece in computing:
        assert len(piece.results) <= OUTPUTS
        assert piece.alive <= ALIVE or len(piece.results) < FEWEST
        seen = set()
        for index in piece.nodes:
            assert seen.issuperset(made.operands(index))
            seen.add(index)
    whole = part(made, range(len(made.results)))
    assert sum(piece.operations for piece in computing) < 2.0 * whole.operations


def test_one_result_after_the_other_keeps_less_of_a_tree_alive():
    """As traced, a recursion goes outward over all branches before it comes inward."""
    made = prepared(traced(robot("talos"), "forward_dynamics"))
    (piece,) = parts(made, "float64")
    whole = part(made, range(len(made.results)))
    assert sorted(piece.nodes) == sorted(whole.nodes)
    assert piece.alive < 0.7 * whole.alive


def test_a_program_without_numbers_is_an_entry_all_the_same(tmp_path):
    empty = trace("nothing", lambda q: ([],), [Argument("q", (2,))], [Argument("y", (0,))])
    text = cuda.CUDA.emit(SourceUnit(empty, "nothing"))
    assert re.findall(r"\.entry (\w+)\(", text) == ["nothing"]
    gpu.assembled(text, tmp_path)
    (found,) = gpu.run(empty, [np.ones((3, 2))])
    assert found.shape == (3, 0)


@pytest.mark.parametrize("processor", ["sm_75", "sm_80", "sm_100"])
def test_one_text_is_for_all_gpus(processor, tmp_path):
    gpu.assembled(fb.source(fb.load("pendulum"), "rk4_step", "cuda"), tmp_path, processor)


@pytest.mark.long
@pytest.mark.parametrize("dtype", DTYPES)
@pytest.mark.parametrize("name", ["ur5e", "panda", "talos", "stewart"])
def test_ptxas_takes_every_formula(name, dtype, tmp_path):
    model = robot(name)
    for quantity in formulas(model):
        if len(traced(model, quantity)) < ASSEMBLED:
            assert gpu.assembled(fb.source(model, quantity, "cuda", dtype=dtype), tmp_path), (
                quantity
            )


# ---------------------------------------------------------------- the target
def test_where_there_is_no_gpu_the_target_says_what_is_missing():
    reason = missing()
    if not reason:
        pytest.skip("there is a GPU")
    with pytest.raises(KernelError, match=f"^target 'cuda' does not run here: {re.escape(reason)}"):
        fb.kernel(
            fb.load("2R").bind(l1=1, l2=1, lc1=0.5, lc2=0.5, m1=1, m2=1, I1=1, I2=1),
            "bias",
            target="cuda",
        )


def test_kernels_run_on_an_emulated_driver():
    """All that is said of kernels on a GPU, and of kernels of all targets: their code runs, below
    NVIDIA's binding."""
    for package in ("cuda.bindings", "cuda.core"):
        extra(package, name="cuda")
    require_compiler()
    here = Path(__file__).parents[1]
    files = [
        here / name for name in ("ways_out/test_cuda_device.py", "core/compiler/test_kernels.py")
    ]
    command = [
        sys.executable,
        "-m",
        "pytest",
        "-n0",
        "-q",
        "-p",
        "support.emulated",
        "-k",
        "device or cuda",
        *files,
    ]
    path = os.pathsep.join([str(here), *sys.path])
    done = subprocess.run(
        command,
        cwd=here.parent,
        env=os.environ | {"PYTHONPATH": path},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout[-4000:] + done.stderr[-2000:]
    ran = re.search(r"(\d+) passed", done.stdout)
    assert ran
    assert int(ran[1]) > 40


# ---------------------------------------------------------------- text and package
def test_the_text_is_the_same_each_time_and_says_how_it_is_called(tmp_path):
    model = fb.load("ur5e")
    text = fb.source(model, STARTED, "cuda", name="dynamics")
    assert text == fb.source(model, STARTED, "cuda", name="dynamics")
    head = text.partition("// Generated by LLVM")[0]
    assert all(line.startswith("//") for line in head.splitlines() if line)
    assert "qdd(6): accelerations, rates of qd" in head
    (entry,) = re.findall(r"\.visible \.entry (\w+)\((.*?)\)", text, re.DOTALL)
    assert entry[0] == "dynamics"
    assert "the entry dynamics with a grid" in head
    assert f"takes {entry[1].count('.param')} 64-bit values" in head
    assert "fma.rn.f64" in text
    assert not re.search(r"\b(sin|cos|rcp|div\.full|sqrt)\.approx", text), "nothing approximate"


@pytest.mark.parametrize("name", ["sin", "atan2", "exp", "log", "acos"])
def test_no_assembler_contracts_what_has_to_be_rounded(name):
    """Without .rn it may make a multiply-add of two instructions, and a difference that is exact is
    exact no more."""
    arity = OPERATIONS[name].arity
    made = fb.compile(lambda **x: FUNCTIONS[name](*x.values()), dict.fromkeys("ab"[:arity], ()))
    text = fb.source(made, language="cuda")
    assert len(re.findall(r"\b(?:mul|add|sub)\.rn\.f64", text)) > 3
    assert not re.search(r"\b(mul|add|sub)\.f(32|64)", text)


@pytest.mark.sample(1)
@pytest.mark.parametrize("dtype", DTYPES)
@pytest.mark.parametrize("quantity", ["inverse_dynamics", "forward_dynamics_derivatives"])
def test_a_package_passes_its_own_test_on_an_emulated_driver_and_can_fail(
    quantity, dtype, tmp_path, monkeypatch
):
    require_compiler()
    texts = []
    monkeypatch.setattr(cuda, "emit", lambda *x: texts.append(emit(*x)) or texts[-1])
    model = fb.load("ur5e")
    fb.export(model, quantity, tmp_path, "cuda", dtype=dtype)
    for text, passes in (
        (texts[0], True),
        (texts[0].replace("fsub contract", "fadd contract", 1), False),
    ):
        gpu.driver(tmp_path, text)
        environment = os.environ | {"LD_LIBRARY_PATH": str(tmp_path)}
        command = [sys.executable, f"{quantity}_test.py"]
        done = subprocess.run(
            command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False
        )
        assert done.stdout.splitlines()[-1] == ("passed" if passes else "FAILED"), (
            done.stdout + done.stderr
        )
        assert (done.returncode == 0) == passes
