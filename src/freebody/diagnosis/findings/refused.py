"""Findings that the readers themselves report: a file that they refuse, repeated elements, and
whatever they make up or leave out that affects the motion."""

from __future__ import annotations

from collections.abc import Iterator

from freebody.diagnosis.facts import RobotFacts
from freebody.diagnosis.finding import FindingKind, FoundFault
from freebody.errors import FileError, IncludedLine


def _refused(facts: RobotFacts) -> Iterator[FoundFault]:
    problem = facts.refusal
    if isinstance(problem, FileError):
        line = problem.line and IncludedLine(problem.path, problem.line)
        yield FoundFault(problem.problem.rstrip("."), line)
    elif problem is not None:
        yield FoundFault(str(problem).rstrip("."))


def _doubled(facts: RobotFacts) -> Iterator[FoundFault]:
    for notice in facts.model.notices if facts.model else ():
        if notice.kind == "doubled":
            yield FoundFault(notice.text.rstrip("."), notice.line)


def _warned(facts: RobotFacts) -> Iterator[FoundFault]:
    for notice in facts.model.notices if facts.model else ():
        if notice.kind in _MADE_UP_OR_LEFT and notice.text.startswith(_WARNING):
            yield FoundFault(notice.text.removeprefix(_WARNING).rstrip("."), notice.line)


_WARNING = "warning: "
_MADE_UP_OR_LEFT = ("inertia", "ignored")
"""Kinds of notices on what a model has otherwise than its file."""

REFUSED = FindingKind("refused", "error", "until then no model is made of the file", _refused)
DOUBLED = FindingKind("given twice", "warning", "leave one", _doubled)
WARNED = FindingKind("read otherwise", "warning", "write what is meant, or load it so", _warned)
