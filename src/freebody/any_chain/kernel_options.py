"""Options of `fb.kernel`: checked against the formulas that are asked for, put together as one
record, and of closed chains settled near the model's home."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from freebody.errors import FreebodyError, UnknownNameError
from freebody.kernels.formulas import FORMULAS, Option
from freebody.kernels.formulas.inverse import known_branches
from freebody.kernels.options import (
    motion_rows,
    refuse_struts,
    require_few_rows,
    require_square,
    several,
)
from freebody.model.losses import require_lossless
from freebody.model.model import Model


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
    """The names of quantities as a tuple, and the checked option that says which kernel is meant;
    arguments as for `kernel`.

    function: what was called, for errors.
    """
    listed = several(function, "names", names)
    _require_possible(function, model, listed)
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


def _require_possible(function: str, model: Model, listed: tuple[str, ...]) -> None:
    """Refuse names of no quantity, names given twice, and quantities that this kind of chain does
    not have."""
    for name in listed:
        if name not in FORMULAS:
            raise UnknownNameError("quantity", name, function, FORMULAS)
        if listed.count(name) > 1:
            raise FreebodyError(f"{function}: the quantity {name!r} is asked for twice.")
        if FORMULAS[name].chains in ("open", "arm", "square"):
            model.require_tree(f"{function}: {name}")
        if FORMULAS[name].without_struts:
            refuse_struts(f"{function}: {name}", model)
        if FORMULAS[name].lossless:
            require_lossless(f"{function}: {name}", model)
        if FORMULAS[name].chains == "square":
            require_square(function, model)
        if FORMULAS[name].chains == "closed" and not model.loops:
            raise FreebodyError(
                f"{function}: {name}: {model.name!r} has no loops; add one with "
                f"model.with_loop(...)."
            )
    if not listed:
        raise FreebodyError(f"{function}: give at least one quantity.")


def _near_home(function: str, model: Model, listed: tuple[str, ...], option: Option) -> Option:
    """The option with those equations and coordinates of a closed chain that are independent near
    its home, whatever positions will follow."""
    from freebody.loops.independent_equations import counting_equations, require_partition

    if any(FORMULAS[name].settled == "equations" for name in listed):
        option = option._replace(equations=counting_equations(model))
    for name in listed:
        settled = FORMULAS[name].settled
        if settled in ("partition", "loops"):
            # one by the drives does for what the loops do, too
            by_drives = settled == "partition" or any(
                FORMULAS[x].settled == "partition" for x in listed
            )
            chosen = require_partition(model, f"{function}: {name}", by_drives)
            option = option._replace(partition=chosen)
    return option


def _require_used(function: str, listed: Sequence[str], **given: Any) -> None:
    """Refuse an option that none of the quantities uses."""
    for name, value in given.items():
        is_set = (
            value is not None
            and value != "world"
            and not (name == "wrench_frames" and not len(value))
        )
        if is_set and not any(FORMULAS[x].uses(name) for x in listed):
            used = ", ".join(x for x, formula in FORMULAS.items() if formula.uses(name))
            raise FreebodyError(
                f"{function}: {name}={value!r} has no meaning for {', '.join(listed)}; it is for "
                f"{used}."
            )


def _require_axes(listed: Sequence[str], reference: str) -> None:
    """Refuse a choice of axes that some of the listed quantities cannot be given in."""
    offered = [FORMULAS[name].axes for name in listed if FORMULAS[name].axes]
    common = (
        "world",
        *(x for x in dict.fromkeys(sum(offered, ())) if all(x in axes for axes in offered)),
    )
    if reference not in common:
        raise UnknownNameError("reference", reference, "reference=", common)
