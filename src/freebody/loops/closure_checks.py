"""The loop equations of a model as they count, scaled; how far they are from holding, and what is
said of it.

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
from freebody.algorithms.singular_thresholds import AT_REST, BLURRED
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
from freebody.model.kept_facts import first_member
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
    """Indices of the driven coordinates: of those named, or the model's own."""
    return model.driven if actuated is None else tuple(free_coordinates(model, actuated, function))


def free_coordinates(model: Model, names: Sequence[str] | None, function: str) -> list[int]:
    """Indices of the coordinates named, each by itself or through its joint; None is all."""
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
    """Φ_q -> P, the combinations that count; None where every equation does."""
    known = redundancy(model)
    return None if known.rank is None else lambda A: telling(A, counting_values(known))


def counting(model: Model, q: Array, scaled: Array) -> Array:
    """Combinations that count (..., m) of scaled equations (..., m), or of derivatives of them, at
    q (..., nq)."""
    project = _projector(model)
    return (
        scaled
        if project is None
        else np.einsum("...ij,...j->...i", project(every_jacobian(model, q)), scaled)
    )


def blurred(model: Model, moving: bool = True) -> float:
    """Singular values of Φ_q, relative to the largest, that count as zero where accelerations are
    sought: rounding of size ε is divided by their square, and near a singular position they say as
    much about it as about the motion, whose branch is then told by Φ's third derivative. At rest
    that tells nothing, and those alone count as zero of which rounding leaves nothing."""
    blur = redundancy(model).blur
    return max(BLURRED, blur ** (1.0 / 3.0)) if moving else max(AT_REST, 2.0 * blur**0.5)


def telling_much(model: Model, q: Array, qd: Array, scaled: Array) -> Array:
    """All of scaled equations (..., m), redundant ones too; where a combination that counts has a
    singular value that is blurred, which is near a singular position, those alone that have not."""
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
    """(the model with its loops taken as they count at some of the positions q (..., nq), which of
    them (...)), until each of those marked in `among` (...) has come.

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
    """The model with its loops taken as they count at the positions q (..., nq), see `branches`;
    as it is, where they are on branches that differ in it."""
    if not model.loops:
        return model
    parts = list(branches(model, q, np.ones(q.shape[:-1], dtype=bool)))
    return parts[0][0] if len(parts) == 1 else model


def homed_at(model: Model, q: Array) -> Model:
    """The model with the position q (nq,) for its home."""
    home = tuple(zip(model.position_names, map(float, q), strict=True))
    return dataclasses.replace(model, home=home)


def holds(model: Model, q: Array, among: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """(...): whether what is known of the model's equations holds at those of the positions q
    (..., nq): all that counts is closed, and nothing of it in doubt."""
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
    """Φ(q) (..., m) in angles, as far as it counts."""
    return counting(model, q, every_residual(model, q))


def scaled_jacobian(model: Model, q: Array) -> Array:
    """Φ_q (..., m, nv) over angular rates, in angles, as far as it counts; rows of nothing but
    rounding are zero."""
    A = every_jacobian(model, q)
    project = _projector(model)
    return A if project is None else project(A) @ A


def scaled_rate(model: Model, q: Array, qd: Array) -> Array:
    """Φ_q q̇ (..., m) in angles, as far as it counts."""
    return counting(
        model,
        q,
        row_scale(model) * fetch(first_member(model), ("constraint_rate",), Option())(q, qd),
    )


def closing(model: Model, q: Array, moving: Sequence[int]) -> tuple[Array, Array]:
    """(positions (N, nq) as closed as they get from q (N, nq), largest scaled equation left
    (N,))."""
    return closed_from(model, q, moving, _projector(model))


# ---------------------------------------------------------------- positions
def is_closed(model: Model, q: Array, left: Array) -> NDArray[np.bool_]:
    """(N,): whether every loop is closed at positions q (N, nq), the right way round, where solving
    has left so much (N,) of the scaled equations."""
    return (
        (left < EXACT) & within_tolerance(model, q).all(axis=-1) & ~backward(model, q).any(axis=-1)
    )


def within_tolerance(model: Model, q: Array) -> NDArray[np.bool_]:
    """(..., m): whether an equation that does not count by itself is open by no more than rounding
    at q (..., nq)."""
    if redundancy(model).rank is None:
        return np.ones((*q.shape[:-1], len(row_scale(model))), dtype=bool)
    return np.abs(every_residual(model, q)) <= scales(model).tolerance


def gaps(model: Model, phi: Array) -> Array:
    """The distance by which each loop is open (..., loops), from scaled Φ (..., m): metres and
    sines together, the latter times the length."""
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
    """Values of a scaled equation with its unit, in a message that compares them."""
    factor, unit = (length(model), "m") if scales(model).metres[row] else (1.0, "rad")
    return tuple(f"{x} {unit}" for x in compared(*(factor * x for x in scaled), digits=3))


def _marked(model: Model, bad: NDArray[np.bool_]) -> Iterator[tuple[tuple[int, ...], str, str]]:
    """(index, loop, text of the sample) of all (..., loops) that are marked."""
    for index in np.argwhere(bad):
        at = tuple(map(int, index))
        yield at, model.loops[at[-1]].name, at_sample(at[:-1])


def refuse_inconsistent(function: str, model: Model, left: Array, what: str) -> NoReturn:
    """Raise for scaled equations (m,) that cannot hold together, naming the loop that misses
    most."""
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
    """Refuse accelerations at the samples marked (...) that would open a loop, with a problem that
    has a place for the sample."""
    bad = np.argwhere(among & (_left(model, q, qd, qdd) > max(LEFT, redundancy(model).slack)))
    if len(bad):
        at = tuple(map(int, bad[0]))
        q, qd, qdd = (x[at] for x in (q, qd, qdd))
        refuse_inconsistent(
            function, model, _missed(model, q, qd, qdd)[0], problem.format(at_sample(at))
        )


def _left(model: Model, q: Array, qd: Array, qdd: Array) -> Array:
    """(...): the largest equation, scaled to angles, that accelerations leave unsatisfied, relative
    to its terms."""
    left, c = _missed(model, q, qd, qdd)
    size = 1.0 + np.abs(qdd / rate_scale(model)).max(axis=-1, initial=0.0) + np.abs(c).max(axis=-1)
    return np.abs(left).max(axis=-1) / size


def _missed(model: Model, q: Array, qd: Array, qdd: Array) -> tuple[Array, Array]:
    """(Φ_q q̈ - c, c) (..., m), scaled, as far as they tell."""
    phi, c = fetch(first_member(model), ("constraint_jacobian", "constraint_bias"), Option())(q, qd)
    rows = row_scale(model)
    left = rows * (np.einsum("...mk,...k->...m", phi, qdd) - c)
    return telling_much(model, q, qd, left), rows * c
