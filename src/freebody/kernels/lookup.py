"""From a model and the name of a formula to its kernel."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, overload

from freebody.errors import FreebodyError
from freebody.kernels.column_by_column import LARGEST, ColumnKernel, KernelList
from freebody.kernels.formulas import FORMULAS, Option
from freebody.kernels.inputs import InputKernel, input_kernel, inputs_of
from freebody.kernels.options import chosen_option, several
from freebody.kernels.tracing import arguments, program
from freebody.model.model import Model
from freebody.model.numbers import Name
from freebody.program import Argument, Program
from freebody.targets import Kernel, compile_program


@overload
def kernel(
    model: Model,
    names: str | Sequence[str],
    *,
    frame: str | None = None,
    reference: str = "world",
    wrench_frames: Sequence[str] = (),
    rows: Sequence[str] | None = None,
    target: str | None = None,
    width: int | None = None,
    dtype: str = "float64",
    inputs: Name | Sequence[Name],
    by: str | Sequence[str] = (),
) -> InputKernel: ...


@overload
def kernel(
    model: Model,
    names: str | Sequence[str],
    *,
    frame: str | None = None,
    reference: str = "world",
    wrench_frames: Sequence[str] = (),
    rows: Sequence[str] | None = None,
    target: str | None = None,
    width: int | None = None,
    dtype: str = "float64",
    by: str | Sequence[str] = (),
) -> Kernel | ColumnKernel | KernelList | InputKernel: ...


def kernel(
    model: Model,
    names: str | Sequence[str],
    *,
    frame: str | None = None,
    reference: str = "world",
    wrench_frames: Sequence[str] = (),
    rows: Sequence[str] | None = None,
    target: str | None = None,
    width: int | None = None,
    dtype: str = "float64",
    inputs: Name | Sequence[Name] = (),
    by: str | Sequence[str] = (),
) -> Kernel | ColumnKernel | KernelList | InputKernel:
    """The compiled function for one quantity, or for several that share their work.

    Parameters
    ----------
    model
        A model with all values.
    names
        One quantity or a list of them: "inverse_dynamics", "forward_dynamics", "mass_matrix",
        "jacobian", … One step of a simulation is a quantity too: "rk4_step", "semi_implicit_step",
        "implicit_step" and "implicit_feedback_step", with the step's length h (s) after tau, return
        (q1, qd1), see docs/stepping.md; and so are control laws, see docs/control.md.
    frame
        The frame of kinematic quantities, by default the tip.
    reference
        The axes of vectors: "world" or "body"; of joint wrenches "world" or "child".
    wrench_frames
        Frames that carry external wrenches; each becomes a further input (..., 6): wrench0,
        wrench1, … in their order.
    rows
        Rows of operational space, among "vx", "vy", "vz", "wx", "wy", "wz" (plane "vx", "vy", "w"),
        by default all.
    target
        Where it runs: "cpu" (machine code by LLVM for this CPU), "cpu:x86-64-v3" (for all that
        reach this level, to the same bytes), "numpy" (node by node, without a compiler) or "cuda"
        (NVIDIA's GPUs; it takes arrays in their memory). None: FREEBODY_TARGET, else the CPU.
    width
        Samples in a CPU vector. None: as many as suit it.
    dtype
        "float64", or "float32", which computes with numbers of 32 bits, about twice as fast in
        batches, to about 6 digits of a sample's largest entry; arrays of other real types are
        rounded to it, and so are the robot's numbers.
    inputs
        Numbers of the model that are given at each call, by names and patterns of `fb.parameters`
        ("link*.mass"; patterns leave out exact zeros and right angles of placements, names in full
        take them). They are gathered, in the order of `fb.parameters`, in one last argument p (...,
        k), or given as p={name: value}; without p they are the model's own. k.parameters are their
        names, k.values the model's own. Of a family all numbers with members are inputs; where its
        members differ in limits alone, the size of gravity.
    by
        Inputs by which each output is differentiated as well (exactly, in forward mode), "p" among
        them. After the outputs come their derivatives, dtau_dp (*output, k) and so on, output by
        output; those by positions are on the tangent space (nv).

    Returns
    -------
    Kernel
        k(q, qd, …, out=None, threads=None), which broadcasts like a NumPy ufunc, lets NaN through
        and checks no names. Its inputs are those of the quantities, in the order q, qd, qdd, tau,
        wrenches, and its outputs in the order of `names`. Kernels of a closed chain assume that its
        loops are closed; at singular positions the drives' torques are NaN, where the public
        functions of the same names still answer.

    Raises
    ------
    UnknownNameError
        A quantity, frame, row, input or number that does not exist.
    SingularError
        Drives of a closed chain that do not force its motion.
    """
    listed, option = chosen_option(
        model, names, frame=frame, reference=reference, wrench_frames=wrench_frames, rows=rows
    )
    return fetch(
        model,
        listed,
        option,
        target,
        width,
        dtype,
        several("fb.kernel", "inputs=", inputs),
        several("fb.kernel", "by=", by),
    )


def fetch(
    model: Model,
    names: tuple[str, ...],
    option: Option,
    target: str | None = None,
    width: int | None = None,
    dtype: str = "float64",
    inputs: tuple[Name, ...] = (),
    by: tuple[str, ...] = (),
) -> Any:
    """The kernel, compiled on first use and kept as long as the model."""
    key = (names, option, target, width, dtype, inputs, by)
    found = model.compiled.get(key)
    if found is None:
        large = _large(model, names)
        if large and dtype != "float64":
            raise FreebodyError(
                f"fb.kernel: {large[0]} of {model.nv} coordinates is computed column by column, "
                f"which is available in float64 only (dtype={dtype!r} up to {LARGEST} coordinates)."
            )
        if inputs or by or model.family:
            found = _with_inputs(model, names, option, target, width, dtype, inputs, by)
        else:
            found = in_columns(
                model,
                names,
                option,
                lambda part: fetch(model, (part,), Option(), target, width),
                lambda some: fetch(model, some, option, target, width),
            ) or compile_program(
                program(model, names, option), target=target, width=width, dtype=dtype
            )
        model.compiled[key] = found
    return found


def in_columns(
    model: Model,
    names: tuple[str, ...],
    option: Option,
    fetch_product: Callable[[str], Any],
    fetch_some: Callable[[tuple[str, ...]], Any],
) -> ColumnKernel | KernelList | None:
    """The kernel of a large robot's quantities, the matrices among them by columns; None where all
    are one program.

    fetch_product: the kernel of a formula that columns come from; fetch_some: of some of the
    quantities.
    """
    if not _large(model, names):
        return None

    def whole() -> Program:
        return program(model, names, option)

    if len(names) == 1:
        inputs = arguments(model, names, option)
        return ColumnKernel(names[0], inputs, model.nv, fetch_product, whole)
    return _in_parts(model, names, option, fetch_some, whole)


def _large(model: Model, names: tuple[str, ...]) -> list[str]:
    """The quantities that are made column by column, for so many coordinates."""
    return [name for name in names if FORMULAS[name].by_columns] if model.nv > LARGEST else []


def _with_inputs(
    model: Model,
    names: tuple[str, ...],
    option: Option,
    target: str | None,
    width: int | None,
    dtype: str,
    wanted: tuple[Name, ...],
    by: tuple[str, ...],
) -> Kernel | InputKernel:
    """A kernel with numbers of the model as inputs, or with derivatives."""
    large = _large(model, names)
    if large:
        raise FreebodyError(
            f"fb.kernel: {large[0]} of {model.nv} coordinates is computed column by column, which "
            f"takes no inputs=, by= or family (up to {LARGEST} coordinates they do)."
        )
    if not wanted and not model.family:
        return compile_program(
            program(model, names, option, by=by), target=target, width=width, dtype=dtype
        )
    given = inputs_of("fb.kernel", model, wanted)
    # a family's numbers never stand still along the batch
    p = Argument("p", (len(given.names),), uniform=not model.family)
    traced = program(model, names, option, p, given.tree, by)
    compiled = compile_program(traced, target=target, width=width, dtype=dtype)
    return input_kernel(compiled, given.names, given.values, model)


def _in_parts(
    model: Model,
    names: tuple[str, ...],
    option: Option,
    fetch_some: Callable[[tuple[str, ...]], Any],
    whole: Callable[[], Program],
) -> KernelList:
    """Quantities by columns each alone, all others in one program that shares their work."""
    large = _large(model, names)
    together = tuple(name for name in names if name not in large)
    groups = [(name,) for name in large] + ([together] if together else [])
    first, places = 0, {}
    for name in names:
        places[name] = list(range(first, first + len(FORMULAS[name].outputs)))
        first += len(FORMULAS[name].outputs)
    parts = [
        (
            fetch_some(some),
            [a.name for a in arguments(model, some, option)],
            [k for x in some for k in places[x]],
        )
        for some in groups
    ]
    return KernelList(arguments(model, names, option), parts, whole)
