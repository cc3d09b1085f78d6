"""The columns of a regression as one kernel: torques as a linear function of those combinations of
masses and inertias that a motion can tell, and of the friction of each joint."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from freebody.arrays import Array
from freebody.errors import FreebodyError, PassiveJointError, UnknownNameError
from freebody.kernels.own_functions import compile as compiled
from freebody.model.drives import LAWS, DriveLaw, assumed_by
from freebody.model.inertial_parameters import body_parameters
from freebody.model.model import Model
from freebody.spatial import of_dimension
from freebody.trees.base_parameters import base_parameters
from freebody.trees.positions import generic_state
from freebody.ways_out.kernel import formula

WIDTHS = (0.01, 0.003, 0.001)
"""Rates (rad/s, m/s) within which the sign of a rate may go from -1 to 1, as tanh(rate / width),
the usual one first: real joints creep before they slip, and a measured rate has no sign that could
be trusted below its noise, where simulated ones turn at once. Half of the first cost 1.1 % of a
real robot's torque."""
USUAL_LAWS = assumed_by("identify")
"""Friction that is looked for unless other laws are asked for: all of one parameter each, in which
torques are linear (load-dependent friction by a fixed point). That by load is left out where a
joint follows another."""
LOST_ROTOR = "load_friction*rotor"
"""Name, behind the joint's, of the product of load-dependent friction and a rotor's inertia."""
_LEAST_LOSS = 1e-3
"""Part of the transmitted torque below which its loss tells nothing of what is transmitted."""


class FrictionLaw(NamedTuple):
    """A law of friction with the numbers of its shape, in which torques are not linear."""

    law: DriveLaw
    numbers: Mapping[str, float]
    shape: tuple[float, ...]
    """The law's further scalars, made of these numbers."""

    @property
    def by_load(self) -> bool:
        """Whether the friction depends on the torque that the joint transmits."""
        return self.law.losses is not None


class JointColumns(NamedTuple):
    """The columns of one joint: which of the kernel's results they are, and which unknowns each of
    them multiplies; those of load-dependent friction are no results of the kernel.

    load: the unknown loss, as part of the transmitted torque, or None. lost_rotor: the unknown
    product of loss and rotor, where base parameters do not tell the rotor from the bodies, or None:
    a rotor's torque is not transmitted, so that nothing of it is lost.
    """

    results: slice
    unknowns: NDArray[np.intp]
    load: int | None
    lost_rotor: int | None

    @property
    def by_load(self) -> list[int]:
        """The unknowns of load-dependent friction."""
        return [x for x in (self.load, self.lost_rotor) if x is not None]


@dataclass(frozen=True)
class Columns:
    """The unknowns of a robot, base parameters and then friction joint by joint, and the kernel of
    their columns.

    smooth: rate within which the sign of a rate changes, 0 for at once. base_names: of the inertial
    parameter that leads each combination. inertial_names: of π, those of bodies and then reflected
    inertias of rotors. matrix: (b, p), base parameters = matrix π. friction: the laws, in order,
    those by load last. joints: names, with columns each. kernel: (q, qd, qdd, s) -> (..., width),
    entries of the regressor that are not always 0, s being the signs of the rates.
    """

    base_names: tuple[str, ...]
    inertial_names: tuple[str, ...]
    matrix: Array
    friction: tuple[FrictionLaw, ...]
    joints: tuple[str, ...]
    rows: tuple[JointColumns, ...]
    kernel: Callable[..., Array]
    width: int
    smooth: float

    @property
    def base(self) -> int:
        """The number of base parameters, the first unknowns."""
        return len(self.base_names)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of all unknowns."""
        laws = [f"{joint}.{x.law.strength}" for joint in self.joints for x in self.friction]
        rotors = [
            f"{joint}.{LOST_ROTOR}"
            for joint, row in zip(self.joints, self.rows, strict=True)
            if row.lost_rotor is not None
        ]
        return (*self.base_names, *laws, *rotors)

    @property
    def friction_size(self) -> int:
        """The number of friction's unknowns, n for each law, behind the base parameters."""
        return len(self.joints) * len(self.friction)

    def of_bodies(self, values: Array) -> tuple[Array, Array]:
        """(base parameters (b,), reflected inertias (n,)) such that joints transmit the torques of
        the first without those of the second, from unknowns."""
        base, rotors = values[: self.base].copy(), np.zeros(len(self.joints))
        base[[name.endswith(".rotor") for name in self.base_names]] = 0.0
        for j, row in enumerate(self.rows):
            if row.load is not None and row.lost_rotor is not None:
                loss, product = values[row.load], values[row.lost_rotor]
                rotors[j] = max(product, 0.0) / loss if loss > _LEAST_LOSS else 0.0
        return base, rotors

    @property
    def by_load(self) -> bool:
        """Whether friction of some joint depends on the torque that it transmits."""
        return any(row.load is not None for row in self.rows)

    def sums_to_torques(self, base: Array) -> Array:
        """(width, n) by which the kernel's results add up to torques of base parameters (b,),
        without friction."""
        values, own = np.zeros((self.width, len(self.joints))), np.append(base, 0.0)
        for j, row in enumerate(self.rows):
            values[row.results, j] = own[np.minimum(row.unknowns, self.base)]
        return values

    def results(self, q: Array, qd: Array, qdd: Array) -> Array:
        """The kernel's results (..., width) at states."""
        return np.asarray(self.kernel(q, qd, qdd, self.sign(qd)))

    def sign(self, qd: Array) -> Array:
        """The sign of rates as the columns have it."""
        return np.sign(qd) if self.smooth == 0.0 else np.tanh(qd / self.smooth)


def friction_laws(
    function: str, model: Model, wanted: Sequence[str] | Mapping[str, Any] | None
) -> tuple[FrictionLaw, ...]:
    """The laws of friction by name, those by load last.

    wanted: names of laws, or {name: {number: value}} with the numbers of their shapes, such as
    {"stribeck": {"stribeck_speed": 0.1}}; None: the usual ones that the robot can have. Raises
    UnknownNameError and FreebodyError.
    """
    following = [body.joint for body in model.bodies if body.joint.mimic is not None]
    if wanted is None:
        wanted = [x for x in USUAL_LAWS if not (following and LAWS[x].losses)]
    given = wanted if isinstance(wanted, Mapping) else dict.fromkeys(wanted)
    made = []
    for name, numbers in given.items():
        if name not in LAWS or LAWS[name].feature == "rotors":
            known = [x for x, law in LAWS.items() if law.feature != "rotors"]
            raise UnknownNameError("law", name, f"{function}: friction=", known)
        if following and LAWS[name].losses:
            raise FreebodyError(
                f"{function}: {LAWS[name].term} is of the torque that a joint transmits, which is "
                f"not determined where {following[0].name!r} follows another joint; leave "
                f"{name!r} out of friction= (--friction), or lock the joint that it follows "
                f"(Model.with_locked, --lock)."
            )
        made.append(_with_shape(function, LAWS[name], numbers or {}))
    return tuple(sorted(made, key=lambda x: x.by_load))


def _with_shape(function: str, law: DriveLaw, numbers: Mapping[str, float]) -> FrictionLaw:
    if len(law.parameters) != 1 and not (law.losses and len(law.numbers) == 1):
        raise FreebodyError(
            f"{function}: a log does not tell the {law.words} by a regression, since torques are "
            f"not linear in its numbers. Take 'load' for losses in a gear, and the model's springs "
            f"as known."
        )
    needed = [x.name for x in law.numbers[1:]]
    for name in numbers:
        if name not in needed:
            raise UnknownNameError("number", name, f"{function}: friction law {law.name!r}", needed)
    missing = [name for name in needed if name not in numbers]
    if missing:
        example = ", ".join(f'"{name}": …' for name in needed)
        raise FreebodyError(
            f"{function}: torques are not linear in {missing[0]} of the {law.words}; give it, as "
            f'friction={{"{law.name}": {{{example}}}}}.'
        )
    values = {law.strength: 1.0} | {name: float(x) for name, x in numbers.items()}
    own = {name: values[name] for name in needed}
    return FrictionLaw(law, own, tuple(law.scalars_of(values.__getitem__))[1:])


def regression_columns(
    function: str,
    model: Model,
    friction: Sequence[FrictionLaw] = (),
    rotors: bool = True,
) -> Columns:
    """The unknowns of a robot and the kernel of their columns; the model's masses do not matter.

    friction: laws that each joint has. rotors: whether each joint has a rotor of unknown inertia.
    Raises FreebodyError for a model with loops, passive joints, or joints of more than one
    coordinate.
    """
    structure = _without_numbers(function, model, rotors)
    base = base_parameters(structure)
    inertial = _inertial(structure, base.parameters)
    kept = [k for k, column in enumerate(base.columns) if column in inertial]
    chosen = [base.columns[k] for k in kept]
    of_all = formula(structure, "regressor")
    n, linear = structure.nv, [x for x in friction if not x.by_load]
    samples = (np.moveaxis(x, -1, 0) for x in generic_state(structure, seed=1, batch=5))
    present = [
        [k for k, c in enumerate(chosen) if np.any(row[c] != 0.0)] for row in of_all(*samples)
    ]

    def regression_columns(q: Any, qd: Any, qdd: Any, s: Any) -> Any:
        entries: list[Any] = []
        for j, row in enumerate(of_all(q, qd, qdd)):
            entries += [row[chosen[k]] for k in present[j]]
            entries += [x.law.torques((1.0, *x.shape), q[j], qd[j], s[j])[0] for x in linear]
        return {"entries": tuple(entries)}

    width = sum(map(len, present)) + n * len(linear)
    shapes: dict[str, tuple[int, ...]] = dict.fromkeys(("q", "qd", "qdd", "s"), (n,))
    kernel = compiled(regression_columns, shapes, {"entries": (width,)})
    rows, start, size, more = [], 0, len(friction), 0
    names = [base.names[k] for k in kept]
    for j, of_base in enumerate(present):
        first = len(kept) + j * size
        unknowns = np.array([*of_base, *range(first, first + len(linear))], dtype=np.intp)
        load = lost = None
        if size > len(linear):
            load = first + len(linear)
            if rotors and f"{structure.velocity_names[j]}.rotor" not in names:
                lost, more = len(kept) + n * size + more, more + 1
        rows.append(JointColumns(slice(start, start + len(unknowns)), unknowns, load, lost))
        start += len(unknowns)
    return Columns(
        tuple(names),
        tuple(base.parameters[c] for c in inertial),
        base.matrix[np.ix_(kept, inertial)],
        tuple(friction),
        structure.velocity_names,
        tuple(rows),
        kernel,
        width,
        WIDTHS[0],
    )


def _without_numbers(function: str, model: Model, rotors: bool) -> Model:
    """The model without friction and springs, with a rotor at each joint or at none."""
    model.require_tree(function)
    if model.passive:
        raise PassiveJointError(
            f"{function}: joint {model.passive_names[0]!r} of {model.name!r} is passive: a log "
            f"tells no torque there. Take a model whose joints all have drives."
        )
    if model.nq != model.nv or not set(model.velocity_names) <= set(model.joint_names):
        raise FreebodyError(
            f"{function}: {model.name!r} has joints of more than one coordinate, or a free base; "
            f"logs are read of joints that turn or slide. Take an arm on a fixed base."
        )
    bare = model.without("friction", "rotors", "springs")
    for joint in model.velocity_names if rotors else ():
        bare = bare.with_drive(joint, rotor=1.0, gear=1.0)
    return bare


def _inertial(model: Model, names: tuple[str, ...]) -> list[int]:
    """Places of the parameters that are masses and inertias: of bodies, and of rotors."""
    of_bodies = len(model.bodies) * len(body_parameters(of_dimension(model.dim)))
    return [k for k, name in enumerate(names) if k < of_bodies or name.endswith(".rotor")]
