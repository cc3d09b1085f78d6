"""Programs as functions of JAX with derivatives of every order; products along broadcast axes need
no copies.

The derivative along tangents is an operation of JAX's own, `freebody_linear`, which is linear in
these and knows its transpose. One tangent, or one cotangent, is what a kernel of the derivative
along a direction takes, or one of the gradient; where there are many for the same values, as in
`jacfwd` and `jacrev`, whole Jacobians are computed once and multiplied by them.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Sequence
from functools import cache
from math import prod
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax.core import ShapedArray
from jax.extend.core import Primitive
from jax.interpreters import ad, batching, mlir

from freebody.program import Argument
from freebody.program.derivative import gradient
from freebody.targets.xla.operation import Compilation, JaxArrays, operation
from freebody.ways_out.differentials import Differentiable

_ArgumentPlaces = tuple[int, ...]


class JaxFunction:
    """A program as a function of arrays (..., *core) of one floating-point type.

    Attributes
    ----------
    call
        The function; returns a tuple.
    program
        What it computes.
    """

    def __init__(self, what: Differentiable, way: Compilation):
        self.what, self.way, self.program = what, way, what.program
        plain = operation(what.program, way)

        @jax.custom_jvp
        def call(*arrays: Any) -> JaxArrays:
            return plain(*_level(self.program.inputs, arrays))

        call.defjvp(self._rule, symbolic_zeros=True)
        self.call = call
        self.matrices = cache(self._matrices)
        self.along = cache(self._along)
        self.applied = cache(self._applied)
        self.gradient = cache(self._gradient)

    def _rule(self, primals: JaxArrays, tangents: JaxArrays) -> tuple[JaxArrays, JaxArrays]:
        results = self.call(*primals)  # itself, so that it is differentiated again by this rule
        by = tuple(
            k for k, x in enumerate(tangents) if type(x) is not jax.custom_derivatives.SymbolicZero
        )
        if not by:
            return results, tuple(map(jnp.zeros_like, results))
        given = _level(self.program.inputs, primals)
        rates = [tangents[k].reshape(given[k].shape) for k in by]
        every = tuple(range(len(results)))
        products = _Products(self, by, every, None)
        changes = _linear.bind(*given, *rates, products=products, matrix=False)
        return results, tuple(changes)

    def _along(self, by: _ArgumentPlaces) -> JaxFunction:
        """The JAX function of the outputs' rates, given the inputs and then rates of the inputs
        `by`."""
        return JaxFunction(self.what.along(by), self.way)

    def _gradient(self, by: _ArgumentPlaces, of: _ArgumentPlaces) -> JaxFunction:
        """The JAX function of the gradient by the inputs `by` of the weighted outputs `of`; the
        weights are the last arguments."""
        return JaxFunction(Differentiable(gradient(self.program, by, of)), self.way)

    def _applied(
        self, by: _ArgumentPlaces, of: _ArgumentPlaces, count: int, back: bool
    ) -> JaxFunction | None:
        """The JAX function of products of the Jacobian, or with `back` its transpose, with `count`
        vectors, given as last arguments; None if the program would be too long."""
        made = self.what.applied(by, of, count, back)
        return made and JaxFunction(made, self.way)

    def _matrices(self, by: _ArgumentPlaces) -> Callable[..., JaxArrays]:
        """A function of the inputs that returns the Jacobians (*output, *input) of each output by
        each of the inputs `by`."""
        found = self.what.jacobian(by)
        call = JaxFunction(found.function, self.way).call
        return call if found.whole else lambda *arrays: self._columns(by, arrays)

    def _columns(self, by: _ArgumentPlaces, arrays: JaxArrays) -> JaxArrays:
        """Jacobians of each output by each of the inputs `by`, computed column by column from rates
        along unit vectors."""
        shapes = [self.program.inputs[k].shape for k in by]
        ends = np.cumsum([prod(shape) for shape in shapes]).tolist()
        given = _level(self.program.inputs, arrays)
        axis = max(
            (x.ndim - len(a.shape) for x, a in zip(given, self.program.inputs, strict=True)),
            default=0,
        )
        units = np.split(np.eye(ends[-1], dtype=given[0].dtype), ends[:-1], axis=1)
        rates = [jnp.asarray(x.reshape(-1, *shape)) for x, shape in zip(units, shapes, strict=True)]
        found = []
        for y in self.along(by).call(*(jnp.expand_dims(x, axis) for x in given), *rates):
            parts = jnp.split(jnp.moveaxis(y, axis, -1), ends[:-1], axis=-1)
            found += [
                x.reshape(*x.shape[:-1], *shape) for x, shape in zip(parts, shapes, strict=True)
            ]
        return tuple(found)


def _level(inputs: Sequence[Argument], arrays: Sequence[Any]) -> list[Any]:
    """The arrays with equally many batch axes; missing ones are inserted with size 1."""
    axes = [x.ndim - len(argument.shape) for x, argument in zip(arrays, inputs, strict=True)]
    most = max(axes, default=0)
    return [x.reshape((1,) * (most - n) + x.shape) for x, n in zip(arrays, axes, strict=True)]


class _Products(NamedTuple):
    """Products with the Jacobian of a function. back None: rates of the inputs `by` give rates of
    the outputs `of`; otherwise the transpose: cotangents of the outputs `of` give cotangents of the
    inputs `by`."""

    function: JaxFunction
    by: _ArgumentPlaces
    of: _ArgumentPlaces
    back: Any

    @property
    def inputs(self) -> list[tuple[int, ...]]:
        """Shapes of one sample of the inputs `by`."""
        return [self.function.program.inputs[k].shape for k in self.by]

    @property
    def outputs(self) -> list[tuple[int, ...]]:
        """Shapes of one sample of the outputs `of`."""
        return [self.function.program.outputs[k].shape for k in self.of]

    def batches(self, operands: Sequence[Any]) -> list[Any]:
        """Batch shape of each operand of the product."""
        last = self.inputs if self.back is None else self.outputs
        cores = (*(x.shape for x in self.function.program.inputs), *last)
        return [x.shape[: x.ndim - len(core)] for x, core in zip(operands, cores, strict=True)]


_linear = Primitive("freebody_linear")
"""Operands: the inputs of a function, then rates or cotangents, all with equally many leading axes.
products: which. matrix: whether through whole Jacobians."""
_linear.multiple_results = True


def _evaluate(*operands: Any, products: _Products, matrix: bool) -> JaxArrays:
    """The results of the Jacobian product, computed by kernels that can be differentiated
    themselves."""
    function, by, of, back = products
    count = len(function.program.inputs)
    primals, given = operands[:count], operands[count:]
    if not matrix and back is None:
        rates = function.along(by).call(*primals, *given)
        return tuple(rates[k] for k in of)
    if not matrix:
        return _to_inputs(products, function.gradient(by, of).call(*primals, *given))
    results = _shared(products, primals, given)
    return _multiplied(products, primals, given) if results is None else results


def _to_inputs(products: _Products, slopes: Sequence[Any]) -> JaxArrays:
    """Cotangents of the inputs, summed over the axes along which the inputs were broadcast."""
    shapes = zip(products.back, products.inputs, strict=True)
    return tuple(
        _summed(x, (*batch, *core)) for x, (batch, core) in zip(slopes, shapes, strict=True)
    )


def _shared(products: _Products, primals: JaxArrays, given: JaxArrays) -> JaxArrays | None:
    """Jacobian products with vectors that are the same for all samples, by a kernel that contains
    the product; None if the vectors differ by sample or are too many."""
    function, by, of, back = products
    sizes = products.batches((*primals, *given))
    values, vectors = (
        np.broadcast_shapes(*some) for some in (sizes[: len(primals)], sizes[len(primals) :])
    )
    many = [k for k, n in enumerate(vectors) if n > 1]
    if any(values[k] > 1 for k in many):
        return None
    count = prod(vectors[k] for k in many)
    found = function.applied(by, of, count, back is not None)
    if found is None:
        return None
    lists = []
    for x in given:
        core = x.shape[len(vectors) :]
        lists.append(jnp.broadcast_to(x, (*vectors, *core)).reshape(count, *core))
    results = found.call(*primals, *lists)
    one = [k for k in range(len(vectors)) if k not in many]
    sizes_of = [values[k] for k in one], [vectors[k] for k in many]
    if back is None:
        return tuple(
            _placed(
                y.reshape(*sizes_of[0], *core, *sizes_of[1]), [*one, *range(-len(core), 0), *many]
            )
            for y, core in zip(results, products.outputs, strict=True)
        )
    made = [
        _placed(y.reshape(*sizes_of[0], *sizes_of[1], *core), [*one, *many, *range(-len(core), 0)])
        for y, core in zip(results, products.inputs, strict=True)
    ]
    return _to_inputs(products, made)


def _multiplied(products: _Products, primals: JaxArrays, given: JaxArrays) -> JaxArrays:
    """Jacobian products computed from the whole Jacobian matrices."""
    function, by, of, back = products
    inputs, outputs = products.inputs, products.outputs
    every = function.matrices(by)(*primals)
    tables = [every[k * len(by) : (k + 1) * len(by)] for k in of]
    if back is None:
        return tuple(
            sum(
                _product(False, x, y, out, shape)
                for x, y, shape in zip(row, given, inputs, strict=True)
            )
            for row, out in zip(tables, outputs, strict=True)
        )
    slopes = [
        sum(
            _product(True, row[j], y, out, shape)
            for row, y, out in zip(tables, given, outputs, strict=True)
        )
        for j, shape in enumerate(inputs)
    ]
    return _to_inputs(products, slopes)


@_linear.def_abstract_eval
def _shapes(*operands: Any, products: _Products, matrix: bool) -> Any:
    if products.back is None:
        batch = np.broadcast_shapes(*products.batches(operands))
        shapes = [(*batch, *core) for core in products.outputs]
    else:
        shapes = [(*x, *core) for x, core in zip(products.back, products.inputs, strict=True)]
    return [ShapedArray(shape, operands[0].dtype) for shape in shapes]


def _mapped(
    operands: Sequence[Any], axes: Sequence[int | None], products: _Products, matrix: bool
) -> Any:
    """The Jacobian product with one more batch axis (`vmap`); where many vectors belong to the same
    inputs, the Jacobian matrix is computed once."""
    count = len(products.function.program.inputs)
    size = next(x.shape[axis] for x, axis in zip(operands, axes, strict=True) if axis is not None)
    moved = [
        x[None] if axis is None else jnp.moveaxis(x, axis, 0)
        for x, axis in zip(operands, axes, strict=True)
    ]
    if products.back is not None:
        products = products._replace(back=tuple((size, *batch) for batch in products.back))
    matrix = matrix or all(axis is None for axis in axes[:count])
    results = _linear.bind(*moved, products=products, matrix=matrix)
    return results, [0] * len(results)


def _jvp(operands: Sequence[Any], tangents: Sequence[Any], **params: Any) -> Any:
    """The tangent of the Jacobian product, which is linear in the vectors; for the other operands
    `_evaluate` is differentiated."""
    count = len(params["products"].function.program.inputs)
    results, changes = _linear.bind(*operands, **params), []
    moving = [k for k in range(count) if type(tangents[k]) is not ad.Zero]
    if moving:

        def of_moving(*given: Any) -> JaxArrays:
            values = list(operands)
            for k, x in zip(moving, given, strict=True):
                values[k] = x
            return _evaluate(*values, **params)

        at, along = ([x[k] for k in moving] for x in (operands, tangents))
        changes.append(jax.jvp(of_moving, at, along)[1])
    if any(type(x) is not ad.Zero for x in tangents[count:]):
        last = map(ad.instantiate_zeros, tangents[count:])
        changes.append(_linear.bind(*operands[:count], *last, **params))
    return results, [sum(terms[1:], terms[0]) for terms in zip(*changes, strict=True)]


def _transposed(
    cotangents: Sequence[Any], *operands: Any, products: _Products, matrix: bool
) -> list[Any]:
    """The transpose of the Jacobian product by the vectors that JAX leaves undefined, for the
    results with nonzero cotangents."""
    function, by, of, back = products
    count = len(function.program.inputs)
    primals, last = operands[:count], operands[count:]
    unknown = [k for k, x in enumerate(last) if ad.is_undefined_primal(x)]
    counting = [k for k, x in enumerate(cotangents) if type(x) is not ad.Zero]
    found: list[Any] = [None] * len(operands)
    if not counting:
        return found
    given = [cotangents[k] for k in counting]
    shapes = [last[k].aval.shape for k in unknown]
    if back is None:
        wanted = tuple(by[k] for k in unknown)
        cores = [len(function.program.inputs[k].shape) for k in wanted]
        axes = tuple(shape[: len(shape) - core] for shape, core in zip(shapes, cores, strict=True))
        other = _Products(function, wanted, tuple(of[k] for k in counting), axes)
    else:
        kept, wanted = tuple(by[k] for k in counting), tuple(of[k] for k in unknown)
        other = _Products(function, kept, wanted, None)
    results = _linear.bind(*primals, *given, products=other, matrix=matrix)
    if back is not None:
        results = [_summed(x, shape) for x, shape in zip(results, shapes, strict=True)]
    for k, result in zip(unknown, results, strict=True):
        found[count + k] = result
    return found


_linear.def_impl(_evaluate)
with contextlib.suppress(ImportError, AttributeError):  # JAX has no public name for it
    from jax._src.dispatch import prim_requires_devices_during_lowering

    # what it is made of is, where there are several devices, cut for them
    prim_requires_devices_during_lowering.add(_linear)
mlir.register_lowering(_linear, mlir.lower_fun(_evaluate, multiple_results=True))
batching.primitive_batchers[_linear] = _mapped
ad.primitive_jvps[_linear] = _jvp
ad.primitive_transposes[_linear] = _transposed


_ShapeOfArray = tuple[int, ...]


def _product(back: bool, table: Any, vector: Any, out: _ShapeOfArray, shape: _ShapeOfArray) -> Any:
    """Product of a matrix (*batch, *output, *input) and a vector (*batch, *input); back: of its
    transpose and a vector (*batch, *output).

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


def _summed(x: Any, shape: _ShapeOfArray) -> Any:
    """Sum of x over the axes along which an array of the given shape was broadcast."""
    axes = tuple(
        k for k, (n, m) in enumerate(zip(x.shape, shape, strict=True)) if m == 1 and n != 1
    )
    return x.sum(axes, keepdims=True) if axes else x


def _placed(x: Any, axes: Sequence[int]) -> Any:
    """The array x with its axes moved to the given positions of another array, in that array's
    order."""
    order = sorted(axes, key=lambda k: k if k >= 0 else len(axes) + k)
    return x.transpose([axes.index(k) for k in order])
