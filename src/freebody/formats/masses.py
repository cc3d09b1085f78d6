"""Masses in a file: doubts on those that cannot be the robot's, and estimates from its shapes.

The bars of the doubts are wide: they are to find what is wrong, not what is unusual. All are about
bodies that move.

- Missing: a body without mass and inertia, where its links have shapes or where nothing that it
  carries has mass either (a body in between that has neither shape nor mass is how several freedoms
  are put into one place).
- Placeholder: the same numbers for links that carry one another, round and alike about all axes; or
  the same, however written, for three such links of different length. Links beside each other
  (legs, fingers) may well be alike.
- Implausible, of all that is fixed together: a radius of gyration, or a centre of mass, far outside
  it, or a radius far too small; a density above that of any metal, below that of any foam, where
  all shapes are boxes, cylinders, spheres.

A file may itself give links the inertia of their shapes, as MJCF does: nothing of that is doubted.

An estimate fills links evenly, at the one density that gives the stated mass. Collision shapes
count where a link has any, else the visual ones; what several share counts twice. A link without
shapes gets no mass. Every inertia of the file is replaced: part measured, part estimated would tell
less.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from freebody.arrays import Array
from freebody.errors import FileError, FreebodyError, MissingPackageError, listed
from freebody.formats.meshes import FORMATS, opened
from freebody.formats.packages import Packages
from freebody.formats.read_file import contents
from freebody.model.bodies import Body
from freebody.model.description import Link, RobotDescription
from freebody.model.doubt_rules.inertias import is_bare, weighs
from freebody.model.doubts import ESTIMATED, IMPLAUSIBLE, NO_MASSES, Doubt
from freebody.model.inertia import Inertia, combined
from freebody.model.model import Model
from freebody.model.placement import Placement
from freebody.model.quantity_reader import VALUES
from freebody.model.shapes import DENSEST, LIGHTEST, Shape
from freebody.spatial import of_dimension

_WIDE, _SMALL, _FAR = 2.0, 0.01, 3.0
"""Bounds as multiples of a link's size: radius of gyration at most, at least; centre of mass."""
_FLOOR = 0.1  # of the robot's reach: the least size of a body, whatever the file shows of it
# of the moving mass: below which links that are alike, and a body, are passed over
_COUNTS, _TINY = 0.01, 0.001
_ROW, _LOOKED = 8, 64
"""Links alike in a row that suffice; bodies towards the base that are searched for them."""
_SHOWN = 12  # names in a sentence


@dataclass
class _DoubtsFound:
    """A doubt on masses: its sentence, and the links and inertias that it is about."""

    text: str
    about: list[tuple[str, Inertia | None]]
    kind: str = IMPLAUSIBLE


@dataclass(frozen=True)
class _LinkInertia:
    """The inertia of one link, and the body that it is part of."""

    name: str
    body: int
    mass: float
    tensor: np.ndarray
    inertia: Inertia


def implausible_masses(
    model: Model,
    shapes: Mapping[str, tuple[Shape, ...]],
    only_missing: bool = False,
    filled: Collection[str] = (),
) -> list[Doubt]:
    """Doubts on the masses of a model, whose links have `shapes`; model.source is the file. filled:
    names of links whose inertia is that of their shapes, about which there is no doubt."""
    missing = _missing(model, shapes)
    found: list[_DoubtsFound] = []
    if missing:
        several = len(missing) > 1
        text = (
            f"{len(missing)} of {len(model.bodies)} moving bodies {'have' if several else 'has'} "
            f"no mass: {listed(missing, _SHOWN)}"
        )
        found.append(_DoubtsFound(text, [(name, None) for name in missing], NO_MASSES))
    if not only_missing:
        sizes = _sizes(model, shapes)
        found += _placeholders(model, sizes, filled)
        found += _implausible(model, shapes, sizes, filled)
    if found and any(shapes.values()) and not only_missing:
        found[-1].text += (
            " (--estimate-inertia MASS, in Python estimate_inertia=, estimates from the shapes in "
            "the file)"
        )
    file = model.source or None
    return [Doubt(x.kind, f"{x.text}.", file, about=tuple(x.about)) for x in found]


# ------------------------------------------------------------ missing
def _missing(model: Model, shapes: Mapping[str, tuple[Shape, ...]]) -> list[str]:
    """Names of the moving bodies that have no mass although they should."""
    bare = list(map(is_bare, model.bodies))
    carries = [False] * len(bare)
    for k, empty in enumerate(bare):
        i = k
        while not empty and i >= 0 and not carries[i]:
            carries[i] = True
            i = model.bodies[i].parent
    shaped = {frame.body for frame in model.frames if shapes.get(frame.name)}
    return [
        body.name
        for i, body in enumerate(model.bodies)
        if bare[i] and (i in shaped or not carries[i])
    ]


# ------------------------------------------------------------ sizes
def _sizes(model: Model, shapes: Mapping[str, tuple[Shape, ...]]) -> list[float]:
    """How far each body reaches from its joint (m), judged by the joints and frames that it carries
    and by its shapes."""
    space = of_dimension(model.dim)
    reach = [0.0] * len(model.bodies)

    def counted(i: int, placement: Placement, more: float = 0.0) -> None:
        if i >= 0:
            _, p = placement.lower(space, VALUES)
            reach[i] = max(reach[i], math.hypot(*p) + more)

    for body in model.bodies:
        counted(body.parent, body.joint.placement)
    for frame in model.frames:
        counted(frame.body, frame.placement)
        for shape in shapes.get(frame.name, ()):
            counted(frame.body, frame.placement.then(shape.placement), shape.radius)
    return reach


# ------------------------------------------------------------ placeholders
def _links(model: Model) -> Iterator[_LinkInertia]:
    """The inertias of the links that move and have mass."""
    for i, body in enumerate(model.bodies):
        for part in body.inertias:
            mass, _, tensor = part.inertia.numbers()
            if mass > 0.0:
                yield _LinkInertia(part.link, i, mass, tensor, part.inertia)


def _placeholders(
    model: Model, own: Sequence[float], filled: Collection[str]
) -> Iterator[_DoubtsFound]:
    links = list(_links(model))
    whole = sum(link.mass for link in links)
    alike: dict[tuple[float, ...], list[_LinkInertia]] = {}
    for link in links:
        if link.name in filled:
            continue
        alike.setdefault((link.mass, *link.tensor.ravel()), []).append(link)
    for group in alike.values():
        if len(group) < 2 or sum(link.mass for link in group) < _COUNTS * whole:
            continue
        by_body: dict[int, list[_LinkInertia]] = {}
        for link in group:
            by_body.setdefault(link.body, []).append(link)
        row = max((_above(model, link, by_body) for link in group), key=len)
        sizes = [own[link.body] for link in row]
        differ = len(row) > 2 and max(sizes) > 1.1 * min(sizes)
        if (len(row) > 1 and _is_plain(row[0])) or differ:
            mass, inertia = row[0].mass, float(row[0].tensor[0, 0])
            yield _DoubtsFound(
                f"{len(group)} links have the same placeholder inertia ({mass:g} kg, {inertia:g} "
                f"kg m²): {listed([link.name for link in group], _SHOWN)}",
                [(link.name, link.inertia) for link in group],
            )


def _above(
    model: Model, link: _LinkInertia, by_body: Mapping[int, Sequence[_LinkInertia]]
) -> list[_LinkInertia]:
    """The links of a group on the way from a link to the base, the link's own body first; at most a
    few, which suffice."""
    found: list[_LinkInertia] = []
    i = link.body
    for _ in range(_LOOKED):
        if i < 0 or len(found) == _ROW:
            break
        found += by_body.get(i, [])[:1]
        i = model.bodies[i].parent
    return found


def _is_plain(link: _LinkInertia) -> bool:
    """Whether a link's numbers look made up: round, and with equal inertia about all axes."""
    diagonal = np.diag(link.tensor)
    alike = bool((link.tensor == np.diag(diagonal)).all() and (diagonal == diagonal[0]).all())
    return alike and all(float(f"{x:.2g}") == x for x in (link.mass, float(diagonal[0])))


# ------------------------------------------------------------ implausible
def _implausible(
    model: Model,
    shapes: Mapping[str, tuple[Shape, ...]],
    own: Sequence[float],
    filled: Collection[str],
) -> Iterator[_DoubtsFound]:
    reach = sum(sorted(own)[-4:])  # the longest bodies make it
    volumes = _volumes(model, shapes)
    bodies = [_whole(body) for body in model.bodies]
    tiny = _TINY * sum(mass for mass, _, _ in bodies)
    ends = set(range(len(bodies))) - {body.parent for body in model.bodies}
    reasons: dict[str, list[tuple[Body, str]]] = {}
    for i, (mass, away, gyration) in enumerate(bodies):
        told = all(part.link in filled for part in model.bodies[i].inertias)
        if mass <= tiny or reach == 0.0 or told:
            continue
        least = (
            reach if i in ends else _FLOOR * reach
        )  # an end may be a long tool that only a mesh shows
        for reason, value in _faults(
            mass, away, gyration, own[i], least, _FLOOR * reach, volumes[i]
        ):
            reasons.setdefault(reason, []).append((model.bodies[i], value))
    for reason, bodies_found in reasons.items():
        names = [f"{body.name} ({value})" for body, value in bodies_found]
        yield _DoubtsFound(
            f"{reason}: {listed(names, _SHOWN)}",
            [(part.link, part.inertia) for body, _ in bodies_found for part in body.inertias],
        )


def _whole(body: Body) -> tuple[float, float, float]:
    """The mass of a body (kg), the distance of its centre from the joint (m), and its largest
    radius of gyration (m), all parts fixed to it included; zeros where masses are not positive."""
    parts = [part for part in body.inertias if weighs(part)]
    if not parts or any(VALUES.quantity(part.inertia.mass) <= 0.0 for part in parts):
        return 0.0, 0.0, 0.0
    placed = (part.inertia.placed(*part.placement.lower(of_dimension(3), VALUES)) for part in parts)
    mass, com, tensor = combined(list(placed)).numbers()
    if body.parent < 0 and body.kind.turns:  # nothing else of it is ever felt
        largest = max(float(np.array(body.joint.axis) @ tensor @ np.array(body.joint.axis)), 0.0)
    else:
        largest = max(float(np.linalg.eigvalsh(tensor).max()), 0.0)
    return mass, math.hypot(*com), math.sqrt(largest / mass)


def _faults(
    mass: float, away: float, gyration: float, own: float, least: float, floor: float, volume: float
) -> Iterator[tuple[str, str]]:
    size = max(own, away, floor)
    if gyration > _WIDE * size:
        yield (
            "inertia far too large for the body",
            f"radius of gyration {gyration:.2g} m, its size {size:.2g} m",
        )
    elif gyration < _SMALL * own:
        yield (
            "inertia far too small for the body",
            f"radius of gyration {gyration:.2g} m, its size {own:.2g} m",
        )
    if away > _FAR * max(own, least):
        yield (
            "centre of mass far outside the body",
            f"{away:.2g} m from its joint, its size {max(own, floor):.2g} m",
        )
    if volume > 0.0 and not LIGHTEST <= mass / volume <= DENSEST:
        yield "mass that does not fit the shape", f"{mass:.3g} kg in {1e3 * volume:.3g} litres"


def _volumes(model: Model, shapes: Mapping[str, tuple[Shape, ...]]) -> list[float]:
    """The volume of each body's shapes (m³), visual or collision, whichever is larger; 0 where
    there are none or where they are meshes, which are not opened."""
    filled = {role: [0.0] * len(model.bodies) for role in ("collision", "visual")}
    for frame in model.frames:
        for shape in shapes.get(frame.name, ()):
            if frame.body >= 0:
                filled[shape.role][frame.body] += shape.volume  # NaN stays
    pairs = zip(*filled.values(), strict=True)
    return [0.0 if math.isnan(a + b) else max(a, b) for a, b in pairs]


_LARGEST = 512 * 2**20  # bytes of a mesh
_FLAT = 1e-9  # thickness of corners, of their extent, below which they lie in a plane


def estimated(description: RobotDescription, mass: float, packages: Packages) -> RobotDescription:
    """The description, its inertias replaced by estimates that weigh `mass` (kg) together, the base
    included.

    Raises FreebodyError for a mass that is none, FileError where no link has a shape, or a mesh
    cannot be read.
    """
    if isinstance(mass, bool) or not math.isfinite(mass) or mass <= 0:
        raise FreebodyError(
            f"load: estimate_inertia is {mass}, expected the robot's whole mass, kg above 0."
        )
    file = description.file or description.name
    filled = {link.name: filled_shapes(link, file, packages) for link in description.links}
    volume = sum(inertia.numbers()[0] for inertia in filled.values() if inertia)
    if not volume:
        raise FileError(
            file,
            None,
            "no link has a shape that fills a volume, so there is nothing to estimate inertias "
            "from.",
        )
    density = mass / volume
    links = tuple(
        replace(link, inertia=_scaled(filled[link.name], density), placement=Placement())
        for link in description.links
    )
    return replace(
        description,
        links=links,
        notices=(*description.notices, *_estimate_doubts(description, filled, mass, density)),
    )


def _estimate_doubts(
    description: RobotDescription, filled: dict[str, Inertia | None], mass: float, density: float
) -> Iterator[Doubt]:
    """Doubts that report what was estimated, and whether the stated total mass can be right."""
    empty = [name for name, inertia in filled.items() if inertia is None]
    without = f"; links without shapes have none: {', '.join(empty)}" if empty else ""
    text = (
        f"the inertias of {len(filled) - len(empty)} links are estimated from their shapes, "
        f"assuming a uniform density of {density:.4g} kg/m³ so that their total mass is {mass:g} "
        f"kg{without}."
    )
    yield Doubt(ESTIMATED, text, description.file)
    if not LIGHTEST <= density <= DENSEST:
        text = (
            f"{mass:g} kg is implausible for the shapes in the file, whose volume is "
            f"{1e3 * mass / density:.3g} litres."
        )
        yield Doubt(IMPLAUSIBLE, text, description.file)


def filled_shapes(link: Link, file: str, packages: Packages) -> Inertia | None:
    """The inertia of a link's shapes at density 1, in the link's frame; None where it has no
    shape."""
    collision = [shape for shape in link.shapes if shape.role == "collision"]
    parts = list(_parts(collision or link.shapes, link, file, packages))
    parts = [part for part in parts if part.numbers()[0] > 0]
    return combined(parts) if parts else None


def _parts(
    shapes: tuple[Shape, ...] | list[Shape], link: Link, file: str, packages: Packages
) -> Iterator[Inertia]:
    for shape in shapes:
        R, p = shape.placement.lower(of_dimension(3), VALUES)
        own = shape.uniform(1.0) if shape.is_solid else _mesh(shape, link, file, packages)
        yield own.placed(np.array(R, dtype=float), p)


def _scaled(inertia: Inertia | None, density: float) -> Inertia | None:
    if inertia is None:
        return None
    mass, com, tensor = inertia.numbers()
    return Inertia.of(density * mass, com.tolist(), density * 0.5 * (tensor + tensor.T))


# ------------------------------------------------------------ meshes
def _flat(corners: Array) -> bool:
    """Whether points (n, 3) lie in one plane."""
    extents = np.linalg.svd(corners - corners.mean(axis=0), compute_uv=False)
    return not extents[2] > _FLAT * extents[0]


def _mesh(shape: Shape, link: Link, file: str, packages: Packages) -> Inertia:
    """The inertia of a mesh at density 1: of the volume that it encloses, or of its convex hull
    where it has holes."""
    if shape.kind == "hull":
        raise FileError(
            file,
            shape.line,
            f"link {link.name!r}: of its mesh the outermost points alone are known, from which no "
            f'inertia is estimated; MuJoCo does it where the file says inertiafromgeom="true".',
        )
    path = packages.located(shape.file)
    if path is None:
        raise FileError(
            file,
            shape.line,
            f"link {link.name!r}: its mesh {shape.file!r} was not found beside the file or above "
            f"it; package_path= names folders of packages.",
        )
    if path.suffix.lower() not in FORMATS:
        raise FileError(
            file,
            shape.line,
            f"link {link.name!r}: its mesh {path.name!r} is not of the formats "
            f"{', '.join(FORMATS)}; convert it to one of these.",
        )
    data = contents(path, _LARGEST, "a mesh")
    try:
        mesh = opened(data, path, "load: estimating inertias from meshes")
        mesh.apply_scale(np.array(shape.size))
        corners = np.asarray(mesh.vertices, dtype=float)
        if len(corners) < 4 or _flat(corners):
            raise FileError(path, None, "its corners enclose no volume")
        if not mesh.is_watertight or mesh.volume <= 0:
            mesh = mesh.convex_hull
        found = mesh.mass_properties
        mass, tensor = float(found["mass"]), np.asarray(found["inertia"], dtype=float)
        return Inertia.of(
            mass,
            [float(x) for x in found["center_mass"]],
            0.5 * (tensor + tensor.T),
        )
    except MissingPackageError:
        raise
    except Exception as problem:  # whatever a reader of meshes raises on a broken one
        told = problem.problem if isinstance(problem, FileError) else str(problem)
        raise FileError(
            file,
            shape.line,
            f"link {link.name!r}: its mesh {path.name!r} cannot be read: "
            f"{' '.join(told.split()).rstrip('.')}.",
        ) from None
