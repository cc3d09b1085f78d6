"""Kernels as functions of PyTorch tensors."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from freebody.errors import FreebodyError, KindError, MissingPackageError
from freebody.kernels.parameter_inputs import InputKernel
from freebody.model.model import Model
from freebody.targets import Kernel, KernelError
from freebody.targets.call_errors import require_count
from freebody.targets.target import target_named
from freebody.ways_out.kernel import kernel

if TYPE_CHECKING:
    from freebody.targets.torch_operator import Tensor, TensorProgram


def to_torch(
    what: Model | Kernel | InputKernel,
    names: str | Sequence[str] | None = None,
    *,
    dtype: str | None = None,
    **options: Any,
) -> TorchFunction:
    """A function of PyTorch tensors that computes as `fb.kernel` does, differentiable to any order.
    Needs PyTorch.

    Derivatives are of the numbers that come in: of a quaternion by its four entries as they stand.
    They have kernels of their own, compiled on first use, by those inputs alone that require a
    gradient. torch.autograd, torch.func (grad, vjp, jvp, jacrev, jacfwd, hessian, vmap),
    torch.compile and torch.export all know them. NaN goes through, as in kernels; names and limits
    are not checked.

    Parameters
    ----------
    what
        A model, or a kernel of `fb.kernel` or `fb.compile`.
    names
        Quantities of the model, as for `fb.kernel`; none for a kernel.
    dtype
        "float64" or "float32", of the results, which is also computed with. None: that of the
        tensors (of both kinds float64), of a kernel the kernel's own.
    **options
        As for `fb.kernel`: frame, reference, wrench_frames, rows, inputs, by, target.

    Returns
    -------
    TorchFunction
        f(q, qd, …), one tensor or a tuple: arguments (..., *core) as of the kernel, on the CPU;
        leading axes broadcast. Python's numbers may stand for constants. With inputs=, p (..., k)
        comes last, or is given as p={name: number or tensor}, the rest being the model's;
        f.parameters are its names.

    Raises
    ------
    UnknownNameError, SingularError
        As `fb.kernel`.
    FreebodyError
        PyTorch is not installed, or matrices of so many coordinates that no one program computes
        them.
    """
    if isinstance(what, Kernel | InputKernel):
        if names is not None or options:
            raise FreebodyError(
                "fb.to_torch: a kernel has its quantities already; give no names and no options."
            )
        own = what.kernel if isinstance(what, InputKernel) else what
        return TorchFunction(what, dtype or own.dtype.name)
    if names is None:
        raise FreebodyError("fb.to_torch: give the quantities, such as 'inverse_dynamics'.")
    made = kernel(what, names, **options)
    if not isinstance(made, Kernel | InputKernel):
        raise FreebodyError(
            f"fb.to_torch: of {what.nv} coordinates these matrices are computed column by column, "
            f"not by one program, and cannot be differentiated; ask for vectors, such as "
            f"'inverse_dynamics'."
        )
    return TorchFunction(made, dtype)


class TorchFunction:
    """A kernel as a function of PyTorch tensors; see `fb.to_torch`.

    Attributes
    ----------
    program
        What was traced.
    parameters
        Names of the entries of p; none where there is no p.
    values
        p of the model itself, of a family (*family, k).
    """

    def __init__(self, kernel: Kernel | InputKernel, dtype: str | None):
        try:
            import torch  # pyright: ignore[reportMissingImports]

            from freebody.targets import torch_operator
        except ImportError:
            raise MissingPackageError("fb.to_torch", "PyTorch", "torch") from None
        known = {name: kind for kind, name in torch_operator.DTYPES.items()}
        if dtype is not None and dtype not in known:
            raise KernelError(
                f"fb.to_torch: dtype={dtype!r}; it can be {' or '.join(map(repr, known))}."
            )
        self._kernel, self._dtype = kernel, dtype
        self._fixed = None if dtype is None else known[dtype]
        self.program = kernel.program
        self.parameters: tuple[str, ...] = (
            kernel.parameters if isinstance(kernel, InputKernel) else ()
        )
        self.values = kernel.values if isinstance(kernel, InputKernel) else np.zeros(0)
        own = kernel.kernel if isinstance(kernel, InputKernel) else kernel
        if not target_named(own.target).host:
            raise FreebodyError(
                f"fb.to_torch: the functions run on the CPU, not on target {own.target!r}, whose "
                "kernels accept PyTorch's tensors directly, without gradients: call what fb.kernel "
                "returns."
            )
        self._of: dict[Any, TensorProgram] = {
            kind: torch_operator.TensorProgram.of(kernel.program, own.target, kind)
            for kind in known.values()
        }
        self._torch, self._evaluate = torch, torch_operator.evaluate

    def __call__(self, *tensors: Tensor, p: Any = None) -> Any:
        """The output, or the tuple of outputs.

        tensors: one for each input, (..., *core). p: the last of them by its name, or {name: number
        or tensor}. Raises ShapeError, BatchError, KernelError.
        """
        named = p.values() if isinstance(p, Mapping) else () if p is None else (p,)
        kind = self._fixed or self._common((*tensors, *named))
        values = [self._tensor(x, kind) for x in tensors]
        if p is not None or (self.parameters and len(values) < len(self.program.inputs)):
            values.append(self._numbers(p, kind))
        require_count(self.program.name, values, self.program.inputs)
        made = self._evaluate(self._of[kind], values)
        return made[0] if len(made) == 1 else made

    def _common(self, given: Sequence[Any]) -> Any:
        """The common type of the tensors; float64 for mixed types and where all arguments are plain
        numbers."""
        torch = self._torch
        kinds = {x.dtype for x in given if isinstance(x, torch.Tensor)}
        return torch.float32 if kinds == {torch.float32} else torch.float64

    def _tensor(self, x: Any, kind: Any) -> Tensor:
        """A tensor, or a number as a tensor, in the number type `kind`; refuses anything else."""
        torch = self._torch
        if not isinstance(x, torch.Tensor):
            if type(x) in (int, float):
                return torch.tensor(x, dtype=kind)
            raise KindError(
                self.program.name, "an argument", x, "a tensor", "torch.as_tensor makes one."
            )
        if x.dtype not in self._of:
            raise KernelError(
                f"{self.program.name}: a tensor of {x.dtype}; kernels compute with torch.float64 "
                f"and torch.float32: convert it with .to(...)."
            )
        if not x.is_cpu and not x.is_meta:
            raise KernelError(
                f"{self.program.name}: a tensor on {str(x.device)!r}; these kernels run on the "
                f"CPU: move it there with .cpu()."
            )
        return x if x.dtype is kind else x.to(kind)

    def _numbers(self, p: Any, kind: Any) -> Tensor:
        """The tensor p (..., k) of model numbers: a given tensor itself; {name: value} completed by
        the model's own numbers; without p all of the model's own."""
        torch = self._torch
        if not isinstance(self._kernel, InputKernel):
            raise KernelError(
                f"{self.program.name}: p is given, but it has no numbers of the model as inputs."
            )
        if p is not None and not isinstance(p, Mapping):
            return self._tensor(p, kind)
        given = {
            self._kernel.named.place(key): self._tensor(x, kind) for key, x in (p or {}).items()
        }
        self._kernel.named.require(given)
        own = torch.from_numpy(self._kernel.values.copy()).to(kind)
        if not given:
            return own
        columns = [given.get(k, own[..., k]) for k in range(len(self.parameters))]
        return torch.stack(torch.broadcast_tensors(*columns), dim=-1)

    def __repr__(self) -> str:
        return f"TorchFunction({self.program}; {self._dtype or 'of the tensors'})"

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle support: another process compiles the kernels again, or finds them in the
        cache."""
        return TorchFunction, (self._kernel, self._dtype)
