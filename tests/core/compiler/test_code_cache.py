"""The cache of machine code on disk: shared between processes, and no entry believed that others
could have written.

Whether LLVM worked is not to be seen from outside: its entrance is watched, and rights, owners and
sizes are feigned.
"""

from __future__ import annotations

import os
import stat
import subprocess
import sys

import numpy as np
import pytest

import freebody as fb
from freebody.targets import kernel
from freebody.targets.llvm import cache, cpu, machine
from support.child_process import environment
from support.programs import swap_kernel

ON_POSIX = pytest.mark.skipif(
    not hasattr(os, "geteuid"), reason="owners and modes of files are POSIX"
)


@pytest.fixture
def store(tmp_path, monkeypatch):
    """A folder for the cache, and programs that no other test has compiled."""
    folder = tmp_path / "cache"
    monkeypatch.setenv("FREEBODY_CACHE", str(folder))
    return folder


def compile_again(monkeypatch):
    """Compile as a new process would; whether LLVM had to work."""
    worked = []
    original = machine.object_code
    for k in range(kernel.RECENT):  # others push it out of the kernels that are kept
        fb.compile(lambda q, k=k: q + k, {"q": ()}, target="numpy")
    monkeypatch.setattr(cpu, "object_code", lambda *a, **k: worked.append(1) or original(*a, **k))
    result = swap_kernel(target="cpu")(np.array([1.0, 2.0, 3.0]))
    monkeypatch.setattr(cpu, "object_code", original)
    assert result.tolist() == [2.0, 2.0, 3.0]
    return bool(worked)


def test_the_second_process_finds_the_object(store, monkeypatch):
    assert compile_again(monkeypatch)
    (entry,) = store.iterdir()
    assert entry.suffix == ".o"
    if hasattr(os, "geteuid"):
        assert stat.S_IMODE(store.stat().st_mode) == 0o700
        assert stat.S_IMODE(entry.stat().st_mode) == 0o600
    assert not compile_again(monkeypatch)


def test_off_means_off(store, monkeypatch):
    monkeypatch.setenv("FREEBODY_CACHE", "off")
    assert compile_again(monkeypatch)
    assert compile_again(monkeypatch)
    assert not store.exists()


@pytest.mark.sample(3)
@pytest.mark.parametrize(
    "damage",
    [
        lambda entry: b"",
        lambda entry: entry[:-1],
        lambda entry: entry[:20],
        lambda entry: entry + b"\0",
        lambda entry: entry[:200] + bytes([entry[200] ^ 1]) + entry[201:],
        lambda entry: b"something else entirely",
    ],
)
def test_a_damaged_entry_is_compiled_anew(store, monkeypatch, damage):
    compile_again(monkeypatch)
    (entry,) = store.iterdir()
    entry.write_bytes(damage(entry.read_bytes()))
    assert compile_again(monkeypatch)
    assert not compile_again(monkeypatch)


def test_an_entry_under_another_name_is_not_believed(store, monkeypatch):
    compile_again(monkeypatch)
    (entry,) = store.iterdir()
    os.replace(entry, store / f"{'0' * 64}.o")
    assert cache.load("0" * 64) is None


@ON_POSIX
@pytest.mark.parametrize("mode", [0o620, 0o602, 0o666])
def test_an_entry_that_others_may_write_is_not_believed(store, monkeypatch, mode):
    compile_again(monkeypatch)
    (entry,) = store.iterdir()
    entry.chmod(mode)
    assert compile_again(monkeypatch)
    assert not compile_again(monkeypatch)


@ON_POSIX
@pytest.mark.parametrize("mode", [0o720, 0o777])
def test_a_folder_that_others_may_write_is_not_used(store, monkeypatch, mode):
    compile_again(monkeypatch)
    store.chmod(mode)
    assert compile_again(monkeypatch)
    assert compile_again(monkeypatch)


@ON_POSIX
def test_an_owner_other_than_this_user_is_not_believed(store, monkeypatch):
    compile_again(monkeypatch)
    monkeypatch.setattr(cache.os, "geteuid", lambda: os.getuid() + 1)
    assert compile_again(monkeypatch)


@ON_POSIX
def test_links_are_not_followed(store, monkeypatch, tmp_path):
    compile_again(monkeypatch)
    (entry,) = store.iterdir()
    os.replace(entry, tmp_path / "elsewhere.o")
    entry.symlink_to(tmp_path / "elsewhere.o")
    assert compile_again(monkeypatch)
    assert not entry.is_symlink()  # replaced by a file of our own
    link = tmp_path / "link"
    link.symlink_to(store)
    monkeypatch.setenv("FREEBODY_CACHE", str(link))
    assert compile_again(monkeypatch)


@ON_POSIX
def test_a_pipe_or_folder_in_the_place_of_an_entry(store, monkeypatch):
    compile_again(monkeypatch)
    (entry,) = store.iterdir()
    entry.unlink()
    os.mkfifo(entry)
    assert compile_again(monkeypatch)
    assert not compile_again(monkeypatch)
    entry.unlink()
    entry.mkdir()
    assert compile_again(monkeypatch)


def test_a_folder_that_cannot_be_made(store, monkeypatch):
    store.write_text("a file in the way")
    assert compile_again(monkeypatch)
    monkeypatch.setenv("FREEBODY_CACHE", str(store / "below"))
    assert compile_again(monkeypatch)
    monkeypatch.setenv("FREEBODY_CACHE", "")
    for name in ("HOME", "XDG_CACHE_HOME", "LOCALAPPDATA"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr(cache.Path, "home", lambda: (_ for _ in ()).throw(RuntimeError("no home")))
    assert cache.folder() is None
    assert compile_again(monkeypatch)


@ON_POSIX
def test_a_read_only_folder(store, monkeypatch):
    compile_again(monkeypatch)
    (entry,) = store.iterdir()
    entry.unlink()
    real = os.open

    def denied(path, flags, *rest, **kw):  # root may write anywhere: modes alone would not tell
        if flags & os.O_CREAT:
            raise PermissionError(13, "denied")
        return real(path, flags, *rest, **kw)

    monkeypatch.setattr(cache.os, "open", denied)
    assert compile_again(monkeypatch)
    assert list(store.iterdir()) == []


def test_the_oldest_entries_make_room(store, monkeypatch):
    monkeypatch.setattr(cache, "LIMIT", 3500)
    for k in range(5):
        cache.store(f"{k}" * 64, bytes(1000))
        os.utime(store / f"{f'{k}' * 64}.o", (k, k))
        if k == 2:
            assert cache.load("0" * 64) == bytes(1000)  # of use: now the youngest
    assert sorted(p.name[0] for p in store.iterdir()) == ["0", "3", "4"]


def test_a_full_folder_is_not_looked_through_for_each_entry(store, monkeypatch):
    """It stays within a 32nd part of its size, and within as many looks."""
    looks, real = [], os.listdir
    monkeypatch.setattr(cache.os, "listdir", lambda place: looks.append(1) or real(place))
    monkeypatch.setattr(cache, "LIMIT", 64_000)
    for k in range(400):
        cache.store(f"{k:064x}", bytes(200))
        held = sum(entry.stat().st_size for entry in os.scandir(store))
        assert held <= 64_000 * 33 / 32
    assert held > 60_000
    assert len(looks) <= 1 + 400 * 300 / (64_000 / 32)


def test_what_a_killed_process_left_is_removed(store):
    store.mkdir(mode=0o700)
    old, new = store / f".{'b' * 64}.1.00", store / f".{'c' * 64}.2.00"
    for path in (old, new):
        path.write_bytes(b"half")
    os.utime(old, (0, 0))
    cache.store("d" * 64, b"code")
    assert not old.exists()
    assert new.exists()


def test_the_default_folder(monkeypatch):
    monkeypatch.delenv("FREEBODY_CACHE")
    monkeypatch.setattr(cache.sys, "platform", "linux")
    monkeypatch.setenv("XDG_CACHE_HOME", "/somewhere")
    assert cache.folder() == cache.Path("/somewhere/freebody")
    monkeypatch.setenv("XDG_CACHE_HOME", "relative is ignored")
    monkeypatch.setattr(cache.Path, "home", lambda: cache.Path("/home/me"))
    assert cache.folder() == cache.Path("/home/me/.cache/freebody")
    monkeypatch.setattr(cache.sys, "platform", "darwin")
    assert cache.folder() == cache.Path("/home/me/Library/Caches/freebody")


CHILD = """
import sys, numpy as np
import freebody as fb
import freebody as fb
from freebody.targets.llvm import cpu
from freebody.math import sin
if len(sys.argv) > 1:
    def refuse(*given, **options): raise AssertionError("compiled again")
    cpu.object_code = refuse
k = fb.compile(lambda q: [sin(q[0]) * q[1], q[0]], {"q": 2}, {"r": 2})
print(k(np.random.default_rng(0).normal(size=(11, 2)) * [1e7, 1.0]).tobytes().hex())
"""


def test_processes_share_objects(store):
    def start(*arguments):
        return subprocess.Popen(
            [sys.executable, "-c", CHILD, *arguments],
            stdout=subprocess.PIPE,
            env=environment(),
            text=True,
        )

    both_at_once = [start(), start()]
    printed = {process.communicate(timeout=60)[0] for process in both_at_once}
    assert [process.returncode for process in both_at_once] == [0, 0]
    later = start("must load")
    printed.add(later.communicate(timeout=60)[0])
    assert later.returncode == 0
    assert len(printed) == 1
    assert len(list(store.iterdir())) == 1
