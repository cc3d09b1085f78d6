"""Formulas that have another spelling here, at most as long: M(q) is M, \\frac{d\\theta}{dt} a dot.

Blanks are counted up to a few, so that a text of nothing but blanks takes no time.
"""

from __future__ import annotations

import re
from collections.abc import Callable

from freebody.derivations.expressions.printed_names import GREEK
from freebody.derivations.grammar.words import DETERMINANT, FRAMES

TRANSPOSED = "ᵀ"
FILL = "\x1f"
"""A blank behind what is shorter here than it was written."""

_S = r"\s{0,9}"
_STATE = (
    rf"(?:\\(?:d?dot|boldsymbol|mathbf){_S}\{{?{_S})*(?:\\(?:var)?[Tt]heta|[qQΘθϑ])"
    rf"(?:[\u0307\u0308]|_?d?dot|_?dd?)?{_S}\}}{{0,2}}"
)
_ARGUMENTS = re.compile(
    rf"(?<![\w\\])((?:\\mathcal{_S}\{{{_S}[A-Za-z]{_S}\}}|[A-Za-z]|\\?(?:tau|phi|Gamma|Lambda)|[τΛ])"
    rf"(?:_(?:\{{[^{{}}]{{1,6}}\}}|\w)|[1-9]{{1,2}})?{_S}(?:⁻¹|\^\{{-1\}}|\^-1)?ᵀ?{_S})"
    rf"(\({_S}(?:t|{_STATE})(?:{_S},{_S}{_STATE})*{_S}\))"
)
"""A quantity and what it depends on: M(q), C(q, q̇)."""
_DETERMINANT = re.compile(
    rf"(?<![\w\\])(?:\\?det(?:\s{{1,9}}|{_S}\({_S})"
    rf"(?P<matrix>J(?:_P|_\{{P\}}|_\{{?[abxq]\}}?)?|[ABMHD]){_S}\)?|(?P<bars>\|{_S}J{_S}\|))"
    rf"(?={_S}&?{_S}(?:=|$))",
    re.MULTILINE,
)
_NAME = (
    rf"(?P<name>(?:\\(?:mathbf|mathrm|boldsymbol|vec)\{{\\?[A-Za-z]{{1,8}}\}}"
    rf"|\\(?:var)?(?:{'|'.join(GREEK)})(?![A-Za-z])|[A-Za-zΑ-ω]){_S}"
    rf"(?:_{_S}(?:\{{[^{{}}]{{1,20}}\}}|\w)|[0-9₀-₉]{{1,2}})?)"
)
_BRACED = re.compile(
    rf"(?<![A-Za-z_^}}])\{{{_S}(\\[A-Za-z]+(?:\{{[^{{}}]{{1,20}}\}}|\\[A-Za-z]+)?|[A-Za-zΑ-ω]){_S}\}}"
    rf"{_S}(_{_S}(?:\{{[^{{}}]{{1,20}}\}}|\w))"
)
"""{\\theta}_2, {\\dot{\\theta}}_{2}."""
_DIGIT = rf"(?:\{{{_S}\d{_S}\}}|\d)"
_FRAMED = re.compile(
    rf"(?:(?P<begin>(?:^|[=(,&+-]){_S})|(?:(?<![\w)\]}}'])|(?<=R))\{{{_S}\}}{_S})"
    rf"(?:\^{_S}(?P<frame>{_DIGIT})|(?P<high>[⁰¹²³⁴-⁹]))(?:{_S}_{_S}(?P<low>{_DIGIT}))?{_S}"
    rf"(?P<name>(?!\\(?:sin|cos|tan|[td]?frac|left|cdot|times|sqrt|[bB]ig))"
    rf"(?:\\(?:d?dot|hat|vec|math(?:bf|rm)|boldsymbol|bm){_S}"
    rf"(?:\{{[^{{}}]{{1,30}}\}}|\\[A-Za-z]+|[A-Za-z])|\\[A-Za-z]+|[A-Za-zΑ-ω])[\u0307\u0308]?)"
    rf"(?P<index>{_S}_{_S}(?:\{{(?:[^{{}}]|\{{[^{{}}]{{0,9}}\}}){{1,20}}\}}|\w)|[₀-₉]+)?",
    re.MULTILINE,
)
"""{}^1v_2, {}^2_1R."""
_D = rf"(?:\\mathrm{_S}\{{{_S}d{_S}\}}|\\mathrm\s{{1,9}}d|d){_S}"
_TWICE = rf"{_S}(?:\^{_S}(?:\{{{_S}2{_S}\}}|2)|²){_S}"
_FRACTION = r"\\[td]?frac"
_BY_TIME = rf"\{{{_S}{_D}t(?:{_TWICE})?{_S}\}}"
_RATE = re.compile(rf"{_FRACTION}{_S}\{{{_S}{_D}(?P<twice>{_TWICE})?{_NAME}{_S}\}}{_S}{_BY_TIME}")
"""\\frac{d^2 \\theta_1}{dt^2}."""
_RATE_OF = re.compile(
    rf"{_FRACTION}{_S}\{{{_S}{_D}(?P<twice>{_TWICE})?{_S}\}}{_S}{_BY_TIME}{_S}{_NAME}"
    r"(?![A-Za-z_{^])"
)
"""\\frac{d}{dt} \\theta_1, as SymPy has it."""
_PLAIN_RATE = re.compile(
    r"(?<![\w\\])d(?P<twice>\^2|²|2(?=[^\W\d]))?\s?(?P<name>[^\W\d_]{1,7}_?[0-9₀-₉P]{0,2})\s?/\s?"
    r"dt(?:\^?2|²)?(?!\w)"
)
"""dθ1/dt, d²θ1/dt²."""
_LETTERS = r"[A-Za-zΑ-ω0-9₀-₉_\\^{}\s\u0307\u0308.]"
_PARTIAL = re.compile(
    rf"{_FRACTION}{_S}\{{{_S}\\partial{_S}(?P<of>{_LETTERS}{{0,30}}?){_S}\}}{_S}"
    rf"\{{{_S}\\partial{_S}(?P<by>(?:[^{{}}]|\{{[^{{}}]{{1,20}}\}}){{1,40}}?){_S}\}}"
)
"""\\frac{\\partial L}{\\partial \\dot{\\theta}_1}."""
_BY_TIME_OF = re.compile(
    rf"{_FRACTION}{_S}\{{{_S}{_D}\}}{_S}\{{{_S}{_D}t{_S}\}}|(?<![\w\\])d\s?/\s?dt(?!\w)"
)
"""\\frac{d}{dt} of what follows."""
_TWICE_BY_TIME_OF = re.compile(rf"{_FRACTION}{_S}\{{{_S}{_D}{_TWICE}\}}{_S}{_BY_TIME}")
"""\\frac{d^2}{dt^2} of what follows."""
_SLOPE = re.compile(r"(?<![\w\\])d(?P<of>[LTVK])\s?/\s?d(?!t(?!\w))(?=[^\W\d_])")
"""dL/dθ1, as one types ∂L/∂θ1."""
_BARS = r"(?:\\?\||‖|\\[lr]?[vV]ert(?![A-Za-z]))"
_SQUARED_LENGTH = re.compile(
    rf"{_BARS}{_S}([^|‖=\n\\]{{1,12}}?){_S}{_BARS}(?={_S}(?:²|\^{_S}\{{?{_S}2))"
)
"""|v_c2|²."""
_CROSS = re.compile(
    r"(?<=\))[^\S\n]+x[^\S\n]+(?=\()"
    r"|(?P<of>(?:omega|alpha|[ωα])_?\{?[\d₀-₉]?\}?)[^\S\n]+x[^\S\n]+(?=[A-Za-z(])"
)
"""ω2 x r2, as one types it."""
_OF_TIME = re.compile(rf"((?<=[\w}}])){_S}\{{{_S}\\left{_S}\({_S}t{_S}\\right{_S}\){_S}\}}")
"""The argument of a function of time, as SymPy sets it in LaTeX."""

_TRANSPOSE = re.compile(
    rf"\^{_S}(?:T(?!\w)|\\(?:top|intercal)(?![A-Za-z])|\{{{_S}(?:T|\\top|\\intercal|\\math(?:rm|sf|bf)"
    rf"{_S}\{{T\}}){_S}\}})"
)
"""J^T."""
_EITHER = re.compile(
    rf"(?:±|\\pm(?![A-Za-z]))(?={_S}\\?(?:operatorname\{{|mathrm\{{)?"
    r"(?:sqrt|a(?:rc)?(?:cos|sin|tan)|(?:cos|sin|tan)\^))"
)
"""± in front of a function of two values: each is looked at."""
_INVERSE_TRANSPOSE = re.compile(rf"\^{_S}\{{{_S}[-−]{_S}(?:T|\\top|1{_S}\\top|1{_S}T){_S}\}}")
"""J^{-T}."""
_DETACHED = re.compile(
    r"(?:\((?P<inside>[^\W\d_]_?\d?)\s?\)|(?P<letter>(?<![\w\\])[^\W\d_]))\s"
    r"(?P<dots>[\u0307\u0308])(?P<below>(?:_\{?)?\d{1,2}\}?)?"
)
"""θ ̈_1 and (θ_1 ) ̈, as Word writes θ̈_1 on one line."""
_WORD_BRACKETS = re.compile(r"〖([^〖〗]{1,200})〗")
_DEGREES = re.compile(rf"\^{_S}(?:\{{{_S}\\circ{_S}\}}|\\circ(?![A-Za-z]))|\\degree(?![A-Za-z])")
_SIUNITX = re.compile(
    r"\\(?:SI|qty)\s?\{([^{}]{1,30})\}\s?\{([^{}]{1,60})\}|\\ang\s?\{([^{}]{1,30})\}"
)
_POWER_OF_TEN = re.compile(
    rf"(?<=[0-9.]){_S}(?:[·*×⋅]|\\cdot|\\times){_S}10{_S}"
    rf"(?:\^{_S}(?:\{{{_S}([-−]?\d{{1,2}}){_S}\}}|([-−]?\d{{1,2}}))|(⁻?[⁰¹²³⁴-⁹]{{1,2}}))(?![\w.])"
)
_LOWERED = str.maketrans("⁻−⁰¹²³⁴⁵⁶⁷⁸⁹", "--0123456789")
_EMPTY = re.compile(r"\{\s{0,9}\}")
_ENTRY = re.compile(
    r"(?<![\w\\}])(?P<name>\\?[A-Za-z]+|[Α-ω])(?:"
    r"\[\s?([1-9])\s?(?:,\s?([1-9])\s?)?\]|\(([1-9])\s?,\s?([1-9])\)|_([1-9]),([1-9])(?=\s?=))"
)
"""H[1,2], tau[1], M(1,2), M_1,2, counted from 1."""
_ASTERISK = rf"\^{_S}\{{?{_S}(?:\*|\\(?:ast|star)(?![A-Za-z])){_S}\}}?"
_INERTIA_FORCE = re.compile(
    rf"(?<![\w\\])(?:(?P<name>F{_S}_?{_S}(?:\{{[1-9]\}}|[1-9₁-₉]))"
    rf"(?:{_ASTERISK}|\*(?=\s*(?:[=+\n]|[-−]\s|$)))|F{_ASTERISK}_\{{?(?P<number>[1-9])\}}?)"
)
"""Kane's F_1*, F₁*, F^*_1: a number follows where * multiplies."""


def respelt(text: str) -> str:
    """A text with each formula that has another spelling here in that, filled up."""
    for pattern, rule in _SPELLINGS:
        text = pattern.sub(lambda match, rule=rule: rule(match).ljust(len(match[0]), FILL), text)
    return text


def _alone(match: re.Match[str]) -> str:
    """A quantity without its arguments. A small letter behind another factor, as in m g(q), may be
    a factor too, unless an equals sign or the end of the line follows, or a comma says it."""
    before = match.string[max(0, match.start() - 40) : match.start()].rstrip(" &")[-1:]
    behind = match.string[match.end() : match.end() + 40].lstrip(" &")[:1]
    letter = match[1].removeprefix("\\mathcal{")[0]
    single = letter in "MHDBCVGJNKAY\\τΛ" or "," in match[2]
    alone = before in ("", "\n", *"=+-−([{,;") or behind in ("=", "\n", "")
    if not (single or alone):
        return match[0]
    return match[1].ljust(len(match[0]))  # a label goes without them


def _framed(match: re.Match[str]) -> str:
    """A name with the mark of its frame behind it; R_{21} of {}^2_1R."""
    frame = (match["frame"] or match["high"].translate(_LOWERED)).strip("{ }")
    begin, name = match["begin"] or "", match["name"]
    if match["low"] and name == "R" and not match["index"]:
        return f"{begin}R_{{{frame}{match['low'].strip('{ }')}}}"
    if match["low"]:
        return match[0]
    return f"{begin}{name}{match['index'] or ''}{FRAMES[int(frame)]}"


def _determinant(match: re.Match[str]) -> str:
    """Its name."""
    if match["bars"]:
        return f"J{DETERMINANT}"
    return "det" + re.sub(r"[_{P}]", "", match["matrix"])


def _dotted(match: re.Match[str]) -> str:
    """A derivative by time as a dot above its letter."""
    return f"\\{'d' * (match['twice'] is not None)}dot{{{match['name'].strip()}}}"


def _plain_rate(match: re.Match[str]) -> str:
    """The same of a name in plain letters: dtheta1."""
    return f"{'d' * (1 + (match['twice'] is not None))}{match['name']}"


def _attached(match: re.Match[str]) -> str:
    """A dot on the letter that it belongs to."""
    name = match["letter"] or match["inside"]
    return f"{name[0]}{match['dots']}{name[1:]}{match['below'] or ''}"


def _exponent(match: re.Match[str]) -> str:
    """2.5·10⁻³ as 2.5e-3."""
    return "e" + "".join(filter(None, match.groups())).translate(_LOWERED)


def _in_brackets(match: re.Match[str]) -> str:
    """What Word's brackets hold together; around a function they say nothing."""
    return match[1] if match[1].strip() in ("sin", "cos", "tan") else f"({match[1]})"


_SPELLINGS: tuple[tuple[re.Pattern[str], Callable[[re.Match[str]], str]], ...] = (
    (_EITHER, lambda match: "+"),
    (_SLOPE, lambda match: f"∂{match['of']}/∂"),
    (_SQUARED_LENGTH, lambda match: match[1]),
    (_CROSS, lambda match: f"{match['of'] or ''} × "),
    (_INVERSE_TRANSPOSE, lambda match: f"⁻¹{TRANSPOSED}"),
    (_TRANSPOSE, lambda match: TRANSPOSED),
    (_DETACHED, _attached),
    (_WORD_BRACKETS, _in_brackets),
    (_DEGREES, lambda match: "°"),
    (_SIUNITX, lambda match: f"{match[1]} {match[2]}" if match[1] else f"{match[3]}°"),
    (_POWER_OF_TEN, _exponent),
    (_FRAMED, _framed),
    (_EMPTY, lambda match: ""),
    (_ENTRY, lambda match: match["name"] + "".join(filter(None, match.groups()[1:]))),
    (_OF_TIME, lambda match: match[1]),
    (_BRACED, lambda match: match[1] + match[2]),
    (_RATE, _dotted),
    (_RATE_OF, _dotted),
    (_PLAIN_RATE, _plain_rate),
    (_PARTIAL, lambda match: f"∂{match['of']}/∂{match['by']}"),
    (_TWICE_BY_TIME_OF, lambda match: "∂/∂t ∂/∂t"),
    (_BY_TIME_OF, lambda match: "∂/∂t"),
    (_ARGUMENTS, _alone),
    (_DETERMINANT, _determinant),
    (_INERTIA_FORCE, lambda match: f"{match['name'] or 'F' + match['number']}'"),
)
