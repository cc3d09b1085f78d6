"""Names allowed in an answer: the model's symbols and their synonyms, c12 and s12, functions,
quantities."""

from __future__ import annotations

import itertools
from collections.abc import Collection, Iterable, Iterator
from copy import copy
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NoReturn

from freebody.errors import capitalised, did_you_mean, likely
from freebody.expressions.grammar import words
from freebody.expressions.grammar.atoms import atom, spellings
from freebody.expressions.grammar.lexemes import Lexeme
from freebody.expressions.grammar.source import Source
from freebody.expressions.grammar.tables.characters import DOT, PRIME, PRIMES, RECIPROCALS
from freebody.expressions.nodes import Expression, Matrix
from freebody.expressions.polynomials.symbols import RATE, SECOND, names_by_body
from freebody.identifiers import word_set
from freebody.scalars.generators import function_of
from freebody.scalars.trig import Trig
from freebody_textbook.check.algebra.quotients import Angle, Value
from freebody_textbook.check.asked import free_body, loads
from freebody_textbook.check.asked.letters_for_numbers import COORDINATES, PARAMETERS
from freebody_textbook.check.asked.right_equations import RightEquations
from freebody_textbook.closed_chains.multiplier_equations import MULTIPLIER, is_multiplier

if TYPE_CHECKING:
    from freebody_textbook.check.asked.quantity import AskedQuantity

FUNCTIONS = {
    "sin": "sin", "Sin": "sin", "SIN": "sin", "cos": "cos", "Cos": "cos", "COS": "cos",
    "tan": "tan", "Tan": "tan", **{x: x for x in RECIPROCALS}, "cosec": "csc",
    "sgn": "sgn", "sign": "sgn", "abs": "abs", "Abs": "abs",
    "Derivative": "Derivative", "diff": "Derivative", "jacobian": "jacobian",
    "Matrix": "Matrix", "array": "Matrix",
    "cross": "cross",
    "acos": "arccos", "arccos": "arccos", "Acos": "arccos", "asin": "arcsin", "arcsin": "arcsin",
    "Asin": "arcsin", "atan": "arctan", "arctan": "arctan", "Atan": "arctan", "atan2": "atan2",
    "Atan2": "atan2", "ATAN2": "atan2", "arctan2": "atan2", "sqrt": "sqrt",
}  # fmt: skip
_NOT_POLYNOMIAL = word_set("exp log ln")
VARIATION = "delta"
_MOST_IN_SUM, _FEW = 6, 3
"""The most angles of which all sums have names, θ123456, and of how many the sums of more angles
are."""
_BARE = str.maketrans("", "", "_{}\\")
GLUED = frozenset("MHCDBJ").union(
    *(spellings(letter, "", dots) for letter in ("q", "theta", "th") for dots in (1, 2)),
    ("q", "theta"),
)
"""Matrices and rates that stand side by side, Mq̈."""


@dataclass
class Vocabulary:
    """Names allowed in an answer, in plain spelling (see `words`), with their meanings."""

    setting: RightEquations
    quantities: frozenset[str] = frozenset()
    """Names of what can be asked: tau1, H12, …"""
    alone: frozenset[str] = frozenset()
    """The names of what can be asked that are no part of a longer word."""
    symbols: dict[str, Value] = field(default_factory=dict)
    waves: dict[str, tuple[str, Angle]] = field(default_factory=dict)
    """c12, s12: the function and the angle."""
    functions: dict[str, str] = field(default_factory=lambda: dict(FUNCTIONS))
    uses: dict[str, tuple[AskedQuantity, ...]] = field(default_factory=dict)
    """Quantities that names of the user's own are given by."""
    told: set[str] = field(default_factory=set)
    """Names of the user's own for expressions of quantities, which other lines may be about."""
    letters: dict[str, str] = field(default_factory=dict)
    """The user's letters for "cos" and "sin"."""
    aliases: dict[str, str] = field(default_factory=dict)
    """Names of the user's own for vectors and matrices, and what these are called here."""
    matrices: dict[str, Matrix] = field(default_factory=dict)
    """Vectors and matrices of the user's own."""
    trees: dict[str, Expression] = field(default_factory=dict)
    """Names of the user's own for what holds roots or inverse functions."""
    given: set[str] = field(default_factory=set)
    """Letters of vectors that lines give: they may be numbers, and so stand side by side, 4AC."""
    variations: set[int] = field(default_factory=set)
    """The places at which virtual displacements begin."""
    _known: frozenset[str] | None = None
    _inside_words: frozenset[str] = frozenset()
    """The names that may be a part of a longer word."""
    _glued: frozenset[str] = frozenset()
    """Matrices and rates that may stand side by side, Mq̈."""

    def __post_init__(self) -> None:
        for spelling, value in self._all_symbols():
            self.symbols.setdefault(spelling, value)
        for name, wave in self._all_waves():
            if name not in self.symbols:
                self.waves[name] = wave

    @property
    def known(self) -> frozenset[str]:
        """All known names except functions."""
        if self._known is None:
            own = (*self.aliases, *self.matrices, *self.trees)
            self._known = frozenset([*self.symbols, *self.waves, *self.quantities, *own, "t", "pi"])
            apart = self.alone.difference(self.symbols, self.waves)
            self._inside_words = self._known - apart
            self._glued = apart & GLUED
        return self._known

    def copy(self) -> Vocabulary:
        """A copy of the vocabulary, without the definitions made later."""
        kept = copy(self)
        tables = ((name, x) for name, x in vars(self).items() if isinstance(x, dict | set))
        kept.__dict__.update((name, copy(x)) for name, x in tables)
        return kept

    def define(
        self, plain: str, meaning: Value | Expression, uses: tuple[AskedQuantity, ...] = ()
    ) -> None:
        """Define a user's own name, with its value, vector, matrix or expression and the quantities
        in its definition; it takes precedence over other meanings."""
        self.uses[plain], self._known = uses, None
        if isinstance(meaning, Expression):
            self.symbols.pop(plain, None)
            if isinstance(meaning, Matrix):
                self.matrices[plain] = meaning
            else:
                self.trees[plain] = meaning
            return
        self.symbols[plain] = meaning
        self.waves.pop(plain, None)
        self.functions.pop(plain, None)

    def define_alias(self, plain: str, name: str) -> None:
        """Define a user's own name for a vector or matrix."""
        self.aliases[plain] = name
        self._known = None

    def also_wave(self, letter: str, function: str) -> None:
        """Define another letter for a function of angles: C12 for c12."""
        own = [(name, wave) for name, wave in self._all_waves() if wave[0] == function]
        self.waves.update((letter + name[1:], wave) for name, wave in own)
        self.letters[function] = letter
        if len(self.letters) > 1:
            self.symbols |= dict(self._products())
        self._known = None

    def _products(self) -> Iterator[tuple[str, Trig]]:
        """Abbreviations CC2 = C2 C2 and SC23 = S23 C23, as in the first papers on the Puma."""
        for numbers, names in self._subsets():
            angle = sum((self.setting.ring[x] for x in names), self.setting.zero)
            waves = {self.letters["cos"]: angle.cos(), self.letters["sin"]: angle.sin()}
            for (a, x), (b, y) in itertools.product(waves.items(), repeat=2):
                yield a + b + numbers, x * y

    def no_waves(self, names: Iterable[str]) -> None:
        """Remove names of quantities from the sines and cosines: c1 if c is a vector's letter."""
        for name in names:
            self.waves.pop(name, None)
        self._known = None

    # ------------------------------------------------------------ words of a text
    def begins(self, x: Lexeme) -> bool:
        """Whether a word can begin with a lexeme."""
        return words.begins(x)

    def word(self, source: Source, at: int) -> words.Cut:
        """The names that form the word at a lexeme."""
        word = words.spell(source, at)
        if word.plain == VARIATION and VARIATION not in self.known:
            word = _joined(source, word)
        pieces = self.cut(source, word)
        if pieces is None:
            self._unknown(source, word)
        named = [(self.aliases.get(x, x), start, end) for x, start, end in pieces]
        transposed = pieces[-1][2] < word.end
        return words.Cut(named, word.power, word.at - transposed)

    def cut(self, source: Source, word: words.Word) -> list[words.WordPiece] | None:
        """A word split into known names; None if it cannot be. Vectors' names stand alone (rc2x is
        never r·c2·x), except those of the equations of motion, Mq̈, and letters that lines
        define."""
        known = self.known
        known = known if word.plain in known else self._inside_words
        found = words.cut(source, word, known, self.functions)
        if found is None:
            found = words.cut(source, word, self._glued, ())  # Mq̈
        if found is None and self.given:
            found = words.cut(source, word, self._inside_words | self.given, self.functions)
        if found is None and word.plain.startswith(VARIATION):
            found = self._varied(word)
        return _before_prime(source, word, self.alone) if found is None else found

    def _varied(self, word: words.Word) -> list[words.WordPiece] | None:
        """A virtual displacement δθ1, read as the rate θ̇1, whose coefficients are the same."""
        rate = DOT + word.plain.removeprefix(VARIATION)
        if rate not in self.known:
            return None
        self.variations.add(word.start)
        return [(rate, word.start, word.end)]

    def _unknown(self, source: Source, spelt: words.Word) -> NoReturn:
        """Raise the error for an unknown name."""
        span = spelt.start, spelt.end
        word = source[span]
        plain = word.translate(_BARE)
        if plain in _NOT_POLYNOMIAL:
            source.fail(
                f"{plain} does not occur in these equations: write them with sin and cos", span
            )
        if words.DECORATIONS & set(spelt.plain):
            source.fail(
                f"{word} is not defined: a letter with a mark is another quantity than without",
                span,
                "What it stands for is told on a line before, or by --name YOURS=OURS.",
            )
        model = self.setting.symbols.model
        if instead := loads.instead_of(model, spelt.plain):
            source.fail(f"no symbol {word!r} in {model.name!r}", span, instead)
        names = self.listed
        near = likely(plain, names) or likely(spelt.plain, names)
        hint = f"{capitalised(did_you_mean(near))} " if near else ""
        if (wave := plain.lower()) in self.waves:
            function = {"sin": "sine", "cos": "cosine"}[self.waves[wave][0]]
            hint = f"The {function} of the angle is written {wave}. "
            near = []
        shown = word if len(word) <= 30 else word[:30] + "…"
        if target := near[0] if near else self._angle_of(plain):
            remedy = (
                f"For a name of your own: names={{{plain!r}: {target!r}}}, --name {plain}={target}."
            )
        else:
            remedy = (
                "What a name of your own stands for is told by --name YOURS=OURS, or on a line "
                "before. Words that are not part of an equation go after a #."
            )
        source.fail(
            f"no symbol {shown!r} in {self.setting.symbols.model.name!r}",
            span,
            f"{hint}Symbols: {', '.join(names[:24])}. {remedy}",
        )

    def _angle_of(self, plain: str) -> str:
        """The joint angle that a name such as t1 or phi1 may mean; "" if none."""
        own = atom(plain)
        meant = f"theta{own.figures}"
        is_angle = own.letter in ("t", "phi", "psi", "alpha") and own.is_numbered
        return meant if is_angle and meant in self.listed else ""

    @property
    def listed(self) -> list[str]:
        """The model's symbols, for error messages."""
        names = self.setting.ring.names
        return [x for x in names if x not in self.setting.foreign and not function_of(x)]

    # ------------------------------------------------------------ symbols
    def _all_symbols(self) -> Iterator[tuple[str, Trig]]:
        ring, s = self.setting.ring, self.setting.symbols
        moving = (
            x
            for x in ring.names
            if x + RATE in ring.index
            and atom(x).letter in COORDINATES
            and atom(x).is_numbered
            and not atom(x).dots
        )
        if self.setting.is_free_body:
            yield from free_body.symbols(self.setting)
        for name in [*s.coordinates, *moving]:
            yield from self._coordinate(name)
        for name in ring.names:
            yield name.replace("_", ""), ring[name]
            if is_multiplier(name):
                yield name.replace(MULTIPLIER, "lambda"), ring[name]
        for name in self.setting.zeros:
            yield name.replace("_", ""), self.setting.zero
        yield from self._of_links()
        if self.setting.is_planar:
            yield from self._absolute_rates()
        yield from self._sums()
        yield from loads.symbols(self.setting, self.quantities)
        gravity = self.setting.order.gravity
        if gravity:
            yield "g", ring[gravity]

    def _coordinate(self, name: str) -> Iterator[tuple[str, Trig]]:
        """Synonyms of a coordinate and its rates: q1, th1, dtheta1, theta1', …"""
        letters, number = atom(name).letter, atom(name).figures
        alone = len(self.setting.symbols.coordinates) == 1 or letters in ("x", "y")
        own = self._is_own(number)
        row = COORDINATES.get(letters)
        for letter in (letters, *(row.also if row else ())):
            if letter == "q" and name not in self.setting.symbols.coordinates and own:
                continue
            bare = alone and letters not in ("x", "y")
            if letter in ("theta", "th"):  # of a cart with a pendulum θ is enough
                bare = [x for x in self.setting.symbols.coordinates if self.setting.turns(x)] == [
                    name
                ]
            for k in (number, "") if bare else (number,):
                for dots, ending in enumerate(("", RATE, SECOND)):
                    for spelling in spellings(letter, k, dots):
                        yield spelling, self.setting.ring[name + ending]

    def _is_own(self, number: str) -> bool:
        """Whether the name of some coordinate of the model has the number."""
        return any(atom(x).figures == number for x in self.setting.symbols.coordinates)

    def _of_links(self) -> Iterator[tuple[str, Trig]]:
        """Synonyms of a planar arm's parameters; without numbers if it has one link."""
        alone = self.setting.joints == 1
        for row in PARAMETERS:
            for k in range(1, self.setting.joints + 1):
                value = self.setting.parameter(f"{row.letter}{k}")
                if value is not None:
                    yield from (
                        (x, value) for x in (*row.spelt(k), *(row.spelt("") if alone else ()))
                    )

    def _absolute_rates(self) -> Iterator[tuple[str, Trig]]:
        """The angular velocity ω_i, the sum of the joint rates from the ground to body i, (3.16)
        and (3.17), and its time derivative."""
        setting = self.setting
        model, own = setting.symbols.model, names_by_body(setting.symbols.model)
        for i, names in enumerate(own):
            k = atom(names[0]).figures if len(names) == 1 else ""
            if not k:
                continue
            turning, at = [], i
            while at >= 0:
                turning += [x for x in own[at] if setting.turns(x)]
                at = model.bodies[at].parent
            for dots, ending in ((0, RATE), (1, SECOND)):
                value = sum((setting.image(x + ending) for x in turning), setting.zero)
                for letter, number in itertools.product(
                    ("omega", "w"), (k, "") if len(setting.symbols.coordinates) == 1 else (k,)
                ):
                    for spelling in spellings(letter, number, dots):
                        yield spelling, value
                if dots:
                    yield f"alpha{k}", value

    def _sums(self) -> Iterator[tuple[str, Trig]]:
        """Sums of angles by name: theta12 is theta1 + theta2; their rates too."""
        ring = self.setting.ring
        for numbers, names in self._subsets():
            if len(names) > 1:
                for dots, ending in enumerate(("", RATE, SECOND)):
                    value = sum((ring[x + ending] for x in names), self.setting.zero)
                    for letter in ("theta", "q", "th"):
                        for spelling in spellings(letter, numbers, dots):
                            yield spelling, value

    def _subsets(self) -> Iterator[tuple[str, tuple[str, ...]]]:
        """Subsets of angles with rising one-digit numbers."""
        angles = sorted(
            x
            for x in self.setting.ring.angles
            if atom(x).letter == "theta" and atom(x).is_numbered and len(atom(x).figures) == 1
        )
        sizes = range(1, 1 + (len(angles) if len(angles) <= _MOST_IN_SUM else _FEW))
        for size in sizes:
            for names in itertools.combinations(angles, size):
                yield "".join(x[-1] for x in names), names

    def _all_waves(self) -> Iterator[tuple[str, tuple[str, Angle]]]:
        if self.setting.is_free_body:
            yield from free_body.waves(self.setting)
        for numbers, names in self._subsets():
            for letter, function in (("c", "cos"), ("s", "sin")):
                angle = tuple((x, 1) for x in sorted(names, key=self.setting.ring.angles.index))
                yield letter + numbers, (function, angle)


def _joined(source: Source, word: words.Word) -> words.Word:
    """A word \\delta joined with the name after it, as in \\delta\\theta_1."""
    if word.at == len(source.lexemes) or not words.begins(source.lexemes[word.at]):
        return word
    behind = words.spell(source, word.at)
    plain = word.plain + behind.plain
    return words.Word(word.start, behind.at, behind.end, plain, power=behind.power)


def _before_prime(
    source: Source, word: words.Word, vectors: Collection[str]
) -> list[words.WordPiece] | None:
    """A vector or matrix without the prime after it, which marks its transpose as in MATLAB's qd';
    None otherwise."""
    items, plain = source.lexemes.items, word.plain.removesuffix(PRIME)
    if plain == word.plain or plain not in vectors or items[word.at - 1].text not in PRIMES:
        return None
    return [(plain, word.start, items[word.at - 2].end)]
