"""The independent loop equations of a model, scaled; by how much they are violated, and messages on
that.

Where numbers are rounded and equations redundant, what counts are combinations of them: see
`redundancy`.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Sequence
from typing import NoReturn

import numpy as np
from numpy.typing import NDArray

from freebody.algorithms.loop_checks import CLOSED, LEFT
from freebody.arrays import Array, at_sample
from freebody.errors import FreebodyError, LoopError, UnknownNameError
from freebody.kernels.formulas import Option
from freebody.kernels.structural import fetch
from freebody.loops.redundancy import (
    EXACT,
    counting_values,
    moves_exactly,
    redundancy,
    rounding_threshold,
    surely_exact,
)
from freebody.loops.scaled_equations import (
    AT_REST,
    BLURRED,
    Telling,
    backward,
    closed_from,
    every_jacobian,
    every_residual,
    length,
    loop_of_row,
    rate_scale,
    row_scale,
    scales,
    telling,
)
from freebody.model.geometry import first_member
from freebody.model.model import Model
from freebody.outputs.number_text import compared


def require_loops(model: Model, function: str) -> None:
    """Refuse a model without loops."""
    if not model.loops:
        raise FreebodyError(
            f"{function}: {model.name!r} has no loops; add one with model.with_loop(...)."
        )


def driven_coordinates(
    function: str, model: Model, actuated: Sequence[str] | None = None
) -> tuple[int, ...]:
    """The indices of the driven coordinates: those named in `actuated`, or the model's own."""
    return model.driven if actuated is None else tuple(free_coordinates(model, actuated, function))


def free_coordinates(model: Model, names: Sequence[str] | None, function: str) -> list[int]:
    """The indices of coordinates that may move: those named, each by itself or through its joint;
    all for None."""
    if names is None:
        return list(range(model.nv))
    if isinstance(names, str):
        names = (names,)
    of_joint = {
        body.joint.name: list(at.v)
        for body, at in zip(model.bodies, model.coordinates, strict=True)
        if body.joint.mimic is None
    }
    of_name = {name: [k] for k, name in enumerate(model.velocity_names)} | of_joint
    for name in names:
        if name not in of_name:
            raise UnknownNameError("coordinate", name, f"{function}: {model.name!r}", of_name)
    return sorted({k for name in names for k in of_name[name]})


def _projector(model: Model) -> Telling | None:
    """The function from Φ_q to the projector onto independent combinations of equations; None where
    all equations are independent."""
    known = redundancy(model)
    return None if known.rank is None else lambda A: telling(A, counting_values(known))


def counting(model: Model, q: Array, scaled: Array) -> Array:
    """The scaled equations (..., m), or derivatives of them, projected onto their independent
    combinations at q (..., nq)."""
    project = _projector(model)
    return (
        scaled
        if project is None
        else np.einsum("...ij,...j->...i", project(every_jacobian(model, q)), scaled)
    )


def blurred(model: Model, moving: bool = True) -> float:
    """The limit, relative to the largest, below which singular values of Φ_q count as zero where
    accelerations are sought. Rounding divided by their square would outweigh the motion near a
    singular position, whose branch then follows from Φ's third derivative; at rest, where that says
    nothing, only mere rounding counts as zero."""
    blur = redundancy(model).blur
    return max(BLURRED, blur ** (1.0 / 3.0)) if moving else max(AT_REST, 2.0 * blur**0.5)


def telling_much(model: Model, q: Array, qd: Array, scaled: Array) -> Array:
    """The scaled equations (..., m), redundant ones included; near a singular position, where an
    independent combination has a small singular value, only the combinations without such a
    value."""
    known = redundancy(model)
    if known.rank is None:
        return scaled
    U, s, _ = np.linalg.svd(every_jacobian(model, q), full_matrices=False)
    moving = np.asarray(qd.any(axis=-1))[..., None]
    clear = s > np.where(moving, blurred(model), blurred(model, moving=False)) * s[..., :1]
    kept = counting_values(known)(s)
    some = np.einsum("...ik,...jk,...j->...i", U * (kept & clear)[..., None, :], U, scaled)
    return np.where((kept & ~clear).any(axis=-1, keepdims=True), some, scaled)


def branches(
    model: Model, q: Array, among: NDArray[np.bool_]
) -> Iterator[tuple[Model, NDArray[np.bool_]]]:
    """Pairs (model, flags (...)) that together cover the positions q (..., nq) marked in `among`
    (...): the model with the independence of its loop equations settled at some of the positions,
    and flags of these.

    Which equations are redundant is known from the model's home. Where that does not hold, on
    another branch of the mechanism's motion, the position itself is taken for the home: so answers
    do not depend on the home that is given. Where nothing holds the model comes as it is.
    """
    if not among.any():
        return
    good = holds(model, q, among)
    if good.any():
        yield model, good
    left = among & ~good
    while left.any():
        first = tuple(np.argwhere(left)[0])
        there = homed_at(model, q[first])
        part = left & holds(there, q, left)
        if not part[first]:
            there, part = model, left
        yield there, part
        left = left & ~part


def taken_at(model: Model, q: Array) -> Model:
    """The model with the independence of its loop equations settled at positions q (..., nq), see
    `branches`; unchanged where the positions need different choices."""
    if not model.loops:
        return model
    parts = list(branches(model, q, np.ones(q.shape[:-1], dtype=bool)))
    return parts[0][0] if len(parts) == 1 else model


def homed_at(model: Model, q: Array) -> Model:
    """The model with the position q (nq,) as its home."""
    home = tuple(zip(model.position_names, map(float, q), strict=True))
    return dataclasses.replace(model, home=home)


def holds(model: Model, q: Array, among: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Flags (...) of the positions q (..., nq) where what is known about redundant equations holds:
    all independent ones are closed, and none is in doubt."""
    found = np.array(among, dtype=bool)
    if not rounding_threshold(model):
        return found
    some, known = q[among], redundancy(model)
    phi = np.abs(scaled_residual(model, some))
    good = np.asarray((phi <= max(CLOSED, known.slack)).all(axis=-1))
    good &= within_tolerance(model, some).all(axis=-1)
    one = first_member(model)
    if known.rank is None:
        doubt = good & ~surely_exact(model, some)
        good[doubt] = [moves_exactly(one, at) for at in some[doubt]]
    else:  # what moves with all loops closed to the last digit is not rounded there
        exact = good & (np.abs(every_residual(model, some)) <= EXACT).all(axis=-1)
        good[exact] = [not moves_exactly(one, at) for at in some[exact]]
    np.place(found, among, good)
    return found


def scaled_residual(model: Model, q: Array) -> Array:
    """Residuals Φ(q) (..., m) as angles, projected onto the independent equations."""
    return counting(model, q, every_residual(model, q))


def scaled_jacobian(model: Model, q: Array) -> Array:
    """The Jacobian Φ_q (..., m, nv) as angles over angular rates, projected onto the independent
    equations; rows of mere rounding are zero."""
    A = every_jacobian(model, q)
    project = _projector(model)
    return A if project is None else project(A) @ A


def scaled_rate(model: Model, q: Array, qd: Array) -> Array:
    """The rates Φ_q q̇ (..., m) as angles, projected onto the independent equations."""
    return counting(
        model,
        q,
        row_scale(model) * fetch(first_member(model), ("constraint_rate",), Option())(q, qd),
    )


def closing(model: Model, q: Array, moving: Sequence[int]) -> tuple[Array, Array]:
    """(positions (N, nq) closed as far as possible from q (N, nq), largest remaining scaled
    equation (N,))."""
    return closed_from(model, q, moving, _projector(model))


# ---------------------------------------------------------------- positions
def is_closed(model: Model, q: Array, left: Array) -> NDArray[np.bool_]:
    """Flags (N,) of the positions q (N, nq) at which every loop is closed, the right way round;
    left: remaining scaled equations (N,) after solving."""
    return (
        (left < EXACT) & within_tolerance(model, q).all(axis=-1) & ~backward(model, q).any(axis=-1)
    )


def within_tolerance(model: Model, q: Array) -> NDArray[np.bool_]:
    """Flags (..., m) of redundant equations that are violated by no more than rounding at q (...,
    nq)."""
    if redundancy(model).rank is None:
        return np.ones((*q.shape[:-1], len(row_scale(model))), dtype=bool)
    return np.abs(every_residual(model, q)) <= scales(model).tolerance


def gaps(model: Model, phi: Array) -> Array:
    """The gap of each loop (..., loops) in m, from scaled Φ (..., m); sines are multiplied by the
    mechanism's length."""
    size = phi * length(model)
    of_row = np.array(loop_of_row(model))
    parts = [np.linalg.norm(size[..., of_row == i], axis=-1) for i in range(len(model.loops))]
    return np.stack(parts, axis=-1)


def require_closed(
    function: str,
    model: Model,
    q: Array,
    qd: Array | None = None,
    among: NDArray[np.bool_] | None = None,
) -> None:
    """Refuse positions whose loops are open, and rates that would open them; of a batch those
    marked in `among` (...), None is all."""
    among = np.ones(q.shape[:-1], dtype=bool) if among is None else among
    marked = among[..., None]
    reach, least = length(model), max(CLOSED, redundancy(model).slack)
    gap = gaps(model, scaled_residual(model, q))
    for at, name, sample in _marked(model, marked & (gap > least * reach)):
        raise LoopError(
            f"{function}: loop {name!r} of {model.name!r} is open by {gap[at]:.3g} m{sample}; "
            "close it with fb.assemble(model, q)."
        )
    require_within_tolerance(function, model, q, among)
    for _, name, sample in _marked(model, marked & backward(model, q)):
        raise LoopError(
            f"{function}: loop {name!r} of {model.name!r} is closed the wrong way round{sample}: "
            f"its frames face "
            "opposite ways; start fb.assemble from another guess, or turn one frame."
        )
    if qd is not None:
        rate = gaps(model, scaled_rate(model, q, qd))
        speed = reach * (1.0 + np.abs(qd / rate_scale(model)).max(axis=-1, initial=0.0))
        for at, name, sample in _marked(model, marked & (rate > least * speed[..., None])):
            raise LoopError(
                f"{function}: loop {name!r} of {model.name!r} would open at {rate[at]:.3g} "
                f"m/s{sample}; make the rates consistent with fb.loop_velocity(model, q, qd)."
            )


def require_within_tolerance(
    function: str, model: Model, q: Array, among: NDArray[np.bool_]
) -> None:
    """Refuse those positions at which redundant equations are open by more than rounding."""
    bad = np.argwhere(among[..., None] & ~within_tolerance(model, q))
    if len(bad):
        at, row = tuple(map(int, bad[0][:-1])), int(bad[0][-1])
        gap = abs(float(every_residual(model, q)[(*at, row)]))
        sizes = (gap, float(scales(model).tolerance[row]))
        open_by, allowed = in_units(model, row, *sizes)
        raise LoopError(
            f"{function}: loop {model.loops[loop_of_row(model)[row]].name!r} of {model.name!r} is "
            f"open by {open_by}{at_sample(at)}, more than its loop_tolerance of {allowed}: there "
            f"its redundant equations contradict each other. Correct the numbers, or state how far "
            f"they are rounded: loop_tolerance=(metres, radians)."
        )


def in_units(model: Model, row: int, *scaled: float) -> tuple[str, ...]:
    """Values of a scaled equation with their unit (m or rad), as text for a message that compares
    them."""
    factor, unit = (length(model), "m") if scales(model).metres[row] else (1.0, "rad")
    return tuple(f"{x} {unit}" for x in compared(*(factor * x for x in scaled), digits=3))


def _marked(model: Model, bad: NDArray[np.bool_]) -> Iterator[tuple[tuple[int, ...], str, str]]:
    """Pairs of index and names (index, loop, text of the sample) for each loop that is marked in
    (..., loops)."""
    for index in np.argwhere(bad):
        at = tuple(map(int, index))
        yield at, model.loops[at[-1]].name, at_sample(at[:-1])


def refuse_inconsistent(function: str, model: Model, left: Array, what: str) -> NoReturn:
    """Raise an error for scaled equations (m,) that contradict each other, naming the loop with the
    largest misfit."""
    worst = int(np.argmax(np.abs(left)))
    name = model.loops[loop_of_row(model)[worst]].name
    raise LoopError(f"{function}: loop {name!r} of {model.name!r} {what}.")


def require_consistent(
    function: str,
    model: Model,
    q: Array,
    qd: Array,
    qdd: Array,
    problem: str,
    among: NDArray[np.bool_],
) -> None:
    """Refuse accelerations that would open a loop at the samples marked (...); problem: the
    message, with a place for the sample."""
    bad = np.argwhere(among & (_left(model, q, qd, qdd) > max(LEFT, redundancy(model).slack)))
    if len(bad):
        at = tuple(map(int, bad[0]))
        q, qd, qdd = (x[at] for x in (q, qd, qdd))
        refuse_inconsistent(
            function, model, _missed(model, q, qd, qdd)[0], problem.format(at_sample(at))
        )


def _left(model: Model, q: Array, qd: Array, qdd: Array) -> Array:
    """The largest scaled equation (...) that accelerations leave unsatisfied, relative to the size
    of its terms."""
    left, c = _missed(model, q, qd, qdd)
    size = 1.0 + np.abs(qdd / rate_scale(model)).max(axis=-1, initial=0.0) + np.abs(c).max(axis=-1)
    return np.abs(left).max(axis=-1) / size


def _missed(model: Model, q: Array, qd: Array, qdd: Array) -> tuple[Array, Array]:
    """The residuals Φ_q q̈ - c and the terms c (..., m), scaled and without combinations that say
    nothing here."""
    phi, c = fetch(first_member(model), ("constraint_jacobian", "constraint_bias"), Option())(q, qd)
    rows = row_scale(model)
    left = rows * (np.einsum("...mk,...k->...m", phi, qdd) - c)
    return telling_much(model, q, qd, left), rows * c
