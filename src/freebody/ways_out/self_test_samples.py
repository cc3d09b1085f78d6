"""Samples to test exported text with: random inputs, and their results in arithmetic of more
digits."""

from __future__ import annotations

import contextlib

import numpy as np

from freebody.arrays import Array
from freebody.errors import FreebodyError, LoopError
from freebody.kernels.formulas import FORMULAS, INPUTS, POSITIONS, Option
from freebody.kernels.formulas.inverse import known_branches
from freebody.model.model import Model
from freebody.program import Program
from freebody.program.passes import with_epsilon
from freebody.targets.interpreter import Interpreter
from freebody.targets.text import SelfTestSamples

COUNT = 5
"""The number of samples."""
_TRIES = 40
_OFF = 0.3
"""How far from the closed position towards a random one."""
_FLOOR = {"float64": 1e-13, "float32": 1e-5}
_MARGIN = 16.0
"""Another order of operations, or another sine, may cost more than was seen."""


def vectors(
    program: Program,
    dtype: str,
    model: Model | None = None,
    numbers: Array | None = None,
    option: Option | None = None,
) -> SelfTestSamples:
    """Inputs at which all outputs are finite, what they give in extended precision, and how far off
    the text may be: sixteen times what NumPy in `dtype` is off here, at least 1e-13 (float32:
    1e-5).

    numbers: (k,) the model's own values of p, which is tried within a tenth of them. option: what
    was chosen of the model, such as the frame that is to reach its target.
    Raises FreebodyError where none are found.
    """
    rng = np.random.default_rng(0)
    given = [
        _near(numbers, rng)
        if numbers is not None and a.name == "p"
        else _samples(a.name, a.shape, model, rng)
        for a in program.inputs
    ]
    if model is not None and model.loops:
        given = _closed(model, [a.name for a in program.inputs], given)
    if model is not None and option is not None and program.inputs[0].name == "target":
        given = _reached(model, option, given, rng)
    given = [x.astype(dtype).astype(np.float64) for x in given]
    epsilon = float(np.finfo(dtype).eps)  # the same samples are valid, but for rounding
    exact = _run(with_epsilon(program, epsilon), given, np.longdouble)
    fine = np.logical_and.reduce([np.isfinite(x).all(axis=1) for x in exact])
    if not fine.any():
        raise FreebodyError(
            f"{program.name}: outputs are infinite or NaN at all of {_TRIES} random inputs; there "
            f"is nothing to test "
            "an export with. Is the robot singular everywhere (a joint that moves no mass)?"
        )
    chosen = np.flatnonzero(fine)[:COUNT]
    rounded = _run(program, given, np.dtype(dtype).type)
    tolerances = []
    for values, with_rounding in zip(exact, rounded, strict=True):
        largest = float(np.abs(values[chosen]).max(initial=0.0)) or 1.0
        off = float(np.abs(with_rounding[chosen] - values[chosen]).max(initial=0.0)) / largest
        tolerances.append(max(_FLOOR[dtype], _MARGIN * off))
    return SelfTestSamples(
        tuple(x[chosen] for x in given),
        tuple(x[chosen].astype(np.float64) for x in exact),
        tuple(float(f"{tolerance:.1e}") for tolerance in tolerances),
    )


def _samples(
    name: str, shape: tuple[int, ...], model: Model | None, rng: np.random.Generator
) -> Array:
    """(tries, size): positions about home, anything else of size 1."""
    size = int(np.prod(shape))
    values = rng.uniform(-1.0, 1.0, size=(_TRIES, size))
    size = INPUTS[name].positive if model is not None and name in INPUTS else None
    if size is not None:
        return np.abs(values) * size
    if model is None or name not in POSITIONS:
        return values
    home = dict(model.home)
    for k, position in enumerate(model.position_names):
        if model.loops:  # a state that is nearly closed
            values[:, k] *= 0.1
        values[:, k] += home.get(position, 0.0)
    return _unit_quaternions(model, values)


def _reached(
    model: Model, option: Option, given: list[Array], rng: np.random.Generator
) -> list[Array]:
    """Targets (tries, pose) that positions all round reach, and where the joint that is held stands
    there."""
    q = np.pi * _samples("q", (model.nq,), None, rng)
    (T,) = FORMULAS["forward_kinematics"].evaluate(
        model.tree, option, q=tuple(_unit_quaternions(model, q).T)
    )
    poses = np.stack([np.broadcast_to(x, (_TRIES,)) for row in T for x in row], axis=-1)
    held = known_branches(model.tree, option).held
    return [poses, *([] if held is None else [q[:, [held]]]), *given[1 if held is None else 2 :]]


def _unit_quaternions(model: Model, positions: Array) -> Array:
    """Positions (tries, nq) whose quaternions have length one."""
    for body, at in zip(model.bodies, model.coordinates, strict=True):
        start = body.kind.quaternion
        if start is not None:
            quaternion = positions[:, at.q[start:]]
            positions[:, at.q[start:]] = quaternion / np.linalg.norm(
                quaternion, axis=1, keepdims=True
            )
    return positions


def _near(own: Array, rng: np.random.Generator) -> Array:
    """(tries, k): the numbers themselves and others near; of what has no value near 1, of zeros
    near 0."""
    known = np.where(np.isnan(own), 1.0, own)
    return known + rng.uniform(-0.1, 0.1, size=(_TRIES, own.size)) * np.where(
        known == 0.0, 0.1, known
    )


def _closed(model: Model, names: list[str], given: list[Array]) -> list[Array]:
    """Positions at which the loops are closed, and rates that keep them so; as given where there
    are none near.

    Every second is a little off: where all loops are closed their equations are rounding, and say
    nothing.
    """
    from freebody.loops.rates import loop_velocity

    found = dict(zip(names, given, strict=True))
    with contextlib.suppress(LoopError):
        closed_at = {x: _assembled(model, found[x]) for x in POSITIONS if x in found}
        if "q" in closed_at and "qd" in found:
            found["qd"] = loop_velocity(model, closed_at["q"], found["qd"])
        for name, positions in closed_at.items():
            positions[1::2] += _OFF * (found[name] - positions)[1::2]
            found[name] = _unit_quaternions(model, positions)
    return list(found.values())


def _assembled(model: Model, near: Array) -> Array:
    """Closed positions near these (tries, nq); where one closes nowhere, another takes its place.
    Raises LoopError where none closes."""
    from freebody.loops.assembly import assemble

    try:
        return assemble(model, near)
    except LoopError as none:
        closed = []
        for position in near:
            with contextlib.suppress(LoopError):
                closed.append(assemble(model, position))
        if not closed:
            raise none
        return np.resize(closed, near.shape)


def _run(program: Program, given: list[Array], kind: type) -> list[np.ndarray]:
    """Outputs (tries, size) in arithmetic of a type."""
    rows = [column for x in given for column in x.astype(kind).T]
    with np.errstate(all="ignore"):
        scalars = Interpreter.of(program)(rows)
    done = [np.broadcast_to(np.asarray(x, kind), (_TRIES,)) for x in scalars]
    results, start = [], 0
    for argument in program.outputs:
        part = done[start : start + argument.size]
        start += argument.size
        results.append(np.stack(part, axis=1) if part else np.zeros((_TRIES, 0), kind))
    return results
