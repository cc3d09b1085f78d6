"""Users' own names and those of a book's notation, with their meanings."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace

from freebody.expressions.grammar import words
from freebody.expressions.grammar.atoms import atom, numbered, spellings
from freebody.expressions.grammar.lexer import tokens
from freebody.expressions.nodes import Matrix, Span
from freebody.expressions.notations.lettering import Lettering
from freebody.expressions.notations.notation import BookNotation
from freebody.expressions.polynomials.symbols import RATE, SECOND
from freebody.expressions.quantities.kinds import SHARED_LETTERS
from freebody.scalars.trig import Trig
from freebody_textbook.check.algebra.exact_polynomials import PolynomialReader
from freebody_textbook.check.algebra.quotients import Named, Value
from freebody_textbook.check.algebra.tables_in_formulas import worked_out
from freebody_textbook.check.asked.asked_quantities import Targets
from freebody_textbook.check.asked.letters_for_numbers import LINK_SYMBOLS
from freebody_textbook.check.asked.quantity import AskedQuantity
from freebody_textbook.check.claims.formula_reader import entry_label
from freebody_textbook.check.reading.claim import uses
from freebody_textbook.check.reading.reading import AnswerParser
from freebody_textbook.check.reading.vocabulary import FUNCTIONS, Vocabulary
from freebody_textbook.check.spelling.answer_text import AnswerError, AnswerText

_NUMBERED = (*(x.letter for x in LINK_SYMBOLS), "q")
"""The letters that a name of one's own may stand for on all links or joints."""


def of_notation(vocabulary: Vocabulary, targets: Targets, notation: BookNotation) -> None:
    """Enter the names of a book's notation together, as they may swap meanings with names used
    here; none are entered if the model uses such names itself."""
    here = Vocabulary(vocabulary.setting, targets.names, targets.alone)
    symbols = vocabulary.setting.symbols
    lettering = Lettering(notation, frozenset(symbols.model.parameters), symbols.coordinates)
    if lettering.taken:
        return
    for name, meaning in notation.names.items():
        if meaning not in _NUMBERED or (meaning in here.symbols and name not in lettering.alone):
            _rename(vocabulary, targets, name, meaning, here)
        for k in range(1, vocabulary.setting.joints + 1) if meaning in _NUMBERED else ():
            if f"{meaning}{k}" in here.symbols:
                _rename(vocabulary, targets, f"{name}{k}", f"{meaning}{k}", here)
    for own, name in lettering.names.items():
        _rename(vocabulary, targets, name, own, here)
    vocabulary.no_waves(
        name for name, x in targets.single.items() if _is_printed(name, x, notation)
    )


def _is_printed(name: str, target: AskedQuantity, notation: BookNotation) -> bool:
    """Whether a book's notation prints a quantity with this name."""
    letters = notation.letters.get(target.kind.name, ())
    printed = target.kind.name in notation.printed_kinds
    return printed and name == f"{letters[0]}{atom(name).figures}" != letters[0]


def of_user(vocabulary: Vocabulary, targets: Targets, names: Mapping[str, str]) -> None:
    """Enter the names that a user gives, together, since one may take another's meaning."""
    here, waiting = vocabulary.copy(), dict(names)
    while waiting:
        problem = None
        for name, meaning in list(waiting.items()):
            try:
                if not _rename(vocabulary, targets, name, meaning, here):
                    raise AnswerError(f"names: {name!r}: no {meaning!r} with a number is known")
                del waiting[name]
            except AnswerError as error:
                problem = problem or error
        if problem is not None and len(waiting) == len(names):
            raise problem
        here, names = vocabulary.copy(), dict(waiting)


def as_texts(names: object) -> dict[str, str]:
    """Names and meanings given by a user, as texts; meanings may be numbers; raises AnswerError."""
    if not isinstance(names, Mapping):
        raise AnswerError(f"names: {names!r} is no dict such as {{'L1': 'l1'}}")
    for name, meaning in names.items():
        if not (isinstance(name, str) and isinstance(meaning, str | int | float)):
            raise AnswerError(f"names: {name!r}: {meaning!r} is no pair of texts as 'L1': 'l1'")
    return {name: str(meaning) for name, meaning in names.items()}


def _rename(
    vocabulary: Vocabulary, targets: Targets, name: str, meaning: str, here: Vocabulary
) -> bool:
    """Enter a user's own name for a symbol (with its rates), a family of symbols, an expression, or
    a letter for the cosines and sines of all angles; returns False if the meaning is unknown. here:
    the names used in meanings."""
    plain = _plain(name)
    if plain in (*FUNCTIONS, "pi", "t"):
        raise AnswerError(f"names: {name!r} has a meaning of its own and cannot be another name")
    target = _plain(meaning) if words.spelt(meaning) else ""
    if target in _NUMBERED and target not in here.symbols:
        numbers = [k for k in range(1, here.setting.joints + 1) if f"{target}{k}" in here.symbols]
        for k in numbers:
            _rename(vocabulary, targets, f"{plain}{k}", f"{target}{k}", here)
        return bool(numbers)
    if target in ("sin", "cos"):
        if atom(plain).figures:
            raise AnswerError(f"names: {name!r} is to be a letter for {target}, without numbers")
        vocabulary.also_wave(plain, target)
        return True
    if target in targets.names and target not in {*here.symbols, *here.waves, *SHARED_LETTERS}:
        _rename_quantity(vocabulary, targets, plain, target)
        return True
    _define(vocabulary, targets, plain, AnswerText.of(meaning), here)
    return True


def _define(
    vocabulary: Vocabulary, targets: Targets, plain: str, meaning: AnswerText, here: Vocabulary
) -> None:
    """Define a user's own name as an expression with its rates, or as a vector or matrix with its
    components."""

    def quantity(name: str) -> Trig | None:
        return targets.single[name].polynomial() if name in targets.single else None

    def table(name: str, span: Span) -> Matrix | None:
        if name in here.matrices:
            return replace(here.matrices[name], span=span)
        asked = () if name in SHARED_LETTERS else targets.tables.get(name, ())
        rows = [
            tuple(Named(entry_label(name, x), x.compute(), span=span) for x in row) for row in asked
        ]
        return Matrix(tuple(rows), span=span) if rows else None

    written = tokens(meaning, here)[:-1]
    parser = AnswerParser(meaning, written, here, quantity, targets.single, table)
    node = worked_out(parser.side(), parser.others)
    given = tuple(use.target for use in uses(node, targets.single, vocabulary))
    reader = PolynomialReader(meaning, vocabulary.setting.ring)
    vocabulary.told |= {plain} if given else set()
    if isinstance(node, Matrix):
        vocabulary.define(plain, node, given)
        for k, row in enumerate(node.rows if len(node.rows[0]) == 1 else (), 1):
            own = tuple(use.target for use in uses(row[0], targets.single, vocabulary))
            vocabulary.define(f"{plain}{k}", reader.quotient(row[0]), own)
            vocabulary.told |= {f"{plain}{k}"} if own else set()
        return
    value = reader.quotient(node)
    vocabulary.define(plain, value, given)
    ring = vocabulary.setting.ring
    for coordinate in vocabulary.setting.symbols.coordinates:
        if value == ring[coordinate]:
            for p in "pP":
                vocabulary.define_alias(p + plain, p + coordinate)
    letter, digits = numbered(plain)
    for dots, rate in enumerate(_rates(vocabulary, value), 1):
        for spelling in spellings(letter, digits, dots):
            vocabulary.define(spelling, rate, given)


def _rename_quantity(vocabulary: Vocabulary, targets: Targets, name: str, target: str) -> None:
    """Define a user's own name for a quantity and for its rates; False if there is no such
    quantity."""
    for dots in range(3):
        theirs = next((x for x in spellings(target, "", dots) if x in targets.names), None)
        for spelling in spellings(name, "", dots) if theirs else ():
            vocabulary.define_alias(spelling, theirs or "")


def _rates(vocabulary: Vocabulary, value: Value) -> Iterator[Trig]:
    """The first and second time derivatives of a value, without those that are 0."""
    ring = vocabulary.setting.ring
    rates = {x: ring[x + RATE] for x in ring.names if x + RATE in ring.index}
    rates |= vocabulary.setting.symbols.rates
    for _ in (RATE, SECOND):
        if not isinstance(value, Trig) or (value := value.along(rates)).is_zero:
            return
        yield value


def _plain(name: str) -> str:
    """The plain spelling of a name."""
    source = AnswerText.of(name.strip())
    items = source.lexemes.items
    if not items or not (words.begins(items[0]) or items[0].kind == "command"):
        raise AnswerError(f"names: {name!r} is not a name")
    word = words.spell(source, 0)
    if word.plain in words.COMMAND_NAMES:  # ell is \\ell
        return words.COMMAND_NAMES[word.plain]
    if word.at != len(items):
        raise AnswerError(f"names: {name!r} is not a single name")
    return word.plain
