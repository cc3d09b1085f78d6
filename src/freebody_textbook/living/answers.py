"""Judging answers typed into an interactive page: grammar tables, names, states of the robot, and
misconceptions."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cache
from itertools import cycle
from operator import mul
from typing import Any

import numpy as np

from freebody.errors import FreebodyError
from freebody.expressions.grammar import patterns
from freebody.expressions.grammar.atoms import atom
from freebody.expressions.grammar.tables import characters
from freebody.expressions.grammar.tables.classes import CLASSES, PATTERNS
from freebody.expressions.grammar.tables.spellings import SPELLINGS
from freebody.expressions.notations.notation import BookNotation
from freebody.expressions.polynomials.symbols import RATE, SECOND
from freebody.lazy import cached_property
from freebody.scalars.generators import function_of, generators_in, symbol_of
from freebody.scalars.trig import Trig
from freebody_textbook.check.algebra.exact_polynomials import LARGEST_EXPONENT
from freebody_textbook.check.algebra.finite_field import RealPoint
from freebody_textbook.check.algebra.quotients import pair
from freebody_textbook.check.asked.quantity import AskedQuantity
from freebody_textbook.check.asked.right_equations import RightEquations, equations_of, in_notation
from freebody_textbook.check.numbers.units_of_symbols import in_other_units
from freebody_textbook.check.numbers.written_units import UNITS
from freebody_textbook.check.reading.vocabulary import GLUED
from freebody_textbook.check.reasons.bodies_at_point import BodiesAtPoint
from freebody_textbook.check.reasons.free_body_beliefs import FreeBodyMotion
from freebody_textbook.check.reasons.misconceptions import TABLES, values
from freebody_textbook.check.reasons.thoughts import Subject
from freebody_textbook.check.states.admissible_states import AdmissibleStates, StateSampler
from freebody_textbook.check.verdicts.equation_verdict import STILL
from freebody_textbook.derivation import Derivation
from freebody_textbook.given_parameters import prepared
from freebody_textbook.living.answer_names import (
    MOST_THOUGHT,
    PageNames,
    QuantityKey,
    is_of_bodies,
    key_of,
    symbols_of,
)
from freebody_textbook.living.page_program import PageProgram
from freebody_textbook.methods import METHODS
from freebody_textbook.relations.formula_values import typical

_STATES, _SETS = 2, 2
"""States with one set of parameters, in each of the units, and sets of parameters."""
_SentenceAndValue = tuple[str, Any]
"""A sentence, and what the right answer would be."""
_MOST_TOLD = [1, *(table.most for table in TABLES)]
"""How many thoughts of each table are told."""
_Thoughts = list[list[list[tuple[int, float]]]]


class PageAnswers:
    """The data with which an interactive page judges answers. readable: quantities in its lines by
    name; defined: quantities that its lines define."""

    def __init__(
        self,
        derivation: Derivation,
        kernel: PageProgram,
        readable: Mapping[str, Any],
        defined: Collection[str],
    ):
        plain = derivation.plain or derivation
        self._at_rest = METHODS[plain.method].at_rest
        self.setting = _equations(plain, derivation.lettering.notation)
        self.names = PageNames(derivation, kernel, readable, defined, self.setting, self._tried)
        self._thought: dict[QuantityKey, _Thoughts] = {}
        self.sentences = [STILL]

    # ------------------------------------------------------------ lines
    def of_line(self, name: str, given: Iterable[str]) -> dict[str, Any]:
        """Data for judging answers to a line: the numbers of its own quantities, those it must not
        use, and the kind of equality."""
        asked = self.names.asked(name)
        found: dict[str, Any] = {"own": self.names.of_line(name, given)}
        if asked and is_of_bodies(asked[0]):
            found["bodies"] = 1
        if asked and asked[0].kind.up_to_a_constant:
            found["level"] = 1
        if asked and asked[0].kind.has_branches:
            found["branches"] = 1
            if any(atom(x).dots for x in generators_in(*pair(asked[0].compute()))):
                found["moves"] = 1
        if asked and asked[0].idle:
            found["idle"] = 1
        if asked and asked[0].kind.is_drive:
            found["torque"] = 1
        return found | ({"thoughts": self._told(asked)} if asked else {})

    def _told(self, asked: Sequence[AskedQuantity]) -> list[int]:
        """Indices of the page's misconception lists that concern a line's entries."""
        for target in asked:
            if key_of(target) not in self._thought:
                self._thought[key_of(target)] = self._thoughts(target)
        keys = [*self._thought]
        return [keys.index(key_of(target)) for target in asked]

    def _thoughts(self, target: AskedQuantity) -> _Thoughts:
        """Misconceptions about one quantity by table and row: the sentence's number, and the value
        of the changed answer at the first state."""
        setting = self.setting
        if setting.turned is not None or len(setting.symbols.coordinates) > MOST_THOUGHT:
            return []
        right = target.compute()
        if not isinstance(right, Trig) or setting.is_free_body:
            return []
        point = RealPoint.of_state(setting.ring, self._signed(self._any[0]))
        told = {_rounded(point.of(right))}
        tables = self._thought_at(target, right, point)
        return [
            self._of_one_table(rows, most, told)
            for rows, most in zip(tables, _MOST_TOLD, strict=True)
        ]

    def _of_one_table(
        self, rows: Iterator[Iterator[_SentenceAndValue]], most: int, told: set[float | None]
    ) -> list[list[tuple[int, float]]]:
        """The misconceptions of one table that can occur as explanations, without those that
        earlier ones always cover. told: values of earlier tables; those of this one are added."""
        here, made = Counter[float](), list[list[tuple[int, float]]]()
        for row in rows:
            said = {x: text for text, full in reversed([*row]) if (x := _rounded(full)) is not None}
            kept = {x: text for x, text in said.items() if x not in told and here[x] < most}
            here.update(kept.keys())
            made.append([(self._sentence(text), x) for x, text in kept.items()])
        told.update(here)
        return list(filter(None, made))

    def _thought_at(
        self, target: AskedQuantity, right: Trig, point: RealPoint
    ) -> Iterator[Iterator[Iterator[_SentenceAndValue]]]:
        """Sentences with the values of wrong answers at a point, by table and row; a first table
        holds the mistake that nothing moves."""
        moving = [name for name in self.setting.ring.names if atom(name).dots]
        still = point.changed(dict.fromkeys(moving, 0)).of(right) or np.nan
        yield iter([iter([(STILL, still)])] if target.kind.may_be_still else [])
        yield from values(
            Subject(BodiesAtPoint(self.setting, point), self.names.targets, target, right)
        )

    def _sentence(self, text: str) -> int:
        if text not in self.sentences:
            self.sentences.append(text)
        return self.sentences.index(text)

    # ------------------------------------------------------------ states
    @cached_property
    def _tried(self) -> list[dict[str, float]]:
        """States for trying answers: an arbitrary one, and where not every state is possible one
        that satisfies loops and equations of motion."""
        found = self._admissible
        held = [] if found is None else [{x: float(v[0]) for x, v in found.values.items()}]
        return [self._signed(row) for row in (self._any[0], *held)]

    def _signed(self, row: Mapping[str, float]) -> dict[str, float]:
        """A state extended by the signs of its rates."""
        signs = [x for x in self.setting.ring.names if function_of(x)]
        return {**row, **{x: float(np.sign(row.get(symbol_of(x), np.nan))) for x in signs}}

    @cached_property
    def _any(self) -> list[dict[str, float]]:
        """Arbitrary states, without conditions; the first ones share their parameter values."""
        chance, names = np.random.default_rng(28), self.setting.symbols.coordinates
        moving = {x + dots for x in names for dots in ("", RATE, SECOND)}
        rows = []
        for _ in range(_SETS):
            held = {x: chance.uniform(0.5, 1.5) for x in symbols_of(self.setting)}
            for _ in range(_STATES):
                own = {
                    x: chance.uniform(-2.0, 2.0) for x in symbols_of(self.setting) if x in moving
                }
                rows.append({x: round(float(v), 3) for x, v in (held | own).items()})
        return rows

    @cached_property
    def _admissible(self) -> AdmissibleStates | None:
        """States with closed loops and correct motion of joints without drives; None if every state
        is possible."""
        if self.setting.is_free_body:
            motion = FreeBodyMotion(self.setting)
            thrusts = [self.setting.ring[x] for x in sorted(motion.thrusts)]
            return StateSampler(self.setting, images=motion.motion(thrusts).images).states()
        if self.setting.system is None and not self.setting.symbols.model.passive:
            return None
        return self._sampler.states()

    @cached_property
    def _sampler(self) -> StateSampler:
        return StateSampler(self.setting, still=self._at_rest)

    def _states(self, names: Sequence[str], values: Mapping[str, float]) -> list[list[float]]:
        """A row for each state: the number of its parameter set (-1 if it is arbitrary while others
        must be possible), the scale of energy in its units, and its values. The last states of a
        set use other units."""
        held = [*self._sampler.loops[0], *self._sampler.passive]
        units = [(1.0, [1.0] * len(names))] * _STATES
        potential = self.names.targets.single.get("V")
        energy = potential.polynomial() if potential else self.setting.zero
        units += in_other_units(self.setting, names, held, energy)
        rows = list[list[float]]()
        for k, some in self._sets():
            for row, (energy, sizes) in zip(cycle(some), units, strict=False):
                numbers = (row.get(x, values.get(x, 0.0)) for x in names)
                rows.append([k, energy, *map(mul, numbers, sizes)])
        return rows

    def _own_state(self, names: Sequence[str], values: Mapping[str, float]) -> dict[str, Any]:
        """A state with the robot's own parameter values, for answers in numbers, and which symbols
        these are, except gravity; {} if there are none."""
        model, gravity = self.setting.symbols.model, self.setting.order.gravity
        given = {x: float(v) for x, v in model.parameters.items() if v is not None and x in names}
        row = self._any[0] | given
        if self._admissible is not None:
            found = replace(self._sampler, own_values=True).states()
            row = {} if found is None else {x: float(v[0]) for x, v in found.values.items()}
        if not row or self.setting.is_free_body:
            return {}
        numbers = [row.get(x, values.get(x, 0.0)) for x in names]
        return {"values": numbers, "given": [names.index(x) for x in given if x != gravity]}

    def _sets(self) -> Iterator[tuple[int, list[dict[str, float]]]]:
        """Parameter sets by number, each with its states."""
        found = self._admissible
        first = range(0, len(self._any), _STATES)
        for k in first if found is None else first[:1]:
            own = self._any[k : k + _STATES]
            yield (k if found is None else -1), [*own, *map(self._turned_back, own)]
        if found is not None:
            closed = self.setting.system is not None
            for k in np.unique(found.parameters)[:_SETS]:
                own = np.flatnonzero(found.parameters == k)
                own = own[found.branch[own] == found.branch[own].min()] if closed else own
                rows = own[: 2 * _STATES]
                yield int(k), [{x: float(v[i]) for x, v in found.values.items()} for i in rows]

    def _turned_back(self, row: Mapping[str, float]) -> dict[str, float]:
        """A state with its coordinates halved and of opposite sign."""
        names = self.setting.symbols.coordinates
        return {x: -v / 2 if x in names else v for x, v in row.items()}

    # ------------------------------------------------------------ for the script
    def symbols(self, inputs: Sequence[Mapping[str, Any]]) -> list[str]:
        """The symbols with sliders, and others that answers may contain."""
        names = [x["name"] for x in inputs]
        return [*names, *(x for x in symbols_of(self.setting) if x not in names)]

    def page(self, inputs: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
        """The data for the script: grammar tables, words, values of further symbols, states and
        sentences."""
        names = self.symbols(inputs)
        others = names[len(inputs) :]
        model = self.setting.symbols.model
        values = dict.fromkeys(others, 0.0) | typical(others, model.parameters)
        values |= {x["name"]: x["value"] for x in inputs}
        return {
            "grammar": tables(),
            "functions": self.names.vocabulary.functions,
            "words": self.names.words(names),
            "glued": [x for x in self.names.apart if x in GLUED],
            "others": [values[x] for x in others],
            "states": self._states(names, values),
            "own": self._own_state(names, values),
            "sentences": self.sentences,
            "thoughts": list(self._thought.values()),
            "most": _MOST_TOLD,
            "readings": self.names.readings(names),
        }


def _equations(plain: Derivation, notation: BookNotation) -> RightEquations:
    """The correct equations of `fb.check`, for the model as given, or else as derived."""
    symbols = plain.equations.symbols
    try:
        model = prepared(symbols.given or symbols.model, notation.parameters)
        return in_notation(equations_of(model), notation)
    except FreebodyError:
        return in_notation(equations_of(symbols.model), notation)


def _rounded(x: Any) -> float | None:
    """A value rounded to the digits stored in a page; None if it is not a number."""
    return float(f"{float(x):.8g}") if np.isfinite(float(x)) else None


# ---------------------------------------------------------------- the language
_CHARACTERS = (
    "LETTERS", "LETTER_COMMANDS", "FONTS", "ACCENTS", "MARKS", "PRIMES", "STARS", "LOW", "HIGH",
    "OPERATORS", "BRACKETS", "VULGAR_FRACTIONS", "FRACTIONS", "FUNCTION_COMMANDS", "RECIPROCALS",
    "MATRICES", "SILENT_COMMANDS", "SILENT", "SIGNS", "KINDS_OF_SIGNS", "ANY_MARK",
)  # fmt: skip
_MENTIONED = re.compile(r"[%@](?:not_)?(\w+)")
_ASKED = ("@number", "%name", "@at_rest", "@condition")
"""Patterns that the script itself asks for: numbers, names, and what it leaves to `fb.check`."""


@cache
def tables() -> dict[str, Any]:
    """The tables with which a page reads answers: characters and commands, spellings, and the
    pattern classes and parts that these use."""
    spellings = [row[:2] for row in SPELLINGS]
    used = _used([*_ASKED, *(find for find, _ in spellings)])
    return {
        **{name: getattr(characters, name) for name in _CHARACTERS},
        "SPELLINGS": spellings,
        "PATTERNS": {name: x for name, x in PATTERNS.items() if name in used},
        "CLASSES": {name: _shorter(x) for name, x in CLASSES.items() if name in used},
        "ITEM": patterns.ITEM.pattern.replace("?P<", "?<"),
        "LARGEST_EXPONENT": LARGEST_EXPONENT,
        "UNITS": UNITS,
    }


def _shorter(texts: tuple[str, ...]) -> str | tuple[str, ...]:
    """Strings joined to one if all are single characters."""
    return "".join(texts) if all(len(x) == 1 for x in texts) else texts


def _used(texts: Iterable[str]) -> set[str]:
    """Names of classes and patterns used in patterns, directly or indirectly."""
    found: set[str] = set()
    waiting = [name for text in texts for name in _MENTIONED.findall(text)]
    while waiting:
        name = waiting.pop()
        if name not in found:
            found.add(name)
            parts = [PATTERNS.get(name, ""), *(x for x in CLASSES.get(name, ()) if x[0] == "%")]
            waiting += [x for part in parts for x in _MENTIONED.findall(part)]
    return found
