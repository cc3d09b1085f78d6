"""Programs as functions of JAX, with derivatives computed by programs too."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from freebody.errors import MissingPackageError, no_real_numbers, warn
from freebody.kernels.parameter_inputs import InputKernel, KernelInputs
from freebody.model.families import FamilyError
from freebody.model.model import Model
from freebody.program import Program
from freebody.targets import Kernel, KernelError
from freebody.targets.call_errors import common_batch, require_count
from freebody.targets.xla.operation import Compilation, JaxArrays, interface
from freebody.ways_out.differentials import Differentiable, of_quantities
from freebody.ways_out.kernel import QuantityRequest, requested


def to_jax(
    what: Model | Kernel | InputKernel,
    names: str | Sequence[str] | None = None,
    *,
    dtype: str | None = None,
    **options: Any,
) -> Callable[..., Any]:
    """A function of JAX arrays that computes as `fb.kernel` does, for `jit`, `vmap` and derivatives
    of any order. Needs JAX.

    On the CPU it runs the compiled kernel, inside of what JAX compiles; on other platforms, or
    where JAX has another interface than the one that is known, JAX calls Python, and a UserWarning
    says so. Arrays on several devices are cut along the batch, so that each device computes its own
    samples; along Explicit axes of a mesh they are refused (jax.shard_map).

    Derivatives of every order, forward and reverse, come from compiled kernels too: ordinary
    partial derivatives, by q of all its nq entries (on the tangent space they are with by=), by
    numbers of the model given as p.

    64-bit numbers are the caller's choice, jax.config.update("jax_enable_x64", True); without it
    JAX makes all numbers float32, and the kernel computes in these, to about 6 digits, and refuses
    dtype="float64". A kernel of float32 keeps to them.

    Parameters
    ----------
    what, names, **options
        As for `fb.source`.
    dtype
        "float64" or "float32", which is computed with, whatever arrays come. None: that of the
        arrays, as JAX promotes them.

    Returns
    -------
    callable
        f(q, qd, …), of arrays (..., *core) whose leading axes broadcast, in the kernel's order and
        SI units: one array, or a tuple. With inputs=, p (..., k) comes last, or is given as
        p={name: value}, the rest being the model's. f.parameters, f.values: names of the entries of
        p, and the model's own values. It raises KernelError, ShapeError, BatchError.

    Raises
    ------
    UnknownNameError
        A quantity or option that does not exist.
    FreebodyError
        JAX is not installed, or a dtype that JAX does not compute with here.
    """
    chosen = requested("fb.to_jax", what, names, options)
    try:
        import jax
    except ImportError:
        raise MissingPackageError("fb.to_jax", "JAX", "jax") from None
    from freebody.ways_out.jax_derivatives import JaxFunction

    if isinstance(chosen, QuantityRequest):
        if chosen.model.family and not chosen.given:
            raise FamilyError("fb.to_jax without inputs=", chosen.model.name, chosen.model.family)
        computed, way, given = of_quantities(chosen), Compilation(), chosen.given
    else:
        kernel, given = (
            (chosen.kernel, chosen.named) if isinstance(chosen, InputKernel) else (chosen, None)
        )
        computed = Differentiable(kernel.program)
        way = Compilation(kernel.target, kernel.asked_width, kernel.dtype.name)
    kind = _kind(dtype, way)
    slow = interface().obstacle
    if not slow and jax.default_backend() != "cpu":
        slow = f"JAX runs on {jax.default_backend()!r} here, and kernels on the CPU"
    if slow:
        warn(
            f"fb.to_jax: {slow}: JAX calls {computed.program.name} through Python, about 50 µs a "
            f"call, with copies of the arrays.",
        )
    function = _checked(computed.program, jax.jit(JaxFunction(computed, way).call), kind, given)
    function.parameters = given.names if given else ()
    function.values = given.values if given else np.zeros(0)
    return function


def _kind(dtype: str | None, way: Compilation) -> str | None:
    """The floating-point type to compute with; None: that of the arguments."""
    import jax

    if dtype is None:
        return way.dtype if way.dtype == "float32" else None
    if dtype not in ("float64", "float32"):
        raise KernelError(f"fb.to_jax: dtype={dtype!r}; it can be 'float64' or 'float32'.")
    if dtype == "float64" and not jax.config.read("jax_enable_x64"):
        raise KernelError(
            "fb.to_jax: dtype='float64', but JAX makes all numbers float32 here; "
            'jax.config.update("jax_enable_x64", True) enables 64-bit numbers.'
        )
    return dtype


def _checked(
    program: Program,
    compute: Callable[..., JaxArrays],
    fixed: str | None,
    named: KernelInputs | None,
) -> Any:
    """A function that accepts anything JAX can convert to arrays, checks the shapes and calls
    `compute`; returns one array or a tuple."""
    import jax

    def function(*arrays: Any, p: Any = None) -> Any:
        values = [
            x if isinstance(x, jax.Array) else _array(program, k, x) for k, x in enumerate(arrays)
        ]
        if p is not None or (named and len(values) < len(program.inputs)):
            values.append(_numbers(program, named, p, values))
        _check(program, values)
        common = _common(program, values)
        kind = fixed or common
        results = compute(*(x if x.dtype == kind else x.astype(kind) for x in values))
        return results[0] if len(results) == 1 else results

    function.__name__ = function.__qualname__ = program.name
    function.__doc__ = f"{program}: of arrays (..., *core), whose leading axes broadcast."
    return function


def _numbers(program: Program, named: KernelInputs | None, p: Any, others: Sequence[Any]) -> Any:
    """The array p (..., k) of model numbers: a given array itself; {name: value} completed by the
    model's own numbers; without p all of the model's own; in the type of the other arguments."""
    import jax.numpy as jnp

    last = len(program.inputs) - 1
    if named is None:
        raise KernelError(
            f"{program.name}: p is given, but it has no numbers of the model as inputs."
        )
    if p is not None and not isinstance(p, Mapping):
        return _array(program, last, p)
    given = {named.place(key): _array(program, last, x) for key, x in (p or {}).items()}
    named.require(given)
    kind = jnp.result_type(float, *others, *given.values())
    own = jnp.asarray(np.nan_to_num(named.values), kind)  # what is missing is given
    columns = [given.get(k, own[..., k]) for k in range(len(named.names))]
    return jnp.stack(jnp.broadcast_arrays(*columns), axis=-1).astype(kind)


def _array(program: Program, k: int, given: Any) -> Any:
    import jax.numpy as jnp

    try:
        return jnp.asarray(given)
    except (TypeError, ValueError) as problem:
        name = program.inputs[k].name if k < len(program.inputs) else f"argument {k}"
        raise KernelError(f"{program.name}: {name} is not an array of numbers: {problem}") from None


def _check(program: Program, arrays: Sequence[Any]) -> None:
    """Raise an error if arrays are too few or too many, have the wrong shape for their inputs, or
    lie along Explicit axes of a mesh."""
    inputs = program.inputs
    require_count(program.name, arrays, inputs)
    for x, argument in zip(arrays, inputs, strict=True):
        along = tuple(getattr(getattr(x.aval, "sharding", None), "spec", ()))
        if any(axis is not None for axis in along):
            raise KernelError(
                f"{program.name}: {argument.name} lies on several devices along axes of a mesh "
                f"that are Explicit, {along}. Take a mesh of axis_types=(jax.sharding.AxisType."
                f"Auto, …), along whose axes the batch is cut; or call it in jax.shard_map, where "
                f"each device has its own samples."
            )
    common_batch(program.name, inputs, arrays)


def _common(program: Program, arrays: Sequence[Any]) -> Any:
    """The common type, float64 or float32, by JAX's promotion rules; for integers JAX's default
    float type."""
    import jax.numpy as jnp

    for x, argument in zip(arrays, program.inputs, strict=True):
        if not (
            jnp.issubdtype(x.dtype, jnp.floating)
            or jnp.issubdtype(x.dtype, jnp.integer)
            or x.dtype == bool
        ):
            raise KernelError(no_real_numbers(f"{program.name}: {argument.name}", x))
    kind = jnp.result_type(*arrays) if arrays else jnp.dtype(bool)
    if not jnp.issubdtype(kind, jnp.floating):
        return jnp.zeros(()).dtype
    return kind if kind == np.float64 else np.dtype(np.float32)
