"""Files: whole or not there, whoever's they are; names in them are only names."""

from __future__ import annotations

import ast
import base64
import errno
import hashlib
import json
import os
import random
import re
import signal
import subprocess
import sys
import time
from html.parser import HTMLParser
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
import xarray as xr

import freebody as fb
from freebody import FileError, OutputError
from freebody.outputs import files, folder
from freebody.outputs.files import stem, write
from freebody.outputs.folder import MANIFEST, write_folder
from freebody.outputs.harmless_text import as_meant, csv_text, harmless, legal
from support.command import run
from support.hostile import JOINTS, LINKS, hostile_study
from support.hostile_pages import LIVING, pages
from support.page_data import page_script
from support.sources import SOURCES, parsed, place

posix = pytest.mark.skipif(os.name != "posix", reason="devices and pipes")


@pytest.fixture(scope="module")
def arm(tmp_path_factory) -> fb.Study:
    return hostile_study(tmp_path_factory)


@pytest.fixture(autouse=True)
def in_a_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.chdir(tmp_path)


def error(capsys: pytest.CaptureFixture[str], *arguments: str) -> str:
    """The one line of a refused command."""
    assert run([*arguments]) == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert "fault of freebody" not in said
    return said.removeprefix("error: ").rstrip("\n")


# ---------------------------------------------------------------- one writer
def test_only_one_module_writes_files():
    """But for the cache of compiled code, which keeps its entries by the same rule under stricter
    ones of its own, the store of a sweep, which Zarr writes and clears of what was left half
    written, and in a folder of the system for a moment the text of an FMU, for the compiler, and a
    page, for the browser that prints it."""
    writers = {}
    for path in SOURCES:
        for node in ast.walk(parsed(path)):
            if isinstance(node, ast.Call) and _writes(node):
                writers.setdefault(place(path), []).append(node.lineno)
    known = {
        "outputs/files.py",
        "outputs/folder.py",
        "outputs/pdf.py",
        "targets/llvm/cache.py",
        "sweeps/store.py",
        "ways_out/fmus.py",
    }
    assert set(writers) == known, writers


def _writes(call: ast.Call) -> bool:
    name = call.func.attr if isinstance(call.func, ast.Attribute) else getattr(call.func, "id", "")
    if name in ("write_text", "write_bytes", "unlink", "makedirs", "mkdir", "touch", "savetxt"):
        return True
    if name in ("replace", "rename"):
        return ast.unparse(call.func).startswith("os.")
    if name in ("to_netcdf", "savez", "netcdf_file"):
        return any(not isinstance(a, ast.Constant) for a in call.args)
    if name == "open":
        return any(
            isinstance(a, ast.Constant) and re.search("[wax+]", str(a.value)) for a in call.args
        )
    return False


def test_a_file_is_replaced_whole_and_keeps_its_rights(tmp_path: Path):
    target = write(tmp_path / "new" / "a.txt", "θ\n")
    assert target.read_bytes() == "θ\n".encode()
    target.chmod(0o640)
    linked = tmp_path / "link"
    linked.symlink_to(target)
    write(linked, b"2")
    assert (target.read_bytes(), target.stat().st_mode & 0o777, linked.is_symlink()) == (
        b"2",
        0o640,
        True,
    )
    assert [p.name for p in target.parent.iterdir()] == ["a.txt"]


def test_a_file_is_on_the_disk_before_it_has_its_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    done = []

    class Recorded(Operations):
        def _counted(self, real, name: str):
            return lambda *arguments, **options: done.append(name) or real(*arguments, **options)

    monkeypatch.setattr(files, "os", Recorded(0, False))
    write(tmp_path / "a.txt", "a")
    assert done[1:] == [
        "open",
        "write",
        "fsync",
        "close",
        "replace",
        "open",
        "fsync",
        "close",
    ]  # the last: its folder


@posix
def test_a_file_whose_name_is_no_utf_8_can_be_studied(capsys: pytest.CaptureFixture[str]):
    fb.save(fb.load("2R"), "a.toml")
    text = Path("a.toml").read_text(encoding="utf-8").replace('name = "2R"', "", 1)
    path = os.fsdecode(b"\xff.toml")
    try:
        Path(path).write_text(text, encoding="utf-8")
    except OSError:
        pytest.skip("this disk holds UTF-8 names only")
    assert run(["study", path, "--out", "out"]) < 2, capsys.readouterr().err
    with xr.open_dataset("out/study.nc") as data:
        assert data.attrs["robot"] == "?"


@pytest.mark.parametrize("code", [errno.ENOSPC, errno.EACCES, errno.EROFS, errno.EIO])
def test_what_cannot_be_written_leaves_what_was_there(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, code: int
):
    target = write(tmp_path / "a.svg", "old")
    said = {
        errno.ENOSPC: "the disk is full",
        errno.EACCES: "no permission",
        errno.EROFS: "only be read",
    }

    def failing(descriptor, content):
        raise OSError(code, os.strerror(code))

    monkeypatch.setattr(files.os, "write", failing)
    with pytest.raises(FileError, match=rf"a\.svg: cannot be written: .*{said.get(code, 'error')}"):
        write(target, "new")
    assert [(p.name, p.read_text()) for p in tmp_path.iterdir()] == [("a.svg", "old")]


COMMANDS = (["derive", "pendulum", "--out"], ["fbd", "2R", "--out"])


@posix
@pytest.mark.parametrize("command", COMMANDS, ids=lambda c: c[0])
def test_a_folder_a_device_and_a_pipe_in_the_place_of_a_file(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, command: list[str]
):
    (tmp_path / "a.svg").mkdir()
    assert (
        error(capsys, *command, "a.svg")
        == "a.svg: cannot be written: there is a folder of that name."
    )
    (tmp_path / "full.svg").symlink_to("/dev/full")
    assert error(capsys, *command, "full.svg") == "full.svg: cannot be written: the disk is full."
    os.mkfifo("pipe.svg")
    assert (
        error(capsys, *command, "pipe.svg")
        == "pipe.svg: cannot be written: nobody reads from this pipe."
    )
    Path("file").write_text("")
    assert error(capsys, *command, "file/b.svg").endswith(
        "a part of the path is a file, not a folder."
    )
    assert error(capsys, "study", "2R", "--out", "/dev/full").endswith("name a folder instead.")


@pytest.mark.sample(1)
@posix
@pytest.mark.parametrize(
    ("shell", "code", "said"),
    [
        ("{} >&-", 2, "error: standard output: is closed; there is nowhere to print to.\n"),
        ("{} >/dev/full", 2, "error: standard output: cannot be written: the disk is full.\n"),
        ("{} 2>&-", 0, ""),
        ("{} | true; exit ${{PIPESTATUS[0]}}", 141, ""),
    ],
)
def test_a_stdout_that_is_closed_full_or_unread_is_no_fault_of_freebody(
    shell: str, code: int, said: str
):
    command = ["bash", "-c", shell.format(f"'{sys.executable}' -m freebody models")]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (code, said)


def test_a_robots_name_leads_out_of_no_folder(capsys: pytest.CaptureFixture[str], tmp_path: Path):
    (tmp_path / "in").mkdir()
    os.chdir(tmp_path / "in")
    fb.save(fb.load("2R"), "a.toml")
    text = Path("a.toml").read_text(encoding="utf-8")
    Path("a.toml").write_text(
        text.replace('name = "2R"', 'name = "../../evil\\u0000/C:\\\\x"', 1), encoding="utf-8"
    )
    assert run(["fbd", "a.toml"]) == 0
    assert sorted(p.name for p in tmp_path.iterdir()) == ["in"]
    assert sorted(p.name for p in Path().iterdir()) == ["a.toml", "evil_C_x-fbd.svg"]
    assert [stem(name) for name in ("ur5e", "..", "", "θ 1", "x" * 5000)] == [
        "ur5e",
        "robot",
        "robot",
        "θ_1",
        "x" * 60,
    ]


# ---------------------------------------------------------------- a folder of results
def test_any_name_goes_through_every_file(arm: fb.Study, tmp_path: Path):
    written = arm.save(tmp_path / "out", report=True)
    with xr.open_dataset(written[0]) as data:
        assert list(data["joint"].values) == JOINTS
        assert list(data["body"].values) == LINKS[1:]
        np.testing.assert_array_equal(data["tau"].values, arm.data["tau"].values)
        assert data.attrs["robot"] == arm.model.name
        names = [*data.attrs, *data.variables, *data.sizes]  # of the file's own, never of a joint
        assert all(name.isascii() and name.isidentifier() for name in names), names
        assert data["check_passed"].values.all()
    again = fb.study(arm.model, tmp_path / "out" / "motion.csv")
    np.testing.assert_array_equal(again.data["tau"].values, arm.data["tau"].values)


def test_no_cell_of_a_table_is_a_formula(arm: fb.Study, tmp_path: Path):
    import csv

    for path in arm.save(tmp_path / "out"):
        if path.suffix == ".csv":
            with path.open(encoding="utf-8", newline="") as file:
                cells = [cell for row in csv.reader(file) for cell in row]
            assert not [
                c
                for c in cells
                if re.match(r"[=+@\t\r]", c) or (c[:1] == "-" and not _is_number(c))
            ]
    assert (
        csv_text([["-1;=2", -1.5, np.float64("nan"), np.bool_(True)]]) == '"\'-1;=2",-1.5,,yes\r\n'
    )


def _is_number(cell: str) -> bool:
    try:
        return bool(float(cell)) or True
    except ValueError:
        return False


@pytest.mark.parametrize(
    "name", [*JOINTS, *LINKS, "", "'", "''=x", "'=x", "\t=", "＝1", "a=b", "-x.v"]
)
def test_a_harmless_cell_is_read_as_it_was_meant(name: str):
    assert as_meant(harmless(name)) == name
    assert not re.match(r"[=+\-@\t\r＝＋－＠]", harmless(name))


def checksums(folder: Path) -> dict[str, str]:
    return {
        p.name: hashlib.sha256(p.read_bytes()).hexdigest() for p in folder.iterdir() if p.is_file()
    }


def test_the_manifest_lists_the_run(tmp_path: Path):
    study = fb.study(fb.load("pendulum"))
    written = study.save(tmp_path, report=True)
    found, listed = checksums(tmp_path), json.loads((tmp_path / MANIFEST).read_text())
    assert [p.name for p in written] == [*listed["files"], MANIFEST]
    assert listed["complete"]
    assert (listed["failed"], listed["earlier"]) == ({}, {})
    del found[MANIFEST]
    assert found == listed["files"]
    study.save(tmp_path)  # now without the report
    later = json.loads((tmp_path / MANIFEST).read_text())
    assert later["run"] != listed["run"]
    assert later["earlier"] == {"report.html": listed["files"]["report.html"]}


def test_one_failed_output_costs_no_other(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
):
    Path("out/study.nc").mkdir(parents=True)
    Path("out/motion.csv").write_text("mine")
    Path("out/notes.txt").write_text("mine too")
    assert run(["study", "2R", "--out", "out"]) == 2
    said = capsys.readouterr()
    assert said.err.count("\n") == 1
    other = (
        "a file of this name was not written by freebody, or was changed since; move it, or "
        "choose another folder"
    )
    assert (
        said.err == f"error: out: not written: study.nc: {other}; motion.csv: {other}. "
        "The other 7 are there.\n"
    )
    assert "report: out/report.html\n" in said.out
    assert "data:" not in said.out
    listed = json.loads(Path("out", MANIFEST).read_text())
    assert not listed["complete"]
    assert listed["failed"] == {"study.nc": other, "motion.csv": other}
    assert Path("out/motion.csv").read_text() == "mine"
    assert checksums(Path("out")).keys() == {*listed["files"], "motion.csv", "notes.txt", MANIFEST}

    def broken(study):
        raise RuntimeError("planted")

    monkeypatch.setattr("freebody.report.study_files.netcdf", broken)
    with pytest.raises(
        OutputError, match=r"study\.nc: RuntimeError: planted \(an error in freebody"
    ) as failure:
        fb.study(fb.load("2R")).save("other")
    assert len(failure.value.written) == 7


def test_a_disk_that_fills_up_keeps_the_old_file_and_the_others(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    write_folder(tmp_path, {"a.nc": lambda: "old", "b.csv": lambda: "old"}, {})
    real = os.write

    def full(descriptor, content):
        if len(content) > 10_000:
            raise OSError(errno.ENOSPC, "full")
        return real(descriptor, content)

    monkeypatch.setattr(files.os, "write", full)
    with pytest.raises(
        OutputError, match=r"not written: a\.nc: the disk is full\. The other one is there\.$"
    ):
        write_folder(tmp_path, {"a.nc": lambda: "new" * 10_000, "b.csv": lambda: "new"}, {})
    listed = json.loads((tmp_path / MANIFEST).read_text())
    assert checksums(tmp_path).items() >= {**listed["earlier"], **listed["files"]}.items()
    assert (list(listed["earlier"]), list(listed["files"])) == (["a.nc"], ["b.csv"])
    assert (tmp_path / "a.nc").read_text() == "old"


@posix
def test_runs_that_write_into_one_folder_at_once_come_one_after_the_other(tmp_path: Path):
    """They deleted each other's half-written files, and left results that no manifest knew."""
    code = (
        "import sys; from freebody.outputs.folder import write_folder\n"
        "make = lambda k: lambda: (sys.argv[1] * 400_000 + str(k))\n"
        "for _ in range(8): write_folder(sys.argv[2], {f'{k}.csv': make(k) for k in range(6)}, "
        "{'run': sys.argv[1]})"
    )
    runs = [
        subprocess.Popen(
            [sys.executable, "-c", code, letter, str(tmp_path)], stderr=subprocess.PIPE, text=True
        )
        for letter in "abc"
    ]
    assert [(run.communicate(timeout=60)[1], run.returncode) for run in runs] == [("", 0)] * 3
    manifest = json.loads((tmp_path / MANIFEST).read_text())
    assert manifest["complete"]
    assert {
        name: hashlib.sha256((tmp_path / name).read_bytes()).hexdigest()
        for name in manifest["files"]
    } == manifest["files"]
    assert sorted(os.listdir(tmp_path)) == sorted([*manifest["files"], MANIFEST])


@posix
def test_a_folder_that_another_run_holds_too_long_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(folder, "PATIENCE", 0.0)
    with (
        folder._alone(tmp_path),
        pytest.raises(FileError, match="another run is writing into this folder"),
    ):
        write_folder(tmp_path, {"a.csv": lambda: "1"}, {})
    assert os.listdir(tmp_path) == []


def test_a_folder_with_another_manifest_is_refused_before_the_work(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
):
    Path("app").mkdir()
    listed = '{"format": "freebody results 1", "earlier": {}, "files": '
    for text in (
        '{"name": "my app"}',
        "[" * 100_000,
        "",
        f"{listed}1}}",
        f'{listed}{{"a": []}}}}',
        f'{listed}{{"../a": "{"0" * 64}"}}}}',
    ):
        Path("app", MANIFEST).write_text(text)
        said = error(capsys, "study", "2R", "--out", "app")
        assert (
            said == "app/manifest.json: this is not a manifest of freebody's results; "
            "name another folder."
        )
        assert Path("app", MANIFEST).read_text() == text


# ---------------------------------------------------------------- stopped anywhere
class Stopped(BaseException):
    """The process is gone."""


class Operations:
    """The system's file operations, of which the one of number `last` is never done (or its end not
    seen)."""

    NAMES = ("open", "write", "fsync", "close", "replace", "unlink", "makedirs")

    def __init__(self, last: float, after: bool):
        self.left, self.after = last, after

    def __getattr__(self, name: str):
        real = getattr(os, name)
        if name == "fsync":  # it counts, but a process that stops needs no disk that is up to date

            def real(descriptor: int) -> None:
                pass

        return self._counted(real, name) if name in self.NAMES else real

    def _counted(self, real, name: str):
        def call(*arguments, **options):
            self.left -= 1
            if self.left > 0:
                return real(*arguments, **options)
            if self.left == 0 and self.after:
                real(*arguments, **options)
            elif self.left == 0 and name == "write":
                real(arguments[0], arguments[1][: len(arguments[1]) // 2])
            elif name == "close":  # what a dead process has open is closed
                real(*arguments, **options)
            raise Stopped

        return call


def verdicts(folder: Path, old: dict[str, bytes], new: dict[str, bytes]) -> set[str]:
    """What the manifest says of each file, which is so."""
    text = (folder / MANIFEST).read_text()
    listed, said = json.loads(text), set()
    found = checksums(folder)
    for name, content in old.items():
        which = {
            hashlib.sha256(c).hexdigest(): w for c, w in ((content, "old"), (new[name], "new"))
        }[found[name]]
        is_of_the_run = listed["files"].get(name) == found[name]
        of_the_old = listed["about"]["run"] == "old"
        assert is_of_the_run == (which == ("old" if of_the_old else "new"))
        assert is_of_the_run or listed["earlier"].get(name) == found[name]
        said.add(which)
    if listed["complete"]:
        assert len(said) == 1
    return said


@pytest.mark.sample(1)
@pytest.mark.parametrize("after", [False, True], ids=["before", "after"])
def test_a_study_stopped_at_any_file_operation_leaves_whole_files_and_says_which(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, after: bool
):
    from freebody.outputs import folder as folders
    from freebody.report.study_files import makers

    def contents(name: str) -> dict[str, bytes]:
        made = {n: make() for n, make in makers(fb.study(fb.load(name)), True).items()}
        return {n: c if isinstance(c, bytes) else c.encode() for n, c in made.items()}

    def save(which: str, made: dict[str, bytes]) -> None:
        write_folder(tmp_path, {name: lambda c=c: c for name, c in made.items()}, {"run": which})

    old, new = contents("pendulum"), contents("2R")
    save("old", old)
    (tmp_path / "mine.txt").write_text("mine")
    before = {path: path.read_bytes() for path in tmp_path.iterdir()}
    seen, stopped = set(), 0
    for last in range(1, 1000):
        for path, content in before.items():
            path.write_bytes(content)
        operations = Operations(last, after)
        with monkeypatch.context() as patch:
            patch.setattr(files, "os", operations)
            patch.setattr(folders, "os", operations)
            try:
                save("new", new)
            except Stopped:
                stopped += 1
        seen.add(frozenset(verdicts(tmp_path, old, new)))
        assert (tmp_path / "mine.txt").read_text() == "mine"
        if operations.left > 0:
            break
    assert stopped > 40
    assert seen == {frozenset({"old"}), frozenset({"new"}), frozenset({"old", "new"})}
    save("new", new)
    assert {p.name for p in tmp_path.iterdir()} == {
        *new,
        MANIFEST,
        "mine.txt",
    }  # nothing half written stays


KILLED = """
import sys
import freebody as fb
studies = [fb.study(fb.load(name)) for name in ("pendulum", "RP")]
for k in range(1000):
    studies[k % 2].save("out", report=True)
    print(k, flush=True)
"""


@posix
@pytest.mark.long
def test_a_study_killed_at_random_moments_leaves_whole_files_and_says_which(tmp_path: Path):
    rng, mixed = random.Random(0), 0
    for _ in range(20):
        with subprocess.Popen(
            [sys.executable, "-c", KILLED], stdout=subprocess.PIPE, cwd=tmp_path
        ) as child:
            assert child.stdout is not None
            child.stdout.readline()
            time.sleep(rng.uniform(0, 0.8))
            child.send_signal(signal.SIGKILL)
        folder = tmp_path / "out"
        listed, found = json.loads((folder / MANIFEST).read_text()), checksums(folder)
        for name in {*listed["files"], *listed["earlier"]}:
            assert found[name] in (listed["files"].get(name), listed["earlier"].get(name))
        assert len(listed["files"]) == 8
        assert (folder / "report.html").read_text(encoding="utf-8").endswith("</html>")
        with xr.open_dataset(folder / "study.nc", engine="scipy") as data:
            assert np.isfinite(data["tau"].values).all()
        mixed += listed["complete"] is False
    assert mixed  # the moments were worth something


# ---------------------------------------------------------------- pages and drawings
class Tags(HTMLParser):
    """What a browser would run or fetch, and the policy with what stood before it."""

    def __init__(self, text: str):
        super().__init__()
        self.active, self.policy, self.before = [], None, []
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        given = dict(attrs)
        if given.get("http-equiv") == "Content-Security-Policy":
            self.policy = given["content"]
        elif self.policy is None:
            self.before.append(tag)
        if tag in ("script", "img", "iframe", "object", "embed", "base", "form") or any(
            k[:2] == "on" for k in given
        ):
            self.active.append((tag, given))


POLICY = (
    "default-src 'none'; script-src 'none'; style-src 'unsafe-inline'; img-src data: blob:; "
    "font-src data:; "
    "base-uri 'none'; form-action 'none'"
)


def test_every_page_has_the_policy_and_no_name_is_markup(arm: fb.Study):
    for name, text in pages(arm).items():
        parsed = Tags(text)
        scripts = re.findall("<script>(.*?)</script>", text, re.DOTALL)
        assert len(scripts) == (name in (*LIVING, "study")), name
        inflated = [page_script(text)] if name in LIVING else []
        assert parsed.policy == allowing([*scripts, *inflated]), name
        assert parsed.before == ["html", "head", "meta"], name
        assert parsed.active == [("script", {})] * len(scripts), name
        assert text == legal(text), name
        for drawings in re.findall(
            r"<figure[^>]*>(<svg.*?</svg>)(?=<figcaption|\s*<details|</figure)", text, re.DOTALL
        ):
            ElementTree.fromstring(f"<figure>{drawings}</figure>")


def allowing(scripts: list[str]) -> str:
    digests = [base64.b64encode(hashlib.sha256(x.encode()).digest()).decode() for x in scripts]
    listed = " ".join(f"'sha256-{digest}'" for digest in digests) or "'none'"
    return POLICY.replace("script-src 'none'", f"script-src {listed}")


def test_a_policy_names_the_scripts_that_may_run():
    from freebody.outputs.pages import policy

    # the example of the standard, Content Security Policy Level 3, section 2.3.1
    digest = "qznLcsROx4GACP2dm0UCKCzCG+HiZ1guq6ZZDob/Tng="
    assert f"script-src 'sha256-{digest}';" in policy(["alert('Hello, world.');"])


def test_drawings_are_well_formed_whatever_the_names(arm: fb.Study, tmp_path: Path):
    q = np.zeros(arm.model.nq)
    for figure in (fb.free_body_diagram(arm.model, q), fb.kinematic_diagram(arm.model)):
        tree = ElementTree.parse(figure.save(tmp_path / "a.svg"))
        drawn = {
            "svg",
            "style",
            "g",
            "path",
            "circle",
            "text",
            "tspan",
            "title",
            "rect",
            "line",
            "polygon",
        }
        assert {e.tag.rpartition("}")[2] for e in tree.iter()} <= drawn
    assert legal("a\0\x0b\x1b\u202e\ud800\ufffeθ\n") == "a" + "\ufffd" * 6 + "θ\n"
