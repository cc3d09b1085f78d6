"""Functions of the rows of a frame's Jacobian at many postures: by a kernel, and where its result
is not sure by NumPy."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from freebody.algorithms import kinematics
from freebody.algorithms.operational_space import nan_unless
from freebody.arrays import Array
from freebody.elementary import Scalar
from freebody.kernels.formulas import Option
from freebody.kernels.formulas.record import frame_of
from freebody.kernels.structural import Bound, Over, fetch_own
from freebody.model.model import Model
from freebody.model.shafts import untwisted
from freebody.program import Argument, Program, trace
from freebody.spatial import Matrix, scale
from freebody.trees.closer_looks import closer_where_unclear
from freebody.trees.kinematics import jacobian
from freebody.trees.public_calls import JointVector, evaluate, finite_vector, refuse_overflow


@dataclass(frozen=True)
class OfRows:
    """A function of the rows of a Jacobian, in which linear rows are divided by a length.

    outputs: of matrices (r, nv). evaluate: of such a matrix of scalars the outputs, and whether
    they are sure. look: of matrices of numbers (..., r, nv) the outputs.
    """

    function: str
    outputs: Callable[[int, int], tuple[Argument, ...]]
    evaluate: Callable[[Matrix], tuple[tuple[Any, ...], Scalar]]
    look: Callable[[Array], Array | tuple[Array, ...]]

    def at(self, model: Model, option: Option, q: JointVector, length: float = 1.0) -> Any:
        """The function's outputs at joint positions q (..., nq); length: the divisor of linear rows
        (m); option: the frame and its rows. Twists of flexible joints are no motions."""
        rigid = untwisted(model)
        if rigid is not None:
            model, q = rigid.model, rigid.links(finite_vector(self.function, model, "q", q))
        key = self.function, option
        return evaluate(key, model, (q, length), None, None, self._answer)

    def _answer(
        self, key: Any, model: Model, inputs: tuple[Any, ...], *_: None, result: Any = None
    ) -> Any:
        function, option = key
        q = finite_vector(function, model, "q", inputs[0])
        named = {"q": q, "length": np.broadcast_to(inputs[1], q.shape[:-1])}
        look = partial(self._look, model, option)
        if not model.nv:  # nothing moves, and no kernel is asked how
            return look(np.empty(0), *named.values())
        bound = self._kernel(model, option)
        model.compiled[key] = bound.checked(every=True, kept=True)
        return closer_where_unclear(function, bound, named, q.ndim - 1, look, result)

    def _look(
        self, model: Model, option: Option, _: np.ndarray, q: Array, length: Array
    ) -> Array | tuple[Array, ...]:
        J = jacobian(model, q, option.frame)[..., list(option.rows), :]
        linear = np.array([row < model.dim for row in option.rows])
        with np.errstate(over="ignore"):
            each = 1.0 / length
            rows = J * np.where(linear, each[..., None], 1.0)[..., None]
        if not np.isfinite(rows).all():
            refuse_overflow(self.function, {"1 / length": each})
        return self.look(rows)

    def _kernel(self, model: Model, option: Option) -> Bound:
        def made(p: Argument, over: Over) -> Program:
            def whole(q: Any, length: Any, numbers: Any) -> tuple[Any, ...]:
                J = kinematics.jacobian(over(numbers), q, frame_of(option))
                units = (1.0 / length if row < model.dim else 1.0 for row in option.rows)
                rows = tuple(scale(x, J[row]) for x, row in zip(units, option.rows, strict=True))
                found, sure = self.evaluate(rows)
                return nan_unless(sure, q, found)

            inputs = Argument("q", (model.nq,)), Argument("length", ()), p
            return trace(self.function, whole, inputs, self.outputs(len(option.rows), model.nv))

        return fetch_own(model, (self.function,), option, made)
