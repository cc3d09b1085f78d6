"""The record of a finding, and of a kind of findings."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Literal, NamedTuple

from freebody.errors import IncludedLine
from freebody.outputs.display import InWords

if TYPE_CHECKING:
    from freebody.diagnosis.facts import RobotFacts
    from freebody.formats.urdf_elements import XmlElement

Severity = Literal["error", "warning", "notice"]
SEVERITIES: tuple[Severity, ...] = ("error", "warning", "notice")
"""Severities, the worst first: what no robot has or no reader takes; what is most likely wrong;
what is worth knowing."""
FileLine = int | IncludedLine | None


class AttributeChange(NamedTuple):
    """A change to a robot's file: a new value for an attribute of one of its elements."""

    element: XmlElement
    attribute: str
    value: str

    def __str__(self) -> str:
        was = self.element.attributes.get(self.attribute, "")
        return f'<{self.element.tag}> {self.attribute}="{was}" becomes "{self.value}"'


class FoundFault(NamedTuple):
    """One place where a fault applies: the reason, the line, and the changes that mend it where
    there is one sensible remedy; remedy: text in place of the kind's."""

    reason: str
    line: FileLine = None
    changes: Sequence[AttributeChange] = ()
    remedy: str = ""


@dataclass(frozen=True)
class FindingKind:
    """A kind of findings: its name, severity and remedy, and the function that finds it among the
    facts of a file."""

    name: str
    severity: Severity
    remedy: str
    find: Callable[[RobotFacts], Iterator[FoundFault]]


@dataclass(frozen=True, repr=False)
class Finding(InWords):
    """A fault of a file: its kind, how severe it is ("error", "warning" or "notice"), why it is
    one, what is to be done, and where it is.

    fix: what mending it changes, in words; () where there is no one sensible remedy.
    """

    kind: str
    severity: Severity
    reason: str
    remedy: str
    file: str
    line: int | None = None
    fix: tuple[str, ...] = ()
    changes: tuple[AttributeChange, ...] = field(default=(), repr=False, compare=False)

    def __str__(self) -> str:
        place = f"{self.file}:{self.line}" if self.line else self.file
        return f"{place}: {self.severity}: {self.reason}; {self.remedy}."

    def _title(self) -> str:
        return str(self)
