"""How heavy the payloads of duty cycles may be for drives that have been chosen: all limits of
motors, gears and brakes count, so it is asked of the loads themselves at each weight."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from freebody.by_value import ByValue
from freebody.design.drive_loads import ChosenDrives, demand_of
from freebody.design.duty_cycle import CarriedLoad, DutyCycle, Segment
from freebody.design.loads import DriveJoint, cycle_loads, rest_loads
from freebody.design.pairs import LIMITS, PairTable, uses
from freebody.errors import FreebodyError, listed
from freebody.model.inertia import Inertia
from freebody.model.model import Model
from freebody.outputs.display import Tabled, TextTable
from freebody.outputs.number_text import rounded_down

_GROWTH = 1.2
"""Ratio of each weight that is looked at to the one before."""
_MOST, _HEAVIEST = 1000.0, 1e5
"""Times as heavy, and kg: drives that bear both have no limit worth telling."""
_FINE = 1e-4
"""Share of the payloads to which the limit is found."""


@dataclass(frozen=True, eq=False, repr=False)
class HeaviestPayloads(Tabled, ByValue):
    """How many times as heavy all payloads of duty cycles may be, at the same places and of the
    same shapes, until the chosen drives have no more than the margin that was asked for."""

    factor: float
    """Times as heavy as the cycles have them; infinite where drives bear a thousand times as much,
    and 100 t."""
    masses: tuple[float, ...]
    """The payloads of the segments that carry one, so heavy, kg."""
    margin: float
    """The margin that every limit then keeps at least."""
    joint: str
    """The joint of which a limit is reached first; "" where none is."""
    limit: str
    """The limit that is reached first; "" where none is."""

    def _title(self) -> str:
        if np.isinf(self.factor):
            return f"No limit is reached by payloads of up to {_HEAVIEST / 1e3:g} t"
        loads = listed(f"{rounded_down(m)} kg" for m in dict.fromkeys(self.masses))
        kept = "" if self.margin == 1.0 else f", with a margin of {self.margin:g}"
        return (
            f"Payloads up to {rounded_down(self.factor)} times as heavy, {loads}{kept}: "
            f"{self.limit} of {self.joint} ends it"
        )

    def _table(self) -> TextTable:
        rows = [(f"{rounded_down(m)} kg",) for m in self.masses]
        return TextTable(("payload",), rows)


def heaviest_payloads(
    model: Model,
    cycles: Sequence[DutyCycle],
    joints: Sequence[DriveJoint],
    drives: ChosenDrives,
    *,
    life: float,
    hold: bool,
    margin: float,
) -> HeaviestPayloads:
    """The heaviest payloads that given drives, which suffice for the cycles, bear: the first of
    weights that grow by a fifth which is too much, and the last before it that is not."""
    masses = [
        _mass(segment.payload)
        for cycle in cycles
        for segment in cycle.segments
        if segment.payload is not None
    ]
    if not any(masses):
        raise FreebodyError(
            "size: no segment of the cycles carries a payload that could be heavier; give one."
        )
    fitted = np.array([float(sum(part.mass for part in drives[x.name])) for x in joints])
    tables = [PairTable([drives[x.name][0]], [drives[x.name][1]]) for x in joints]

    def shares(factor: float) -> np.ndarray:
        """The share (limits, n) that is used of each limit."""
        heavier = [_scaled(cycle, factor) for cycle in cycles]
        loads = cycle_loads(model, heavier, joints)
        rest = rest_loads(model, heavier, joints) if hold else None
        found = [
            uses(demand_of(loads, k, fitted, life, rest), table)[:, 0, 0]
            for k, table in enumerate(tables)
        ]
        return np.stack(found, axis=-1)

    most = max(_MOST, _HEAVIEST / max(masses))
    within, beyond = _between(lambda factor: float(shares(factor).max()) * margin <= 1.0, most)
    if np.isinf(beyond):
        return HeaviestPayloads(np.inf, (), margin, "", "")
    limit, k = divmod(int(shares(beyond).argmax()), len(joints))
    heavy = tuple(within * m for m in masses if m > 0.0)
    return HeaviestPayloads(within, heavy, margin, joints[k].name, LIMITS[limit].name)


def _between(good: Callable[[float], bool], most: float) -> tuple[float, float]:
    """A factor of at least 1 that is good, and one a little larger that is not; infinite where all
    up to `most` are good."""
    within, beyond = 1.0, _GROWTH
    while good(beyond):
        within, beyond = beyond, beyond * _GROWTH
        if beyond > most:
            return within, np.inf
    while beyond - within > _FINE * within:
        middle = 0.5 * (within + beyond)
        within, beyond = (middle, beyond) if good(middle) else (within, middle)
    return within, beyond


def _scaled(cycle: DutyCycle, factor: float) -> DutyCycle:
    """The cycle with payloads so many times as heavy."""
    return replace(cycle, segments=tuple(_heavier(x, factor) for x in cycle.segments))


def _heavier(segment: Segment, factor: float) -> Segment:
    given: Any = segment.payload
    if given is None:
        return segment
    if isinstance(given, Inertia):
        own: Any = given
        mass, tensor = own.mass * factor, tuple(x * factor for x in own.tensor)
        return replace(segment, payload=replace(given, mass=mass, tensor=tensor))
    if not isinstance(given, Mapping):
        return replace(segment, payload=given * factor)
    if isinstance(given.get("mass"), Inertia):
        whole = _heavier(replace(segment, payload=given["mass"]), factor).payload
        return replace(segment, payload={**given, "mass": whole})
    heavier = {x: np.asarray(given[x]) * factor for x in ("mass", "inertia") if x in given}
    return replace(segment, payload={**given, **heavier})


def _mass(payload: CarriedLoad) -> float:
    """The mass of what a segment carries, kg."""
    given: Any = payload.get("mass", 0.0) if isinstance(payload, Mapping) else payload
    mass: Any = given.numbers()[0] if isinstance(given, Inertia) else given
    return float(mass)
