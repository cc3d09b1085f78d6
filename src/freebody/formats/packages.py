"""The search for folders of ROS packages without ROS: around the file that refers to them, in
folders that the user gives, and where ROS keeps packages.

Only the folders above the file and those beside them are looked at, never what lies deeper.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import takewhile
from pathlib import Path

from freebody.lazy import cached_property

VARIABLE = "FREEBODY_PACKAGE_PATH"
"""Environment variable with folders of packages, as PATH lists them."""
_HIGHEST = 6  # folders above a file that are looked at
_MOST = 2000  # entries of a folder that are looked at
_NAME = re.compile(rb"<name>\s*([^<\s]+)\s*</name>")
_DESCRIPTIONS = ("urdf", "urdfs", "xacro", "robots", "robot", "model", "models")


@dataclass(frozen=True)
class Packages:
    """The packages that a file in `folder` (absolute; None for text) can refer to. given: folders
    of packages, or packages, that the user names."""

    folder: Path | None
    given: tuple[Path, ...] = ()

    def find(self, name: str) -> Path | None:
        """The folder of that package: the one of its name or whose package.xml names it; else one
        whose name is the beginning of the package's, or the other way round, as copies of packages
        are often called. The nearest of each sort comes first."""
        if not name or "/" in name or os.sep in name or name.startswith("."):
            return None
        folders = list(dict.fromkeys(self._folders))
        sorts = (
            lambda folder: folder.name == name,
            lambda folder: _named(folder) == name,
            lambda folder: name.startswith(f"{folder.name}_"),
            lambda folder: folder.name.startswith(f"{name}_"),
        )
        return next((x for fits in sorts for x in folders if fits(x)), None)

    def located(self, name: str) -> Path | None:
        """The file that a mesh's name means: a path from the file's folder, file://PATH, or
        package://NAME/REST, where NAME/REST, or else REST alone, is also found from that folder or
        one above it, the nearest first. None where there is no such file."""
        scheme, colon, rest = name.partition("://")
        above = (self.folder, *self.folder.parents) if self.folder else ()
        if not colon:
            candidates = [place / name for place in above[:1]]
        elif scheme == "file":
            candidates = [Path(rest)]
        elif scheme in ("package", "model"):
            package, _, inside = rest.partition("/")
            candidates = [place / rest for place in above]
            found = self.find(package)
            candidates += [found / inside] if found else []
            candidates += [place / inside for place in above]
        else:
            return None
        return next((path for path in candidates if _is_file(path)), None)

    def holds(self, name: str, path: Path) -> bool:
        """Whether the file that a mesh's name means lies in a package that the name tells, or below
        the folders whose files a description may ask for."""
        scheme, _, rest = name.partition("://")
        if scheme in ("package", "model") and ".." not in rest.split("/"):
            return True
        real = os.path.realpath(path)
        return any(Path(real).is_relative_to(os.path.realpath(root)) for root in self.readable)

    @cached_property
    def readable(self) -> tuple[Path, ...]:
        """Folders whose files a description may ask for: its own, its package's, and those that the
        user gives. Its package is the nearest folder above with a package.xml, or else the one
        around a folder of a usual name such as urdf."""
        own = next((x for x in self._above if (x / "package.xml").is_file()), None)
        if own is None and len(self._above) > 1 and self._above[0].name in _DESCRIPTIONS:
            own = self._above[1]
        return (*self._above[:1], *([own] if own else []), *self.given)

    @cached_property
    def _above(self) -> tuple[Path, ...]:
        """The file's folder and those above it, except the user's home and the root."""
        if self.folder is None:
            return ()
        above = (self.folder, *self.folder.parents)[:_HIGHEST]
        forbidden = {Path(self.folder.anchor), Path.home()}
        return tuple(takewhile(lambda folder: folder not in forbidden, above))

    @cached_property
    def _folders(self) -> tuple[Path, ...]:
        """All folders that may be a package, the likeliest first."""
        listed = (*self.given, *_listed(VARIABLE))
        ros = (
            *(prefix / "share" for prefix in _listed("AMENT_PREFIX_PATH")),
            *_listed("ROS_PACKAGE_PATH"),
        )
        places = (*listed, *self._above, *ros)
        return tuple(folder for place in places for folder in (place, *_inside(place)))


def packages_around(file: str | None, given: Sequence[str | os.PathLike[str]] = ()) -> Packages:
    """The packages that a file (or a text, where it is None) can refer to, with folders that the
    user gives."""
    folders = tuple(Path(folder).expanduser().absolute() for folder in given)
    return Packages(None if file is None else Path(os.path.abspath(file)).parent, folders)


def _listed(variable: str) -> Iterator[Path]:
    for entry in os.environ.get(variable, "").split(os.pathsep):
        if entry:
            yield Path(entry).expanduser().absolute()


def _inside(place: Path) -> list[Path]:
    try:
        with os.scandir(place) as entries:
            found = [entry for _, entry in zip(range(_MOST), entries, strict=False)]
        return sorted(Path(entry.path) for entry in found if entry.is_dir())
    except OSError:
        return []


def _is_file(path: Path) -> bool:
    try:
        return path.is_file()
    except OSError:  # a name that is too long
        return False


def _named(folder: Path) -> str | None:
    """The name that a folder's package.xml gives."""
    try:
        with open(folder / "package.xml", "rb") as file:
            found = _NAME.search(file.read(20_000))
    except OSError:
        return None
    return found[1].decode(errors="replace") if found else None
