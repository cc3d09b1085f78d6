"""Results in numbers as a document has them: τ₁ = 12.3 N m at θ₁ = 30°, θ₂ = 45°. Units, tolerances
and states are noted and taken away; the numbers stay."""

from __future__ import annotations

import re
from dataclasses import replace

from freebody.derivations.check.documents.answer_document import AnswerDocument, Blanks
from freebody.derivations.check.numbers.results import WrittenNumber, WrittenNumbers
from freebody.derivations.check.numbers.states import (
    NO_STATE,
    GivenValue,
    State,
    StateReader,
)
from freebody.derivations.check.numbers.units import unit_of_quantity
from freebody.derivations.check.numbers.written_units import WrittenUnit, unit_at
from freebody.derivations.check.spelling.answer_text import AnswerText
from freebody.derivations.check.spelling.equation_marks import asked_marks
from freebody.derivations.check.spelling.formula_spellings import FILL, respelt
from freebody.derivations.grammar.source import Span
from freebody.derivations.polynomials.symbols import RATE, SECOND

_RESULT = re.compile(
    r"(?:(?<![\w.^_,])(?:\d{1,30}(?:[.,]\d{0,30})?|\.\d{1,30})(?:[eE][-+]?\d{1,3})?|[\])]"
    r"|\\end\s?\{\w?matrix\}(?:\s?\\right\s?[\])])?)(?=(?:[\s~$]|\\[,;:! )]){0,4}"
    r"(?P<pm>(?:±|\\pm|\+/-|\+-)\s?(?P<within>\d{1,30}(?:\.\d{0,30})?))?)"
)
"""The end of a number or of a vector, and a tolerance behind it."""
_STILL = r"in\s(?:static|equilibrium)|held\s"
_CLAUSE = re.compile(
    r"(?:[\s~$]|\\[,;:! ()\]]|\\(?:text|mbox|textrm)\s?\{)*"
    rf"(?:,?\s?(?:(?:at|for|when|where|with|if)\b|(?={_STILL}))|[@,;(])[\s~}}$]*"
)
_SENTENCE = re.compile(
    r"(?:^|(?<=[.:;]\s))[^\S\n]{0,12}(?:(?:[-*>]|\(?\w{1,2}[.)])[^\S\n]{1,4})?(?:\*\*|__)?",
    re.MULTILINE,
)
_WORD = re.compile(r"[^\W\d_]{1,20}[,:]?(?:\*\*|__)?(?=\s?[$\s])[^\S\n]?")
_MOST_WORDS = 8
_KEYWORDS = ("at", "for", "with", "when", "given", "let", "if")
_WHERE = re.compile(
    rf"(?<=[\w)}}\]²³])[\s~$]{{1,4}}(?=(?:at|for|when|where|with|if)[\s~$]|{_STILL})"
)
_COLON = re.compile(r"[\s~$]{0,3}:")
_ALONE = re.compile(r"(?:[=\[;]|,\s)[\s~$&]{0,4}[-−+]?\s?$")
_SENTENCE_END = re.compile(r"(?:[\s~$}]|\\[,;:! )])*(?:[.:,;)]|$)", re.MULTILINE)
_LONE = re.compile(
    r"=[\s~$&\[({]{0,6}[-+−]?\s?(?:\d{1,30}(?:\.\d{0,30})?|\.\d{1,30})(?:[eE][-+]?\d{1,3})?"
    r"(?:[^\S\n]|[~$}]|\\[,;:! )\]])*(?:[.,;\]&)]|\\\\|$)",
    re.MULTILINE,
)
_EQUALS = re.compile(r"\s?&?\s?=")
_GOES_ON = re.compile(r"\s?(?:[*/^·×(]|\\cdot|\\times|\\frac|[+−-])")
_IN_HEAD = re.compile(
    r"(?:(?P<open>[\[(])|/|\bin\b)\s{0,3}(?P<unit>[^\[\]()=\n]{1,40}?)\s{0,3}(?(open)[\])])"
    r"[\s~$&]{0,4}=(?!=)"
)
"""A unit in front of the sign of equality: τ1 [N m] = …, τ1 / N m = …"""
_STOP = re.compile(
    r"(?:[^\S\n]|[~$}]|\\[,;:! )\]])*(?:[.,;\]&)]|\\\\|±|\\pm|\+/-|\+-|$)", re.MULTILINE
)
_SEPARATOR = re.compile(r"[;\[\n]|\\\\|,\s")
_LONGEST_NAME = 40
_LONGEST = 600
"""Characters of an equation in front of a result."""


def taken_from(
    document: AnswerDocument, reader: StateReader
) -> tuple[AnswerDocument, WrittenNumbers]:
    """A document without units and states, and what they say; one without numbers as it is."""
    search = _NumberSearch(document, reader)
    numbers = search.numbers()
    if not (numbers or search.heads) and not (search.standing and search.has_result):
        return document, WrittenNumbers()
    formulas, said = Blanks(respelt(document.formulas)), Blanks(document.said)
    for start, end in search.taken:
        formulas.put(start, end)
        if document.said:
            said.put(start, end)
    for start, end in search.units:  # shown with its number
        formulas.put(start, end, FILL * (end - start))
    return replace(document, formulas=str(formulas), said=str(said)), WrittenNumbers(
        numbers, search.standing
    )


class _NumberSearch:
    """The numbers of a document; `taken`: what is read here and need not be read again."""

    def __init__(self, document: AnswerDocument, reader: StateReader):
        self.document, self.reader = document, reader
        text = respelt(document.said or document.formulas)
        self.source = AnswerText(text, document.written, document.parts)
        self.text = "\n".join(line.partition("#")[0].ljust(len(line)) for line in text.split("\n"))
        self.taken: list[Span] = []
        self.is_taken = bytearray(len(text))
        """Of each character, whether it is in one of these."""
        self.units: list[Span] = []
        self.standing: list[tuple[int, dict[str, GivenValue]]] = []
        self.heads: dict[int, tuple[WrittenUnit, Span]] = {}
        """Units in front of signs of equality, by the place behind the sign."""

    def numbers(self) -> list[WrittenNumber]:
        if "=" not in self.text:
            return []
        self._read_standing()
        self._read_heads()
        places = [*_RESULT.finditer(self.text), *_WHERE.finditer(self.text)]
        places.sort(key=lambda match: match.start())
        found = [x for match in places if (x := self._said_behind(match))]
        for k in reversed(range(len(found) - 1)):  # τ1 = 1 N m, τ2 = 2 N m at …
            x, behind = found[k], found[k + 1]
            between = self.text[x.span[1] : behind.span[0]]
            if not x.state and between and "\n" not in between:
                found[k] = replace(x, state=behind.state)
        return found

    @property
    def has_result(self) -> bool:
        """Whether a quantity is said to be a number, or a state is one for what follows."""
        if any(_COLON.match(self.text, end) for end, _ in self.standing):
            return True
        quantities = self.reader.targets.names - self.reader.vocabulary.symbols.keys()
        marks = asked_marks(self.text, (0, len(self.text)), quantities.__contains__)
        return any(_LONE.match(self.text, mark) for _, mark in marks)

    # ------------------------------------------------------------ states before numbers
    def _read_standing(self) -> None:
        """States on lines of their own, or at the begin of a sentence: At θ₁ = 30° …"""
        for match in _SENTENCE.finditer(self.text):
            if self.taken and match.end() < self.taken[-1][1]:
                continue
            start, values, end, word = self._list_behind_words(match.end())
            is_alone = not self._is_result(values) and _SENTENCE_END.match(self.text, end)
            if values and (word in _KEYWORDS or is_alone):
                begun = {} if not self.standing else self.standing[-1][1]
                moving = {name for name in values if not self._is_constant(name)}
                if moving & set(begun):  # another state
                    begun = {name: x for name, x in begun.items() if self._is_constant(name)}
                self.standing.append((end, {**begun, **values}))
                colon = _COLON.match(self.text, end)
                self._take(match.start() if colon else start, colon.end() if colon else end)

    def _is_result(self, values: State) -> bool:
        """Whether a value is that of an acceleration of a body that nothing holds, which forces
        make."""
        free = self.reader.vocabulary.setting.is_free_body
        return free and any(name.endswith((RATE, SECOND)) for name in values)

    def _list_behind_words(self, at: int) -> tuple[int, dict[str, GivenValue], int, str]:
        """A list of values behind a few words, where it stands, and the last of the words."""
        word = ""
        for _ in range(_MOST_WORDS):
            values, end = self.reader.list_at(self.source, at)
            match = _WORD.match(self.text, at)
            if values or match is None:
                return at, values, end, word
            word, at = match[0].strip(" ,:*_"), match.end()
            vocabulary = self.reader.vocabulary
            if word in vocabulary.known or word in vocabulary.functions or word.lower() in NO_STATE:
                return at, {}, at, ""  # cos θ₂ = 0
            word = word.lower()
        return at, {}, at, word

    def _take(self, start: int, end: int) -> None:
        end = self._behind_padding(end)
        self.taken.append((start, end))
        self.is_taken[start:end] = b"\1" * (end - start)

    def _behind_padding(self, at: int) -> int:
        while self.text[at : at + 1] == FILL:
            at += 1
        return at

    def _is_constant(self, name: str) -> bool:
        symbols = self.reader.vocabulary.setting.symbols
        return name.partition("_d")[0] not in symbols.coordinates

    # ------------------------------------------------------------ units before numbers
    def _read_heads(self) -> None:
        """Units in front of signs of equality; behind a quantity that has it, it says nothing."""
        known, quantities = self.reader.vocabulary.known, self.reader.targets.names
        for match in _IN_HEAD.finditer(self.text):
            found, sign = unit_at(self.text, match.start("unit")), match.end() - 1
            left = self.text[max(0, match.start() - _LONGEST_NAME) : match.start()] + "="
            is_asked = any(True for _ in asked_marks(left, (0, len(left)), quantities.__contains__))
            if found is None or found[1] != match.end("unit") or not is_asked:
                continue
            if match["open"] != "[" and set(found[0].words) <= known:  # G(m), G2/m
                continue
            self.heads[match.end()] = found[0], (match.start(), sign)
            if found[0].factor == 1.0 and self._may_have(found[0], match.end()):
                self._take(match.start(), sign)

    def _unit_in_head(self, begun: int, number: Span) -> WrittenUnit | None:
        """The unit in front of the sign of equality where a number that stands alone begins."""
        unit, span = self.heads.get(begun, (None, (0, 0)))
        before = self.text[begun : number[0]]
        alone = self.text[number[0]] == "]" or not before.strip(" \t~$&{+-−")
        ends = _STOP.match(self.text, number[1]) or self._clause(number[1])[0]
        if unit is None or not alone or not ends:
            return None
        self._take(*span)
        return unit

    # ------------------------------------------------------------ numbers
    def _said_behind(self, match: re.Match[str]) -> WrittenNumber | None:
        return self._number(match) if match.re is _RESULT else self._expression(match)

    def _number(self, match: re.Match[str]) -> WrittenNumber | None:
        """What is said behind a number, if it is a result."""
        start, end = match.start(), match.end()
        if self.is_taken[start] or not self.document.formulas[start].strip():
            return None
        at = match.end("pm") if match["pm"] else end
        unit = self._unit(at, start)
        if unit and "\n" in self.text[at : unit[1]] and _EQUALS.match(self.text, unit[1]):
            unit = None  # N = … on the next line
        stop = unit[1] if unit else at
        own, behind = self._clause(stop)
        line = self._begin(start)
        if match[0] == "]" or match[0].startswith("\\"):
            line = self.text.rfind("=", 0, start) + 1
        begun = max(self.text.rfind("=", line, start) + 1, line)
        head = None if unit else self._unit_in_head(begun, (start, at))
        if not (own or unit or match["pm"] or head):
            return None
        inside = self.text.count("(", begun, end) > self.text.count(")", begun, end)
        if inside or begun == max(0, start - _LONGEST):
            return None
        if unit and "," in match[0]:
            self.source.fail("a decimal comma: write a point", (start, end))
        self._take(end, behind)
        self.units.append((end, self._behind_padding(stop)))
        within = match["within"] or ""
        return WrittenNumber(
            (begun, end), line, (end, behind), unit[0] if unit else head, within, own
        )

    def _expression(self, match: re.Match[str]) -> WrittenNumber | None:
        """The state behind an expression in symbols."""
        end = match.start()
        own, behind = self._clause(end)
        line = self._begin(end)
        begun = self.text.rfind("=", line, end) + 1
        if not own or not begun or self.is_taken[end]:
            return None
        self._take(end, behind)
        return WrittenNumber((begun, end), line, (end, behind), state=own)

    def _begin(self, at: int) -> int:
        """Where the equation begins that goes on there."""
        first = max(0, at - _LONGEST)
        return max((m.end() for m in _SEPARATOR.finditer(self.text, first, at)), default=first)

    def _unit(self, at: int, number: int) -> tuple[WrittenUnit, int] | None:
        """The unit there. Where its words are symbols too, as m of a pendulum, it is one where the
        quantity has it."""
        found = unit_at(self.text, at)
        if found is None:
            return None
        unit, end = found
        if unit.text == "°" and not _ALONE.search(self.text, max(0, number - 12), number):
            return None  # cos 75°
        if _GOES_ON.match(self.text, end) and not self._clause(end)[0]:
            return None
        is_name = set(unit.words) <= self.reader.vocabulary.known
        if is_name and not self._may_have(unit, number):
            return None
        return unit, end

    def _may_have(self, unit: WrittenUnit, at: int) -> bool:
        """Whether a quantity that stands before the last equals signs there has such a unit."""
        start = max(self.text.rfind("\n", 0, at) + 1, at - _LONGEST)
        single, setting = self.reader.targets.single, self.reader.vocabulary.setting
        for left, mark in asked_marks(self.text, (start, at), single.__contains__):
            name = re.sub(r"[_{}\\\s]|[\[(/].*|\bin\b.*", "", self.text[left:mark])
            for target in (single.get(name), single.get(name.replace("P", "power"))):
                if target is not None:
                    needed = unit_of_quantity(setting, target, target.compute())
                    if needed == unit.dimension:
                        return True
        return False

    def _clause(self, at: int) -> tuple[dict[str, GivenValue], int]:
        """The state behind a number: at θ₁ = 30°, θ₂ = 45°, and where it ends."""
        match = _CLAUSE.match(self.text, at)
        if match is None:
            return {}, at
        _, values, end, _ = self._list_behind_words(match.end())
        if not values:
            return {}, at
        closing = re.compile(r"\s?\)").match(self.text, end) if "(" in match[0] else None
        return values, closing.end() if closing else end
