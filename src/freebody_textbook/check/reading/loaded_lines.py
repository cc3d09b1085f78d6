"""Which lines of an answer have a force at the tip, and what else they are about."""

from __future__ import annotations

from collections.abc import Iterable

from freebody.expressions.grammar.atoms import atom
from freebody.scalars.generators import generators_in
from freebody.scalars.trig import Trig
from freebody_textbook.check.asked.asked_quantities import Targets
from freebody_textbook.check.reading.answer_lines import AnswerLine
from freebody_textbook.check.reading.vocabulary import Vocabulary


def loads(lines: Iterable[AnswerLine], vocabulary: Vocabulary, targets: Targets) -> frozenset[str]:
    """The components of a force or moment at the tip that lines have."""
    names = {name for line in lines for name in _names(line)}
    return frozenset(x for name in names for x in _of_name(name, vocabulary, targets)[1])


def told(line: AnswerLine, vocabulary: Vocabulary, targets: Targets) -> frozenset[str]:
    """What a line's quantities tell of: "rate", "motion" and "weight"."""
    inside = [token for side in line for token in side if token.kind == "name"]
    varied = [x.text for x in inside if x.start in vocabulary.variations]
    others = [x.text for x in inside if x.start not in vocabulary.variations]
    found = {x for name in others for x in _of_name(name, vocabulary, targets)[0]}
    return frozenset(found | {"weight"} if _weighs(varied, targets) else found)


def _weighs(varied: Iterable[str], targets: Targets) -> bool:
    """Whether the weights do work along virtual displacements, which tell of no motion, as in
    δV."""
    asked = (targets.single[name] for name in varied if name in targets.single)
    terms = (powers for x in asked for powers, _ in x.polynomial().terms())
    return any(targets.setting.order.gravity in powers for powers in terms)


def _of_name(name: str, vocabulary: Vocabulary, targets: Targets) -> tuple[set[str], set[str]]:
    """What a name tells of, and the components of the load that it holds."""
    setting, value = targets.setting, vocabulary.symbols.get(name)
    table = targets.tables.get(name)
    if name in vocabulary.waves:
        return set(), set()
    if isinstance(value, Trig):
        used = generators_in(value)
        dots = {atom(x).dots for x in used}
        found = {what for what, dot in (("rate", 1), ("motion", 2)) if dot in dots}
        found |= {"weight"} if setting.order.gravity in used else set()
        return found, used & set(setting.loads)
    if name in targets.single:
        return {targets.single[name].kind.tells}, set()
    if table is None:
        return set(), set()
    kind = table[0][0].kind
    return {kind.tells}, set(setting.loads[: len(table)]) if kind.is_load else set()


def _names(line: AnswerLine) -> list[str]:
    return [token.text for side in line for token in side if token.kind == "name"]
