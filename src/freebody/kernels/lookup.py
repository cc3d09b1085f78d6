"""From a model and the names of formulas to their kernel, specialised to the model's numbers."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from freebody.errors import FreebodyError
from freebody.kernels.column_by_column import LARGEST, ColumnKernel, KernelList
from freebody.kernels.formulas import FORMULAS, Option
from freebody.kernels.inputs import InputKernel, input_kernel, inputs_of
from freebody.kernels.tracing import arguments, program
from freebody.model.model import Model
from freebody.model.named_numbers import Name
from freebody.program import Argument, Program
from freebody.targets import Kernel, compile_program


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
