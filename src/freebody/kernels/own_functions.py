"""A user's own function over scalars, traced and compiled as the formulas are."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping, Sequence
from itertools import count
from math import prod
from numbers import Real
from operator import index
from typing import Any

import numpy as np

from freebody.arrays import Array
from freebody.dual import Dual, Outer, slopes, value
from freebody.errors import FreebodyError, KindError, UnknownNameError, listed, shown
from freebody.identifiers import is_identifier
from freebody.program import Argument, ProgramError, trace
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
    GraphError
        A function that cannot be traced.
    ProgramError
        Results whose shapes do not fit.
    """
    if not callable(function):
        raise KindError("fb.compile", "function", function, "a function of scalars")
    taken = _arguments("input", inputs)
    wanted = None if outputs is None else _arguments("output", outputs)
    name = getattr(function, "__name__", "")
    name = name if is_identifier(name) else "compiled"
    _require_parameters(function, name, [x.name for x in taken])
    chosen = (by,) if isinstance(by, str) else tuple(by)
    for label in chosen:
        if label not in inputs:
            raise UnknownNameError("input", label, "by=", inputs)

    shapes = {x.name: x.shape for x in taken}

    def evaluate(*values: Any) -> dict[str, Array]:
        given = dict(zip((x.name for x in taken), values, strict=True))
        directions = {label: shapes[label] for label in chosen}
        results = _results(
            name, wanted, _called(name, function, _differentiated(given, directions))
        )
        found = {label: _each(array, lambda x: value(x, Outer)) for label, array in results.items()}
        for label, array in results.items():
            for title, block in _derivatives(label, array, directions).items():
                if title in found:
                    raise ProgramError(
                        f"fb.compile: {title} is both an output of {name} and a derivative; rename "
                        f"it."
                    )
                found[title] = block
        return found

    return compile_program(
        trace(name, evaluate, taken, None), target=target, width=width, dtype=dtype
    )


def _arguments(what: str, shapes: Shapes) -> tuple[Argument, ...]:
    """Names and core shapes, checked."""
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
    """The function's result; an error that says what the function did to traced scalars."""
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
            word in str(problem)
            for word in ("Expr", "Dual", "Outer", "ufunc", "dtype('O')", "object")
        ):
            raise
        said = str(problem).rstrip(".")
        raise GraphError(
            f"fb.compile: {title} uses traced scalars in a way that cannot be recorded: {said}. "
            f"Functions of them are those of freebody.math (freebody.math.sin, where, …), not "
            f"those of Python's math or NumPy; vectors are tuples, and np.array makes arrays of "
            f"them, for + - * / @ with other arrays."
        ) from problem


def _differentiated(
    given: dict[str, Any], directions: dict[str, tuple[int, ...]]
) -> dict[str, Any]:
    """The inputs; the scalars of those with directions, in the order of these, each with a slope of
    its own."""
    number = count()

    def lifted(x: Any) -> Any:
        return tuple(map(lifted, x)) if isinstance(x, tuple) else Outer(x, {next(number): 1.0})

    return given | {name: lifted(given[name]) for name in directions}


def _results(title: str, wanted: tuple[Argument, ...] | None, returned: Any) -> dict[str, Array]:
    """The returned values by name, as arrays of objects of the shapes that are wanted."""
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
    if isinstance(nested, Expr | Dual | Real):
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


def _each(array: Array, function: Callable[[Any], Any]) -> Array:
    made = np.empty(array.size, dtype=object)
    made[:] = [function(x) for x in array.ravel().tolist()]
    return made.reshape(array.shape)


def _derivatives(
    label: str, array: Array, directions: dict[str, tuple[int, ...]]
) -> dict[str, Array]:
    """The derivatives of one output by each of some inputs."""
    sizes = [prod(shape) for shape in directions.values()]
    _require_few(f"the derivatives of {label}", array.size * sum(sizes))
    rows = [slopes(x, sum(sizes), Outer) for x in array.ravel().tolist()]
    found, start = {}, 0
    for (name, shape), size in zip(directions.items(), sizes, strict=True):
        block = np.empty((array.size, size), dtype=object)
        for row, every in zip(block, rows, strict=True):
            row[:] = every[start : start + size]
        found[f"d{label}_d{name}"] = block.reshape((*array.shape, *shape))
        start += size
    return found
