"""`doctor`: the faults of a robot's file, each with its line, a reason and a remedy; and the file's
text with what is mended by the smallest changes, all other bytes as they were."""

from __future__ import annotations

import os
import re
import warnings
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from html import escape
from pathlib import Path
from typing import Any
from xml.parsers import expat

import numpy as np

from freebody.diagnosis import description_facts, urdf_facts
from freebody.diagnosis.facts import RobotFacts, elements_in
from freebody.diagnosis.finding import (
    SEVERITIES,
    AttributeChange,
    FileLine,
    Finding,
    FindingKind,
    FoundFault,
)
from freebody.diagnosis.findings import FINDINGS
from freebody.errors import FileError, FreebodyError, FreebodyWarning, IncludedLine
from freebody.formats import read_file, urdf
from freebody.formats.loading import SUFFIXES, ReadingOptions, read, weighed
from freebody.formats.packages import Packages, packages_around
from freebody.formats.urdf_elements import XmlElement, parse
from freebody.formats.xacro.expand import expanded
from freebody.model.build import build_model
from freebody.model.description import RobotDescription
from freebody.model.dh import Convention
from freebody.model.model import Model
from freebody.outputs.display import InWords, Tabled, TextTable, counted

_SNAP = 3e-9
"""rad, as `load` has it."""
_ROUNDS = 4
"""Times that what is mended is looked at again: one change may show the next fault."""


@dataclass(frozen=True, repr=False)
class Diagnosis(InWords, Tabled):
    """The findings on a file, in the order of its lines.

    mended: the file's text with all changes that have one sensible remedy, None where there are
    none; changes: those in words, with their lines.
    """

    file: str
    findings: tuple[Finding, ...]
    mended: bytes | None = field(default=None, repr=False)
    changes: tuple[str, ...] = ()

    @property
    def sound(self) -> bool:
        """Whether there is neither an error nor a warning."""
        return not any(finding.severity != "notice" for finding in self.findings)

    def of(self, severity: str) -> tuple[Finding, ...]:
        """The findings of one severity: "error", "warning" or "notice"."""
        return tuple(finding for finding in self.findings if finding.severity == severity)

    @property
    def title(self) -> str:
        """The file, and how many findings of each severity there are."""
        counts = Counter(finding.severity for finding in self.findings)
        told = ", ".join(counted(counts[x], x) for x in SEVERITIES if counts[x])
        return f"{self.file}: {told or 'no findings'}"

    @property
    def data(self) -> dict[str, Any]:
        """The diagnosis as plain data, such as JSON holds."""
        keys = ("kind", "severity", "reason", "remedy", "file", "line", "fix")
        findings = [{key: getattr(x, key) for key in keys} for x in self.findings]
        return {"file": self.file, "sound": self.sound, "findings": findings}

    def __str__(self) -> str:
        return "\n".join([*map(str, self.findings), self.title])

    def _title(self) -> str:
        return self.title

    def _table(self) -> TextTable:
        rows = [(str(x.line or ""), x.severity, x.kind, x.reason, x.remedy) for x in self.findings]
        return TextTable(("line", "severity", "kind", "reason", "remedy"), rows)


def doctor(
    path: str | os.PathLike[str],
    *,
    convention: Convention | None = None,
    package_path: Sequence[str | os.PathLike[str]] | str | os.PathLike[str] = (),
    xacro: Mapping[str, object] | None = None,
    xacro_environment: Sequence[str] | str = (),
) -> Diagnosis:
    """The faults of a robot's file: what no reader takes, what no robot has, and what is most
    likely wrong.

    Of URDF and xacro files each element is looked at, with its line; of other formats the links and
    joints that they describe. Meshes are held against masses where their files are there and
    trimesh is installed (freebody[mesh]).

    Parameters
    ----------
    path
        Path of a file, or the name of a bundled model.
    convention, package_path, xacro, xacro_environment
        How the file is read, as `load` has them.

    Returns
    -------
    Diagnosis
        Its `findings`, each with `kind`, `severity`, `reason`, `remedy`, `file` and `line`; of a
        URDF `mended`, the text with what has one sensible remedy.

    Raises
    ------
    FileError
        A file that is not there, or is no text of its format.
    FreebodyError
        A name that is not known, or an option that does not fit.
    """
    how = ReadingOptions.of(_SNAP, convention, package_path, xacro, xacro_environment)
    given = read_file.path_of("doctor", "path", path, "a robot's file")
    suffix = Path(given).suffix.lower()
    packages = packages_around(given, how.package_path)
    if suffix in (".urdf", ".xml"):
        data = read_file.read(given)
        root = parse(given, data)
        if root.tag == "robot":
            return _mended(given, data, root, packages)
    elif suffix == ".xacro":
        data = read_file.read(given)
        parse(given, data)
        return Diagnosis(given, _findings(_xacro_facts(given, data, packages, how)))
    return Diagnosis(given, _findings(_described(path, given, packages, how)))


# ------------------------------------------------------------ facts
def _urdf_facts(file: str, root: XmlElement, packages: Packages) -> RobotFacts:
    links, joints = urdf_facts.links_and_joints(root)
    model, refusal = None, None
    try:
        name = Path(file).stem.removesuffix(".urdf")
        model = _built(urdf.describe(root, file, name=name, snap_angles=_SNAP))
    except FreebodyError as problem:
        refusal = problem
    return RobotFacts(file, links, joints, packages, model, refusal, root)


def _xacro_facts(file: str, data: bytes, packages: Packages, how: ReadingOptions) -> RobotFacts:
    try:
        found = expanded(file, data, packages, how.xacro, how.xacro_environment)
    except FileError as problem:
        return RobotFacts(file, (), (), packages, None, problem)
    return _urdf_facts(file, found.root, packages)


def _described(
    path: str | os.PathLike[str], file: str, packages: Packages, how: ReadingOptions
) -> RobotFacts:
    known = Path(file).suffix.lower() in SUFFIXES
    if known:
        read_file.read(file)  # a file that is not there has no faults
    try:
        description = read(path, how)
    except FileError as problem:
        if not known:
            raise
        return RobotFacts(file, (), (), packages, None, problem)
    links, joints = description_facts.links_and_joints(description)
    model, refusal = None, None
    try:
        model = _built(description)
    except FreebodyError as problem:
        refusal = problem
    return RobotFacts(file, links, joints, packages, model, refusal, dim=description.dim)


def _built(description: RobotDescription) -> Model:
    """The model; its faults are findings, not warnings."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", FreebodyWarning)
        model = build_model(description, physical="warn", base=description.base)
        return weighed(model, description, False, False)


# ------------------------------------------------------------ findings
def _findings(facts: RobotFacts) -> tuple[Finding, ...]:
    found: list[Finding] = []
    for kind in FINDINGS:
        told = {(x.file, x.line) for x in found if x.severity == "error"}
        with np.errstate(all="ignore"):  # a mass of 1e-300 kg: what follows is infinite
            sightings = list(kind.find(facts))
        for one in sightings:
            # what a reader refuses is told once, by the finding that knows more about it
            if kind.name != "refused" or not told & _lines(facts, one.line):
                found.append(_finding(facts, kind, one))
    return tuple(sorted(found, key=lambda finding: finding.line or 0))


def _lines(facts: RobotFacts, line: FileLine) -> set[tuple[str, int | None]]:
    """File and line of each element that begins on a line, and of those inside it; of every element
    of the file where the line is None."""
    if facts.root is None:
        return {_place(facts, line)}
    return {
        _place(facts, inner.line)
        for element in elements_in(facts.root)
        if line is None or _place(facts, line) == _place(facts, element.line)
        for inner in elements_in(element)
    }


def _place(facts: RobotFacts, line: FileLine) -> tuple[str, int | None]:
    """File and line of a place, which may be in an included file."""
    return (line.file, line.line) if isinstance(line, IncludedLine) else (facts.file, line)


def _finding(facts: RobotFacts, kind: FindingKind, found: FoundFault) -> Finding:
    file, line = _place(facts, found.line)
    return Finding(
        kind.name,
        kind.severity,
        found.reason,
        found.remedy or kind.remedy,
        file,
        line,
        tuple(map(str, found.changes)),
        tuple(found.changes),
    )


def _mended(file: str, data: bytes, root: XmlElement, packages: Packages) -> Diagnosis:
    """The findings on a URDF, and its text with what can be mended."""
    facts = _urdf_facts(file, root, packages)
    findings = _findings(facts)
    diagnosis = Diagnosis(file, findings)
    told: list[str] = []
    for _ in range(_ROUNDS):
        changes = [change for finding in findings for change in finding.changes]
        if not changes or root.passed_over:
            break
        told += dict.fromkeys(f"{file}:{x.element.line}: {x}" for x in changes)
        data = changed(data, root, changes)
        root = parse(file, data)
        facts = replace(_urdf_facts(file, root, packages), filled=facts.filled)
        findings = _findings(facts)
        diagnosis = replace(diagnosis, mended=data, changes=tuple(told))
    return diagnosis


_ATTRIBUTE = rb"""\s(%s)\s*=\s*("[^"]*"|'[^']*')"""
_NAME = re.compile(rb"<[^\s/>]+")


def changed(data: bytes, root: XmlElement, changes: Sequence[AttributeChange]) -> bytes:
    """The text of a file with other values of attributes; root is what was read of it. An attribute
    that an element lacks is put behind its name. The first of several changes of one attribute
    counts."""
    start_of = dict(zip(map(id, elements_in(root)), _starts(data), strict=True))
    pieces: dict[tuple[int, int], bytes] = {}
    for element, attribute, value in changes:
        begin = start_of[id(element)]
        text = escape(value).encode()
        found = re.compile(_ATTRIBUTE % re.escape(attribute.encode())).search(
            data, begin, _end(data, begin)
        )
        if found:
            pieces.setdefault((found.start(2) + 1, found.end(2) - 1), text)
        else:
            name = _NAME.match(data, begin)
            assert name is not None
            pieces.setdefault((name.end(), name.end()), b' %s="%s"' % (attribute.encode(), text))
    for (begin, end), text in sorted(pieces.items(), reverse=True):
        data = data[:begin] + text + data[end:]
    return data


def _starts(data: bytes) -> list[int]:
    """The byte at which each element begins."""
    found: list[int] = []
    text = data.rstrip(b"\0")
    before = len(text) - len(text.lstrip()) if text.lstrip().startswith(b"<?xml") else 0
    parser = expat.ParserCreate()
    parser.StartElementHandler = lambda *_: found.append(before + parser.CurrentByteIndex)
    parser.Parse(text[before:], True)
    return found


def _end(data: bytes, begin: int) -> int:
    """The end of a start tag; what stands in quotes does not end it."""
    tag = re.compile(rb"""<(?:[^"'>]|"[^"]*"|'[^']*')*>""").match(data, begin)
    assert tag is not None
    return tag.end()
