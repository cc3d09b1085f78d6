"""Singular poses in answers, "singular at θ2 = 0 or π", checked by det J (2.23)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction

from freebody.expressions.grammar import words
from freebody.expressions.grammar.lexemes import Lexemes
from freebody.expressions.grammar.parser import PI
from freebody.expressions.grammar.patterns import LexemePattern, Match
from freebody.expressions.grammar.source import Span
from freebody.expressions.quantities import kinds
from freebody.scalars.rational import rational_sin_cos
from freebody.scalars.trig import Trig
from freebody_textbook.check.algebra.quotients import Named, Value, put
from freebody_textbook.check.asked.asked_quantities import Targets
from freebody_textbook.check.asked.quantity import AskedQuantity
from freebody_textbook.check.documents.answer_document import AnswerDocument, Blanks
from freebody_textbook.check.reading.claim import Claim
from freebody_textbook.check.reading.vocabulary import Vocabulary
from freebody_textbook.check.spelling.answer_text import AnswerText
from freebody_textbook.check.verdict import EquationVerdict

MOST_POSES = 100
_POSE = LexemePattern(
    "< %fresh function:< \\sin | \\cos | sin | cos > (? | other:< %operating | tan | cot > (? >?"
    " %fresh @angle )? = @pose_values"
)
"""A pose among words; an angle that is part of a formula is none."""
_MORE = LexemePattern("sign:< %minus | + > @angle")
_LISTED = LexemePattern(
    "%first < & | [ | ] >* function:< \\sin | \\cos | sin | cos >? first:%minus? @angle"
    " more:< < < %minus | + > @other_angle >{0,5} > = @pose_values < & | . | , | ] >* %last"
)
"""A line with a pose and nothing else, also of a sum of angles."""
_DETERMINANT = LexemePattern("%fresh name:< d ~e ~t < ~J ~%chain_letter? | ~A | ~B > > %ends")
_DENIED = LexemePattern(
    "< not | Not | n ~%prime ~t | non -? | Non -? | never | Never >"
    " < %letter ~%letter{0,20} >{0,2} %last"
)
_SINGULAR = LexemePattern(
    "< singular | Singular | singularity | Singularity | singularities | Singularities >"
    " !< unless | except >"
)
_VALUE = LexemePattern("@pose_value")


def taken_from(
    document: AnswerDocument, vocabulary: Vocabulary, targets: Targets
) -> tuple[AnswerDocument, list[Claim]]:
    """A document with its statements about singular poses removed, and these statements."""
    text = document.said or document.formulas
    if "det" not in text and "ingular" not in text:
        return document, []
    source = AnswerText(text, document.written, document.parts)
    formulas, said, claims = Blanks(document.formulas), Blanks(document.said), list[Claim]()
    for pose, det in _poses(source, targets):
        found = list(_claims(pose, source, vocabulary, targets, det))
        claims += found
        if len(claims) > MOST_POSES:
            source.fail(f"at most {MOST_POSES} singular poses are read", pose.span)
        for blanks in (formulas, said) if found and document.said else [formulas] * bool(found):
            blanks.put(*pose.span)
    if not claims:
        return document, []
    return replace(document, formulas=str(formulas), said=str(said)), claims


def _poses(source: AnswerText, targets: Targets) -> Iterator[tuple[Match, AskedQuantity]]:
    """Poses that a sentence calls singular, or that stand alone below a determinant; each with the
    determinant that must vanish."""
    lexemes = source.lexemes
    if (of_tip := targets.single.get("detJ")) is not None:
        yield from ((pose, of_tip) for pose in _told(lexemes))
    above: AskedQuantity | None = None
    start = 0
    for end in [*lexemes.places.get("%line", ()), len(lexemes)]:
        if det := next(_DETERMINANT.all(lexemes, start, end), None):
            above = targets.single.get(det["name"])
        elif above is not None and (pose := _LISTED.at(lexemes, start, end)):
            yield pose, above
        elif end > start:
            above = None
        start = end + 1


def _told(lexemes: Lexemes) -> Iterator[Match]:
    """Poses that follow the word singular in a sentence which does not deny it."""
    end = 0
    for word in _SINGULAR.all(lexemes):
        begun = lexemes.at(lexemes[word.start].start - 40)
        denied = any(_DENIED.at(lexemes, k, word.start) for k in range(begun, word.start))
        if word.start < end or denied:
            continue
        end = _end_of_sentence(lexemes, word.stop)
        yield from (x for x in _POSE.all(lexemes, word.stop, end) if "other" not in x)


def _end_of_sentence(lexemes: Lexemes, k: int) -> int:
    """The lexeme at which a sentence or line ends; decimal points do not end one."""
    for j in range(k, len(lexemes)):
        behind = lexemes[j + 1 : j + 2]
        is_stop = lexemes[j].text == "." and not (behind and behind[0].kind == "digit")
        if is_stop or lexemes[j].kind == "line":
            return j
    return len(lexemes)


def _claims(
    pose: Match,
    source: AnswerText,
    vocabulary: Vocabulary,
    targets: Targets,
    determinant: AskedQuantity,
) -> Iterator[Claim]:
    """A claim for each value of a singular pose."""
    setting, det = targets.setting, determinant.polynomial()
    more = list(_MORE.all(pose.lexemes, *pose.captures.get("more", (0, 0))))
    places = [pose.captures["name"][0], *(x.captures["name"][0] for x in more)]
    names = [_coordinate(source, at, vocabulary, targets) for at in places]
    signs = [-1 if x in ("-", "−") else 1 for x in (pose["first"], *(x["sign"] for x in more))]
    ring = setting.ring
    others = [ring[x] * sign for x, sign in zip(names[1:], signs[1:], strict=True)]
    rest = sum(others, setting.zero)
    begin = pose.lexemes[pose.captures["values"][0]].start
    for value, span in _values(pose):
        at = (value * signs[0], rest * -signs[0])
        function = pose["function"].removeprefix("\\")
        there = put(det, _images(at, names[0], function, ring.angles))
        written = source[pose.span[0], begin].strip()
        label = f"singular at {written} {source[span].strip()}".replace("$", "")
        target = AskedQuantity(
            kinds.SINGULAR, (), lambda: setting.zero, words="where det J must be 0",
            note=f"det J = {setting.form(det)}.",
        )  # fmt: skip
        node = Named("", there, span=span)
        yield Claim(label, target, node, there, source)


def _coordinate(source: AnswerText, at: int, vocabulary: Vocabulary, targets: Targets) -> str:
    """The coordinate whose name begins at a lexeme."""
    spelt = words.spell(source, at)
    symbol = vocabulary.symbols.get(spelt.plain)
    for name in targets.setting.symbols.coordinates:
        if symbol == targets.setting.ring[name]:
            return name
    source.fail("this is no coordinate of the robot", (spelt.start, spelt.end))


def _values(pose: Match) -> Iterator[tuple[Fraction, Span]]:
    """Values of a pose with their places; ± gives two values."""
    for match in _VALUE.all(pose.lexemes, *pose.captures["values"]):
        value = Fraction(match["number"] or match["above"] or 1)
        value = value * PI if "pi" in match or "below" in match else value
        value = value / int(match["parts"] or match["below"] or 1)
        value = value * PI / 180 if "degrees" in match else value
        for sign in {"-": (-1,), "−": (-1,), "±": (1, -1)}.get(match["sign"], (1,)):
            yield value * sign, match.span


def _images(
    at: tuple[Fraction, Trig], name: str, function: str | None, angles: tuple[str, ...]
) -> dict[str, Value]:
    """Values of generators when a coordinate, or its sine or cosine, equals a number plus other
    angles."""
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
    """The verdict on a singular pose: whether det J vanishes there."""
    right, note = claim.value.is_zero, claim.target.note
    causes = () if right else (f"There det J is not 0: {note}",)
    return EquationVerdict(
        claim.label, claim.target.title, right, (), causes, note=note if right else ""
    )
