"""The formulas as functions of scalars, to be called inside functions of one's own."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from freebody.any_chain.kernel_options import chosen_option
from freebody.errors import FreebodyError, ShapeError, SingularError
from freebody.kernels.formulas import FORMULAS
from freebody.kernels.tracing import arguments, chosen
from freebody.model.model import Model
from freebody.targets.call_errors import require_count


def formula(
    model: Model,
    name: str,
    *,
    frame: str | None = None,
    reference: str = "world",
    wrench_frames: Sequence[str] = (),
    rows: Sequence[str] | None = None,
) -> Callable[..., Any]:
    """A quantity of a model as a function of scalars, to be called inside what `fb.compile` takes.

    Parameters
    ----------
    model, frame, reference, wrench_frames, rows
        As for `fb.kernel`. The model's numbers are constants of what is compiled.
    name
        One quantity.

    Returns
    -------
    callable
        f(q, qd, …), with the inputs of the kernel of that name: sequences of its core shapes, of
        traced scalars, floats, or arrays with an entry for each sample. It returns its output as a
        nested tuple, or the tuple of its outputs. States of closed chains have to be closed.

    Raises
    ------
    UnknownNameError, SingularError
        As `fb.kernel`.
    """
    if not isinstance(name, str):
        raise FreebodyError(
            "fb.formula: give the name of one quantity; of several, make several functions."
        )
    listed, option = chosen_option(
        model,
        name,
        frame=frame,
        reference=reference,
        wrench_frames=wrench_frames,
        rows=rows,
        function="fb.formula",
    )
    inputs, record, tree = arguments(model, listed, option), FORMULAS[name], model.tree

    def function(*values: Any) -> Any:
        require_count(name, values, inputs)
        given = {
            x.name: _nested(name, x.name, v, x.shape) for x, v in zip(inputs, values, strict=True)
        }
        try:
            results = record.evaluate(tree, option, **chosen(name, given, option))
        except ZeroDivisionError:
            raise SingularError(
                f"{name} of {model.name!r} divides by zero at this state."
            ) from None
        results = tuple(map(_tuples, results))
        return results[0] if len(results) == 1 else results

    function.__name__ = function.__qualname__ = name
    function.__doc__ = f"{name}({', '.join(map(str, inputs))}) of scalars."
    return function


def _nested(function: str, name: str, value: Any, shape: tuple[int, ...]) -> Any:
    """Sequences or an array as nested tuples of a shape."""
    if not shape:
        return value
    is_sequence = isinstance(value, tuple | list) or (
        isinstance(value, np.ndarray) and value.ndim > 0
    )
    if not is_sequence or len(value) != shape[0]:
        raise ShapeError(function, name, (len(value),) if is_sequence else (), str(shape))
    return tuple(_nested(function, name, entry, shape[1:]) for entry in value)


def _tuples(value: Any) -> Any:
    return tuple(map(_tuples, value)) if isinstance(value, tuple | list) else value
