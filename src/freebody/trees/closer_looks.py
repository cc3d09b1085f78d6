"""Samples at which a kernel's result is not sure: it is NaN there, and these samples alone are
computed again more closely, in one further batch."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial, reduce
from types import MappingProxyType
from typing import Any, Protocol

import numpy as np

from freebody.arrays import Array
from freebody.kernels import structural
from freebody.kernels.formulas import FORMULAS, Option
from freebody.kernels.structural import Bound
from freebody.model.model import Model
from freebody.model.model_argument import require_model
from freebody.trees.public_calls import checked_inputs, refuse_overflow


class Look(Protocol):
    """A function that computes a quantity by a closer look, at samples (k,) of its inputs, of a
    family (k, *family); at: each sample's index in the whole batch, for errors."""

    def __call__(self, model: Model, option: Option, at: np.ndarray, *inputs: Array) -> Array: ...


Closer = Callable[..., Array | tuple[Array, ...]]
"""(at, *inputs) -> the outputs of a kernel, as of `Look`."""


def looking_closer(
    look: Look, called: Mapping[str, str] = MappingProxyType({})
) -> Callable[..., Any]:
    """A function that replaces `public_calls.careful` for a quantity whose kernel returns NaN where
    it is not sure. called: see `public_calls.checked_inputs`."""

    def answer(
        key: Any,
        model: Model,
        inputs: tuple[Any, ...],
        chosen: Callable[..., Option],
        _: Any,
        result: Any = None,
    ) -> Any:
        function, *choice = key
        require_model(function, model)
        option = chosen(model, *choice)
        given = dict(zip(FORMULAS[function].inputs, inputs, strict=True))
        _, arrays = checked_inputs(function, model, given, None, option, called)
        bound = structural.fetch(model, (function,), option)
        model.compiled[key] = bound.checked(every=True, kept=True)
        batch = arrays[0].shape[:-1]
        lead = len(batch) - len(model.family)
        named = dict(zip(given, arrays, strict=True))
        closer = partial(look, model, option)
        return closer_where_unclear(function, bound, named, lead, closer, result)

    return answer


def closer_where_unclear(
    function: str,
    bound: Bound,
    named: Mapping[str, Array],
    lead: int,
    look: Closer,
    result: Any = None,
) -> Any:
    """The outputs of a kernel, replaced by those of a closer look at samples of the first `lead`
    axes where one is not finite. named: the kernel's inputs; result: outputs that are already
    known."""
    if result is None:
        result = bound(*named.values())
    outputs = result if isinstance(result, tuple) else (result,)
    finite = (np.isfinite(x).all(axis=tuple(range(lead, x.ndim))) for x in outputs)
    unclear = ~np.asarray(reduce(np.logical_and, finite))
    if unclear.any():
        with np.errstate(over="ignore", invalid="ignore"):  # what overflows is named below
            closer = look(np.argwhere(unclear), *(x[unclear] for x in named.values()))
        for x, y in zip(outputs, closer if isinstance(closer, tuple) else (closer,), strict=True):
            x[unclear] = y
        if not all(np.isfinite(x).all() for x in outputs):
            refuse_overflow(function, named)
    return result
