"""A user's own function over scalars, traced and compiled as the formulas are."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping, Sequence
from numbers import Real
from operator import index
from typing import Any

import numpy as np

from freebody.arrays import Array
from freebody.errors import FreebodyError, KindError, UnknownNameError, listed, shown
from freebody.identifiers import is_identifier
from freebody.program import Argument, Program, ProgramError, trace
from freebody.program.derivative import Directions, differentiated
from freebody.scalars.expr import Expr
from freebody.scalars.nodes import GraphError
from freebody.targets import Kernel, compile_program

Shapes = Mapping[str, int | Sequence[int]]


MOST = 1_000_000
"""Scalars of all inputs, of all outputs, or of one derivative: each is traced by itself."""


def compile(  # noqa: A001  the name that users look for
    function: Callable[..., Any],
    inputs: Shapes,
    outputs: Shapes | None = None,
    *,
    by: str | Sequence[str] = (),
    dtype: str = "float64",
    target: str | None = None,
    width: int | None = None,
) -> Kernel:
    """Your own function, such as a controller or a cost, compiled; called like the kernels of
    `fb.kernel`.

    Parameters
    ----------
    function
        Called once, with traced scalars: for each input, by its name, a nested tuple of its core
        shape (a bare scalar for shape ()). It adds, multiplies, divides, raises to whole powers,
        uses `freebody.math` and what `fb.formula` gives, and may build lists and NumPy arrays of
        such scalars; it cannot branch on their values. It is not kept; a pickle has its program.
    inputs
        {name: core shape}, an integer for a vector: {"q": 6, "gain": ()}; names are words of a-z,
        0-9 and _.
    outputs
        {name: core shape} of the results: the value itself if there is one, else a tuple in this
        order; a dict by name does too. None: as returned, {name: value}, or one value, which is
        called "result".
    by
        Inputs by which each output is differentiated as well (exactly, in forward mode). Behind the
        outputs follow their derivatives, of core shape (*output, *input), called dtau_dq for tau by
        q; of each output in turn, by each.
    dtype, target, width
        As for `fb.kernel`.

    Returns
    -------
    Kernel
        k(*inputs, out=None, threads=None): one output, or a tuple. A sample with an input that is
        not finite has NaN in all outputs.

    Raises
    ------
    FreebodyError
        A function that cannot be traced, or results whose shapes do not fit.
    """
    if not callable(function):
        raise KindError("fb.compile", "function", function, "a function of scalars")
    taken = _arguments("input", inputs)
    wanted = None if outputs is None else _arguments("output", outputs)
    name = getattr(function, "__name__", "")
    name = name if is_identifier(name) else "compiled"
    _require_parameters(function, name, [x.name for x in taken])
    shapes = {x.name: x.shape for x in taken}
    chosen = (by,) if isinstance(by, str) else tuple(by)
    for label in chosen:
        if label not in inputs:
            raise UnknownNameError("input", label, "by=", inputs)

    labels = [x.name for x in taken]

    def evaluate(*values: Any) -> dict[str, Array]:
        given = dict(zip(labels, values, strict=True))
        return _results(name, wanted, _called(name, function, given))

    program = trace(name, evaluate, taken, None)
    if chosen:
        directions = {labels.index(label): Directions(shapes[label]) for label in chosen}
        _require_derivatives(program, [labels[k] for k in directions])
        program = differentiated(program, directions)
    return compile_program(program, target=target, width=width, dtype=dtype)


def _arguments(what: str, shapes: Shapes) -> tuple[Argument, ...]:
    """The arguments from a dict of names and core shapes, checked."""
    if not isinstance(shapes, Mapping) or not (shapes or what == "input"):
        raise KindError(
            "fb.compile", f"{what}s", shapes, 'a dict of names and core shapes, as {"q": (6,)}'
        )
    made = []
    for name, shape in shapes.items():
        if not is_identifier(name):
            raise FreebodyError(
                f"fb.compile: the {what} name {shown(name)} is not a word of letters a-z, digits "
                f"and _."
            )
        try:
            sizes = (index(shape),) if not isinstance(shape, Sequence) else tuple(map(index, shape))
        except TypeError:
            sizes = (-1,)
        if isinstance(shape, str | bool) or any(size < 0 for size in sizes):
            raise FreebodyError(
                f"fb.compile: the core shape of {what} {name} is {shown(shape)}, expected a whole "
                f"number or a tuple of "
                "them: (6,) for a vector, (3, 3) for a matrix, () for a number."
            )
        made.append(Argument(name, sizes))
    _require_few(f"the {what}s", sum(argument.size for argument in made))
    return tuple(made)


def _require_few(what: str, count: int) -> None:
    if count > MOST:
        raise FreebodyError(
            f"fb.compile: {what} have {count} entries, at most {MOST} are possible: each is a "
            f"scalar with operations of its own. Compile the function of one sample, and call it "
            f"with a batch."
        )


def _require_parameters(function: Callable[..., Any], title: str, names: list[str]) -> None:
    """Refuse a function that does not take exactly these names."""
    try:
        signature = inspect.signature(function)
    except (TypeError, ValueError):  # some builtins have none
        return
    try:
        signature.bind(**dict.fromkeys(names))
    except TypeError as problem:
        raise FreebodyError(
            f"fb.compile: {title}{signature} is called with its inputs by name, "
            f"{listed(names) or 'none'}: {problem}."
        ) from None


def _called(title: str, function: Callable[..., Any], given: dict[str, Any]) -> Any:
    """The result of the user's function on traced scalars; errors that it raises are explained."""
    try:
        return function(**given)
    except GraphError:
        raise
    except RecursionError:
        raise GraphError(
            f"fb.compile: {title} calls itself without end: a traced scalar has no value that "
            f"could end the recursion."
        ) from None
    except TypeError as problem:
        if not any(
            word in str(problem) for word in ("Expr", "Dual", "ufunc", "dtype('O')", "object")
        ):
            raise
        said = str(problem).rstrip(".")
        raise GraphError(
            f"fb.compile: {title} uses traced scalars in a way that cannot be recorded: {said}. "
            f"Functions of them are those of freebody.math (freebody.math.sin, where, …), not "
            f"those of Python's math or NumPy; vectors are tuples, and np.array makes arrays of "
            f"them, for + - * / @ with other arrays."
        ) from problem


def _require_derivatives(program: Program, by: Sequence[str]) -> None:
    """Refuse derivatives with too many entries, and those with the name of an output."""
    outputs = [x.name for x in program.outputs]
    count = sum(x.size for x in program.inputs if x.name in by)
    for output in program.outputs:
        _require_few(f"the derivatives of {output.name}", output.size * count)
        for title in (f"d{output.name}_d{name}" for name in by):
            if title in outputs:
                raise ProgramError(
                    f"fb.compile: {title} is both an output of {program.name} and a derivative; "
                    f"rename it."
                )


def _results(title: str, wanted: tuple[Argument, ...] | None, returned: Any) -> dict[str, Array]:
    """The returned values by name, as object arrays of the declared shapes."""
    if isinstance(returned, Mapping):
        values = dict(returned)
    elif wanted is None or len(wanted) == 1:
        values = {"result" if wanted is None else wanted[0].name: returned}
    elif isinstance(returned, tuple | list) and len(returned) == len(wanted):
        values = {x.name: y for x, y in zip(wanted, returned, strict=True)}
    else:
        kind = (
            f"{len(returned)} values"
            if isinstance(returned, tuple | list)
            else type(returned).__name__
        )
        raise ProgramError(
            f"fb.compile: {title} returned {kind}, expected a tuple of {listed(map(str, wanted))}, "
            f"or a dict of them."
        )
    if wanted is None:
        wanted = _arguments("output", dict.fromkeys(values, ()))
        return {x.name: _array(title, x.name, values[x.name]) for x in wanted}
    if set(values) != {x.name for x in wanted}:
        raise ProgramError(
            f"fb.compile: {title} returned a dict of {listed(map(str, values)) or 'nothing'}, "
            f"expected one of {listed(map(str, wanted))}."
        )
    results = {x.name: _array(title, x.name, values[x.name]) for x in wanted}
    for x in wanted:
        if results[x.name].shape != x.shape:
            raise ProgramError(
                f"fb.compile: {title} returned {x.name} of shape {results[x.name].shape}, expected "
                f"{x.shape}."
            )
    return results


def _array(title: str, name: str, nested: Any) -> Array:
    """Nested sequences of scalars as an array of objects."""
    shape, flat = _flat(title, name, nested)
    array = np.empty(len(flat), dtype=object)
    array[:] = flat
    return array.reshape(shape)


def _flat(title: str, name: str, nested: Any) -> tuple[tuple[int, ...], list[Any]]:
    if isinstance(nested, np.ndarray):
        return nested.shape, [
            x for entry in nested.ravel().tolist() for x in _flat(title, name, entry)[1]
        ]
    if isinstance(nested, Expr | Real):
        return (), [nested]
    if not isinstance(nested, tuple | list):
        raise ProgramError(
            f"fb.compile: {title} returned {name} with {type(nested).__name__} {shown(nested)} "
            f"where a scalar was expected."
        )
    parts = [_flat(title, name, entry) for entry in nested]
    shapes = dict.fromkeys(shape for shape, _ in parts)
    if len(shapes) > 1:
        raise ProgramError(
            f"fb.compile: {title} returned {name} with entries of different shapes, "
            f"{listed(map(str, shapes))}. "
            "Several outputs are returned as a dict, {name: value}."
        )
    return (len(nested), *next(iter(shapes), ())), [x for _, flat in parts for x in flat]
