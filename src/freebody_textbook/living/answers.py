"""What a page judges answers by: the names that `fb.check` reads and what they stand for, states
that the robot can be in, and what a wrong answer may have been thought by."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from itertools import cycle, groupby
from operator import mul
from typing import Any

import numpy as np

from freebody.errors import FreebodyError
from freebody.expressions.expression import Symbol
from freebody.expressions.grammar.atoms import atom
from freebody.expressions.grammar.words import spelt
from freebody.expressions.polynomials.symbols import RATE, SECOND
from freebody.expressions.printed_names import sym
from freebody.lazy import cached_property
from freebody.scalars.generators import function_of, symbol_of
from freebody.scalars.trig import Trig
from freebody_textbook.check.algebra.finite_field import RealPoint
from freebody_textbook.check.asked.asked_quantities import Targets
from freebody_textbook.check.asked.quantity import AskedQuantity, QuantityTable
from freebody_textbook.check.asked.right_equations import RightEquations, equations_of, in_notation
from freebody_textbook.check.claims import own_names
from freebody_textbook.check.numbers.units import in_other_units
from freebody_textbook.check.reading.vocabulary import GLUED, Vocabulary
from freebody_textbook.check.reasons.bodies_at_point import BodiesAtPoint
from freebody_textbook.check.reasons.free_bodies import FreeBodyMotion
from freebody_textbook.check.reasons.misconceptions import TABLES, values
from freebody_textbook.check.reasons.misreadings import GRAVITY, TIPS
from freebody_textbook.check.reasons.thoughts import Subject
from freebody_textbook.check.states.admissible_states import AdmissibleStates, StateSampler
from freebody_textbook.check.verdicts.equation_verdict import STILL
from freebody_textbook.derivation import Derivation
from freebody_textbook.derive import freed
from freebody_textbook.living.kernel import PageProgram
from freebody_textbook.living.language import tables
from freebody_textbook.methods import METHODS
from freebody_textbook.relations.formula_values import rank, typical

MOST_THOUGHT = 4
"""Coordinates up to which thoughts are told: of more the right values are too long."""
_STATES, _SETS = 2, 2
"""States with one set of parameters, in each of the units, and sets of parameters."""

_MOST_ALIKE = 40
"""Names without value that differ by their figures, up to which a page knows them."""

_SentenceAndValue = tuple[str, Any]
"""A sentence, and what the right answer would be."""
_MOST_TOLD = [1, *(table.most for table in TABLES)]
"""How many thoughts of each table are told."""

ValueSum = list[str | int]
"""A sum of symbols by name and of values by place in y; of a function of it the name first, behind
a ~."""
_QuantityKey = tuple[Any, ...]
_Thoughts = list[list[list[tuple[int, float]]]]


class PageAnswers:
    """The language of one page. readable: quantities of its lines by name; defined: those that a
    line of its own defines."""

    def __init__(
        self,
        derivation: Derivation,
        kernel: PageProgram,
        readable: Mapping[str, Any],
        defined: Collection[str],
    ):
        plain = derivation.plain or derivation
        self._kernel, self._notation = kernel, derivation.lettering.notation
        self._at_rest = METHODS[plain.method].at_rest
        self.setting = self._equations(plain)
        self.targets = Targets(self.setting, letters=self._notation.all_letters)
        self.vocabulary = self._vocabulary()
        spellings = {name: plain for name in readable if (plain := spelt(name))}
        self._own: dict[str, Any] = {plain: readable[name] for name, plain in spellings.items()}
        self._called = {
            spelt(derivation.lettering.symbol(x).name): spellings[x.name]
            for x in map(sym, spellings)
            if isinstance(x, Symbol)
        }
        self._strange = self._others(spellings, defined)
        self._numbers: dict[_QuantityKey, int] = {}
        self._asked_for: set[int] = set()
        self._values: dict[_QuantityKey, list[int]] = {}
        for name, x in self._own.items():
            for key, place in zip(self._keys(name, x), kernel.places(x), strict=True):
                self._values.setdefault(key, [place])
        self._meanings = dict(self._all_meanings())
        _ = self._velocity_terms  # their places, before the page's size is known
        self._thought: dict[_QuantityKey, _Thoughts] = {}
        self.sentences = [STILL]

    def _equations(self, plain: Derivation) -> RightEquations:
        """Those of `fb.check`, of the model as it was given, or else of what was derived."""
        symbols = plain.equations.symbols
        try:
            model = freed(symbols.given or symbols.model, self._notation.parameters)
            return in_notation(equations_of(model), self._notation)
        except FreebodyError:
            return in_notation(equations_of(symbols.model), self._notation)

    def _vocabulary(self) -> Vocabulary:
        found = Vocabulary(self.setting, self.targets.names, self.targets.alone)
        for name, value in self.setting.given.items():
            found.define(name, value)
        own_names.of_notation(found, self.targets, self._notation)
        return found

    # ------------------------------------------------------------ names
    def _keys(self, name: str, x: Any) -> list[_QuantityKey]:
        """What a name of the page is to `fb.check`, entry by entry; its own where it is nothing."""
        single, table = self.targets.single.get(name), self.targets.tables.get(name)
        if name in self._strange:
            single = table = None
        if rank(x) == 0 and single is not None:
            return [_key(single)]
        shape = (len(x), len(x[0]) if rank(x) == 2 else 1) if rank(x) else ()
        if table is not None and shape == (len(table), len(table[0])):
            return [_key(entry) for row in table for entry in row]
        size = shape[0] * shape[1] if shape else 1
        return [(name, k) for k in range(size)]

    def _others(self, spellings: Mapping[str, str], defined: Collection[str]) -> set[str]:
        """Names that are something else to `fb.check`, such as k1, the kinetic energy of body 1:
        found out in numbers where its values are short; else what a line defines."""
        strange = {spellings[name] for name in spellings if name in defined}
        if len(self.setting.symbols.coordinates) > MOST_THOUGHT or self.setting.turned is not None:
            return strange
        for name, x in self._own.items():
            single = self.targets.single.get(name)
            right = single.compute() if single is not None and rank(x) == 0 else None
            is_same = right is not None and any(
                np.isclose(RealPoint.of_state(self.setting.ring, row).of(right), value, rtol=1e-9)
                for row, value in zip(self._tried, self._valued(x), strict=True)
            )
            (strange.discard if is_same or right is None else strange.add)(name)
        return strange

    @cached_property
    def _tried(self) -> list[dict[str, float]]:
        """A state of any kind, and one that is admissible."""
        found = self._admissible
        held = [] if found is None else [{x: float(v[0]) for x, v in found.values.items()}]
        return [self._signed(row) for row in (self._any[0], *held)]

    def _valued(self, x: Any) -> list[float]:
        """A value of the page at these states."""
        inputs = self._kernel.inputs
        rows = [{k: v for k, v in row.items() if k in inputs} for row in self._tried]
        return [float(self._kernel.at_random([x], **row)[0, 0]) for row in rows]

    def _all_meanings(self) -> Iterator[tuple[str, dict[str, Any]]]:
        """What each name stands for: "s" a scalar, "t" a vector or matrix, "q" a quantity's number,
        "bodies" whether it is one of bodies."""
        for name in dict.fromkeys((*sorted(self.vocabulary.known), *self._own, *self._called)):
            meaning = self._meaning(name)
            if name not in ("t", "pi"):
                yield name, meaning

    def _meaning(self, name: str) -> dict[str, Any]:
        """What one name stands for."""
        vocabulary, targets = self.vocabulary, self.targets
        meant = vocabulary.aliases.get(name, self._called.get(name, name))
        single, table = targets.single.get(meant), targets.tables.get(meant)
        known = name in vocabulary.symbols or name in vocabulary.waves or single is not None
        found: dict[str, Any] = {"s": self._scalar(name, single)} if known else {}
        if table is not None:
            found["t"] = self._table(_keys_of(table))
        named = table if name not in vocabulary.symbols else None  # g is no vector's name
        keys = [_key(single)] if single is not None else [_key(x) for (x, *_) in named or ()]
        if not keys and meant in self._own:
            keys = self._keys(meant, self._own[meant])
            found = self._of_page(meant, keys) | found
        found = {key: x for key, x in found.items() if x is not None}
        asked = single or (table[0][0] if table else None)
        return found | self._marks(name, asked, keys) if found else {}

    def _marks(
        self, name: str, asked: AskedQuantity | None, keys: list[_QuantityKey]
    ) -> dict[str, int]:
        """A quantity's number, and whether it is one of bodies."""
        found: dict[str, int] = {}
        if any(key in self._values for key in keys):
            found["q"] = self._number(keys[0])
        if asked and name not in self.vocabulary.symbols and _is_of_bodies(asked):
            found["bodies"] = 1
        return found

    def _of_page(self, name: str, keys: list[_QuantityKey]) -> dict[str, Any]:
        """A name of the page's own lines: a scalar, or a column of entries."""
        if rank(self._own[name]) == 0:
            return {"s": self._values[keys[0]]}
        return {"t": self._table([[key] for key in keys])}

    def _scalar(self, name: str, single: AskedQuantity | None) -> ValueSum | list[int] | None:
        """The number that a name stands for: a symbol, a sine or cosine, or a quantity."""
        vocabulary = self.vocabulary
        if name in vocabulary.symbols:
            return self._slots(vocabulary.symbols[name])
        if name in vocabulary.waves:
            function, angle = vocabulary.waves[name]
            return [f"~{function}", *(x for x, _ in angle)]
        return self._values.get(_key(single)) if single is not None else None

    def _table(self, keys: list[list[_QuantityKey]]) -> list[list[list[int]]] | None:
        if any(key not in self._values for row in keys for key in row):
            return None
        return [[self._values[key] for key in row] for row in keys]

    def _number(self, key: _QuantityKey) -> int:
        return self._numbers.setdefault(key, len(self._numbers))

    def _slots(self, value: Any) -> ValueSum | None:
        """A symbol's value as a sum of symbols, or computed by the page; None where that cannot
        be."""
        terms = list(value.terms()) if isinstance(value, Trig) else []
        names = [next(iter(powers)) for powers, c in terms if c == 1 and [*powers.values()] == [1]]
        plain = all(x in self._symbols for x in names)
        if len(names) == len(terms) and plain and isinstance(value, Trig):
            return list(names)
        with suppress(KeyError):  # a symbol that the page does not have
            return list(self._kernel.places(self.setting.layout.form(value)))
        return None

    @cached_property
    def _symbols(self) -> tuple[str, ...]:
        """Names of the ring that states give values to."""
        return tuple(x for x in self.setting.ring.names if not function_of(x))

    # ------------------------------------------------------------ lines
    def of_line(self, name: str, given: Iterable[str]) -> dict[str, Any]:
        """Of the line that gives a quantity: its number, those that an answer may not use, and how
        it is compared."""
        asked = self._asked(name)
        numbers = (self._meanings.get(spelt(x), {}).get("q") for x in (name, *given))
        own = [x for x in dict.fromkeys(numbers) if x is not None]
        self._asked_for.update(own)
        found: dict[str, Any] = {"own": own}
        if asked and _is_of_bodies(asked[0]):
            found["bodies"] = 1
        if asked and asked[0].kind.up_to_a_constant:
            found["level"] = 1
        if asked and asked[0].idle:
            found["idle"] = 1
        if asked and asked[0].kind.is_drive:
            found["torque"] = 1
        return found | ({"thoughts": self._told(asked)} if asked else {})

    def _asked(self, name: str) -> list[AskedQuantity]:
        """What `fb.check` knows by the name of a line, entry by entry."""
        plain = spelt(name)
        x = self._own.get(plain)
        if x is None:
            return []
        single, table = self.targets.single.get(plain), self.targets.tables.get(plain)
        if rank(x) == 0:
            return [single] if single is not None else []
        entries = [entry for row in table or () for entry in row]
        return entries if len(entries) == len(x) else []

    def _told(self, asked: Sequence[AskedQuantity]) -> list[int]:
        """Of each entry which of the page's lists of thoughts is about it."""
        for target in asked:
            if _key(target) not in self._thought:
                self._thought[_key(target)] = self._thoughts(target)
        keys = [*self._thought]
        return [keys.index(_key(target)) for target in asked]

    def _thoughts(self, target: AskedQuantity) -> _Thoughts:
        """By table and row: sentences by number, each with what the right answer would be under it
        at the first state."""
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
        """Those of one table that can be told: not where others before them always are; told:
        values of tables before, and now of this one."""
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
        """By table and row; in a table of its own that nothing moves, where that may be meant."""
        moving = [name for name in self.setting.ring.names if atom(name).dots]
        still = point.changed(dict.fromkeys(moving, 0)).of(right) or np.nan
        yield iter([iter([(STILL, still)])] if target.kind.may_be_still else [])
        yield from values(Subject(BodiesAtPoint(self.setting, point), self.targets, target, right))

    def _signed(self, row: Mapping[str, float]) -> dict[str, float]:
        """A state with the signs of its rates."""
        signs = [x for x in self.setting.ring.names if function_of(x)]
        return {**row, **{x: float(np.sign(row.get(symbol_of(x), np.nan))) for x in signs}}

    def _sentence(self, text: str) -> int:
        if text not in self.sentences:
            self.sentences.append(text)
        return self.sentences.index(text)

    # ------------------------------------------------------------ states
    @cached_property
    def _any(self) -> list[dict[str, float]]:
        """States without conditions; the first have the same parameters."""
        chance, names = np.random.default_rng(28), self.setting.symbols.coordinates
        moving = {x + dots for x in names for dots in ("", RATE, SECOND)}
        rows = []
        for _ in range(_SETS):
            held = {x: chance.uniform(0.5, 1.5) for x in self._symbols}
            for _ in range(_STATES):
                own = {x: chance.uniform(-2.0, 2.0) for x in self._symbols if x in moving}
                rows.append({x: round(float(v), 3) for x, v in (held | own).items()})
        return rows

    @cached_property
    def _admissible(self) -> AdmissibleStates | None:
        """States at which loops are closed and what nothing drives moves by itself; None where any
        state is admissible."""
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

    def _readings(self, names: Sequence[str]) -> list[dict[str, Any]]:
        """What may be read in another way: the numbers or names, and what is said of it; terms: of
        torques and where they are terms of their own."""
        rows = [
            ({"numbers": self._gravity}, f"‘#’ is read as {self.setting.order.gravity}."),
            ({"names": self._slide}, "x is read as the slide's coordinate."),
            ({"names": self._cosines}, "‘#’ is read as a cosine."),
            ({"names": self._velocity_terms, "terms": 1}, "‘#’ is read as the velocity term."),
        ]
        index = _places(names)
        found: list[dict[str, Any]] = []
        for row, note in rows:
            (kind, slots), *more = row.items()
            made = {text: _numbered({"s": x}, index)["s"] for text, x in slots.items()}
            found += [{kind: made, **dict(more), "note": note}] if made else []
        return found

    @property
    def _gravity(self) -> dict[str, ValueSum]:
        """Numbers that are its value."""
        g = self.setting.order.gravity
        value = self.setting.symbols.model.parameters.get(g or "")
        if not g or value is None:
            return {}
        decimals = {x: len(x.partition(".")[2]) for x in GRAVITY if "." in x}
        return {x: [g] for x, count in decimals.items() if round(value, count) == float(x)}

    @property
    def _slide(self) -> dict[str, ValueSum]:
        """x where the only slide is called otherwise."""
        slides = [x for x in self.setting.symbols.coordinates if not self.setting.turns(x)]
        if len(slides) != 1:
            return {}
        single, endings = self.targets.single, ("", RATE, SECOND)
        return {x: [slides[0] + endings[single[x].kind.dots]] for x in sorted(TIPS) if x in single}

    @property
    def _cosines(self) -> dict[str, ValueSum]:
        """C12 where it is a quantity's name."""
        found: dict[str, ValueSum] = {}
        for name in sorted(self.targets.single):
            own = atom(name)
            angle = [f"theta{k}" for k in own.figures]
            if own.letter == "C" and angle and all(x in self.setting.ring.angles for x in angle):
                found[name] = ["~cos", *angle]
        return found

    @cached_property
    def _velocity_terms(self) -> dict[str, ValueSum]:
        """c1 and V1 beside torques."""
        if len(self.setting.symbols.coordinates) > MOST_THOUGHT:
            return {}
        single, found = self.targets.single, dict[str, ValueSum]()
        terms = {x.index[0]: x for x in single.values() if x.kind.is_velocity_term}
        levels = ((name, x) for name, x in single.items() if x.kind.up_to_a_constant)
        names = {name: x.index[0] for name, x in levels if x.index}
        names |= {f"c{k}": k for k in terms if f"c{k}" in self.vocabulary.waves}
        for name in sorted(names):
            target = terms.get(names[name])
            slots = target and (self._values.get(_key(target)) or self._slots(target.compute()))
            if slots:
                found[name] = [*slots]
        return found

    def _states(self, names: Sequence[str], values: Mapping[str, float]) -> list[list[float]]:
        """Of each state the number of its set of parameters, -1 of one that need not be admissible
        where others are; how large an energy is in its units; and its values. The last ones of a
        set are in other units."""
        held = [*self._sampler.loops[0], *self._sampler.passive]
        units = [(1.0, [1.0] * len(names))] * _STATES
        potential = self.targets.single.get("V")
        energy = potential.polynomial() if potential else self.setting.zero
        units += in_other_units(self.setting, names, held, energy)
        rows = list[list[float]]()
        for k, some in self._sets():
            for row, (energy, sizes) in zip(cycle(some), units, strict=False):
                numbers = (row.get(x, values.get(x, 0.0)) for x in names)
                rows.append([k, energy, *map(mul, numbers, sizes)])
        return rows

    def _own_state(self, names: Sequence[str], values: Mapping[str, float]) -> dict[str, Any]:
        """A state with the values of the robot's own parameters, by which answers in numbers are
        told, and which of the symbols these are, gravity apart; nothing where there are none."""
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
        """Sets of parameters by number, each with its states."""
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
        """A state with coordinates of the other sign."""
        names = self.setting.symbols.coordinates
        return {x: -v / 2 if x in names else v for x, v in row.items()}

    # ------------------------------------------------------------ for the script
    def symbols(self, inputs: Sequence[Mapping[str, Any]]) -> list[str]:
        """The symbols with sliders, and others that an answer may be written with."""
        names = [x["name"] for x in inputs]
        return [*names, *(x for x in self._symbols if x not in names)]

    def page(self, inputs: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
        """What the script is given: tables of the grammar, words, values of further symbols, states
        and sentences."""
        names = self.symbols(inputs)
        others = names[len(inputs) :]
        model = self.setting.symbols.model
        values = dict.fromkeys(others, 0.0) | typical(others, model.parameters)
        values |= {x["name"]: x["value"] for x in inputs}
        return {
            "grammar": tables(),
            "functions": self.vocabulary.functions,
            "words": self._words(names),
            "glued": [x for x in self._apart if x in GLUED],
            "others": [values[x] for x in others],
            "states": self._states(names, values),
            "own": self._own_state(names, values),
            "sentences": self.sentences,
            "thoughts": list(self._thought.values()),
            "most": _MOST_TOLD,
            "readings": self._readings(names),
        }

    @cached_property
    def _apart(self) -> list[str]:
        """Names that are no part of a longer word."""
        own = self.vocabulary
        return [x for x in self._meanings if x in own.alone and x not in {*own.symbols, *own.waves}]

    def _words(self, order: Sequence[str]) -> list[tuple[list[str], dict[str, dict[str, Any]]]]:
        """All names, those that differ by their figures together, θ1 and θ12 as theta#: spellings
        that mean the same, and by their figures what they mean; nothing where they have no value
        here; "apart" of names that stand alone."""
        index, apart = _places(order), frozenset(self._apart)
        rows: dict[str, dict[str, dict[str, Any]]] = {}
        for name, meaning in self._meanings.items():
            said = {key: x for key, x in meaning.items() if key != "q" or x in self._asked_for}
            said = _numbered(said, index) | ({"apart": 1} if name in apart else {})
            template, figures = _template(name)
            rows.setdefault(template, {})[figures] = said
        alike: dict[str, tuple[list[str], dict[str, dict[str, Any]]]] = {}
        for template, row in rows.items():
            unvalued = [figures for figures, x in row.items() if not {"s", "t"} & {*x}]
            for figures in unvalued if len(unvalued) > _MOST_ALIKE else ():
                del row[figures]
            alike.setdefault(json.dumps(row), ([], row))[0].append(template)
        return [row for row in alike.values() if row[1]]


def _key(target: AskedQuantity) -> _QuantityKey:
    """A key by which a quantity is told from others."""
    return target.kind, target.index, target.axis, target.words, target.joint


def _keys_of(table: QuantityTable) -> list[list[_QuantityKey]]:
    return [[_key(entry) for entry in row] for row in table]


def _is_of_bodies(target: AskedQuantity) -> bool:
    return target.kind.of == "bodies"


def _places(names: Sequence[str]) -> dict[str, int]:
    """The places of symbols by name, as the script counts them."""
    return {name: -1 - k for k, name in enumerate(names)}


def _numbered(meaning: Mapping[str, Any], index: Mapping[str, int]) -> dict[str, Any]:
    """A meaning with places of symbols for their names."""
    made = dict(meaning)
    if "s" in made:
        made["s"] = [x if isinstance(x, int) else index.get(x, x[1:]) for x in made["s"]]
    return made


def _template(name: str) -> tuple[str, str]:
    """A name with # for each run of figures, and these."""
    runs = [("".join(run), is_figure) for is_figure, run in groupby(name, str.isdigit)]
    template = "".join("#" if is_figure else run for run, is_figure in runs)
    return template, ",".join(run for run, is_figure in runs if is_figure)


def _rounded(x: Any) -> float | None:
    """What an answer would be under a thought, with the digits that travel; None where that is no
    number."""
    return float(f"{float(x):.8g}") if np.isfinite(float(x)) else None
