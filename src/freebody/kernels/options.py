"""Quantities of a model with the options of `fb.kernel`, checked against the formulas that are
meant, and put together as one record; where a computation leaves freebody, a kernel may stand in
their place."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

from freebody.algorithms.inverse_rates import wrench_rows
from freebody.errors import FreebodyError, KindError, SingularError, UnknownNameError
from freebody.kernels.closed_chains import closed_chain_function
from freebody.kernels.formulas import FORMULAS, Option
from freebody.kernels.formulas.inverse import known_branches
from freebody.kernels.inputs import InputKernel, KernelInputs, inputs_of
from freebody.kernels.tracing import program
from freebody.model.model import Model
from freebody.model.model_argument import require_model
from freebody.outputs.display import counted
from freebody.program import Argument, Program
from freebody.targets import Kernel


def several(function: str, argument: str, given: Any) -> tuple[Any, ...]:
    """One name, or several, as a tuple."""
    if isinstance(given, str):
        return (given,)
    if not isinstance(given, (list, tuple)):
        raise KindError(function, argument, given, "a name or a list of names")
    return tuple(given)


def chosen_option(
    model: Model,
    names: str | Sequence[str],
    *,
    frame: str | None = None,
    reference: str = "world",
    wrench_frames: Sequence[str] = (),
    rows: Sequence[str] | None = None,
    function: str = "fb.kernel",
) -> tuple[tuple[str, ...], Option]:
    """The names as a tuple, and the structure that they depend on, checked; arguments as for
    `kernel`.

    function: what was called, for errors.
    """
    listed = several(function, "names", names)
    for name in listed:
        if name not in FORMULAS:
            raise UnknownNameError("quantity", name, function, FORMULAS)
        if listed.count(name) > 1:
            raise FreebodyError(f"{function}: the quantity {name!r} is asked for twice.")
        _require_chain(function, model, name)
    if not listed:
        raise FreebodyError(f"{function}: give at least one quantity.")
    _require_used(
        function, listed, frame=frame, reference=reference, wrench_frames=wrench_frames, rows=rows
    )
    _require_axes(listed, reference)
    chosen = motion_rows(model, rows)
    if any(FORMULAS[name].free_rows for name in listed):
        require_few_rows(function, model, chosen)
    option = Option(
        model.frame(frame).name if any(FORMULAS[name].of_frame for name in listed) else None,
        reference,
        tuple(model.frame(f).name for f in wrench_frames),
        rows=chosen,
    )
    if any("redundancy" in FORMULAS[name].inputs for name in listed):
        option = option._replace(redundant=known_branches(model.tree, option).held is not None)
    return listed, _near_home(function, model, listed, option) if model.loops else option


def _require_chain(function: str, model: Model, name: str) -> None:
    """Refuse a quantity that says nothing of chains such as the model."""
    chains = FORMULAS[name].chains
    if chains in ("open", "arm", "square"):
        model.require_tree(f"{function}: {name}")
    if chains == "square":
        require_square(function, model)
    if chains == "closed" and not model.loops:
        raise FreebodyError(
            f"{function}: {name}: {model.name!r} has no loops; add one with model.with_loop(...)."
        )


def _near_home(function: str, model: Model, listed: tuple[str, ...], option: Option) -> Option:
    """The option of a closed chain with those equations and coordinates chosen that tell all near
    its home, whatever positions will come."""
    if any(FORMULAS[name].settled == "equations" for name in listed):
        option = option._replace(equations=closed_chain_function("counting_equations")(model))
    for name in listed:
        settled = FORMULAS[name].settled
        if settled in ("partition", "loops"):
            # one by the drives does for what the loops do, too
            by_drives = settled == "partition" or any(
                FORMULAS[x].settled == "partition" for x in listed
            )
            chosen = closed_chain_function("require_partition")(
                model, f"{function}: {name}", by_drives
            )
            option = option._replace(partition=chosen)
    return option


def _require_used(function: str, listed: Sequence[str], **given: Any) -> None:
    """Refuse an option that none of the quantities uses."""
    for name, value in given.items():
        is_given = (
            value is not None
            and value != "world"
            and not (name == "wrench_frames" and not len(value))
        )
        if is_given and not any(FORMULAS[x].uses(name) for x in listed):
            used = ", ".join(x for x, formula in FORMULAS.items() if formula.uses(name))
            raise FreebodyError(
                f"{function}: {name}={value!r} has no meaning for {', '.join(listed)}; it is for "
                f"{used}."
            )


def _require_axes(listed: Sequence[str], reference: str) -> None:
    """Refuse axes that not all of the quantities that have a choice can be given in."""
    offered = [FORMULAS[name].axes for name in listed if FORMULAS[name].axes]
    common = (
        "world",
        *(x for x in dict.fromkeys(sum(offered, ())) if all(x in axes for axes in offered)),
    )
    if reference not in common:
        raise UnknownNameError("reference", reference, "reference=", common)


def motion_row_names(model: Model) -> tuple[str, ...]:
    """Names of the rows of a frame's motion."""
    return ("vx", "vy", "vz", "wx", "wy", "wz") if model.dim == 3 else ("vx", "vy", "w")


def motion_rows(model: Model, rows: Sequence[str] | None) -> tuple[int, ...]:
    """Indices of rows of a frame's motion by name; None is all of them."""
    names = motion_row_names(model)
    if rows is not None and (isinstance(rows, str) or not len(rows) or len(set(rows)) < len(rows)):
        raise FreebodyError(
            f"rows is {rows!r}, expected one or several of {', '.join(names)}, each once."
        )
    for row in rows or ():
        if row not in names:
            raise UnknownNameError("row", row, "rows=", names)
    return tuple(names.index(row) for row in (names if rows is None else rows))


def require_few_rows(function: str, model: Model, rows: Sequence[int]) -> None:
    """Raise SingularError where there are more rows of a frame's motion than joint coordinates."""
    if len(rows) > model.nv:
        raise SingularError(
            f"{function}: {model.name!r} has {counted(model.nv, 'joint coordinate')} and cannot "
            f"move a frame along {len(rows)} rows; choose as many at most, such as "
            f'rows=("vx", "vy").'
        )


def require_square(function: str, model: Model) -> None:
    """Raise SingularError where a wrench has not as many components as there are torques."""
    rows = wrench_rows(model.nv, len(motion_row_names(model)), model.dim)
    if rows != model.nv:
        raise SingularError(
            f"{function}: {model.name!r} has {counted(model.nv, 'joint')} but the wrench {rows} "
            f"components; torques determine it only when these are equal."
        )


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
