"""Products and sums of JAX's arrays along axes that were broadcast, without copies."""

from __future__ import annotations

from collections.abc import Sequence
from math import prod
from typing import Any

import jax
import numpy as np

Shape = tuple[int, ...]


def product(back: bool, table: Any, vector: Any, out: Shape, shape: Shape) -> Any:
    """A matrix (*batch, *output, *input) times a vector (*batch, *input); back: its transpose times
    (*batch, *output).

    Axes of size 1 are left out: XLA would copy the other factor along them.
    """
    taken, made = (out, shape) if back else (shape, out)
    sizes = (
        table.shape[: table.ndim - len(out) - len(shape)],
        vector.shape[: vector.ndim - len(taken)],
    )
    batch = np.broadcast_shapes(*sizes)
    rows, columns = len(batch), len(batch) + 1
    axes = [[k for k, n in enumerate(own) if n > 1] for own in sizes]
    matrix = table.reshape(*(sizes[0][k] for k in axes[0]), prod(out), prod(shape))
    given = vector.reshape(*(sizes[1][k] for k in axes[1]), prod(taken))
    # the matrix first, whatever order is wanted: another order costs XLA a copy, which it finds out
    # itself otherwise
    shared = [k for k in axes[0] if k in axes[1]]
    contracted, kept = (rows, columns) if back else (columns, rows)
    labels = [*axes[0], rows, columns], [*axes[1], contracted]
    at = [[own.index(k) for k in shared] for own in labels]
    result = jax.lax.dot_general(
        matrix,
        given,
        (([labels[0].index(contracted)], [labels[1].index(contracted)]), (at[0], at[1])),
        precision="highest",
    )
    order = [*shared, *(k for own in labels for k in own if k not in (*shared, contracted))]
    wanted = [*(k for k, n in enumerate(batch) if n > 1), kept]
    return result.transpose([order.index(k) for k in wanted]).reshape(*batch, *made)


def summed(x: Any, shape: Shape) -> Any:
    """The sum over axes along which an array of this shape was broadcast."""
    axes = tuple(
        k for k, (n, m) in enumerate(zip(x.shape, shape, strict=True)) if m == 1 and n != 1
    )
    return x.sum(axes, keepdims=True) if axes else x


def placed(x: Any, axes: Sequence[int]) -> Any:
    """An array whose axes are these of another one, in the order of that one."""
    order = sorted(axes, key=lambda k: k if k >= 0 else len(axes) + k)
    return x.transpose([axes.index(k) for k in order])
