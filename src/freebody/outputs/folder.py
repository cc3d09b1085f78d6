"""A folder of results: every file complete, a manifest that says which run each file is of, files
of others untouched.

`manifest.json` is written twice. First, before any file is touched, with `complete: false`, the
checksums of what is about to be written under `files`, and those of what lies there under
`earlier`. Last, when all is in its place, with `complete: true` or with what `failed`. So a file
whose SHA-256 stands under `files` is of the run that the manifest names, one under `earlier` of a
run before it, and any other is not freebody's, or was changed since.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import re
import secrets
import stat
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from freebody.errors import FileError, FreebodyError, OutputError
from freebody.outputs.files import LEFTOVER, encoded, reason, replace

try:
    import fcntl
except ImportError:  # Windows
    fcntl: Any = None

MANIFEST = "manifest.json"
PATIENCE = 20.0
"""Seconds to wait for another run that is writing into the same folder, which takes one."""

_FORMAT = "freebody results 1"
_LARGEST = 2**20  # bytes; a manifest has about one hundred a file
_FOREIGN = (
    "a file of this name was not written by freebody, or was changed since; move it, or "
    "choose another folder"
)

_NAME, _SHA256 = re.compile(r"\w[\w.-]*"), re.compile("[0-9a-f]{64}")

Makers = Mapping[str, Callable[[], str | bytes]]
"""Functions that make the content of each file, by the file's name."""


@dataclass
class _Manifest:
    """The content of a folder's manifest.json."""

    run: str
    about: dict[str, str]
    complete: bool = False
    files: dict[str, str] = field(default_factory=dict)
    """SHA-256 of the files of this run."""
    earlier: dict[str, str] = field(default_factory=dict)
    """Checksums of files of earlier runs that lie here."""
    failed: dict[str, str] = field(default_factory=dict)
    """Why a file of this run is not here."""

    def text(self) -> bytes:
        entries = {"format": _FORMAT, **vars(self)}
        return (json.dumps(entries, indent=1) + "\n").encode()


def prepare(directory: str | os.PathLike[str]) -> None:
    """Make the folder; raises FileError, before any work is done, if nothing could be written into
    it."""
    folder = Path(directory)
    try:
        os.makedirs(folder, exist_ok=True)
    except (OSError, ValueError) as failure:
        if isinstance(failure, FileExistsError) and os.path.lexists(folder):
            problem = "there is a file of that name; name a folder instead."
        else:
            problem = f"cannot be made: {reason(failure)}."
        raise FileError(folder, None, problem) from None
    if not os.access(folder, os.W_OK | os.X_OK):
        raise FileError(folder, None, "there is no permission to write into this folder.")
    _known(folder)


def write_folder(
    directory: str | os.PathLike[str], makers: Makers, about: Mapping[str, str]
) -> list[Path]:
    """The paths of the files of one run written into a folder, the manifest's last.

    about: what the manifest says of the run. What cannot be made or written does not keep the
    others from it: in the end OutputError names it. A file of another origin is left as it is.
    """
    folder = Path(directory)
    prepare(folder)
    contents, problems = _made(makers)
    with _alone(folder):
        paths, failed = _put_all(folder, contents, problems, about, list(makers))
    if failed:
        raise OutputError(folder, failed, [path.name for path in paths]) from next(
            iter(problems.values())
        )
    return [*paths, folder / MANIFEST]


def _put_all(
    folder: Path,
    contents: dict[str, bytes],
    problems: dict[str, Exception],
    about: Mapping[str, str],
    names: list[str],
) -> tuple[list[Path], dict[str, str]]:
    """The paths of the files that are written, with the manifest before and after them, and the
    reasons why others are missing."""
    known = _known(folder)
    lies_here = {name: _digest(folder / name) for name in known.keys() | contents.keys()}
    for name in sorted(contents.keys() & lies_here.keys()):
        if lies_here[name] is not None and lies_here[name] not in known.get(name, ()):
            del contents[name]
            problems[name] = FreebodyError(_FOREIGN)
    manifest = _Manifest(secrets.token_hex(8), dict(about))
    manifest.files = {
        name: hashlib.sha256(content).hexdigest() for name, content in contents.items()
    }
    manifest.earlier = {
        name: sha for name, sha in sorted(lies_here.items()) if sha and sha in known.get(name, ())
    }
    _clear(folder)
    _put(folder / MANIFEST, manifest.text())
    for name, content in contents.items():
        try:
            replace(folder / name, content)
        except OSError as failure:
            problems[name] = failure
            del manifest.files[name]
        else:
            manifest.earlier.pop(name, None)
    manifest.failed = {name: _why(problems[name]) for name in names if name in problems}
    manifest.complete = not problems
    _put(folder / MANIFEST, manifest.text())
    return [folder / name for name in manifest.files], manifest.failed


@contextlib.contextmanager
def _alone(folder: Path) -> Iterator[None]:
    """Context in which only one run writes into a folder: another waits, and is refused where that
    takes too long.

    Where the system has no such locks, nothing keeps two runs apart. The lock ends with the
    process, however it ends.
    """
    try:
        descriptor = os.open(folder, os.O_RDONLY) if fcntl else None
    except OSError as failure:
        raise FileError(folder, None, f"cannot be read: {reason(failure)}.") from None
    try:
        late = time.monotonic() + PATIENCE
        while descriptor is not None and not _locked(descriptor):
            if time.monotonic() > late:
                raise FileError(
                    folder,
                    None,
                    "another run is writing into this folder; wait for it, or name another.",
                )
            time.sleep(0.02)
        yield
    finally:
        if descriptor is not None:
            os.close(descriptor)


def _locked(descriptor: int) -> bool:
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError:  # a file system without locks
        return True
    return True


def _made(makers: Makers) -> tuple[dict[str, bytes], dict[str, Exception]]:
    """The contents of files by name, and the exceptions of those that could not be made."""
    contents: dict[str, bytes] = {}
    problems: dict[str, Exception] = {}
    for name, make in makers.items():
        try:
            contents[name] = encoded(make())
        except Exception as failure:  # whatever it is, the others are made
            problems[name] = failure
    return contents, problems


def _put(path: Path, content: bytes) -> None:
    try:
        replace(path, content)
    except OSError as failure:
        raise FileError(path, None, f"cannot be written: {reason(failure)}.") from None


def _why(problem: Exception) -> str:
    if isinstance(problem, OSError):
        return reason(problem)
    if isinstance(problem, FreebodyError):
        return str(problem).rstrip(".")
    return f"{type(problem).__name__}: {problem} (an error in freebody, please report it)"


def _digest(path: Path) -> str | None:
    """The SHA-256 of a file; None where there is nothing, and a word that is no checksum for
    anything but a file."""
    try:
        if not stat.S_ISREG(os.lstat(path).st_mode):
            return "not a file"
        with path.open("rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    except FileNotFoundError:
        return None
    except OSError:
        return "not to be read"


def _known(folder: Path) -> dict[str, set[str]]:
    """The checksums that a folder's manifest lists, by file name. Raises FileError for a manifest
    of something else."""
    path = folder / MANIFEST
    try:
        if not stat.S_ISREG(os.lstat(path).st_mode) or os.path.getsize(path) > _LARGEST:
            raise ValueError
        found: Any = json.loads(path.read_bytes())
        if found["format"] != _FORMAT:
            raise ValueError
        pairs = [*found["files"].items(), *found["earlier"].items()]
        if not all(_NAME.fullmatch(name) and _SHA256.fullmatch(sha) for name, sha in pairs):
            raise ValueError
    except FileNotFoundError:
        return {}
    except OSError as failure:
        raise FileError(path, None, f"cannot be read: {reason(failure)}.") from None
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
        raise FileError(
            path,
            None,
            "this is not a manifest of freebody's results; name another folder.",
        ) from None
    known: dict[str, set[str]] = {}
    for name, sha in pairs:
        known.setdefault(name, set()).add(sha)
    return known


def _clear(folder: Path) -> None:
    """Remove half-written files of a run that was killed."""
    for name in os.listdir(folder):
        if LEFTOVER.fullmatch(name):
            with contextlib.suppress(OSError):
                os.unlink(folder / name)
