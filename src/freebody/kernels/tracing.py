"""Formulas traced with a model into a program: its inputs and outputs, the trace, and derivatives
by any of its inputs."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from freebody.algorithms.kinematics import position_rates
from freebody.algorithms.regressor import parameter_values
from freebody.algorithms.regrouped_parameters import lightened
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
from freebody.program.derivative import Directions, differentiated
from freebody.spatial import Vector, identity


def program(
    model: Model,
    names: tuple[str, ...],
    option: Option,
    p: Argument | None = None,
    over: Callable[[Sequence[Scalar]], Tree] | None = None,
    by: tuple[str, ...] = (),
) -> Program:
    """The program of some formulas for a model, traced over scalars; the shorter one where formulas
    have two ways of evaluation.

    p: some of the model's numbers, as a last input. over: the tree over the scalars of p. by:
    inputs by which the outputs are differentiated.
    """
    if model.family and p is None:
        raise FamilyError(f"the program of {', '.join(names)}", model.name, model.family)
    fixed = model.tree if p is None or over is None else over([1.0] * p.size)
    inputs = arguments(model, names, option) if p is None else (*arguments(model, names, option), p)
    labels = [a.name for a in inputs]
    outputs = _outputs(model, names, option, fixed)
    directions = _directions(fixed, labels, inputs, by)

    def traced(ways: dict[str, Evaluation]) -> Program:
        def evaluate(*values: Any) -> tuple[Any, ...]:
            given = dict(zip(labels, values, strict=True))
            tree = fixed if over is None else over(given.pop("p"))
            if all(FORMULAS[name].by_motion for name in names):
                tree = lightened(tree)  # no output shows the links one by one
            return tuple(
                x for name in names for x in ways[name](tree, option, **chosen(name, given, option))
            )

        try:
            plain = trace("_".join(names), evaluate, inputs, outputs)
            return differentiated(plain, directions) if directions else plain
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
    """The alternative evaluation of each formula that has one, the usual one of the others; empty
    where none has an alternative."""
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
    """Whether the option makes use of an input that only some kernels have."""
    return {"point": option.point, "redundancy": option.redundant}.get(name, True)


def _wrench(k: int) -> str:
    """Name of the input for the wrench on frame k of `wrench_frames`."""
    return f"wrench{k}"


def chosen(name: str, given: dict[str, Any], option: Option) -> dict[str, Any]:
    """The arguments that a formula's evaluation takes, out of all inputs given."""
    taken = {x: given[x] for x in FORMULAS[name].inputs if x in given}
    if "wrenches" in FORMULAS[name].inputs:
        taken["wrenches"] = tuple(given[_wrench(k)] for k in range(len(option.wrench_frames)))
    return taken


def _outputs(
    model: Model, names: tuple[str, ...], option: Option, tree: Tree
) -> tuple[Argument, ...]:
    """The outputs of the formulas by name; with several formulas each output's name begins with its
    formula's."""
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
    """The sizes of named dimensions; those of the numbers of drives and bodies are taken from the
    tree where one is given."""
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
        "struts": lambda: len(model.struts),
        "branches": lambda: known_branches(tree or model.tree, option).count,
        "parameters": lambda: len(
            parameter_names(model) if tree is None else parameter_values(tree)
        ),
    }
    return tuple(d if isinstance(d, int) else sizes[d]() for d in dims)


def _directions(
    tree: Tree, labels: list[str], inputs: Sequence[Argument], by: Sequence[str]
) -> dict[int, Directions]:
    """For each input by which outputs are differentiated, its directions: the nv tangent ones for
    positions, unit vectors for others."""

    def tangent(q: Vector) -> list[Vector]:
        return [position_rates(tree, q, unit) for unit in identity(tree.nv)]

    found = {}
    for name in dict.fromkeys(by):
        if name not in labels:
            raise UnknownNameError("input", name, "by=", labels)
        given = inputs[labels.index(name)]
        found[labels.index(name)] = (
            Directions((tree.nv,), tangent)
            if name in POSITIONS
            else Directions((given.size,) if given.shape else ())
        )
    return found
