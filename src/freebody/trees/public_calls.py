"""The part of every public function outside its kernel: take vectors and dicts, check shapes, and
raise errors about arguments that are not finite."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from freebody.arrays import Array, as_floats, at_sample, check_core, refuse_not_finite
from freebody.errors import FreebodyError, ShapeError, SingularError, UnknownNameError
from freebody.kernels import structural
from freebody.kernels.formula_variants import refuse_untaken
from freebody.kernels.formulas import FORMULAS, INPUTS, POSITIONS, Option
from freebody.kernels.tracing import shape
from freebody.labels import aligned, refuse_other_times
from freebody.model.model import Model
from freebody.model.model_argument import require_model
from freebody.outputs.number_text import compared
from freebody.targets.finite_check import HUGE, UNIT, Unclear

JointVector = ArrayLike | Mapping[str, float]
FrameWrenchTable = ArrayLike | Mapping[str, ArrayLike] | None


CallKey = str | tuple[Any, ...]
"""Name of a formula, or that and what else was chosen, such as a frame's name: under it a model
keeps what answers."""


def evaluate(
    key: CallKey,
    model: Model,
    inputs: tuple[Any, ...],
    option: Callable[..., Option] | None = None,
    wrenches: FrameWrenchTable = None,
    otherwise: Callable[..., Any] | None = None,
) -> Any:
    """Call the kernel of the formula of a key with the inputs in the formula's order; returns an
    array, or a tuple of the outputs.

    What was called before under the key is tried at once: it refuses wrong shapes and types by
    itself, and tells of inputs that carry names, of quaternions that are not of unit length, and of
    results that are not finite. There, and on the first call, `otherwise` answers, by default
    `careful`, with the same arguments: every call gives the same answer, or the same refusal.
    """
    given = None
    try:
        if wrenches is None:
            found = model.compiled[key](*inputs)
        elif type(wrenches) is dict and len(wrenches) == 1:  # most are
            [frame] = wrenches
            found = model.compiled[key, frame](*inputs, wrenches[frame])
        else:
            frames, loads = _given(wrenches)
            found = model.compiled[key, *frames](*inputs, *loads)
        if found is not None:
            return found
    except Unclear as problem:
        given = problem.result
    except (KeyError, TypeError, ValueError, AttributeError):
        pass  # explained by who looks closer
    if given is not None and otherwise is not None:  # who looks closer need not ask again
        return otherwise(key, model, inputs, option, wrenches, result=given)
    return (otherwise or careful)(key, model, inputs, option, wrenches)


def attempt(
    key: CallKey,
    model: Model,
    inputs: tuple[Any, ...],
    option: Option,
    wrenches: FrameWrenchTable = None,
) -> Any:
    """Call the fast kernel, whose outputs are NaN where an input needs a closer check; returns None
    in that case.

    The kernel is the one that it will try under this key from now on.
    """
    function = key if isinstance(key, str) else key[0]
    try:
        frames = (
            ()
            if wrenches is None
            else tuple(model.frame(name).name for name in _given(wrenches)[0])
        )
    except FreebodyError:  # said in its turn
        return None
    if len(set(frames)) < len(frames):
        return None
    bound = structural.fetch(model, (function,), option._replace(wrench_frames=frames))
    model.compiled[_place(key, wrenches)] = bound.checked(every=True)
    return evaluate(key, model, inputs, None, wrenches, _nothing)


def _nothing(*_: Any) -> None:
    """Return None, which means that the fast kernel cannot give the result."""


def _place(key: CallKey, wrenches: FrameWrenchTable) -> CallKey:
    """Key under which a model stores the function of a call, extended by the frames on which
    wrenches act."""
    if wrenches is None:
        return key
    frames, _ = _given(wrenches)
    return (key, *frames)


def careful(
    key: CallKey,
    model: Model,
    inputs: tuple[Any, ...],
    option: Callable[..., Option] | None = None,
    wrenches: FrameWrenchTable = None,
) -> Any:
    """Call the kernel of the model's structure after every input has been checked by itself.

    `option` makes an Option of the model and of what the key holds besides the name.
    """
    function, *choice = (key,) if isinstance(key, str) else key
    require_model(function, model)
    if FORMULAS[function].chains == "open":
        model.require_tree(function)
    refuse_untaken(function, model, FORMULAS[function])
    chosen = structural.PLAIN if option is None else option(model, *choice)
    place = _place(key, wrenches)
    if place not in model.compiled and _is_known(function, model, chosen, wrenches, place):
        return evaluate(key, model, inputs, option, wrenches)
    names = _input_names(function, chosen)
    refuse_other_times(function, dict(zip(names, inputs, strict=True)))
    arrays = [
        vector(function, model, name, value, chosen)
        for name, value in zip(names, inputs, strict=True)
    ]
    loads = wrenches_by_frame(function, model, wrenches)
    bound = structural.fetch(model, (function,), chosen._replace(wrench_frames=tuple(loads)))
    wrenched = [f"wrenches[{frame!r}]" for frame in loads]
    named = dict(zip([*names, *wrenched], [*arrays, *loads.values()], strict=True))
    common_batch(function, named | _of_family(model))
    result = bound(*named.values())
    if not all(np.isfinite(x).all() for x in (result if isinstance(result, tuple) else (result,))):
        for name, array in named.items():
            _refuse_not_finite(function, model, name, array)
        refuse_overflow(function, named)
        if "q" in named:
            refuse_without_length(function, model, named["q"])
    model.compiled[place] = bound.checked()
    return result


def _is_known(
    function: str, model: Model, option: Option, wrenches: FrameWrenchTable, place: Any
) -> bool:
    """Whether the kernel has been compiled for another model of the same structure; if so, it is
    also stored in this model."""
    try:
        frames = (
            ()
            if wrenches is None
            else tuple(model.frame(name).name for name in _given(wrenches)[0])
        )
        loaded = option._replace(wrench_frames=frames) if frames else option
        bound = structural.ready(model, (function,), loaded)
    except FreebodyError:  # said in its turn
        return False
    if bound is None or len(set(frames)) < len(frames):
        return False
    model.compiled[place] = bound.checked()
    return True


def _input_names(function: str, option: Option) -> list[str]:
    """Names of the inputs of a function's formula, without the wrenches."""
    inputs = FORMULAS[function].inputs
    return [name for name in inputs if name != "wrenches" and (name != "point" or option.point)]


def _given(wrenches: FrameWrenchTable) -> tuple[tuple[str | None, ...], tuple[ArrayLike, ...]]:
    """Frames on which wrenches act, as the caller named them (None: the tip), and the wrench on
    each."""
    if wrenches is None:
        return (), ()
    if isinstance(wrenches, Mapping):
        return tuple(wrenches), tuple(wrenches.values())
    return (None,), (wrenches,)


def checked_inputs(
    function: str,
    model: Model,
    given: Mapping[str, Any],
    wrenches: FrameWrenchTable,
    option: Option | None = None,
    called: Mapping[str, str] = MappingProxyType({}),
) -> tuple[tuple[str, ...], list[Array]]:
    """(names of the frames with wrenches, arrays of the inputs and then of the wrenches): all
    finite, and of one batch shape, which ends in the model's family shape. called: the formula's
    name of an argument that is called otherwise."""
    refuse_other_times(function, given)
    arrays = {
        called.get(name, name): vector(function, model, name, value, option)
        for name, value in given.items()
    }
    loads = wrenches_by_frame(function, model, wrenches)
    named = arrays | {f"wrenches[{frame!r}]": load for frame, load in loads.items()}
    for name, array in named.items():
        _refuse_not_finite(function, model, name, array)
    batch = common_batch(function, named | _of_family(model))
    return tuple(loads), [
        np.broadcast_to(array, (*batch, *array.shape[array.ndim - core_axes(name) :]))
        for name, array in named.items()
    ]


def _of_family(model: Model) -> dict[str, Array]:
    """For a family of models, an array with the family's shape, to be included when batch shapes
    are broadcast; {} for a single model."""
    return {"model.family": np.empty((*model.family, 0))} if model.family else {}


def refuse_overflow(function: str, named: Mapping[str, Array]) -> None:
    """Raise an error that names the largest input where finite inputs give a result that is not
    finite."""
    sizes = {name: float(np.abs(array).max(initial=0.0)) for name, array in named.items()}
    name = max(sizes, key=lambda n: sizes[n])
    if sizes[name] > HUGE:
        raise FreebodyError(
            f"{function}: {name} reaches {sizes[name]:.3g}; the result overflows. Check its units."
        )


def refuse_without_length(function: str, model: Model, q: Array) -> None:
    """Raise SingularError where both ends of a strut are at one place at finite q (..., nq): its
    force has no direction."""
    if not model.struts:
        return
    lengths = structural.fetch(model, ("strut_states",), structural.PLAIN)(q, np.zeros(model.nv))[0]
    bad = np.argwhere(lengths == 0.0)
    if len(bad):
        *sample, k = map(int, bad[0])
        raise SingularError(
            f"{function}: strut {model.strut_names[k]!r} of {model.name!r} has no "
            f"length{at_sample(sample)}: both its ends are at one place, and its force has no "
            f"direction. Choose another q, or move an end."
        )


def vector(
    function: str, model: Model, name: str, value: Any, option: Option | None = None
) -> Array:
    """q, qd, qdd, tau or a point as a checked array; one whose entries carry names (`labels`) is
    put in order. Inputs that are no vectors have their shape checked alone, and so have those of
    the rows of an option, which its function puts in order."""
    if not _has_names(name):
        array = as_floats(function, name, value)
        core = shape(model, INPUTS[name].dims, option or Option())
        check_core(function, name, array, core, INPUTS[name].meaning)
        return array
    dimension, names = _dimension(name), labels(model, name)
    array = as_floats(
        function, name, aligned(function, name, value, names, _VECTORS[dimension].dims)
    )
    size = len(names)
    if array.shape[-1:] != (size,):
        check_core(function, name, array, (size,), f"model {model.name!r} has {dimension} = {size}")
    if name in POSITIONS and model.nq != model.nv:
        check_quaternions(function, model, array)
    return array


def core_axes(name: str) -> int:
    """How many axes one sample of an input has: vectors 1, scalars 0, matrices 2."""
    given = INPUTS.get(name)
    return 1 if given is None else len(given.dims)


def _refuse_not_finite(function: str, model: Model, name: str, array: Array) -> None:
    named = labels(model, name) if _has_names(name) else ()
    refuse_not_finite(function, name, array, core_axes(name), named)


def _has_names(name: str) -> bool:
    """Whether the entries of an input have names that depend on the model."""
    return core_axes(name) == 1 and _dimension(name) in _VECTORS


class _VectorNames(NamedTuple):
    """Name of the dimension of one kind of vector: what a DataArray may call it, and the names of
    the entries."""

    dims: tuple[str, ...]
    entries: Callable[[Model], tuple[str, ...]]


_VECTORS = {
    "nq": _VectorNames(("position", "joint"), lambda model: model.position_names),
    "nv": _VectorNames(("velocity", "joint"), lambda model: model.velocity_names),
    "dim": _VectorNames(("axis",), lambda model: ("x", "y", "z")[: model.dim]),
    "six": _VectorNames(
        ("component", "axis"),
        lambda model: ("fx", "fy", "fz", "mx", "my", "mz") if model.dim == 3 else ("fx", "fy", "m"),
    ),
}
"""Names of vectors by the dimension of an input (`kernels.formulas.INPUTS`)."""


_ALIKE = {"about": "point", "waypoints": "q", "path": "q"}
"""Arguments that are vectors as an input of another name is."""


def _dimension(name: str) -> str:
    """Name of the dimension of an argument: from the table for inputs of formulas, along the rates
    for all others."""
    if name.startswith("wrenches"):
        return "six"
    given = INPUTS.get(_ALIKE.get(name, name))
    return "nv" if given is None else str(given.dims[0])


def finite_vector(function: str, model: Model, name: str, value: Any) -> Array:
    """The checked array of a `vector` argument that is passed to no kernel; raises an error for NaN
    or infinity."""
    array = vector(function, model, name, value)
    refuse_not_finite(function, name, array, 1, labels(model, name))
    return array


def single_vector(function: str, model: Model, name: str, value: Any) -> Array:
    """The checked array of a `vector` argument of one sample, for functions that take no batch."""
    array = vector(function, model, name, value)
    if array.ndim != 1:
        raise ShapeError(function, name, array.shape, str(array.shape[-1:]), "one sample, no batch")
    return array


def common_batch(function: str, named: Mapping[str, Array]) -> tuple[int, ...]:
    """The common batch shape of several inputs; raises an error if they do not broadcast
    together."""
    return common_shape(
        function, {name: x.shape[: x.ndim - core_axes(name)] for name, x in named.items()}
    )


def common_shape(function: str, shapes: Mapping[str, tuple[int, ...]]) -> tuple[int, ...]:
    """The common batch shape of inputs of these batch shapes; raises an error if they do not
    broadcast together."""
    try:
        return np.broadcast_shapes(*shapes.values())
    except ValueError:
        batches = ", ".join(f"{name} {batch}" for name, batch in shapes.items())
        raise FreebodyError(
            f"{function}: the batch shapes do not broadcast together: {batches}."
        ) from None


def labels(model: Model, name: str) -> tuple[str, ...]:
    """Names of the entries of a function's input, such as the coordinates of q."""
    return _VECTORS[_dimension(name)].entries(model)


def check_quaternions(function: str, model: Model, q: Array) -> None:
    """Raise an error if positions q (..., nq) have a quaternion that is not of unit length."""
    for body, at in zip(model.bodies, model.coordinates, strict=True):
        start = body.kind.quaternion
        if start is not None:
            length = np.sqrt(np.sum(q[..., at.q[start : start + 4]] ** 2, axis=-1))
            off = np.argwhere(np.abs(length - 1.0) > UNIT)
            if len(off):
                sample = tuple(map(int, off[0]))
                size, unit = compared(length[sample], 1.0, digits=6)
                raise FreebodyError(
                    f"{function}: the quaternion of joint {body.joint.name!r}{at_sample(sample)} "
                    f"has length {size}; it must be {unit} within 1e-6: divide it by its length."
                )


def wrenches_by_frame(
    function: str,
    model: Model,
    wrenches: FrameWrenchTable,
    single: bool = False,
    name: str = "wrenches",
) -> dict[str, Array]:
    """External wrenches (..., six) by frame; a wrench with named entries fx, fy, … is put in order.
    single: no batch is allowed. name: of the argument, for errors."""
    if wrenches is None:
        return {}
    names = labels(model, "wrenches")
    given = wrenches if isinstance(wrenches, Mapping) else {model.frame().name: wrenches}
    loads = {}
    for frame, value in given.items():
        known = model.frame(frame).name
        if known in loads:
            raise FreebodyError(
                f"{function}: {name} holds frame {known!r} twice; add the two wrenches up."
            )
        argument = f"{name}[{known!r}]"
        loads[known] = as_floats(
            function, argument, aligned(function, argument, value, names, _VECTORS["six"].dims)
        )
        order = "force, then moment, world axes"
        check_core(function, argument, loads[known], (len(names),), order)
        if single and loads[known].ndim > 1:
            raise ShapeError(
                function, argument, loads[known].shape, f"({len(names)},)", f"one wrench: {order}"
            )
    return loads


def checked_reference(reference: str, allowed: tuple[str, ...] = ("world", "body")) -> str:
    """The `reference` argument, if it is one of the allowed axes ("world", "body"); raises an error
    otherwise."""
    if reference not in allowed:
        raise UnknownNameError("reference", reference, "reference=", allowed)
    return reference
