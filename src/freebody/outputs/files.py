"""The only writer of files: each is written beside its place, flushed and renamed, so that it is
the old or the new file, never a part of one.

A link is followed to the file that it names. A pipe or a terminal has no place to rename to: what
is written goes straight into it.
"""

from __future__ import annotations

import contextlib
import errno
import os
import re
import secrets
import shutil
import stat
from pathlib import Path

from freebody.errors import FileError

LEFTOVER = re.compile(r"\.freebody-[0-9a-f]{16}\.tmp")
"""Name of a file that is being written; one stays behind where the program was killed."""

_NEW = (
    os.O_WRONLY | os.O_CREAT | os.O_EXCL | getattr(os, "O_BINARY", 0) | getattr(os, "O_NOFOLLOW", 0)
)
_REASONS = {
    errno.ENOSPC: "the disk is full",
    errno.EDQUOT: "the disk's quota is used up",
    errno.EFBIG: "the file would be larger than this disk allows",
    errno.EACCES: "there is no permission to write it, or in its folder",
    errno.EPERM: "there is no permission to write it, or in its folder",
    errno.EROFS: "the disk can only be read",
    errno.EISDIR: "there is a folder of that name",
    errno.ENOTDIR: "a part of the path is a file, not a folder",
    errno.EEXIST: "a part of the path is a file, not a folder",
    errno.ENAMETOOLONG: "the name is too long",
    errno.ENXIO: "nobody reads from this pipe",
    errno.EPIPE: "the reader of this pipe has gone",
    errno.ENODEV: "this is a device, not a file",
}


def write(path: str | os.PathLike[str], content: str | bytes) -> Path:
    """The path of a file that is written whole, with the folders it needs. Text is written as
    UTF-8.

    Raises FileError where that cannot be: the file that was there is as it was.
    """
    target = Path(path)
    try:
        if _is_stream(target):
            _send(target, encoded(content))
        else:
            place = Path(os.path.realpath(target))
            os.makedirs(place.parent, exist_ok=True)
            replace(place, encoded(content))
    except (OSError, ValueError) as failure:
        raise FileError(target, None, f"cannot be written: {reason(failure)}.") from None
    return target


def replace(target: Path, content: bytes) -> None:
    """Put a file in its place, whole and on the disk, or raise OSError and leave what is there."""
    _permitted(target)
    temporary = os.path.join(target.parent, f".freebody-{secrets.token_hex(8)}.tmp")
    try:
        descriptor = os.open(temporary, _NEW, 0o666)
        try:
            _write_all(descriptor, content)
            os.fsync(descriptor)
        finally:
            os.close(descriptor)
        with contextlib.suppress(OSError):
            shutil.copymode(target, temporary)
        os.replace(temporary, target)
    except BaseException:  # also an interrupt leaves nothing behind
        with contextlib.suppress(OSError):
            os.unlink(temporary)
        raise
    _settle(target.parent)


def reason(failure: Exception) -> str:
    """The reason why a file cannot be written, in terms of the path that was given."""
    if isinstance(failure, OSError):
        return _REASONS.get(failure.errno or 0) or (failure.strerror or str(failure)).lower()
    return "a path cannot hold the character NUL" if "null byte" in str(failure) else str(failure)


def encoded(content: str | bytes) -> bytes:
    """Text as UTF-8 bytes; halves of surrogate pairs, as in file names outside UTF-8, become
    question marks."""
    return content if isinstance(content, bytes) else content.encode("utf-8", "replace")


def stem(name: str) -> str:
    """A file name without suffix made of a robot's name, which stays in its folder whatever the
    robot is called."""
    return re.sub(r"[^\w.-]+", "_", name).strip("._")[:60].rstrip("._") or "robot"


def _is_stream(target: Path) -> bool:
    """Whether a path is a pipe or a terminal; raises OSError for a folder and for other devices."""
    try:
        mode = os.stat(target).st_mode
    except (FileNotFoundError, NotADirectoryError):
        return False
    if stat.S_ISDIR(mode):
        raise IsADirectoryError(errno.EISDIR, "a folder")
    if stat.S_ISFIFO(mode) or stat.S_ISCHR(mode):
        return True
    if not stat.S_ISREG(mode):
        raise OSError(errno.ENODEV, "a device")
    return False


def _send(target: Path, content: bytes) -> None:
    # a pipe that nobody reads is refused at once instead of waited for
    waiting = getattr(os, "O_NONBLOCK", 0)
    descriptor = os.open(target, os.O_WRONLY | waiting | getattr(os, "O_NOCTTY", 0))
    try:
        if waiting:
            os.set_blocking(descriptor, True)
        _write_all(descriptor, content)
    finally:
        os.close(descriptor)


def _permitted(target: Path) -> None:
    """Raise OSError for a folder or a write-protected file, which a rename would not respect."""
    try:
        mode = os.lstat(target).st_mode
    except FileNotFoundError:
        return
    if stat.S_ISDIR(mode):
        raise IsADirectoryError(errno.EISDIR, "a folder")
    if not os.access(target, os.W_OK):
        raise PermissionError(errno.EACCES, "write-protected")


def _write_all(descriptor: int, content: bytes) -> None:
    left = memoryview(content)
    while left:
        left = left[os.write(descriptor, left) :]


def _settle(folder: Path) -> None:
    """Flush a folder's directory entries to the disk, where the system supports it."""
    if not hasattr(os, "O_DIRECTORY"):
        return
    with contextlib.suppress(OSError):
        descriptor = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)
