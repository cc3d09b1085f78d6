"""Formulas run on NumPy arrays as they stand, without a program or a kernel: what kernels are held
against.

`helpers.numbers` does so by `fb.formula`; this takes any option of a kernel, a point too, so it
goes to the table itself.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from freebody.arrays import Array
from freebody.kernels.formulas import FORMULAS, Option
from freebody.kernels.tracing import arguments, chosen, shape
from freebody.model.model import Model


def reference(
    model: Model, name: str, *arrays: Array, option: Option | None = None
) -> Array | tuple[Array, ...]:
    """The formula run on NumPy arrays instead of the compiled kernel; arguments and results as for
    the kernel."""
    option = option or Option()
    inputs = arguments(model, (name,), option)
    batch = np.broadcast_shapes(
        *(
            a.shape[: a.ndim - len(argument.shape)]
            for a, argument in zip(arrays, inputs, strict=True)
        )
    )
    given = {
        argument.name: _scalars(np.broadcast_to(a, batch + argument.shape), len(argument.shape))
        for argument, a in zip(inputs, arrays, strict=True)
    }
    formula = FORMULAS[name]
    values = formula.evaluate(model.tree, option, **chosen(name, given, option))
    results = tuple(
        _array(value, batch, shape(model, output.dims, option))
        for value, output in zip(values, formula.outputs.values(), strict=True)
    )
    return results[0] if len(results) == 1 else results


def at_point(model: Model, name: str, *arrays: Any, frame: str | None = None) -> Array:
    """A quantity about a point, which is the last of the arrays."""
    at = frame if name == "momentum" else model.frame(frame).name
    found = reference(
        model, name, *(np.asarray(a, dtype=float) for a in arrays), option=Option(at, point=True)
    )
    assert not isinstance(found, tuple)
    return found


def _array(value: Any, batch: tuple[int, ...], shape: tuple[int, ...]) -> Array:
    """Nested scalars as one array (*batch, *shape)."""
    flat = [np.broadcast_to(np.asarray(x, dtype=float), batch) for x in _flat(value, len(shape))]
    return np.stack(flat, axis=-1).reshape(batch + shape) if flat else np.zeros(batch + shape)


def _scalars(array: Array, core: int) -> Any:
    """An array as nested tuples over its core axes, each entry an array over the batch."""
    if core == 0:
        return array
    axis = array.ndim - core
    return tuple(_scalars(np.take(array, i, axis=axis), core - 1) for i in range(array.shape[axis]))


def _flat(value: Any, depth: int) -> list[Any]:
    return [value] if depth == 0 else [x for item in value for x in _flat(item, depth - 1)]
