"""Quantities of a model by name, as kernels and as functions of scalars inside users' functions,
and the request that `kernel`, `source`, `to_jax` and the like share."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple, overload

import numpy as np

from freebody.any_chain.kernel_options import chosen_option
from freebody.errors import FreebodyError, ShapeError, SingularError, UnknownNameError
from freebody.kernels.formulas import FORMULAS, Option
from freebody.kernels.inputs import InputKernel, KernelInputs, inputs_of
from freebody.kernels.lookup import ColumnKernel, KernelList, fetch
from freebody.kernels.options import several
from freebody.kernels.tracing import arguments, chosen, program
from freebody.model.model import Model
from freebody.model.model_argument import require_model
from freebody.model.named_numbers import Name
from freebody.program import Argument, Program
from freebody.targets import Kernel
from freebody.targets.call_errors import require_count


@overload
def kernel(
    model: Model,
    names: str | Sequence[str],
    *,
    frame: str | None = None,
    reference: str = "world",
    wrench_frames: Sequence[str] = (),
    rows: Sequence[str] | None = None,
    target: str | None = None,
    width: int | None = None,
    dtype: str = "float64",
    inputs: Name | Sequence[Name],
    by: str | Sequence[str] = (),
) -> InputKernel: ...


@overload
def kernel(
    model: Model,
    names: str | Sequence[str],
    *,
    frame: str | None = None,
    reference: str = "world",
    wrench_frames: Sequence[str] = (),
    rows: Sequence[str] | None = None,
    target: str | None = None,
    width: int | None = None,
    dtype: str = "float64",
    by: str | Sequence[str] = (),
) -> Kernel | ColumnKernel | KernelList | InputKernel: ...


def kernel(
    model: Model,
    names: str | Sequence[str],
    *,
    frame: str | None = None,
    reference: str = "world",
    wrench_frames: Sequence[str] = (),
    rows: Sequence[str] | None = None,
    target: str | None = None,
    width: int | None = None,
    dtype: str = "float64",
    inputs: Name | Sequence[Name] = (),
    by: str | Sequence[str] = (),
) -> Kernel | ColumnKernel | KernelList | InputKernel:
    """The compiled function for one quantity, or for several that share their work.

    Kernels of a closed chain assume that its loops are closed; at singular positions the drives'
    torques are NaN, where the public functions of the same names still answer. One step of a
    simulation is a quantity too: "rk4_step", "semi_implicit_step", "implicit_step" and
    "implicit_feedback_step", with the step's length h after tau, return (q1, qd1); see
    docs/stepping.md; and so are control laws, docs/control.md.

    Parameters
    ----------
    model : Model
        With all values. Of a family all numbers with members are inputs; where its members differ
        in limits alone, the size of gravity.
    names : str or list of str
        Among "inverse_dynamics", "forward_dynamics", "mass_matrix", "jacobian", …
    frame : str, optional
        For kinematic quantities; default the tip.
    reference : str
        "world" or "body" axes (for joint wrenches "child").
    wrench_frames : names
        Frames that carry external wrenches; each becomes a further input (..., 6): wrench0,
        wrench1, … in their order.
    rows : names, optional
        Of operational space, among "vx", "vy", "vz", "wx", "wy", "wz" (plane "vx", "vy", "w";
        default all).
    target : str, optional
        Where it runs: "cpu" (machine code by LLVM for this CPU), "cpu:x86-64-v3" (for all that
        reach this level, to the same bytes), "numpy" (node by node, without a compiler) or "cuda"
        (NVIDIA's GPUs; it takes arrays in their memory); None: what FREEBODY_TARGET says, else the
        CPU.
    width : int, optional
        Samples in a CPU vector; None: as many as suit it.
    dtype : str
        "float64", or "float32", which computes with numbers of 32 bits, about twice as fast in
        batches, to about 6 digits of a sample's largest entry; arrays of other real types are
        rounded to it, and so are the robot's numbers.
    inputs : names
        Numbers of the model that are to be given, by names and patterns of `fb.parameters`
        ("link*.mass"; patterns leave out exact zeros and right angles of placements, names in full
        take them): they are gathered, in the order of `fb.parameters`, in one last argument p
        (..., k), or given as p={name: value}; without p they are the model's own. k.parameters are
        their names, k.values the model's own.
    by : names
        Inputs by which each output is differentiated as well (exactly, in forward mode), "p" among
        them: after the outputs come their derivatives, dtau_dp (*output, k) and so on, output by
        output; those by positions are on the tangent space (nv).

    Returns
    -------
    k(q, qd, …, out=None, threads=None)
        Broadcasts like a NumPy ufunc, lets NaN through and checks no names; its inputs are those of
        the quantities, in the order q, qd, qdd, tau, wrenches, and its outputs in the order of
        `names`.

    Raises
    ------
    UnknownNameError
    SingularError
        The drives of a closed chain do not force its motion.
    """
    listed, option = chosen_option(
        model, names, frame=frame, reference=reference, wrench_frames=wrench_frames, rows=rows
    )
    return fetch(
        model,
        listed,
        option,
        target,
        width,
        dtype,
        several("fb.kernel", "inputs=", inputs),
        several("fb.kernel", "by=", by),
    )


_OPTIONS = ("frame", "reference", "wrench_frames", "rows")


class QuantityRequest(NamedTuple):
    """A request for quantities of a model: their names and options, the model numbers that are
    inputs p, and the inputs to differentiate by."""

    model: Model
    names: tuple[str, ...]
    option: Option
    given: KernelInputs | None
    by: tuple[str, ...]

    def p(self, uniform: bool = False) -> Argument | None:
        """The argument p for the model's numbers, the last input; None if no numbers are inputs.
        uniform: the same for all samples."""
        return Argument("p", (len(self.given.names),), uniform) if self.given else None

    def program(self) -> Program:
        """The program that computes the requested quantities."""
        over = self.given.tree if self.given else None
        return program(self.model, self.names, self.option, self.p(), over, self.by)


def requested(
    function: str,
    what: Model | Kernel | InputKernel,
    names: str | Sequence[str] | None,
    options: dict[str, Any],
) -> QuantityRequest | Kernel | InputKernel:
    """The checked request for quantities; a kernel passes unchanged and takes neither names nor
    options."""
    if isinstance(what, Kernel | InputKernel):
        if names is not None or options:
            raise FreebodyError(
                f"{function}: a kernel has its quantities already; give no names and no options."
            )
        return what
    require_model(function.removeprefix("fb."), what)
    if names is None:
        raise FreebodyError(f"{function}: give the quantities, such as 'inverse_dynamics'.")
    wanted, by = (several(function, f"{key}=", options.get(key, ())) for key in ("inputs", "by"))
    rest = {key: value for key, value in options.items() if key not in ("inputs", "by")}
    for key in rest:
        if key not in _OPTIONS:
            raise UnknownNameError("option", key, function, (*_OPTIONS, "inputs", "by"))
    listed, option = chosen_option(what, names, **rest, function=function)
    given = inputs_of(function, what, wanted) if wanted else None
    return QuantityRequest(what, listed, option, given, by)


def formula(
    model: Model,
    name: str,
    *,
    frame: str | None = None,
    reference: str = "world",
    wrench_frames: Sequence[str] = (),
    rows: Sequence[str] | None = None,
) -> Callable[..., Any]:
    """A quantity of a model as a function of scalars, to be called inside what `fb.compile` takes.

    Parameters
    ----------
    model, frame, reference, wrench_frames, rows
        As for `fb.kernel`. The model's numbers are constants of what is compiled.
    name
        One quantity.

    Returns
    -------
    callable
        f(q, qd, …), with the inputs of the kernel of that name: sequences of its core shapes, of
        traced scalars, floats, or arrays with an entry for each sample. It returns its output as a
        nested tuple, or the tuple of its outputs. States of closed chains have to be closed.

    Raises
    ------
    UnknownNameError, SingularError
        As `fb.kernel`.
    """
    if not isinstance(name, str):
        raise FreebodyError(
            "fb.formula: give the name of one quantity; of several, make several functions."
        )
    listed, option = chosen_option(
        model,
        name,
        frame=frame,
        reference=reference,
        wrench_frames=wrench_frames,
        rows=rows,
        function="fb.formula",
    )
    inputs, record, tree = arguments(model, listed, option), FORMULAS[name], model.tree

    def function(*values: Any) -> Any:
        require_count(name, values, inputs)
        given = {
            x.name: _nested(name, x.name, v, x.shape) for x, v in zip(inputs, values, strict=True)
        }
        try:
            results = record.evaluate(tree, option, **chosen(name, given, option))
        except ZeroDivisionError:
            raise SingularError(
                f"{name} of {model.name!r} divides by zero at this state."
            ) from None
        results = tuple(map(_tuples, results))
        return results[0] if len(results) == 1 else results

    function.__name__ = function.__qualname__ = name
    function.__doc__ = f"{name}({', '.join(map(str, inputs))}) of scalars."
    return function


def _nested(function: str, name: str, value: Any, shape: tuple[int, ...]) -> Any:
    """A sequence or array as nested tuples of the given shape; raises an error for another
    shape."""
    if not shape:
        return value
    is_sequence = isinstance(value, tuple | list) or (
        isinstance(value, np.ndarray) and value.ndim > 0
    )
    if not is_sequence or len(value) != shape[0]:
        raise ShapeError(function, name, (len(value),) if is_sequence else (), str(shape))
    return tuple(_nested(function, name, entry, shape[1:]) for entry in value)


def _tuples(value: Any) -> Any:
    return tuple(map(_tuples, value)) if isinstance(value, tuple | list) else value
