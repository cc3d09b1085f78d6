"""`save`: a model as a file of one of the formats that are written, and what is lost in each."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

from freebody.errors import FreebodyError, UnknownNameError, require_kind
from freebody.formats.writing import dh_csv, mjcf, sdf, toml, urdf
from freebody.model.families import FamilyError
from freebody.model.model import Model
from freebody.outputs.files import write

_TextAndLosses = Callable[[Model], tuple[str, list[str]]]
"""The text of a model, and in words what of the model is not in it."""

_WRITERS: dict[str, _TextAndLosses] = {
    ".toml": toml.written,
    ".urdf": urdf.written,
    ".sdf": sdf.written,
    ".xml": mjcf.written,
    ".mjcf": mjcf.written,
    ".csv": dh_csv.written,
}
SUFFIXES = tuple(_WRITERS)
_SHOWN = 20


def save(model: Model, path: str | os.PathLike[str], *, lossy: bool = False) -> None:
    """Write the model to a .toml, .urdf, .sdf, .xml or .mjcf (MJCF), or .csv (DH table) file
    (UTF-8).

    freebody's own format, .toml, holds every model, and loading it gives the same again. Of
    `model.notices` the doubts that still stand go along, as `masses_missing`, `masses_doubtful`,
    `masses_estimated` and `limits_estimated`; the others, about the file it came from, are not
    saved. The other formats hold less; what of this model would be lost is told before anything is
    written, and by `fb.losses`.

    Parameters
    ----------
    model
        The model, with values of all its parameters but for .toml.
    path
        The file; its suffix is the format.
    lossy
        Whether to write what the format holds, although something is lost.

    Raises
    ------
    FreebodyError
        A suffix that is none of these, the losses, or a robot that the format does not hold at all.
    FileError
        A file that cannot be written.
    """
    require_kind("save", "path", path, (str, os.PathLike), "the name of a file")
    target = Path(path)
    suffix = target.suffix.lower()
    if suffix not in _WRITERS:
        raise FreebodyError(
            f"save: {os.fspath(path)!r} must end in {', '.join(SUFFIXES)}, the formats that are "
            f"written."
        )
    text, lost = _written(model, suffix, "save")
    if lost and not lossy:
        more = [f"{len(lost) - _SHOWN} more"] if len(lost) > _SHOWN else []
        raise FreebodyError(
            f"save: of {model.name!r} this would be lost in {suffix}: "
            f"{'; '.join([*lost[:_SHOWN], *more])}. Write it as .toml, which holds all, or without "
            f"these by lossy=True (--lossy)."
        )
    write(target, text)


def losses(model: Model, format: str) -> list[str]:  # noqa: A002
    """Sentences that name what of a model a format cannot hold; nothing is written.

    Parameters
    ----------
    model
        The model.
    format
        "toml", "urdf", "sdf", "mjcf" (or "xml"), "csv" (a DH table).

    Raises
    ------
    UnknownNameError
        A format that is not written.
    FreebodyError
        A robot that the format does not hold at all, such as a branched one in a DH table.
    """
    suffix = f".{format}"
    if suffix not in _WRITERS:
        raise UnknownNameError("format", format, "losses", [x[1:] for x in SUFFIXES])
    return _written(model, suffix, "losses")[1]


def _written(model: Model, suffix: str, function: str) -> tuple[str, list[str]]:
    if model.family:
        raise FamilyError(function, model.name, model.family)
    return _WRITERS[suffix](model)
