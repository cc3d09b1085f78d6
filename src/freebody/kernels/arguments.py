"""What the formulas take and return, of a model: names and shapes."""

from __future__ import annotations

from typing import Any

from freebody.algorithms.regressor import parameter_values
from freebody.kernels.formulas import FORMULAS, INPUTS, Option
from freebody.kernels.formulas.inverse import known_branches
from freebody.kernels.formulas.record import Dimensions
from freebody.model.inertial_parameters import parameter_names
from freebody.model.model import Model
from freebody.model.tree import Tree
from freebody.program import Argument


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
    """Whether an input that not all models or calls have is one here."""
    return {"point": option.point, "redundancy": option.redundant}.get(name, True)


def _wrench(k: int) -> str:
    """Name of the input that acts at frame k of `wrench_frames`."""
    return f"wrench{k}"


def chosen(name: str, given: dict[str, Any], option: Option) -> dict[str, Any]:
    """Of the given inputs those that a formula takes."""
    taken = {x: given[x] for x in FORMULAS[name].inputs if x in given}
    if "wrenches" in FORMULAS[name].inputs:
        taken["wrenches"] = tuple(given[_wrench(k)] for k in range(len(option.wrench_frames)))
    return taken


def shape(
    model: Model, dims: Dimensions, option: Option, tree: Tree | None = None
) -> tuple[int, ...]:
    """The sizes of dimensions that are told by name; of the numbers that a tree has, where its
    scalars are not the model's own."""
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
