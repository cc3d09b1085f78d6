"""Changed copies of a model: without some feature, with another load, frame or loop, as its twin in
space."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import replace
from numbers import Real
from operator import is_
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from freebody.arrays import Array
from freebody.errors import ModelError, UnknownNameError, listed, shown
from freebody.model.bodies import Body, Frame
from freebody.model.description import Loop
from freebody.model.drives import LAWS
from freebody.model.families import Members, is_array, is_nested, members, one_family
from freebody.model.inertia import Inertia, faults
from freebody.model.loop_kinds import LOOP_KINDS
from freebody.model.loops import checked_loop
from freebody.model.losses import loss_fault
from freebody.model.number_names import PAYLOAD
from freebody.model.parameter_formulas import followed
from freebody.model.parameters import (
    LARGEST,
    Quantity,
    each_parameter,
    finite,
    one_value_each,
    quantity,
    real,
)
from freebody.model.piece_paths import get, put
from freebody.model.placement import AxisRotation, Placement, Rotate, Shift, rotate, shift
from freebody.model.shafts import shafts, without_shafts
from freebody.model.strut_ends import strut_fault
from freebody.model.struts import Strut, checked_strut
from freebody.model.tree import Attached
from freebody.outputs.display import counted

if TYPE_CHECKING:
    from freebody.model.model import Model

_FEATURES = tuple(dict.fromkeys(law.feature for law in LAWS.values()))
_PARTS = ("loops", "struts", "shafts")


def without(model: Model, features: Sequence[str]) -> Model:
    """The model without some features; see `Model.without`."""
    for feature in features:
        if feature not in _FEATURES and feature not in _PARTS:
            raise UnknownNameError("feature", feature, "Model.without", (*_FEATURES, *_PARTS))
    if "shafts" in features:
        model = without_shafts(model)
    off = {k: x for law in LAWS.values() if law.feature in features for k, x in law.off.items()}
    kept = shafts(model)
    bodies = tuple(
        body
        if k in kept
        else replace(body, joint=replace(body.joint, drive=replace(body.joint.drive, **off)))
        for k, body in enumerate(model.bodies)
    )
    gone: dict[str, Any] = {part: () for part in ("loops", "struts") if part in features}
    return replace(model, bodies=bodies, **gone)


def actuated(model: Model, names: Sequence[str]) -> tuple[Body, ...]:
    """The bodies with all joints passive except those named; joints that follow others stay as they
    are."""
    names = (names,) if isinstance(names, str) else names
    free = [body.joint.name for body in model.bodies if body.joint.mimic is None]
    for name in names:
        if name not in free:
            raise UnknownNameError("joint", name, f"{model.name!r}", free)
    return tuple(
        replace(
            body,
            joint=replace(
                body.joint, passive=body.joint.name in free and body.joint.name not in names
            ),
        )
        for body in model.bodies
    )


def load(mass: Any, com: Any, box: Any, cylinder: Any, inertia: Any, dim: int) -> Inertia:
    """The inertia that the arguments of `Model.with_payload` describe."""
    if isinstance(inertia, Inertia):
        if mass is not None:
            raise ModelError(
                "with_payload: an Inertia has a mass of its own; leave out mass=, or give inertia= "
                "as its entries about the centre of mass."
            )
        mass, inertia = inertia, None
    shapes = {"box": box, "cylinder": cylinder, "inertia": inertia}
    given = [name for name, shape in shapes.items() if shape is not None]
    if isinstance(mass, Inertia):
        if given:
            raise ModelError(
                f"with_payload: an Inertia has a shape of its own; leave out {given[0]}=."
            )
        return mass if com is None else mass.moved_to(_entries(com, dim))
    if len(given) > 1:
        raise ModelError(
            f"with_payload: {listed(f'{x}=' for x in given)} exclude each other; give one."
        )
    weight = _mass(mass)
    centre = (0.0,) * dim if com is None else _entries(com, dim)
    if not given:
        return Inertia.point(weight, centre)
    if inertia is not None:
        return Inertia.of(weight, centre, inertia)
    if box is not None:
        words = "sides (a, b, c)" if dim == 3 else "sides (a, b)"
        unit = Inertia.box(1.0, _sizes("box", box, dim, words))
    else:
        radius, height = _sizes("cylinder", cylinder, 2, "radius and height (r, h)")
        unit = Inertia.cylinder(1.0, radius, height) if dim == 3 else Inertia.disc(1.0, radius, 2)
    return Inertia(weight, centre, tuple(_times(weight, x) for x in unit.tensor))


def _sizes(name: str, given: Any, count: int, words: str) -> list[float]:
    """The lengths of a load's shape (m), checked."""
    found = np.asarray(given, dtype=object)
    if found.shape != (count,):
        raise ModelError(f"with_payload: {name} is {shown(given)}, expected its {words} in m.")
    sizes = [finite(x, f"with_payload: {name}") for x in found.tolist()]
    if min(sizes) < 0.0:
        raise ModelError(f"with_payload: {name} is {shown(given)}; no length is negative.")
    return sizes


def _times(mass: float | Members, entry: Quantity) -> float | Members:
    """An entry of a load's inertia from that for one kilogram."""
    x = cast(float, entry)
    if x == 0.0:
        return 0.0
    return Members(mass.array * x) if isinstance(mass, Members) else mass * x


def _mass(mass: Any) -> float | Members:
    """A load's mass (kg), or the masses for the members of a family."""
    if isinstance(mass, np.ndarray) and not mass.ndim:
        mass = mass[()]
    if isinstance(mass, (float, int, Real, np.bool_)):
        return real(mass, "with_payload: mass")
    if is_array(mass):
        return members(mass, "with_payload: mass", LARGEST)
    raise ModelError(
        "with_payload: give a mass (kg), perhaps with com= and box=, cylinder= or inertia=; or an "
        "Inertia."
    )


def _entries(com: Any, dim: int) -> tuple[Quantity, ...]:
    """The entries of a centre of mass, given as an array (..., dim) or as dim entries, some of
    which may be arrays over the members."""
    if is_nested(com):  # a list of centres is what its array is
        centres = members(com, "with_payload: com", LARGEST).array
        if centres.shape[-1] != dim:
            raise ModelError(f"with_payload: com has shape {centres.shape}, expected (..., {dim}).")
        return tuple(Members(centres[..., k]) for k in range(dim))
    if (not isinstance(com, Sequence) and np.ndim(com) == 0) or len(com) != dim:
        raise ModelError(
            f"with_payload: com is {shown(com)}, expected {dim} entries, or an array (..., {dim})."
        )
    return tuple(members(x, "with_payload: com", LARGEST) if is_array(x) else x for x in com)


def with_drive(model: Model, joint: str, given: Mapping[str, Any]) -> Model:
    """The model with another drive in a joint; see `Model.with_drive`."""
    free = [body.joint.name for body in model.bodies if body.kind.nv == 1]
    if joint not in free:
        raise UnknownNameError("one-coordinate joint", joint, f"{model.name!r}", free)
    k = model.joint_names.index(joint)
    body = model.bodies[k]
    numbers = {
        name: members(x, f"with_drive: {name}", LARGEST)
        if is_array(x)
        else quantity(x, f"with_drive: {name}")
        for name, x in given.items()
    }
    drive = replace(body.joint.drive, **numbers)
    fault = drive.idle(given) or drive.fault()
    if fault:
        raise ModelError(f"with_drive: joint {joint!r}: {fault}.")
    driven = replace(body, joint=replace(body.joint, drive=drive))
    result = with_symbols_known(put(model, ("bodies", k), driven), *numbers.values())
    if problem := loss_fault(result.bodies, result.loops):
        raise ModelError(f"with_drive: {problem}.")
    return one_family(result, model, *numbers.values())


def with_symbols_known(changed: Model, *new: Any) -> Model:
    """The changed model in which new parts take the values that their names have elsewhere in it;
    refuses names with two values."""
    if not any(each_parameter(new)):  # most are numbers
        return changed
    known = one_value_each(changed, repr(changed.name))
    return followed(known) if known.formulas else known


def with_payload(model: Model, inertia: Inertia, frame: str | None, name: str) -> Model:
    """The model with a rigid load on a frame; see `Model.with_payload`."""
    at = model.frame(frame)
    added = attached(inertia, at.placement, name, at.name, model.dim, model.name)
    path = ("base_inertias",) if at.body < 0 else ("bodies", at.body, "inertias")
    result = with_symbols_known(put(model, path, (*get(model, path), added)), inertia)
    return one_family(result, model, inertia)


def without_idle_payload(model: Model) -> Model:
    """The model without an empty payload at the tip, whose numbers are all zero and which has no
    effect."""
    nothing = Inertia.nothing(model.dim)

    def kept(parts: tuple[Attached, ...]) -> tuple[Attached, ...]:
        left = tuple(
            part
            for part in parts
            if not (part.load and part.link == PAYLOAD and part.inertia == nothing)
            or part.frame != model.tip
        )
        return parts if len(left) == len(parts) else left

    bodies = tuple(
        body if (left := kept(body.inertias)) is body.inertias else replace(body, inertias=left)
        for body in model.bodies
    )
    base = kept(model.base_inertias)
    if base is model.base_inertias and all(map(is_, bodies, model.bodies)):
        return model
    return replace(model, bodies=bodies, base_inertias=base)


def attached(
    inertia: Inertia, placement: Placement, name: str, frame: str, dim: int, owner: str
) -> Attached:
    """A load fixed to a frame, at its place in a body; refuses inertias that no rigid body has."""
    if inertia.dim != dim:
        raise ModelError(f"with_payload: the inertia is {inertia.dim}D but {owner!r} is {dim}D.")
    fault = faults(inertia)
    if fault:
        raise ModelError(f"with_payload: {name!r}: {fault}.")
    return Attached(name, inertia, placement, load=True, frame=frame)


def with_frame(
    model: Model,
    name: str,
    position: Sequence[float] | None,
    rotation: Sequence[Sequence[float]] | Array | None,
    frame: str | None,
    function: str,
) -> Model:
    """The model with one more frame; see `Model.with_frame`. Errors name the given function."""
    at = model.frame(frame)
    if name in model.frame_names:
        raise ModelError(
            f"{function}: {model.name!r} already has a frame {name!r}; choose another name."
        )
    placement = at.placement
    if position is not None:
        if len(position) != model.dim:
            raise ModelError(
                f"{function}: position has {counted(len(position), 'entry')}, expected {model.dim}."
            )
        placement = placement.then(shift(*(finite(x, f"{function}: position") for x in position)))
    if rotation is not None:
        if np.shape(rotation) != (model.dim, model.dim):
            raise ModelError(
                f"{function}: rotation has shape {np.shape(rotation)}, expected "
                f"{(model.dim, model.dim)}."
            )
        placement = placement.then(rotate(rotation, function))
    return replace(
        model, frames=(*model.frames, Frame(name, at.body, placement, at.name, mounted=True))
    )


def with_loop(model: Model, loop: Loop) -> Model:
    """The model with one more loop; see `Model.with_loop`."""
    body_of = {frame.name: frame.body for frame in model.frames}
    taken = (*model.reaction_names, *model.strut_names)
    loops = (*model.loops, checked_loop(model.dim, loop, body_of, taken))
    if problem := loss_fault(model.bodies, loops):
        raise ModelError(f"with_loop: {problem}.")
    return with_symbols_known(replace(model, loops=loops), loop)


def with_strut(
    model: Model, name: str, frames: tuple[str, str], numbers: Mapping[str, Any]
) -> Model:
    """The model with one more strut; see `Model.with_strut`."""
    given: dict[str, Any] = {
        key: members(x, f"with_strut: {key}", LARGEST) if is_array(x) else x
        for key, x in numbers.items()
    }
    alone = given["stiffness"] is None
    given["stiffness"] = 0.0 if alone else given["stiffness"]
    if alone and given["rest"] != 0.0:
        raise ModelError(
            f"with_strut: strut {name!r}: rest is given without stiffness, without which it has no "
            f"effect; give both."
        )
    body_of = {frame.name: frame.body for frame in model.frames}
    taken = (*model.reaction_names, *model.strut_names)
    strut = checked_strut(Strut(name, frames, **given), body_of, taken)
    result = with_symbols_known(replace(model, struts=(*model.struts, strut)), strut)
    if problem := strut_fault(result):
        raise ModelError(f"with_strut: {problem}.")
    return one_family(result, model, strut)


# ---------------------------------------------------------------- the twin in space
def in_space(model: Model) -> Model:
    """A planar model in space, its plane as the xy-plane."""
    return dataclasses.replace(
        model,
        dim=3,
        bodies=tuple(map(_body_in_space, model.bodies)),
        frames=tuple(
            replace(frame, placement=_placement_in_space(frame.placement)) for frame in model.frames
        ),
        base_inertias=tuple(map(_attached_in_space, model.base_inertias)),
        gravity_direction=(*model.gravity_direction, 0.0),
        loops=tuple(map(_loop_in_space, model.loops)),
    )


def _body_in_space(body: Body) -> Body:
    joint = replace(
        body.joint,
        placement=_placement_in_space(body.joint.placement),
        axis=body.kind.axis_in_space(body.joint.axis),
    )
    return replace(body, joint=joint, inertias=tuple(map(_attached_in_space, body.inertias)))


def _loop_in_space(loop: Loop) -> Loop:
    """A planar loop in space: a revolute loop stays revolute about z, a kind that exists in the
    plane only becomes its counterpart in space."""
    kind = LOOP_KINDS[loop.kind]
    if 3 not in kind.dimensions:
        return replace(loop, kind=kind.elsewhere)
    return replace(loop, axis=kind.axis_in_space(loop.axis))


def _placement_in_space(placement: Placement) -> Placement:
    return Placement(tuple(map(_step_in_space, placement.steps)))


def _step_in_space(step: Shift | AxisRotation | Rotate) -> Shift | AxisRotation | Rotate:
    if isinstance(step, Shift):
        return Shift((*step.by, 0.0))
    if isinstance(step, Rotate):
        return Rotate((*((*row, 0.0) for row in step.matrix), (0.0, 0.0, 1.0)))
    return step


def _attached_in_space(part: Attached) -> Attached:
    (zz,) = part.inertia.tensor
    inertia = Inertia(part.inertia.mass, (*part.inertia.com, 0.0), (0.0, 0.0, 0.0, 0.0, 0.0, zz))
    return replace(part, inertia=inertia, placement=_placement_in_space(part.placement))
