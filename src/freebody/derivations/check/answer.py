"""An answer's text as equations: which quantity each line is about, and the expression given for it."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from freebody.derivations.check import words
from freebody.derivations.check.exact import Reader
from freebody.derivations.check.lexer import Token, tokens
from freebody.derivations.check.parser import Parser
from freebody.derivations.check.setting import FAMILIES, Setting
from freebody.derivations.check.source import AnswerError, Source
from freebody.derivations.check.targets import Target, Targets
from freebody.derivations.check.tree import Node, Symbol, Table
from freebody.derivations.check.vocabulary import Vocabulary, spellings
from freebody.scalars.trig import Trig

MOST_EQUATIONS, MOST_SIDES = 100, 6


@dataclass(frozen=True)
class Claim:
    """label = what the user says it is."""

    label: str
    target: Target
    node: Node
    value: Trig
    source: Source


def claims(setting: Setting, text: str, names: Mapping[str, str]) -> list[Claim]:
    """All that an answer states, in its order."""
    source = Source.of(text)
    targets = Targets(setting, velocity=re.search(r"(?<![A-Za-z\\])h(?![a-z])", text) is not None)
    vocabulary = Vocabulary(setting, targets.names)
    for name, meaning in names.items():
        _rename(vocabulary, targets, name, meaning)
    for name in _new_names(source, vocabulary):
        vocabulary.define(name, setting.zero)
    lines = [_sides(source, line) for line in _lines(source, tokens(source, vocabulary))]
    if not lines:
        raise AnswerError(
            "the answer is empty; write an equation such as H12 = m2*(lc2^2 + l1*lc2*cos(theta2)) + I2"
        )
    if len(lines) > MOST_EQUATIONS:
        raise AnswerError(f"the answer has {len(lines)} equations; at most {MOST_EQUATIONS} are read")
    reading = _Reading(source, vocabulary, targets)
    own = reading.definitions(lines)
    found = [claim for line in lines if line not in own for claim in reading.claims(line)]
    if not found:
        raise AnswerError("the answer only introduces names; write what is to be checked, such as tau1 = …")
    return found


# ---------------------------------------------------------------- names
def _rename(vocabulary: Vocabulary, targets: Targets, name: str, meaning: str) -> None:
    """A name of the user's own, for a symbol (and its rates), for a family of them, or for an expression."""
    plain = _plain(name)
    target = _plain(meaning) if re.fullmatch(r"[\w\\{}']+", meaning) else ""
    if target in (*FAMILIES, "theta", "d", "q") and target not in vocabulary.symbols:
        for k in range(1, vocabulary.setting.joints + 1):
            if f"{target}{k}" in vocabulary.symbols:
                _rename(vocabulary, targets, f"{plain}{k}", f"{target}{k}")
        return
    source = Source.of(meaning)
    parser = Parser(
        source, tokens(source, vocabulary)[:-1], vocabulary, lambda n: targets.single[n].compute()
    )
    value = Reader(source, vocabulary.setting.ring).read(parser.side())
    vocabulary.define(plain, value)
    letter, digits = re.sub(r"\d+$", "", plain), re.findall(r"\d*$", plain)[0]
    rate = value
    for dots in (1, 2):
        rate = rate.along(vocabulary.setting.symbols.rates)
        if rate.is_zero:
            return
        for spelling in spellings(letter, digits, dots):
            vocabulary.define(spelling, rate)


def _plain(name: str) -> str:
    """The plain spelling of a name."""
    source = Source.of(name.strip())
    if not source.text or not (source.text[0] in words.STARTS or source.text[0] == "\\"):
        raise AnswerError(f"names: {name!r} is no name")
    word = words.spell(source, 0)
    if word.end != len(source.text):
        raise AnswerError(f"names: {name!r} is no single name")
    return word.plain


def _new_names(source: Source, vocabulary: Vocabulary) -> list[str]:
    """Names before a = that mean nothing else: the user introduces them."""
    found = []
    for match in re.finditer(
        r"(?m)^[^\S\n]*(?:&\s*)?([^\W\d_][^=\n;,&+*/()-]{0,40}?)\s*&?\s*=(?!=)", source.text
    ):
        word = words.spell(source, match.start(1))
        alone = not source.text[word.end : match.end(1)].strip()
        if alone and words.cut(source, word, vocabulary.known, vocabulary.functions) is None:
            found.append(word.plain)
    return found


# ---------------------------------------------------------------- lines
Line = tuple[tuple[Token, ...], ...]
"""The sides of an equation."""


def _lines(source: Source, found: Sequence[Token]) -> list[list[Token]]:
    """Tokens by equation: a line that has no = of its own, or begins with an operator, continues the one before."""
    pieces: list[list[Token]] = [[]]
    depth = 0
    for token in found:
        depth += {"open": 1, "begin": 1, "close": -1, "end": -1}.get(token.kind, 0)
        if token.kind in ("line", "row", "stop", "comma") and depth <= 0:
            pieces.append([])
        elif not (token.kind in ("amp", "line") and (depth <= 0 or not _in_matrix(found, token))):
            pieces[-1].append(token)
    lines: list[list[Token]] = []
    for piece in pieces:
        if not piece:
            continue
        continues = piece[0].kind in ("operator", "equals") or (lines and _is_open(lines[-1]))
        if lines and continues:
            lines[-1] += piece
        else:
            lines.append(piece)
    return lines


def _in_matrix(found: Sequence[Token], token: Token) -> bool:
    """Whether a token inside brackets separates entries of a matrix: & always, a ; but no line break."""
    return token.kind == "amp" or token.text == ";"


def _is_open(line: list[Token]) -> bool:
    """Whether a line ends where something must follow."""
    return line[-1].kind in ("operator", "equals")


def _sides(source: Source, line: list[Token]) -> Line:
    sides: list[list[Token]] = [[]]
    for token in line:
        if token.kind == "equals":
            sides.append([])
        else:
            sides[-1].append(token)
    if len(sides) == 1:
        source.fail(
            "this line says nothing about what it equals; write, for example, tau1 = … or H12 = …",
            (line[0].start, line[-1].end),
        )
    if len(sides) > MOST_SIDES:
        source.fail(
            f"more than {MOST_SIDES} sides in one equation",
            sides[MOST_SIDES][0].span if sides[MOST_SIDES] else line[-1].span,
        )
    for k, side in enumerate(sides):
        if not side:
            equals = [token for token in line if token.kind == "equals"][max(0, k - 1)]
            source.fail("one side of this = is empty", equals.span)
    return tuple(map(tuple, sides))


# ---------------------------------------------------------------- meaning
class _Reading:
    """Lines into claims."""

    def __init__(self, source: Source, vocabulary: Vocabulary, targets: Targets):
        self.source, self.vocabulary, self.targets = source, vocabulary, targets
        self.setting = vocabulary.setting
        self.replaced: dict[str, Trig] = {}

    def parse(self, side: Sequence[Token]) -> Node:
        """A side as tree."""
        return Parser(self.source, side, self.vocabulary, self._quantity).side()

    def value(self, node: Node) -> Trig:
        """A tree as polynomial."""
        return Reader(self.source, self.setting.ring).read(node)

    def _quantity(self, name: str) -> Trig | None:
        if name in self.replaced:
            return self.replaced[name]
        return self.targets.single[name].compute() if name in self.targets.single else None

    def definitions(self, lines: Sequence[Line]) -> list[Line]:
        """Lines that introduce a name of the user's own, or an h that other lines use: their values are noted."""
        found = []
        for line in lines:
            name = (
                line[0][0].text if len(line) == 2 and len(line[0]) == 1 and line[0][0].kind == "name" else ""
            )
            if not name or (name in self.targets.names and not self._is_own_h(name, line, lines)):
                continue
            if (
                name in self.vocabulary.waves
                or name in self.setting.zeros
                or not self.vocabulary.symbols.get(name, self.setting.zero).is_zero
            ):
                self.source.fail(
                    f"{self.source[line[0][0].span]} is a symbol of the model, not a result to be checked",
                    line[0][0].span,
                )
            self.vocabulary.define(name, self.value(self.parse(line[1])))
            found.append(line)
        return found

    def _is_own_h(self, name: str, line: Line, lines: Sequence[Line]) -> bool:
        """Whether a line defines a velocity coefficient that other lines are written with."""
        if self.targets.single.get(name) is None or self.targets.single[name].family != "h":
            return False
        return any(
            t.kind == "name" and t.text == name for other in lines if other != line for s in other for t in s
        )

    def claims(self, line: Line) -> list[Claim]:
        """What one equation states."""
        named = [side for side in line if self._target(side) is not None]
        other = [side for side in line if self._target(side) is None]
        if not named or not other:
            return self._implicit(line)
        found = []
        for side in other:
            node = self.parse(side)
            for name in named:
                found += self._pairs(name[0], node)
        return found

    def _target(self, side: Sequence[Token]) -> str | None:
        """The quantity that a side is, if it is one alone."""
        if len(side) == 1 and side[0].kind == "name" and side[0].text in self.targets.names:
            return side[0].text
        return None

    def _pairs(self, name: Token, node: Node) -> list[Claim]:
        """The claims of name = node, entry by entry where it is a vector or matrix."""
        label = self.source[name.span]
        single, table = self.targets.single.get(name.text), self.targets.tables.get(name.text)
        if not isinstance(node, Table):
            if single is None:
                self.source.fail(f"{label} is a vector or matrix: write it as [[…, …], […, …]]", name.span)
            return [Claim(label, single, node, self.value(node), self.source)]
        if table is None and single is not None:
            table = self.targets.tables.get(name.text, [[single]])
        return self._entries(label, name, node, table or [])

    def _entries(self, label: str, name: Token, node: Table, table: list[list[Target]]) -> list[Claim]:
        rows = [list(row) for row in node.rows]
        if len(rows) == 1 and table and len(table[0]) == 1:
            rows = [[entry] for entry in rows[0]]  # a vector written as a row
        if label == "J" and len(rows) < len(table):
            table = table[: len(rows)]
        if [len(r) for r in rows] != [len(r) for r in table]:
            size = f"{len(table)} × {len(table[0])}"
            self.source.fail(f"{label} has {size} entries here", node.span)
        return [
            Claim(_entry_label(label, target), target, entry, self.value(entry), self.source)
            for row, targets in zip(rows, table, strict=True)
            for entry, target in zip(row, targets, strict=True)
        ]

    # ------------------------------------------------------------ torques inside an equation
    def _implicit(self, line: Line) -> list[Claim]:
        """An equation that holds one τ_i somewhere: solved for it."""
        span = (line[0][0].start, line[-1][-1].end)
        inside = {t.text for side in line for t in side if t.kind == "name" and t.text in self.targets.single}
        inside = {name for name in inside if self.targets.single[name].family == "tau"} - set(
            self.vocabulary.symbols
        )
        if len(line) != 2 or len(inside) != 1:
            self.source.fail(
                "neither side is one of the quantities that are checked",
                span,
                "These are tau1, H12 or M12, c1, g1 or G1, J11, T, V, x and y.",
            )
        (name,) = inside
        rest, slope = self._solved(line, name)
        if slope is None:
            self.source.fail(f"this equation cannot be solved for {name}", span)
        node = Symbol(*span, name, rest / -slope)
        return [Claim(name, self.targets.single[name], node, rest / -slope, self.source)]

    def _solved(self, line: Line, name: str) -> tuple[Trig, Trig | None]:
        """a and k of a + k τ = 0; k None where it is no number."""
        values = []
        for k in range(3):
            self.replaced[name] = self.setting.zero + k
            left, right = (self.value(self.parse(side)) for side in line)
            values.append(left - right)
        del self.replaced[name]
        slope = values[1] - values[0]
        linear = slope.is_constant and not slope.is_zero and slope == values[2] - values[1]
        return values[0], slope if linear else None


def _entry_label(label: str, target: Target) -> str:
    return f"{label}{''.join(map(str, target.index))}" if target.index else label
