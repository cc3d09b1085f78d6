"""Inertias estimated from the shapes in a file: links filled evenly, at the one density that gives
the stated mass.

Collision shapes count where a link has any, else the visual ones; what several share counts twice.
A link without shapes gets no mass. Every inertia of the file is replaced: part measured, part
estimated would tell less.
"""

from __future__ import annotations

import io
import math
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from freebody.errors import FileError, FreebodyError, MissingPackageError
from freebody.formats.read_file import contents
from freebody.model.description import Link, RobotDescription
from freebody.model.doubts import ESTIMATED, IMPLAUSIBLE, Doubt
from freebody.model.inertia import Inertia, combined
from freebody.model.placement import Placement
from freebody.model.quantity_reader import VALUES
from freebody.model.shapes import DENSEST, LIGHTEST, Shape
from freebody.spatial import of_dimension

_LARGEST = 512 * 2**20  # bytes of a mesh
_MESHES = (".stl", ".obj", ".ply", ".dae")
"""What is read: formats of shapes alone, no archives and no scenes that name further files."""


def estimated(description: RobotDescription, mass: float) -> RobotDescription:
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
    filled = {link.name: _filled(link, file) for link in description.links}
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
        notices=(*description.notices, *_told(description, filled, mass, density)),
    )


def _told(
    description: RobotDescription, filled: dict[str, Inertia | None], mass: float, density: float
) -> Iterator[Doubt]:
    """What was done, and whether the stated mass can be right."""
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


def _filled(link: Link, file: str) -> Inertia | None:
    """The link at density 1, in its frame; None where it has no shape."""
    collision = [shape for shape in link.shapes if shape.role == "collision"]
    parts = list(_parts(collision or link.shapes, link, file))
    parts = [part for part in parts if part.numbers()[0] > 0]
    return combined(parts) if parts else None


def _parts(shapes: tuple[Shape, ...] | list[Shape], link: Link, file: str) -> Iterator[Inertia]:
    for shape in shapes:
        R, p = shape.placement.lower(of_dimension(3), VALUES)
        own = _mesh(shape, link, file) if shape.kind == "mesh" else shape.uniform(1.0)
        yield own.placed(np.array(R, dtype=float), p)


def _scaled(inertia: Inertia | None, density: float) -> Inertia | None:
    if inertia is None:
        return None
    mass, com, tensor = inertia.numbers()
    return Inertia.of(density * mass, com.tolist(), density * 0.5 * (tensor + tensor.T))


# ------------------------------------------------------------ meshes
def _mesh(shape: Shape, link: Link, file: str) -> Inertia:
    """A mesh at density 1: what it encloses; of one with holes, what its convex hull does."""
    path = located(shape.file, Path(file).absolute().parent)
    if path is None:
        raise FileError(
            file,
            shape.line,
            f"link {link.name!r}: its mesh {shape.file!r} was not found beside the file or above "
            f"it.",
        )
    try:
        import trimesh  # an extra
    except ImportError:
        what = "load: estimating inertias from meshes"
        raise MissingPackageError(what, "trimesh", "mesh") from None
    suffix = path.suffix.lower()
    if suffix not in _MESHES:
        raise FileError(
            file,
            shape.line,
            f"link {link.name!r}: its mesh {path.name!r} is not of the formats "
            f"{', '.join(_MESHES)}; convert it to one of these.",
        )
    data = contents(path, _LARGEST, "a mesh")
    try:
        mesh: Any = trimesh.load(io.BytesIO(data), file_type=suffix[1:], force="mesh")
        mesh.apply_scale(np.array(shape.size))
        if not mesh.is_watertight or mesh.volume <= 0:
            mesh = mesh.convex_hull
        found = mesh.mass_properties
        tensor = np.asarray(found["inertia"], dtype=float)
        return Inertia.of(
            float(found["mass"]),
            [float(x) for x in found["center_mass"]],
            0.5 * (tensor + tensor.T),
        )
    except Exception as problem:  # whatever a reader of meshes raises on a broken one
        raise FileError(
            file,
            shape.line,
            f"link {link.name!r}: its mesh {path.name!r} cannot be read: "
            f"{' '.join(str(problem).split())}.",
        ) from None


def located(name: str, folder: Path) -> Path | None:
    """The file that a mesh's name means: a path from `folder` (absolute), or package://NAME/REST,
    where NAME/REST, or else REST alone, is found from `folder` or one above it, the nearest first.
    None where there is no such file."""
    scheme, colon, rest = name.partition("://")
    if not colon:
        candidates = [folder / name]
    elif scheme == "file":
        candidates = [Path(rest)]
    elif scheme in ("package", "model"):
        inside = rest.partition("/")[2]
        above = (folder, *folder.parents)
        candidates = [place / rest for place in above]
        candidates += [place / inside for place in above]  # folders of packages are often renamed
    else:
        return None
    return next((path for path in candidates if path.is_file()), None)
