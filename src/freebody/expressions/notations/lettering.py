"""Printed equations in the letters of a notation: those that `check` reads with that notation."""

from __future__ import annotations

import unicodedata
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from string import ascii_lowercase
from typing import Self

from freebody.errors import FreebodyError, shown
from freebody.expressions.grammar.atoms import atom, numbered, undotted
from freebody.expressions.grammar.lexemes import Lexemes
from freebody.expressions.grammar.patterns import LexemePattern, Match
from freebody.expressions.grammar.tables.characters import LOW
from freebody.expressions.grammar.words import letter, spelt
from freebody.expressions.nodes import Equation, Expression, Function, Sum, Symbol, nodes
from freebody.expressions.notations.notation import BookNotation, preset
from freebody.expressions.polynomials.symbols import RATE, SECOND
from freebody.expressions.printed_names import GREEK, sym
from freebody.expressions.quantities.kinds import LETTERED
from freebody.expressions.typesetting.literal import MARK, in_parts
from freebody.lazy import cached_property
from freebody.model.model import Model
from freebody.values import ByValue

KIND_OF = {letter: kind for kind in LETTERED for letter in kind.printed}
"""The letters of derivations as they are made, and what they stand for."""

_IN_WORDS = LexemePattern(
    "%fresh !-. letter:< %plain_letter | %dotted_letter > more:~%latin{0,3}"
    " low:< ~%low_digit{1,9} | ~_ < ~%digit | index:~%small_letter > %ends >"
)
"""A symbol in a sentence: θ̇₁, lc₂, τ_2, T_i."""


_ANGLES = tuple(f"theta{k}" for k in range(10))
_ANY = frozenset(ascii_lowercase)
"""Indices for any number, l_i."""


@dataclass(frozen=True, eq=False)
class Lettering(ByValue):
    """The symbols of one model in the letters of a notation; `parameters` are the model's own
    names, which never stand for quantities."""

    notation: BookNotation
    parameters: frozenset[str] = frozenset()
    coordinates: tuple[str, ...] = ()
    kept: frozenset[str] = frozenset()
    """Letters of `KIND_OF` that stay as they are."""

    @cached_property
    def taken(self) -> tuple[str, ...]:
        """Names in the notation that the model already uses itself."""
        stems = {numbered(name)[0] for name in self.parameters}
        meanings = self.notation.names
        return tuple(sorted((set(meanings) - set(meanings.values())) & stems))

    @cached_property
    def names(self) -> Mapping[str, str]:
        """The notation's names for parameters and coordinates that it renames; none at all where
        the model already uses one of these names."""
        found: dict[str, str] = {}
        for name, meaning in () if self.taken else self.notation.names.items():
            new = spelt(name)
            if _is_printable(new):
                for own, number in self._meant(meaning):
                    if new + number not in self.alone:
                        found.setdefault(own, new + number)
        return found

    @cached_property
    def alone(self) -> frozenset[str]:
        """The letters of energies, which no renamed parameter may take."""
        letters = self.notation.all_letters
        return frozenset(
            letter for kind in LETTERED if kind.is_energy for letter in letters[kind.name][:1]
        )

    def printable(self) -> Self:
        """The lettering itself; raises FreebodyError for a name that cannot be printed, and for one
        name of two things."""
        for name in self.notation.names:
            if not _is_printable(spelt(name)):
                raise FreebodyError(
                    f"the notation {self.notation.name!r}: {shown(name)} cannot be "
                    "printed; a name consists of letters and perhaps a number after them."
                )
        called: dict[str, str] = {}
        for own in (*self.coordinates, *sorted(self.parameters)):
            new = self.names.get(own, own)
            other = called.setdefault(new, own)
            if other != own:
                raise FreebodyError(
                    f"the notation {self.notation.name!r} calls both {other} and {own} "
                    f"{new}; give one of them another name."
                )
        return self

    def _meant(self, meaning: str) -> Iterator[tuple[str, str]]:
        """The model's names that a meaning in the notation covers, each with the number to
        append."""
        for own in (*self.coordinates, *sorted(self.parameters)):
            stem, number = numbered(own)
            of_all = number and own in self.coordinates and meaning == "q"
            if own == meaning or (number and stem == meaning) or of_all:
                yield own, number if own != meaning else ""

    @cached_property
    def letters(self) -> Mapping[str, str]:
        """The notation's letters, by those of `KIND_OF`."""
        given, others = self.notation.letters, self.notation.all_letters
        taken = {letter for letters in given.values() for letter in letters}
        found = {}
        for old, kind in KIND_OF.items():
            stays = old not in taken and len(old) == 1
            own = given.get(kind.name) or ((old,) if stays else others[kind.name])
            found[old] = own[0] if own and old not in self.kept else old
        return {old: new for old, new in found.items() if old != new}

    @cached_property
    def waves(self) -> Mapping[str, str]:
        """The letters of sines and cosines in short form, such as {"cos": "c"}."""
        return {x: spelt(name) for name, x in self.notation.names.items() if x in ("sin", "cos")}

    def __call__(self, x: Expression) -> Expression:
        """An expression in the letters of the notation."""
        if isinstance(x, Symbol):
            return self.symbol(x)
        if isinstance(x, Function) and x.name in self.waves and (k := self._numbers(x.argument)):
            return Symbol(self.waves[x.name] + k, self.waves[x.name], (k,))
        return x.mapped(self)

    def line(self, line: Equation) -> Equation:
        """An equation in the letters of the notation."""
        return line.mapped(self)

    def _numbers(self, angle: Expression) -> str:
        """The numbers of the model's angles in a sum, in rising order and of one digit each; "" for
        any other expression."""
        terms = angle.terms if isinstance(angle, Sum) else (angle,)
        names = [x.name if isinstance(x, Symbol) else "" for x in terms]
        plain = all(x in _ANGLES and x in self.coordinates for x in names)
        return "".join(x[-1] for x in sorted(set(names))) if plain else ""

    def symbol(self, x: Symbol) -> Symbol:
        """A symbol in the letters of the notation; vectors keep their own."""
        if x.bold:
            return x
        stem = undotted(x.name)
        new = self.names.get(x.name) or self._of_all(x.name)
        if new is None and stem != x.name and (new := self.names.get(stem) or self._of_all(stem)):
            return _made(new, x.name.removeprefix(stem), x)
        return x if new is None else _made(new, "", x)

    def _of_all(self, name: str) -> str | None:
        """The notation's name for a quantity, such as T1 or T_i, or for a general parameter, such
        as l_i; None for others."""
        own = atom(name)
        of_any = len(own.index) == 1 and own.index[0] in _ANY
        is_name = own.letter and not own.dots and (own.is_figures or not own.index or of_any)
        if not is_name or name in self.parameters or name in self.coordinates:
            return None
        letter, rest = own.letter, name.removeprefix(own.letter)
        if letter in self.letters:
            kind = KIND_OF[letter]
            own = self.notation.letters.get(kind.name, ()) if kind.is_matrix else ()
            large = next(filter(str.isupper, own), self.letters[letter])
            return (self.letters[letter] if rest else large) + rest
        if rest[:1] == "_":
            like = next((x for x in self.names if numbered(x)[0] == letter), "")
            return numbered(self.names[like])[0] + rest if like else None
        return None

    def sentence(self, text: str) -> str:
        """A sentence with its symbols in the letters of the notation; names that come from files
        stay as they are."""
        plain = in_parts(text, self.words, lambda name: f"{MARK}{name}{MARK}")
        return unicodedata.normalize("NFC", plain)

    def words(self, text: str) -> str:
        """Text without names from files, with its symbols in the letters of the notation."""
        text, made, at = unicodedata.normalize("NFD", text), "", 0
        for match in _IN_WORDS.all(Lexemes.of(text)):
            start, end = match.span
            made += text[at:start] + self._word(match)
            at = end
        return made + text[at:]

    def _word(self, match: Match) -> str:
        """A symbol found in a sentence, in the letters of the notation and in the sentence's way of
        writing."""
        (first,) = match.items("letter")
        own, low = atom(letter(first)), match["low"]
        number = "".join(LOW.get(x.text, x.text) for x in match.items("low") if x.text != "_")
        name = own.letter + match["more"] + ("_" if "index" in match else "") + number
        old = sym(name + ("", RATE, SECOND)[own.dots])
        if not isinstance(old, Symbol) or (new := self.symbol(old)) == old:
            return match.text
        stem = atom(new.name).letter
        return f"{GREEK.get(stem, stem)}{first.text[1:]}{low}"


def _is_printable(name: str) -> bool:
    """Whether a plain name consists of letters, perhaps with a number behind them."""
    stem, _ = numbered(name)
    return stem.isascii() and stem.isalpha()


def _made(name: str, ending: str, old: Symbol) -> Symbol:
    """The symbol of a plain name: its first letter with the rest as subscript, and the dots of the
    old symbol."""
    stem, parts = atom(name).letter, atom(name).index
    if stem in GREEK:
        letter, more = GREEK[stem], ""
    else:
        letter, more = stem[0], stem[1:]
    low = (more + parts[0], *parts[1:]) if parts else (more,) if more else ()
    return Symbol(name + ending, letter, low, old.dots, False, old.high)


def lettering_of(notation: BookNotation, model: Model, coordinates: tuple[str, ...]) -> Lettering:
    """The letters of a notation for what is printed about a model.

    Raises FreebodyError for a notation that calls two things by one name.
    """
    own = notation.names, notation.letters, notation.absolute, notation.quarter_turns
    if not any(own) and notation.terms == PLAIN.notation.terms:
        return PLAIN
    return Lettering(notation, frozenset(model.parameters), coordinates).printable()


def lettered_for(lettering: Lettering, printed: Iterable[Expression]) -> Lettering:
    """The letters for a document: without short sines and cosines where s_1 is something else, and
    the reduced mass matrix H as it is where there is a larger M.

    Raises FreebodyError where two symbols of it would be one.
    """
    symbols = dict.fromkeys(x for y in printed for x in nodes(y) if isinstance(x, Symbol))
    stems = {x.letter for x in symbols if x.name not in lettering.parameters}
    lettering = replace(lettering, kept=frozenset("H" if {"H", "M"} <= stems else ""))
    called: dict[Symbol, Symbol] = {}
    for old in symbols:
        other = called.setdefault(lettering.symbol(old), old)
        if other != old:
            return lettered_for(_with_another(lettering, old, other), symbols)
    return _without_ambiguous_functions(lettering, called)


def _without_ambiguous_functions(lettering: Lettering, called: Iterable[Symbol]) -> Lettering:
    """The lettering without short forms of sine and cosine where one of their letters, such as s in
    s_1, already names one of the given symbols."""
    letters = {x.letter for x in called if x.low and x.low[0].isdigit()}
    names = lettering.notation.names
    short = {x for x, y in names.items() if y in ("sin", "cos")}
    if not any(spelt(x) in letters for x in short):
        return lettering
    kept = {x: y for x, y in names.items() if x not in short}
    return replace(lettering, notation=replace(lettering.notation, names=kept))


def _with_another(lettering: Lettering, one: Symbol, other: Symbol) -> Lettering:
    """The lettering with the next letter for one of two symbols that would print alike; raises
    FreebodyError where there is no other letter."""
    notation = lettering.notation
    for symbol in (one, other):
        kind = KIND_OF.get(symbol.letter)
        own = notation.letters.get(kind.name, ()) if kind else ()
        if kind and symbol.name not in lettering.parameters and len(own) > 1:
            letters = {**notation.letters, kind.name: own[1:]}
            return replace(lettering, notation=replace(notation, letters=letters))
    raise FreebodyError(
        f"the notation {notation.name!r} calls both {other} and {one} {lettering.symbol(one)} "
        "here; in one of your own give one of them another letter."
    )


PLAIN = Lettering(preset("notes"))
"""The letters of the notes."""
