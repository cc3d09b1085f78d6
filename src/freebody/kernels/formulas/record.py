"""A formula as a record, and the option that picks its variant by structure: the frame, the loaded
frames, and the drives of a closed chain; and the inputs of all formulas."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Literal, NamedTuple

from freebody.algorithms.loop_constraints import Counting
from freebody.algorithms.loop_forces import Partition, drive_torques
from freebody.algorithms.rnea import External, external_on_frame
from freebody.arrays import Array
from freebody.dual import Dual
from freebody.model.doubt_rules.aspects import DYNAMIC
from freebody.model.tree import Tree
from freebody.spatial import Vector

Dimensions = tuple[str | int, ...]
"""Numbers, or names that a model turns into numbers: nq, nv, nj, six, dim, angular (3 or 1), pose
(dim + 1), rows, parameters, constraints (loop equations), equations (those that count), loose
(those that the partition leaves out), reactions (joints and loops), struts, branches (of inverse
kinematics)."""

Evaluation = Callable[..., tuple[Any, ...]]
"""(tree, option, **inputs) -> a tuple of nested sequences of scalars; of inputs, `wrenches` is a
tuple of vectors, one for each of option.wrench_frames."""

Untaken = Literal["struts", "losses", "losses by columns"]
"""Features of robots that some formulas cannot take."""

Fetch = Callable[[str], Any]
"""Name of a formula -> its kernel."""

ByColumns = Callable[[list[Array], int, Fetch, int | None], tuple[Array, ...]]
"""(inputs, coordinates, fetch, threads) -> arrays (..., column, row)."""


class Option(NamedTuple):
    """The structure that a formula depends on besides the model: part of the key of every call, and
    so quick to hash."""

    frame: str | None = None
    reference: str = "world"
    wrench_frames: tuple[str, ...] = ()
    point: bool = False
    rows: tuple[int, ...] = ()
    """Rows of a frame's motion, for the quantities of operational space and inverse kinematics."""
    equations: Counting | None = None
    """Loop equations that count; None: all."""
    partition: Partition | None = None
    """The partition of a closed chain's equations and coordinates, by which its drives' torques
    follow."""
    held: tuple[int, ...] | None = None
    """Coordinates whose rates are given, and tell the others; None: all are given, and the nearest
    possible meant."""
    checks: str = ""
    """Checks of a closed chain: NaN where the choice of equations does not tell ("solution"), and
    where its loops do not allow the state either ("state")."""
    redundant: bool = False
    """Whether the arm has a joint whose position is given, for inverse kinematics."""


class Output(NamedTuple):
    """An output of a formula: its dimensions, and its meaning for readers of generated text."""

    dims: Dimensions
    meaning: str


def one(name: str, dims: Dimensions, meaning: str) -> dict[str, Output]:
    """The outputs of a formula that has a single one."""
    return {name: Output(dims, meaning)}


@dataclass(frozen=True)
class Formula:
    """A computable quantity.

    inputs: names of the table `INPUTS`, and `wrenches`.
    outputs: by their name, which is unique within the formula.
    another: a second way to the same values; for robots of few joints both are traced and the
    shorter program is compiled. by_motion: whether of the inertial numbers M and the bias alone
    count, so that they may be regrouped. of_frame: whether it is of one frame, by default the tip.
    axes: those that it may be asked for in, besides the world's. of_rows: whether rows of the
    frame's motion can be chosen. free_rows: whether the arm must be able to move the frame along
    each of them.
    chains: which it says something of; "open": it leaves loops out, so that a closed chain must not
    be given to it; "arm": of open chains those with a closed form alone; "square": those whose
    torques determine the wrench at a frame. settled: what of a closed
    chain is chosen near home, once for all positions of a kernel: the "equations" that tell all,
    those left out that depend on others, or the "partition" of equations and coordinates by its
    drives, or one for what the "loops" do, to which drives do not matter.
    by_columns: how a matrix of a large robot is made column by column.
    cannot_take: features of robots for which it would be wrong, and is refused: "struts", which it
    leaves out; "losses", joints that lose a part of the torque that they transmit; "losses by
    columns", which the way by columns alone leaves out.
    touches: what of the robot it depends on besides geometry, of what a doubt may be on
    (`model.doubt_rules.aspects`).
    derivatives: of an open chain without wrenches, formulas of the one output's derivatives on the
    tangent space, and the inputs by which their outputs are, in their order.
    """

    inputs: tuple[str, ...]
    outputs: dict[str, Output]
    evaluate: Evaluation
    another: Evaluation | None = None
    by_motion: bool = False
    of_frame: bool = False
    axes: tuple[str, ...] = ()
    of_rows: bool = False
    free_rows: bool = False
    chains: Literal["all", "open", "closed", "arm", "square"] = "all"
    settled: Literal["equations", "partition", "loops"] | None = None
    by_columns: ByColumns | None = None
    cannot_take: frozenset[Untaken] = frozenset()
    touches: tuple[str, ...] = DYNAMIC
    derivatives: Mapping[str, tuple[str, ...]] = field(default_factory=dict)

    def uses(self, option: str) -> bool:
        """Whether an option of `fb.kernel` has an effect on the formula."""
        return {
            "frame": self.of_frame,
            "reference": bool(self.axes),
            "wrench_frames": "wrenches" in self.inputs,
            "rows": self.of_rows,
        }[option]


def frame_of(o: Option) -> str:
    """The name of the frame that the option chooses."""
    assert o.frame is not None  # the public functions resolve the tip
    return o.frame


def partition_of(o: Option) -> Partition:
    """The partition of the loop equations that the option chooses."""
    assert o.partition is not None  # `kernel` and the functions of closed chains choose it
    return o.partition


def external(tree: Tree, o: Option, q: Vector, wrenches: tuple[Vector, ...]) -> list[External]:
    """The external wrenches on the option's frames, as they act on bodies."""
    loads = (
        external_on_frame(tree, q, f, w) for f, w in zip(o.wrench_frames, wrenches, strict=True)
    )
    return [load for load in loads if load is not None]


def at_driven_joints(tree: Tree, o: Option, q: Vector, needed: Vector) -> Vector:
    """The needed torques themselves for a tree, or for a closed chain the torques of its drives
    with the same effect."""
    return drive_torques(tree, q, needed, partition_of(o)) if tree.loops else needed


def still(tree: Tree) -> Vector:
    """Rates of a robot at rest."""
    return (0.0,) * tree.nv


def seeded(values: Vector, rates: Vector) -> Vector:
    """Dual scalars from values and their slopes."""
    return tuple(Dual(x, {0: rate}) for x, rate in zip(values, rates, strict=True))


class Input(NamedTuple):
    """An input of a formula: its dimensions, its meaning with units, and a usual size for inputs
    that must be positive."""

    dims: Dimensions
    meaning: str
    positive: float | None = None


INPUTS = {
    "q": Input(("nq",), "positions of the joints (rad, m; unit quaternions as w, x, y, z)"),
    "q0": Input(("nq",), "initial positions, as q"),
    "q1": Input(("nq",), "final positions, as q"),
    "qd": Input(
        ("nv",),
        "rates (rad/s, m/s; of free joints the velocity, then the angular velocity, body axes)",
    ),
    "qdd": Input(("nv",), "accelerations, rates of qd (rad/s^2, m/s^2)"),
    "v": Input(("nv",), "a displacement along the rates (rad, m)"),
    "tau": Input(("nv",), "torques and forces of the joints (N m, N)"),
    "x": Input(("nv",), "a vector along the rates"),
    "dq": Input(("nv",), "a direction along the rates (rad, m)"),
    "dqd": Input(("nv",), "a direction of the rates (rad/s, m/s)"),
    "multipliers": Input(("constraints",), "one for each loop equation (N, N m)"),
    "reactions": Input(
        ("reactions", "six"), "wrench of each joint, then of each loop: force, then moment (N, N m)"
    ),
    "point": Input(("dim",), "a point, world axes (m)"),
    "target": Input(("pose", "pose"), "pose to be reached, homogeneous matrix, world axes (m)"),
    "redundancy": Input(
        (), "position of the joint that is held: the last of seven, or the first (rad, m)"
    ),
    "h": Input((), "length of the step (s)", 1e-2),
    "q_ref": Input(("nq",), "reference positions of the feedback, as q"),
    "qd_ref": Input(("nv",), "reference rates of the feedback (rad/s, m/s)"),
    "qdd_ref": Input(("nv",), "reference accelerations (rad/s^2, m/s^2)"),
    "kp": Input(
        ("nv",), "position gains of the feedback (N m/rad, N/m; of computed torque 1/s^2)", 1.0
    ),
    "kd": Input(
        ("nv",), "rate gains of the feedback (N m s/rad, N s/m; of computed torque 1/s)", 1.0
    ),
    "pose_ref": Input(("pose", "pose"), "reference pose, homogeneous matrix, world axes (m)"),
    "V_ref": Input(("rows",), "reference velocity of the frame, world axes (m/s, rad/s)"),
    "A_ref": Input(("rows",), "reference acceleration of the frame, world axes (m/s^2, rad/s^2)"),
    "kp_task": Input(("rows",), "position gains of the motion of the frame (1/s^2)", 1.0),
    "kd_task": Input(("rows",), "rate gains of the motion of the frame (1/s)", 1.0),
    "tau_null": Input(("nv",), "torques of which acts what does not accelerate the frame (N m, N)"),
    "offset": Input(("rows",), "displacement from the reference (m, rad)"),
    "offset_rate": Input(("rows",), "rate of the displacement (m/s, rad/s)"),
    "w_ext": Input(("rows",), "measured wrench on the frame: force, then moment (N, N m)"),
    "inertia": Input(("rows",), "virtual inertia (kg, kg m^2)", 1.0),
    "stiffness": Input(("rows",), "stiffness of the motion of the frame (N/m, N m/rad)", 1.0),
    "damping": Input(("rows",), "damping of the motion of the frame (N s/m, N m s/rad)", 1.0),
    "integral": Input(("nv",), "what the observer remembers, at first M qd (kg m^2/s, kg m/s)"),
    "ko": Input(("nv",), "gains of the observer (1/s)", 1.0),
}
"""Inputs of formulas by name, all but the wrenches on frames, whose number a call says: wrench0,
wrench1, …, which come last."""

POSITIONS = tuple(name for name, given in INPUTS.items() if given.dims == ("nq",))
"""Inputs that are positions; a derivative by them is one along the rates."""
