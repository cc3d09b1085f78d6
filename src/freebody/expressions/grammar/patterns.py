"""Patterns of lexemes, as `\\frac { d name:@name } { d t }`: a small language whose sentences are
data, in which the tables say what may stand where.

A pattern is written with blanks between its items: a text stands for lexemes with that text (for
several letters also for the word that they are), %name for one of a class of lexemes, @name for
another pattern, < a | b > for either, name:x keeps what x was. Behind an item ? * + {m,n} say how
often, before it ~ that no blank stands before it, ! and & whether it follows, -x whether it stands
right before, -- whether it stands before, after blanks or none. Blanks between lexemes mean nothing
else; lines end.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field

from freebody.expressions.grammar.lexemes import KINDS, Lexeme, Lexemes, plain, scanned
from freebody.expressions.grammar.tables.classes import CLASSES, PATTERNS

MANY = 60
"""The most repetitions that * and + stand for."""

Captures = dict[str, tuple[int, int]]
_Next = Callable[[Lexemes, int, int, Captures], int]
_PatternStep = Callable[[_Next], _Next]
"""A function from the rest of a pattern to the pattern from here on, which returns where the whole
ends, or -1."""
_Test = Callable[[Lexeme], bool]
_Firsts = frozenset[str] | None
"""Texts and kinds that something begins with; None where that is not known."""


@dataclass(frozen=True)
class Match:
    """A match of a pattern: the lexemes that it describes."""

    lexemes: Lexemes
    start: int
    stop: int
    captures: Mapping[str, tuple[int, int]] = field(default_factory=dict)

    def __contains__(self, name: str) -> bool:
        """Whether the match has a non-empty capture of that name."""
        start, stop = self.captures.get(name, (0, 0))
        return stop > start

    def items(self, name: str) -> list[Lexeme]:
        """The lexemes of a named capture."""
        return self.lexemes.items[slice(*self.captures.get(name, (0, 0)))]

    def __getitem__(self, name: str) -> str:
        """The text of a named capture, without blanks."""
        return plain(self.items(name))

    @property
    def text(self) -> str:
        """The text of the matched lexemes, without blanks."""
        return plain(self.lexemes[self.start : self.stop])

    @property
    def span(self) -> tuple[int, int]:
        """Place of the match in the text."""
        at = self.lexemes[self.start].start if self.start < len(self.lexemes) else 0
        return at, self.lexemes[self.stop - 1].end if self.stop > self.start else at


class LexemePattern:
    """A pattern that is ready to be looked for."""

    def __init__(self, text: str):
        item = _Reader(text).whole()
        self._firsts = None if item.nullable else item.firsts
        self._needs = sorted(item.needs, key=len)
        self._run = item.step(lambda lexemes, k, end, kept: k)

    def at(self, lexemes: Lexemes, k: int, end: int | None = None) -> Match | None:
        """The match that begins at lexeme k, or None; `end`: the lexeme at which the searched text
        ends."""
        kept: Captures = {}
        stop = self._run(lexemes, k, len(lexemes) if end is None else end, kept)
        return Match(lexemes, k, stop, kept) if stop >= 0 else None

    def end(self, lexemes: Lexemes, k: int) -> int:
        """The index behind the match that begins at lexeme k; k where there is none."""
        match = self.at(lexemes, k)
        return match.stop if match else k

    def all(self, lexemes: Lexemes, start: int = 0, end: int | None = None) -> Iterator[Match]:
        """The matches in a stretch, from left to right, none inside another."""
        end = len(lexemes) if end is None else end
        stop = start
        if any(need.isdisjoint(lexemes.places) for need in self._needs):
            return
        for k in self._candidates(lexemes, start, end):
            if k >= stop and (match := self.at(lexemes, k, end)) is not None:
                yield match
                stop = max(match.stop, k + 1)

    def found_in(self, lexemes: Lexemes, start: int = 0, end: int | None = None) -> bool:
        """Whether the pattern matches anywhere in a stretch of lexemes."""
        return next(self.all(lexemes, start, end), None) is not None

    def _candidates(self, lexemes: Lexemes, start: int, end: int) -> Iterator[int] | range:
        if self._firsts is None:
            return range(start, end)
        rows = [lexemes.places[x] for x in self._firsts if x in lexemes.places]
        found = rows[0] if len(rows) == 1 else sorted(set().union(*rows))
        return (k for k in found if start <= k < end)


# -------------------------------------------------------------------------------- places
_OF_NAMES = frozenset(kind[1:] for kind in CLASSES["name"])


def _touches(lexemes: Lexemes, k: int, end: int) -> bool:
    """Whether there is a lexeme at k, with no blank before it."""
    return k < end and not lexemes[k].apart


def _fresh(lexemes: Lexemes, k: int, end: int) -> bool:
    before = lexemes[k - 1] if k and _touches(lexemes, k, end) else None
    return before is None or (before.kind not in _OF_NAMES and before.text != "_")


_PLACES: dict[str, Callable[[Lexemes, int, int], bool]] = {
    "apart": lambda lexemes, k, end: not _touches(lexemes, k, end),
    "glued": _touches,
    "first": lambda lexemes, k, end: k == 0 or lexemes[k - 1].kind == "line",
    "last": lambda lexemes, k, end: k >= end or lexemes[k].kind == "line",
    "fresh": _fresh,
    "ends": lambda lexemes, k, end: (
        not _touches(lexemes, k, end) or lexemes[k].kind not in _OF_NAMES
    ),
    "word": lambda lexemes, k, end: (
        k == 0 or not _touches(lexemes, k, end) or lexemes[k - 1].kind != "letter"
    ),
    "word_ends": lambda lexemes, k, end: (
        not _touches(lexemes, k, end) or lexemes[k].kind != "letter"
    ),
}
"""The conditions on a place: whether a blank stands there or none, and whether a line, a name or a
word begins or ends."""

# -------------------------------------------------------------------------------- reading
ITEM = re.compile(
    r"(?P<back>!?--?(?=[^\s?]))?(?P<look>[!&](?=[^\s?]))?(?:(?P<name>[a-z_]+):(?=\S))?"
    r"(?P<glued>~(?=\S))?(?P<body><|>|\||.+?)"
    r"(?P<times>(?<=.)[?*+]|\{\d+,\d+\})?"
)


@dataclass
class _PatternItem:
    step: _PatternStep
    firsts: _Firsts
    nullable: bool = False
    needs: frozenset[frozenset[str]] = frozenset()
    """Texts and kinds, one of each of which it cannot be without."""
    single: tuple[_Test, bool] | None = None
    """The test of an item that is one lexeme, and whether no blank may stand before it."""


class _Reader:
    """The reader of a pattern's text, which builds the pattern."""

    def __init__(self, text: str):
        self.text = text
        self.words = text.split()
        self.at = 0

    def whole(self) -> _PatternItem:
        item = self._either()
        if self.at < len(self.words):
            raise ValueError(f"{self.words[self.at]!r} closes nothing in {self.text!r}")
        return item

    def _either(self) -> _PatternItem:
        ways = [self._sequence()]
        while self.at < len(self.words) and self.words[self.at] == "|":
            self.at += 1
            ways.append(self._sequence())
        return ways[0] if len(ways) == 1 else _either(ways)

    def _sequence(self) -> _PatternItem:
        items: list[_PatternItem] = []
        while self.at < len(self.words) and self.words[self.at] != "|":
            if self.words[self.at][0] == ">" and self.words[self.at] != ">=":
                break
            items.append(self._item())
        return _sequence(items)

    def _item(self) -> _PatternItem:
        match = ITEM.fullmatch(self.words[self.at])
        assert match, self.words[self.at]
        self.at += 1
        times = match["times"]
        if match["body"] == "<":
            item = self._either()
            closing = self.words[self.at]
            assert closing[0] == ">", self.text
            self.at += 1
            times = closing[1:] or None
        elif match["back"]:
            return _behind(match["body"], match["back"])
        else:
            item = _single(match["body"], bool(match["glued"]))
        if match["glued"] and match["body"] == "<":
            item = _sequence([_ZERO["glued"], item])
        if times:
            low, high = _TIMES.get(times) or map(int, times.strip("{}").split(","))
            item = _repeated(item, low, high)
        if match["name"]:
            item = _kept(match["name"], item)
        return _looked(item, match["look"] == "&") if match["look"] else item


_TIMES = {"?": (0, 1), "*": (0, MANY), "+": (1, MANY)}


# -------------------------------------------------------------------------------- steps
def _one(test: _Test, firsts: _Firsts, glued: bool = False) -> _PatternItem:
    def step(next_: _Next) -> _Next:
        def run(lexemes: Lexemes, k: int, end: int, kept: Captures) -> int:
            if k < end and test(x := lexemes.items[k]) and not (glued and x.apart):
                return next_(lexemes, k + 1, end, kept)
            return -1

        return run

    needs = frozenset() if firsts is None else frozenset((firsts,))
    return _PatternItem(step, firsts, needs=needs, single=(test, glued))


def _zero(test: Callable[[Lexemes, int, int], bool]) -> _PatternItem:
    def step(next_: _Next) -> _Next:
        def run(lexemes: Lexemes, k: int, end: int, kept: Captures) -> int:
            return next_(lexemes, k, end, kept) if test(lexemes, k, end) else -1

        return run

    return _PatternItem(step, frozenset(), nullable=True)


_ZERO = {name: _zero(test) for name, test in _PLACES.items()}


def _single(body: str, glued: bool) -> _PatternItem:
    """The item of a pattern for one lexeme class, another pattern or a literal text."""
    if body == "~":
        return _ZERO["glued"]
    if body[0] == "%" and len(body) > 1:
        name = body[1:]
        if name in _ZERO:
            return _ZERO[name]
        test, firsts = _class(name)
        return _one(test, firsts, glued)
    if body[0] == "@" and len(body) > 1:
        item = _named_pattern(body[1:])
        return _sequence([_ZERO["glued"], item]) if glued else item
    wanted = scanned(body)
    assert wanted, body
    items = [
        _one(lambda x, text=x.text: x.text == text, frozenset((x.text,)), glued or k > 0)
        for k, x in enumerate(wanted)
    ]
    if len(items) > 1 and all(x.kind == "letter" for x in wanted):
        items = [_ZERO["word"], *items, _ZERO["word_ends"]]
    return _sequence(items)


def _class(name: str) -> tuple[_Test, _Firsts]:
    if name == "any":
        return (lambda x: x.kind != "line"), None
    if name.startswith("not_"):
        test, _ = _class(name[4:])
        return (lambda x: x.kind != "line" and not test(x)), None
    if name == "bare_letter":
        return (lambda x: x.kind == "letter" and len(x.text) == 1), frozenset(("%letter",))
    if name == "dotted_letter":
        return (lambda x: x.kind == "letter" and not _DOTS.isdisjoint(x.text)), frozenset(
            ("%letter",)
        )
    members = _members(name)
    kinds = frozenset(x[1:] for x in members if x[0] == "%")
    texts = frozenset(x for x in members if x[0] != "%")
    return (lambda x: x.text in texts or x.kind in kinds), frozenset(members)


def _members(name: str) -> set[str]:
    """The texts of a lexeme class and of the classes in it; kinds of lexemes are written with a %
    in front."""
    if name not in CLASSES:
        assert name in KINDS, name
        return {f"%{name}"}
    found: set[str] = set()
    for x in CLASSES[name]:
        found |= _members(x[1:]) if x[0] == "%" else {x}
    return found


_DOTS = frozenset("\u0307\u0308˙¨")
_patterns: dict[str, _PatternItem] = {}


def _named_pattern(name: str) -> _PatternItem:
    if name not in _patterns:
        _patterns[name] = _Reader(PATTERNS[name]).whole()
    return _patterns[name]


def _sequence(items: list[_PatternItem]) -> _PatternItem:
    if len(items) == 1:
        return items[0]

    def step(next_: _Next) -> _Next:
        for item in reversed(items):
            next_ = item.step(next_)
        return next_

    needs = frozenset[frozenset[str]]().union(*(item.needs for item in items))
    firsts: _Firsts = frozenset()
    for item in items:
        firsts = None if firsts is None or item.firsts is None else firsts | item.firsts
        if not item.nullable:
            return _PatternItem(step, firsts, needs=needs)
    return _PatternItem(step, firsts, nullable=True, needs=needs)


def _either(ways: list[_PatternItem]) -> _PatternItem:
    def step(next_: _Next) -> _Next:
        runs = [way.step(next_) for way in ways]

        def run(lexemes: Lexemes, k: int, end: int, kept: Captures) -> int:
            for one in runs:
                stop = one(lexemes, k, end, kept)
                if stop >= 0:
                    return stop
            return -1

        return run

    firsts: _Firsts = frozenset()
    for way in ways:
        firsts = None if firsts is None or way.firsts is None else firsts | way.firsts
    needs = frozenset.intersection(*(way.needs for way in ways))
    if firsts is not None and not any(way.nullable for way in ways):
        needs |= {firsts}
    return _PatternItem(step, firsts, any(way.nullable for way in ways), needs)


def _repeated(item: _PatternItem, low: int, high: int) -> _PatternItem:
    """A pattern's item repeated between `low` and `high` times, as often as possible."""
    if item.single is not None:
        return _repeated_single(item, item.single, low, high)

    def step(next_: _Next) -> _Next:
        key = f"{id(next_)} {id(item)}"

        def from_there(lexemes: Lexemes, k: int, end: int, kept: Captures, count: int) -> int:
            if count < high:
                before = kept.get(key)
                kept[key] = count, k
                stop = again(lexemes, k, end, kept)
                if stop >= 0:
                    return stop
                _put_back(kept, key, before)
            return next_(lexemes, k, end, kept) if count >= low else -1

        def behind(lexemes: Lexemes, k: int, end: int, kept: Captures) -> int:
            count, last = kept[key]
            return from_there(lexemes, k, end, kept, count + 1) if k > last else -1

        again = item.step(behind)
        return lambda lexemes, k, end, kept: from_there(lexemes, k, end, kept, 0)

    needs = item.needs if low else frozenset[frozenset[str]]()
    return _PatternItem(step, item.firsts, item.nullable or low == 0, needs)


def _repeated_single(
    item: _PatternItem, single: tuple[_Test, bool], low: int, high: int
) -> _PatternItem:
    test, glued = single

    def step(next_: _Next) -> _Next:
        def run(lexemes: Lexemes, k: int, end: int, kept: Captures) -> int:
            items, last = lexemes.items, min(end, k + high)
            j = k
            while j < last and test(items[j]) and not (glued and items[j].apart):
                j += 1
            for stop in range(j, k + low - 1, -1):
                whole = next_(lexemes, stop, end, kept)
                if whole >= 0:
                    return whole
            return -1

        return run

    needs = item.needs if low else frozenset[frozenset[str]]()
    return _PatternItem(step, item.firsts, low == 0, needs)


def _kept(name: str, item: _PatternItem) -> _PatternItem:
    begun = f"{name} begun"

    def step(next_: _Next) -> _Next:
        def close(lexemes: Lexemes, k: int, end: int, kept: Captures) -> int:
            before = kept.get(name)
            kept[name] = kept[begun][0], k
            stop = next_(lexemes, k, end, kept)
            if stop < 0:
                _put_back(kept, name, before)
            return stop

        inner = item.step(close)

        def run(lexemes: Lexemes, k: int, end: int, kept: Captures) -> int:
            before = kept.get(begun)
            kept[begun] = k, k
            stop = inner(lexemes, k, end, kept)
            if stop < 0:
                _put_back(kept, begun, before)
            return stop

        return run

    return _PatternItem(step, item.firsts, item.nullable, item.needs)


def _put_back(kept: Captures, name: str, before: tuple[int, int] | None) -> None:
    if before is None:
        kept.pop(name, None)
    else:
        kept[name] = before


def _looked(item: _PatternItem, follows: bool) -> _PatternItem:
    found = item.step(lambda lexemes, k, end, kept: k)
    return _zero(lambda lexemes, k, end: (found(lexemes, k, end, {}) >= 0) == follows)


def _behind(body: str, mark: str) -> _PatternItem:
    wanted, anywhere = mark[0] != "!", "--" in mark
    of_class = _class(body[1:])[0] if body[0] == "%" and len(body) > 1 else None

    def stands(lexemes: Lexemes, k: int, end: int) -> bool:
        touches = k > 0 and (anywhere or k >= len(lexemes) or not lexemes[k].apart)
        if not touches:
            return not wanted
        before = lexemes[k - 1]
        return (of_class(before) if of_class else before.text == body) == wanted

    return _zero(stands)
