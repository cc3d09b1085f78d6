"""From a model and the name of a formula to its kernel, or to its value over plain arrays."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from freebody.algorithms.regressor import parameter_values
from freebody.algorithms.regroup import lightened
from freebody.arrays import Array
from freebody.elementary import Scalar
from freebody.errors import FreebodyError, KindError, SingularError, UnknownNameError
from freebody.kernels.closed_chains import closed
from freebody.kernels.columns import BY_COLUMNS, LARGEST, ColumnKernel, KernelList
from freebody.kernels.formulas import (
    FORMULAS,
    OF_INDEPENDENT_EQUATIONS,
    OF_LOOPS,
    OF_PARTITION,
    OF_TREES,
    POSITIONS,
    Option,
)
from freebody.kernels.inputs import InputKernel, input_kernel, inputs_of
from freebody.kernels.slopes import directions, lifted, slope_arguments, with_slopes
from freebody.model.identified import parameter_names
from freebody.model.members import FamilyError
from freebody.model.model import Model
from freebody.model.numbers import Name
from freebody.model.tree import Tree
from freebody.program import Argument, Program, trace
from freebody.targets import Kernel, compile_program


def kernel(
    model: Model,
    names: str | Sequence[str],
    *,
    frame: str | None = None,
    reference: str = "world",
    wrench_frames: Sequence[str] = (),
    rows: Sequence[str] | None = None,
    target: str | None = None,
    width: int | None = None,
    dtype: str = "float64",
    inputs: Name | Sequence[Name] = (),
    by: str | Sequence[str] = (),
) -> Kernel | ColumnKernel | KernelList | InputKernel:
    """The compiled function for one quantity, or for several that share their work.

    model: with all values. names: among "inverse_dynamics", "forward_dynamics", "mass_matrix", "jacobian", … or a list.
    frame: for kinematic quantities (default: the tip). reference: "world" or "body" axes (for joint wrenches "child").
    rows: of operational space, among "vx", "vy", "vz", "wx", "wy", "wz" (plane "vx", "vy", "w"; default all).
    wrench_frames: frames that carry external wrenches; each becomes a further input (..., 6): wrench0, wrench1, … in
    their order.
    target: where it runs: "cpu" (machine code by LLVM) or "numpy" (node by node, without a compiler); None: what the
    environment's FREEBODY_TARGET says, else the CPU. width: samples in a vector of the CPU's; None: what suits it.
    dtype: "float32" computes with numbers of 32 bits, about twice as quick in batches, to about 6 digits of a sample's
    largest entry; arrays of other real types are rounded to it, and so are the robot's numbers.
    inputs: numbers of the model that are to be given, by names and patterns of `fb.parameters` ("link*.mass"; patterns
    leave out exact zeros and right angles of placements, names in full take them): they are gathered, in the order of
    `fb.parameters`, in one last argument p (..., k), or given as p={name: value}; without p they are the model's own.
    k.parameters are their names, k.values the model's own. Of a family all numbers with members are inputs.
    by: inputs by which each output is differentiated as well (exactly, in forward mode), "p" among them: behind the
    outputs follow dtau_dp (*output, k) and so on, of each output in turn; by positions on the tangent space (nv).
    Returns k(q, qd, …, out=None, threads=None), which broadcasts like a NumPy ufunc, lets NaN through and checks no
    names; its inputs are those of the quantities, in the order q, qd, qdd, tau, wrenches, and its outputs in the order
    of `names`. Dynamics of a closed chain take its state to be closed, and are not defined at singular positions, where
    the functions of the same names are: torques of the drives are NaN there. One step of a simulation is a quantity
    too: "rk4_step", "semi_implicit_step", "implicit_step" and "implicit_feedback_step", with the step's length h after
    tau, return (q1, qd1); see docs/stepping.md. Raises UnknownNameError, SingularError where the drives of a closed
    chain do not force its motion.
    """
    listed, option = chosen_option(
        model, names, frame=frame, reference=reference, wrench_frames=wrench_frames, rows=rows
    )
    return fetch(
        model,
        listed,
        option,
        target,
        width,
        dtype,
        several("fb.kernel", "inputs=", inputs),
        several("fb.kernel", "by=", by),
    )


def several(function: str, argument: str, given: Any) -> tuple[Any, ...]:
    """One name, or several, as a tuple."""
    if isinstance(given, str):
        return (given,)
    if not isinstance(given, (list, tuple)):
        raise KindError(function, argument, given, "a name or a list of names")
    return tuple(given)


def _near_home(function: str, model: Model, listed: tuple[str, ...], option: Option) -> Option:
    """Of a closed chain's equations and coordinates those that tell all near its home, whatever positions will come."""
    if any(name in OF_INDEPENDENT_EQUATIONS for name in listed):
        option = option._replace(equations=closed("independent_rows")(model))
    for name in listed:
        if name in OF_PARTITION and option.partition is None:
            option = option._replace(partition=closed("require_partition")(model, f"{function}: {name}"))
    return option


def chosen_option(
    model: Model,
    names: str | Sequence[str],
    *,
    frame: str | None = None,
    reference: str = "world",
    wrench_frames: Sequence[str] = (),
    rows: Sequence[str] | None = None,
    function: str = "fb.kernel",
) -> tuple[tuple[str, ...], Option]:
    """The names as a tuple and the structure that is meant, checked; arguments as for `kernel`.

    function: what was called, for errors.
    """
    listed = several(function, "names", names)
    for name in listed:
        if name not in FORMULAS:
            raise UnknownNameError("quantity", name, function, FORMULAS)
        if listed.count(name) > 1:
            raise FreebodyError(f"{function}: the quantity {name!r} is asked for twice.")
        if name in OF_TREES:
            model.require_tree(f"{function}: {name}")
        if name in OF_LOOPS and not model.loops:
            raise FreebodyError(
                f"{function}: {name}: {model.name!r} has no loops; add one with model.with_loop(...)."
            )
    if not listed:
        raise FreebodyError(f"{function}: give at least one quantity.")
    references = ("world", "child") if listed == ("joint_wrenches",) else ("world", "body")
    if reference not in references:
        raise UnknownNameError("reference", reference, "reference=", references)
    needs_frame = any(name in _FRAMED for name in listed)
    _require_used(function, listed, frame=frame, reference=reference, wrench_frames=wrench_frames, rows=rows)
    option = Option(
        model.frame(frame).name if needs_frame or frame is not None else None,
        reference,
        tuple(model.frame(f).name for f in wrench_frames),
        rows=motion_rows(model, rows),
    )
    return listed, _near_home(function, model, listed, option) if model.loops else option


def motion_rows(model: Model, rows: Sequence[str] | None) -> tuple[int, ...]:
    """Indices of rows of a frame's motion by name; None is all of them."""
    names = ("vx", "vy", "vz", "wx", "wy", "wz") if model.dim == 3 else ("vx", "vy", "w")
    if rows is not None and (isinstance(rows, str) or not len(rows) or len(set(rows)) < len(rows)):
        raise FreebodyError(f"rows is {rows!r}, expected one or several of {', '.join(names)}, each once.")
    for row in rows or ():
        if row not in names:
            raise UnknownNameError("row", row, "rows=", names)
    return tuple(names.index(row) for row in (names if rows is None else rows))


_FRAMED = (
    "forward_kinematics",
    "velocity",
    "acceleration",
    "jacobian",
    "jacobian_dot",
    "jacobian_derivatives",
    "operational_space_inertia",
    "operational_space_bias",
)
_USED_BY = {
    "frame": _FRAMED,
    "reference": ("jacobian", "jacobian_dot", "jacobian_derivatives", "joint_wrenches"),
    "wrench_frames": tuple(name for name, formula in FORMULAS.items() if "wrenches" in formula.inputs),
    "rows": ("operational_space_inertia", "operational_space_bias"),
}
"""Quantities that an option is for."""


def _require_used(function: str, listed: Sequence[str], **given: Any) -> None:
    """Refuse an option that none of the quantities uses."""
    for name, value in given.items():
        used = _USED_BY[name]
        if value not in (None, (), "world") and len(value) and not set(used) & set(listed):
            raise FreebodyError(
                f"{function}: {name}={value!r} has no meaning for {', '.join(listed)}; it is for {', '.join(used)}."
            )


SMALL = 12
"""Coordinates up to which two ways to the same values are both traced."""

_ORDER = (
    *("q", "q0", "q1", "qd", "qdd", "v", "tau", "x", "dq", "dqd", "multipliers", "reactions", "point"),
    *("h", "q_ref", "qd_ref", "kp", "kd"),
)


def fetch(
    model: Model,
    names: tuple[str, ...],
    option: Option,
    target: str | None = None,
    width: int | None = None,
    dtype: str = "float64",
    inputs: tuple[Name, ...] = (),
    by: tuple[str, ...] = (),
) -> Any:
    """The kernel, compiled on first use and kept as long as the model."""
    key = (names, option, target, width, dtype, inputs, by)
    found = model.compiled.get(key)
    if found is None:
        large = [name for name in names if model.nv > LARGEST and name in BY_COLUMNS]
        if large and dtype != "float64":
            raise FreebodyError(
                f"fb.kernel: {large[0]} of {model.nv} coordinates is made column by column, which is there in float64 "
                f"only (dtype={dtype!r} up to {LARGEST} coordinates)."
            )
        if inputs or by or model.family:
            found = _with_inputs(model, names, option, target, width, dtype, inputs, by)
        else:
            found = in_columns(
                model,
                names,
                option,
                lambda part: fetch(model, (part,), Option(), target, width),
                lambda some: fetch(model, some, option, target, width),
            ) or compile_program(program(model, names, option), target=target, width=width, dtype=dtype)
        model.compiled[key] = found
    return found


def in_columns(
    model: Model,
    names: tuple[str, ...],
    option: Option,
    fetch_product: Callable[[str], Any],
    fetch_some: Callable[[tuple[str, ...]], Any],
) -> ColumnKernel | KernelList | None:
    """Of a large robot, the matrices among the quantities by columns; None where all are one program.

    fetch_product: the kernel of a formula that columns come from; fetch_some: of some of the quantities.
    """
    if model.nv <= LARGEST or not any(name in BY_COLUMNS for name in names):
        return None
    if len(names) == 1:
        return ColumnKernel(names[0], arguments(model, names, option), model.nv, fetch_product)
    return _in_parts(model, names, option, fetch_some)


def _with_inputs(
    model: Model,
    names: tuple[str, ...],
    option: Option,
    target: str | None,
    width: int | None,
    dtype: str,
    wanted: tuple[Name, ...],
    by: tuple[str, ...],
) -> Kernel | InputKernel:
    """A kernel with numbers of the model as inputs, or with derivatives."""
    large = [name for name in names if model.nv > LARGEST and name in BY_COLUMNS]
    if large:
        raise FreebodyError(
            f"fb.kernel: {large[0]} of {model.nv} coordinates is made column by column, which takes no inputs=, by= or "
            f"family (up to {LARGEST} coordinates they do)."
        )
    if not wanted and not model.family:
        return compile_program(program(model, names, option, by=by), target=target, width=width, dtype=dtype)
    given = inputs_of("fb.kernel", model, wanted)
    # a family's numbers never stand still along the batch
    p = Argument("p", (len(given.names),), uniform=not model.family)
    traced = program(model, names, option, p, given.tree, by)
    compiled = compile_program(traced, target=target, width=width, dtype=dtype)
    return input_kernel(compiled, given.names, given.values, model)


def _in_parts(
    model: Model, names: tuple[str, ...], option: Option, fetch_some: Callable[[tuple[str, ...]], Any]
) -> KernelList:
    """Quantities by columns each alone, all others in one program that shares their work."""
    together = tuple(name for name in names if name not in BY_COLUMNS)
    groups = [(name,) for name in names if name in BY_COLUMNS] + ([together] if together else [])
    first, places = 0, {}
    for name in names:
        places[name] = list(range(first, first + len(FORMULAS[name].outputs)))
        first += len(FORMULAS[name].outputs)
    parts = [
        (
            fetch_some(some),
            [a.name for a in arguments(model, some, option)],
            [k for x in some for k in places[x]],
        )
        for some in groups
    ]
    return KernelList(arguments(model, names, option), parts)


def program(
    model: Model,
    names: tuple[str, ...],
    option: Option,
    p: Argument | None = None,
    over: Callable[[Sequence[Scalar]], Tree] | None = None,
    by: tuple[str, ...] = (),
) -> Program:
    """What the formulas do to scalars, for this model; with p, some of its numbers, as a last input.

    over: the tree over the scalars of p. by: inputs by which the outputs are differentiated.
    """
    if model.family and p is None:
        raise FamilyError(f"the program of {', '.join(names)}", model.name, model.family)
    fixed = model.tree if p is None or over is None else over([1.0] * p.size)
    inputs = arguments(model, names, option) if p is None else (*arguments(model, names, option), p)
    labels = [a.name for a in inputs]
    outputs = tuple(
        Argument(f"{name}_{label}" if len(names) > 1 else label, _shape(model, dims, option, fixed))
        for name in names
        for label, dims in FORMULAS[name].outputs.items()
    )
    sizes = directions(model, inputs, by)

    def traced(ways: dict[str, Callable[..., tuple[Any, ...]]]) -> Program:
        def evaluate(*values: Any) -> tuple[Any, ...]:
            given, tree = lifted(dict(zip(labels, values, strict=True)), sizes, fixed, over)
            if all(FORMULAS[name].by_motion for name in names):  # no output shows the links one by one
                tree = lightened(tree)
            results = tuple(
                x for name in names for x in ways[name](tree, option, **chosen(name, given, option))
            )
            return with_slopes(results, outputs, sizes)

        try:
            return trace("_".join(names), evaluate, inputs, (*outputs, *slope_arguments(outputs, sizes)))
        except ZeroDivisionError:
            raise SingularError(
                f"{', '.join(names)} of {model.name!r} divides by zero in every state: a joint moves no mass and no "
                "inertia, or a loop does not hold anything."
            ) from None

    first = traced({name: FORMULAS[name].evaluate for name in names})
    others = {name: FORMULAS[name].another or FORMULAS[name].evaluate for name in names}
    if model.nv > SMALL or all(FORMULAS[name].another is None for name in names):
        return first
    return min(first, traced(others), key=lambda program: sum(program.operations.values()))


def reference(model: Model, name: str, option: Option, *arrays: Array) -> Array | tuple[Array, ...]:
    """The formula run on NumPy arrays instead of the compiled kernel; arguments and results as for the kernel."""
    inputs = arguments(model, (name,), option)
    batch = np.broadcast_shapes(
        *(a.shape[: a.ndim - len(argument.shape)] for a, argument in zip(arrays, inputs, strict=True))
    )
    given = {
        argument.name: _scalars(np.broadcast_to(a, batch + argument.shape), len(argument.shape))
        for argument, a in zip(inputs, arrays, strict=True)
    }
    formula = FORMULAS[name]
    values = formula.evaluate(model.tree, option, **chosen(name, given, option))
    results = tuple(
        _array(value, batch, _shape(model, dims, option))
        for value, dims in zip(values, formula.outputs.values(), strict=True)
    )
    return results[0] if len(results) == 1 else results


def _array(value: Any, batch: tuple[int, ...], shape: tuple[int, ...]) -> Array:
    """Nested scalars as one array (*batch, *shape)."""
    flat = [np.broadcast_to(np.asarray(x, dtype=float), batch) for x in _flat(value, len(shape))]
    return np.stack(flat, axis=-1).reshape(batch + shape) if flat else np.zeros(batch + shape)


def arguments(model: Model, names: tuple[str, ...], option: Option) -> tuple[Argument, ...]:
    """Inputs that the formulas need, each once, in the fixed order."""
    wanted = {label for name in names for label in FORMULAS[name].inputs}
    shapes = dict.fromkeys(POSITIONS, (model.nq,)) | {
        "point": (model.dim,),
        "multipliers": (model.tree.constraints if "multipliers" in wanted else 0,),
        "reactions": _shape(model, ("reactions", "six"), option),
        "h": (),
    }
    plain = [
        Argument(x, shapes.get(x, (model.nv,)))
        for x in _ORDER
        if x in wanted and (x != "point" or option.point)
    ]
    loads = option.wrench_frames if "wrenches" in wanted else ()
    # by index: the frames' names come from outside, and a program's names stand in generated text
    return (*plain, *(Argument(_wrench(k), _shape(model, ("six",), option)) for k in range(len(loads))))


def _wrench(k: int) -> str:
    """Name of the input that acts at frame k of `wrench_frames`."""
    return f"wrench{k}"


def chosen(name: str, given: dict[str, Any], option: Option) -> dict[str, Any]:
    """Of the given inputs those that a formula takes."""
    taken = {x: given[x] for x in FORMULAS[name].inputs if x in given}
    if "wrenches" in FORMULAS[name].inputs:
        taken["wrenches"] = tuple(given[_wrench(k)] for k in range(len(option.wrench_frames)))
    return taken


def _shape(
    model: Model, dims: tuple[str | int, ...], option: Option, tree: Tree | None = None
) -> tuple[int, ...]:
    sizes = {
        "nq": lambda: model.nq,
        "nv": lambda: model.nv,
        "nj": lambda: len(model.bodies),
        "six": lambda: 6 if model.dim == 3 else 3,
        "dim": lambda: model.dim,
        "angular": lambda: 3 if model.dim == 3 else 1,
        "pose": lambda: model.dim + 1,
        "rows": lambda: len(option.rows),
        "equations": lambda: (
            (tree or model.tree).constraints if option.equations is None else len(option.equations)
        ),
        "constraints": lambda: (tree or model.tree).constraints,
        "loose": lambda: (
            (tree or model.tree).constraints - len(option.partition.rows if option.partition else ())
        ),
        "reactions": lambda: len(model.bodies) + len(model.loops),
        "parameters": lambda: parameter_count(model) if tree is None else len(parameter_values(tree)),
    }
    return tuple(d if isinstance(d, int) else sizes[d]() for d in dims)


def parameter_count(model: Model) -> int:
    """Columns of the regressors: the parameters of bodies, then of the joints that have a drive."""
    return len(parameter_names(model))


def _scalars(array: Array, core: int) -> Any:
    """An array as nested tuples over its core axes, each entry an array over the batch."""
    if core == 0:
        return array
    axis = array.ndim - core
    return tuple(_scalars(np.take(array, i, axis=axis), core - 1) for i in range(array.shape[axis]))


def _flat(value: Any, depth: int) -> list[Any]:
    return [value] if depth == 0 else [x for item in value for x in _flat(item, depth - 1)]
