"""Names as they are written, θ̇₁, \\dot{\\theta}_1, l_{c1} or m2glc2, spelt in one plain way and
cut into known names.

Plain spelling: Greek letters by name, subscripts behind the letter without underscore, dots as ˙
before the letter, primes behind: ˙theta1, lc1, theta1'.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from functools import lru_cache
from itertools import pairwise

from freebody.expressions.grammar.lexemes import Lexeme
from freebody.expressions.grammar.patterns import LexemePattern
from freebody.expressions.grammar.source import Source, UnreadableError
from freebody.expressions.grammar.tables import characters as table
from freebody.expressions.grammar.tables.characters import DOT, PRIME

DECORATIONS = frozenset(table.DECORATIONS)
"""Marks with which a letter is another quantity: θ̄, θ̂, θ*."""
FRAMES = tuple(map(chr, range(0xE010, 0xE01A)))
"""Marks behind a name, one for each frame: of {}^1v_2 the plain spelling is v2 and the second."""
DETERMINANT = "\ue01a"
"""The mark behind the name of a determinant, |J|."""
COMMANDS = frozenset((*table.FONTS, *table.LETTER_COMMANDS, *table.ACCENTS))
"""LaTeX commands that a name may begin with."""
COMMAND_NAMES = table.LETTER_COMMANDS
"""Plain names of LaTeX's letters."""
_STAR = LexemePattern("@asterisk")
_EARLY_POWER = LexemePattern("< ^ ~{? power:~%digit ~}? | power:< ² | ³ > > &< ~_ | ~%low_digit >")
"""A power in front of a subscript, l²₁."""
_DEEPEST, _LONGEST = 4, 200
_ONE_LETTER = "a dot or bar needs a single letter under it, such as \\dot{\\theta}_1"


@dataclass
class Word:
    """A run of letters, digits and marks in plain spelling, with the place in the source where each
    character comes from."""

    start: int
    at: int
    """The lexeme behind the word."""
    end: int
    """The place at which the last lexeme ends in the text."""
    plain: str = ""
    origins: list[int] = field(default_factory=list)
    cuts: set[int] = field(default_factory=set)
    """The places at which a new name may begin: not inside `theta` that was one letter."""
    power: int | None = None
    """A power that stood before the subscript, as in l²₁."""

    def add(self, plain: str, origin: int, cut: bool = True) -> None:
        """Append one more unit to the word, from the lexeme at `origin`."""
        if cut:
            self.cuts.add(len(self.plain))
        self.plain += plain
        self.origins += [origin] * len(plain)


def letter(x: Lexeme) -> str:
    """The plain spelling of a letter with its marks; "" for any other lexeme."""
    return _letter(x.text) if x.kind == "letter" else ""


@lru_cache(maxsize=1000)
def _letter(text: str) -> str:
    c, marks = text[0], text[1:]
    if not (c in table.LETTERS or c.isascii()) or any(mark not in table.MARKS for mark in marks):
        return ""
    return "".join(table.MARKS[mark] for mark in marks) + table.LETTERS.get(c, c)


def begins(x: Lexeme) -> bool:
    """Whether a name may begin with the given lexeme."""
    return x.text == "_" or x.command in COMMANDS or letter(x) != ""


class _Speller:
    """A reader of one word, which may stand inside another one."""

    def __init__(self, source: Source, at: int):
        self.source, self.items = source, source.lexemes.items
        start = self.items[at].start
        self.word = Word(start, at, start)

    def whole(self, depth: int) -> Word:
        if self.items[self.word.at].kind == "command":
            self._command(depth)
        first = self.word.at == self.source.lexemes.at(self.word.start)
        while self.word.at < len(self.items):
            if (self._next.apart and not first) or not self._unit():
                break
            first = False
        return self.word

    @property
    def _next(self) -> Lexeme:
        return self.items[self.word.at]

    def _take(self, count: int = 1) -> None:
        self.word.at += count
        self.word.end = self.items[self.word.at - 1].end

    # ------------------------------------------------------------ units
    def _unit(self) -> bool:
        """Read one more unit of a word, if the word goes on."""
        x, word = self._next, self.word
        if plain := letter(x):
            self._take()
            word.add(self._marks() + plain, x.start)
        elif x.kind == "digit":
            self._take()
            word.add(x.text, x.start)
        elif x.kind == "low":
            self._take()
            word.add(table.LOW[x.text], x.start, cut=False)
        elif x.text in table.PRIMES:
            self._take()
            word.add(PRIME * table.PRIMES[x.text], x.start, cut=False)
        elif star := _STAR.at(self.source.lexemes, word.at):
            self._take(star.stop - star.start)
            word.add("*", x.start, cut=False)
        elif early := _EARLY_POWER.at(self.source.lexemes, word.at):
            self._take(early.stop - early.start)
            word.power = int(table.HIGH.get(early["power"], early["power"]))
        elif x.kind in ("frame", "determinant"):
            self._take()
            word.add(FRAMES[int(x.text)] if x.text else DETERMINANT, x.start, cut=False)
        elif x.text == "_":
            self._subscript()
        else:
            return False
        return True

    def _marks(self) -> str:
        """The marks that follow a letter as separate lexemes, in plain spelling; they are used
        up."""
        marks = ""
        while self.word.at < len(self.items) and self._next.kind == "mark" and not self._next.apart:
            marks += table.MARKS.get(self._next.text, "")
            self._take()
        return marks

    def _subscript(self) -> None:
        """Read a subscript behind underscores: a group in braces, or a single letter that begins no
        name."""
        word = self.word
        while word.at < len(self.items) and self._next.text == "_":
            self._take()
        if word.at >= len(self.items) or self._next.apart:
            return
        if self._next.text != "{":
            if self._next.command in COMMAND_NAMES:
                word.add(COMMAND_NAMES[self._next.command], self._next.start, cut=False)
                self._take()
            elif word.plain:
                start = len(word.plain)
                if self._unit():
                    word.cuts.discard(start)
            return
        close = self._closing(word.at)
        for x in self.items[word.at + 1 : close]:
            primes = PRIME * table.PRIMES.get(x.text, 0)
            own = x.text[0] if x.kind in ("letter", "digit") else ""
            own = own if own.isascii() else table.LETTERS.get(own, "")
            word.add(own or primes or COMMAND_NAMES.get(x.command, ""), x.start, cut=False)
        self._take(close + 1 - word.at)

    def _closing(self, k: int) -> int:
        close = self.source.lexemes.closing(k)
        if close is None:
            self.source.fail("this brace is not closed", (self.items[k].start, self.items[k].end))
        return close

    # ------------------------------------------------------------ commands
    def _command(self, depth: int) -> None:
        """A LaTeX command that begins a word: a Greek letter, a dot over something, a font."""
        x, word = self._next, self.word
        self._take()
        if x.command in COMMAND_NAMES:
            word.add(COMMAND_NAMES[x.command], x.start)
            return
        if x.command not in COMMANDS:
            self.source.fail(f"the command {x.text} is not known here", (x.start, x.end))
        if depth == _DEEPEST:
            self.source.fail("commands inside commands, too deep", (x.start, x.end))
        inner = self._argument(depth + 1)
        marks = table.ACCENTS.get(x.command, "")
        if DOT in marks and inner.plain.startswith(DOT):
            self.source.fail("dots over dots", (x.start, word.end))
        for k, c in enumerate(marks + inner.plain):
            word.add(c, x.start, cut=k == 0 or (not marks and k in inner.cuts))
        word.power = inner.power

    def _argument(self, depth: int) -> Word:
        """The argument of a command, a group in braces or the next letter."""
        start, k = self.word.end, self.word.at
        x = self.items[k] if k < len(self.items) else None
        if x is None or not (x.text == "{" or begins(x) or x.kind == "command"):
            self.source.fail(_ONE_LETTER, (start, x.end if x else start + 1))
        if x.text != "{":
            inner = self._single(k)
        else:
            close = self._closing(k)
            inner = self._grouped(k + 1, close, depth)
            if inner.at != close:
                self.source.fail(_ONE_LETTER, (start, self.items[close].start))
            inner.at, inner.end = close + 1, self.items[close].end
        self.word.at, self.word.end = inner.at, inner.end
        return inner

    def _grouped(self, k: int, close: int, depth: int) -> Word:
        """The word in a group, which may be a group itself, \\dot{{\\theta}}."""
        x = self.items[k]
        if x.text == "{" and depth < _DEEPEST:
            end = self._closing(k)
            inner = self._grouped(k + 1, end, depth + 1)
            if inner.at == end:
                inner.at = end + 1
            return inner
        if k >= close or not (begins(x) or x.kind == "command"):
            self.source.fail(_ONE_LETTER, (self.items[k - 1].start, x.end))
        return _Speller(self.source, k).whole(depth)

    def _single(self, k: int) -> Word:
        """A single letter or Greek command."""
        inner = _Speller(self.source, k)
        x = self.items[k]
        if x.kind != "command":
            inner._unit()
        elif x.command in COMMAND_NAMES:
            inner.word.add(COMMAND_NAMES[x.command], x.start)
            inner._take()
        else:
            self.source.fail(_ONE_LETTER, (x.start, x.start + 1))
        return inner.word


def spell(source: Source, at: int) -> Word:
    """The word that begins at a lexeme of a text."""
    return _Speller(source, at).whole(0)


def word_at(source: Source, at: int) -> Word | None:
    """The word that begins at a lexeme of a text; None if no word that can be read begins there."""
    if at not in source.words:
        source.words[at] = None
        if at < len(source.lexemes) and begins(source.lexemes[at]):
            with suppress(UnreadableError):
                source.words[at] = spell(source, at)
    return source.words[at]


def dotted(source: Source) -> frozenset[str]:
    """The plain spellings of the words in a text that have dots, as marks or in letters."""
    found = words_in(source, range(len(source.lexemes)))
    return frozenset(x for x in found if DOT in x or "dot" in x)


def words_in(source: Source, within: range) -> Iterator[str]:
    """The plain spellings of the words in a stretch."""
    k = within.start
    while k < within.stop:
        word = word_at(source, k)
        if word is not None:
            yield word.plain
        k = max(word.at if word else 0, k + 1)


def spelt(name: str) -> str:
    """The plain spelling of a text that is one name and no more, else ""."""
    source = Source.of(name.strip())
    word = word_at(source, 0)
    is_one = word is not None and word.at == len(source.lexemes) and word.power is None
    return word.plain if word is not None and is_one else ""


WordPiece = tuple[str, int, int]
"""A known name, and where it stands in the text."""


@dataclass(frozen=True)
class Cut:
    """A word as a list of known names and numbers, with a power that stood inside and the index of
    the lexeme behind it."""

    pieces: list[WordPiece]
    power: int | None
    stop: int


def cut(
    source: Source, word: Word, known: Collection[str], functions: Collection[str]
) -> list[WordPiece] | None:
    """The word cut into the fewest known names; a number may follow a function (cos2θ1). None where
    that is impossible."""
    if word.plain in known or word.plain in functions:
        return [(word.plain, word.start, word.end)]
    if not 0 < len(word.plain) <= _LONGEST:
        return None
    ways = _shortest_ways(word, known, functions)
    if not ways:
        return None
    if len(ways) > 1:
        readings = " or ".join("·".join(_pieces(word, way)) for way in ways)
        source.fail(
            f"{source[word.start, word.end]!r} may be {readings}: put spaces",
            (word.start, word.end),
        )
    (way,) = ways
    ends = [word.origins[j] for j in way[1:-1]] + [word.end]
    starts = [word.start, *ends[:-1]]
    return list(zip(_pieces(word, way), starts, ends, strict=True))


def _shortest_ways(
    word: Word, known: Collection[str], functions: Collection[str]
) -> list[list[int]]:
    """Ways to cut a word into the fewest known pieces, each as the list of their ends; at most two,
    which suffice to see an ambiguity."""
    best: dict[int, list[list[int]]] = {0: [[0]]}  # by the place that they reach
    for i in sorted(word.cuts):
        for j in sorted({*word.cuts, len(word.plain)}):
            if i not in best or j <= i:
                continue
            piece, ways = word.plain[i:j], best[i]
            if piece.isdigit():
                ways = [w for w in ways if len(w) > 1 and word.plain[w[-2] : i] in functions]
            elif piece not in known and piece not in functions:
                ways = []
            longer = [[*way, j] for way in ways]
            if longer and (j not in best or len(longer[0]) < len(best[j][0])):
                best[j] = longer
            elif longer and len(longer[0]) == len(best[j][0]):
                best[j] = (best[j] + longer)[:2]
    return best.get(len(word.plain), [])


def _pieces(word: Word, way: list[int]) -> list[str]:
    return [word.plain[i:j] for i, j in pairwise(way)]
