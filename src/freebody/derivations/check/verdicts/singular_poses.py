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
    rf"[-−±]?{_S}(?:\d{{1,4}}(?:\.\d{{1,9}})?)?{_S}(?:\\?pi\b|π)?(?:{_S}/{_S}\d{{1,2}})?"
    rf"{_S}(?:\^?\{{?\\circ\}}?|°|deg(?:rees?)?\b)?"
)
_AND = rf"(?:{_S}(?:,|\bor\b|\band\b|\\text\{{{_S}(?:or|and){_S}\}}|\\(?:quad|,|;)){_S}){{1,4}}"
_POSE = re.compile(
    rf"(?:\\?(?P<function>sin|cos){_S}\(?{_S}"
    r"|(?<![\d+*/·−)-])(?<![\d+*/·−)-] )(?<!(?:sin|cos|tan|cot)[ (])(?<!(?:sin|cos|tan|cot)))"
    rf"(?P<name>(?:\\theta|theta|θ|q|d)_?\{{?[0-9₀-₉]\}}?){_S}\)?{_S}={_S}"
    rf"(?P<values>{_NUMBER}(?:{_AND}(?=[-−±\dπ\\]|pi\b)(?!\\theta){_NUMBER})*)"
)
_DENIED = re.compile(r"(?:\bnot|n't|\bnon-?|\bnever)\s{0,9}(?:\w{1,20}\s{1,9}){0,2}$", re.I)
_SENTENCE = re.compile(
    r"singular(?:it(?:y|ies))?\b(?!\s{1,9}(?:unless|except))(?P<told>(?:[^.\n]|\.(?=\d)){0,300})",
    re.I,
)
_VALUE = re.compile(
    r"(?P<sign>[-−±])?[\s$]*(?:(?P<digits>\d+(?:\.\d+)?)|(?P<bare>(?=\\?pi|π)))[\s$]*"
    r"(?P<pi>\\?pi|π)?(?:[\s$]*/[\s$]*(?P<parts>\d+))?[\s$]*(?P<degrees>\^?\{?\\circ|°|deg)?"
)


def taken_from(
    document: AnswerDocument, vocabulary: Vocabulary, targets: Targets
) -> tuple[AnswerDocument, list[Claim]]:
    """A document without what it says of singular poses, and that."""
    text = document.said or document.formulas
    if "detJ" not in targets.single or "ingular" not in text:
        return document, []
    source = AnswerText(text, document.written, document.parts)
    formulas, said, claims = Blanks(document.formulas), Blanks(document.said), list[Claim]()
    for sentence in _SENTENCE.finditer(text):
        if _DENIED.search(text, max(0, sentence.start() - 40), sentence.start()):
            continue
        for pose in _POSE.finditer(text, *sentence.span("told")):
            found = list(_claims(pose, source, vocabulary, targets))
            claims += found
            if len(claims) > MOST_POSES:
                source.fail(f"at most {MOST_POSES} singular poses are read", pose.span())
            for blanks in (formulas, said) if found and document.said else [formulas] * bool(found):
                blanks.put(*pose.span())
    if not claims:
        return document, []
    return replace(document, formulas=str(formulas), said=str(said)), claims


def _claims(
    pose: re.Match[str], source: AnswerText, vocabulary: Vocabulary, targets: Targets
) -> Iterator[Claim]:
    """A claim for each value of a pose."""
    spelt = words.spell(source, pose.start("name"))
    symbol = vocabulary.symbols.get(spelt.plain)
    setting, det = targets.setting, targets.single["detJ"].polynomial()
    names = [x for x in setting.symbols.coordinates if symbol == setting.ring[x]]
    if not names:
        source.fail("this is no coordinate of the robot", pose.span("name"))
    for value, span in _values(pose):
        images = _images(setting.zero, names[0], pose["function"], value, setting.ring.angles)
        there = put(det, images)
        written = source[pose.start(), pose.start("values")].strip()
        label = f"singular at {written} {source[span].strip()}".replace("$", "")
        target = AskedQuantity(
            FAMILY, (), lambda: setting.zero, words="where det J must be 0",
            note=f"det J = {setting.form(det)}.",
        )  # fmt: skip
        node = Named("", there, span=span)
        yield Claim(label, target, node, there, source)


def _values(pose: re.Match[str]) -> Iterator[tuple[Fraction, Span]]:
    """The values and where they stand; ± for both."""
    for match in _VALUE.finditer(pose.string, *pose.span("values")):
        value = Fraction(match["digits"] or 1)
        value = value * PI if match["pi"] else value
        value = value / int(match["parts"] or 1) * (PI / 180 if match["degrees"] else 1)
        for sign in {"-": (-1,), "−": (-1,), "±": (1, -1)}.get(match["sign"] or "", (1,)):
            yield value * sign, match.span()


def _images(
    zero: Trig, name: str, function: str | None, value: Fraction, angles: tuple[str, ...]
) -> dict[str, Value]:
    """What generators are at a value of a coordinate, or of its sine or cosine."""
    if function:
        return {f"{function}_{name}": zero + value}
    if name not in angles:
        return {name: zero + value}
    s, c = rational_sin_cos(float(value))
    return {f"sin_{name}": zero + s, f"cos_{name}": zero + c, name: zero + value}


def verdict(claim: Claim) -> EquationVerdict:
    """Whether det J vanishes there."""
    right, note = claim.value.is_zero, claim.target.note
    causes = () if right else (f"There det J is not 0: {note}",)
    return EquationVerdict(
        claim.label, claim.target.title, right, (), causes, note=note if right else ""
    )
