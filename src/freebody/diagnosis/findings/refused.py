"""Findings that the readers themselves tell: a file that they refuse, and equal elements twice."""

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


REFUSED = FindingKind("refused", "error", "until then no model is made of the file", _refused)
DOUBLED = FindingKind("given twice", "warning", "leave one", _doubled)
