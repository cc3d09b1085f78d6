"""Derivatives of what a formula computes, by any of its inputs: scalars with slopes in the
trace."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Sequence
from typing import Any

from freebody.algorithms.kinematics import position_rates
from freebody.elementary import Scalar
from freebody.errors import UnknownNameError
from freebody.kernels.formulas import POSITIONS
from freebody.model.model import Model
from freebody.model.tree import Tree
from freebody.program import Argument
from freebody.scalars.dual import Outer, slopes, value
from freebody.spatial import identity


def directions(model: Model, inputs: Sequence[Argument], by: Sequence[str]) -> dict[str, int]:
    """How many directions there are of each input by which is differentiated: of positions nv,
    tangent ones; 0 stands for the one of a bare number."""
    sizes = {a.name: model.nv if a.name in POSITIONS else a.size if a.shape else 0 for a in inputs}
    for name in by:
        if name not in sizes:
            raise UnknownNameError("input", name, "by=", sizes)
    return {name: sizes[name] for name in dict.fromkeys(by)}


def lifted(
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


def with_slopes(
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


def slope_arguments(outputs: Sequence[Argument], sizes: dict[str, int]) -> tuple[Argument, ...]:
    """d<output>_d<input> (*output, directions); by a bare number of the output's shape."""
    return tuple(
        Argument(f"d{a.name}_d{name}", (*a.shape, *((size,) if size else ())))
        for a in outputs
        for name, size in sizes.items()
    )


def _each(nested: Any, depth: int, function: Callable[[Any], Any]) -> Any:
    return function(nested) if depth == 0 else tuple(_each(x, depth - 1, function) for x in nested)
