"""The verdict of `check`: equal, or where and why an answer differs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from freebody.errors import listed
from freebody.expressions.nodes import Expression
from freebody.outputs.display import InWords, counted


@dataclass(frozen=True)
class Mistake:
    """A mistake in an answer. kind: sign, factor, missing, extra, function, angle, length, index,
    rate, exponent, symbol, inverse, arguments, "missing factor", "extra factor" or "term"."""

    kind: str
    message: str
    yours: str = ""
    """The piece of the answer that is wrong."""
    right: str = ""
    """The right piece in its place."""
    line: int = 0
    column: int = 0
    context: str = ""
    """The line of the answer with carets below the place; "" where it is no single place."""


@dataclass(frozen=True)
class Example:
    """Numbers for the symbols at which the answer and the correct one differ."""

    values: Mapping[str, float]
    yours: float
    right: float


@dataclass(frozen=True)
class EquationVerdict:
    """The verdict on one equation of an answer."""

    name: str
    """The name as the answer writes it."""
    title: str
    """Name of the quantity in words."""
    equal: bool
    findings: tuple[Mistake, ...] = ()
    causes: tuple[str, ...] = ()
    """The thoughts that may be behind it, where a single one explains the whole difference."""
    example: Example | None = None
    example_text: str = ""
    note: str = ""
    where: str = ""
    """The equation's line in a document, "line 12"; "" of an answer without lines."""
    line: int = 0
    """The line of the whole answer that it stands in, from 1."""
    right: Expression | None = field(default=None, repr=False)
    """The right equation or right side, of a wrong one; None where that is no formula of a few
    lines."""

    @property
    def text(self) -> str:
        """The whole verdict on the equation in words."""
        where = f"{self.where}: " if self.where else ""
        if self.equal:
            return f"{where}{self.name} is right.{' ' if self.note else ''}{self.note}"
        lines = [f"{where}{self.name}, {self.title}, is not right."]
        lines += [f"  {cause}" for cause in self.causes]
        for finding in self.findings:
            lines.append(f"  {finding.message}")
            lines += [f"  {line}" for line in finding.context.splitlines()]
        if self.example_text:
            lines.append(f"  {self.example_text}")
        return "\n".join(lines)


@dataclass(frozen=True)
class UnreadEquation:
    """An equation of a document that was skipped."""

    at: int
    """The place in the text, by which equations are put in order."""
    where: str
    """The line of the equation, in words."""
    text: str
    """The equation as it is written, shortened."""
    reason: str
    is_asked: bool
    """Whether it is about one of the robot's quantities, so that something was left unchecked."""


@dataclass(frozen=True, repr=False)
class Verdict(InWords):
    """True when every equation of the answer is equal to the right one; `print` it to read why
    not."""

    equations: tuple[EquationVerdict, ...]
    model: str = field(default="", repr=False)
    unchecked: tuple[str, ...] = ()
    """Names on the left of lines that were read as names of the user's own, and that no other line
    uses: what they are said to be was not checked."""
    unread: tuple[UnreadEquation, ...] = ()
    """Equations of a document that could not be read."""
    answer: str = field(default="", repr=False)
    """The answer as it was written."""

    def _title(self) -> str:
        right = sum(equation.equal for equation in self.equations)
        mistakes = counted(len(self.findings), "mistake")
        return f"Verdict: {right} of {counted(len(self.equations), 'equation')} right, {mistakes}"

    def __bool__(self) -> bool:
        return all(x.equal for x in self.equations) and not self.left_out

    @property
    def left_out(self) -> tuple[UnreadEquation, ...]:
        """Equations about the robot's quantities that could not be read."""
        return tuple(x for x in self.unread if x.is_asked)

    @property
    def findings(self) -> tuple[Mistake, ...]:
        """The mistakes in all equations."""
        return tuple(finding for equation in self.equations for finding in equation.findings)

    @property
    def causes(self) -> tuple[str, ...]:
        """Misconceptions that may explain wrong equations."""
        return tuple(cause for equation in self.equations for cause in equation.causes)

    @property
    def text(self) -> str:
        """The verdict in words, equation by equation."""
        lines = [equation.text for equation in self.equations]
        if self.unchecked:
            lines.append(
                f"Not checked: {listed(self.unchecked, 8)}; no quantity of the robot has such a "
                f"name. fb.quantities lists them all; what a name of your own stands for is said "
                f"by names= (--name)."
            )
        lines += [f"Not read, {x.where}: {x.text}: {x.reason}." for x in self.unread]
        return "\n".join(lines)

    def __str__(self) -> str:
        return self.text

    def html(self) -> str:
        """The verdict as a page that needs no network: the answer with a mark at each of its
        equations, why it is wrong, and folded away what would be right."""
        from freebody_textbook.check.verdict_page import verdict_page

        return verdict_page(self)
