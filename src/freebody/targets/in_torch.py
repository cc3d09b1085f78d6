"""Programs on PyTorch's tensors: an autograd function and a custom operator, both over compiled
kernels.

PyTorch calls the autograd function, which knows gradients, directions, `vmap` and whatever is
nested of them. Where PyTorch makes a graph (torch.compile, torch.export) the operator
`freebody::evaluate` stands in it, and finds its program by a key. Tensors are read where they lie,
and results handed over without a copy.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any
from weakref import WeakValueDictionary

import numpy as np
import torch  # pyright: ignore[reportMissingImports]
from torch.autograd import forward_ad  # pyright: ignore[reportMissingImports]

from freebody.lazy import cached_property
from freebody.program import Program
from freebody.program.derivative import directional, gradient
from freebody.targets.call_errors import common_batch
from freebody.targets.kernel import Kernel, compile_program
from freebody.targets.target import KernelError

Tensor = Any  # torch.Tensor; a type checker without PyTorch would know nothing of it
ArgumentNumbers = tuple[int, ...]

DTYPES = {torch.float64: "float64", torch.float32: "float32"}
"""Types of number that kernels compute with."""


class TensorProgram:
    """A program for tensors of one type, and those of its derivatives, made on first use.

    key: what stands for it in a graph.
    """

    def __init__(self, program: Program, target: str, dtype: Any):
        self.program, self.target, self.dtype = program, target, dtype
        self.key = f"{program.name} {target} {DTYPES[dtype]} {program.digest}"
        self._derivatives: dict[tuple[ArgumentNumbers, ...], TensorProgram] = {}

    @classmethod
    def of(cls, program: Program, target: str, dtype: Any) -> TensorProgram:
        """The tensor program of a program, one object for each; graphs find it by its key while it
        is in use."""
        made = cls(program, target, dtype)
        return _KNOWN.setdefault(made.key, made)

    @cached_property
    def kernel(self) -> Kernel:
        """The kernel that computes the program."""
        return compile_program(self.program, target=self.target, dtype=DTYPES[self.dtype])

    def gradient(self, by: ArgumentNumbers, of: ArgumentNumbers) -> TensorProgram:
        """The program from the inputs and weights of the outputs `of` to the gradient by the inputs
        `by`."""
        return self._derivative((by, of), gradient)

    def along(self, by: ArgumentNumbers) -> TensorProgram:
        """The program from the inputs and directions of the inputs `by` to the change of the
        outputs."""
        return self._derivative((by,), directional)

    def _derivative(
        self, which: tuple[ArgumentNumbers, ...], made: Callable[..., Program]
    ) -> TensorProgram:
        if which not in self._derivatives:
            program = made(self.program, *which)
            self._derivatives[which] = TensorProgram.of(program, self.target, self.dtype)
        return self._derivatives[which]

    def batch(self, tensors: Sequence[Tensor]) -> tuple[int, ...]:
        """The common batch shape of the tensors; refuses wrong core shapes."""
        program = self.program
        return common_batch(program.name, program.inputs, tensors, torch.broadcast_shapes)


_KNOWN: WeakValueDictionary[str, TensorProgram] = WeakValueDictionary()
"""Programs by key, as long as somebody holds them."""

_IN_GRAPHS: dict[str, TensorProgram] = {}
"""Programs by key that are in a graph: PyTorch keeps graphs, and they have nothing but the key."""


def evaluate(function: TensorProgram, tensors: Sequence[Tensor]) -> tuple[Tensor, ...]:
    """The outputs as tensors that take part in PyTorch's gradients, transforms and graphs.

    tensors: on the CPU, of the function's type, one for each input.
    """
    if torch.compiler.is_compiling():
        return tuple(_operator(function.key, list(tensors)))
    if _watched():
        made = _Evaluate.apply(function, *tensors)
    elif torch.is_grad_enabled() and any(x.requires_grad for x in tensors):
        made = _Recorded.apply(function, *tensors)
    else:
        return _computed(function, tensors)
    return made if type(made) is tuple else (made,)


_PLAIN = (torch.Tensor, torch.nn.Parameter)


def _watched() -> bool:
    """Whether a transform (`vmap`, `jvp`, …) may be active, which sees only operations of
    PyTorch."""
    try:
        nested = torch._C._functorch.peek_interpreter_stack()  # pyright: ignore[reportAttributeAccessIssue]
        return nested is not None or forward_ad._current_level >= 0
    except AttributeError:  # other names in another PyTorch: the longer way is always right
        return True


def _graphed() -> bool:
    """Whether tensors may be placeholders without usable memory, so that the custom operator must
    be called."""
    try:
        return torch._C._len_torch_dispatch_stack() > 0 or torch._C._get_tracing_state() is not None
    except AttributeError:
        return True


def _computed(function: TensorProgram, tensors: Sequence[Tensor]) -> tuple[Tensor, ...]:
    """The outputs, computed by the kernel where the tensors have memory of their own."""
    if _graphed() or any(type(x) not in _PLAIN or x.is_meta for x in tensors):
        return tuple(_operator(function.key, list(tensors)))
    return _run(function, tensors)


def _run(function: TensorProgram, tensors: Sequence[Tensor]) -> tuple[Tensor, ...]:
    """The outputs, computed by the kernel from the tensors' memory."""
    try:
        arrays = [
            x.numpy(force=True) if x.requires_grad or x.is_neg() else x.numpy() for x in tensors
        ]
    except (TypeError, RuntimeError) as problem:  # sparse ones, say
        raise KernelError(
            f"{function.program.name}: a tensor that is not a plain array: {problem}"
        ) from None
    made = function.kernel(*arrays)
    return tuple(
        [torch.from_numpy(np.asarray(y)) for y in (made if type(made) is tuple else (made,))]
    )


def _gradients(
    function: TensorProgram,
    call: Callable[..., Sequence[Tensor]],
    tensors: Sequence[Tensor],
    needed: Sequence[bool],
    weights: Sequence[Tensor | None],
) -> list[Tensor | None]:
    """The gradient by each input that needs one, in the input's shape."""
    found: list[Tensor | None] = [None] * len(tensors)
    of = tuple([k for k, weight in enumerate(weights) if weight is not None])
    by = tuple([k for k, wanted in enumerate(needed) if wanted])
    if of and by:
        made = call(function.gradient(by, of), [*tensors, *(weights[k] for k in of)])
        for k, slope in zip(by, made, strict=True):
            found[k] = slope.sum_to_size(tensors[k].shape)  # over axes along which it was broadcast
    return found


class _Evaluate(torch.autograd.Function):
    """A program as an autograd function of PyTorch."""

    @staticmethod
    def forward(function: TensorProgram, *tensors: Tensor) -> Any:
        made = _computed(function, tensors)
        return made[0] if len(made) == 1 else made

    @staticmethod
    def setup_context(ctx: Any, inputs: Any, output: Any) -> None:
        ctx.function, *tensors = inputs
        ctx.set_materialize_grads(False)
        ctx.save_for_backward(*tensors)
        ctx.save_for_forward(*tensors)

    @staticmethod
    def backward(ctx: Any, *weights: Tensor | None) -> Any:
        return None, *_gradients(
            ctx.function, evaluate, ctx.saved_tensors, ctx.needs_input_grad[1:], weights
        )

    @staticmethod
    def jvp(ctx: Any, _: None, *directions: Tensor | None) -> Any:
        by = tuple([k for k, direction in enumerate(directions) if direction is not None])
        made = evaluate(ctx.function.along(by), [*ctx.saved_tensors, *(directions[k] for k in by)])
        return made[0] if len(made) == 1 else made

    @staticmethod
    def vmap(
        info: Any, in_dims: Sequence[int | None], function: TensorProgram, *tensors: Tensor
    ) -> Any:
        """The rule of `vmap`: the program applied to tensors with one more axis in front."""
        made = evaluate(function, _in_front(function.program, tensors, in_dims[1:]))
        return (made[0], 0) if len(made) == 1 else (made, (0,) * len(made))


class _Recorded(torch.autograd.Function):
    """A program as an autograd function for use where no transform is active, which PyTorch calls
    in half the time."""

    @staticmethod
    def forward(ctx: Any, function: TensorProgram, *tensors: Tensor) -> Any:
        made = _Evaluate.forward(function, *tensors)
        ctx.function = function
        ctx.set_materialize_grads(False)
        ctx.save_for_backward(*tensors)
        return made

    backward = _Evaluate.backward


def _in_front(
    program: Program, tensors: Sequence[Tensor], dims: Sequence[int | None]
) -> list[Tensor]:
    """Tensors with the mapped axis in front of all batch axes, padded to an equal number of
    these."""
    moved = [x if d is None else x.movedim(d, 0) for x, d in zip(tensors, dims, strict=True)]
    axes = [
        x.ndim - len(argument.shape) - (d is not None)
        for x, argument, d in zip(moved, program.inputs, dims, strict=True)
    ]
    most = max(axes)
    return [
        x if d is None else x.reshape(x.shape[0], *(1,) * (most - own), *x.shape[1:])
        for x, d, own in zip(moved, dims, axes, strict=True)
    ]


# ---------------------------------------------------------------- the operator of graphs
def _named(key: str) -> TensorProgram:
    function = _KNOWN.get(key)
    if function is None:
        raise KernelError(
            f"freebody::evaluate: no program {key[:200]!r} in this process. A graph holds its "
            f"name, not the program: "
            "call fb.to_torch with the same arguments as for the graph, and keep the result."
        )
    return function


@torch.library.custom_op("freebody::evaluate", mutates_args=())
def _operator(key: str, inputs: Sequence[torch.Tensor]) -> list[torch.Tensor]:
    return list(_run(_named(key), inputs))


@_operator.register_fake
def _(key: str, inputs: Sequence[torch.Tensor]) -> list[torch.Tensor]:
    function = _IN_GRAPHS[key] = _named(key)
    batch = function.batch(inputs)
    # of one tensor without numbers none come out
    device = next((x.device for x in inputs if x.is_meta), inputs[0].device)
    return [
        torch.empty((*batch, *argument.shape), dtype=function.dtype, device=device)
        for argument in function.program.outputs
    ]


def _setup(ctx: Any, inputs: Any, output: Any) -> None:
    ctx.key, tensors = inputs
    ctx.save_for_backward(*tensors)


def _backward(ctx: Any, weights: Sequence[Tensor | None]) -> Any:
    def call(function: TensorProgram, tensors: Sequence[Tensor]) -> Sequence[Tensor]:
        return _operator(function.key, list(tensors))

    return None, _gradients(
        _named(ctx.key), call, ctx.saved_tensors, ctx.needs_input_grad[1], weights
    )


def _vmap(info: Any, in_dims: Any, key: str, inputs: Sequence[Tensor]) -> Any:
    function = _named(key)
    made = _operator(key, _in_front(function.program, inputs, in_dims[1]))
    return made, [0] * len(made)


_operator.register_autograd(_backward, setup_context=_setup)
_operator.register_vmap(_vmap)
