"""Names that an interactive page accepts in answers, as `fb.check` does: their meanings and
alternative readings."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from itertools import groupby
from typing import Any

import numpy as np

from freebody.expressions.expression import Symbol
from freebody.expressions.grammar.words import spelt
from freebody.expressions.printed_names import sym
from freebody.lazy import cached_property
from freebody.scalars.generators import function_of
from freebody.scalars.trig import Trig
from freebody_textbook.check.algebra.finite_field import RealPoint
from freebody_textbook.check.asked.asked_quantities import Targets
from freebody_textbook.check.asked.quantity import AskedQuantity, QuantityTable
from freebody_textbook.check.asked.right_equations import RightEquations
from freebody_textbook.check.claims import own_names
from freebody_textbook.check.reading.vocabulary import Vocabulary
from freebody_textbook.check.reasons.misreadings import (
    GRAVITY,
    angle_of_cosine,
    is_value,
    slide_meant,
)
from freebody_textbook.derivation import Derivation
from freebody_textbook.living.kernel import PageProgram
from freebody_textbook.relations.formula_values import rank

MOST_THOUGHT = 4
"""Coordinates up to which right values are short enough to be worked out for a page."""
_MOST_ALIKE = 40
"""Names without value that differ by as many figures, c₁₁₁ to c₄₄₄, up to which a page knows
them."""
ValueSum = list[str | int]
"""A sum of symbols by name and of values by place in y; of a function of it the name first, behind
a ~."""
QuantityKey = tuple[Any, ...]


class PageNames:
    """The names of one interactive page. readable: quantities in its lines by name; defined:
    quantities that its lines define; tried: states at which a name's value is compared with that of
    `fb.check`."""

    def __init__(
        self,
        derivation: Derivation,
        kernel: PageProgram,
        readable: Mapping[str, Any],
        defined: Collection[str],
        setting: RightEquations,
        tried: Sequence[Mapping[str, float]],
    ):
        self.setting, self._kernel, self._tried = setting, kernel, tried
        self._notation = derivation.lettering.notation
        self.targets = Targets(setting, letters=self._notation.all_letters)
        self.vocabulary = self._vocabulary()
        spellings = {name: plain for name in readable if (plain := spelt(name))}
        self._own: dict[str, Any] = {plain: readable[name] for name, plain in spellings.items()}
        self._called = {
            spelt(derivation.lettering.symbol(x).name): spellings[x.name]
            for x in map(sym, spellings)
            if isinstance(x, Symbol)
        }
        self._strange = self._others(spellings, defined)
        self._numbers: dict[QuantityKey, int] = {}
        self._asked_for: set[int] = set()
        self._values: dict[QuantityKey, list[int]] = {}
        for name, x in self._own.items():
            for key, place in zip(self._keys(name, x), kernel.places(x), strict=True):
                self._values.setdefault(key, [place])
        self._meanings = dict(self._all_meanings())
        _ = self._velocity_terms  # their places, before the page's size is known

    def _vocabulary(self) -> Vocabulary:
        found = Vocabulary(self.setting, self.targets.names, self.targets.alone)
        for name, value in self.setting.given.items():
            found.define(name, value)
        own_names.of_notation(found, self.targets, self._notation)
        return found

    def _keys(self, name: str, x: Any) -> list[QuantityKey]:
        """The keys of the `fb.check` quantities that a page's name means, one per entry; keys of
        the page's own if there are none."""
        single, table = self.targets.single.get(name), self.targets.tables.get(name)
        if name in self._strange:
            single = table = None
        if rank(x) == 0 and single is not None:
            return [key_of(single)]
        shape = (len(x), len(x[0]) if rank(x) == 2 else 1) if rank(x) else ()
        if table is not None and shape == (len(table), len(table[0])):
            return [key_of(entry) for row in table for entry in row]
        size = shape[0] * shape[1] if shape else 1
        return [(name, k) for k in range(size)]

    def _others(self, spellings: Mapping[str, str], defined: Collection[str]) -> set[str]:
        """Names that mean something else in `fb.check`, such as k1, the kinetic energy of body 1:
        compared numerically if short, otherwise taken from the lines' definitions."""
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

    def _valued(self, x: Any) -> list[float]:
        """Values of a page's quantity at the tried states."""
        inputs = self._kernel.inputs
        rows = [{k: v for k, v in row.items() if k in inputs} for row in self._tried]
        return [float(self._kernel.at_random([x], **row)[0, 0]) for row in rows]

    def _all_meanings(self) -> Iterator[tuple[str, dict[str, Any]]]:
        """Every name with its meaning: "s" a scalar, "t" a vector or matrix, "q" the number of a
        quantity, "bodies" if it belongs to a body."""
        for name in dict.fromkeys((*sorted(self.vocabulary.known), *self._own, *self._called)):
            meaning = self._meaning(name)
            if name not in ("t", "pi"):
                yield name, meaning

    def _meaning(self, name: str) -> dict[str, Any]:
        """The meaning of one name; {} if it has no value."""
        vocabulary, targets = self.vocabulary, self.targets
        meant = vocabulary.aliases.get(name, self._called.get(name, name))
        single, table = targets.single.get(meant), targets.tables.get(meant)
        known = name in vocabulary.symbols or name in vocabulary.waves or single is not None
        found: dict[str, Any] = {"s": self._scalar(name, single)} if known else {}
        if table is not None:
            found["t"] = self._table(_keys_of(table))
        named = table if name not in vocabulary.symbols else None  # g is no vector's name
        keys = [key_of(single)] if single is not None else [key_of(x) for (x, *_) in named or ()]
        if not keys and meant in self._own:
            keys = self._keys(meant, self._own[meant])
            found = self._of_page(meant, keys) | found
        found = {key: x for key, x in found.items() if x is not None}
        asked = single or (table[0][0] if table else None)
        return found | self._marks(name, asked, keys) if found else {}

    def _marks(
        self, name: str, asked: AskedQuantity | None, keys: list[QuantityKey]
    ) -> dict[str, int]:
        """The number of a name's quantity, and whether it is a quantity of bodies."""
        found: dict[str, int] = {}
        if any(key in self._values for key in keys):
            found["q"] = self._number(keys[0])
        if asked and name not in self.vocabulary.symbols and is_of_bodies(asked):
            found["bodies"] = 1
        return found

    def _of_page(self, name: str, keys: list[QuantityKey]) -> dict[str, Any]:
        """The meaning of a name defined by the page's lines: a scalar, or a column of entries."""
        if rank(self._own[name]) == 0:
            return {"s": self._values[keys[0]]}
        return {"t": self._table([[key] for key in keys])}

    def _scalar(self, name: str, single: AskedQuantity | None) -> ValueSum | list[int] | None:
        """The scalar meaning of a name: a symbol, a sine or cosine, or a quantity."""
        vocabulary = self.vocabulary
        if name in vocabulary.symbols:
            return self._slots(vocabulary.symbols[name])
        if name in vocabulary.waves:
            function, angle = vocabulary.waves[name]
            return [f"~{function}", *(x for x, _ in angle)]
        return self._values.get(key_of(single)) if single is not None else None

    def _table(self, keys: list[list[QuantityKey]]) -> list[list[list[int]]] | None:
        if any(key not in self._values for row in keys for key in row):
            return None
        return [[self._values[key] for key in row] for row in keys]

    def _number(self, key: QuantityKey) -> int:
        return self._numbers.setdefault(key, len(self._numbers))

    def _slots(self, value: Any) -> ValueSum | None:
        """A symbol's value as a sum of symbols, or as a number that the page computes; None if it
        is neither."""
        terms = list(value.terms()) if isinstance(value, Trig) else []
        names = [next(iter(powers)) for powers, c in terms if c == 1 and [*powers.values()] == [1]]
        plain = all(x in symbols_of(self.setting) for x in names)
        if len(names) == len(terms) and plain and isinstance(value, Trig):
            return list(names)
        with suppress(KeyError):  # a symbol that the page does not have
            return list(self._kernel.places(self.setting.layout.form(value)))
        return None

    def of_line(self, name: str, given: Iterable[str]) -> list[int]:
        """Numbers of a line's own quantities, which an answer to it must not use, the line's result
        first."""
        numbers = (self._meanings.get(spelt(x), {}).get("q") for x in (name, *given))
        own = [x for x in dict.fromkeys(numbers) if x is not None]
        self._asked_for.update(own)
        return own

    def asked(self, name: str) -> list[AskedQuantity]:
        """The quantities of `fb.check` with the name of a line, one per entry."""
        plain = spelt(name)
        x = self._own.get(plain)
        if x is None:
            return []
        single, table = self.targets.single.get(plain), self.targets.tables.get(plain)
        if rank(x) == 0:
            return [single] if single is not None else []
        entries = [entry for row in table or () for entry in row]
        return entries if len(entries) == len(x) else []

    def readings(self, names: Sequence[str]) -> list[dict[str, Any]]:
        """Numbers and names with an alternative reading, and a sentence about it; terms: only as
        terms by themselves in lines of torques."""
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
        """Alternative reading: a number equal to the gravitational acceleration, read as g."""
        g = self.setting.order.gravity
        value = self.setting.symbols.model.parameters.get(g or "")
        if not g or value is None:
            return {}
        return {x: [g] for x in GRAVITY if is_value(value, x)}

    @property
    def _slide(self) -> dict[str, ValueSum]:
        """Alternative reading: x for the only slide, if its coordinate has another name."""
        single = sorted(self.targets.single.items())
        meant = {name: slide_meant(self.setting, name, target) for name, target in single}
        return {name: [slide] for name, slide in meant.items() if slide}

    @property
    def _cosines(self) -> dict[str, ValueSum]:
        """Alternative reading: C12 as a cosine, if it is also a quantity's name."""
        single = sorted(self.targets.single.items())
        meant = {name: angle_of_cosine(self.setting, name, target) for name, target in single}
        return {name: ["~cos", *angles] for name, angles in meant.items() if angles}

    @cached_property
    def _velocity_terms(self) -> dict[str, ValueSum]:
        """Alternative reading: velocity terms named c1 or V1, beside torques."""
        if len(self.setting.symbols.coordinates) > MOST_THOUGHT:
            return {}
        single, found = self.targets.single, dict[str, ValueSum]()
        terms = {x.index[0]: x for x in single.values() if x.kind.is_velocity_term}
        levels = ((name, x) for name, x in single.items() if x.kind.up_to_a_constant)
        names = {name: x.index[0] for name, x in levels if x.index}
        waves = ((f"{x.kind.letters[0]}{k}", k) for k, x in terms.items())
        names |= {name: k for name, k in waves if name in self.vocabulary.waves}
        for name in sorted(names):
            target = terms.get(names[name])
            slots = target and (self._values.get(key_of(target)) or self._slots(target.compute()))
            if slots:
                found[name] = [*slots]
        return found

    @cached_property
    def apart(self) -> list[str]:
        """Names that are never part of a longer word."""
        own = self.vocabulary
        return [x for x in self._meanings if x in own.alone and x not in {*own.symbols, *own.waves}]

    def words(self, order: Sequence[str]) -> list[tuple[list[str], dict[str, dict[str, Any]]]]:
        """All names, those that differ only in digits grouped under a template (theta# for θ1 and
        θ12): spellings with the same meaning, and meanings by digits; {} where they have no value;
        "apart" for names that stand alone."""
        index, apart = _places(order), frozenset(self.apart)
        rows: dict[str, dict[str, dict[str, Any]]] = {}
        for name, meaning in self._meanings.items():
            said = {key: x for key, x in meaning.items() if key != "q" or x in self._asked_for}
            said = _numbered(said, index) | ({"apart": 1} if name in apart else {})
            template, figures = _template(name)
            rows.setdefault(template, {})[figures] = said
        found: dict[str, tuple[list[str], dict[str, dict[str, Any]]]] = {}
        for template, row in rows.items():
            unvalued = [figures for figures, x in row.items() if not {"s", "t"} & {*x}]
            alike = Counter(map(len, unvalued))
            for figures in unvalued:
                if alike[len(figures)] > _MOST_ALIKE:
                    del row[figures]
            found.setdefault(json.dumps(row), ([], row))[0].append(template)
        return [row for row in found.values() if row[1]]


def key_of(target: AskedQuantity) -> QuantityKey:
    """Hashable key of a quantity that is unique among all."""
    return target.kind, target.index, target.axis, target.words, target.joint


def _keys_of(table: QuantityTable) -> list[list[QuantityKey]]:
    return [[key_of(entry) for entry in row] for row in table]


def is_of_bodies(target: AskedQuantity) -> bool:
    return target.kind.of == "bodies"


def _places(names: Sequence[str]) -> dict[str, int]:
    """Indices of symbols by name, as in the script."""
    return {name: -1 - k for k, name in enumerate(names)}


def _numbered(meaning: Mapping[str, Any], index: Mapping[str, int]) -> dict[str, Any]:
    """A meaning with symbol names replaced by indices."""
    made = dict(meaning)
    if "s" in made:
        made["s"] = [x if isinstance(x, int) else index.get(x, x[1:]) for x in made["s"]]
    return made


def _template(name: str) -> tuple[str, str]:
    """A name with # for each run of digits, and these runs."""
    runs = [("".join(run), is_figure) for is_figure, run in groupby(name, str.isdigit)]
    template = "".join("#" if is_figure else run for run, is_figure in runs)
    return template, ",".join(run for run, is_figure in runs if is_figure)


def symbols_of(setting: RightEquations) -> tuple[str, ...]:
    """Names of a ring that receive values in states."""
    return tuple(x for x in setting.ring.names if not function_of(x))
