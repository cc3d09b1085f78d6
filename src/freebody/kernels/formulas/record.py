"""A formula as a record, and the option that picks its variant by structure: the frame, the loaded
frames, and the drives of a closed chain."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Literal, NamedTuple

from freebody.algorithms.loop_constraints import Counting
from freebody.algorithms.loop_forces import Partition, drive_torques
from freebody.algorithms.rnea import External, external_on_frame
from freebody.arrays import Array
from freebody.dual import Dual
from freebody.model.doubts import DYNAMIC
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
    """Outputs of a formula that has a single one."""
    return {name: Output(dims, meaning)}


@dataclass(frozen=True)
class Formula:
    """A computable quantity: its inputs, its outputs, the function that evaluates it, and the
    properties by which kernels are made of it.

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
    without_struts: whether it leaves struts out, so that no model with some must be given to it.
    by_columns: how a matrix of a large robot is made column by column.
    lossless: whether it says nothing of robots whose joints lose a part of the torque that they
    transmit; columns_lossless: whether the way by columns does not.
    touches: what of the robot it depends on besides geometry, of what a doubt may be on
    (`model.doubts`).
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
    without_struts: bool = False
    by_columns: ByColumns | None = None
    lossless: bool = False
    columns_lossless: bool = False
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
