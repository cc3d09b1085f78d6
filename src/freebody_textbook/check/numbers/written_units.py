"""Parsing units as people write them: N m, Nmm, kg·m², °/s, rpm; also in LaTeX and siunitx."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

from freebody.expressions.grammar.lexemes import Lexemes
from freebody.expressions.grammar.patterns import LexemePattern
from freebody.expressions.grammar.tables.characters import BRACKETS
from freebody.expressions.quantities.units import Unit

_DEGREE = math.pi / 180
_BASE: dict[str, tuple[float, Unit]] = {
    "rad": (1.0, (0, 0, 0)), "°": (_DEGREE, (0, 0, 0)), "rev": (2 * math.pi, (0, 0, 0)),
    "m": (1.0, (0, 1, 0)), "g": (1e-3, (1, 0, 0)), "s": (1.0, (0, 0, 1)),
    "min": (60.0, (0, 0, 1)), "N": (1.0, (1, 1, -2)), "J": (1.0, (1, 2, -2)),
    "W": (1.0, (1, 2, -3)), "rpm": (math.pi / 30, (0, 0, -1)),
}  # fmt: skip
"""Factor to SI units, and powers of kg, m and s."""
_PREFIXES = {"k": 1e3, "c": 1e-2, "m": 1e-3, "µ": 1e-6, "μ": 1e-6, "M": 1e6}
_KNOWN = _BASE | {
    prefix + name: (factor * _BASE[name][0], _BASE[name][1])
    for name in ("m", "g", "s", "N", "J", "W", "rad")
    for prefix, factor in _PREFIXES.items()
}
_SYNONYMS = {
    "deg": "°", "degree": "°", "radian": "rad", "newton": "N", "metre": "m", "meter": "m",
    "kilogram": "kg", "gram": "g", "second": "s", "sec": "s", "joule": "J", "watt": "W",
}  # fmt: skip
_SIUNITX = {"kilo": "k", "milli": "m", "centi": "c", "micro": "µ", "mega": "M"}
_FORCES = ("N", "kN", "mN", "cN", "MN", "kg")
_ALONG = ("", "mm", "cm", "m")
_BEHIND = ("", "s", "rad")
_TOGETHER = {
    "".join(parts): [part for part in parts if part]
    for parts in itertools.product(_FORCES, _ALONG, _BEHIND)
}
"""Units written without blanks, and their parts: Nm, Nms, kgm."""
UNITS = (*_KNOWN, *_SYNONYMS, *filter(None, _TOGETHER))
"""Words that stand for units."""
_WORD = LexemePattern("< word:@unit_letters raised:~%two_or_three? !~%unit_goes_on | word:° >")
_LONG_WORD = LexemePattern("word:@unit_letters")
_POWER = LexemePattern(
    "^ < { power:< %minus? %digit > } | power:< %minus? %digit > > | ~ power:%two_or_three"
    " | ~ power:< ⁻? %raised > | power:%raised_word"
)
_RAISED = {"²": 2, "³": 3, "¹": 1, "⁻¹": -1, "⁻²": -2, "⁻³": -3, "squared": 2, "cubed": 3}
_BLANK = LexemePattern("%line*")
_TIMES = LexemePattern("%times_of_units | - &~%latin")
_PER = LexemePattern("/ | \\per | per")
_OPEN = LexemePattern("%unit_font { | { | [ | (")


@dataclass(frozen=True)
class WrittenUnit:
    """A unit in readable form, with its factor to SI units."""

    text: str
    factor: float
    dimension: Unit
    words: tuple[str, ...] = ()
    """The words that the unit is made of, as they are written."""


def common_units(dimension: Unit) -> list[WrittenUnit]:
    """Common units of a dimension, one of which may be meant by mistake."""
    names = {
        (1, 2, -2): ("N m", "N mm", "N cm", "kN m", "mN m"), (1, 1, -2): ("N", "kN", "mN"),
        (0, 1, 0): ("m", "mm", "cm"), (0, 0, 0): ("rad", "°"), (1, 0, 0): ("kg", "g"),
        (0, 0, -1): ("rad/s", "°/s", "rpm"), (0, 0, -2): ("rad/s²", "°/s²"),
        (0, 1, -1): ("m/s", "mm/s"), (0, 1, -2): ("m/s²", "mm/s²"), (1, 2, -3): ("W", "kW", "mW"),
        (1, 2, 0): ("kg m²", "kg mm²", "g mm²", "kg cm²"),
    }  # fmt: skip
    return [
        found[0] for name in names.get(dimension, ()) if (found := unit_at(Lexemes.of(name), 0))
    ]


def unit_at(lexemes: Lexemes, at: int) -> tuple[WrittenUnit, int] | None:
    """The unit written at a lexeme, and the lexeme after it; None if there is none."""
    return _UnitReader(lexemes, at).read()


class _UnitReader:
    """Reads a unit factor by factor until something else follows; brackets must close."""

    def __init__(self, lexemes: Lexemes, at: int):
        self.lexemes, self.at = lexemes, at
        self.closing: list[str] = []
        self.signs = [1]
        self.factor, self.dimension = 1.0, (0, 0, 0)
        self.shown: list[tuple[str, int]] = []
        self.words: list[str] = []
        self.last: int | None = None
        """The lexeme behind the last factor with all brackets closed."""

    def read(self) -> tuple[WrittenUnit, int] | None:
        while self._step():
            if not self.closing and self.shown:
                self.last = self.at
        if self.last is None:
            return None
        return WrittenUnit(self._shown(), self.factor, self.dimension, tuple(self.words)), self.last

    def _step(self) -> bool:
        """Read one factor with the sign before it; returns whether there was one."""
        at, sign = _BLANK.end(self.lexemes, self.at), 1
        if at >= len(self.lexemes):
            return False
        if self.closing and self.lexemes[at].text == self.closing[-1]:
            self.closing.pop()
            self.signs.pop()
            self.at = at + 1
            return True
        if self.shown and (times := _TIMES.at(self.lexemes, at)):
            at = _BLANK.end(self.lexemes, times.stop)
        elif per := _PER.at(self.lexemes, at):
            at, sign = _BLANK.end(self.lexemes, per.stop), -1
        if opened := _OPEN.at(self.lexemes, at):
            bracket = self.lexemes[opened.stop - 1].text
            if bracket != "(" or sign < 0 or not self.shown:
                self.closing.append(BRACKETS[bracket])
                self.signs.append(self.signs[-1] * sign)
                self.at = opened.stop
                return True
        return self._word(at, self.signs[-1] * sign)

    def _word(self, at: int, sign: int) -> bool:
        match = _WORD.at(self.lexemes, at)
        if match is None:
            return False
        word, end = match["word"].lstrip("\\"), match.stop
        if "raised" in match:  # kg m2, kgm2
            end -= 1
            if not self.shown and len(_parts(word)) < 2:
                return False
        if word in _SIUNITX and (following := _LONG_WORD.at(self.lexemes, end)):
            word = _SIUNITX[word] + _named(following["word"].lstrip("\\"))
            end = following.stop
        parts = _parts(_named(word))
        if not parts:
            return False
        exponent = 1
        if power := _POWER.at(self.lexemes, end):
            raised = power["power"].lstrip("\\")
            exponent = _RAISED[raised] if raised in _RAISED else int(raised.replace("−", "-"))
            end = power.stop
        for k, part in enumerate(parts):
            self._take(part, sign * (exponent if k == len(parts) - 1 else 1))
        self.words.append(match["word"] + match["raised"])
        self.at = end
        return True

    def _take(self, name: str, exponent: int) -> None:
        factor, dimension = _KNOWN[name]
        self.factor *= factor**exponent
        kg, m, s = (a + exponent * b for a, b in zip(self.dimension, dimension, strict=True))
        self.dimension = (kg, m, s)
        self.shown.append((name, exponent))

    def _shown(self) -> str:
        raised = {1: "", 2: "²", 3: "³"}
        above, below = (
            " ".join(
                f"{name}{raised.get(abs(e), f'^{abs(e)}')}"
                for name, e in self.shown
                if e * sign > 0
            )
            for sign in (1, -1)
        )
        below = f"({below})" if " " in below else below
        return f"{above or '1'}/{below}" if below else above


def _parts(word: str) -> list[str]:
    """The units in a compound word: N and m of Nm."""
    return [word] if word in _KNOWN else _TOGETHER.get(word, [])


def _named(word: str) -> str:
    """The symbol of a unit that is written as a word, such as Newtons or millimetres."""
    plain = word.lower().removesuffix("s") if len(word) > 2 else word
    prefix = next((x for x in _SIUNITX if plain.startswith(x) and plain not in _SYNONYMS), "")
    name = _SYNONYMS.get(plain.removeprefix(prefix), "")
    return _SIUNITX.get(prefix, "") + name if name else word
