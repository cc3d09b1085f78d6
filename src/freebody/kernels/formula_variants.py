"""Arguments that choose a formula's variant, shared by all functions that have them: names, rows of
a frame's motion, and how many rows a robot's joints can serve."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Sequence
from typing import Any

from freebody.algorithms.inverse_rates import wrench_rows
from freebody.errors import FreebodyError, KindError, SingularError, UnknownNameError
from freebody.kernels.formulas.record import Formula, Untaken
from freebody.model.losses import require_lossless
from freebody.model.model import Model
from freebody.outputs.display import counted


def several(function: str, argument: str, given: Any) -> tuple[Any, ...]:
    """The names given in a call, one or several, as a tuple."""
    if isinstance(given, str):
        return (given,)
    listed = isinstance(given, (list, tuple)) and all(isinstance(x, Hashable) for x in given)
    if not listed:
        raise KindError(function, argument, given, "a name or a list of names")
    return tuple(given)


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


def refuse_struts(function: str, model: Model) -> None:
    """Refuse a model with struts, which a function leaves out."""
    if model.struts:
        raise FreebodyError(
            f"{function}: {model.name!r} has struts ({', '.join(model.strut_names)}), whose forces "
            f'are left out here; take model.without("struts").'
        )


def refuse_untaken(function: str, model: Model, formula: Formula) -> None:
    """Refuse a model with a feature that a formula cannot take, in the name of a function."""
    for feature, refuse in _REFUSALS:
        if feature in formula.cannot_take:
            refuse(function, model)


_REFUSALS: tuple[tuple[Untaken, Callable[[str, Model], None]], ...] = (
    ("struts", refuse_struts),
    ("losses", require_lossless),
)
"""How a model with a feature is refused, where it has it."""


def require_square(function: str, model: Model) -> None:
    """Raise SingularError where a wrench has not as many components as there are torques."""
    rows = wrench_rows(model.nv, len(motion_row_names(model)), model.dim)
    if rows != model.nv:
        raise SingularError(
            f"{function}: {model.name!r} has {counted(model.nv, 'joint')} but the wrench {rows} "
            f"components; torques determine it only when these are equal."
        )
