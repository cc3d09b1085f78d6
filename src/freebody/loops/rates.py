"""Rates and accelerations that keep every loop closed: the nearest to given ones, or those that
follow from a few given ones."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike, NDArray

from freebody.algorithms.loop_constraints import Counting
from freebody.algorithms.loop_rates import ALLOWED
from freebody.arrays import Array, as_floats, at_sample, refuse_not_finite
from freebody.errors import FreebodyError, UnknownNameError
from freebody.kernels.formulas import Option
from freebody.kernels.structural import fetch
from freebody.loops.equations import (
    branches,
    counting,
    refuse_inconsistent,
    require_closed,
    require_loops,
    scaled_jacobian,
)
from freebody.loops.independent_equations import idle_coordinates, partition_of_loops
from freebody.loops.scaled_equations import rate_scale, row_scale
from freebody.model.model import Model
from freebody.trees.public_calls import JointVector, attempt, common_batch, finite_vector

_LOOSE = 1e-9  # singular values of Φ_q from which coordinates follow from the others


def loop_velocity(model: Model, q: JointVector, rates: JointVector) -> Array:
    """Rates that keep every loop closed at a closed position (2.35, 5.22).

    Parameters
    ----------
    model : Model
        A closed chain.
    q : (..., nq)
        Closed position, rad and m.
    rates : {coordinate: value} or (..., nv)
        Of the independent coordinates, or a whole vector, from which the nearest consistent one is
        taken; rad/s and m/s.

    Returns
    -------
    (..., nv)

    Raises
    ------
    LoopError
        The values given contradict the loops.
    FreebodyError
        They do not determine the motion.
    """
    require_loops(model, "loop_velocity")
    found = _attempted("loop_velocity", model, q, rates)
    if found is not None:
        return found
    at = finite_vector("loop_velocity", model, "q", q)
    return _consistent("loop_velocity", model, {"q": at}, rates)


def loop_acceleration(
    model: Model, q: JointVector, qd: JointVector, accelerations: JointVector
) -> Array:
    """Accelerations that keep every loop closed in a closed state (5.28).

    Parameters
    ----------
    model : Model
        A closed chain.
    q, qd : (..., nq), (..., nv)
        Closed position, and rates that keep it closed.
    accelerations : {coordinate: value} or (..., nv)
        As the rates of `loop_velocity`; rad/s² and m/s².

    Returns
    -------
    (..., nv)

    Raises
    ------
    LoopError, FreebodyError
        As for `loop_velocity`.
    """
    require_loops(model, "loop_acceleration")
    found = _attempted("loop_acceleration", model, q, qd, accelerations)
    if found is not None:
        return found
    at, rates = (finite_vector("loop_acceleration", model, n, x) for n, x in (("q", q), ("qd", qd)))
    return _consistent("loop_acceleration", model, {"q": at, "qd": rates}, accelerations)


def _attempted(function: str, model: Model, *inputs: JointVector) -> Array | None:
    """Rates by a kernel where its result is sure and a whole vector is given; else None."""
    chosen = None if isinstance(inputs[-1], Mapping) else partition_of_loops(model)
    if chosen is None:
        return None
    return attempt(function, model, inputs, Option(partition=chosen, checks="state"))


def _given(
    function: str, model: Model, given: ArrayLike | Mapping[str, ArrayLike]
) -> tuple[tuple[int, ...] | None, Array]:
    """(indices of the coordinates whose values are given by name, None where a whole vector is
    given; the values (..., nv), 0 where not given)."""
    if not isinstance(given, Mapping) or hasattr(given, "to_dataarray"):
        return None, finite_vector(function, model, "rates", given)
    names, columns = model.velocity_names, {}
    for name, value in given.items():
        if name not in names:
            raise UnknownNameError("coordinate", name, f"{function}: {model.name!r}", names)
        columns[name] = as_floats(function, f"rates[{name!r}]", value)
        refuse_not_finite(function, f"rates[{name!r}]", columns[name], 0)
    named = {f"rates[{name!r}]": column[..., None] for name, column in columns.items()}
    values = np.zeros((*common_batch(function, named), model.nv))
    for name, column in columns.items():
        values[..., names.index(name)] = column
    return tuple(sorted(map(names.index, columns))), values


def _consistent(
    function: str, model: Model, state: dict[str, Array], given: ArrayLike | Mapping[str, ArrayLike]
) -> Array:
    """Rates x (..., nv) with Φ_q x = right at a closed state: with the values given by name, or
    nearest to the vector given."""
    held, x = _given(function, model, given)
    arrays = state | {"rates": x}
    batch = common_batch(function, arrays)
    arrays = {name: np.broadcast_to(a, (*batch, a.shape[-1])) for name, a in arrays.items()}
    result = _by_kernel(function, model, held, arrays)
    with_care = np.asarray(np.isnan(result).any(axis=-1))
    q, qd = arrays["q"], arrays.get("qd")
    require_closed(function, model, q, qd, ~with_care)
    for taken, part in branches(model, q, with_care):
        require_closed(function, taken, q, qd, part)
        some = {name: a[part] for name, a in arrays.items()}
        result[part] = _carefully(function, taken, held, some, np.argwhere(part))
    return result


def _by_kernel(
    function: str, model: Model, held: tuple[int, ...] | None, arrays: dict[str, Array]
) -> Array:
    """Rates by a kernel; NaN where no fixed choice of equations and coordinates fits, or where a
    coordinate that no loop determines has no value given."""
    chosen = partition_of_loops(model)
    valued = range(model.nv) if held is None else held
    if chosen is None or not set(idle_coordinates(model)) <= set(valued):
        return np.full(arrays["rates"].shape, np.nan)
    option = (
        Option(partition=chosen)
        if held is None
        else Option(equations=Counting(chosen.rows), held=held)
    )
    return fetch(model, (function,), option)(*arrays.values())


def _carefully(
    function: str,
    model: Model,
    held: tuple[int, ...] | None,
    arrays: dict[str, Array],
    samples: NDArray[np.intp],
) -> Array:
    """Rates by singular values for arrays (N, …), the given samples of a batch; refuses given
    values that contradict the loops or leave them free to move."""
    q, x = arrays["q"], arrays["rates"]
    right = (
        fetch(model, ("constraint_bias",), Option())(q, arrays["qd"])
        if "qd" in arrays
        else np.zeros(1)
    )
    J = scaled_jacobian(model, q)
    right, stretch = counting(model, q, row_scale(model) * right), rate_scale(model)
    result = x / stretch
    moving = np.setdiff1d(np.arange(model.nv), held or ())
    missing = right - np.einsum("nmk,nk->nm", J, result)
    step = np.einsum("nkm,nm->nk", np.linalg.pinv(J[..., moving], rcond=1e-10), missing)
    result[:, moving] += step
    left = right - np.einsum("nmk,nk->nm", J, result)
    allowed = ALLOWED * (1.0 + np.abs(result).max(axis=-1, initial=0.0))
    bad = np.flatnonzero(np.abs(left).max(axis=-1, initial=0.0) > allowed)
    if len(bad):
        sample = at_sample(samples[bad[0]].tolist())
        refuse_inconsistent(
            function,
            model,
            left[bad[0]],
            f"does not allow the values given{sample}: they contradict its equations; give fewer "
            f"of them"
            if held
            else f"cannot stay closed{sample}, whatever the values: the mechanism is locked",
        )
    if held is not None and (np.linalg.matrix_rank(J[..., moving], tol=_LOOSE) < len(moving)).any():
        names = ", ".join(model.velocity_names[k] for k in held) or "nothing"
        raise FreebodyError(
            f"{function}: the values given for {names} leave {model.name!r} free to move; give one "
            f"for every independent coordinate: fb.mobility(model, q).independent names a choice."
        )
    return result * stretch
