"""What the tests of laws share: formulas on arrays, paths through a state, differences,
comparison."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
import pytest

import freebody as fb

# central differences of eighth order on -4 … 4
FIRST = np.array([1 / 280, -4 / 105, 1 / 5, -4 / 5, 0, 4 / 5, -1 / 5, 4 / 105, -1 / 280])
SECOND = np.array([-1 / 560, 8 / 315, -1 / 5, 8 / 5, -205 / 72, 8 / 5, -1 / 5, 8 / 315, -1 / 560])
STEPS = np.arange(-4, 5)

OPEN_CHAINS = [name for name in fb.models() if not fb.load(name, physical="ignore").loops]
"""Bundled models without loops."""


def numbers(
    model: fb.Model,
    name: str,
    *arrays: Any,
    frame: str | None = None,
    reference: str = "world",
    wrenches: dict[str, np.ndarray] | None = None,
) -> np.ndarray:
    """A quantity of one output by its formula on plain arrays (..., n), without the compiler."""
    loads = wrenches or {}
    function = fb.formula(model, name, frame=frame, reference=reference, wrench_frames=[*loads])
    given = [np.asarray(a, dtype=float) for a in (*arrays, *loads.values())]
    batch = np.broadcast_shapes(*(a.shape[:-1] for a in given))
    found = function(*(scalars(np.broadcast_to(a, (*batch, a.shape[-1]))) for a in given))
    return np.array(_array(found, batch))


def several(model: fb.Model, name: str, *arrays: Any) -> tuple[np.ndarray, ...]:
    """A quantity of several outputs by its formula on plain arrays of one batch: vectors (..., n)
    and numbers (...), a vector first."""
    batch = np.shape(arrays[0])[:-1]
    found = fb.formula(model, name)(
        *(scalars(a) if np.ndim(a) > len(batch) else np.asarray(a, dtype=float) for a in arrays)
    )
    return tuple(np.array(_array(x, batch)) for x in found)


def _array(value: Any, batch: tuple[int, ...]) -> np.ndarray:
    """Nested tuples of scalars, each an array over the batch, as one array (*batch, ...)."""
    if isinstance(value, tuple):
        return np.stack([_array(x, batch) for x in value], axis=len(batch))
    return np.broadcast_to(np.asarray(value, dtype=float), batch)


def poses(model: fb.Model, q: np.ndarray) -> dict[str, np.ndarray]:
    """The pose (..., 4, 4) of every frame; planar ones lie in the xy plane."""
    found = {}
    for name in model.frame_names:
        T = numbers(model, "forward_kinematics", q, frame=name)
        found[name] = T if model.dim == 3 else _in_space(T)
    return found


def _in_space(T: np.ndarray) -> np.ndarray:
    """A planar pose (..., 3, 3) as one in space."""
    found = np.zeros((*T.shape[:-2], 4, 4))
    found[..., 2, 2] = 1.0
    keep = np.array([0, 1, 3])
    found[..., keep[:, None], keep] = T
    return found


def scalars(array: np.ndarray) -> tuple[np.ndarray, ...]:
    """The entries of a vector, each an array over the batch: what algorithms take."""
    return tuple(np.moveaxis(np.asarray(array, dtype=float), -1, 0))


def path(
    model: fb.Model, q: np.ndarray, qd: np.ndarray, qdd: np.ndarray, h: float
) -> tuple[np.ndarray, np.ndarray]:
    """Positions (9, ..., nq) and rates at times -4h … 4h of a motion with this q, q̇ and q̈ at time
    0."""
    t = h * STEPS.reshape(-1, *(1,) * np.ndim(q))
    first = numbers(model, "integrate", q, t * qd)
    return numbers(model, "integrate", first, t**2 / 2 * qdd), qd + t * qdd


def rate(values: np.ndarray, h: float) -> np.ndarray:
    """Time derivative at 0 of values along a `path`."""
    return np.tensordot(FIRST, values, axes=1) / h


def second_rate(values: np.ndarray, h: float) -> np.ndarray:
    """Second time derivative at 0 of values along a `path`."""
    return np.tensordot(SECOND, values, axes=1) / h**2


def close(found: Any, expected: Any, tolerance: float, scale: float = 0.0, what: str = "") -> None:
    """Largest difference over the largest reference (or `scale`, where that is larger) is at most
    `tolerance`."""
    found, expected = np.asarray(found), np.asarray(expected)
    assert found.shape == expected.shape, f"{what}: shapes {found.shape} and {expected.shape}"
    assert np.isfinite(found).all(), f"{what}: not finite"
    if found.size:
        size = max(scale, float(np.abs(expected).max()))
        off = float(np.abs(found - expected).max())
        assert off <= tolerance * size, (
            f"{what}: off by {off:.3g} of {size:.3g}, allowed {tolerance:.3g}"
        )


def state(model: fb.Model, seed: int, batch: int = 3) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Random q, q̇, q̈; rates moderate so that differences are sharp."""
    return fb.random_state(model, seed, batch)


def all_driven(model: fb.Model) -> fb.Model:
    """The model with a drive in every joint."""
    leading = [body.joint.name for body in model.bodies if body.joint.mimic is None]
    return model.replace(actuated=leading)


def in_space(wrench: np.ndarray, dim: int) -> tuple[np.ndarray, np.ndarray]:
    """Force and moment, both (..., 3), of a wrench or twist in the plane or in space."""
    if dim == 3:
        return wrench[..., :3], wrench[..., 3:]
    zero = np.zeros_like(wrench[..., :1])
    return np.concatenate([wrench[..., :2], zero], axis=-1), np.concatenate(
        [zero, zero, wrench[..., 2:]], axis=-1
    )


def random_wrenches(model: fb.Model, seed: int, batch: int, n: int = 3) -> dict[str, np.ndarray]:
    """Wrenches on up to n frames."""
    rng = np.random.default_rng(seed)
    names = rng.permutation(np.array(model.frame_names))[:n]
    return {str(name): 5 * rng.normal(size=(batch, 6 if model.dim == 3 else 3)) for name in names}


def refused(text: str, call: Callable[[], Any], kind: type[Exception] = fb.FreebodyError) -> None:
    """The call is refused in exactly these words."""
    with pytest.raises(kind, match=f"^{re.escape(text)}$"):
        call()


@contextmanager
def raises_own(kind: type[Exception], match: str) -> Iterator[None]:
    """What stands inside is refused by an error of freebody's own that is one of Python's `kind`
    too: by either, callers catch it."""
    with pytest.raises(fb.FreebodyError, match=match) as caught:
        yield
    assert isinstance(caught.value, kind), type(caught.value).__mro__


def homogeneous_of(placement: Any) -> np.ndarray:
    """The matrix (4, 4) of a placement of numbers, a shift or a rotation at each step."""
    T = np.eye(4)
    for step in placement.steps:
        by = np.eye(4)
        if hasattr(step, "by"):
            by[:3, 3] = step.by
        else:
            by[:3, :3] = step.matrix
        T = T @ by
    return T
