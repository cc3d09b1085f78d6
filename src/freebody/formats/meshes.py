"""Corners of meshes in files, of which drawings make hulls: STL and OBJ read here, other formats by
trimesh.

A file may come from anywhere: its length is bounded, what does not fit is refused in words, and of
all that it holds three columns of finite numbers are kept.
"""

from __future__ import annotations

import io
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from freebody.arrays import Array
from freebody.errors import FileError, MissingPackageError
from freebody.formats.read_file import contents

FORMATS = (".stl", ".obj", ".ply", ".dae")
"""Formats of meshes: those of shapes alone, no archives and no scenes that name further files."""
_LARGEST = 64 * 2**20  # bytes of a mesh that is drawn
_FARTHEST = 1e6
"""Numbers of a mesh up to which it can be one, in whatever unit."""
_HEAD, _TRIANGLE = 84, 50  # bytes of an STL file's beginning, and of a triangle


def mesh_corners(path: Path) -> Array:
    """Corners (n, 3) of the mesh in a file, in its own unit, each perhaps several times.

    Raises FileError for what is no mesh, too large, or not of numbers.
    """
    suffix = path.suffix.lower()
    if suffix not in FORMATS:
        raise FileError(path, None, f"a mesh is of the formats {', '.join(FORMATS)}.")
    data = contents(path, _LARGEST, "a mesh that is drawn")
    own = _CORNERS.get(suffix)
    found = (
        own(data, path)
        if own
        else np.asarray(opened(data, path, f"meshes in {suffix}").vertices, dtype=float)
    )
    if found.ndim != 2 or found.shape[1:] != (3,) or not len(found):
        raise FileError(path, None, "there are no triangles in it.")
    if not (np.abs(found) < _FARTHEST).all():  # NaN neither
        raise FileError(path, None, f"a corner is not of numbers below {_FARTHEST:g}.")
    return found


def opened(data: bytes, path: Path, what: str) -> Any:
    """The mesh in a file's bytes as trimesh has it, which is an extra."""
    try:
        import trimesh
    except ImportError:
        raise MissingPackageError(what, "trimesh", "mesh") from None
    if path.suffix.lower() == ".dae" and find_spec("collada") is None:
        raise MissingPackageError(what, "pycollada", "mesh")
    try:
        return trimesh.load(io.BytesIO(data), file_type=path.suffix.lower()[1:], force="mesh")
    except Exception as problem:  # whatever a reader of meshes raises on a broken one
        raise FileError(path, None, f"{' '.join(str(problem).split())}.") from None


def _stl(data: bytes, path: Path) -> Array:
    """Corners of an STL file: binary where its length is that of as many triangles as it tells,
    else of the lines that begin with vertex."""
    told = int.from_bytes(data[_HEAD - 4 : _HEAD], "little")
    if len(data) == _HEAD + _TRIANGLE * told:
        raw = np.frombuffer(data, dtype=np.uint8, offset=_HEAD).reshape(told, _TRIANGLE)
        # behind the normal, in front of two bytes of attributes
        with np.errstate(invalid="ignore"):  # NaN is refused with the others
            return raw[:, 12:48].copy().view("<f4").reshape(-1, 3).astype(float)
    if data.lstrip()[:5].lower() == b"solid" and b"vertex" in data:
        return _columns(data, b"vertex", path)
    fits = (len(data) - _HEAD) / _TRIANGLE
    raise FileError(
        path, None, f"it tells of {told} triangles, and its length is that of {max(fits, 0):.6g}."
    )


def _obj(data: bytes, path: Path) -> Array:
    """Corners of an OBJ file: the lines that begin with v."""
    return _columns(data, b"v", path)


def _columns(data: bytes, word: bytes, path: Path) -> Array:
    """The three numbers behind a word at the beginning of lines."""
    rows = [words[1:4] for words in map(bytes.split, data.splitlines()) if words[:1] == [word]]
    try:
        return np.array(rows, dtype=object).astype(float).reshape(len(rows), 3)
    except ValueError:
        told = f"a line that begins with {word.decode()} has no three numbers."
        raise FileError(path, None, told) from None


_CORNERS: dict[str, Callable[[bytes, Path], Array]] = {".stl": _stl, ".obj": _obj}
"""Readers of formats that need no other package."""
