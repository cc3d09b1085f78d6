"""The table of what can be computed: for each name its inputs, its outputs and the algorithm that does it.

Kernels are traced from this table and the float reference runs it as it stands, so both are the same text. An
`Option` picks a variant by structure (frame, axes, which frames carry wrenches); inputs and outputs are named by
their dimensions, which a model turns into numbers.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

from freebody.algorithms import energy, kinematics, steps
from freebody.algorithms.aba import aba
from freebody.algorithms.balance import Moving, balance
from freebody.algorithms.constraints import (
    constrained_dynamics,
    constraint,
    constraint_bias,
    constraint_jacobian,
    loop_loads,
    loop_wrenches,
)
from freebody.algorithms.coriolis import coriolis_matrix, coriolis_product
from freebody.algorithms.crba import (
    bias,
    crba,
    factor,
    forward_dynamics,
    mass_product,
    only_inertia,
    substitute,
    supports,
)
from freebody.algorithms.derivatives import (
    Derivatives,
    forward_dynamics_derivatives,
    inverse_dynamics_derivatives,
)
from freebody.algorithms.loop_forces import Partition, drive_torques, loop_multipliers, loose_recursions
from freebody.algorithms.operational import centroidal_momentum_matrix, mass_matrix_inverse, operational_space
from freebody.algorithms.regressor import energy_regressor, regressor
from freebody.algorithms.regroup import lightened
from freebody.algorithms.rnea import External, external_on_frame, joint_wrenches, rnea
from freebody.elementary import Scalar
from freebody.model.tree import Tree
from freebody.scalars.dual import Dual, slopes
from freebody.scalars.jets import Jet, parts
from freebody.spatial import Vector, identity, neg, sub, times, transposed

POSITIONS = ("q", "q0", "q1", "q_ref")
"""Inputs that are positions (nq); the others are velocities and what acts along them (nv), or named below."""


class Option(NamedTuple):
    """Structure that a formula depends on, besides the model; part of the key of every call, so quick to hash."""

    frame: str | None = None
    reference: str = "world"
    wrench_frames: tuple[str, ...] = ()
    point: bool = False
    rows: tuple[int, ...] = ()
    """Rows of a frame's motion, for the quantities of operational space."""
    equations: tuple[int, ...] | None = None
    """Loop equations that count; None: all. The others follow from them."""
    partition: Partition | None = None
    """Of a closed chain's equations and coordinates, for what its drives do."""


@dataclass(frozen=True)
class Formula:
    """A computable quantity.

    inputs: names among q, q0, q1, q_ref (nq each), qd, qdd, v, tau, x, dq, dqd, qd_ref, kp, kd (nv each), h (a number),
    multipliers, reactions (wrenches of joints and loops), point, wrenches.
    outputs: name -> dimensions: numbers, or names among nq, nv, nj, six, dim, angular (3 or 1), pose (dim + 1), rows,
    parameters, constraints (loop equations), equations (those that count), loose (those that the partition leaves out),
    reactions (joints and loops).
    evaluate(tree, option, **inputs): a tuple of nested sequences of scalars; wrenches is a tuple of vectors, one for
    each of option.wrench_frames. another: a second way to the same values; for robots of few joints both are traced and
    the shorter program is compiled. by_motion: whether of the inertial numbers M and the bias alone count, so that they
    may be regrouped.
    """

    inputs: tuple[str, ...]
    outputs: dict[str, tuple[str | int, ...]]
    evaluate: Callable[..., tuple[Any, ...]]
    another: Callable[..., tuple[Any, ...]] | None = None
    by_motion: bool = False


def _external(tree: Tree, o: Option, q: Vector, wrenches: tuple[Vector, ...]) -> list[External]:
    loads = (external_on_frame(tree, q, f, w) for f, w in zip(o.wrench_frames, wrenches, strict=True))
    return [load for load in loads if load is not None]


def _pose(tree: Tree, o: Option, q: Vector) -> tuple[Any, ...]:
    R, p = kinematics.frame_pose(
        tree, kinematics.world_poses(tree, kinematics.joint_poses(tree, q)), _frame(o)
    )
    last = (0.0,) * tree.space.dim + (1.0,)
    return ((*((*row, x) for row, x in zip(R, p, strict=True)), last),)


def _velocity(tree: Tree, o: Option, q: Vector, qd: Vector, point: Vector | None = None) -> tuple[Any, ...]:
    motion = kinematics.outward(tree, q, qd, _zeros(tree))
    (w, v), _ = kinematics.frame_motion(tree, motion, _frame(o), point)
    return (v + w,)


def _acceleration(
    tree: Tree, o: Option, q: Vector, qd: Vector, qdd: Vector, point: Vector | None = None
) -> tuple[Any, ...]:
    _, (wd, vd) = kinematics.frame_motion(tree, kinematics.outward(tree, q, qd, qdd), _frame(o), point)
    return (vd + wd,)


def _inverse(
    tree: Tree, o: Option, q: Vector, qd: Vector, qdd: Vector, wrenches: Any = ()
) -> tuple[Any, ...]:
    return (_driven(tree, o, q, rnea(tree, q, qd, qdd, _external(tree, o, q, wrenches)).tau),)


def _forward(
    tree: Tree, o: Option, q: Vector, qd: Vector, tau: Vector, wrenches: Any = ()
) -> tuple[Any, ...]:
    if tree.loops:
        return (constrained_dynamics(tree, q, qd, tau, _external(tree, o, q, wrenches), o.equations).qdd,)
    method = aba if prefers_articulated_bodies(tree) else forward_dynamics
    return (method(tree, q, qd, tau, _external(tree, o, q, wrenches)),)


def prefers_articulated_bodies(tree: Tree) -> bool:
    """Whether articulated bodies take fewer operations than factoring the mass matrix: chains are long."""
    longest = max((len(above) for above in supports(tree).values()), default=0)
    return longest >= 24 and not tree.follows


def _step(method: Callable[..., steps.State]) -> Callable[..., tuple[Any, ...]]:
    """A step by an explicit method, the torque and the wrenches held."""

    def evaluate(
        tree: Tree, o: Option, q: Vector, qd: Vector, tau: Vector, h: Scalar, wrenches: Any = ()
    ) -> tuple[Any, ...]:
        tree = lightened(tree)

        def acceleration(q: Vector, qd: Vector) -> Vector:
            return _forward(tree, o, q, qd, tau, wrenches)[0]

        return steps.on_loops(tree, q, method(tree, q, qd, h, acceleration), o.equations)

    return evaluate


def _implicit_step(
    tree: Tree,
    o: Option,
    q: Vector,
    qd: Vector,
    tau: Vector,
    h: Scalar,
    wrenches: Any = (),
    **feedback: Vector,
) -> tuple[Any, ...]:
    def loads(q: Vector) -> list[External]:
        return _external(tree, o, q, wrenches)

    tree = lightened(tree)
    law = steps.Feedback(**feedback) if feedback else None
    reached = steps.implicit(tree, q, qd, tau, h, loads, law, o.equations)
    return steps.on_loops(tree, q, reached, o.equations)


def _gravity(tree: Tree, o: Option, q: Vector) -> tuple[Any, ...]:
    still = _zeros(tree)
    return (rnea(only_inertia(tree), q, still, still).tau,)


def _static(tree: Tree, o: Option, q: Vector, wrenches: Any = ()) -> tuple[Any, ...]:
    still = _zeros(tree)
    return (_driven(tree, o, q, rnea(tree, q, still, still, _external(tree, o, q, wrenches)).tau),)


def _wrenches(
    tree: Tree, o: Option, q: Vector, qd: Vector, qdd: Vector, wrenches: Any = ()
) -> tuple[Any, ...]:
    return (joint_wrenches(tree, rnea(tree, q, qd, qdd, _external(tree, o, q, wrenches)), o.reference),)


def _constrained(
    tree: Tree, o: Option, q: Vector, qd: Vector, tau: Vector, wrenches: Any = ()
) -> tuple[Any, ...]:
    found = constrained_dynamics(tree, q, qd, tau, _external(tree, o, q, wrenches), o.equations)
    return found.qdd, found.multipliers, found.pivots


def _constraint_jerk(tree: Tree, o: Option, q: Vector, qd: Vector, x: Vector) -> tuple[Any, ...]:
    """Φ's third derivative when q̈ = x and q⃛ = 0: affine in x. It tells how a mechanism goes on where Φ_q loses rank."""
    moved = _seeded(q, kinematics.position_rates(tree, q, qd))
    second = sub(times(constraint_jacobian(tree, moved), x), constraint_bias(tree, moved, _seeded(qd, x)))
    return (tuple(slopes(value, 1)[0] for value in second),)


def _closed_wrenches(
    tree: Tree, o: Option, q: Vector, qd: Vector, qdd: Vector, multipliers: Vector, wrenches: Any = ()
) -> tuple[Any, ...]:
    """Of every joint, then of every loop."""
    loads = _external(tree, o, q, wrenches) + loop_loads(tree, q, multipliers)
    recursion = rnea(tree, q, qd, qdd, loads)
    return (
        [*joint_wrenches(tree, recursion, o.reference), *loop_wrenches(tree, q, multipliers, o.reference)],
    )


def _loose_wrenches(tree: Tree, o: Option, q: Vector) -> tuple[Any, ...]:
    """What each combination of multipliers that no motion feels does to every joint and loop."""
    return (
        [
            [
                *joint_wrenches(tree, recursion, o.reference),
                *loop_wrenches(tree, q, multipliers, o.reference),
            ]
            for multipliers, recursion in loose_recursions(tree, q, _partition(o))
        ],
    )


def _balance(
    tree: Tree, o: Option, q: Vector, qd: Vector, qdd: Vector, reactions: Any, wrenches: Any = ()
) -> tuple[Any, ...]:
    """Poses and their derivatives come from the positions' alone, by jets in time."""
    rates = kinematics.position_rates(tree, q, qd)
    second = kinematics.position_rates(tree, _seeded(q, rates), _seeded(qd, qdd))
    jets = tuple(Jet(*x) for x in zip(q, rates, (slopes(x, 1)[0] for x in second), strict=True))
    world = kinematics.world_poses(tree, kinematics.joint_poses(tree, jets))
    moving = [Moving(*parts(pose)) for pose in world]
    return balance(tree, moving, reactions, tuple(zip(o.wrench_frames, wrenches, strict=True)))


def _driven(tree: Tree, o: Option, q: Vector, needed: Vector) -> Vector:
    """Torques of a tree, or of the drives of a closed chain that do the same."""
    return drive_torques(tree, q, needed, _partition(o)) if tree.loops else needed


def _partition(o: Option) -> Partition:
    assert o.partition is not None  # `kernel` and the functions of closed chains choose it
    return o.partition


def _momentum(tree: Tree, o: Option, q: Vector, qd: Vector, point: Vector | None = None) -> tuple[Any, ...]:
    return (energy.momentum(tree, q, qd, point),)


def _centre(tree: Tree, o: Option, q: Vector) -> tuple[Any, ...]:
    return (kinematics.centre_of_mass(tree, q),)


def _inverse_along(
    tree: Tree, o: Option, q: Vector, qd: Vector, qdd: Vector, dq: Vector, dqd: Vector
) -> tuple[Any, ...]:
    """Change of tau along a direction (dq, dqd) of the tangent space."""
    moved = _seeded(q, kinematics.position_rates(tree, q, dq))
    return (tuple(slopes(t, 1)[0] for t in rnea(tree, moved, _seeded(qd, dqd), qdd).tau),)


def _seeded(values: Vector, rates: Vector) -> Vector:
    return tuple(Dual(x, {0: rate}) for x, rate in zip(values, rates, strict=True))


def _jacobian_by_position(tree: Tree, o: Option, q: Vector) -> tuple[Any, ...]:
    """Derivatives of every entry of the Jacobian along every direction of q."""
    J = kinematics.jacobian(tree, _along_every_direction(tree, q), _frame(o), o.reference)
    return (tuple(tuple(slopes(x, tree.nv) for x in row) for row in J),)


def _along_every_direction(tree: Tree, q: Vector) -> Vector:
    """q with slopes along each of the nv directions of the tangent space."""
    units = identity(tree.nv)
    along = [kinematics.position_rates(tree, q, unit) for unit in units]
    return tuple(Dual(x, {k: rates[i] for k, rates in enumerate(along)}) for i, x in enumerate(q))


def _by_dual_scalars(tree: Tree, q: Vector, qd: Vector, qdd: Vector) -> Derivatives:
    """Derivatives of inverse dynamics by forward mode: shorter where a robot's geometry folds well."""
    n = tree.nv
    faster = tuple(Dual(x, {n + k: 1.0}) for k, x in enumerate(qd))
    rows = [slopes(t, 2 * n) for t in rnea(tree, _along_every_direction(tree, q), faster, qdd).tau]
    return Derivatives(tuple(tuple(r[:n]) for r in rows), tuple(tuple(r[n:]) for r in rows), crba(tree, q))


def _forward_by_parameters(tree: Tree, o: Option, q: Vector, qd: Vector, tau: Vector) -> tuple[Any, ...]:
    """∂q̈/∂π = -M⁻¹ Y."""
    qdd = forward_dynamics(tree, q, qd, tau)
    factors = factor(tree, crba(tree, q))
    columns = transposed(regressor(tree, q, qd, qdd))
    return (transposed(tuple(neg(substitute(tree, factors, column)) for column in columns)),)


def _second(tree: Tree, o: Option, q: Vector, qd: Vector, qdd: Vector) -> tuple[Any, ...]:
    """Second derivatives of tau: those of its first ones along every direction of q, and of q̇."""
    n = tree.nv
    by_q = inverse_dynamics_derivatives(tree, _along_every_direction(tree, q), qd, qdd)
    faster = tuple(Dual(x, {k: 1.0}) for k, x in enumerate(qd))
    by_qd = inverse_dynamics_derivatives(tree, q, faster, qdd)
    return tuple(
        tuple(tuple(slopes(x, n) for x in row) for row in table)
        for table in (by_q.by_q, by_q.by_qd, by_qd.by_qd, by_q.by_last)
    )


def _matrices(derivatives: Derivatives) -> tuple[Any, ...]:
    return derivatives.by_q, derivatives.by_qd, derivatives.by_last


def _zeros(tree: Tree) -> Vector:
    return (0.0,) * tree.nv


def _frame(o: Option) -> str:
    assert o.frame is not None  # the public functions resolve the tip
    return o.frame


_STEP = ("q", "qd", "tau", "h", "wrenches")
_STATE: dict[str, tuple[str | int, ...]] = {"q1": ("nq",), "qd1": ("nv",)}

FORMULAS: dict[str, Formula] = {
    "forward_kinematics": Formula(("q",), {"T": ("pose", "pose")}, _pose),
    "velocity": Formula(("q", "qd", "point"), {"V": ("six",)}, _velocity),
    "acceleration": Formula(("q", "qd", "qdd", "point"), {"A": ("six",)}, _acceleration),
    "jacobian": Formula(
        ("q",), {"J": ("six", "nv")}, lambda t, o, q: (kinematics.jacobian(t, q, _frame(o), o.reference),)
    ),
    "jacobian_dot": Formula(
        ("q", "qd"),
        {"Jd": ("six", "nv")},
        lambda t, o, q, qd: (kinematics.jacobian_dot(t, q, qd, _frame(o), o.reference),),
    ),
    "center_of_mass": Formula(("q",), {"com": ("dim",)}, _centre),
    "inverse_dynamics": Formula(("q", "qd", "qdd", "wrenches"), {"tau": ("nv",)}, _inverse, by_motion=True),
    "forward_dynamics": Formula(("q", "qd", "tau", "wrenches"), {"qdd": ("nv",)}, _forward, by_motion=True),
    "mass_matrix": Formula(("q",), {"M": ("nv", "nv")}, lambda t, o, q: (crba(t, q),), by_motion=True),
    "coriolis_matrix": Formula(
        ("q", "qd"), {"C": ("nv", "nv")}, lambda t, o, q, qd: (coriolis_matrix(t, q, qd),)
    ),
    "bias": Formula(("q", "qd"), {"bias": ("nv",)}, lambda t, o, q, qd: (bias(t, q, qd),), by_motion=True),
    "gravity_torque": Formula(("q",), {"g": ("nv",)}, _gravity),
    "static_torque": Formula(("q", "wrenches"), {"tau": ("nv",)}, _static),
    "joint_wrenches": Formula(("q", "qd", "qdd", "wrenches"), {"W": ("nj", "six")}, _wrenches),
    "inverse_dynamics_derivatives": Formula(
        ("q", "qd", "qdd"),
        {"dtau_dq": ("nv", "nv"), "dtau_dqd": ("nv", "nv"), "M": ("nv", "nv")},
        lambda t, o, q, qd, qdd: _matrices(inverse_dynamics_derivatives(t, q, qd, qdd)),
        lambda t, o, q, qd, qdd: _matrices(_by_dual_scalars(t, q, qd, qdd)),
        by_motion=True,
    ),
    "forward_dynamics_derivatives": Formula(
        ("q", "qd", "tau"),
        {"dqdd_dq": ("nv", "nv"), "dqdd_dqd": ("nv", "nv"), "Minv": ("nv", "nv")},
        lambda t, o, q, qd, tau: _matrices(forward_dynamics_derivatives(t, q, qd, tau)),
        lambda t, o, q, qd, tau: _matrices(forward_dynamics_derivatives(t, q, qd, tau, _by_dual_scalars)),
        by_motion=True,
    ),
    "inverse_dynamics_second_derivatives": Formula(
        ("q", "qd", "qdd"),
        dict.fromkeys(("d2tau_dq_dq", "d2tau_dqd_dq", "d2tau_dqd_dqd", "dM_dq"), ("nv", "nv", "nv")),
        _second,
    ),
    "jacobian_derivatives": Formula(("q",), {"dJ_dq": ("six", "nv", "nv")}, _jacobian_by_position),
    "forward_dynamics_parameter_derivatives": Formula(
        ("q", "qd", "tau"), {"dqdd_dpi": ("nv", "parameters")}, _forward_by_parameters
    ),
    "mass_product": Formula(("q", "x"), {"Mx": ("nv",)}, lambda t, o, q, x: (mass_product(t, q, x),)),
    "coriolis_product": Formula(
        ("q", "qd", "x"), {"Cx": ("nv",)}, lambda t, o, q, qd, x: (coriolis_product(t, q, qd, x),)
    ),
    "inverse_dynamics_along": Formula(("q", "qd", "qdd", "dq", "dqd"), {"dtau": ("nv",)}, _inverse_along),
    "mass_matrix_inverse": Formula(
        ("q",), {"Minv": ("nv", "nv")}, lambda t, o, q: (mass_matrix_inverse(t, q),)
    ),
    "operational_space_inertia": Formula(
        ("q",),
        {"Lambda": ("rows", "rows")},
        lambda t, o, q: operational_space(t, q, None, _frame(o), o.rows)[:1],
    ),
    "operational_space_bias": Formula(
        ("q", "qd"), {"mu": ("rows",)}, lambda t, o, q, qd: operational_space(t, q, qd, _frame(o), o.rows)[1:]
    ),
    "centroidal_momentum_matrix": Formula(
        ("q",), {"A": ("six", "nv")}, lambda t, o, q: (centroidal_momentum_matrix(t, q),)
    ),
    "regressor": Formula(
        ("q", "qd", "qdd"), {"Y": ("nv", "parameters")}, lambda t, o, q, qd, qdd: (regressor(t, q, qd, qdd),)
    ),
    "energy_regressor": Formula(
        ("q", "qd"), {"E": (2, "parameters")}, lambda t, o, q, qd: (energy_regressor(t, q, qd),)
    ),
    "integrate": Formula(("q", "v"), {"q1": ("nq",)}, lambda t, o, q, v: (kinematics.moved(t, q, v),)),
    "difference": Formula(
        ("q0", "q1"), {"v": ("nv",)}, lambda t, o, q0, q1: (kinematics.between(t, q0, q1),)
    ),
    "semi_implicit_step": Formula(_STEP, _STATE, _step(steps.semi_implicit)),
    "rk4_step": Formula(_STEP, _STATE, _step(steps.runge_kutta)),
    "implicit_step": Formula(_STEP, _STATE, _implicit_step),
    "implicit_feedback_step": Formula((*_STEP, "q_ref", "qd_ref", "kp", "kd"), _STATE, _implicit_step),
    "constraint": Formula(("q",), {"Phi": ("constraints",)}, lambda t, o, q: (constraint(t, q),)),
    "constraint_jacobian": Formula(
        ("q",), {"Phi_q": ("constraints", "nv")}, lambda t, o, q: (constraint_jacobian(t, q),)
    ),
    "constraint_bias": Formula(
        ("q", "qd"), {"c": ("constraints",)}, lambda t, o, q, qd: (constraint_bias(t, q, qd),)
    ),
    "constraint_rate": Formula(
        ("q", "qd"),
        {"Phid": ("constraints",)},
        lambda t, o, q, qd: (times(constraint_jacobian(t, q), qd),),
    ),
    "constraint_jerk": Formula(("q", "qd", "x"), {"jerk": ("constraints",)}, _constraint_jerk),
    "constrained_dynamics": Formula(
        ("q", "qd", "tau", "wrenches"),
        {"qdd": ("nv",), "multipliers": ("equations",), "pivots": ("equations",)},
        _constrained,
    ),
    "closed_wrenches": Formula(
        ("q", "qd", "qdd", "multipliers", "wrenches"), {"W": ("reactions", "six")}, _closed_wrenches
    ),
    "drive_torques": Formula(
        ("q", "x"),
        {"tau": ("nv",)},
        lambda t, o, q, x: (drive_torques(t, q, x, _partition(o)),),
    ),
    "loop_multipliers": Formula(
        ("q", "x"),
        {"multipliers": ("constraints",)},
        lambda t, o, q, x: (loop_multipliers(t, q, x, _partition(o)),),
    ),
    "balance": Formula(
        ("q", "qd", "qdd", "reactions", "wrenches"),
        {"force": ("nj", "dim"), "moment": ("nj", "angular"), "largest": (2,)},
        _balance,
    ),
    "loose_wrenches": Formula(("q",), {"W": ("loose", "reactions", "six")}, _loose_wrenches),
    "kinetic_energy": Formula(("q", "qd"), {"T": ()}, lambda t, o, q, qd: (energy.kinetic_energy(t, q, qd),)),
    "potential_energy": Formula(("q",), {"V": ()}, lambda t, o, q: (energy.potential_energy(t, q),)),
    "momentum": Formula(("q", "qd", "point"), {"h": ("six",)}, _momentum),
}

OF_TREES = (
    "joint_wrenches",
    "inverse_dynamics_derivatives",
    "inverse_dynamics_second_derivatives",
    "inverse_dynamics_along",
    "forward_dynamics_derivatives",
    "forward_dynamics_parameter_derivatives",
    "mass_matrix_inverse",
    "operational_space_inertia",
    "operational_space_bias",
    "regressor",
)
"""Formulas that leave loops out, so that a closed chain must not be given to them."""

OF_INDEPENDENT_EQUATIONS = (
    "forward_dynamics",
    "semi_implicit_step",
    "rk4_step",
    "implicit_step",
    "implicit_feedback_step",
)
"""Formulas whose kernel for a closed chain has to do for all positions: equations that depend on others at home are
left out."""

OF_PARTITION = ("inverse_dynamics", "static_torque", "drive_torques", "loop_multipliers", "loose_wrenches")
"""Formulas that, of a closed chain, take its equations and coordinates apart as is right near home."""

OF_LOOPS = ("drive_torques", "loop_multipliers", "loose_wrenches")
"""Formulas that say nothing of an open chain."""
