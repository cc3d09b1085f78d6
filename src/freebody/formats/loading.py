"""`load`: a model from a file or from the data that comes with the package."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Literal

from freebody.errors import FileError, FreebodyError, MassWarning, UnknownNameError, shown, warn
from freebody.formats import dh_csv, read_file, toml, urdf
from freebody.formats.masses import estimated, implausible_masses
from freebody.formats.packages import Packages, packages_around
from freebody.formats.urdf_elements import parse
from freebody.model import planar_arms
from freebody.model.build import BasePolicy, MimicPolicy, Policy, build_model
from freebody.model.description import RobotDescription
from freebody.model.dh import Convention
from freebody.model.doubts import Doubt, tied
from freebody.model.model import Model
from freebody.model.parameters import real
from freebody.model.shapes import Shape

TEMPLATE = "template:"
"""Text that stands before a template's name, where a robot is named."""
_BARE = "files without suffix"


@dataclass(frozen=True)
class ReadingOptions:
    """How files of some formats are to be read; see `load`."""

    snap_angles: float = 3e-9
    convention: Convention | None = None
    package_path: tuple[str, ...] = ()
    xacro: Mapping[str, object] = field(default_factory=dict)
    xacro_environment: tuple[str, ...] = ()

    @staticmethod
    def of(
        snap_angles: float,
        convention: Convention | None,
        package_path: object,
        xacro: object,
        xacro_environment: object,
    ) -> ReadingOptions:
        """The options in the form that readers use, from those of a caller, who may give one name
        or several."""
        return ReadingOptions(
            snap_angles,
            convention,
            _listed("package_path", package_path),
            _arguments(xacro),
            _listed("xacro_environment", xacro_environment),
        )


@dataclass(frozen=True)
class _Given:
    """One description to be read: its file's name in messages, its bytes, the name for a robot that
    has none, and the packages that it can refer to."""

    file: str
    data: bytes
    name: str
    packages: Packages
    how: ReadingOptions


@dataclass(frozen=True)
class _Format:
    """A file format: its reader, and the options that it uses."""

    describe: Callable[[_Given], RobotDescription]
    uses: tuple[str, ...] = ()


def _urdf(given: _Given) -> RobotDescription:
    root = parse(given.file, given.data)
    return urdf.describe(root, given.file, name=given.name, snap_angles=given.how.snap_angles)


def _xacro(given: _Given) -> RobotDescription:
    # its reader, like those of SDF and MJCF, is imported for its files alone: half of all readers
    from freebody.formats.xacro.expand import expanded, without_links

    how, file = given.how, given.file
    found = expanded(file, given.data, given.packages, how.xacro, how.xacro_environment)
    if not found.root.all("link"):
        raise FileError(file, None, without_links(found))
    name = given.name.removesuffix(".urdf")
    described = urdf.describe(found.root, file, name=name, snap_angles=how.snap_angles)
    return replace(described, notices=(*found.notices, *described.notices))


def _sdf(given: _Given) -> RobotDescription:
    from freebody.formats import sdf, sdf_nested

    root = parse(given.file, given.data, sdf_nested.TEXT)
    snap = given.how.snap_angles
    return sdf.describe(root, given.file, given.packages, name=given.name, snap_angles=snap)


def _xml(given: _Given) -> RobotDescription:
    """The description in an XML file, which may be MJCF or a URDF called .xml."""
    root = parse(given.file, given.data)
    if root.tag == "robot":
        return _urdf(given)
    if root.tag != "mujoco":
        raise FileError(
            given.file,
            root.line,
            f"the root element is <{root.tag}>, expected <mujoco> or <robot>"
            f"{urdf.other_format(root.tag)}.",
        )
    if not root.all("worldbody") and not root.all("include"):
        raise FileError(
            given.file,
            root.line,
            "there is no <worldbody>: the file is a part that others include; load one that does.",
        )
    from freebody.formats.mjcf import reader as mjcf

    _used(given.how, (), given.file)  # MuJoCo finds its files by itself
    on_disk = given.packages.folder is not None
    return mjcf.describe(given.file, on_disk, given.data, given.name)


def _toml(given: _Given) -> RobotDescription:
    return toml.describe(given.file, read_file.decoded(given.file, given.data), name=given.name)


def _csv(given: _Given) -> RobotDescription:
    text = read_file.decoded(given.file, given.data)
    return dh_csv.describe(given.file, text, name=given.name, convention=given.how.convention)


_FORMATS = {
    ".urdf": _Format(_urdf, ("package_path",)),
    ".xacro": _Format(_xacro, ("package_path", "xacro", "xacro_environment")),
    ".xml": _Format(_xml, ("package_path",)),
    ".mjcf": _Format(_xml),
    ".sdf": _Format(_sdf, ("package_path",)),
    ".toml": _Format(_toml),
    ".csv": _Format(_csv, ("convention",)),
}
SUFFIXES = tuple(_FORMATS)
_PURPOSES = {
    "convention": "DH tables in .csv files, which do not always state it",
    "package_path": "URDF, xacro and SDF files, which name packages",
    "xacro": "xacro files, which have arguments",
    "xacro_environment": "xacro files, which can ask for variables",
}
"""Options that are refused where nothing uses them, and whose they are."""


def load(
    source: str | os.PathLike[str] | None = None,
    *,
    text: str | None = None,
    format: Literal["urdf", "xacro", "mjcf", "sdf", "toml", "csv"] | None = None,  # noqa: A002
    tip: str | None = None,
    base: BasePolicy | None = None,
    mimic: MimicPolicy = "follow",
    physical: Policy = "warn",
    snap_angles: float = 3e-9,
    convention: Convention | None = None,
    estimate_inertia: float | None = None,
    loop_tolerance: tuple[float, float] | None = None,
    package_path: Sequence[str | os.PathLike[str]] | str | os.PathLike[str] = (),
    xacro: Mapping[str, object] | None = None,
    xacro_environment: Sequence[str] | str = (),
) -> Model:
    """A model from a .urdf, .xacro, .xml (MJCF), .sdf, .toml or .csv (DH table) file, from such
    text, or a bundled model by its name (see `models()`).

    Letters R and P that are not a bundled model's name are a planar arm: load("RRP") is
    planar("RRP"); "template:delta" is the robot template of that name, see `template`. A file is a
    regular one of at most 32 MB (TOML: 16) and 50 000 links, and no number in it but a limit is
    beyond 1e60.

    Parameters
    ----------
    source
        Path of a file, or the name of a bundled model.
    text, format
        In place of a source: a description as text, and its format, "urdf", "xacro", "mjcf",
        "sdf", "toml" or "csv". Errors count the text's lines.
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
    package_path
        Folders of ROS packages that a xacro or SDF file includes, or that hold meshes. Packages
        around the file are found without, then those in FREEBODY_PACKAGE_PATH and where ROS keeps
        them.
    xacro
        Values for the arguments of a xacro file, by their names.
    xacro_environment
        The environment variables that a xacro file may read.

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
    how = ReadingOptions.of(snap_angles, convention, package_path, xacro, xacro_environment)
    if source is None:
        description = _text(text, format, how)
    elif text is None and format is None:
        description = read(source, how)
    else:
        raise FreebodyError("load: text= and format= take the place of a path; leave one out.")
    if estimate_inertia is not None:
        file = None if source is None else os.fspath(source)
        description = _estimated(
            description, estimate_inertia, packages_around(file, how.package_path)
        )
    chosen = base or description.base
    model = build_model(description, physical=physical, mimic=mimic, base=chosen, tip=tip)
    if loop_tolerance is not None:
        model = model.replace(loop_tolerance=loop_tolerance)
    return weighed(model, description, estimate_inertia is not None, physical != "ignore")


def _estimated(description: RobotDescription, mass: float, packages: Packages) -> RobotDescription:
    if not description.real:
        raise FreebodyError(
            f"load: estimate_inertia= needs the shapes of a URDF, and {description.name!r} comes "
            f"from none; give masses in its file."
        )
    return estimated(description, mass, packages)


def weighed(model: Model, description: RobotDescription, estimate: bool, warned: bool) -> Model:
    """The model with doubts on its masses added, where the description is of a real machine."""
    if description.real:
        shapes = {link.name: link.shapes for link in description.links}
        filled = {link.name for link in description.links if link.filled}
        found = implausible_masses(model, shapes, estimate, filled)
        model = replace(model, notices=(*model.notices, *found)) if found else model
    notices = tied(model.notices, model)
    model = replace(model, notices=notices) if notices != model.notices else model
    for doubt in model.notices if warned else ():
        if isinstance(doubt, Doubt) and doubt.of.mend:
            warn(f"warning: {doubt}", MassWarning)
    return model


def read(
    source: str | os.PathLike[str], how: ReadingOptions = ReadingOptions()
) -> RobotDescription:
    """The description in a file or of a bundled model, before it is checked and lumped; see
    `load`."""
    given = _path(source)
    path = Path(given)
    if not path.suffix and os.sep not in given and "/" not in given:
        _used(how, (), given)
        return _named(given)
    suffix = path.suffix.lower()
    if suffix not in SUFFIXES and not path.is_dir():
        raise FileError(
            path, None, f"freebody does not know {suffix or _BARE}; it reads {', '.join(SUFFIXES)}."
        )
    data = read_file.read(path)
    return _described(suffix, given, data, path.stem, packages_around(given, how.package_path), how)


def _text(text: object, kind: str | None, how: ReadingOptions) -> RobotDescription:
    """The description in a text of a stated format."""
    if text is None or kind is None:
        raise FreebodyError(
            "load: give a path or a bundled model's name, or text= and format= of a description."
        )
    if not isinstance(text, str) or not text.strip():
        what = "empty" if isinstance(text, str) else f"of type {type(text).__name__}"
        raise FreebodyError(f"load: text= is {what}, expected a description.")
    known = [suffix[1:] for suffix in SUFFIXES]
    if kind not in known:
        raise UnknownNameError("format", kind, "load", known)
    if len(text) > read_file.LARGEST_FILE:
        raise FreebodyError("load: text= is longer than any robot description.")
    data = text.encode(errors="replace")
    packages = packages_around(None, how.package_path)
    return _described(f".{kind}", "text", data, "robot", packages, how)


def _described(
    suffix: str, file: str, data: bytes, name: str, packages: Packages, how: ReadingOptions
) -> RobotDescription:
    reader = _FORMATS[suffix]
    _used(how, reader.uses, file)
    return _with_folders(reader.describe(_Given(file, data, name, packages, how)), packages)


def _with_folders(description: RobotDescription, packages: Packages) -> RobotDescription:
    """The description, its meshes with the folders where their files are looked for."""
    own, given = str(packages.folder or ""), tuple(map(str, packages.given))

    def placed(shape: Shape) -> Shape:
        return replace(shape, folders=((*shape.folders, own)[0], *given)) if shape.file else shape

    links = tuple(
        replace(link, shapes=tuple(map(placed, link.shapes))) if link.shapes else link
        for link in description.links
    )
    return replace(description, links=links)


def _used(how: ReadingOptions, uses: tuple[str, ...], given: str) -> None:
    """Refuse options that have no effect on what is read, and values that are out of range."""
    if not 0.0 <= real(how.snap_angles, "load: snap_angles") < 0.1:
        raise FreebodyError(
            f"load: snap_angles is {how.snap_angles}, expected radians between 0 and 0.1."
        )
    for name, purpose in _PURPOSES.items():
        if getattr(how, name) and name not in uses:
            raise FreebodyError(f"load: {name}= is for {purpose}; leave it out for {given!r}.")


def _listed(option: str, given: object) -> tuple[str, ...]:
    """One name or path, or several of them, as a tuple of texts."""
    entries = (given,) if isinstance(given, str | os.PathLike) else given
    if not isinstance(entries, Sequence) or not all(
        isinstance(entry, str | os.PathLike) for entry in entries
    ):
        raise FreebodyError(f"load: {option}= takes one text or a list of texts.")
    return tuple(os.fspath(entry) for entry in entries)


def _arguments(given: object) -> dict[str, object]:
    """Values for a xacro file's arguments, by their names."""
    if given is None:
        return {}
    if not isinstance(given, Mapping) or not all(isinstance(name, str) for name in given):
        raise FreebodyError("load: xacro= takes values by their names, such as {'length': 0.5}.")
    return dict(given)


def _path(source: object) -> str:
    """The path or name as text; refuses a description passed in place of a file's name."""
    given = read_file.path_of("load", "source", source, "a robot's file, or a model's name")
    if given.lstrip().startswith("<") or "\n" in given:
        kind = "urdf" if given.lstrip().startswith("<") else "toml"
        raise FreebodyError(
            f"load: {shown(given)} is the text of a description, not a path; give it as text=, "
            f'with its format, such as format="{kind}".'
        )
    return given


def _template(name: str) -> RobotDescription:
    """The description of a template with its default numbers."""
    names = read_file.template_names()
    if name not in names:
        raise UnknownNameError("template", name, "load", names)
    return toml.describe(f"{name}.toml", read_file.template_text(name), name=name)


def _named(name: str) -> RobotDescription:
    """The description of a bundled model, whose name's case is free, or for a name made of R and P
    alone, of the planar arm with these joints."""
    if name.startswith(TEMPLATE):
        return _template(name.removeprefix(TEMPLATE))
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
    for known in names:
        if known.casefold() == name.casefold():  # UR5e for ur5e
            return _named(known)
    problem = UnknownNameError("model", name, "the bundled models", names)
    raise FreebodyError(f"load: {problem} A file needs its suffix: {', '.join(SUFFIXES)}.")
