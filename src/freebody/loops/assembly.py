"""Closing the loops: positions, rates and accelerations that satisfy every loop equation."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from freebody.algorithms.loop_checks import CLOSED
from freebody.arrays import Array, at_sample
from freebody.errors import FreebodyError, LoopError
from freebody.loops.dyad_decomposition import decomposed
from freebody.loops.equations import (
    closing,
    free_coordinates,
    gaps,
    holds,
    homed_at,
    is_closed,
    require_loops,
    scaled_jacobian,
)
from freebody.loops.scaled_equations import (
    backward,
    every_residual,
    length,
    rate_scale,
    scales,
    shortest_way,
)
from freebody.model.model import Model
from freebody.trees.public_calls import JointVector, finite_vector
from freebody.trees.states import home_guess, integrate

_STARTS = 200  # of `assembly_modes`
_RESTARTS = 32
_NEARLY = 0.02  # gap, relative to the length, that rounded numbers may be the reason of


def assemble(
    model: Model, q: JointVector | None = None, free: Sequence[str] | None = None
) -> Array:
    """The position near a guess at which every loop is closed, to rounding.

    Levenberg-Marquardt on Φ (5.21). Where the search from the guess ends with a gap, other starts
    are tried and the nearest closed position is taken.

    Parameters
    ----------
    model : Model
        A closed chain.
    q : (..., nq), optional
        Guess, rad and m; default the model's home. Given by name, it may leave out coordinates that
        may move: those start from the home.
    free : names, optional
        Coordinates (`model.velocity_names`) or joints that may move; the others keep the values
        given. None: all may.

    Returns
    -------
    (..., nq)

    Raises
    ------
    LoopError
        No closed position was found: the loop and its gap.
    """
    require_loops(model, "assemble")
    moving = free_coordinates(model, free, "assemble")
    guess = finite_vector("assemble", model, "q", _completed(model, q, moving))
    flat = guess.reshape(-1, model.nq)
    closed, left = closing(model, flat, moving)
    good = is_closed(model, closed, left)
    for k in np.flatnonzero(~holds(model, closed, good)):
        rounded = _as_rounded(model, flat[k], moving, closed[k])
        if rounded is not None:
            closed[k] = rounded
        elif not good[k]:
            closed[k] = _restarted(
                model, flat[k], moving, closed[k], at_sample((int(k),) if guess.ndim > 1 else ())
            )
    return closed.reshape(guess.shape)


def _as_rounded(model: Model, guess: Array, moving: Sequence[int], best: Array) -> Array | None:
    """The closed position near the guess of the mechanism that the model's rounded numbers stand
    for; None where the gaps at the best position found exceed rounding, or no equation is
    redundant."""
    if (np.abs(every_residual(model, best)) > scales(model).tolerance).any():
        return None
    there = homed_at(model, best)
    closed, left = closing(there, guess[None], moving)
    good = holds(there, closed, is_closed(there, closed, left))
    return closed[0] if good[0] else None


def _completed(model: Model, q: JointVector | None, moving: Sequence[int]) -> JointVector:
    """The guess for closing the loops, with home values for movable coordinates that it does not
    name."""
    home = home_guess(model)
    if q is None:
        return home
    if not isinstance(q, Mapping) or hasattr(q, "to_dataarray"):  # a Dataset has every entry
        return q
    may: dict[str, float] = {}
    for at in model.coordinates:
        one_to_one = len(at.q) == len(at.v)  # else with a quaternion, which moves as a whole
        for k, own in zip(at.q, at.v if one_to_one else at.q, strict=True):
            if not set(moving).isdisjoint((own,) if one_to_one else at.v):
                may[model.position_names[k]] = float(home[k])
    return {**may, **q}


def assembly_modes(
    model: Model, q: JointVector, free: Sequence[str] | None = None, starts: int | None = None
) -> Array:
    """All closed positions that were found with the fixed coordinates of a position, nearest first.

    Planar mechanisms that come apart into dyads (two unknown joints per loop) are solved in closed
    form, and these are all. Others by Newton's method from starts spread over the free coordinates'
    whole range, so completeness is likely, not proved.

    Parameters
    ----------
    model : Model
        A closed chain.
    q : (nq,)
        The fixed coordinates, and where to look first; rad and m.
    free : names, optional
        As for `assemble`; the coordinates that differ from mode to mode.
    starts : int, optional
        Of the numeric search, default 200; refused where a closed form answers.

    Returns
    -------
    (k, nq)

    Raises
    ------
    FreebodyError
        The mechanism can move with the fixed coordinates locked: there are infinitely many.
    """
    require_loops(model, "assembly_modes")
    guess = finite_vector("assembly_modes", model, "q", q)
    if guess.shape != (model.nq,):
        raise FreebodyError(
            f"assembly_modes: q has shape {guess.shape}, expected ({model.nq},): one position."
        )
    if starts is not None and starts < 1:
        raise FreebodyError(f"assembly_modes: starts is {starts}, expected at least 1.")
    moving = free_coordinates(model, free, "assembly_modes")
    found = _by_dyads(model, guess, moving)
    in_closed_form = found is not None
    if found is None:
        found = _solutions(model, guess, moving, _STARTS if starts is None else starts)
    elif starts is not None:
        raise FreebodyError(
            f"assembly_modes: starts= is of the numeric search; {model.name!r} with these "
            f"coordinates free is solved in closed form, which finds all modes. Leave it out."
        )
    modes: list[Array] = []
    for position in found:
        if all(np.abs(shortest_way(model, position, other)).max() > 1e-6 for other in modes):
            modes.append(position)
    if modes and not in_closed_form:
        J = scaled_jacobian(model, modes[0])[:, moving]
        if np.linalg.matrix_rank(J, tol=1e-9) < len(moving):
            raise FreebodyError(
                f"assembly_modes: {model.name!r} still moves with the other coordinates held, so "
                f"it has infinitely many positions; free fewer coordinates."
            )
    return np.array(modes).reshape(-1, model.nq)


def _restarted(
    model: Model, guess: Array, moving: Sequence[int], best: Array, sample: str
) -> Array:
    """The closed position nearest to the guess among those reached from random starts around it."""
    found = _solutions(model, guess, moving, _RESTARTS)
    if len(found):
        return found[0]
    gap = gaps(model, every_residual(model, best))
    worst = int(np.argmax(gap))
    name = model.loops[worst].name
    if gap[worst] < CLOSED * length(model) and backward(model, best).any():
        raise LoopError(
            f"assemble: loop {name!r} of {model.name!r} closes only the wrong way round{sample}: "
            f"its frames face opposite ways. Start from another guess, or turn one frame."
        )
    if gap[worst] < _NEARLY * length(model):
        raise LoopError(
            f"assemble: loop {name!r} of {model.name!r} stays open by {gap[worst]:.3g} m{sample}, "
            f"at the nearest position found. Start from another guess, check lengths and frames, "
            f"or, where redundant equations contradict each other because numbers are rounded, "
            f"state by how much: loop_tolerance=(metres, radians)."
        )
    fixed = [name for k, name in enumerate(model.velocity_names) if k not in moving]
    remedy = f"let one of {', '.join(fixed)} move too" if fixed else "check lengths and frames"
    raise LoopError(
        f"assemble: loop {name!r} of {model.name!r} stays open by {gap[worst]:.3g} m{sample}, at "
        f"the nearest position found; its links may be too short or too long to meet. Start from "
        f"another guess, or {remedy}."
    )


def _by_dyads(model: Model, guess: Array, moving: Sequence[int]) -> Array | None:
    """Closed positions (k, nq) in closed form, the nearest first; None where the mechanism is no
    sequence of dyads."""
    plan = decomposed(model, moving) if model.nq == model.nv else None
    if plan is None:
        return None
    found, anywhere = plan.solve(guess[None])
    if anywhere.any():
        return None
    closed, left = closing(model, found[0][np.isfinite(found[0]).all(axis=-1)], moving)
    good = closed[is_closed(model, closed, left)]
    way = shortest_way(model, np.broadcast_to(guess, good.shape), good)
    return (guess + way * rate_scale(model))[np.argsort(np.linalg.norm(way, axis=-1))]


def _solutions(model: Model, guess: Array, moving: Sequence[int], starts: int) -> Array:
    """Closed positions (k, nq) reached from starts spread about the guess, the nearest first."""
    rng = np.random.default_rng(1)
    near = np.concatenate([np.geomspace(0.02, 1.0, starts // 2), np.ones(starts - starts // 2)])
    spread = rng.uniform(-np.pi, np.pi, size=(starts, model.nv)) * near[:, None]
    spread[0] = 0.0
    held = np.setdiff1d(np.arange(model.nv), moving)
    spread[:, held] = 0.0
    begun = integrate(model, np.broadcast_to(guess, (starts, model.nq)), spread * rate_scale(model))
    closed, left = closing(model, begun, moving)
    good = closed[is_closed(model, closed, left)]
    distance = np.linalg.norm(
        shortest_way(model, np.broadcast_to(guess, good.shape), good), axis=-1
    )
    return good[np.argsort(distance)]
