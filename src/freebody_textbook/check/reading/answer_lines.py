"""Splitting a document's formulas into equations: tokens by line, without the words between
them."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from contextlib import contextmanager

from freebody.errors import FreebodyError
from freebody.expressions.grammar import words
from freebody.expressions.grammar.lexemes import Lexemes, plain
from freebody.expressions.grammar.lexer import Token
from freebody.expressions.grammar.lexer import sides as sides_of
from freebody.expressions.grammar.patterns import LexemePattern
from freebody.expressions.grammar.source import Source, Span
from freebody.lazy import cached_property
from freebody_textbook.check.documents.answer_document import AnswerDocument, Blanks, FormulaPiece
from freebody_textbook.check.documents.plain import lines as plain_lines
from freebody_textbook.check.documents.plain import sentences
from freebody_textbook.check.reading.sums import sums, tokens_with_sums
from freebody_textbook.check.reading.vocabulary import Vocabulary
from freebody_textbook.check.spelling.answer_text import AnswerError, AnswerText
from freebody_textbook.check.spelling.equation_marks import asked_marks
from freebody_textbook.check.verdict import UnreadEquation

MOST_SIDES = 6
MOST_OUTSIDE = 20
"""The most lines outside of formulas that are told."""
_SHOWN = 60
_AXES = ["x"], ["y"], ["z"]
"""The names that are directions where a sign stands before them, $-y$."""
_WHERE = LexemePattern(
    "--%term_end %apart < where | with | and > &< %apart < %letter | %command > ~%in_name{0,12} = >"
)
"""The words between an equation and one that says what a letter in it stands for."""
_EQUALS = LexemePattern("< = | == >")
_CONTINUES = LexemePattern("+ | - | * | %strong | / | &")
_TABLE = LexemePattern("= &? < [ | %begin | Matrix | array >")
_INTRODUCED = LexemePattern("< %first | --; | --, > word:@word &< = | == | := >")
_BETWEEN = LexemePattern(
    "% %any{0,999} | said:< %word !@aligning %letter | !@aligning %command | %begin | %end >"
)
"""A comment of LaTeX, or something said between the lines of one equation."""


class AnswerLine(tuple[tuple[Token, ...], ...]):
    """An equation, as tokens of each side."""

    @property
    def tokens(self) -> list[Token]:
        """The tokens of all its sides."""
        return [token for side in self for token in side]

    @property
    def names(self) -> list[Token]:
        """The names in the equation."""
        return [token for token in self.tokens if token.kind == "name"]

    @property
    def subject(self) -> str:
        """The name that makes up the left side; "" if the side is anything else."""
        first = self[0]
        return first[0].text if len(first) == 1 and first[0].kind == "name" else ""

    @property
    def written_with(self) -> list[Token]:
        """Names that the equation uses, without the one it defines."""
        return AnswerLine(self if len(self[0]) > 1 else self[1:]).names

    @property
    def span(self) -> Span:
        """The equation's place in the text."""
        return self[0][0].start, self[-1][-1].end


class DocumentReader:
    """Reads the equations of a document; `unread` are those that could not be read."""

    def __init__(
        self, document: AnswerDocument, vocabulary: Vocabulary, quantities: Collection[str]
    ):
        self.document, self.vocabulary, self.quantities = document, vocabulary, quantities
        self.unread: list[UnreadEquation] = []
        self.failed: list[AnswerLine] = []
        self.unread_names: set[str] = set()
        """The names to which code gives something that is not read."""
        self.source, self.pieces = self._without_words()
        self._tell_what_no_formula_holds()

    # ------------------------------------------------------------ words
    def _without_words(self) -> tuple[AnswerText, list[FormulaPiece]]:
        """The text of the formulas without words, and its pieces."""
        document = self.document
        blanks, apart = Blanks(document.formulas), list[Span]()
        source = AnswerText(document.formulas, document.written, document.parts)
        for match in _WHERE.all(source.lexemes):
            blanks.put(*match.span, ";")
        source = AnswerText(str(blanks), document.written, document.parts)

        in_sums = _in_sums(source, self._bodies)

        def is_name(word: range) -> bool:
            return word.start in in_sums or self._is_name(source, word)

        for line in document.prose:
            for sentence in sentences(source.lexemes, line, is_name):
                span = (sentence.kept, sentence.end)
                if sentence.words_behind and not self._is_asked(source, span):
                    self._pass_over(source, span, "it stands among words")
                    span = (span[1], span[1])
                elif not sentence.is_empty and sentence.words_before:
                    apart.append(span)
                blanks.put(sentence.start, span[0])
        read = AnswerText.of_formulas(str(blanks), document.written, document.parts)
        return read, [part for piece in document.pieces for part in _parted(piece, apart)]

    def _tell_what_no_formula_holds(self) -> None:
        """Record statements about the robot's quantities that a document makes outside of its
        formulas."""
        said = self.document.said
        source = AnswerText(said, self.document.written, self.document.parts)
        for line in plain_lines(said, 0, len(said)):
            for x in asked_marks(source, source.lexemes.between(*line), self._is_quantity):
                if self.document.formulas[x.at] != said[x.at]:
                    self._pass_over(source, (x.start, line[1]), "it stands outside of the formulas")
                    break
            if len(self.unread) >= MOST_OUTSIDE:
                break

    def _asks(self, source: Source, span: Span) -> bool:
        """Whether one of the robot's quantities is left of an equals sign in a span, in the
        original or in the normalised text."""
        texts = [(source, source.lexemes.between(*span))]
        begun, written = self._written(span)
        if written.text != source.text[begun : span[1]]:
            within = written.lexemes.between(span[0] - begun, len(written.text))
            texts.append((written, within))
        return any(True for x in texts for _ in asked_marks(*x, self._is_quantity))

    def _written(self, span: Span) -> tuple[int, AnswerText]:
        """The start of the line in which a span begins, and the original text from there to the
        span's end."""
        begun = self.document.written.rfind("\n", 0, span[0]) + 1
        return begun, AnswerText(self.document.written[begun : span[1]])

    def _is_quantity(self, name: str) -> bool:
        """Whether a name is one of the robot's quantities and not a symbol as well."""
        return name in self.quantities and name not in self.vocabulary.symbols

    def _is_name(self, source: Source, word: range) -> bool:
        """Whether a word may consist of names known for the robot."""
        if not words.begins(source.lexemes[word.start]):
            return False
        if plain(source.lexemes[word.start : word.stop]) in self._introduced:
            return True
        try:
            spelt = words.spell(source, word.start)
            pieces = self.vocabulary.cut(source, spelt)
            return pieces is not None and pieces[-1][2] == source.lexemes[word.stop - 1].end
        except FreebodyError:  # it may be read in two ways
            return True

    @cached_property
    def in_sums(self) -> frozenset[int]:
        """The lexemes that belong to sums over bodies."""
        return _in_sums(self.source, self._bodies)

    @property
    def _bodies(self) -> int:
        """The number of bodies in a sum over all bodies."""
        return len(self.vocabulary.setting.equations.symbols.model.bodies)

    @cached_property
    def _introduced(self) -> frozenset[str]:
        """Words of the document that stand alone on the left of an equation, which so gives them a
        meaning."""
        return frozenset(match["word"] for match in _INTRODUCED.all(self.document.lexemes))

    def _is_asked(self, source: Source, span: Span) -> bool:
        """Whether the left side in a span names one of the robot's quantities; a symbol, as in g =
        9.81, counts only if a vector or matrix is assigned to it."""
        left = _left_side(source, source.lexemes.between(*span))
        is_table = _TABLE.at(source.lexemes, left.stop) is not None
        asked = (name for name in words.words_in(source, left) if name in self.quantities)
        return any(is_table or name not in self.vocabulary.symbols for name in asked)

    # ------------------------------------------------------------ equations
    def lines(self) -> list[AnswerLine]:
        """The sides of each equation."""
        found: list[Token] = []
        for piece in self.pieces:
            if not self._says_something(piece):
                continue
            with self._lenient(piece.lenient, (piece.start, piece.end)):
                span = (piece.start, piece.end)
                read = tokens_with_sums(self.source, self.vocabulary, span, self._bodies)
                found += _without_time(read[:-1])
                found.append(Token("line", "", piece.end, piece.end))
        lines: list[AnswerLine] = []
        for line in _lines(found, self.document.written):
            span = (line[0].start, line[-1].end)
            lenient = self._is_lenient(span[0])
            if lenient and line[0].kind == "operator" and [x.text for x in line[1:]] in _AXES:
                continue  # a direction, +z
            with self._lenient(lenient, span):
                lines.append(_answer_line(self.source, line))
        return lines

    def _says_something(self, piece: FormulaPiece) -> bool:
        """Whether a piece contains an equation or may continue one, or is any text that is not read
        leniently."""
        span = (piece.start, piece.end)
        lexemes, inside = self.source.lexemes, self.source.lexemes.between(*span)
        may = not piece.lenient or _EQUALS.found_in(lexemes, inside.start, inside.stop)
        may = may or _CONTINUES.at(lexemes, inside.start) is not None
        return bool(inside) and (may or self._asks(self.source, span))

    def _is_lenient(self, at: int) -> bool:
        return any(piece.lenient for piece in self.pieces if piece.start <= at < piece.end)

    @contextmanager
    def passing_over(self, line: AnswerLine) -> Iterator[None]:
        """Context that records an equation which cannot be understood, and continues."""
        count = len(self.unread)
        with self._lenient(self._is_lenient(line.span[0]), line.span):
            yield
        if len(self.unread) > count:
            self.failed.append(line)

    @contextmanager
    def _lenient(self, lenient: bool, span: Span) -> Iterator[None]:
        try:
            yield
        except AnswerError as problem:
            if not lenient or (self.document.strict and self._is_asked(self.source, span)):
                raise
            if self.source.lexemes.between(*span):
                self._pass_over(self.source, span, problem.bare)

    def pass_over(self, span: Span, reason: str, is_asked: bool) -> None:
        """Record a piece of the document that is skipped, with the reason."""
        self._pass_over(self.source, span, reason, is_asked)

    def _pass_over(
        self, source: AnswerText, span: Span, reason: str, is_asked: bool = False
    ) -> None:
        text = source[span]
        text = text if len(text) <= _SHOWN else f"{text[:_SHOWN]}…"
        inside = source.lexemes.between(*span)
        first = source.lexemes[inside.start].start if inside else span[0]
        asked = is_asked or self._is_asked(source, span) or self._asks(source, span)
        if self.document.assigns:
            _, written = self._written(span)
            left = _left_side(written, range(len(written.lexemes)))
            self.unread_names.update(words.words_in(written, left))
        self.unread.append(
            UnreadEquation(first, source.where(first), text, reason.rstrip("."), asked)
        )


def _in_sums(source: Source, count: int) -> frozenset[int]:
    """The lexemes of sums over bodies, when there are `count` bodies."""
    found = sums(source.lexemes, range(len(source.lexemes)), count)
    return frozenset(k for one in found for k in one.whole)


def _left_side(source: Source, within: range) -> range:
    """The lexemes left of the first equals sign in a stretch; empty if there is none."""
    equals = next(_EQUALS.all(source.lexemes, within.start, within.stop), None)
    return range(within.start, equals.start if equals else within.start)


def _parted(piece: FormulaPiece, apart: Sequence[Span]) -> Iterator[FormulaPiece]:
    """A piece split at the given spans, which stand among words and are read leniently."""
    at = piece.start
    for start, end in apart:
        if piece.start <= start < piece.end:
            yield FormulaPiece(at, start, piece.lenient)
            yield FormulaPiece(start, end, lenient=True)
            at = end
    yield FormulaPiece(at, piece.end, piece.lenient)


def _without_time(found: Sequence[Token]) -> Iterator[Token]:
    """Tokens without the argument of functions of time: theta1(t) becomes theta1."""
    k = 0
    while k < len(found):
        yield found[k]
        behind = [x.text for x in found[k + 1 : k + 4]]
        k += 4 if found[k].kind == "name" and behind == ["(", "t", ")"] else 1


def _lines(found: Sequence[Token], written: str) -> list[list[Token]]:
    """The tokens of each equation: a line that begins with an operator, or follows one, continues
    the previous line, unless words stand between.

    A minus may begin an equation of its own, -a = b.
    """
    pieces: list[list[Token]] = [[]]
    depth = 0
    for token in found:
        depth += token.deepens
        if token.kind in ("line", "row", "stop", "comma") and depth <= 0:
            pieces.append([])
        elif not (token.kind in ("amp", "line") and (depth <= 0 or not _in_matrix(token))):
            pieces[-1].append(token)
    lines: list[list[Token]] = []
    for piece in pieces:
        if not piece:
            continue
        own = piece[0].text == "-" and any(token.kind == "equals" for token in piece)
        continues = (piece[0].kind in ("operator", "equals") and not own) or (
            lines and _is_open(lines[-1])
        )
        if lines and continues and _goes_on(written[lines[-1][-1].end : piece[0].start]):
            lines[-1] += piece
        else:
            lines.append(piece)
    return lines


def _goes_on(between: str) -> bool:
    """Whether a text between tokens contains only white space, alignment and formula delimiters."""
    return not any("said" in match for match in _BETWEEN.all(Lexemes.of(between)))


def _in_matrix(token: Token) -> bool:
    """Whether a token within brackets separates matrix entries: & or ;, but not a line break."""
    return token.kind == "amp" or token.text == ";"


def _is_open(line: list[Token]) -> bool:
    """Whether a line ends with a token that requires a continuation."""
    return line[-1].kind in ("operator", "equals")


def _answer_line(source: Source, line: list[Token]) -> AnswerLine:
    """The equation of a line's tokens; raises an error if it has no second side, too many sides, or
    an empty one."""
    sides = sides_of(line)
    if len(sides) == 1:
        source.fail(
            "this line has no equals sign; write, for example, tau1 = … or H12 = …, and # before a "
            "remark",
            (line[0].start, line[-1].end),
        )
    if len(sides) > MOST_SIDES:
        source.fail(
            f"more than {MOST_SIDES} sides in one equation",
            sides[MOST_SIDES][0].span if sides[MOST_SIDES] else line[-1].span,
        )
    for k, side in enumerate(sides):
        if not side:
            equals = [token for token in line if token.kind == "equals"][max(0, k - 1)]
            source.fail("one side of this = is empty", equals.span)
    return AnswerLine(map(tuple, sides))
