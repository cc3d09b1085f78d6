"""Compiled objects on disk, addressed by content.

An entry is code that will run, so it is believed only if its folder and it belong to this user and
nobody else can write them (asked of the open descriptor; links are not followed), and if its
checksum, which covers the key, is right. Entries are written under a temporary name and renamed, so
that other processes see whole entries only. Whatever goes wrong here costs a compilation, never an
error: the reasons are logged under "freebody.targets.llvm.cache".

The environment's FREEBODY_CACHE is a folder, or `off`. The default is the platform's cache folder
of the user.
"""

from __future__ import annotations

import contextlib
import hashlib
import logging
import os
import secrets
import stat
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

LIMIT = 256 * 2**20
"""Bytes that the folder may hold; the entries unused for longest go first."""
_UNSEEN = 32
"""A process looks through the folder, which takes as long as it has entries, at its first and then
after each 32nd part of LIMIT that it has stored."""

_MAGIC = b"freebody object\n"
_HEAD = len(_MAGIC) + hashlib.sha256().digest_size
_SUFFIX = ".o"
_STALE = 3600.0  # seconds after which a temporary file is what a killed process left
_POSIX = hasattr(os, "geteuid")

log = logging.getLogger(__name__)

_stored: dict[Path | None, int] = {}
"""Bytes that this process has stored in a folder since it looked through it."""


def folder() -> Path | None:
    """The folder of the cache; None if it is off or there is no home."""
    given = os.environ.get("FREEBODY_CACHE")
    if given:
        return None if given.lower() == "off" else Path(given)
    if sys.platform == "win32":
        local = os.environ.get("LOCALAPPDATA")
        return Path(local, "freebody", "cache") if local else None
    if sys.platform != "darwin" and os.path.isabs(os.environ.get("XDG_CACHE_HOME", "")):
        return Path(os.environ["XDG_CACHE_HOME"], "freebody")
    try:
        home = Path.home()
    except RuntimeError:
        return None
    return home / ("Library/Caches" if sys.platform == "darwin" else ".cache") / "freebody"


def key(*parts: object) -> str:
    """Name of an entry: a hash of everything that its content depends on."""
    return hashlib.sha256(repr(parts).encode()).hexdigest()


def load(key: str) -> bytes | None:
    """The object stored under `key`; None if there is none, or none that can be trusted."""
    try:
        with _folder(create=False) as place:
            entry = _read(place, key + _SUFFIX)
    except OSError as problem:
        log.info("%s not loaded: %s", key, problem)
        return None
    code = entry[_HEAD:]
    if entry != _entry(key, code):
        log.info("%s not loaded: damaged", key)
        return None
    return code


def store(key: str, code: bytes) -> None:
    """Store an object under `key`, if there is a place for it."""
    entry = _entry(key, code)
    try:
        with _folder(create=True) as place:
            temporary = f".{key}.{os.getpid()}.{secrets.token_hex(4)}"
            try:
                _write(place, temporary, entry)
                _rename(place, temporary, key + _SUFFIX)
            except OSError:
                _remove(place, temporary)
                raise
            _evict_in_time(place, len(entry))
    except OSError as problem:
        log.info("%s not stored: %s", key, problem)


class _Refused(OSError):
    """Raised for a cache folder or file that others could have written."""


def _entry(key: str, code: bytes) -> bytes:
    return _MAGIC + hashlib.sha256(key.encode() + code).digest() + code


def _trusted(descriptor: int, kind: Callable[[int], bool]) -> None:
    """Raise an error unless an open file is of the right kind, owned by the user, and writable by
    nobody else."""
    status = os.fstat(descriptor)
    if not kind(status.st_mode):
        raise _Refused("not a plain file or folder")
    if _POSIX and (status.st_uid != os.geteuid() or status.st_mode & (stat.S_IWGRP | stat.S_IWOTH)):
        raise _Refused(
            f"owner {status.st_uid}, mode {stat.filemode(status.st_mode)}: not ours alone to write"
        )


@contextlib.contextmanager
def _folder(create: bool) -> Iterator[int | str]:
    """The trusted cache folder: opened, where the system can open files relative to a descriptor,
    else its path."""
    path = folder()
    if path is None:
        raise FileNotFoundError("the cache is off, or there is no home")
    if create:
        path.parent.mkdir(parents=True, exist_ok=True)
        with contextlib.suppress(FileExistsError):
            path.mkdir(mode=0o700)
    if not _POSIX:
        yield str(path)  # %LOCALAPPDATA% belongs to its user
        return
    descriptor = os.open(path, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW | os.O_CLOEXEC)
    try:
        _trusted(descriptor, stat.S_ISDIR)
        yield descriptor
    finally:
        os.close(descriptor)


def _open(place: int | str, name: str, flags: int) -> int:
    if isinstance(place, int):
        # O_NONBLOCK: a pipe in the place of an entry must not hang us
        return os.open(
            name, flags | os.O_NOFOLLOW | os.O_CLOEXEC | os.O_NONBLOCK, 0o600, dir_fd=place
        )
    return os.open(os.path.join(place, name), flags | getattr(os, "O_BINARY", 0), 0o600)


def _read(place: int | str, name: str) -> bytes:
    """The content of a trusted file, whose time of use is updated."""
    descriptor = _open(place, name, os.O_RDONLY)
    with open(descriptor, "rb") as file:
        _trusted(descriptor, stat.S_ISREG)
        with contextlib.suppress(OSError):
            os.utime(descriptor if _POSIX else os.path.join(str(place), name))
        return file.read(LIMIT)


def _write(place: int | str, name: str, content: bytes) -> None:
    with open(_open(place, name, os.O_WRONLY | os.O_CREAT | os.O_EXCL), "wb") as file:
        file.write(content)


def _at(place: int | str, name: str) -> tuple[str, int | None]:
    """The name and `dir_fd` of a file, for functions of `os`."""
    return (name, place) if isinstance(place, int) else (os.path.join(place, name), None)


def _rename(place: int | str, old: str, new: str) -> None:
    (source, descriptor), (target, _) = _at(place, old), _at(place, new)
    os.replace(source, target, src_dir_fd=descriptor, dst_dir_fd=descriptor)


def _remove(place: int | str, name: str) -> None:
    path, descriptor = _at(place, name)
    with contextlib.suppress(OSError):
        os.unlink(path, dir_fd=descriptor)


def _evict_in_time(place: int | str, size: int) -> None:
    """Look after the folder's size, where so much was stored that it is worth the time."""
    where = folder()
    _stored[where] = _stored.get(where, LIMIT) + size
    if _stored[where] > LIMIT / _UNSEEN:
        _stored[where] = 0
        _evict(place)


def _evict(place: int | str) -> None:
    """Remove the least recently used files until the rest fits, and temporary files of killed
    processes."""
    entries, now = [], time.time()
    for name in os.listdir(place):
        path, descriptor = _at(place, name)
        try:
            status = os.stat(path, dir_fd=descriptor, follow_symlinks=False)
        except OSError:
            continue  # another process was quicker
        if name.endswith(_SUFFIX):
            entries.append((status.st_mtime, status.st_size, name))
        elif name.startswith(".") and name.count(".") == 3 and now - status.st_mtime > _STALE:
            _remove(place, name)
    total = sum(size for _, size, _ in entries)
    for _, size, name in sorted(entries):
        if total <= LIMIT:
            break
        _remove(place, name)
        total -= size
