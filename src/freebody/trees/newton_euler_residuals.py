"""Whether reactions explain a motion: ΣF = m a and ΣM = Ḣ of every body
(`algorithms.newton_euler_residuals`)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from freebody.arrays import Array
from freebody.kernels.formulas import Option
from freebody.kernels.structural import fetch
from freebody.model.model import Model


@dataclass(frozen=True)
class NewtonEulerResiduals:
    """ΣF - m a (..., nj, dim) and ΣM - Ḣ (..., nj, 3 or 1) of every body, and the largest force and
    moment that entered."""

    force: Array
    moment: Array
    largest_force: float
    largest_moment: float


def balance(
    model: Model, q: Array, qd: Array, qdd: Array, wrenches: Array, external: Mapping[str, Array]
) -> NewtonEulerResiduals:
    """How well reactions and external wrenches, world axes, explain a motion q (..., nq), qd, qdd
    (..., nv).

    wrenches: (..., joints and loops, six), as `reactions` gives them; external: {frame: (...,
    six)}.
    """
    kernel = fetch(model, ("balance",), Option(wrench_frames=tuple(external)))
    force, moment, largest = kernel(q, qd, qdd, wrenches, *external.values())
    sizes = largest.reshape(-1, 2).max(axis=0, initial=0.0)
    return NewtonEulerResiduals(force, moment, float(sizes[0]), float(sizes[1]))
