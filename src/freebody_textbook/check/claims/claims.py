"""An answer's text as claims: which quantity each line is about, and the expression given for
it."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NoReturn

from freebody.errors import listed
from freebody.expressions.grammar import words
from freebody.expressions.grammar.patterns import LexemePattern
from freebody.expressions.grammar.source import Source, Span
from freebody.expressions.notations.notation import BookNotation
from freebody_textbook.check.algebra.quotients import Named
from freebody_textbook.check.asked.asked_quantities import Targets
from freebody_textbook.check.asked.loads import instead_of
from freebody_textbook.check.asked.right_equations import RightEquations
from freebody_textbook.check.claims import own_names
from freebody_textbook.check.claims.claim_reader import ClaimReader
from freebody_textbook.check.documents.answer_document import AnswerDocument
from freebody_textbook.check.numbers.given_states import StateReader, WrittenNumbers
from freebody_textbook.check.numbers.written_numbers import taken_from
from freebody_textbook.check.reading.answer_lines import AnswerLine, DocumentReader
from freebody_textbook.check.reading.claim import Claim, refuse_circles
from freebody_textbook.check.reading.vocabulary import Vocabulary
from freebody_textbook.check.spelling.answer_text import AnswerError, AnswerText
from freebody_textbook.check.verdict import UnreadEquation
from freebody_textbook.check.verdicts import singular_poses

MOST_EQUATIONS = 100


@dataclass(frozen=True)
class Statements:
    """All statements of a document: its claims in order, user-defined names that no claim uses, and
    equations that could not be read."""

    claims: list[Claim]
    unused: tuple[str, ...]
    unread: tuple[UnreadEquation, ...] = ()
    numbers: WrittenNumbers = WrittenNumbers()
    told: tuple[Span, ...] = ()
    """The places at which values of parameters are told."""


def _names(
    setting: RightEquations,
    document: AnswerDocument,
    names: Mapping[str, str],
    notation: BookNotation,
) -> tuple[Targets, Vocabulary]:
    """The quantities and all names that may occur in an answer."""
    formulas = document.lexemes
    coefficients = (
        setting.turned is None
        and not any("h" in letters for letters in notation.letters.values())
        and any(_COEFFICIENTS.all(formulas))
    )
    framed = "%frame" in formulas.places
    targets = Targets(
        setting,
        bool(coefficients),
        notation.all_letters,
        framed=framed,
        formulas=formulas,
        dotted=words.dotted(AnswerText(document.formulas)),
    )
    vocabulary = Vocabulary(setting, targets.names, targets.alone)
    for name, value in setting.given.items():
        vocabulary.define(name, value)
    own_names.of_notation(vocabulary, targets, notation)
    own_names.of_user(vocabulary, targets, names)
    return targets, vocabulary


def _refuse_none_or_too_many(lines: Sequence[AnswerLine], has_others: bool) -> None:
    """Raise an error for an answer that has no equation and nothing else, or too many equations."""
    if not lines and not has_others:
        raise AnswerError(
            "the answer is empty; write an equation such as H12 = m2*(lc2^2 + l1*lc2*cos(theta2)) "
            "+ I2"
        )
    if len(lines) > MOST_EQUATIONS:
        raise AnswerError(
            f"the answer has {len(lines)} equations; at most {MOST_EQUATIONS} are read"
        )


def statements(
    setting: RightEquations,
    document: AnswerDocument,
    names: Mapping[str, str],
    notation: BookNotation,
    at: Mapping[str, Any] | str | None = None,
) -> Statements:
    """All statements of an answer; at: the state for its numbers."""
    targets, vocabulary = _names(setting, document, names, notation)
    states = StateReader(vocabulary, targets)
    document, poses = singular_poses.taken_from(document, vocabulary, targets)
    document, numbers = taken_from(document, states, states.given(at))
    numbers.refuse_two_states()
    reading = DocumentReader(document, vocabulary, targets.names)
    source = reading.source
    symbols = frozenset(vocabulary.symbols)
    new = _new_names(reading, vocabulary)
    pending = set(new)
    for name in new:  # known as words; no line is read with one before it has its value
        vocabulary.define(name, setting.zero)
    lines = reading.lines()
    _refuse_none_or_too_many(lines, bool(reading.unread or poses))
    claimed = ClaimReader(source, vocabulary, targets, numbers, lines)
    for line in lines:
        with reading.passing_over(line):
            if claimed.says_that_the_base_moves(line):
                claimed.targets = replace(targets, based=True)
    pending |= claimed.own_scalars | claimed.own_coordinates
    pending |= claimed.own_coefficients(pending)
    own = _definitions(claimed, reading, lines, pending)
    read = (line for line in lines if line not in reading.failed)
    stated = [AnswerLine(line[1:]) if line in own else line for line in read]
    found = _claims(claimed, reading, [line for line in stated if len(line) > 1], pending, symbols)
    if not found and not poses:
        _refuse_nothing(setting, source, own, reading.unread)
    if document.strict:
        refuse_circles(source, found)
    else:
        found = _without_circles(reading, found)
    unread = sorted(reading.unread, key=lambda row: row.at)
    unused, told = _unused(source, own, lines), tuple(claimed.told)
    return Statements([*found, *poses], unused, tuple(unread), numbers, told)


def _claims(
    claimed: ClaimReader,
    reading: DocumentReader,
    lines: Sequence[AnswerLine],
    pending: Collection[str],
    symbols: Collection[str],
) -> list[Claim]:
    """The claims of lines whose names all have values. pending: names without a value; symbols:
    names that had a meaning before."""
    by_line: dict[AnswerLine, list[Claim]] = {}
    for line in lines:
        with reading.passing_over(line):
            _refuse_names(reading.source, line, pending)
            before = [claim for claims in by_line.values() for claim in claims]
            by_line[line] = claimed.claims(line, before)
    unread_names = {line.subject for line in reading.failed} | reading.unread_names
    for line in list(by_line):
        with reading.passing_over(line):
            _refuse_names(reading.source, line, unread_names.difference(symbols))
        if line in reading.failed:
            del by_line[line]
    return [claim for claims in by_line.values() for claim in claims]


def _definitions(
    claimed: ClaimReader, reading: DocumentReader, lines: Sequence[AnswerLine], pending: set[str]
) -> list[AnswerLine]:
    """The lines that define names, in any order; names that get a value are removed from
    `pending`."""
    own: list[AnswerLine] = []
    waiting = [line for line in lines if line not in reading.failed]
    while True:
        ready = [x for x in waiting if pending.isdisjoint(t.text for t in x.written_with)]
        if not ready:
            return own
        for line in ready:
            waiting.remove(line)
            with reading.passing_over(line):
                own += claimed.definitions(line)
        pending -= {line.subject for line in own}


def _refuse_names(source: Source, line: AnswerLine, without_value: Collection[str]) -> None:
    """Raise an error for a line that uses a name without a definition, or with one that could not
    be read."""
    for token in line.written_with:
        if token.text in without_value:
            source.fail(
                f"{source[token.span]} is not defined by any line that can be read", token.span
            )


def _without_circles(reading: DocumentReader, found: Sequence[Claim]) -> list[Claim]:
    """The claims of a document without those that are defined by themselves, which are reported."""
    kept: list[Claim] = []
    for claim in found:
        try:
            refuse_circles(reading.source, [*kept, claim], [claim])
            kept.append(claim)
        except AnswerError as problem:
            own_name = isinstance(claim.node, Named)  # Q = [τ1; τ2] only says another name
            reading.pass_over(claim.node.span, problem.bare, not own_name)
    return kept


def _refuse_nothing(
    setting: RightEquations,
    source: Source,
    own: Sequence[AnswerLine],
    unread: Sequence[UnreadEquation],
) -> NoReturn:
    """Raise the error that an answer contains nothing to be checked."""
    if unread:
        first = unread[0]
        raise AnswerError(f"no equation could be read; {first.where}: {first.reason}")
    if not own:
        raise AnswerError(
            "the answer only gives values of parameters; write the quantity to be checked, such as "
            "tau1 = …"
        )
    names_given = dict.fromkeys(source[line[0][0].span] for line in own)
    instead = (instead_of(setting.symbols.model, line[0][0].text) for line in own)
    taken = "are taken for names" if len(names_given) > 1 else "is taken for a name"
    raise AnswerError(
        f"{listed(names_given, 8)} {taken} of your own, not one of the robot's quantities; "
        f"write the quantity to be checked, such as tau1 = …",
        next(filter(None, instead), ""),
    )


def _unused(
    source: Source, own: Sequence[AnswerLine], lines: Sequence[AnswerLine]
) -> tuple[str, ...]:
    """Names that a line defines and no other line uses."""
    used = {x.text for y in lines for x in (y.written_with if y in own else y.names)}
    unused = (source[line[0][0].span] for line in own if line.subject not in used)
    return tuple(dict.fromkeys(unused))


def _new_names(reading: DocumentReader, vocabulary: Vocabulary) -> list[str]:
    """Names left of = that have no other meaning: the user defines them. Letters of vectors are
    recorded as defined."""
    source, lexemes = reading.source, reading.source.lexemes
    places = {lexemes.at(piece.start) for piece in reading.pieces}
    places |= {match.stop for match in _BEFORE_NAME.all(lexemes)}
    found, given = [], set[str]()
    for k in sorted(places | {0}):
        k = _ALIGNED.end(lexemes, k)
        word = words.word_at(source, k)
        if word is None or lexemes[k].text == "_" or k in reading.in_sums:
            continue
        if not _IS.at(lexemes, word.at):
            continue
        if vocabulary.cut(source, word) is None:
            found.append(word.plain)
        elif word.plain in vocabulary.alone and len(word.plain) == 1:
            given.add(word.plain)
    vocabulary.given |= given
    return found


_BEFORE_NAME = LexemePattern("%line | , | ; | %row")
_ALIGNED = LexemePattern("&?")
_IS = LexemePattern("&? =")
_COEFFICIENTS = LexemePattern("!-%latin h !~%small_letter")
"""h, h_112 of the notes' form."""
