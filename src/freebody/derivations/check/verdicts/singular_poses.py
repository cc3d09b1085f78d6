"""What an answer says of singular poses, "singular at θ2 = 0 or π", put into det J (2.23)."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction

from freebody.derivations.check.algebra.answer_tree import Named
from freebody.derivations.check.algebra.quotients import Value
from freebody.derivations.check.asked.asked_quantities import Targets
from freebody.derivations.check.asked.quantity import AskedQuantity
from freebody.derivations.check.documents.answer_document import AnswerDocument, Blanks
from freebody.derivations.check.reading.claim import Claim
from freebody.derivations.check.reading.vocabulary import Vocabulary
from freebody.derivations.check.reasons.free_motion import put
from freebody.derivations.check.spelling.answer_text import AnswerText
from freebody.derivations.check.spelling.formula_spellings import respelt
from freebody.derivations.check.verdict import EquationVerdict
from freebody.derivations.grammar import words
from freebody.derivations.grammar.parser import PI
from freebody.derivations.grammar.source import Span
from freebody.scalars.rational import rational_sin_cos
from freebody.scalars.trig import Trig

FAMILY = "singular"
MOST_POSES = 100
_S = r"[\s$]{0,9}"
_NUMBER = (
    rf"[-−±]?{_S}(?:\\[dt]?frac\{{\d{{0,2}}{_S}\\pi{_S}\}}\{{\d{{1,2}}\}}|"
    rf"(?:\d{{1,4}}(?:\.\d{{1,9}})?)?{_S}(?:\\?pi\b|π)?(?:{_S}/{_S}\d{{1,2}})?)"
    rf"{_S}(?:\^?\{{?\\circ\}}?|°|deg(?:rees?)?\b)?"
)
_AND = rf"(?:{_S}(?:,|\bor\b|\band\b|\\text\{{{_S}(?:or|and){_S}\}}|\\(?:quad|,|;)){_S}){{1,4}}"
_POSE = re.compile(
    rf"(?:\\?(?P<function>sin|cos){_S}\(?{_S}"
    r"|(?<![\d+*/·−)-])(?<![\d+*/·−)-] )(?<!(?:sin|cos|tan|cot)[ (])(?<!(?:sin|cos|tan|cot)))"
    rf"(?P<name>(?:\\theta|theta|θ|q|d)_?\{{?[0-9₀-₉]\}}?){_S}\)?{_S}={_S}"
    rf"(?P<values>{_NUMBER}(?:{_AND}(?=[-−±\dπ\\]|pi\b)(?!\\theta){_NUMBER})*)"
)
_ANGLE = r"(?:\\theta|theta|θ|q|d)_?\{?[0-9₀-₉]\}?"
_MORE = re.compile(rf"{_S}(?P<sign>[-−+]){_S}(?P<name>{_ANGLE})")
_LISTED = re.compile(
    rf"[\s$&\[\]\\]*(?P<function>\\?(?:sin|cos)(?=\W))?{_S}(?P<first>[-−])?{_S}(?P<name>{_ANGLE})"
    rf"(?P<more>(?:{_S}[-−+]{_S}{_ANGLE}){{0,5}}){_S}={_S}"
    rf"(?P<values>{_NUMBER}(?:{_AND}(?=[-−±\dπ\\]|pi\b)(?!\\theta){_NUMBER})*)[\s$&.,\]\\]*"
)
"""A line with a pose and nothing else, also of a sum of angles."""
_LINE = re.compile(r"[^\n]+")
_DETERMINANT = re.compile(r"\bdet(?:J[abxq]?|[AB])\b")
_DENIED = re.compile(r"(?:\bnot|n't|\bnon-?|\bnever)\s{0,9}(?:\w{1,20}\s{1,9}){0,2}$", re.I)
_SENTENCE = re.compile(
    r"singular(?:it(?:y|ies))?\b(?!\s{1,9}(?:unless|except))(?P<told>(?:[^.\n]|\.(?=\d)){0,300})",
    re.I,
)
_VALUE = re.compile(
    r"(?P<sign>[-−±])?[\s$]*(?:\\[dt]?frac\{(?P<above>\d*)\s?\\pi\s?\}\{(?P<below>\d+)\}"
    r"|(?:(?P<digits>\d+(?:\.\d+)?)|(?P<bare>(?=\\?pi|π)))[\s$]*(?P<pi>\\?pi|π)?"
    r"(?:[\s$]*/[\s$]*(?P<parts>\d+))?[\s$]*(?P<degrees>\^?\{?\\circ|°|deg)?)"
)


def taken_from(
    document: AnswerDocument, vocabulary: Vocabulary, targets: Targets
) -> tuple[AnswerDocument, list[Claim]]:
    """A document without what it says of singular poses, and that."""
    text = document.said or document.formulas
    if "det" not in text and "ingular" not in text:
        return document, []
    source = AnswerText(text, document.written, document.parts)
    formulas, said, claims = Blanks(document.formulas), Blanks(document.said), list[Claim]()
    for pose, det in _poses(text, targets):
        found = list(_claims(pose, source, vocabulary, targets, det))
        claims += found
        if len(claims) > MOST_POSES:
            source.fail(f"at most {MOST_POSES} singular poses are read", pose.span())
        for blanks in (formulas, said) if found and document.said else [formulas] * bool(found):
            blanks.put(*pose.span())
    if not claims:
        return document, []
    return replace(document, formulas=str(formulas), said=str(said)), claims


def _poses(text: str, targets: Targets) -> Iterator[tuple[re.Match[str], AskedQuantity]]:
    """Poses in sentences that call them singular, and lines of nothing else below a determinant;
    each with the determinant that is to vanish there."""
    of_tip = targets.single.get("detJ")
    for sentence in _SENTENCE.finditer(text):
        if of_tip is not None and not _DENIED.search(
            text, max(0, sentence.start() - 40), sentence.start()
        ):
            for pose in _POSE.finditer(text, *sentence.span("told")):
                yield pose, of_tip
    above: AskedQuantity | None = None
    for line in _LINE.finditer(text):
        if told := _DETERMINANT.search(respelt(line[0])):
            above = targets.single.get(told[0])
        elif above is not None and (pose := _LISTED.fullmatch(text, *line.span())):
            yield pose, above
        elif line[0].strip():
            above = None


def _claims(
    pose: re.Match[str],
    source: AnswerText,
    vocabulary: Vocabulary,
    targets: Targets,
    determinant: AskedQuantity,
) -> Iterator[Claim]:
    """A claim for each value of a pose."""
    setting, det = targets.setting, determinant.polynomial()
    names = [_coordinate(source, at, vocabulary, targets) for at in _places(pose)]
    signs = [-1 if x in "-−" else 1 for x in _signs(pose)]
    ring = setting.ring
    others = [ring[x] * sign for x, sign in zip(names[1:], signs[1:], strict=True)]
    rest = sum(others, setting.zero)
    for value, span in _values(pose):
        at = (value * signs[0], rest * -signs[0])
        there = put(det, _images(at, names[0], pose["function"], ring.angles))
        written = source[pose.start(), pose.start("values")].strip()
        label = f"singular at {written} {source[span].strip()}".replace("$", "")
        target = AskedQuantity(
            FAMILY, (), lambda: setting.zero, words="where det J must be 0",
            note=f"det J = {setting.form(det)}.",
        )  # fmt: skip
        node = Named("", there, span=span)
        yield Claim(label, target, node, there, source)


def _places(pose: re.Match[str]) -> list[int]:
    """Where the names of its angles begin."""
    more = pose.groupdict().get("more") or ""
    return [
        pose.start("name"),
        *(pose.start("more") + x.start("name") for x in _MORE.finditer(more)),
    ]


def _signs(pose: re.Match[str]) -> list[str]:
    """The signs of its angles."""
    found = pose.groupdict()
    return [
        found.get("first") or "+",
        *(x["sign"] for x in _MORE.finditer(found.get("more") or "")),
    ]


def _coordinate(source: AnswerText, at: int, vocabulary: Vocabulary, targets: Targets) -> str:
    """The coordinate whose name stands there."""
    spelt = words.spell(source, at)
    symbol = vocabulary.symbols.get(spelt.plain)
    for name in targets.setting.symbols.coordinates:
        if symbol == targets.setting.ring[name]:
            return name
    source.fail("this is no coordinate of the robot", (spelt.start, spelt.end))


def _values(pose: re.Match[str]) -> Iterator[tuple[Fraction, Span]]:
    """The values and where they stand; ± for both."""
    for match in _VALUE.finditer(pose.string, *pose.span("values")):
        value = Fraction(match["digits"] or match["above"] or 1)
        value = value * PI if match["pi"] or match["below"] else value
        value = value / int(match["parts"] or match["below"] or 1)
        value = value * PI / 180 if match["degrees"] else value
        for sign in {"-": (-1,), "−": (-1,), "±": (1, -1)}.get(match["sign"] or "", (1,)):
            yield value * sign, match.span()


def _images(
    at: tuple[Fraction, Trig], name: str, function: str | None, angles: tuple[str, ...]
) -> dict[str, Value]:
    """What generators are where a coordinate, or its sine or cosine, is the sum of a number and
    other angles."""
    number, rest = at
    if function:
        return {f"{function}_{name}": rest + number}
    if name not in angles:
        return {name: rest + number}
    s, c = rational_sin_cos(float(number))
    sin, cos = (rest, rest + 1) if rest.is_zero else (rest.sin(), rest.cos())
    return {
        f"sin_{name}": cos * s + sin * c, f"cos_{name}": cos * c - sin * s, name: rest + number
    }  # fmt: skip


def verdict(claim: Claim) -> EquationVerdict:
    """Whether det J vanishes there."""
    right, note = claim.value.is_zero, claim.target.note
    causes = () if right else (f"There det J is not 0: {note}",)
    return EquationVerdict(
        claim.label, claim.target.title, right, (), causes, note=note if right else ""
    )
