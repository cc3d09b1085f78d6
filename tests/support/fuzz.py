"""Wrong input by the thousand, the same for the same seed: seeds of tests/corpus, cut, spliced,
repeated and peppered.

A case is right when its reader takes it, or refuses it with an error of freebody, in little time,
and touches no file but the one that it was given.
"""

from __future__ import annotations

import os
import random
import re
import signal
import sys
import tempfile
import time
import traceback
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from unittest import mock

import freebody as fb
from support.command import told
from support.mujoco_server import MujocoServer

CORPUS = Path(__file__).parent.parent / "corpus"
SECONDS = 5.0
"""CPU time that a case may take."""
BYTES = 600 << 20
"""Memory by which all cases of a run together may make the process grow."""


def dictionary(name: str) -> list[str]:
    """Words of a kind of text, or what might be taken for a number."""
    return (CORPUS / "dictionary" / f"{name}.txt").read_text(encoding="utf-8").split("\n")[:-1]


ROBOTS = ("urdf", "xacro", "mjcf", "sdf", "toml", "dh")
"""The kinds that are formats of robots."""
KINDS = (*ROBOTS, "motion", "check", "values", "word", "name")
NUMBERS = [*dictionary("numbers"), "9" * 5000, "0." + "1" * 3000, "1e" + "9" * 400]
WORDS = {kind: dictionary(kind) for kind in KINDS}
MARKS = list("\"'[]{}()<>=,.;:#&|\\/^*+-_ \t\n\r\0\x0b\x1b\x85\u2028\ufeff\u202e°²θ̇½") + [
    "\r\n", '"""', "'''", "<!--", "]]>", "<![CDATA[", "&amp;", "&#0;", "&lt;", "<?",
    "<!DOCTYPE a [<!ENTITY b 'c'>]>", "\udc80",
    "\ud800", "${x}", "../../x", "%s", "{0}",
]  # fmt: skip
_NUMBER = re.compile(r"[-+]?\d+\.?\d*(?:[eE][-+]?\d+)?")
_WORD = re.compile(r"[A-Za-z_\\]\w*")


def seeds(kind: str) -> list[str]:
    """The texts of a corpus; of kinds that are lines, each line."""
    texts = [path.read_text(encoding="utf-8") for path in sorted((CORPUS / kind).iterdir())]
    return texts if kind in (*ROBOTS, "motion", "check") else "".join(texts).splitlines()


def cases(kind: str, seed: int) -> Iterator[bytes]:
    """Wrong inputs without end."""
    draw = random.Random(f"{kind} {seed}")
    texts = seeds(kind)
    while True:
        text = draw.choice(texts)
        for _ in range(draw.choice((1, 1, 1, 2, 2, 3, 5, 9))):
            text = draw.choice(_CHANGES)(text, draw, kind, texts)[:300_000]
        data = text.encode("utf-8", "surrogatepass")
        if draw.random() < 0.05:
            data = _broken(data, draw)
        yield data


def _place(text: str, draw: random.Random) -> tuple[int, int]:
    """A short piece of a text."""
    start = draw.randrange(len(text) + 1)
    return start, min(len(text), start + draw.choice((0, 1, 1, 2, 5, 20, 100, 1000)))


def _cut(text: str, draw: random.Random, kind: str, texts: list[str]) -> str:
    a, b = _place(text, draw)
    return text[:a] + text[b:] if draw.random() < 0.8 else text[:a]


def _repeat(text: str, draw: random.Random, kind: str, texts: list[str]) -> str:
    a, b = _place(text, draw)
    times = draw.choice((2, 2, 3, 10, 100, 3000))
    return text[:a] + (text[a:b] * times)[:100_000] + text[b:]


def _splice(text: str, draw: random.Random, kind: str, texts: list[str]) -> str:
    other = draw.choice(texts)
    a, b = _place(text, draw)
    c, d = _place(other, draw)
    return text[:a] + other[c:d] + text[b:]


def _pepper(text: str, draw: random.Random, kind: str, texts: list[str]) -> str:
    a, b = _place(text, draw)
    new = draw.choice(draw.choice((MARKS, MARKS, NUMBERS, WORDS[kind])))
    return text[:a] + new + text[draw.choice((a, b)) :]


def _replace(
    pattern: re.Pattern[str], choose: Callable[[random.Random, str], str]
) -> Callable[..., str]:
    """A change of one piece that the grammar knows for another."""

    def change(text: str, draw: random.Random, kind: str, texts: list[str]) -> str:
        found = list(pattern.finditer(text))
        if not found:
            return text
        match = draw.choice(found)
        return text[: match.start()] + choose(draw, kind) + text[match.end() :]

    return change


def _lines(text: str, draw: random.Random, kind: str, texts: list[str]) -> str:
    """A line moved, doubled or left out."""
    lines = text.split("\n")
    k = draw.randrange(len(lines))
    line = lines.pop(k) if draw.random() < 0.6 else lines[k]
    if draw.random() < 0.7:
        lines.insert(draw.randrange(len(lines) + 1), line)
    return "\n".join(lines)


_CHANGES: tuple[Callable[..., str], ...] = (
    _cut,
    _repeat,
    _splice,
    _pepper,
    _lines,
    _replace(_NUMBER, lambda draw, kind: draw.choice(NUMBERS)),
    _replace(_NUMBER, lambda draw, kind: repr(draw.gauss(0.0, 1.0) * 10 ** draw.uniform(-30, 30))),
    _replace(_WORD, lambda draw, kind: draw.choice(WORDS[kind])),
    _replace(_WORD, lambda draw, kind: draw.choice(NUMBERS + MARKS)),
)


def _broken(data: bytes, draw: random.Random) -> bytes:
    """Bytes that may be no text, or text in another encoding."""
    if draw.random() < 0.5:
        with_mark = draw.choice(("utf-16", "utf-32", "utf-8-sig", "latin-1", "utf-16-le"))
        return data.decode("utf-8", "replace").encode(with_mark, "replace")
    changed = bytearray(data)
    for _ in range(draw.randrange(1, 6)):
        if changed:
            changed[draw.randrange(len(changed))] = draw.randrange(256)
    return bytes(changed)


# ---------------------------------------------------------------- readers
def _model(path: Path) -> None:
    """Loads a robot, and asks what one asks of a robot first."""
    model = fb.load(path)
    _ = model.limits, model.position_names, model.driven_names, str(model.notices), model.leaves
    with unwatched():
        fb.save(model, path.with_name("again.toml"))
    if not model.missing:
        _ = model.mass, model.tree


_mujoco = MujocoServer()


def _mjcf(path: Path) -> None:
    """Loads a robot; MuJoCo's process is the server."""
    with unwatched(), mock.patch("subprocess.run", _mujoco.run):
        _model(path)


def _positions(text: str) -> None:
    """Reads positions as the command line does, for the diagram of a body that there is not."""
    _, said = told(["fbd", "2R", "--body", "none", f"--q={text}"])
    assert "an error in freebody" not in said, said
    raise fb.FreebodyError(said)


def _text(data: bytes) -> str:
    return data.decode("utf-8", "surrogateescape")


def readers() -> dict[str, tuple[str, Callable[[Path, bytes], Any]]]:
    """For each kind the suffix of its file, and what reads it."""
    arm = fb.load("2R")
    return {
        "urdf": (".urdf", lambda path, data: _model(path)),
        "xacro": (".xacro", lambda path, data: _model(path)),
        "mjcf": (".xml", lambda path, data: _mjcf(path)),
        "sdf": (".sdf", lambda path, data: _model(path)),
        "toml": (".toml", lambda path, data: _model(path)),
        "dh": (".csv", lambda path, data: _model(path)),
        "motion": (".csv", lambda path, data: fb.read_motion(arm, path)),
        "check": (".txt", lambda path, data: fb.check(arm, _text(data)).text),
        "values": (".txt", lambda path, data: _positions(_text(data))),
        "word": (".txt", lambda path, data: fb.planar(_text(data)).limits),
        "name": (".txt", lambda path, data: fb.load("2R", tip=_text(data))),
    }


class Hang(BaseException):
    """A case took too long."""


_watch: dict[str, Any] = {"on": False, "allowed": "", "touched": []}


def _audit(event: str, arguments: tuple[Any, ...]) -> None:
    """Notes whatever leaves the process but the reading of the case's own file."""
    if not _watch["on"]:
        return
    if event == "open":
        path, mode, flags = arguments
        reads = not flags & (os.O_WRONLY | os.O_RDWR)
        # a number is what was opened before; the program and its data are its own; a file may
        # name its neighbours, and what says of a folder which package it is
        own = isinstance(path, int) or (
            os.path.dirname(str(path)) == os.path.dirname(_watch["allowed"])
            or str(path).endswith((".py", ".pyc", ".toml", "/package.xml"))
        )
        if not (reads and own):
            _watch["touched"].append((event, str(path), mode))
    elif event in ("os.putenv", "os.unsetenv") and arguments[0].startswith(b"PYDANTIC_"):
        pass  # the reader of commands does so for as long as it validates
    elif event.startswith(_DOINGS) and event not in (
        "os.listdir",
        "os.scandir",
    ):  # names of models, of files nearby
        _watch["touched"].append((event, *map(str, arguments)))


_DOINGS = ("os.", "subprocess.", "socket.", "shutil.", "ctypes.dlopen", "pickle.")
_audited: list[bool] = []


@contextmanager
def watched(path: Path) -> Iterator[None]:
    """Within the block a case has its time, and its accesses are noted."""
    if not _audited:
        sys.addaudithook(_audit)
        _audited.append(True)

    def late(*_: object) -> None:
        raise Hang

    before = signal.signal(signal.SIGPROF, late)
    _watch.update(on=True, allowed=str(path), touched=[])
    signal.setitimer(signal.ITIMER_PROF, SECONDS)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        _watch["on"] = False
        signal.signal(signal.SIGPROF, before)


@contextmanager
def unwatched() -> Iterator[None]:
    """Within the block accesses are meant."""
    before, _watch["on"] = _watch["on"], False
    try:
        yield
    finally:
        _watch["on"] = before


def fault(kind: str, data: bytes, path: Path, read: Callable[[Path, bytes], Any]) -> str | None:
    """What is wrong with how a case is read, or None; a text is given as such, not in a file."""
    if path.suffix != ".txt":
        path.write_bytes(data)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.simplefilter("ignore", fb.FreebodyWarning)
        try:
            with watched(path):
                read(path, data)
        except fb.FreebodyError as error:
            if len(str(error)) > 5000:
                return f"an error of {len(str(error))} characters"
        except Hang:
            return f"more than {SECONDS} s"
        except Exception as error:
            place = traceback.extract_tb(error.__traceback__)[-1]
            return f"{type(error).__name__} in {Path(place.filename).name}:{place.lineno}: {error}"[
                :300
            ]
    return f"touched {_watch['touched'][:3]}" if _watch["touched"] else None


def run(
    kind: str, seed: int, goes_on: Callable[[int], bool]
) -> tuple[int, list[tuple[str, bytes]]]:
    """Cases as long as goes_on(number of cases); how many there were, and those that went wrong,
    with what did."""
    suffix, read = readers()[kind]
    wrong: list[tuple[str, bytes]] = []
    memory = (
        "/dev/shm" if Path("/dev/shm").is_dir() else None
    )  # a disk takes longer than the reading
    with tempfile.TemporaryDirectory(dir=memory) as folder:
        path = Path(folder) / f"case{suffix}"
        for text in seeds(kind):  # for what is imported and compiled once
            fault(kind, text.encode(), path, read)
        count, before = 0, _most_memory()
        for data in cases(kind, seed):
            if not goes_on(count):
                break
            count += 1
            problem = fault(kind, data, path, read)
            if problem is not None:
                wrong.append((problem, data))
            if _most_memory() - before > BYTES:
                wrong.append((f"the process grew by {_most_memory() - before} bytes", data))
                before = _most_memory()
    return count, wrong


def _most_memory() -> int:
    """The most that the process has had, in bytes."""
    import resource  # where there is a timer of CPU time, as the cases need

    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss << (sys.platform != "darwin") * 10


if __name__ == "__main__":  # python tests/support/fuzz.py KIND CASES [SEED]
    most = int(sys.argv[2])
    began = time.monotonic()
    number, found = run(
        sys.argv[1], int(sys.argv[3]) if len(sys.argv) > 3 else 0, lambda n: n < most
    )
    kinds = {problem.split(":")[0] + problem[-30:]: (problem, data) for problem, data in found}
    for k, (problem, data) in enumerate(kinds.values()):
        Path(f"{sys.argv[1]}-{k}.case").write_bytes(data)
        print(f"{sys.argv[1]}-{k}.case: {problem}: {data[:100]!r}")
    took = time.monotonic() - began
    print(f"{sys.argv[1]}: {number} cases, {len(found)} wrong, {took:.0f} s")
