"""An answer as a document, with the places of its formulas."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, field

from freebody.expressions.grammar.lexemes import Lexemes
from freebody.expressions.grammar.source import Span, decomposed
from freebody.lazy import cached_property
from freebody_textbook.check.documents.macros import expanded
from freebody_textbook.check.spelling.answer_text import AnswerError, AnswerText

LARGEST = 400_000
"""The most characters of a document; of its formulas fewer are read, see `AnswerText.longest`."""


@dataclass(frozen=True)
class FormulaPiece:
    """A stretch of a document that contains formulas."""

    start: int
    end: int
    lenient: bool = False
    """Whether an equation in it that cannot be read is passed over and told, where it is not about
    one of the robot's quantities."""


@dataclass(frozen=True)
class AnswerDocument:
    """A document's text as written, and a copy in which everything but formulas is blank."""

    written: str
    formulas: str
    pieces: tuple[FormulaPiece, ...]
    prose: tuple[Span, ...] = ()
    """Lines in which formulas may stand between words."""
    parts: tuple[tuple[str, int], ...] = ()
    """The cells of a notebook: what each is called and where it begins."""
    said: str = ""
    """The text that speaks to readers, formula or not, every character at its place: without
    comments, headings and declarations."""
    assigns: bool = False
    """Whether each equals sign gives a name a value of its own, as in code: where that is not read,
    nothing is taken for it."""
    told: bool = False
    """Whether it is a document, of which a verdict says the line of each equation."""
    strict: bool = False
    """Whether an equation about a quantity of the robot's that cannot be read raises an error;
    else it is told, and the verdict is not true."""

    @cached_property
    def lexemes(self) -> Lexemes:
        """The lexemes in the document's formulas."""
        return AnswerText(self.formulas).lexemes

    @property
    def tells_lines(self) -> bool:
        """Whether verdicts state the line number of each equation."""
        return self.told and "\n" in self.written.strip()


@dataclass(frozen=True)
class DocumentForm:
    """A file format of answers."""

    name: str
    words: str
    suffixes: tuple[str, ...]
    read: Callable[[str], AnswerDocument]


def plain_characters(text: str) -> str:
    """A text in normalised characters: own LaTeX commands expanded, accents decomposed,
    mathematical letters plain, line ends "\\n", = for all definition signs, blanks for equation and
    question numbers; raises AnswerError if it is too long."""
    if len(text) > LARGEST:
        raise AnswerError(f"the answer has {len(text)} characters; at most {LARGEST} are read")
    plain = decomposed(expanded(text.replace("\r\n", "\n").replace("\r", "\n")))
    plain = _DEFINED.sub(lambda sign: "=".rjust(len(sign[0])), plain)
    for number in (_NUMBER, _LABEL):
        plain = number.sub(lambda match: " " * len(match[0]), plain)
    return plain


_DEFINED = re.compile(
    r":=|[≡≔≜]|\\(?:equiv|coloneqq|triangleq|doteq)(?![A-Za-z])"
    r"|(?:[≈≃≅]|\\(?:approx|simeq|cong)(?![A-Za-z]))(?=\s?[-−]?\s?[0-9.])"
)
"""Signs of definition, and of an approximation by a number, which is read to its digits."""
_NUMBER = re.compile(
    r"(?:\\q?quad|\\hfill|\t|(?<=[ ]) )[ ]?\((?:\d{1,3}[.-]\d{1,3}[a-z]?|[A-Z]\.\d{1,3})\)"
    r"(?=[ ]?(?:\\\\|\$|\\\]|\n|$))"
)
"""The number of an equation at the end of its line and apart from it: (3.2), (A.4)."""
_LABEL = re.compile(
    r"^[ \t]{0,12}(?:\(?(?:[a-z]|[ivx]{1,4}|\d{1,2}[a-z]?)\)|(?:\d{1,2}\.|[*•‣])(?=[ \t])"
    r"|[^\W\d_]{1,12}\.?[ \t]?\(?\d{1,3}(?:\.\d{1,3})?[a-z]?\)?[ \t]?:)"
    r"(?=[ \t]{1,4}(?:[^\W\d_]|\\[a-zA-Z])[^\s=+*/()]{0,30}(?:\([^()=\n]{0,30}\))?[ \t]?=)",
    re.MULTILINE,
)
"""The label of a question or an equation in front of it: 1) H22 = …, (a), ii), Eq. (3):, and
bullets."""


@dataclass
class Blanks:
    """A text that can be changed while its length is kept."""

    text: str
    characters: list[str] = field(init=False)

    def __post_init__(self) -> None:
        self.characters = list(self.text)

    def __str__(self) -> str:
        return "".join(self.characters)

    def put(self, start: int, end: int, new: str = "") -> None:
        """Replace a stretch by a text that is at most as long, padded with blanks; line ends are
        kept."""
        for k in range(start, end):
            if self.characters[k] != "\n":
                self.characters[k] = " "
        self.characters[start : start + len(new)] = new

    def only(self, kept: list[Span], span: Span | None = None) -> None:
        """Replace everything in a stretch by blanks except the spans `kept`, which are in order."""
        at, stop = span or (0, len(self.characters))
        for start, end in [*kept, (stop, stop)]:
            self.put(at, max(at, start))
            at = max(at, end)

    def inside(self, span: Span) -> str:
        """The text of a stretch of the document, with blanks in place of what has been taken out of
        it."""
        return "".join(self.characters[slice(*span)])

    def replace(
        self,
        pattern: re.Pattern[str],
        new: str | Callable[[re.Match[str]], str] = "",
        span: Span | None = None,
        group: int = 0,
    ) -> None:
        """Replace a group of every match in a stretch; matches do not see beyond the stretch."""
        start, end = span or (0, len(self.characters))
        for match in pattern.finditer(self.inside((start, end))):
            first, behind = match.span(group)
            self.put(start + first, start + behind, new(match) if callable(new) else new)


def between(text: str, opening: str, closing: str) -> list[Span]:
    """The stretches between pairs of an opening and a closing mark, excluding the marks; takes
    linear time."""
    found, at = [], 0
    while (start := text.find(opening, at)) >= 0:
        end = text.find(closing, start + len(opening))
        if end < 0:
            break
        found.append((start + len(opening), end))
        at = end + len(closing)
    return found
