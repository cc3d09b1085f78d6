"""Batches of any shape as two axes, an outer and an inner one."""

from __future__ import annotations

from collections.abc import Sequence
from math import prod
from typing import Any

import numpy as np

SHORT = 64
"""Samples that are too few for a call of a kernel's loop, where there are several calls."""

Shape = tuple[int, ...]


def arranged(
    arrays: Sequence[Any], shapes: Sequence[Shape]
) -> tuple[tuple[int, int], list[Any], list[bool]]:
    """Sizes of the two axes, the arrays (outer, inner, *core), and whether each varies along the
    inner one.

    shapes: of the leading axes, equally many of each array, which broadcast. Each of the two sizes
    of an array is 1 or that of the batch; an array is copied only where it varies along some of the
    axes that become one, but not all.
    """
    whole = np.broadcast_shapes(*shapes)
    groups = _alike(whole, shapes)
    outer, inner = (groups[0], [*groups[1:]]) if len(groups) > 1 else ([], groups)
    if outer and prod(whole[axis] for group in inner for axis in group) < SHORT:
        outer, inner = [], groups
    axes = [axis for group in inner for axis in group]
    size = prod(whole[axis] for axis in outer), prod(whole[axis] for axis in axes)
    placed, varies = [], []
    for array, shape in zip(arrays, shapes, strict=True):
        core = array.shape[len(shape) :]
        along = [axis for axis in axes if shape[axis] > 1]
        if along and len(along) < len(axes):
            full = tuple(whole[axis] if axis in axes else n for axis, n in enumerate(shape))
            array = _broadcast(array, (*full, *core))
        rows = size[0] if any(shape[axis] > 1 for axis in outer) else 1
        placed.append(array.reshape(rows, size[1] if along else 1, *core))
        varies.append(bool(along))
    return size, placed, varies


def _alike(whole: Shape, shapes: Sequence[Shape]) -> list[list[int]]:
    """Neighbouring axes along which the same arrays vary."""
    groups: list[list[int]] = []
    last: list[bool] = []
    for axis, size in enumerate(whole):
        if size == 1:
            continue
        pattern = [shape[axis] > 1 for shape in shapes]
        if groups and pattern == last:
            groups[-1].append(axis)
        else:
            groups.append([axis])
        last = pattern
    return groups


def _broadcast(array: Any, shape: Shape) -> Any:
    import jax.numpy

    return jax.numpy.broadcast_to(array, shape)
