"""Numeric results in a document: τ₁ = 12.3 N m at θ₁ = 30°, θ₂ = 45°. Units, tolerances and states
are recorded and removed from the text; the numbers stay."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from freebody.expressions.grammar.atoms import atom, undotted
from freebody.expressions.grammar.lexemes import Lexemes
from freebody.expressions.grammar.patterns import LexemePattern, Match
from freebody.expressions.grammar.source import Span
from freebody.expressions.grammar.tables.characters import FILL
from freebody.lazy import cached_property
from freebody_textbook.check.algebra.quotients import generator
from freebody_textbook.check.documents.answer_document import AnswerDocument, Blanks
from freebody_textbook.check.numbers.states import (
    AT_REST,
    NO_STATE,
    GivenState,
    GivenValue,
    StandingState,
    StateReader,
    WrittenNumber,
    WrittenNumbers,
)
from freebody_textbook.check.numbers.units_of_symbols import Unit, unit_of, unit_of_quantity
from freebody_textbook.check.numbers.written_units import WrittenUnit, unit_at
from freebody_textbook.check.spelling.answer_text import AnswerText
from freebody_textbook.check.spelling.equation_marks import asked_marks, quantity_before
from freebody_textbook.closed_chains.first_kind import is_multiplier

_RESULT = LexemePattern(
    "number:< !-%no_result_behind @result_number | %list_end | %end < ] | ) >? > pm:@tolerance?"
)
"""The end of a number or of a vector, and a tolerance behind it."""
_CLAUSE = LexemePattern(
    "< %line | %text_font { >* < ,? < @keyword | &@still > | @ | , | ; | begun:( > < } | %line >*"
)
_SENTENCE = LexemePattern(
    "< %first | --%stop %apart > < < - | * | %quote > %apart"
    " | (? %name ~%name? < . | ) > %apart >? < %strong | _ ~_ >?"
)
_WORD = LexemePattern(
    "word:< %bare_letter ~%bare_letter{0,19} > < ~, | ~: >? < ~%strong | ~_ ~_ >?"
    " < %apart | %last >"
)
_MOST_WORDS = 8
_KEYWORDS = ("at", "for", "with", "when", "given", "let", "if")
_WHERE = LexemePattern("@condition")
_UNCONDITIONED = LexemePattern("@unconditioned")
_COLON = LexemePattern("%line? :")
_INTRODUCES = LexemePattern("< , | ; | . > < %apart | %last > | %last | then | we | one | it")
"""Words behind a condition of what follows: For θ₂ = 0, with θ₂ = 0 we get."""
_SENTENCE_END = LexemePattern("< } | %line >* < . | : | , | ; | ) > | }* %last")
_BEHIND_CONDITION = LexemePattern("< . | , | ; | * | %strong | _ | } >{0,60}")
_BLANK_LINE = LexemePattern("%line %line")
_LONE = LexemePattern(
    "= < & | [ | ( | { >{0,6} %sign? @result_number }* < . | , | ; | ] | & | ) | %row | %last >"
)
_EQUALS = LexemePattern("%line? &? =")
_GOES_ON = LexemePattern("%continuing")
_IN_HEAD = LexemePattern(
    "< < [ | ( > unit:< %not_head_end{1,30} > < ] | ) >"
    " | < / | in > unit:< %not_head_end{1,30} > > &? ="
)
"""A unit in front of the sign of equality: τ1 [N m] = …, τ1 / N m = …"""
_STOP = LexemePattern("}* < . | , | ; | ] | & | ) | %row | %within_sign | +/- | +- | %last >")
_LONGEST = 600
"""Characters of an equation in front of a result."""


def taken_from(
    document: AnswerDocument, reader: StateReader, at: GivenState
) -> tuple[AnswerDocument, WrittenNumbers]:
    """A document without its units and states, and these separately; unchanged if it has no
    numbers. at: the state given in addition."""
    search = _NumberSearch(document, reader, at)
    numbers = search.numbers()
    if not (numbers or search.heads) and not (search.standing and search.has_result):
        return document, WrittenNumbers(at=at)
    formulas, said = Blanks(document.formulas), Blanks(document.said)
    for start, end in search.taken:
        formulas.put(start, end)
        if document.said:
            said.put(start, end)
    for start, end in search.units:  # shown with its number
        formulas.put(start, end, FILL * (end - start))
    return replace(document, formulas=str(formulas), said=str(said)), WrittenNumbers(
        numbers, search.standing, at
    )


class _NumberSearch:
    """Searches a document for numbers; `taken`: what has been read and must not be read again."""

    def __init__(self, document: AnswerDocument, reader: StateReader, at: GivenState):
        self.document, self.reader, self.at = document, reader, at
        self.text = document.said or document.formulas
        self.source = AnswerText(self.text, document.written, document.parts)
        self.taken: list[Span] = []
        self.is_taken = bytearray(len(self.text))
        """Flags of the characters in stretches that are taken."""
        self.units: list[Span] = []
        self.standing: list[StandingState] = []
        self.heads: dict[int, tuple[WrittenUnit, Span]] = {}
        """Units in front of signs of equality, by the lexeme of the sign."""

    @property
    def lexemes(self) -> Lexemes:
        """The lexemes of the searched text."""
        return self.source.lexemes

    def numbers(self) -> list[WrittenNumber]:
        if "=" not in self.text:
            return []
        self._read_standing()
        self._read_heads()
        results = ((match.start, match.stop, match) for match in _RESULT.all(self.lexemes))
        clauses = ((match.start, match.start, match) for match in _WHERE.all(self.lexemes))
        found: list[WrittenNumber] = []
        for start, stop, match in sorted((*results, *clauses), key=lambda row: row[:2]):
            said = self._number(match) if stop > start else self._expression(match.start)
            found += [said] if said else []
        for k in reversed(range(len(found) - 1)):  # τ1 = 1 N m, τ2 = 2 N m at …
            x, behind = found[k], found[k + 1]
            between = self.text[x.span[1] : behind.span[0]]
            if not x.state and between and "\n" not in between:
                found[k] = replace(x, state=behind.state)
        return found

    def _start(self, k: int) -> int:
        """Text position at which a lexeme begins."""
        return self.lexemes[k].start if k < len(self.lexemes) else len(self.text)

    def _end(self, k: int) -> int:
        """Text position at which the preceding lexeme ends."""
        return self.lexemes[k - 1].end if k else 0

    @property
    def has_result(self) -> bool:
        """Whether some quantity is given as a number, or some state is written for later
        results."""
        if any(x.is_condition for x in self.standing):
            return True
        quantities = self.reader.targets.names - self.reader.vocabulary.symbols.keys()
        marks = asked_marks(self.source, range(len(self.lexemes)), quantities.__contains__)
        return any(_LONE.at(self.lexemes, mark.lexeme) for mark in marks)

    # ------------------------------------------------------------ states before numbers
    def _read_standing(self) -> None:
        """Read states on lines of their own or at the beginning of a sentence: At θ₁ = 30° …"""
        for match in _SENTENCE.all(self.lexemes):
            if self.taken and self._start(match.stop) < self.taken[-1][1]:
                continue
            if _UNCONDITIONED.at(self.lexemes, match.stop):
                self._end_condition(match.stop)
                continue
            start, values, end, word = self._list_behind_words(match.stop)
            is_alone = not self._is_result(values) and _SENTENCE_END.at(self.lexemes, end)
            if values and (word in _KEYWORDS or is_alone):
                self._stand(match, (start, end), values, word in _KEYWORDS)

    def _stand(
        self, match: Match, place: tuple[int, int], values: GivenState, is_introduced: bool
    ) -> None:
        """Record the state that begins a sentence and holds for what follows, and remove its
        text."""
        start, end = place
        begun = self.standing[-1].state if self.standing else {}
        moving = {name for name in values if not self._is_constant(name)}
        if moving & set(begun):  # another state
            begun = {name: x for name, x in begun.items() if self._is_constant(name)}
        colon = _COLON.at(self.lexemes, end)
        still = AT_REST.at(self.lexemes, match.stop) is not None
        told = (is_introduced or still) and moving and _INTRODUCES.at(self.lexemes, end)
        first, last = (match.start, end) if colon or told else (start, end)
        last = colon.stop if colon else last
        self.standing.append(
            StandingState(
                self._end(end),
                {**begun, **values},
                bool(colon or told),
                len(self.text) if still else self._paragraph_end(last),
            )
        )
        self._take(self._start(first), self._end(last))

    def _end_condition(self, k: int) -> None:
        """End the validity of earlier conditions at words such as "in general"; values of
        parameters stay valid."""
        if self.standing:
            still = self.standing[-1].state.items()
            kept = {name: x for name, x in still if self._is_constant(name)}
            self.standing.append(StandingState(self._start(k), kept))

    def _paragraph_end(self, k: int) -> int:
        """Text position at which the validity of a condition ends: the end of its paragraph, or of
        the document if the condition is a paragraph of its own."""
        begun = _BEHIND_CONDITION.end(self._written, self._written.at(self._end(k)))
        blank = next(_BLANK_LINE.all(self._written, begun), None)
        return len(self.text) if blank is None or blank.start == begun else blank.span[0]

    @cached_property
    def _written(self) -> Lexemes:
        """The lexemes of the document before anything was removed."""
        return Lexemes.of(self.document.written)

    def _is_result(self, values: GivenState) -> bool:
        """Whether values are results rather than a state: accelerations of a free body,
        multipliers, or coordinates that follow from the loops when others are given."""
        setting = self.reader.vocabulary.setting
        if setting.system is not None and all(map(is_multiplier, values)):
            return True
        known = {*self.at, *(self.standing[-1].state if self.standing else ())}
        if setting.system is not None and known:
            moving = {name for name in values if not self._is_constant(name)}
            return bool(moving) and moving.isdisjoint(known)
        return setting.is_free_body and any(atom(name).dots for name in values)

    def _list_behind_words(self, at: int) -> tuple[int, dict[str, GivenValue], int, str]:
        """A list of values after a few words: where it starts, the values, where it ends, and the
        last of the words."""
        word = ""
        for _ in range(_MOST_WORDS):
            values, end = self.reader.list_at(self.source, at)
            match = _WORD.at(self.lexemes, at)
            if values or match is None:
                return at, values, end, word
            word, at = match["word"], match.stop
            vocabulary = self.reader.vocabulary
            if word in vocabulary.known or word in vocabulary.functions or word.lower() in NO_STATE:
                return at, {}, at, ""  # cos θ₂ = 0
            word = word.lower()
        return at, {}, at, word

    def _take(self, start: int, end: int) -> None:
        self.taken.append((start, end))
        self.is_taken[start:end] = b"\1" * (end - start)

    def _is_constant(self, name: str) -> bool:
        symbols = self.reader.vocabulary.setting.symbols
        return undotted(name) not in symbols.coordinates

    # ------------------------------------------------------------ units before numbers
    def _read_heads(self) -> None:
        """Read units written before equals signs; a unit after a quantity that has it is
        removed."""
        known, quantities = self.reader.vocabulary.known, self.reader.targets.names
        for match in _IN_HEAD.all(self.lexemes):
            begun, end = match.captures["unit"]
            found, sign = unit_at(self.lexemes, begun), match.stop - 1
            if found is None or found[1] != end:
                continue
            if quantity_before(self.source, match.start, quantities.__contains__) is None:
                continue
            is_bracket = self.lexemes[match.start].text == "["
            if not is_bracket and set(found[0].words) <= known:  # G(m), G2/m
                continue
            span = self._start(match.start), self._start(sign)
            self.heads[sign] = found[0], span
            if found[0].factor == 1.0 and self._may_have(found[0], sign + 1):
                self._take(*span)

    def _unit_in_head(self, sign: int, start: int, stop: int) -> WrittenUnit | None:
        """The unit written before the equals sign of a number that is a whole side."""
        unit, span = self.heads.get(sign, (None, (0, 0)))
        before = {x.text for x in self.lexemes[sign + 1 : start]}
        alone = self.lexemes[start].text == "]" or before <= {"&", "{", "+", "-", "−"}
        ends = _STOP.at(self.lexemes, stop) or self._clause(stop)[0]
        if unit is None or not alone or not ends:
            return None
        self._take(*span)
        return unit

    # ------------------------------------------------------------ numbers
    def _number(self, match: Match) -> WrittenNumber | None:
        """A number with its unit, tolerance and state, if it is a result."""
        number = match.captures["number"]
        start, end = self._start(number[0]), self._end(number[1])
        if self.is_taken[start] or not self.document.formulas[start].strip():
            return None
        at = match.stop
        unit = self._unit_behind(at, number[0])
        stop = unit[1] if unit else at
        own, behind = self._clause(stop)
        if not (own or unit or "pm" in match or self.heads):
            return None
        line = self._line_of(number[0])
        sign = self._behind_equals(line, number[0]) - 1
        begun = max(self._end(sign + 1), self._end(line))
        head = None if unit else self._unit_in_head(sign, number[0], at)
        if not (own or unit or "pm" in match or head):
            return None
        inside = [x.text for x in self.lexemes[self.lexemes.at(begun) : number[1]]]
        if inside.count("(") > inside.count(")") or begun == max(0, start - _LONGEST):
            return None
        if unit and "," in match["number"]:
            self.source.fail("a decimal comma: write a point", (start, end))
        self._take(end, self._end(behind))
        self.units.append((end, self._end(stop)))
        return WrittenNumber(
            (begun, end), self._end(line), (end, self._end(behind)),
            unit[0] if unit else head, match["within"], own,
        )  # fmt: skip

    def _unit_behind(self, at: int, start: int) -> tuple[WrittenUnit, int] | None:
        """The unit after a number and where it ends; None if it is the name on the next line, N =
        …."""
        unit = self._unit(at, start)
        behind_lines = unit and any(x.kind == "line" for x in self.lexemes[at : unit[1]])
        return None if unit and behind_lines and _EQUALS.at(self.lexemes, unit[1]) else unit

    def _line_of(self, k: int) -> int:
        """The first lexeme of the equation whose number begins at k; for lists of numbers over
        several lines the one after the equals sign."""
        is_list = self.lexemes[k].text == "]" or self.lexemes[k].kind == "end"
        return self._behind_equals(0, k) if is_list else self._begin(k)

    def _expression(self, k: int) -> WrittenNumber | None:
        """The state written after an expression in symbols."""
        end = self._end(k)
        own, behind = self._clause(k)
        if not own or self.is_taken[end]:
            return None
        line = self._begin(k)
        begun = self._behind_equals(line, k)
        if begun == line:
            return None
        self._take(end, self._end(behind))
        return WrittenNumber(
            (self._end(begun), end), self._end(line), (end, self._end(behind)), state=own
        )

    def _behind_equals(self, first: int, k: int) -> int:
        """The lexeme after the last equals sign in a stretch; the stretch's first if there is
        none."""
        signs = (j for j in range(k - 1, first - 1, -1) if self.lexemes[j].text in ("=", "=="))
        return next(signs, first - 1) + 1

    def _begin(self, k: int) -> int:
        """The first lexeme of the equation that contains lexeme k."""
        first = self.lexemes.at(max(0, self._start(k) - _LONGEST))
        items = self.lexemes.items
        for j in range(k - 1, first - 1, -1):
            x = items[j]
            if x.kind in ("line", "row") or x.text in (";", "["):
                return j + 1
            if x.text == "," and items[j + 1].apart:
                return j + 1
        return first

    def _unit(self, at: int, number: int) -> tuple[WrittenUnit, int] | None:
        """The unit at a lexeme, and the lexeme after it. If it is also a symbol, as the m of a
        pendulum, it counts as a unit only if the quantity has that unit."""
        found = unit_at(self.lexemes, at)
        if found is None:
            return None
        unit, end = found
        if unit.text == "°" and not self._is_alone(number):
            return None  # cos 75°
        if _GOES_ON.at(self.lexemes, end) and not self._clause(end)[0]:
            return None
        is_name = set(unit.words) <= self.reader.vocabulary.known
        if is_name and not self._may_have(unit, number):
            return None
        return unit, end

    def _is_alone(self, k: int) -> bool:
        """Whether a number is preceded by nothing but a sign."""
        k -= k > 0 and self.lexemes[k - 1].text in ("-", "−", "+")
        k -= k > 0 and self.lexemes[k - 1].text == "&"
        before = self.lexemes[k - 1].text if k else ""
        return before in ("=", "==", "[", ";") or (before == "," and self.lexemes[k].apart)

    def _may_have(self, unit: WrittenUnit, k: int) -> bool:
        """Whether a quantity or multiplier left of the last equals sign can have the unit."""
        lines = (j for j in range(k - 1, -1, -1) if self.lexemes[j].kind == "line")
        start = max(next(lines, -1) + 1, self.lexemes.at(self._start(k) - _LONGEST))
        single, symbols = self.reader.targets.single, self.reader.vocabulary.symbols
        marks = asked_marks(self.source, range(start, k), {*single, *symbols}.__contains__)
        return any(unit.dimension in self._units(mark.name) for mark in marks)

    def _units(self, name: str) -> Iterator[Unit | None]:
        """Units of the quantities that a name may mean."""
        targets, setting = self.reader.targets, self.reader.vocabulary.setting
        for target in (targets.single.get(name), targets.namesakes.get(name)):
            if target is not None:
                yield unit_of_quantity(setting, target, target.compute())
        symbol = generator(self.reader.vocabulary.symbols.get(name, setting.zero))
        if symbol and is_multiplier(symbol):
            yield unit_of(setting, {symbol: 1})

    def _clause(self, k: int) -> tuple[dict[str, GivenValue], int]:
        """The state written after a number, at θ₁ = 30°, θ₂ = 45°, and the lexeme after it."""
        match = _CLAUSE.at(self.lexemes, k)
        if match is None:
            return {}, k
        _, values, end, _ = self._list_behind_words(match.stop)
        is_next = match.stop - match.start == 1 and self.lexemes[k].text in (",", ";")
        if not values or (is_next and all(map(is_multiplier, values))):
            return {}, k  # λ1 = 3 N, λ2 = 4 N
        closed = "begun" in match and end < len(self.lexemes) and self.lexemes[end].text == ")"
        return values, end + closed
