"""`load`: a model from a file or from the data that comes with the package."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path

from freebody.errors import FileError, FreebodyError, MassWarning, UnknownNameError, shown, warn
from freebody.formats import dh_csv, read_file, toml, urdf
from freebody.formats.masses import estimated, implausible_masses
from freebody.formats.urdf_elements import xacro
from freebody.model import planar_arms
from freebody.model.build import BasePolicy, MimicPolicy, Policy, build_model
from freebody.model.description import RobotDescription
from freebody.model.dh import Convention
from freebody.model.doubts import Doubt
from freebody.model.model import Model
from freebody.model.parameters import real

_NOT_READ = {
    ".xacro": "xacro is not read directly; {xacro}, and load that.",
    ".xml": "MJCF and other XML are not read; export the robot as URDF, "
    "or describe it in freebody's TOML.",
    ".sdf": "SDF is not read; convert it to URDF, or describe the robot in freebody's TOML.",
}
SUFFIXES = (".urdf", ".toml", ".csv")
_BARE = "files without suffix"


def load(
    source: str | os.PathLike[str],
    *,
    tip: str | None = None,
    base: BasePolicy | None = None,
    mimic: MimicPolicy = "follow",
    physical: Policy = "warn",
    snap_angles: float = 3e-9,
    convention: Convention | None = None,
    estimate_inertia: float | None = None,
    loop_tolerance: tuple[float, float] | None = None,
) -> Model:
    """A model from a .urdf, .toml or .csv (DH table) file, or a bundled model by its name (see
    `models()`).

    Letters R and P that are not a bundled model's name are a planar arm: load("RRP") is
    planar("RRP"). A file is a regular one of at most 32 MB (TOML: 16) and 50 000 links, and no
    number in it but a limit is beyond 1e60.

    Parameters
    ----------
    source
        Path of a file, or the name of a bundled model.
    tip
        The frame that `frame=None` means; default: the file's, else the only one that is called
        tcp, tool0, flange, ee… or grasp…, in this order, else the end of the longest chain of
        joints, grippers taken off, where only one is so long; `tip_reason` says which.
    base
        "fixed" or "free" (a free joint carries the root link); default: the file's, else fixed.
    mimic
        "follow", or "free" to make mimic joints independent.
    physical
        "warn" about, "refuse" or "ignore" an inertia that no rigid body has, and friction, rotors
        and gears that no motor has; the numbers are never changed.
    snap_angles
        URDF angles (rad) this close to a multiple of π/2 are read as that multiple; 0 reads them as
        written.
    convention
        "standard" or "modified", for a DH table that does not state it.
    estimate_inertia
        The robot's whole mass (kg): all inertias of a URDF are replaced by estimates from the
        shapes in the file, filled evenly at one density; meshes need the extra freebody[mesh].
        Marked as estimated wherever shown.
    loop_tolerance
        (m, rad) by which rounded numbers may keep loops from closing, see `Model.with_loop`;
        default: the file's, else 1 mm or a thousandth of the loop's size, the smaller, and 1 mrad.

    Returns
    -------
    Model
        Its `notices` list what was snapped, ignored or doubtful.

    Raises
    ------
    FileError
        What cannot be read, with file and line.
    FreebodyError
        A name that is not known, or an option that does not fit.

    Warns
    -----
    MassWarning
        Masses of a URDF that are missing, placeholders or implausible.
    """
    description = read(source, snap_angles=snap_angles, convention=convention)
    if estimate_inertia is not None:
        description = _estimated(description, estimate_inertia)
    chosen = base or description.base
    model = build_model(description, physical=physical, mimic=mimic, base=chosen, tip=tip)
    if loop_tolerance is not None:
        model = model.replace(loop_tolerance=loop_tolerance)
    return _weighed(model, description, estimate_inertia is not None, physical != "ignore")


def _estimated(description: RobotDescription, mass: float) -> RobotDescription:
    if not description.real:
        raise FreebodyError(
            f"load: estimate_inertia= needs the shapes of a URDF, and {description.name!r} comes "
            f"from none; give masses in its file."
        )
    return estimated(description, mass)


def _weighed(model: Model, description: RobotDescription, estimate: bool, warned: bool) -> Model:
    """The model with doubts on its masses, where they are to be those of a machine."""
    if description.real:
        found = implausible_masses(
            model, {link.name: link.shapes for link in description.links}, estimate
        )
        model = replace(model, notices=(*model.notices, *found)) if found else model
    model = settled(model)
    for doubt in model.notices if warned else ():
        if isinstance(doubt, Doubt) and doubt.of.mend:
            warn(f"warning: {doubt}", MassWarning)
    return model


def settled(model: Model) -> Model:
    """The model as it was read, its file's doubts tied to the numbers that they are about: to all
    of their sort, where the file names no links."""
    if model.missing:
        return model
    notices = tuple(
        replace(x, about=x.of.tied(model))
        if isinstance(x, Doubt) and not x.about and x.of.tied
        else x
        for x in model.notices
    )
    return replace(model, notices=notices) if notices != model.notices else model


def read(
    source: str | os.PathLike[str],
    *,
    snap_angles: float = 3e-9,
    convention: Convention | None = None,
) -> RobotDescription:
    """The description in a file or of a bundled model, before it is checked and lumped; see
    `load`."""
    if not 0.0 <= real(snap_angles, "load: snap_angles") < 0.1:
        raise FreebodyError(
            f"load: snap_angles is {snap_angles}, expected radians between 0 and 0.1."
        )
    given = _path(source)
    path = Path(given)
    if convention is not None and path.suffix.lower() != ".csv":
        raise FreebodyError(
            f"load: convention= is for DH tables in .csv files, which do not always state it; "
            f"leave it out for {given!r}."
        )
    if not path.suffix and os.sep not in given and "/" not in given:
        return _named(given)
    suffix = path.suffix.lower()
    if suffix in _NOT_READ:
        advice = xacro(path.name, path.stem.removesuffix(".urdf"))
        raise FileError(path, None, _NOT_READ[suffix].format(xacro=advice))
    if suffix not in SUFFIXES and not path.is_dir():
        raise FileError(
            path, None, f"freebody does not know {suffix or _BARE}; it reads {', '.join(SUFFIXES)}."
        )
    data = read_file.read(path)
    if suffix == ".urdf":
        return urdf.describe(given, data, name=path.stem, snap_angles=snap_angles)
    text = read_file.decoded(given, data)
    if suffix == ".csv":
        return dh_csv.describe(given, text, name=path.stem, convention=convention)
    return toml.describe(given, text, name=path.stem)


def _path(source: object) -> str:
    """The path or name as text; refuses a description itself."""
    if not isinstance(source, str | os.PathLike) or isinstance(given := os.fspath(source), bytes):
        raise FreebodyError(
            f"load: expected a path or a model's name, not {type(source).__name__}."
        )
    if given.lstrip().startswith("<") or "\n" in given:
        kind = ".urdf" if given.lstrip().startswith("<") else ".toml or .csv"
        raise FreebodyError(
            f"load: {shown(given)} is the text of a description, not a path; write it to a {kind} "
            f"file and load that: its lines are what errors refer to."
        )
    return given


def _named(name: str) -> RobotDescription:
    """A bundled model; of another name that is all R and P, the planar arm of these joints."""
    names = read_file.bundled_names()
    if name in names:
        return toml.describe(f"{name}.toml", read_file.bundled_text(name), name=name)
    if name and not set(name) - set("RP"):
        return planar_arms.describe(name)
    if name == "-":
        raise FreebodyError(
            "load: a robot is not read from standard input, where no suffix tells its format; save "
            "it in a file."
        )
    if Path(name).exists():
        kind = "folder" if Path(name).is_dir() else "file"
        raise FreebodyError(
            f"load: {name!r} is not a bundled model. The {kind} of that name needs a suffix that "
            f"tells its format: {', '.join(SUFFIXES)}."
        )
    problem = UnknownNameError("model", name, "the bundled models", names)
    raise FreebodyError(f"load: {problem} A file needs its suffix: {', '.join(SUFFIXES)}.")
