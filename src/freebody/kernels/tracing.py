"""From formulas and a model to their program: what it takes and returns, the trace, and derivatives
by any of its inputs, for which scalars have slopes in the trace."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Sequence
from typing import Any

from freebody.algorithms.kinematics import position_rates
from freebody.algorithms.regressor import parameter_values
from freebody.algorithms.regrouped_parameters import lightened
from freebody.dual import Outer, slopes, value
from freebody.elementary import Scalar
from freebody.errors import SingularError, UnknownNameError
from freebody.kernels.formulas import FORMULAS, INPUTS, POSITIONS, Option
from freebody.kernels.formulas.inverse import known_branches
from freebody.kernels.formulas.record import Dimensions, Evaluation
from freebody.model.families import FamilyError
from freebody.model.inertial_parameters import parameter_names
from freebody.model.model import Model
from freebody.model.tree import Tree
from freebody.program import Argument, Program, trace
from freebody.spatial import identity


def program(
    model: Model,
    names: tuple[str, ...],
    option: Option,
    p: Argument | None = None,
    over: Callable[[Sequence[Scalar]], Tree] | None = None,
    by: tuple[str, ...] = (),
) -> Program:
    """Trace the formulas over scalars, for this model; of two ways to the same values the shorter.

    p: some of the model's numbers, as a last input. over: the tree over the scalars of p. by:
    inputs by which the outputs are differentiated.
    """
    if model.family and p is None:
        raise FamilyError(f"the program of {', '.join(names)}", model.name, model.family)
    fixed = model.tree if p is None or over is None else over([1.0] * p.size)
    inputs = arguments(model, names, option) if p is None else (*arguments(model, names, option), p)
    labels = [a.name for a in inputs]
    outputs = _outputs(model, names, option, fixed)
    sizes = _directions(model, inputs, by)

    def traced(ways: dict[str, Evaluation]) -> Program:
        def evaluate(*values: Any) -> tuple[Any, ...]:
            given, tree = _lifted(dict(zip(labels, values, strict=True)), sizes, fixed, over)
            if all(FORMULAS[name].by_motion for name in names):
                tree = lightened(tree)  # no output shows the links one by one
            results = tuple(
                x for name in names for x in ways[name](tree, option, **chosen(name, given, option))
            )
            return _with_slopes(results, outputs, sizes)

        try:
            return trace(
                "_".join(names), evaluate, inputs, (*outputs, *_slope_arguments(outputs, sizes))
            )
        except ZeroDivisionError:
            raise SingularError(
                f"{', '.join(names)} of {model.name!r} divides by zero in every state: a joint "
                f"moves no mass and no inertia, or a loop does not hold anything."
            ) from None

    first = traced({name: FORMULAS[name].evaluate for name in names})
    others = _other_ways(names)
    if model.nv > _SMALL or not others:
        return first
    return min(first, traced(others), key=lambda program: sum(program.operations.values()))


_SMALL = 12
"""Coordinates up to which two ways to the same values are both traced."""


def _other_ways(names: tuple[str, ...]) -> dict[str, Evaluation]:
    """Each formula's second way, or its first where it has one only; none where all have one."""
    if all(FORMULAS[name].another is None for name in names):
        return {}
    return {name: FORMULAS[name].another or FORMULAS[name].evaluate for name in names}


def arguments(model: Model, names: tuple[str, ...], option: Option) -> tuple[Argument, ...]:
    """Inputs that the formulas need, each once, in the fixed order."""
    wanted = {label for name in names for label in FORMULAS[name].inputs}
    plain = [
        Argument(name, shape(model, given.dims, option))
        for name, given in INPUTS.items()
        if name in wanted and _is_given(name, option)
    ]
    loads = option.wrench_frames if "wrenches" in wanted else ()
    # by index: the frames' names come from outside, and a program's names stand in generated text
    return (
        *plain,
        *(Argument(_wrench(k), shape(model, ("six",), option)) for k in range(len(loads))),
    )


def _is_given(name: str, option: Option) -> bool:
    """Whether a model and option have an input that others lack."""
    return {"point": option.point, "redundancy": option.redundant}.get(name, True)


def _wrench(k: int) -> str:
    """Name of the input that acts at frame k of `wrench_frames`."""
    return f"wrench{k}"


def chosen(name: str, given: dict[str, Any], option: Option) -> dict[str, Any]:
    """The inputs that a formula takes, out of all that are given."""
    taken = {x: given[x] for x in FORMULAS[name].inputs if x in given}
    if "wrenches" in FORMULAS[name].inputs:
        taken["wrenches"] = tuple(given[_wrench(k)] for k in range(len(option.wrench_frames)))
    return taken


def _outputs(
    model: Model, names: tuple[str, ...], option: Option, tree: Tree
) -> tuple[Argument, ...]:
    """The formulas' outputs; of several formulas each is named after its own."""
    return tuple(
        Argument(
            f"{name}_{label}" if len(names) > 1 else label, shape(model, output.dims, option, tree)
        )
        for name in names
        for label, output in FORMULAS[name].outputs.items()
    )


def shape(
    model: Model, dims: Dimensions, option: Option, tree: Tree | None = None
) -> tuple[int, ...]:
    """The sizes of named dimensions; of the numbers that a tree has, where its scalars are not the
    model's own."""
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
            (tree or model.tree).constraints
            if option.equations is None
            else len(option.equations.rows)
        ),
        "constraints": lambda: (tree or model.tree).constraints,
        "loose": lambda: (
            (tree or model.tree).constraints
            - len(option.partition.rows if option.partition else ())
        ),
        "reactions": lambda: len(model.bodies) + len(model.loops),
        "branches": lambda: known_branches(tree or model.tree, option).count,
        "parameters": lambda: len(
            parameter_names(model) if tree is None else parameter_values(tree)
        ),
    }
    return tuple(d if isinstance(d, int) else sizes[d]() for d in dims)


def _directions(model: Model, inputs: Sequence[Argument], by: Sequence[str]) -> dict[str, int]:
    """How many directions there are of each input by which the outputs are differentiated: of
    positions nv, tangent ones; 0 stands for the one of a bare number."""
    sizes = {a.name: model.nv if a.name in POSITIONS else a.size if a.shape else 0 for a in inputs}
    for name in by:
        if name not in sizes:
            raise UnknownNameError("input", name, "by=", sizes)
    return {name: sizes[name] for name in dict.fromkeys(by)}


def _lifted(
    given: dict[str, Any],
    sizes: dict[str, int],
    fixed: Tree,
    over: Callable[[Sequence[Scalar]], Tree] | None,
) -> tuple[dict[str, Any], Tree]:
    """The inputs, some with slopes, and the tree over those of p."""
    starts, start = {}, 0
    for name, size in sizes.items():
        starts[name], start = start, start + (size or 1)
    plain = given
    given = dict(given)
    for name in sizes:
        if name not in POSITIONS:
            given[name] = _units(plain[name], itertools.count(starts[name]))
    p = given.pop("p", None)
    tree = fixed if over is None else over(p)
    for name in sizes:
        if name in POSITIONS:
            q = plain[name]
            along = [position_rates(tree, q, unit) for unit in identity(tree.nv)]
            given[name] = tuple(
                Outer(x, {starts[name] + k: rates[i] for k, rates in enumerate(along)})
                for i, x in enumerate(q)
            )
    return given, tree


def _units(scalars: Any, numbers: Iterator[int]) -> Any:
    """Each scalar with a slope of its own, a matrix's row by row."""
    if not isinstance(scalars, tuple):
        return Outer(scalars, {next(numbers): 1.0})
    return tuple(_units(x, numbers) for x in scalars)


def _with_slopes(
    results: tuple[Any, ...], outputs: Sequence[Argument], sizes: dict[str, int]
) -> tuple[Any, ...]:
    """The values, then of each result in turn its slopes by each of the inputs."""
    if not sizes:
        return results
    count = sum(size or 1 for size in sizes.values())
    found = [
        _each(x, len(a.shape), lambda s: value(s, Outer))
        for x, a in zip(results, outputs, strict=True)
    ]
    for x, a in zip(results, outputs, strict=True):
        start = 0
        for size in sizes.values():
            at = slice(start, start + size) if size else start
            found.append(_each(x, len(a.shape), lambda s, at=at: slopes(s, count, Outer)[at]))
            start += size or 1
    return tuple(found)


def _slope_arguments(outputs: Sequence[Argument], sizes: dict[str, int]) -> tuple[Argument, ...]:
    """d<output>_d<input> (*output, directions); by a bare number of the output's shape."""
    return tuple(
        Argument(f"d{a.name}_d{name}", (*a.shape, *((size,) if size else ())))
        for a in outputs
        for name, size in sizes.items()
    )


def _each(nested: Any, depth: int, function: Callable[[Any], Any]) -> Any:
    return function(nested) if depth == 0 else tuple(_each(x, depth - 1, function) for x in nested)
