"""Inverse velocity (2.25) and acceleration (2.26): the rates of the joints that move a frame as
wanted."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from freebody.algorithms.screws import arm_length
from freebody.algorithms.singular_thresholds import NO_INVERSE
from freebody.arrays import Array, as_floats, at_sample, check_core, refuse_not_finite
from freebody.errors import FreebodyError, SingularError, warn
from freebody.inverse.problem.task import combined_rates, row_names, rows_of
from freebody.kernels.formulas import Option
from freebody.labels import aligned, labels_of
from freebody.model.model import Model
from freebody.model.model_argument import require_one
from freebody.model.shafts import untwisted
from freebody.trees.closer_looks import looking_closer
from freebody.trees.kinematics import jacobian, jacobian_dot
from freebody.trees.operational_space import as_it_is
from freebody.trees.public_calls import JointVector, common_batch, evaluate, finite_vector


def inverse_velocity(
    model: Model,
    q: JointVector,
    V: ArrayLike,
    frame: str | None = None,
    task: str | Sequence[str] | None = None,
    damping: float | None = None,
) -> Array:
    """Joint rates q̇ with J q̇ = V (2.25); of more joints than rows those of least norm.

    Parameters
    ----------
    model : Model
        An open chain.
    q : (..., nq)
        Positions, rad and m.
    V : (..., r)
        Velocity of the frame, linear (m/s) then angular (rad/s), world axes: for the r rows of the
        task, or (..., 6), (..., 3) in the plane, of which those rows are taken.
    frame : str, optional
        Name, default the tip.
    task : str or names of rows, optional
        "position", "orientation", "pose" or rows by name; default by the length of V: dim entries
        are a position's, all rows a pose's. So a planar 2R takes (ẋ, ẏ), the rows that make its J
        square. More rows than joints are refused.
    damping : float, optional
        A singular value of J (> 0, lengths over the arm's, such as 0.05): singular values below it
        are damped, q̇ is exact elsewhere, and a FreebodyWarning says how far off V is (Nakamura and
        Hanafusa 1986; Chiaverini 1997).

    Returns
    -------
    (..., nv)
        rad/s and m/s; 0 of the shafts of flexible joints, which do not twist meanwhile.

    Raises
    ------
    SingularError
        J loses rank, with the direction that is lost, unless `damping` is given.
    """
    require_one("inverse_velocity", model)
    model.require_tree("inverse_velocity", "fb.input_output(model, q).J")
    return _solved("inverse_velocity", model, q, "V", V, None, frame, task, damping)


def inverse_acceleration(
    model: Model,
    q: JointVector,
    qd: JointVector,
    A: ArrayLike,
    frame: str | None = None,
    task: str | Sequence[str] | None = None,
    damping: float | None = None,
) -> Array:
    """Joint accelerations q̈ with J q̈ + J̇ q̇ = A (2.26).

    Parameters
    ----------
    model, q, frame, task, damping
        As for `inverse_velocity`.
    qd : (..., nv)
        Rates, rad/s and m/s.
    A : (..., r)
        Acceleration of the frame, the time derivative of its velocity (m/s², rad/s²), world axes.

    Returns
    -------
    (..., nv)
        rad/s² and m/s².

    Raises
    ------
    SingularError
        As for `inverse_velocity`.
    """
    require_one("inverse_acceleration", model)
    model.require_tree("inverse_acceleration", "fb.input_output(model, q).J")
    return _solved("inverse_acceleration", model, q, "A", A, qd, frame, task, damping)


def _solved(
    function: str,
    model: Model,
    q: JointVector,
    letter: str,
    given: ArrayLike,
    qd: JointVector | None,
    frame: str | None,
    task: str | Sequence[str] | None,
    damping: float | None,
) -> Array:
    if damping is not None and not damping > 0.0:
        raise FreebodyError(
            f"{function}: damping is {damping}; it must be positive, such as 0.05, or None."
        )
    rows, wanted = _wanted(function, model, letter, given, task)
    option = Option(model.frame(frame).name, rows=tuple(rows))
    rigid = untwisted(model)
    if rigid is not None:
        at = rigid.links(finite_vector(function, model, "q", q))
        rates = None if qd is None else rigid.link_rates(finite_vector(function, model, "qd", qd))
        names = [row_names(model.dim)[r] for r in rows]
        found = _solved(
            function, rigid.model, at, letter, wanted, rates, option.frame, names, damping
        )
        return rigid.at_rates(found)
    if damping is None and len(rows) <= model.nv:
        inputs = (q, wanted) if qd is None else (q, qd, wanted)
        answer = looking_closer(partial(_closer, function, letter, None), {f"{letter}_ref": letter})
        return evaluate((function, option), model, inputs, as_it_is, None, answer)
    state = {"q": q} if qd is None else {"q": q, "qd": qd}
    state = {name: finite_vector(function, model, name, x) for name, x in state.items()}
    batch = common_batch(function, {**state, letter: wanted})
    wanted = np.broadcast_to(wanted, (*batch, len(rows)))
    return _closer(function, letter, damping, model, option, None, *state.values(), wanted)


def _closer(
    function: str,
    letter: str,
    damping: float | None,
    model: Model,
    option: Option,
    at: np.ndarray | None,
    q: Array,
    *others: Array,
) -> Array:
    """Rates for samples that the kernel cannot decide or that are damped, by singular values; at:
    the samples' indices in the whole batch, for errors."""
    name, rows = str(option.frame), list(option.rows)
    J, (*rates, wanted) = jacobian(model, q, name)[..., rows, :], others
    for qd in rates:
        drift = jacobian_dot(model, q, qd, name)[..., rows, :] @ qd[..., None]
        wanted = wanted - drift[..., 0]
    _refuse_too_few(function, model, name, J, rows)
    return _inverted(_JacobianRows(function, model, name, rows, letter), J, wanted, damping, at)


def _wanted(
    function: str, model: Model, letter: str, given: ArrayLike, task: str | Sequence[str] | None
) -> tuple[list[int], Array]:
    """The indices of the counted rows, and the wanted rates (..., r) in them."""
    given = aligned(function, letter, given, _row_labels(model, given, task), ("component", "axis"))
    array = as_floats(function, letter, given)
    six = 6 if model.dim == 3 else 3
    size = array.shape[-1] if array.ndim else 0
    if task is None:
        if size not in (model.dim, six):
            because = (
                f"{model.dim} entries for the position, {six} for the pose; "
                "else name the rows with task="
            )
            check_core(function, letter, array, (six,), because)
        task = "pose" if size == six else "position"
    rows = list(rows_of(function, model, task))
    if size != len(rows):
        names = ", ".join(row_names(model.dim)[r] for r in rows)
        check_core(function, letter, array, (six,), f"all rows, or {len(rows)} entries for {names}")
        array = array[..., rows]
    labels = [row_names(model.dim)[r] for r in rows]
    refuse_not_finite(function, letter, array, 1, labels)
    return rows, array


def _row_labels(model: Model, given: Any, task: str | Sequence[str] | None) -> tuple[str, ...]:
    """Names of the rows that a labelled vector may have: all, those of the task, or by default
    those of a position."""
    names = row_names(model.dim)
    if task is not None:
        chosen = tuple(names[r] for r in rows_of("task", model, task))
        return chosen if set(labels_of(given)) <= set(chosen) else names
    return names if set(labels_of(given)) - set(names[: model.dim]) else names[: model.dim]


class _JacobianRows:
    """A Jacobian's function, frame and names of rows, for error messages."""

    def __init__(self, function: str, model: Model, frame: str, rows: list[int], letter: str):
        self.function, self.letter = function, letter
        self.frame = f"frame {frame!r} of {model.name!r}"
        self.names = [row_names(model.dim)[r] for r in rows]
        length = arm_length(model.tree, frame)
        self.scale = np.array([1.0 / length if r < model.dim else 1.0 for r in rows])


def _refuse_too_few(function: str, model: Model, frame: str, J: Array, rows: list[int]) -> None:
    moving = (
        int((np.abs(J).max(axis=tuple(range(J.ndim - 1)), initial=0.0) > 0.0).sum())
        if J.size
        else model.nv
    )
    if moving >= len(rows) or not J.size:
        return
    names = row_names(model.dim)
    hint = (
        'task="position"'
        if moving >= model.dim
        else f"task={tuple(names[r] for r in rows[:moving])}"
    )
    raise SingularError(
        f"{function}: {moving} joint coordinate{'s' if moving != 1 else ''} of {model.name!r} "
        f"cannot give frame {frame!r} any motion in {len(rows)} rows "
        f"({', '.join(names[r] for r in rows)}); choose at most that many rows, such as {hint}."
    )


def _inverted(
    problem: _JacobianRows,
    J: Array,
    wanted: Array,
    damping: float | None,
    at: np.ndarray | None = None,
) -> Array:
    """The rates Σ σ / (σ² + λ²) v uᵀ wanted by singular values, with λ = 0 except near a
    singularity; at: the samples' indices in the whole batch."""
    U, sigma, Vt = np.linalg.svd(problem.scale[:, None] * J, full_matrices=False)
    if sigma.shape[-1] == 0 or not wanted.size:
        return np.zeros((*wanted.shape[:-1], J.shape[-1]))
    singular = sigma[..., -1] <= NO_INVERSE * np.maximum(sigma[..., 0], 1e-300)
    if damping is None:
        if np.any(singular):
            _refuse_singular(problem, U, np.asarray(singular), at)
        gain = 1.0 / sigma
    else:
        short = np.maximum(1.0 - (sigma / damping) ** 2, 0.0)
        gain = sigma / (sigma**2 + damping**2 * short)
    parts = np.swapaxes(U, -1, -2) @ (problem.scale * wanted)[..., None]
    rates = (np.swapaxes(Vt, -1, -2) @ (gain[..., None] * parts))[..., 0]
    if damping is not None:
        _say_damped(problem, J, rates, wanted)
    return rates


def _refuse_singular(
    problem: _JacobianRows, U: Array, singular: np.ndarray, places: np.ndarray | None
) -> None:
    at = tuple(map(int, np.argwhere(singular)[0]))
    place = at if places is None else tuple(map(int, places[at[0]]))
    lost = U[(*at, slice(None), -1)] * problem.scale  # lost · J = 0
    lost = lost / lost[np.argmax(np.abs(lost))]
    raise SingularError(
        f"{problem.function}: the Jacobian is singular{at_sample(place)}: {problem.frame} has lost "
        f"a degree of freedom: every motion that the joints can give it satisfies "
        f"{combined_rates(lost, problem.names)} = 0. Leave out a row (task=), or give damping=0.05 "
        f"for the nearest possible motion."
    )


def _say_damped(problem: _JacobianRows, J: Array, rates: Array, wanted: Array) -> None:
    off = np.abs((J @ rates[..., None])[..., 0] - wanted)
    worst = float(off.max())
    if worst > 1e-9 * max(1.0, float(np.abs(wanted).max())):
        at = [int(i) for i in np.unravel_index(int(np.argmax(off)), off.shape)]
        where = f" at sample {at[0] if len(at) == 2 else tuple(at[:-1])}" if len(at) > 1 else ""
        warn(
            f"{problem.function}: damped near a singularity: {problem.frame} gets {problem.letter} "
            f"but for {worst:.3g} in {problem.names[at[-1]]}{where}.",
        )
