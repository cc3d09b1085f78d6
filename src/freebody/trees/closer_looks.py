"""Samples that are not clear to a kernel: it says NaN there, and these alone are looked at closer,
in one further batch; the others are never looked at again."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any, Protocol

import numpy as np

from freebody.arrays import Array
from freebody.kernels import structural
from freebody.kernels.formulas import FORMULAS, Option
from freebody.model.model import Model
from freebody.model.model_argument import require_model
from freebody.trees.public_calls import checked_inputs, refuse_overflow


class Look(Protocol):
    """What a quantity is, found with care: at samples (k,) of its inputs, of a family (k, *family);
    at: the index of each in the whole batch, for errors."""

    def __call__(self, model: Model, option: Option, at: np.ndarray, *inputs: Array) -> Array: ...


def looking_closer(
    look: Look, called: Mapping[str, str] = MappingProxyType({})
) -> Callable[..., Any]:
    """What answers instead of `public_calls.careful` for a quantity of one output whose kernel says
    NaN where it is not sure. called: see `public_calls.checked_inputs`."""

    def answer(
        key: Any, model: Model, inputs: tuple[Any, ...], chosen: Callable[..., Option], _: Any
    ) -> Any:
        function, *choice = key
        require_model(function, model)
        option = chosen(model, *choice)
        given = dict(zip(FORMULAS[function].inputs, inputs, strict=True))
        _, arrays = checked_inputs(function, model, given, None, option, called)
        bound = structural.fetch(model, (function,), option)
        model.compiled[key] = bound.checked(every=True)
        result = bound(*arrays)
        batch = arrays[0].shape[:-1]
        lead = batch[: len(batch) - len(model.family)]
        clear = np.isfinite(result).all(axis=tuple(range(len(lead), result.ndim)))
        if not clear.all():
            at = np.argwhere(~clear)
            result[~clear] = look(model, option, at, *(x[~clear] for x in arrays))
            if not np.isfinite(result).all():
                refuse_overflow(function, dict(zip(given, arrays, strict=True)))
        return result

    return answer
