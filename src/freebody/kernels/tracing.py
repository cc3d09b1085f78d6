"""From formulas and a model to their program."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from freebody.algorithms.regrouped_parameters import lightened
from freebody.elementary import Scalar
from freebody.errors import SingularError
from freebody.kernels.arguments import arguments, chosen, shape
from freebody.kernels.formulas import FORMULAS, Option
from freebody.kernels.input_derivatives import directions, lifted, slope_arguments, with_slopes
from freebody.model.families import FamilyError
from freebody.model.model import Model
from freebody.model.tree import Tree
from freebody.program import Argument, Program, trace

_SMALL = 12
"""Coordinates up to which two ways to the same values are both traced."""


def program(
    model: Model,
    names: tuple[str, ...],
    option: Option,
    p: Argument | None = None,
    over: Callable[[Sequence[Scalar]], Tree] | None = None,
    by: tuple[str, ...] = (),
) -> Program:
    """What the formulas do to scalars, for this model; with p, some of its numbers, as a last
    input.

    over: the tree over the scalars of p. by: inputs by which the outputs are differentiated.
    """
    if model.family and p is None:
        raise FamilyError(f"the program of {', '.join(names)}", model.name, model.family)
    fixed = model.tree if p is None or over is None else over([1.0] * p.size)
    inputs = arguments(model, names, option) if p is None else (*arguments(model, names, option), p)
    labels = [a.name for a in inputs]
    outputs = tuple(
        Argument(
            f"{name}_{label}" if len(names) > 1 else label, shape(model, output.dims, option, fixed)
        )
        for name in names
        for label, output in FORMULAS[name].outputs.items()
    )
    sizes = directions(model, inputs, by)

    def traced(ways: dict[str, Callable[..., tuple[Any, ...]]]) -> Program:
        def evaluate(*values: Any) -> tuple[Any, ...]:
            given, tree = lifted(dict(zip(labels, values, strict=True)), sizes, fixed, over)
            if all(
                FORMULAS[name].by_motion for name in names
            ):  # no output shows the links one by one
                tree = lightened(tree)
            results = tuple(
                x for name in names for x in ways[name](tree, option, **chosen(name, given, option))
            )
            return with_slopes(results, outputs, sizes)

        try:
            return trace(
                "_".join(names), evaluate, inputs, (*outputs, *slope_arguments(outputs, sizes))
            )
        except ZeroDivisionError:
            raise SingularError(
                f"{', '.join(names)} of {model.name!r} divides by zero in every state: a joint "
                f"moves no mass and no inertia, or a loop does not hold anything."
            ) from None

    first = traced({name: FORMULAS[name].evaluate for name in names})
    others = {name: FORMULAS[name].another or FORMULAS[name].evaluate for name in names}
    if model.nv > _SMALL or all(FORMULAS[name].another is None for name in names):
        return first
    return min(first, traced(others), key=lambda program: sum(program.operations.values()))
