"""What every public function does around its kernel: take vectors and dicts, check shapes, blame what is not finite."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from freebody.arrays import Array, as_floats, at_sample, check_core, refuse_not_finite
from freebody.errors import FreebodyError, ShapeError
from freebody.kernels import lookup
from freebody.kernels.formulas import FORMULAS, OF_TREES, POSITIONS, Option
from freebody.labels import aligned, refuse_other_times
from freebody.model.model import Model
from freebody.model.required import require_model
from freebody.targets.sound import HUGE

Vector = ArrayLike | Mapping[str, float]
Wrenches = ArrayLike | Mapping[str, ArrayLike] | None

_POINTS = ("point", "about")
_UNIT = 1e-6  # how far a quaternion may be off unit length


def evaluate(
    function: str,
    model: Model,
    inputs: tuple[Any, ...],
    option: Option | None = None,
    wrenches: Wrenches = None,
) -> Any:
    """The kernel of `function` on inputs in the formula's order: an array, or a tuple of its outputs.

    A kernel that was called before is tried at once: it refuses wrong shapes and types by itself, and says of inputs
    that carry names and of results that are not finite that there is something to look at. Then, and on the first call,
    the inputs are looked at one by one: every call gives the same answer, or the same refusal.
    """
    frames, loads = _given(wrenches)
    try:
        known = model.compiled.get((function, option, frames))
    except AttributeError:
        require_model(function, model)
        raise
    if known is not None:
        checked, quaternions = known
        try:
            result = checked(*inputs, *loads)
            if result is not None and all(_are_unit(inputs[i], starts) for i, starts in quaternions):
                return result
        except (TypeError, ValueError, AttributeError):
            pass  # explained below
    return _carefully(function, model, inputs, option, wrenches)


def _given(wrenches: Wrenches) -> tuple[tuple[str | None, ...], tuple[ArrayLike, ...]]:
    """Frames as they were named, None being the tip, and the wrench on each."""
    if wrenches is None:
        return (), ()
    if isinstance(wrenches, Mapping):
        return tuple(wrenches), tuple(wrenches.values())
    return (None,), (wrenches,)


def _are_unit(q: Array, starts: tuple[int, ...]) -> bool:
    """Whether the quaternions that begin at `starts` are surely of unit length; AttributeError if q is no array."""
    if q.ndim == 1:
        values = q.tolist()  # sums of floats are quicker than any function of so small an array
        for k in starts:
            w, x, y, z = values[k : k + 4]
            if not abs(w * w + x * x + y * y + z * z - 1.0) < _UNIT:
                return False
        return True
    blocks = (q[..., k : k + 4] for k in starts)
    return all(bool((np.abs(np.vecdot(x, x) - 1.0) < _UNIT).all()) for x in blocks)


def _carefully(
    function: str, model: Model, inputs: tuple[Any, ...], option: Option | None, wrenches: Wrenches
) -> Any:
    """Check every input, call the kernel, and blame what is not finite."""
    if function in OF_TREES:
        model.require_tree(function)
    chosen = option or Option()
    formula = FORMULAS[function]
    names = [name for name in formula.inputs if name != "wrenches" and (name != "point" or chosen.point)]
    refuse_other_times(function, dict(zip(names, inputs, strict=True)))
    arrays = [vector(function, model, name, value) for name, value in zip(names, inputs, strict=True)]
    loads = wrenches_by_frame(function, model, wrenches)
    if loads:
        chosen = chosen._replace(wrench_frames=tuple(loads))
    kernel = lookup.fetch(model, (function,), chosen)
    wrenched = [f"wrenches[{frame!r}]" for frame in loads]
    named = dict(zip([*names, *wrenched], [*arrays, *loads.values()], strict=True))
    common_batch(function, named)
    result = kernel(*named.values())
    if not all(np.isfinite(x).all() for x in (result if isinstance(result, tuple) else (result,))):
        for name, array in named.items():
            refuse_not_finite(function, name, array, 1, labels(model, name))
        _refuse_overflow(function, named)
    starts = _quaternions(model)
    turning = tuple((i, starts) for i, name in enumerate(names) if starts and name in POSITIONS)
    model.compiled[function, option, _given(wrenches)[0]] = kernel.checked, turning
    return result


def _quaternions(model: Model) -> tuple[int, ...]:
    """Where in q a quaternion begins, for each there is."""
    return tuple(
        at.q[body.kind.quaternion]
        for body, at in zip(model.bodies, model.coordinates, strict=True)
        if body.kind.quaternion is not None
    )


def checked_inputs(
    function: str, model: Model, given: Mapping[str, Any], wrenches: Wrenches
) -> tuple[tuple[str, ...], list[Array]]:
    """(frames with wrenches, arrays of the inputs and then the wrenches), all finite and of one batch shape."""
    refuse_other_times(function, given)
    arrays = {name: vector(function, model, name, value) for name, value in given.items()}
    loads = wrenches_by_frame(function, model, wrenches)
    named = arrays | {f"wrenches[{frame!r}]": load for frame, load in loads.items()}
    for name, array in named.items():
        refuse_not_finite(function, name, array, 1, labels(model, name))
    batch = common_batch(function, named)
    return tuple(loads), [np.broadcast_to(array, (*batch, array.shape[-1])) for array in named.values()]


def _refuse_overflow(function: str, named: Mapping[str, Array]) -> None:
    """Finite inputs whose result is not finite: name the one that is too large to be meant."""
    sizes = {name: float(np.abs(array).max(initial=0.0)) for name, array in named.items()}
    name = max(sizes, key=lambda n: sizes[n])
    if sizes[name] > HUGE:
        raise FreebodyError(
            f"{function}: {name} reaches {sizes[name]:.3g}; the result overflows. Check its units."
        )


def vector(function: str, model: Model, name: str, value: Any) -> Array:
    """q, qd, qdd, tau or a point as a checked array; one whose entries carry names (`labels`) is put in order."""
    array = as_floats(function, name, aligned(function, name, value, labels(model, name), _DIMS[_kind(name)]))
    symbol = "nq" if name in POSITIONS else "dim" if name in _POINTS else "nv"
    size = getattr(model, symbol)
    if array.shape[-1:] != (size,):
        check_core(function, name, array, (size,), f"model {model.name!r} has {symbol} = {size}")
    if name in POSITIONS and model.nq != model.nv:
        _check_quaternions(function, model, array)
    return array


_DIMS = {
    "positions": ("position", "joint"),
    "velocities": ("velocity", "joint"),
    "point": ("axis",),
}
_OF_WRENCH = ("component", "axis")
"""Dimensions of a DataArray that stand for the vector."""


def _kind(name: str) -> str:
    return "positions" if name in POSITIONS else "point" if name in _POINTS else "velocities"


def finite_vector(function: str, model: Model, name: str, value: Any) -> Array:
    """A `vector` that no kernel looks at: NaN and infinity are refused here."""
    array = vector(function, model, name, value)
    refuse_not_finite(function, name, array, 1, labels(model, name))
    return array


def single_vector(function: str, model: Model, name: str, value: Any) -> Array:
    """A `vector` of one sample, for what takes no batch."""
    array = vector(function, model, name, value)
    if array.ndim != 1:
        raise ShapeError(function, name, array.shape, str(array.shape[-1:]), "one sample, no batch")
    return array


def common_batch(function: str, named: Mapping[str, Array]) -> tuple[int, ...]:
    """The batch shape of vectors taken together; refuses those that do not broadcast."""
    try:
        return np.broadcast_shapes(*(array.shape[:-1] for array in named.values()))
    except ValueError:
        batches = ", ".join(f"{name} {array.shape[:-1]}" for name, array in named.items())
        raise FreebodyError(f"{function}: the batch shapes do not broadcast together: {batches}.") from None


def labels(model: Model, name: str) -> tuple[str, ...]:
    """Names of the entries of an input."""
    if name in POSITIONS:
        return model.position_names
    if name in _POINTS:
        return ("x", "y", "z")[: model.dim]
    if name.startswith("wrenches"):
        return ("fx", "fy", "fz", "mx", "my", "mz") if model.dim == 3 else ("fx", "fy", "m")
    return model.velocity_names


def _check_quaternions(function: str, model: Model, q: Array) -> None:
    for body, at in zip(model.bodies, model.coordinates, strict=True):
        start = body.kind.quaternion
        if start is not None:
            length = np.sqrt(np.sum(q[..., at.q[start : start + 4]] ** 2, axis=-1))
            off = np.argwhere(np.abs(length - 1.0) > _UNIT)
            if len(off):
                sample = tuple(map(int, off[0]))
                raise FreebodyError(
                    f"{function}: the quaternion of joint {body.joint.name!r}{at_sample(sample)} has length "
                    f"{length[sample]:.6g}; "
                    "it must be 1 within 1e-6: divide it by its length."
                )


def wrenches_by_frame(
    function: str, model: Model, wrenches: Wrenches, single: bool = False
) -> dict[str, Array]:
    """External wrenches (..., six) by frame, one by names fx, fy, … put in order; `single`: no batch."""
    if wrenches is None:
        return {}
    names = labels(model, "wrenches")
    given = wrenches if isinstance(wrenches, Mapping) else {model.frame().name: wrenches}
    loads = {}
    for frame, value in given.items():
        name = model.frame(frame).name
        if name in loads:
            raise FreebodyError(f"{function}: wrenches holds frame {name!r} twice; add the two wrenches up.")
        argument = f"wrenches[{name!r}]"
        loads[name] = as_floats(function, argument, aligned(function, argument, value, names, _OF_WRENCH))
        order = "force, then moment, world axes"
        check_core(function, argument, loads[name], (len(names),), order)
        if single and loads[name].ndim > 1:
            raise ShapeError(
                function, argument, loads[name].shape, f"({len(names)},)", f"one wrench: {order}"
            )
    return loads
