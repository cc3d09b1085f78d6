"""Work of every public function around its kernel: take vectors and dicts, check shapes, blame what
is not finite."""

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
    """The kernel of a formula on inputs in its order: an array, or a tuple of its outputs.

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
    """Evaluate by the kernel of an option that says NaN where there is something to look at; None
    there.

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
    """Answer nothing: None stands for whatever is not sure at once."""


def _place(key: CallKey, wrenches: FrameWrenchTable) -> CallKey:
    """Where a model keeps what answers under a key, and with wrenches on these frames."""
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
    """Evaluate by the kernel of the model's structure, the inputs looked at one by one.

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
    """Whether the kernel has been compiled for another model of the same structure; it is then kept
    at the place."""
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
    """Names of a formula's inputs without the wrenches."""
    inputs = FORMULAS[function].inputs
    return [name for name in inputs if name != "wrenches" and (name != "point" or option.point)]


def _given(wrenches: FrameWrenchTable) -> tuple[tuple[str | None, ...], tuple[ArrayLike, ...]]:
    """Frames as they were named, None being the tip, and the wrench on each."""
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
    """(frames with wrenches, arrays of the inputs and then the wrenches), all finite and of one
    batch shape, which ends in that of a family. called: arguments by other names than the formula's
    inputs."""
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
    """Arrays that a family adds to those whose batches must broadcast together."""
    return {"model.family": np.empty((*model.family, 0))} if model.family else {}


def refuse_overflow(function: str, named: Mapping[str, Array]) -> None:
    """Finite inputs whose result is not finite: name the one that is too large to be meant."""
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
    """How many axes one sample of an input has: vectors one, scalars none, matrices two."""
    given = INPUTS.get(name)
    return 1 if given is None else len(given.dims)


def _refuse_not_finite(function: str, model: Model, name: str, array: Array) -> None:
    named = labels(model, name) if _has_names(name) else ()
    refuse_not_finite(function, name, array, core_axes(name), named)


def _has_names(name: str) -> bool:
    """Whether the entries of an input have names that the model alone tells."""
    return core_axes(name) == 1 and _dimension(name) in _VECTORS


class _VectorNames(NamedTuple):
    """Vectors of one dimension: what a DataArray may call it, and the names of their entries."""

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
    """Dimension of an argument: inputs of formulas have theirs in the table, all others are along
    the rates."""
    if name.startswith("wrenches"):
        return "six"
    given = INPUTS.get(_ALIKE.get(name, name))
    return "nv" if given is None else str(given.dims[0])


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
    """The batch shape of inputs taken together; refuses those that do not broadcast."""
    shapes = {name: array.shape[: array.ndim - core_axes(name)] for name, array in named.items()}
    try:
        return np.broadcast_shapes(*shapes.values())
    except ValueError:
        batches = ", ".join(f"{name} {batch}" for name, batch in shapes.items())
        raise FreebodyError(
            f"{function}: the batch shapes do not broadcast together: {batches}."
        ) from None


def labels(model: Model, name: str) -> tuple[str, ...]:
    """Names of the entries of an input."""
    return _VECTORS[_dimension(name)].entries(model)


def check_quaternions(function: str, model: Model, q: Array) -> None:
    """Refuse positions (..., nq) with a quaternion that is not of unit length."""
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
    """External wrenches (..., six) by frame, one by names fx, fy, … put in order; `single`: no
    batch; name: of the argument."""
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
    """The name of axes given as `reference`; refuses unknown ones."""
    if reference not in allowed:
        raise UnknownNameError("reference", reference, "reference=", allowed)
    return reference
