"""An answer's text as equations: which quantity each line is about, and the expression given for
it."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NoReturn

from freebody.derivations.check import undriven_joints
from freebody.derivations.check.answer_lines import DocumentReader, Line
from freebody.derivations.check.answer_text import AnswerError, AnswerText
from freebody.derivations.check.answer_tree import Named
from freebody.derivations.check.asked_quantities import AMBIGUOUS, AskedQuantity, Targets
from freebody.derivations.check.circular_answers import GivenQuantity, refuse_circles, uses
from freebody.derivations.check.documents.answer_document import AnswerDocument, FormulaPiece
from freebody.derivations.check.exact_polynomials import PolynomialReader
from freebody.derivations.check.reading import AnswerParser
from freebody.derivations.check.right_equations import FAMILIES, RightEquations
from freebody.derivations.check.tables_in_formulas import worked_out
from freebody.derivations.check.units import is_of_another_kind
from freebody.derivations.check.verdict import UnreadEquation
from freebody.derivations.check.vocabulary import Vocabulary, spellings
from freebody.derivations.expressions.evaluate import NoValue
from freebody.derivations.expressions.nodes import Expression, Matrix, Negative, Sum
from freebody.derivations.grammar import words
from freebody.derivations.grammar.lexer import Token, tokens
from freebody.derivations.grammar.parser import around
from freebody.derivations.grammar.source import Source, Span
from freebody.errors import FreebodyError, listed
from freebody.scalars.trig import Trig

MOST_EQUATIONS = 100


@dataclass(frozen=True)
class Claim:
    """label = what the user says it is."""

    label: str
    target: AskedQuantity
    node: Expression
    value: Trig
    source: AnswerText
    uses: tuple[GivenQuantity, ...] = ()
    """Quantities that it is given by."""


@dataclass(frozen=True)
class Statements:
    """What a document says: claims in its order, the names of its own that no statement uses as
    they are written, and what was not read."""

    claims: list[Claim]
    unused: tuple[str, ...]
    unread: tuple[UnreadEquation, ...] = ()


def statements(
    setting: RightEquations, document: AnswerDocument, names: Mapping[str, str]
) -> Statements:
    """All that an answer states."""
    coefficients = setting.turned is None and re.search(
        r"(?<![A-Za-z\\])h(?![a-z])", document.formulas
    )
    targets = Targets(setting, velocity=bool(coefficients))
    vocabulary = Vocabulary(setting, targets.names)
    for name, meaning in names.items():
        _rename(vocabulary, targets, name, meaning)
    reading = DocumentReader(document, vocabulary, targets.names)
    source = reading.source
    for name in _new_names(source, reading.pieces, vocabulary):
        vocabulary.define(name, setting.zero)
    lines = reading.lines()
    if not lines and not reading.unread:
        raise AnswerError(
            "the answer is empty; write an equation such as H12 = m2*(lc2^2 + l1*lc2*cos(theta2)) "
            "+ I2"
        )
    if len(lines) > MOST_EQUATIONS:
        raise AnswerError(
            f"the answer has {len(lines)} equations; at most {MOST_EQUATIONS} are read"
        )
    claimed = _ClaimReader(source, vocabulary, targets)
    own: list[Line] = []
    for line in lines:
        with reading.passing_over(line):
            own += claimed.definitions(line, lines)
    found: list[Claim] = []
    for line in lines:
        if line not in own and line not in reading.failed:
            with reading.passing_over(line):
                found += claimed.claims(line, found)
    if not found:
        _refuse_nothing(source, own, reading.unread)
    refuse_circles(source, found)
    unread = sorted(reading.unread, key=lambda row: row.at)
    return Statements(found, _unused(source, own, lines), tuple(unread))


def _refuse_nothing(
    source: Source, own: Sequence[Line], unread: Sequence[UnreadEquation]
) -> NoReturn:
    """Raise the error that nothing was found to be checked."""
    if unread:
        first = unread[0]
        raise AnswerError(f"no equation could be read; {first.where}: {first.reason}")
    names_given = dict.fromkeys(source[line[0][0].span] for line in own)
    taken = "are taken for names" if len(names_given) > 1 else "is taken for a name"
    raise AnswerError(
        f"{listed(names_given, 8)} {taken} of your own, not one of the robot's quantities; "
        f"write the quantity to be checked, such as tau1 = …"
    )


def _unused(source: Source, own: Sequence[Line], lines: Sequence[Line]) -> tuple[str, ...]:
    """The names that lines introduce and no other line uses."""
    unused = []
    for line in own:
        used = {
            token.text
            for other in lines
            if other is not line
            for side in (other if other not in own else other[1:])
            for token in side
        }
        if line[0][0].text not in used:
            unused.append(source[line[0][0].span])
    return tuple(dict.fromkeys(unused))


# ---------------------------------------------------------------- names
def _rename(vocabulary: Vocabulary, targets: Targets, name: str, meaning: str) -> None:
    """A name of the user's own, for a symbol (and its rates), for a family of them, for an
    expression, or a letter for the cosines and sines of all angles."""
    plain = _plain(name)
    target = _plain(meaning) if re.fullmatch(r"[\w\\{}']+", meaning) else ""
    if target in (*FAMILIES, "theta", "d", "q") and target not in vocabulary.symbols:
        for k in range(1, vocabulary.setting.joints + 1):
            if f"{target}{k}" in vocabulary.symbols:
                _rename(vocabulary, targets, f"{plain}{k}", f"{target}{k}")
        return
    if target in ("sin", "cos"):
        vocabulary.also_wave(plain, target)
        return
    source = AnswerText.of(meaning)
    parser = AnswerParser(
        source, tokens(source, vocabulary)[:-1], vocabulary, lambda n: targets.single[n].compute()
    )
    node = parser.side()
    value = PolynomialReader(source, vocabulary.setting.ring).read(node)
    given = tuple(use.target for use in uses(node, targets.single, vocabulary))
    vocabulary.define(plain, value, given)
    letter, digits = re.sub(r"\d+$", "", plain), re.findall(r"\d*$", plain)[0]
    rate = value
    for dots in (1, 2):
        rate = rate.along(vocabulary.setting.symbols.rates)
        if rate.is_zero:
            return
        for spelling in spellings(letter, digits, dots):
            vocabulary.define(spelling, rate, given)


def _plain(name: str) -> str:
    """The plain spelling of a name."""
    source = AnswerText.of(name.strip())
    if not source.text or not (source.text[0] in words.STARTS or source.text[0] == "\\"):
        raise AnswerError(f"names: {name!r} is not a name")
    word = words.spell(source, 0)
    if word.end != len(source.text):
        raise AnswerError(f"names: {name!r} is no single name")
    return word.plain


def _new_names(source: Source, pieces: Sequence[FormulaPiece], vocabulary: Vocabulary) -> list[str]:
    """Names before a = that mean nothing else: the user introduces them."""
    found = []
    begun = [m for x in pieces if (m := _OWN_NAME.match(source.text, x.start, x.end))]
    for match in [*begun, *_NEXT_OWN_NAME.finditer(source.text)]:
        try:
            word = words.spell(source, match.start(1))
        except FreebodyError:  # told where the line is read
            continue
        alone = not source.text[word.end : match.end(1)].strip()
        if alone and words.cut(source, word, vocabulary.known, vocabulary.functions) is None:
            found.append(word.plain)
    return found


_NAME_AND_EQUALS = (
    r"[^\S\n]*(?:&\s*)?((?:[^\W\d_]|\\[a-zA-Z])[^=\n;,&+*/()-]{0,40}?)(?:\s{0,9}&)?\s{0,9}=(?!=)"
)
_OWN_NAME = re.compile(_NAME_AND_EQUALS)
_NEXT_OWN_NAME = re.compile(rf"(?:^|[,;]|\\\\){_NAME_AND_EQUALS}", re.MULTILINE)


# ---------------------------------------------------------------- meaning
class _ClaimReader:
    """Lines into claims."""

    def __init__(self, source: AnswerText, vocabulary: Vocabulary, targets: Targets):
        self.source, self.vocabulary, self.targets = source, vocabulary, targets
        self.setting = vocabulary.setting
        self.replaced: dict[str, Trig] = {}

    def parse(self, side: Sequence[Token]) -> Expression:
        """A side as tree."""
        parser = AnswerParser(
            self.source, side, self.vocabulary, self._quantity, self.targets.single, self._table
        )
        node = parser.side()
        try:
            return worked_out(node, parser.others)
        except NoValue as problem:
            self.source.fail(problem.problem, (problem.node or node).span)

    def _table(self, name: str, span: Span) -> Matrix | None:
        """The entries of a vector or matrix, each with its name."""
        ring, symbols = self.setting.ring, self.vocabulary.vectors.get(name)
        if symbols is not None:
            return Matrix(tuple((Named(x, ring[x], span=span),) for x in symbols), span=span)
        table = self.targets.tables.get("v" if name == "V" else name)
        if table is None:
            return None
        return Matrix(
            tuple(
                tuple(Named(_entry_label(name, x), self._value_of(x), span=span) for x in row)
                for row in table
            ),
            span=span,
        )

    def value(self, node: Expression) -> Trig:
        """A tree as polynomial."""
        return PolynomialReader(self.source, self.setting.ring).read(node)

    def _quantity(self, name: str) -> Trig | None:
        if name in self.replaced:
            return self.replaced[name]
        if name not in self.targets.single:
            return None
        return self._value_of(self.targets.single[name])

    def _value_of(self, target: AskedQuantity) -> Trig:
        return self.setting.zero if target.idle else target.compute()

    def _claim(self, label: str, target: AskedQuantity, node: Expression) -> Claim:
        """What a tree says of a quantity."""
        used = tuple(uses(node, self.targets.single, self.vocabulary))
        return Claim(label, target, node, self.value(node), self.source, used)

    def definitions(self, line: Line, lines: Sequence[Line]) -> list[Line]:
        """The line, if it introduces a name of the user's own, or an h that other lines use: its
        value is noted."""
        name = (
            line[0][0].text
            if len(line) == 2 and len(line[0]) == 1 and line[0][0].kind == "name"
            else ""
        )
        if not name or (
            name in self.targets.names
            and not self._is_own_h(name, line, lines)
            and not self._is_own_number(name, line, lines)
            and not self._is_own_scalar(name, line)
        ):
            return []
        if name in self.vocabulary.waves or name in self.setting.zeros or not self._is_free(name):
            self.source.fail(
                f"{self.source[line[0][0].span]} is a symbol of the model, not a result to be "
                f"checked",
                line[0][0].span,
            )
        node = self.parse(line[1])
        given = tuple(use.target for use in uses(node, self.targets.single, self.vocabulary))
        self.vocabulary.define(name, self.value(node), given)
        return [line]

    def _is_free(self, name: str) -> bool:
        """Whether a name stands for nothing of the model: for nothing, or for what only other
        models have."""
        if name in self.setting.foreign:
            return True
        return self.vocabulary.symbols.get(name, self.setting.zero).is_zero

    def _is_own_number(self, name: str, line: Line, lines: Sequence[Line]) -> bool:
        """Whether a letter that some books have for one of the quantities stands for something of
        the user's own: one number for a matrix or vector, or what other lines use and has other
        units."""
        letter = re.sub(r"\d+$", "", name)
        if not (letter in AMBIGUOUS or name in self.targets.soft) or self._is_matrix(line[1]):
            return False
        target = self.targets.single.get(name)
        if target is None:
            return name in AMBIGUOUS
        return self._is_used(name, line, lines) and is_of_another_kind(
            self.setting, self.value(self.parse(line[1])), target.compute()
        )

    def _is_own_scalar(self, name: str, line: Line) -> bool:
        """Whether a name of a body's vector is given to one number."""
        if name not in self.targets.soft or name in self.targets.single:
            return False
        return not isinstance(self.parse(line[1]), Matrix)

    def _is_matrix(self, side: Sequence[Token]) -> bool:
        return side[0].kind == "begin" or side[0].text == "["

    def _is_own_h(self, name: str, line: Line, lines: Sequence[Line]) -> bool:
        """Whether a line defines a velocity coefficient that other lines are written with."""
        if self.targets.single.get(name) is None or self.targets.single[name].family != "h":
            return False
        return self._is_used(name, line, lines)

    def _is_used(self, name: str, line: Line, lines: Sequence[Line]) -> bool:
        """Whether another line is written with a name, not merely about it."""
        return any(
            t.kind == "name" and t.text == name
            for other in lines
            if other != line
            for side in (other if len(other[0]) > 1 else other[1:])
            for t in side
        )

    def claims(self, line: Line, before: Sequence[Claim]) -> list[Claim]:
        """What one equation states, after others."""
        subjects = [self._subject(side) for side in line]
        named = [subject for subject in subjects if subject is not None]
        if not named or len(line) < 2:
            return self._implicit(line, before)
        other = [side for side, subject in zip(line, subjects, strict=True) if subject is None]
        if not other:
            named, other = named[:1], list(line[1:])
        found = []
        for side in other:
            node = self.parse(side)
            for subject in named:
                found += self._pairs(subject, node)
        return found

    def _subject(self, side: Sequence[Token]) -> Token | Named | Matrix | None:
        """The quantity, the derivative of one, or the vector or matrix of quantities that a side
        is, if it is one alone."""
        if len(side) == 1 and side[0].kind == "name" and side[0].text in self.targets.names:
            return side[0]
        first = side[0]
        if first.kind != "partial" and not self._is_matrix(side):
            return None
        node = self.parse(side)
        if isinstance(node, Matrix):
            return node if all(self._is_quantity(x) for row in node.rows for x in row) else None
        return node if isinstance(node, Named) and self._is_quantity(node) else None

    def _is_quantity(self, node: Expression) -> bool:
        """Whether a node is a quantity by name, or a derivative."""
        if not isinstance(node, Named):
            return False
        return node.is_derivative or (
            node.name in self.targets.single and node.name not in self.vocabulary.symbols
        )

    def _pairs(self, name: Token | Named | Matrix, node: Expression) -> list[Claim]:
        """The claims of name = node, entry by entry where it is a vector or matrix."""
        label = self.source[name.span]
        if isinstance(name, Matrix):
            return self._entry_by_entry(name, node)
        if isinstance(name, Named):
            derivative = AskedQuantity("derivative", (), lambda: name.value)
            asked = derivative if name.is_derivative else self.targets.single[name.name]
            return [self._claim(label, asked, node)]
        single, table = self.targets.single.get(name.text), self.targets.tables.get(name.text)
        if not isinstance(node, Matrix):
            if single is None:
                self.source.fail(
                    f"{label} is a vector or matrix: write it as [[…, …], […, …]]", name.span
                )
            return [self._claim(label, single, node)]
        if name.text == "V" and len(node.rows) * len(node.rows[0]) > 1:
            table = self.targets.tables["v"]  # the potential energy is no vector
        if table is None and single is not None:
            table = [[single]]
        return self._entries(label, node, table or [])

    def _entry_by_entry(self, named: Matrix, node: Expression) -> list[Claim]:
        """The claims of [τ1; τ2] = node."""
        if not isinstance(node, Matrix) or [len(x) for x in node.rows] != [
            len(x) for x in named.rows
        ]:
            self.source.fail(
                "the sides of this equation have not as many entries as each other", named.span
            )
        pairs = zip(named.rows, node.rows, strict=True)
        return [
            claim
            for names, row in pairs
            for name, x in zip(names, row, strict=True)
            if isinstance(name, Named)
            for claim in self._pairs(name, x)
        ]

    def _entries(self, label: str, node: Matrix, table: list[list[AskedQuantity]]) -> list[Claim]:
        rows = [list(row) for row in node.rows]
        if len(rows) == 1 and table and len(table[0]) == 1:
            rows = [[entry] for entry in rows[0]]  # a vector written as a row
        if label == "J" and len(rows) < len(table):
            table = table[: len(rows)]
        if [len(row) for row in table] == [1] and len(rows) * len(rows[0]) > 1:
            self.source.fail(f"{label} is one number, not a vector or matrix", node.span)
        if [len(r) for r in rows] != [len(r) for r in table]:
            size = f"{len(table)} × {len(table[0])}"
            self.source.fail(f"{label} has {size} entries here", node.span)
        return [
            self._claim(_entry_label(label, target), target, entry)
            for row, targets in zip(rows, table, strict=True)
            for entry, target in zip(row, targets, strict=True)
        ]

    # ------------------------------------------------------------ torques inside an equation
    def _implicit(self, line: Line, before: Sequence[Claim]) -> list[Claim]:
        """An equation that holds one τ_i somewhere, solved for it; without any, that of a passive
        joint."""
        span = (line[0][0].start, line[-1][-1].end)
        inside = {
            t.text
            for side in line
            for t in side
            if t.kind == "name" and t.text in self.targets.single
        }
        inside -= set(self.vocabulary.symbols)
        torques = {
            self.targets.single[name]
            for name in inside
            if self.targets.single[name].family == "tau"
        }
        torques = {target for target in torques if not target.idle}
        if len(line) == 2 and not torques and self.targets.passive:
            return [self._unpowered(line, before)]
        if len(line) != 2 or len(torques) != 1:
            self.source.fail(
                "neither side is one of the quantities that are checked",
                span,
                "These are tau1, H12 or M12, c1, g1 or G1, J11, T, V, x and y.",
            )
        (target,) = torques
        name = next(name for name in sorted(inside) if self.targets.single[name] == target)
        rest, slope = self._solved(line, target)
        if slope is None:
            self.source.fail(f"this equation cannot be solved for {name}", span)
        node = Named(name, rest / -slope, span=span)
        nodes = map(self.parse, line)
        used = [use for side in nodes for use in uses(side, self.targets.single, self.vocabulary)]
        used = [use for use in used if use.target != target]
        return [Claim(name, target, node, rest / -slope, self.source, tuple(used))]

    def _unpowered(self, line: Line, before: Sequence[Claim]) -> Claim:
        """An equation without torque: that of a joint which nothing drives."""
        left, right = map(self.parse, line)
        values = self.value(left), self.value(right)
        node: Expression = Sum((left, Negative(right, span=right.span)), span=around(left, right))
        for side, value in ((right, values[0]), (left, values[1])):
            if value.is_zero:
                node = side
        taken = [
            claim.target.index
            for claim in before
            if claim.target.family == "0" or claim.target.idle
        ]
        target = undriven_joints.equation(self.targets, self.value(node), taken)
        return self._claim(f"The equation of joint {target.index[0]}", target, node)

    def _solved(self, line: Line, target: AskedQuantity) -> tuple[Trig, Trig | None]:
        """a and k of a + k τ = 0; k None where it is no number."""
        values = []
        for k in range(3):
            self.replaced = {
                name: self.setting.zero + k
                for name, other in self.targets.single.items()
                if other == target
            }
            left, right = (self.value(self.parse(side)) for side in line)
            values.append(left - right)
        self.replaced = {}
        slope = values[1] - values[0]
        linear = slope.is_constant and not slope.is_zero and slope == values[2] - values[1]
        return values[0], slope if linear else None


def _entry_label(label: str, target: AskedQuantity) -> str:
    """c of joint 2 is c2; the second entry of vc1 is vc1y."""
    return label + (target.axis or "".join(map(str, target.index)))
