"""Names as they are written, θ̇₁, \\dot{\\theta}_1, l_{c1} or m2glc2, spelt in one plain way and
cut into known names.

Plain spelling: Greek letters by name, subscripts behind the letter without underscore, dots as ˙
before the letter, primes behind: ˙theta1, lc1, theta1'.
"""

from __future__ import annotations

import re
from collections.abc import Collection
from dataclasses import dataclass, field
from itertools import pairwise

from freebody.derivations.expressions.printed_names import GREEK
from freebody.derivations.grammar.source import Source, UnreadableError
from freebody.identifiers import word_set

DOT, PRIME = "˙", "'"
_LETTERS = {letter: name for name, letter in GREEK.items()} | {
    "ϑ": "theta",
    "ϕ": "phi",
    "λ": "lam",
    "ɡ": "g",
    "Θ": "Theta",
    "Φ": "Phi",
}
_COMMANDS = {name: name for name in GREEK} | {
    "lambda": "lam",
    "vartheta": "theta",
    "varphi": "phi",
    "Theta": "Theta",
    "Phi": "Phi",
    "ell": "l",
}
_FONTS = word_set(
    "mathrm mathit mathbf mathsf mathcal boldsymbol bm text operatorname textrm rm vec"
)
_ACCENTS = {
    "dot": DOT, "ddot": DOT * 2, "bar": "\u0304", "overline": "\u0304", "hat": "\u0302",
    "widehat": "\u0302", "tilde": "\u0303", "widetilde": "\u0303", "underline": "\u0332",
    "check": "\u030c", "breve": "\u0306", "mathring": "\u030a",
}  # fmt: skip
"""Commands for a mark on a letter."""
DECORATIONS = frozenset("".join(_ACCENTS.values())) - {DOT} | {"*"}
"""Marks with which a letter is another quantity: θ̄, θ̂, θ*."""
MARKS = {"\u0307": DOT, "\u0308": DOT * 2, "˙": DOT, "¨": DOT * 2, "\u20d7": "", "\u0305": "\u0304"}
MARKS |= {mark: mark for mark in DECORATIONS if mark != "*"}
"""Characters behind a letter that are a mark on it; an arrow only says that it is a vector."""
FRAMES = tuple(map(chr, range(0xE010, 0xE01A)))
"""Marks behind a name, one for each frame: of {}^1v_2 the plain spelling is v2 and the second."""
DETERMINANT = "\ue01a"
"""The same of what stands between bars, |J|."""
_PRIMES = {"'": 1, "’": 1, "′": 1, "″": 2}
_LOW = {c: str(k) for k, c in enumerate("₀₁₂₃₄₅₆₇₈₉")} | {
    "ₐ": "a", "ₑ": "e", "ₒ": "o", "ₓ": "x", "ᵢ": "i", "ⱼ": "j", "ₘ": "m", "ₙ": "n", "ₚ": "p",
    "ₜ": "t",
}  # fmt: skip
_HIGH = {c: str(k) for k, c in enumerate("⁰¹²³⁴⁵⁶⁷⁸⁹")} | {"⁻": "-", "⁺": ""}
_STAR = re.compile(r"\^\s?(?:[*∗⋆]|\\(?:ast|star)(?![A-Za-z])|\{\s?(?:[*∗⋆]|\\(?:ast|star))\s?\})")
_EARLY_POWER = re.compile(r"(?:\^\{?([0-9])\}?|([²³]))(?=_|[₀-₉])")
_DEEPEST, _LONGEST = 4, 200
_COMMAND = re.compile(r"\\([A-Za-z]+)")

STARTS = frozenset(_LETTERS) | frozenset("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ_")
"""Characters that a name may begin with; commands apart."""

COMMAND_NAMES = _COMMANDS
"""Plain names of LaTeX's letters."""

COMMANDS = _FONTS.union(_COMMANDS, _ACCENTS)
"""LaTeX commands that a name may begin with."""


@dataclass
class Word:
    """A run of letters, digits and marks in plain spelling, with where each character comes
    from."""

    start: int
    end: int
    plain: str = ""
    origins: list[int] = field(default_factory=list)
    cuts: set[int] = field(default_factory=set)
    """Where a new name may begin: not inside `theta` that was one letter."""
    power: int | None = None
    """A power that stood before the subscript, as in l²₁."""

    def add(self, plain: str, origin: int, cut: bool = True) -> None:
        """One more unit."""
        if cut:
            self.cuts.add(len(self.plain))
        self.plain += plain
        self.origins += [origin] * len(plain)


def spell(source: Source, at: int, depth: int = 0) -> Word:
    """The word that begins there, `depth` commands deep."""
    word = Word(at, at)
    if source.text[at] == "\\":
        _command(source, word, depth)
    while word.end < len(source.text) and _unit(source, word):
        pass
    return word


def spelt(name: str) -> str:
    """The plain spelling of a text that is one name and no more, else ""."""
    source = Source.of(name.strip())
    if not source.text or not (source.text[0] in STARTS or source.text[0] == "\\"):
        return ""
    try:
        word = spell(source, 0)
    except UnreadableError:
        return ""
    return word.plain if word.end == len(source.text) and word.power is None else ""


def _command(source: Source, word: Word, depth: int) -> None:
    """A LaTeX command that begins a word: a Greek letter, a dot over something, a font."""
    match = _COMMAND.match(source.text, word.end)
    name = match[1] if match else ""
    start, word.end = word.end, match.end() if match else word.end + 1
    if name in _COMMANDS:
        word.add(_COMMANDS[name], start)
        return
    if name not in COMMANDS:
        source.fail(f"the command \\{name} is not known here", (start, word.end))
    if depth == _DEEPEST:
        source.fail("commands inside commands, too deep", (start, word.end))
    inner = _argument(source, word, depth + 1)
    marks = _ACCENTS.get(name, "")
    if DOT in marks and inner.plain.startswith(DOT):
        source.fail("dots over dots", (start, word.end))
    for k, letter in enumerate(marks + inner.plain):
        word.add(letter, start, cut=k == 0 or (not marks and k in inner.cuts))
    word.power = inner.power


def _argument(source: Source, word: Word, depth: int) -> Word:
    """What a command applies to, a group in braces or the next letter; `word.end` moves behind
    it."""
    start = word.end
    at = start
    while source.text[at : at + 1] == " ":
        at += 1
    braced = source.text[at : at + 1] == "{"
    close = _closing(source, at) if braced else len(source.text)
    at += braced
    while source.text[at : at + 1] == " ":
        at += 1
    if braced and source.text[at : at + 1] == "{" and depth < _DEEPEST:
        around = Word(at, at)  # \\dot{{\\theta}}
        inner = _argument(source, around, depth + 1)
        word.end = close + 1
        if not source.text[around.end : close].strip():
            return inner
    if at >= close or not (source.text[at] in STARTS or source.text[at] == "\\"):
        source.fail(
            "a dot or bar needs a single letter under it, such as \\dot{\\theta}_1", (start, at + 1)
        )
    inner = spell(source, at, depth) if braced else _single(source, at)
    if braced and source.text[inner.end : close].strip():
        source.fail(
            "a dot or bar needs a single letter under it, such as \\dot{\\theta}_1", (start, close)
        )
    word.end = close + 1 if braced else inner.end
    return inner


def _single(source: Source, at: int) -> Word:
    """A single letter or Greek command."""
    word = Word(at, at)
    if source.text[at] != "\\":
        _unit(source, word)
        return word
    match = _COMMAND.match(source.text, at)
    if match is None or match[1] not in _COMMANDS:
        source.fail(
            "a dot or bar needs a single letter under it, such as \\dot{\\theta}_1", (at, at + 1)
        )
    word.add(_COMMANDS[match[1]], at)
    word.end = match.end()
    return word


def _unit(source: Source, word: Word) -> bool:
    """Read one more unit of a word, if there is one."""
    at, text = word.end, source.text
    c = text[at]
    if c in _LETTERS or (c.isascii() and c.isalpha()):
        word.end += 1
        marks = ""
        while text[word.end : word.end + 1] in MARKS:
            marks += MARKS[text[word.end]]
            word.end += 1
        word.add(marks + _LETTERS.get(c, c), at)
    elif c.isascii() and c.isdigit():
        word.end += 1
        word.add(c, at)
    elif c in _LOW:
        word.end += 1
        word.add(_LOW[c], at, cut=False)
    elif c in _PRIMES:
        word.end += 1
        word.add(PRIME * _PRIMES[c], at, cut=False)
    elif star := _STAR.match(text, at):
        word.end = star.end()
        word.add("*", at, cut=False)
    elif early := _EARLY_POWER.match(text, at):
        word.power = int(early[1] or _HIGH[early[2]])
        word.end = early.end()
    elif c in FRAMES or c == DETERMINANT:
        word.end += 1
        word.add(c, at, cut=False)
    elif c == "_":
        _subscript(source, word)
    else:
        return False
    return True


def _subscript(source: Source, word: Word) -> None:
    """What follows underscores: a group in braces, or one letter, with which no name begins."""
    while source.text[word.end : word.end + 1] == "_":
        word.end += 1
    if source.text[word.end : word.end + 1] != "{":
        command = _COMMAND.match(source.text, word.end)
        if command and command[1] in _COMMANDS:
            word.add(_COMMANDS[command[1]], word.end, cut=False)
            word.end = command.end()
        elif word.plain:
            start = len(word.plain)
            if word.end < len(source.text) and _unit(source, word):
                word.cuts.discard(start)
        return
    at, close = word.end + 1, _closing(source, word.end)
    while at < close:
        c, end = source.text[at], at + 1
        if command := _COMMAND.match(source.text, at, close):
            word.add(_COMMANDS.get(command[1], ""), at, cut=False)  # fonts say nothing
            end = command.end()
        elif c.isascii() and c.isalnum():
            word.add(c, at, cut=False)
        elif c in _PRIMES:
            word.add(PRIME * _PRIMES[c], at, cut=False)
        at = end
    word.end = close + 1


def _closing(source: Source, at: int) -> int:
    """Where the brace that opens there is closed."""
    depth = 0
    for k in range(at, len(source.text)):
        depth += {"{": 1, "}": -1}.get(source.text[k], 0)
        if depth == 0:
            return k
    source.fail("this brace is not closed", (at, at + 1))


def superscript(text: str, at: int) -> tuple[int | None, int]:
    """The number that superscript characters spell there, and where they end."""
    end = at
    while text[end : end + 1] and text[end] in _HIGH:
        end += 1
    digits = "".join(_HIGH[c] for c in text[at:end])
    return (int(digits) if re.fullmatch(r"-?\d{1,9}", digits) else None), end


Piece = tuple[str, int, int]
"""A known name, and where it stands in the text."""


def cut(
    source: Source, word: Word, known: Collection[str], functions: Collection[str]
) -> list[Piece] | None:
    """A word as the fewest known names; a number may follow a function (cos2θ1). None where there
    is no way."""
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
    """Where the fewest pieces begin and the last one ends: no way, the only one, or two of
    several."""
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
