"""The logs that a function of identification is given: read, checked against the model, and their
torques without what the model knows."""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from freebody.any_chain.dynamics import inverse_dynamics
from freebody.arrays import Array
from freebody.errors import FreebodyError, KindError
from freebody.identification.filters import RATES
from freebody.identification.logs.log import Log
from freebody.identification.logs.read_log import read_log
from freebody.model.model import Model

Logs = Log | str | os.PathLike[str] | Sequence[Log | str | os.PathLike[str]]
"""Logs of `fb.read_log`, or their files, one or several."""


def read_logs(function: str, argument: str, given: Logs, model: Model) -> list[Log]:
    """The logs of an argument, those that are files read."""
    alone = isinstance(given, Log | str | os.PathLike)
    if not alone and not isinstance(given, Iterable):
        raise KindError(function, argument, given, "logs of fb.read_log, or their files")
    several = [given] if alone else list(given)
    for x in several:
        if not isinstance(x, Log | str | os.PathLike):
            raise KindError(function, argument, x, "a log of fb.read_log, or its file")
    return [x if isinstance(x, Log) else read_log(x, model) for x in several]


def require_suited(function: str, log: Log, joints: Sequence[str]) -> None:
    """Raises FreebodyError for a log of other joints than these, or of too few samples a second to
    have the rates from which columns are built."""
    if tuple(log.names) != tuple(joints):
        raise FreebodyError(
            f"{function}: the log {log.source!r} is of joints {', '.join(log.names)}, expected "
            f"those of the model in its order: {', '.join(joints)}. Read it with the model: "
            f"fb.read_log(path, model)."
        )
    if not log.rate > 2.0 * RATES:
        raise FreebodyError(
            f"{function}: the log {log.source!r} has {log.rate:.4g} samples a second; rates and "
            f"accelerations up to {RATES:g} Hz are taken from logs, so more than {2.0 * RATES:g} "
            f"are needed: log at 100 Hz or more."
        )


def has_springs(model: Model) -> bool:
    """Whether some joint of the model has a spring."""
    bare = model.without("friction", "rotors")
    return bare != bare.without("springs")


def torques_of(model: Model, log: Log) -> Array | None:
    """A log's torques (n, joints) without those of the model's springs, or None."""
    if log.torque is None or not has_springs(model):
        return log.torque
    bare = model.without("friction", "rotors")
    rest = np.zeros_like(log.position)
    sprung = inverse_dynamics(bare, log.position, rest, rest)
    return log.torque - (
        sprung - inverse_dynamics(bare.without("springs"), log.position, rest, rest)
    )


def with_torques(function: str, log: Log, gains: Array | None) -> Log:
    """The log with torques, those of its currents times the gains (n,), N m/A, where it has no
    others. Raises FreebodyError where neither tells torques."""
    if log.torque is not None:
        return log
    if log.current is None or gains is None:
        raise FreebodyError(
            f"{function}: the log {log.source!r} has currents alone; give gains=, N m (N) of the "
            f"joint per A, such as those of fb.identify, or torque constants in the TOML file "
            f"beside it."
        )
    return replace(log, torque=log.current * gains)
