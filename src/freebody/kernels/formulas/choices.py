"""What an option means to a formula: the frame, loads on frames, what the drives of a closed chain
do; and slopes."""

from __future__ import annotations

from freebody.algorithms.kinematics import position_rates
from freebody.algorithms.loop_forces import Partition, drive_torques
from freebody.algorithms.rnea import External, external_on_frame
from freebody.kernels.formulas.record import Option
from freebody.model.tree import Tree
from freebody.scalars.dual import Dual
from freebody.spatial import Vector, identity


def frame_of(o: Option) -> str:
    """The frame that is meant."""
    assert o.frame is not None  # the public functions resolve the tip
    return o.frame


def partition_of(o: Option) -> Partition:
    """The partition that is meant."""
    assert o.partition is not None  # `kernel` and the functions of closed chains choose it
    return o.partition


def external(tree: Tree, o: Option, q: Vector, wrenches: tuple[Vector, ...]) -> list[External]:
    """The wrenches as they act on bodies."""
    loads = (
        external_on_frame(tree, q, f, w) for f, w in zip(o.wrench_frames, wrenches, strict=True)
    )
    return [load for load in loads if load is not None]


def at_driven_joints(tree: Tree, o: Option, q: Vector, needed: Vector) -> Vector:
    """Torques of a tree, or of the drives of a closed chain that do the same."""
    return drive_torques(tree, q, needed, partition_of(o)) if tree.loops else needed


def still(tree: Tree) -> Vector:
    """No rates."""
    return (0.0,) * tree.nv


def seeded(values: Vector, rates: Vector) -> Vector:
    """Values with one slope each."""
    return tuple(Dual(x, {0: rate}) for x, rate in zip(values, rates, strict=True))


def along_every_direction(tree: Tree, q: Vector) -> Vector:
    """q with slopes along each of the nv directions of the tangent space."""
    units = identity(tree.nv)
    along = [position_rates(tree, q, unit) for unit in units]
    return tuple(Dual(x, {k: rates[i] for k, rates in enumerate(along)}) for i, x in enumerate(q))
