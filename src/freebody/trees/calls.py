"""What every public function does around its kernel: take vectors and dicts, check shapes, blame what is not finite."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from freebody.arrays import Array, as_floats, at_sample, check_core, refuse_not_finite
from freebody.errors import FreebodyError, ShapeError
from freebody.kernels import structural
from freebody.kernels.formulas import FORMULAS, POSITIONS, Option
from freebody.labels import aligned, refuse_other_times
from freebody.model.model import Model
from freebody.model.required import require_model
from freebody.targets.sound import FEW, HUGE

Vector = ArrayLike | Mapping[str, float]
Wrenches = ArrayLike | Mapping[str, ArrayLike] | None

_POINTS = ("point", "about")
_UNIT = 1e-6  # how far a quaternion may be off unit length


def evaluate(
    function: str,
    model: Model,
    inputs: tuple[Any, ...],
    choice: tuple[Any, ...] | None = None,
    option: Callable[..., Option] | None = None,
    wrenches: Wrenches = None,
) -> Any:
    """The kernel of `function` on inputs in the formula's order: an array, or a tuple of its outputs.

    choice: what else was given, such as a frame's name; `option` makes an Option of the model and that. The kernel is
    that of the model's structure. One that was called before is tried at once, see `quick`. Then, and on the first
    call, the inputs are looked at one by one: every call gives the same answer, or the same refusal.
    """
    result = quick(function, model, inputs, choice, wrenches)
    if result is not None:
        return result
    require_model(function, model)
    if FORMULAS[function].chains == "open":
        model.require_tree(function)
    chosen = Option() if option is None else option(model, *(choice or ()))
    key = _key(function, choice, wrenches)
    if key not in model.compiled and _is_known(function, model, chosen, wrenches, key):
        result = quick(function, model, inputs, choice, wrenches)
        if result is not None:
            return result
    return _carefully(function, model, inputs, chosen, wrenches, key)


def quick(
    function: str,
    model: Model,
    inputs: tuple[Any, ...],
    choice: tuple[Any, ...] | None = None,
    wrenches: Wrenches = None,
) -> Any:
    """What `evaluate` returns where it is sure at once; None where there is something to look at.

    A kernel that was called before refuses wrong shapes and types by itself, and tells of inputs that carry names and
    of results that are not finite.
    """
    try:
        if wrenches is None:
            checked, numbers, quaternions = model.compiled[function if choice is None else (function, choice)]
            result = checked(*inputs, *numbers)
        else:
            frames, loads = _given(wrenches)
            checked, numbers, quaternions = model.compiled[function, choice, frames]
            result = checked(*inputs, *loads, *numbers)
        if quaternions and result is not None:
            for i, starts in quaternions:
                if not _are_unit(inputs[i], starts):
                    return None
        return result
    except (KeyError, TypeError, ValueError, AttributeError):
        return None  # explained by who looks closer


def attempt(
    function: str, model: Model, inputs: tuple[Any, ...], option: Option, wrenches: Wrenches = None
) -> Any:
    """What `quick` returns with the kernel of an option that says NaN where there is something to look at; None there.

    The kernel is the one that `quick` will try for this function and model from now on.
    """
    try:
        frames = () if wrenches is None else tuple(model.frame(name).name for name in _given(wrenches)[0])
    except FreebodyError:  # said in its turn
        return None
    if len(set(frames)) < len(frames):
        return None
    bound = structural.fetch(model, (function,), option._replace(wrench_frames=frames))
    _keep(function, model, option, bound, _key(function, None, wrenches), all_finite(bound.kernel))
    return quick(function, model, inputs, None, wrenches)


def all_finite(kernel: Any) -> Callable[..., Any]:
    """The kernel as it is called where a result that is not finite must not pass: `checked`, all of the results looked
    at, however many there are."""
    checked = kernel.checked

    def call(*arrays: Any) -> Any:
        result = checked(*arrays)
        if type(result) is np.ndarray and result.size > FEW and not np.isfinite(result).all():
            return None
        return result

    return call


def _key(function: str, choice: tuple[Any, ...] | None, wrenches: Wrenches) -> Any:
    """Under which a model keeps what `quick` calls."""
    if wrenches is not None:
        return function, choice, _given(wrenches)[0]
    return function if choice is None else (function, choice)


def _is_known(function: str, model: Model, option: Option, wrenches: Wrenches, key: Any) -> bool:
    """Whether the kernel has been compiled for another model of the same structure; then `quick` may call it."""
    try:
        frames = () if wrenches is None else tuple(model.frame(name).name for name in _given(wrenches)[0])
        loaded = option._replace(wrench_frames=frames) if frames else option
        bound = structural.known(model, (function,), loaded)
    except FreebodyError:  # said in its turn
        return False
    if bound is None or len(set(frames)) < len(frames):
        return False
    _keep(function, model, option, bound, key)
    return True


def _keep(
    function: str,
    model: Model,
    option: Option,
    bound: structural.Bound,
    key: Any,
    checked: Callable[..., Any] | None = None,
) -> None:
    starts = model.structure.quaternions
    names = _input_names(function, option)
    turning = tuple((i, starts) for i, name in enumerate(names) if starts and name in POSITIONS)
    model.compiled[key] = checked or bound.kernel.checked, bound.numbers, turning


def _input_names(function: str, option: Option) -> list[str]:
    """Inputs without wrenches."""
    inputs = FORMULAS[function].inputs
    return [name for name in inputs if name != "wrenches" and (name != "point" or option.point)]


def _given(wrenches: Wrenches) -> tuple[tuple[str | None, ...], tuple[ArrayLike, ...]]:
    """Frames as they were named, None being the tip, and the wrench on each."""
    if wrenches is None:
        return (), ()
    # most are; to ask an abstract class takes longer
    if type(wrenches) is dict or isinstance(wrenches, Mapping):
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
    function: str, model: Model, inputs: tuple[Any, ...], option: Option, wrenches: Wrenches, key: Any
) -> Any:
    """Check every input, call the kernel, and blame what is not finite."""
    names = _input_names(function, option)
    refuse_other_times(function, dict(zip(names, inputs, strict=True)))
    arrays = [vector(function, model, name, value) for name, value in zip(names, inputs, strict=True)]
    loads = wrenches_by_frame(function, model, wrenches)
    bound = structural.fetch(model, (function,), option._replace(wrench_frames=tuple(loads)))
    wrenched = [f"wrenches[{frame!r}]" for frame in loads]
    named = dict(zip([*names, *wrenched], [*arrays, *loads.values()], strict=True))
    common_batch(function, named | _of_family(model))
    result = bound(*named.values())
    if not all(np.isfinite(x).all() for x in (result if isinstance(result, tuple) else (result,))):
        for name, array in named.items():
            refuse_not_finite(function, name, array, 1, labels(model, name))
        _refuse_overflow(function, named)
    _keep(function, model, option, bound, key)
    return result


def checked_inputs(
    function: str, model: Model, given: Mapping[str, Any], wrenches: Wrenches
) -> tuple[tuple[str, ...], list[Array]]:
    """(frames with wrenches, arrays of the inputs and then the wrenches), all finite and of one batch shape, which ends
    in that of a family."""
    refuse_other_times(function, given)
    arrays = {name: vector(function, model, name, value) for name, value in given.items()}
    loads = wrenches_by_frame(function, model, wrenches)
    named = arrays | {f"wrenches[{frame!r}]": load for frame, load in loads.items()}
    for name, array in named.items():
        refuse_not_finite(function, name, array, 1, labels(model, name))
    batch = common_batch(function, named | _of_family(model))
    return tuple(loads), [np.broadcast_to(array, (*batch, array.shape[-1])) for array in named.values()]


def _of_family(model: Model) -> dict[str, Array]:
    """What a family adds to the arrays whose batches must go together."""
    return {"model.family": np.empty((*model.family, 0))} if model.family else {}


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
