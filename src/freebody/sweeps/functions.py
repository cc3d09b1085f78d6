"""Functions that a sweep evaluates: kernels by the name of their formula, compiled functions, and
functions of Python over batches."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from freebody.any_chain.kernel_options import chosen_option
from freebody.arrays import Array, as_floats, check_core, refuse_not_finite
from freebody.errors import FreebodyError, KindError, ShapeError, UnknownNameError, listed
from freebody.kernels.formulas import FORMULAS, INPUTS
from freebody.kernels.inputs import InputKernel
from freebody.kernels.tracing import arguments
from freebody.model.doubts import ALL
from freebody.model.model import Model
from freebody.model.named_numbers import found, known
from freebody.targets import Kernel
from freebody.trees.public_calls import finite_vector
from freebody.ways_out.kernel import kernel

FAILURES = (FreebodyError, ArithmeticError, ValueError)
"""Errors by which a function says that it has no value at a point; any other is a fault of its
own."""
FAULTS = (ShapeError, KindError, UnknownNameError)
"""Errors among `FAILURES` that do not depend on the point."""


class SweptFunction(Protocol):
    """A function that a sweep evaluates at the points of its grid."""

    @property
    def numbers(self) -> tuple[str, ...]:
        """Names of the model's numbers that vary."""
        ...

    @property
    def touches(self) -> tuple[str, ...]:
        """The aspects of the model, among those that may be doubted, that the function's values
        depend on."""
        ...

    @property
    def threads(self) -> bool:
        """Whether parts of the grid may be evaluated side by side."""
        ...

    def __call__(self, given: Mapping[str, Array], hoisted: bool) -> dict[str, Array]:
        """The function's values (R, C, *core) by output, for inputs (R or 1, C or 1, *core).

        hoisted: whether a robot's own arithmetic is done once a row, where its numbers are the same
        along the columns.
        """
        ...

    def dimensions(self, output: str) -> tuple[str, ...] | None:
        """Names of the dimensions of an output's core, such as "nv"; None where they have none."""
        ...


@dataclass(frozen=True)
class SweptKernel:
    """A kernel as a swept function; where numbers of the model vary, its last input holds them."""

    kernel: Kernel | InputKernel
    numbers: tuple[str, ...]
    formulas: tuple[str, ...] = ()
    threads: bool = True

    @property
    def touches(self) -> tuple[str, ...]:
        """The aspects of the model that the kernel's values depend on, see `SweptFunction`; none
        for a function of the user's own."""
        return tuple({x: None for name in self.formulas for x in FORMULAS[name].touches})

    @property
    def inputs(self) -> tuple[str, ...]:
        """Names of the kernel's inputs other than numbers of the model."""
        names = tuple(x.name for x in self.kernel.program.inputs)
        return names[:-1] if self.numbers else names

    def __call__(self, given: Mapping[str, Array], hoisted: bool) -> dict[str, Array]:
        """The kernel's values by output; see `SweptFunction`."""
        names = [x.name for x in self.kernel.program.outputs]
        arrays = [given[name] for name in self.inputs]
        if self.numbers:
            p = np.stack(np.broadcast_arrays(*(given[name] for name in self._order())), axis=-1)
            if hoisted:
                return self._by_row(names, arrays, p)
            arrays.append(p)
        return dict(zip(names, _tuple(self.kernel(*arrays, threads=1)), strict=True))

    def _order(self) -> tuple[str, ...]:
        assert isinstance(self.kernel, InputKernel)
        return self.kernel.parameters

    def _by_row(self, names: list[str], arrays: list[Array], p: Array) -> dict[str, Array]:
        rows = max(len(x) for x in [*arrays, p])
        columns = max(x.shape[1] for x in arrays)
        outputs = self.kernel.program.outputs
        made = tuple(np.empty((rows, columns, *x.shape)) for x in outputs)
        for r in range(rows):
            row = [x[r if len(x) > 1 else 0] for x in arrays]
            out = [x[r] for x in made]
            number = p[r if len(p) > 1 else 0, 0]
            self.kernel(*row, number, out=tuple(out) if len(out) > 1 else out[0], threads=1)
        return dict(zip(names, made, strict=True))

    def dimensions(self, output: str) -> tuple[str, ...] | None:
        """Names of the dimensions of a kernel's output; see `SweptFunction`."""
        for name in self.formulas:
            label = output if len(self.formulas) == 1 else output.removeprefix(f"{name}_")
            found = FORMULAS[name].outputs.get(label)
            if found is not None and (label != output or len(self.formulas) == 1):
                return tuple(map(str, found.dims))
        return None


def _tuple(result: Any) -> tuple[Array, ...]:
    return result if isinstance(result, tuple) else (result,)


@dataclass(frozen=True)
class SweptCallable:
    """A Python function as a swept function: of the model (a family where its numbers vary) and of
    batches by name."""

    function: Callable[..., Any]
    model: Model
    numbers: tuple[str, ...]
    threads: bool = False
    touches: tuple[str, ...] = ALL
    """All aspects of the model: the function may ask for any."""

    def __call__(self, given: Mapping[str, Array], hoisted: bool) -> dict[str, Array]:
        """The Python function's values by output; see `SweptFunction`."""
        batch = np.broadcast_shapes(*(x.shape[:2] for x in given.values()))
        model = self.model
        if self.numbers:
            model = model.bind({name: given[name] for name in self.numbers})
        rest = {name: x for name, x in given.items() if name not in self.numbers}
        result = self.function(model, **rest)
        name = getattr(self.function, "__name__", "result")
        named = (
            dict(result)
            if isinstance(result, Mapping)
            else {name if name.isidentifier() else "result": result}
        )
        return {key: _of_batch(key, value, batch) for key, value in named.items()}

    def dimensions(self, output: str) -> None:
        """None: the results of Python functions have no named dimensions."""


def _of_batch(name: str, value: Any, batch: tuple[int, ...]) -> Array:
    array = as_floats("sweep", f"the function's {name}", value)
    if array.ndim >= 2 and all(
        n in (1, wanted) for n, wanted in zip(array.shape[:2], batch, strict=True)
    ):
        return np.broadcast_to(array, (*batch, *array.shape[2:]))
    raise ShapeError(
        "sweep",
        f"the function's {name}",
        array.shape,
        f"({batch[0]}, {batch[1]}, ...)",
        "what the function is given has this batch in front, or 1 where it does not vary",
    )


def named_formulas(
    model: Model,
    names: Sequence[str],
    frame: str | None,
    reference: str,
    numbers: Sequence[str],
    target: str | None,
) -> SweptKernel:
    """The kernel of one or several formulas, with numbers of the model as inputs."""
    if model.loops:
        raise FreebodyError(
            f"sweep: {model.name!r} is a closed chain, whose loops must close at each state. Give "
            f"a function, such as lambda model, q: fb.{names[0]}(model, q), which refuses others."
        )
    option = {"frame": frame, "reference": reference, "target": target}
    made: Any = (
        kernel(model, names, **option, inputs=tuple(numbers))
        if numbers
        else kernel(model, names, **option)
    )
    if not isinstance(made, Kernel | InputKernel):
        raise FreebodyError(
            f"sweep: {names[0]} of {model.nv} coordinates is computed column by column; give a "
            f"function, such as lambda model, q: fb.{names[0]}(model, q)."
        )
    return SweptKernel(made, tuple(numbers), tuple(names))


def reader(model: Model, inputs: Mapping[str, tuple[int, ...]] | None) -> Callable[..., Any]:
    """A function that reads and checks the values given for an axis or a constant, see `axes.Read`.

    inputs: what the function takes and its core shape; None: whatever is no number of the model.
    """
    numbers = known(model)

    def read(name: str, value: Any, axes: int = 1) -> tuple[str, Array]:
        if inputs is not None and name in inputs:
            array = (
                finite_vector("sweep", model, name, value)
                if name in INPUTS and INPUTS[name].dims in (("nq",), ("nv",))
                else as_floats("sweep", name, value)
            )
            _check(name, array, inputs[name], axes)
            return name, array
        if inputs is None and name not in numbers.rows:
            array = as_floats("sweep", name, value)
            if array.ndim < axes:
                raise ShapeError("sweep", name, array.shape, "(n, ...)", "one entry for each point")
            refuse_not_finite("sweep", name, array, max(array.ndim - 1, 0))
            return name, array
        try:
            full = found(numbers, name, model)
        except FreebodyError as problem:
            takes = f" The function takes {listed(inputs)}." if inputs else ""
            raise FreebodyError(f"sweep: {problem}{takes}") from None
        array = as_floats("sweep", full, value)
        _check(full, array, (), axes)
        return full, array

    return read


def _check(name: str, array: Array, core: tuple[int, ...], axes: int) -> None:
    check_core("sweep", name, array, core, "the shape of one point, after the axes of the points")
    if array.ndim != axes + len(core):
        raise ShapeError(
            "sweep",
            name,
            array.shape,
            str(("n", *core)[1 - axes :]).replace("'n'", "n"),
            "a grid over several things has an axis of over for each",
        )
    refuse_not_finite("sweep", name, array, len(core))


def input_shapes(
    function: Any, model: Model, frame: str | None, reference: str
) -> dict[str, tuple[int, ...]] | None:
    """Core shapes of a function's inputs by name; None for a Python function, which may take
    anything."""
    if isinstance(function, Kernel):
        return {x.name: x.shape for x in function.program.inputs}
    if callable(function):
        try:
            inspect.signature(function)
        except (TypeError, ValueError):
            raise KindError(
                "sweep", "function", function, "a function of (model, **what varies)"
            ) from None
        return None
    listed, option = chosen_option(
        model, names_of(function), frame=frame, reference=reference, wrench_frames=(), rows=None
    )
    return {x.name: x.shape for x in arguments(model, listed, option)}


def names_of(function: Any) -> tuple[str, ...]:
    """The names of formulas, given as one or several."""
    names = (function,) if isinstance(function, str) else function
    if not isinstance(names, Sequence) or not all(isinstance(x, str) for x in names) or not names:
        raise KindError(
            "sweep",
            "function",
            function,
            'the name of a formula ("inverse_dynamics"), several, what fb.compile returns, or a '
            "function of (model, **what varies)",
        )
    return tuple(names)
