"""The request where a computation leaves freebody: a kernel, or quantities of a model with
options."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

from freebody.any_chain.kernel_options import chosen_option
from freebody.errors import FreebodyError, UnknownNameError
from freebody.kernels.formulas import Option
from freebody.kernels.inputs import InputKernel, KernelInputs, inputs_of
from freebody.kernels.options import several
from freebody.kernels.tracing import program
from freebody.model.model import Model
from freebody.model.model_argument import require_model
from freebody.program import Argument, Program
from freebody.targets import Kernel

_OPTIONS = ("frame", "reference", "wrench_frames", "rows")


class QuantityRequest(NamedTuple):
    """Quantities of a model, their variant, numbers that are given as p, and inputs by which they
    are differentiated."""

    model: Model
    names: tuple[str, ...]
    option: Option
    given: KernelInputs | None
    by: tuple[str, ...]

    def p(self, uniform: bool = False) -> Argument | None:
        """The last input, if numbers are given."""
        return Argument("p", (len(self.given.names),), uniform) if self.given else None

    def program(self) -> Program:
        """The program of the quantities."""
        over = self.given.tree if self.given else None
        return program(self.model, self.names, self.option, self.p(), over, self.by)


def requested(
    function: str,
    what: Model | Kernel | InputKernel,
    names: str | Sequence[str] | None,
    options: dict[str, Any],
) -> QuantityRequest | Kernel | InputKernel:
    """The quantities of a request, checked; or the kernel itself, which takes neither names nor
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
