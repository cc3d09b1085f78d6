"""Units as people write them behind numbers: N m, Nmm, kg·m², °/s, rpm, in LaTeX too, and those of
siunitx."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

from freebody.derivations.check.numbers.units import Unit, unit_text

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
_TOGETHER = re.compile(r"((?:[kmcM]?N)|kg)((?:mm|cm|m)?)((?:/?s|/?rad)?)")
_WORD = re.compile(r"\\?[A-Za-zµμ]+[23]?(?![A-Za-z0-9_'₀-ₜ\u0300-\u036f])|°")
_POWER = re.compile(
    r"(?:\s?\^\s?|(?=[23]))(?:\{\s?([-−]?\d)\s?\}|([-−]?\d))|([⁻]?[²³¹])|\s?\\(squared|cubed)"
)
_RAISED = {"²": 2, "³": 3, "¹": 1, "⁻¹": -1, "⁻²": -2, "⁻³": -3, "squared": 2, "cubed": 3}
_BLANK = re.compile(r"(?:[\s~$]|\\[,;:! ])*")
_TIMES = re.compile(r"[*·⋅.×∙]|-(?=[A-Za-z])|\\(?:cdot|times)(?![A-Za-z])")
_PER = re.compile(r"/|\\per(?![A-Za-z])|per\s")
_OPEN = re.compile(r"\\(?:mathrm|text|textrm|mbox|mathsf|si|unit|rm)\s?\{|[{\[(]")
_CLOSING = {"{": "}", "[": "]", "(": ")"}


@dataclass(frozen=True)
class WrittenUnit:
    """A unit, as it reads best, with its factor to SI units."""

    text: str
    factor: float
    dimension: Unit
    words: tuple[str, ...] = ()
    """What it is made of, as it is written."""


def common_units(dimension: Unit) -> list[WrittenUnit]:
    """Units in which such a quantity may be given by mistake."""
    names = {
        (1, 2, -2): ("N m", "N mm", "N cm", "kN m", "mN m"), (1, 1, -2): ("N", "kN", "mN"),
        (0, 1, 0): ("m", "mm", "cm"), (0, 0, 0): ("rad", "°"), (1, 0, 0): ("kg", "g"),
        (0, 0, -1): ("rad/s", "°/s", "rpm"), (0, 0, -2): ("rad/s²", "°/s²"),
        (0, 1, -1): ("m/s", "mm/s"), (0, 1, -2): ("m/s²", "mm/s²"), (1, 2, -3): ("W", "kW", "mW"),
        (1, 2, 0): ("kg m²", "kg mm²", "g mm²", "kg cm²"),
    }  # fmt: skip
    return [found[0] for name in names.get(dimension, ()) if (found := unit_at(name, 0))]


def si_text(dimension: Unit, angular: bool = False) -> str:
    """The SI unit: N m, rad/s, kg m²."""
    for unit in common_units(dimension)[:1]:
        if "rad" not in unit.text or angular:
            return unit.text
    return unit_text(dimension)


def unit_at(text: str, at: int) -> tuple[WrittenUnit, int] | None:
    """The unit that is written from there on, and where it ends; None where there is none."""
    reader = _UnitReader(text, at)
    return reader.read()


class _UnitReader:
    """Reads factors until something else comes; brackets must close."""

    def __init__(self, text: str, at: int):
        self.text, self.at = text, at
        self.closing: list[str] = []
        self.signs = [1]
        self.factor, self.dimension = 1.0, (0, 0, 0)
        self.shown: list[tuple[str, int]] = []
        self.words: list[str] = []
        self.last: int | None = None
        """Behind the last factor with all brackets closed."""

    def read(self) -> tuple[WrittenUnit, int] | None:
        while self._step():
            if not self.closing and self.shown:
                self.last = self.at
        if self.last is None:
            return None
        return WrittenUnit(self._shown(), self.factor, self.dimension, tuple(self.words)), self.last

    def _step(self) -> bool:
        """Read a factor with what stands before it; whether there was one."""
        at, sign = self._match(_BLANK), 1
        if self.closing and self.text[at : at + 1] == self.closing[-1]:
            self.closing.pop()
            self.signs.pop()
            self.at = at + 1
            return True
        if self.shown and (times := _TIMES.match(self.text, at)):
            at = self._match(_BLANK, times.end())
        elif per := _PER.match(self.text, at):
            at, sign = self._match(_BLANK, per.end()), -1
        opened = _OPEN.match(self.text, at)
        if opened and (opened[0][-1] != "(" or sign < 0 or not self.shown):
            self.closing.append(_CLOSING[opened[0][-1]])
            self.signs.append(self.signs[-1] * sign)
            self.at = opened.end()
            return True
        return self._word(at, self.signs[-1] * sign)

    def _match(self, pattern: re.Pattern[str], at: int | None = None) -> int:
        match = pattern.match(self.text, self.at if at is None else at)
        return match.end() if match else self.at

    def _word(self, at: int, sign: int) -> bool:
        match = _WORD.match(self.text, at)
        if match is None:
            return False
        word, end = match[0].lstrip("\\"), match.end()
        if word[-1].isdigit():  # kg m2, kgm2
            word, end = word[:-1], end - 1
            if not self.shown and len(self._parts(word)) < 2:
                return False
        if word in _SIUNITX and (following := _WORD.match(self.text, end)):
            word = _SIUNITX[word] + _named(following[0].lstrip("\\"))
            end = following.end()
        parts = self._parts(_named(word))
        if not parts:
            return False
        power = _POWER.match(self.text, end)
        exponent = 1
        if power:
            digits = power[1] or power[2] or ""
            exponent = int(digits.replace("−", "-")) if digits else _RAISED[power[3] or power[4]]
            end = power.end()
        for k, part in enumerate(parts):
            self._take(part, sign * (exponent if k == len(parts) - 1 else 1))
        self.words.append(match[0])
        self.at = end
        return True

    def _parts(self, word: str) -> list[str]:
        """The units of a word: Nm is N and m."""
        if word in _KNOWN:
            return [word]
        match = _TOGETHER.fullmatch(word)
        return [part for part in match.groups() if part] if match else []

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


def _named(word: str) -> str:
    """The symbol of a unit that is spelt out, Newtons, millimetres."""
    plain = word.lower().removesuffix("s") if len(word) > 2 else word
    prefix = next((x for x in _SIUNITX if plain.startswith(x) and plain not in _SYNONYMS), "")
    name = _SYNONYMS.get(plain.removeprefix(prefix), "")
    return _SIUNITX.get(prefix, "") + name if name else word
