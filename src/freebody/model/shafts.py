"""The shafts of flexible joints: which joints of a model are shafts that twist, the robot in which
they do not, and the states of both.

A shaft is a passive joint with a spring that rests at 0, which goes on along the joint above it,
from a link almost without mass. It is no joint of the arm: where a link is follows from the sum of
the rotor's angle and the twist, and the twist from what the shaft carries. So what asks where an
arm can be asks the robot with rigid joints, at the links' angles.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from freebody.arrays import Array
from freebody.model.bodies import Body
from freebody.model.description import Joint
from freebody.model.families import Members, one_family
from freebody.model.kept_facts import fact
from freebody.model.parameters import Parameter, Quantity
from freebody.model.placement import Placement, rotate, shift
from freebody.model.tree import Attached

if TYPE_CHECKING:
    from freebody.model.model import Model

_NEAR = 1e-9
"""Distance (m) or difference of directions of two lines that are one."""
_TRACE = 1e-6
"""Share of a robot's mass that a rotor's link has where a format knows none without mass."""


def least(number: Quantity) -> float:
    """The least value of a quantity among the members of a family; infinite where it has none."""
    known = number.value if isinstance(number, Parameter) else number
    if known is None:
        return math.inf
    return float(known.array.min()) if isinstance(known, Members) else known


# ------------------------------------------------------------ which joints are shafts
def shafts(model: Model) -> tuple[int, ...]:
    """The bodies, by index, whose joints are the shafts of flexible joints."""
    return tuple(
        k
        for k, body in enumerate(model.bodies)
        if _holds(body.joint) and goes_on(model, k) and not _leads(model, body.joint.name)
    )


def _holds(joint: Joint) -> bool:
    """Whether a joint has a spring that rests at 0, and nothing drives it."""
    return joint.passive and least(joint.drive.stiffness) > 0.0 and joint.drive.rest == 0.0


def _leads(model: Model, name: str) -> bool:
    """Whether another joint follows a joint."""
    mimics = (body.joint.mimic for body in model.bodies)
    return any(x is not None and name in (leader for leader, _ in x.terms) for x in mimics)


def goes_on(model: Model, k: int) -> bool:
    """Whether a body's joint goes on along the joint above, from a link almost without mass that
    carries nothing else."""
    body = model.bodies[k]
    if body.parent < 0 or body.kind.nv != 1 or body.joint.mimic is not None:
        return False
    rotor = model.bodies[body.parent]
    return (
        body.kind.motion is rotor.kind.motion
        and body.joint.numbers == rotor.joint.numbers
        and _is_light(model, rotor.inertias)
        and sum(other.parent == body.parent for other in model.bodies) == 1
        and _one_line(rotor, body, model.dim)
    )


def _is_light(model: Model, parts: tuple[Attached, ...]) -> bool:
    """Whether parts have almost none of the robot's mass."""
    if not parts:
        return True
    if model.missing or model.family:
        return False
    return sum(part.inertia.numbers()[0] for part in parts) <= _TRACE * model.mass


def _one_line(rotor: Body, body: Body, dim: int) -> bool:
    """Whether the axes of two joints in a row are one line; those of slides are parallel."""
    if not body.joint.placement.steps and body.joint.axis == rotor.joint.axis:
        return True
    R, p = body.joint.placement.arrays(dim)
    if not body.joint.axis:
        return not p.any()
    one, two, aside = np.array(rotor.joint.axis), np.array(body.joint.axis), p
    if len(two) == dim:  # else it is normal to the plane
        two, aside = R @ two, p - one * (one @ p)
    if body.kind.slides:
        aside = np.zeros(dim)
    return max(abs(one - two).max(), abs(aside).max()) <= _NEAR


# ------------------------------------------------------------ the robot in which they are rigid
def with_rigid_joints(model: Model) -> tuple[Model, dict[int, Body]]:
    """The model with shafts that do not twist, whatever drives or holds them, and the shaft of each
    body of it that has one."""
    return _made_rigid(model, [k for k in range(len(model.bodies)) if goes_on(model, k)])


def without_shafts(model: Model) -> Model:
    """The model with the rotors of flexible joints fixed to their links; frames of the rotors that
    nothing else names are gone."""
    gone = shafts(model)
    if not gone:
        return model
    rotors = {model.bodies[k].parent for k in gone}
    own = {x.name for x in model.frames if x.body in rotors and not x.parent and not x.mounted}
    ends = (name for part in (*model.loops, *model.struts) for name in part.frames)
    loads = (part.frame for body in model.bodies for part in body.inertias)
    own -= {*ends, *loads, model.tip, *(x.parent for x in model.frames)}
    rigid = _made_rigid(model, gone)[0]
    frames = tuple(x for x in rigid.frames if x.name not in own)
    return one_family(replace(rigid, frames=frames), model)


def _made_rigid(model: Model, gone: Collection[int]) -> tuple[Model, dict[int, Body]]:
    """The model in which given shafts, by the indices of their bodies, do not twist, and the shaft
    of each body of it that has one."""
    if not gone:
        return model, {}
    above = {model.bodies[k].parent for k in gone}
    kept = [k for k in range(len(model.bodies)) if k not in above]
    index = {-1: -1} | {k: i for i, k in enumerate(kept)}
    index |= {model.bodies[k].parent: index[k] for k in gone}
    behind = {model.bodies[k].parent: model.bodies[k].joint.placement for k in gone}

    def seen(body: int, placement: Placement) -> Placement:
        """A placement in a body's frame as one in the frame of the body that it now is."""
        if body not in behind or not behind[body].steps:
            return placement
        R, p = behind[body].arrays(model.dim)
        return rotate(R.T, model.name).then(shift(*(-p).tolist())).then(placement)

    bodies = []
    for k in kept:
        body = model.bodies[k]
        if k in gone:
            rotor = model.bodies[body.parent]
            placement = rotor.joint.placement.then(body.joint.placement)
            axis, child = body.joint.axis, body.joint.child
            joint = replace(rotor.joint, placement=placement, axis=axis, child=child)
            light = (
                replace(part, placement=seen(body.parent, part.placement))
                for part in rotor.inertias
            )
            inertias = (*light, *body.inertias)
            body = replace(body, joint=joint, parent=rotor.parent, inertias=inertias)
        bodies.append(replace(body, parent=index[body.parent]))
    frames = tuple(
        replace(x, body=index[x.body], placement=seen(x.body, x.placement)) for x in model.frames
    )
    twists = {model.bodies[k].joint.name for k in gone}
    home = tuple((name, x) for name, x in model.home if name not in twists)
    rigid = replace(model, bodies=tuple(bodies), frames=frames, home=home)
    return rigid, {index[k]: model.bodies[k] for k in gone}


# ------------------------------------------------------------ states of both
@dataclass(frozen=True, eq=False)
class Untwisted:
    """A robot with flexible joints whose shafts do not twist.

    model: the robot with rigid joints. positions, rates: which entries of the flexible robot's q
    and q̇ its own are. twists: of each shaft (entry of the flexible robot's q, of its q̇, and of the
    rigid robot's q and q̇ to which the twist adds).
    """

    model: Model
    positions: NDArray[np.intp]
    rates: NDArray[np.intp]
    twists: tuple[tuple[int, int, int, int], ...]

    def links(self, q: Array) -> Array:
        """The rigid robot's positions (..., nq) with its links where the flexible one's are at q
        (..., nq)."""
        found = q[..., self.positions]
        for at, _, to, _ in self.twists:
            found[..., to] += q[..., at]
        return found

    def link_rates(self, qd: Array) -> Array:
        """The rigid robot's rates (..., nv) with which its links move as the flexible one's at qd
        (..., nv)."""
        found = qd[..., self.rates]
        for _, at, _, to in self.twists:
            found[..., to] += qd[..., at]
        return found

    def at(self, q: Array) -> Array:
        """The flexible robot's positions (..., nq), untwisted, from the rigid one's."""
        return _spread(q, self.positions, len(self.twists))

    def at_rates(self, qd: Array) -> Array:
        """The flexible robot's rates (..., nv), without twisting, from the rigid one's."""
        return _spread(qd, self.rates, len(self.twists))


def _spread(x: Array, places: NDArray[np.intp], more: int) -> Array:
    """x (..., n) at places of an array (..., n + more), which is 0 elsewhere."""
    found = np.zeros((*x.shape[:-1], len(places) + more))
    found[..., places] = x
    return found


@fact
def untwisted(model: Model) -> Untwisted | None:
    """The robot with rigid joints, and how its states follow from the model's; None where no joint
    is flexible."""
    gone = shafts(model)
    if not gone:
        return None
    rigid = one_family(_made_rigid(model, gone)[0], model)  # with the rotors' frames
    own = {model.bodies[k].joint.name: model.coordinates[k] for k in gone}
    names = dict.fromkeys(own)

    def left(count: int, entries: Mapping[str, int]) -> NDArray[np.intp]:
        return np.setdiff1d(np.arange(count), [entries[name] for name in names])

    q, v = ({name: x.q[0] for name, x in own.items()}, {name: x.v[0] for name, x in own.items()})
    at = {body.joint.name: x for body, x in zip(rigid.bodies, rigid.coordinates, strict=True)}
    rotors = {
        model.bodies[k].joint.name: model.bodies[model.bodies[k].parent].joint.name for k in gone
    }
    twists = tuple(
        (q[name], v[name], at[rotors[name]].q[0], at[rotors[name]].v[0]) for name in names
    )
    return Untwisted(rigid, left(model.nq, q), left(model.nv, v), twists)


def shaft_entries(model: Model) -> tuple[int, ...]:
    """The entries of q̇ that are twists of shafts."""
    found = untwisted(model)
    return () if found is None else tuple(at for _, at, _, _ in found.twists)


def shaft_names(model: Model) -> tuple[str, ...]:
    """Names of the shafts of flexible joints, which are those of their twists as positions and
    rates."""
    return tuple(model.bodies[k].joint.name for k in shafts(model))
