"""What the lines of an answer state: which quantity each is about, and the expression given for
it."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace

from freebody.derivations.check import undriven_joints
from freebody.derivations.check.answer_lines import Line
from freebody.derivations.check.answer_text import AnswerText
from freebody.derivations.check.answer_tree import Named, Wave
from freebody.derivations.check.asked.quantity import INVERSE, AskedQuantity
from freebody.derivations.check.asked_quantities import AMBIGUOUS, Targets
from freebody.derivations.check.circular_answers import (
    GivenQuantity,
    refuse_itself,
    uses,
)
from freebody.derivations.check.dotted_names import spellings
from freebody.derivations.check.exact_polynomials import PolynomialReader
from freebody.derivations.check.quotients import Value, difference, pair
from freebody.derivations.check.reading import AnswerParser, inverse_behind
from freebody.derivations.check.tables_in_formulas import Shape, worked_out
from freebody.derivations.check.units import is_of_another_kind
from freebody.derivations.check.vocabulary import Vocabulary
from freebody.derivations.closed_chains.linear import Ratio
from freebody.derivations.expressions.evaluate import NoValue
from freebody.derivations.expressions.nodes import Expression, Matrix, Negative, Number, Sum, nodes
from freebody.derivations.grammar.lexer import Token
from freebody.derivations.grammar.parser import around
from freebody.derivations.grammar.source import Span
from freebody.derivations.polynomials.symbols import RATE, SECOND
from freebody.scalars.trig import Trig

_LONGEST_LABEL = 60
_BY_FORMULA = (
    "Parameters that formulas give, as lc = l/2 of uniform bars, stand below [parameters] in a "
    "notation of your own: --notation FILE.toml, notation='FILE.toml'."
)


@dataclass(frozen=True)
class Claim:
    """label = what the user says it is."""

    label: str
    target: AskedQuantity
    node: Expression
    value: Value
    source: AnswerText
    uses: tuple[GivenQuantity, ...] = ()
    """Quantities that it is given by."""
    whole: Expression | None = None
    """Of an equation between two sides their difference."""


class ClaimReader:
    """Lines into claims."""

    def __init__(self, source: AnswerText, vocabulary: Vocabulary, targets: Targets):
        self.source, self.vocabulary, self.targets = source, vocabulary, targets
        self.setting = vocabulary.setting
        self.replaced: dict[str, Trig] = {}
        self.letters_of_vectors: frozenset[str] = frozenset()
        """Letters such as v that other lines give as vectors: v1 = 0 is one too."""
        self.of_bodies = False
        """Whether the line is about bodies, so that g is the gravitational acceleration and J that
        of the tip's position; else they are what stands in the equations of motion."""

    def parse(self, side: Sequence[Token], shape: Shape | None = None) -> Expression:
        """A side as tree; shape: of the vector that it must be."""
        parser = AnswerParser(
            self.source, side, self.vocabulary, self._quantity, self.targets.single, self._table
        )
        node = parser.side()
        try:
            return worked_out(node, parser.others, shape)
        except NoValue as problem:
            self.source.fail(problem.problem, (problem.node or node).span)

    def _table(self, name: str, span: Span) -> Matrix | None:
        """The entries of a vector or matrix, each with its name."""
        meant = _OF_BODIES.get(name, name) if self.of_bodies else name
        table = self.targets.tables.get(meant)
        if table is None:
            return None
        return Matrix(
            tuple(
                tuple(Named(_entry_label(meant, x), self._value_of(x), span=span) for x in row)
                for row in table
            ),
            span=span,
        )

    def says_that_the_base_moves(self, line: Line) -> bool:
        """Whether it is v̇0 = -g: gravity as an acceleration of the base."""
        first = line[0]
        if len(first) != 1 or first[0].text not in spellings("v", "0", 1) or len(line) != 2:
            return False
        self.of_bodies = True
        gravity = self._table("gravity", first[0].span)
        node = self.parse(line[1], gravity and (len(gravity.rows), 1))
        if gravity is None or not isinstance(node, Matrix):
            return False
        pairs = zip(_entries_of(gravity), _entries_of(node), strict=False)
        return all((self.value(x) + self.value(y)).is_zero for x, y in pairs)

    def value(self, node: Expression) -> Trig:
        """A tree as polynomial."""
        return PolynomialReader(self.source, self.setting.ring).read(node)

    def quotient(self, node: Expression) -> Value:
        """A tree as polynomial, or as quotient of two."""
        return PolynomialReader(self.source, self.setting.ring).quotient(node)

    def _quantity(self, name: str) -> Value | None:
        if name in self.replaced:
            return self.replaced[name]
        if name not in self.targets.single:
            return None
        return self._value_of(self.targets.single[name])

    def _value_of(self, target: AskedQuantity) -> Value:
        return self.setting.zero if target.idle else target.compute()

    def _claim(self, label: str, target: AskedQuantity, node: Expression) -> Claim:
        """What a tree says of a quantity."""
        used = tuple(uses(node, self.targets.single, self.vocabulary))
        return Claim(label, target, node, self.quotient(node), self.source, used)

    def letters_given_as_vectors(self, lines: Sequence[Line]) -> frozenset[str]:
        """First letters of names of vectors that a line gives by its entries."""
        return frozenset(
            line[0][0].text[0]
            for line in lines
            if len(line[0]) == 1
            and line[0][0].text in self.targets.soft
            and any(self._is_matrix(side) for side in line[1:])
        )

    def definitions(self, line: Line, lines: Sequence[Line]) -> list[Line]:
        """The line, if it introduces a name of the user's own, or an h that other lines use: its
        value is noted."""
        first = line[0]
        name = first[0].text if len(first) == 1 and first[0].kind == "name" else ""
        if self._is_solved(line):
            return []
        if name in self.vocabulary.waves and self._is_wave(name, line):
            return [line]
        if not name or (
            name in self.targets.names
            and not self._is_own_h(name, line, lines)
            and not self._is_own_number(name, line, lines)
            and not self._is_own_scalar(name, line)
        ):
            return []
        if name in self.vocabulary.waves or name in self.setting.zeros or not self._is_free(name):
            self.source.fail(
                f"{self.source[first[0].span]} is a symbol of the model, not a result to be "
                f"checked",
                first[0].span,
                "" if name in self.vocabulary.waves else _BY_FORMULA,
            )
        node = self.parse(line[1])
        given = tuple(use.target for use in uses(node, self.targets.single, self.vocabulary))
        if self.targets.single.get(name) in given:
            refuse_itself(self.source, self.source[first[0].span], node.span)
        self.vocabulary.define(name, self.quotient(node), given)
        return [line]

    def _is_solved(self, line: Line) -> bool:
        """Whether a line tells a coordinate, a rate, an acceleration, or the sine or cosine of an
        angle by the robot's quantities: θ̈1 = (τ1 - …)/H11, cos θ2 = (x² + …)/(2 l1 l2)."""
        first = line[0][0]
        if len(line) != 2 or len(line[0]) != 1 or self._is_matrix(line[1]):
            return False
        names = {token.text for token in line[1] if token.kind == "name"}
        by_quantities = any(
            x in self.targets.names and x not in self.vocabulary.symbols for x in names
        )
        if first.text in self.vocabulary.waves:
            tip = (x for x in names if x in self.targets.single)
            return any(self.targets.single[x].family == "tip" for x in tip)
        if first.text in self.targets.single:
            return False
        if first.text in self.targets.tables and isinstance(self.parse(line[1]), Matrix):
            return False
        moving = self._moving(self.vocabulary.symbols.get(first.text))
        if self.setting.is_free_body:
            return bool(moving) and bool(names)
        return bool(moving) and (by_quantities or (moving.endswith(SECOND) and bool(names)))

    def _moving(self, value: Value | None) -> str:
        """The coordinate, rate or acceleration that a value is, or nothing."""
        terms = list(value.terms()) if isinstance(value, Trig) else []
        name = "".join(terms[0][0]) if len(terms) == 1 else ""
        known = {x + d for x in self.setting.symbols.coordinates for d in ("", RATE, SECOND)}
        if self.setting.is_free_body:
            known |= {
                x for x in self.setting.ring.names if x.startswith(("v_", "omega_", "f_", "n_"))
            }
        return name if name in known and terms[0] == ({name: 1}, 1) else ""

    def _solved_for(self, line: Line) -> Claim:
        """What a line says of a coordinate or of what belongs to it, by the robot's quantities."""
        first, node = line[0][0], self.parse(line[1])
        value = self.quotient(self.parse(line[0]))
        name = self._moving(value)
        for part in nodes(node):
            if not isinstance(part, Named) or part.name in self.targets.single:
                continue
            if name and any(name in p for x in pair(part.value) for p, _ in x.terms()):
                self.source.fail(
                    f"{self.source[first.span]} stands on both sides: solve for it", part.span
                )
        words = "solved for it by the robot's quantities"
        target = AskedQuantity("solved", (), lambda: value, words=words)
        return self._claim(self.source[first.span], target, node)

    def _is_wave(self, name: str, line: Line) -> bool:
        """Whether a line says of s12 or c12 only what it stands for anyway."""
        node = self.parse(line[1])
        if isinstance(node, Matrix):
            return False
        meant = Wave(*self.vocabulary.waves[name], span=line[0][0].span)
        return difference(self.quotient(node), self.value(meant)).is_zero

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
        soft = letter in AMBIGUOUS or name in self.targets.soft
        if not (soft or letter in _NO_QUOTIENTS) or self._is_matrix(line[1]):
            return False
        target = self.targets.single.get(name)
        if target is None:
            return name in AMBIGUOUS
        if isinstance(self._given(line[1]), Ratio):
            return True
        if not soft:
            return False
        if not self._is_used(name, line, lines):
            return False
        node = self.parse(line[1])
        return not isinstance(node, Matrix) and is_of_another_kind(
            self.setting, self.value(node), target.polynomial()
        )

    def _given(self, side: Sequence[Token]) -> Value | None:
        """The value of a side that is no vector or matrix."""
        node = self.parse(side)
        return None if isinstance(node, Matrix) else self.quotient(node)

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
        self.of_bodies = self.setting.is_free_body or any(
            self._tells_of_bodies(token) for side in line for token in side
        )
        if self._is_solved(line):
            return [self._solved_for(line)]
        subjects = [self._subject(side) for side in line]
        named = [subject for subject in subjects if subject is not None]
        if not named or len(line) < 2:
            return self._implicit(line, before)
        if not self.setting.is_free_body and any(map(self._is_of_joints, named)):
            self.of_bodies = False
        other = [side for side, subject in zip(line, subjects, strict=True) if subject is None]
        if not other:
            named, other = named[:1], list(line[1:])
        found = []
        for side in other:
            if self._closes(named[0], side, len(other)):
                continue
            node = self.parse(side, self._shape_of(named[0]))
            for subject in named:
                found += self._pairs(subject, node)
        return found

    def _closes(self, subject: Token | Named | Matrix, side: Sequence[Token], count: int) -> bool:
        """Whether a side is the 0 of Φ1 = … = 0, which says that the loop is closed."""
        own = isinstance(subject, Token) and subject.text.startswith("Phi")
        return own and count > 1 and len(side) == 1 and side[0].text == "0"

    def _tells_of_bodies(self, token: Token) -> bool:
        """Whether a name is that of a vector of a body or the tip, or of an energy."""
        if token.kind != "name" or token.text in self.vocabulary.symbols:
            return False
        single = self.targets.single.get(token.text)
        if single is not None:
            return single.family in _BODY_FAMILIES
        if token.text in self.vocabulary.waves:
            return False
        table = self.targets.tables.get(token.text)
        return table is not None and table[0][0].family in _BODY_FAMILIES

    def _is_of_joints(self, subject: Token | Named | Matrix) -> bool:
        """Whether it is a whole vector or matrix of the equations of motion, in which g is too."""
        if not isinstance(subject, Token) or subject.text in self.targets.single:
            return False
        family = self.targets.tables[subject.text][0][0].family
        return family != "q" and family not in _BODY_FAMILIES

    def _shape_of(self, subject: Token | Named | Matrix) -> Shape | None:
        """The shape of a vector or matrix that cannot be one number."""
        if isinstance(subject, Matrix):
            return len(subject.rows), len(subject.rows[0])
        if isinstance(subject, Named) or subject.text in self.targets.single:
            return None
        table = self.targets.tables[subject.text]
        return len(table), len(table[0])

    def _subject(self, side: Sequence[Token]) -> Token | Named | Matrix | None:
        """The quantity, the derivative of one, or the vector or matrix of quantities that a side
        is, if it is one alone."""
        if len(side) == 1 and side[0].kind == "name" and side[0].text in self.targets.names:
            return side[0]
        first = side[0]
        name = first.text + INVERSE
        if name in self.targets.tables and inverse_behind(side[1:]) == len(side) - 1 > 0:
            return replace(first, text=name, end=side[-1].end)
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
        if isinstance(node, Number) and table and name.text[0] in self.letters_of_vectors:
            zeros = tuple((replace(node),) for _ in table)
            node = Matrix(zeros, span=node.span) if node.value == 0 else node
        if not isinstance(node, Matrix):
            if single is None:
                self.source.fail(
                    f"{label} is a vector or matrix: write it as [[…, …], […, …]]", name.span
                )
            return [self._claim(label, single, node)]
        if table is None and single is not None:
            table = [[single]]
        return self._entries(label, node, table or [])

    def _entry_by_entry(self, named: Matrix, node: Expression) -> list[Claim]:
        """The claims of [τ1; τ2] = node."""
        if not isinstance(node, Matrix) or [len(x) for x in node.rows] != [
            len(x) for x in named.rows
        ]:
            self.source.fail(
                "the sides of this equation have different numbers of entries", named.span
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
        if self.setting.is_free_body:
            return self._identities(line)
        if len(line) == 2 and not torques and self.setting.system is not None:
            closing = self._closing(line)
            if closing is not None:
                return [closing]
        if len(line) == 2 and not torques and self.targets.passive:
            return [self._unpowered(line, before)]
        if (len(line) != 2 or len(torques) != 1) and self.of_bodies:
            return self._identities(line)
        if len(line) != 2 or len(torques) != 1:
            self.source.fail(
                "neither side is one of the quantities that are checked",
                span,
                "These are tau1, H12 or M12, c1, g1 or G1, J11, T, V, x and y.",
            )
        (target,) = torques
        name = next(name for name in sorted(inside) if self.targets.single[name] == target)
        if any(isinstance(x, Matrix) for x in map(self.parse, line)):
            return self._identities(line)
        rest, slope = self._solved(line, target)
        if slope is None:
            self.source.fail(f"this equation cannot be solved for {name}", span)
        node = Named(name, rest / -slope, span=span)
        nodes = map(self.parse, line)
        used = [use for side in nodes for use in uses(side, self.targets.single, self.vocabulary)]
        used = [use for use in used if use.target != target]
        return [Claim(name, target, node, rest / -slope, self.source, tuple(used))]

    def _closing(self, line: Line) -> Claim | None:
        """A loop equation without its name, l1 c1 + l2 c12 - d - l3 c3 = 0, with either sign; None
        of an equation in which something moves or presses."""
        node, value = self._difference(line)
        rates = {x for names in self.setting.symbols.rates.items() for x in (names[0],)}
        used = {name for powers, _ in value.terms() for name in powers}
        moving = {name for name in used if name.endswith(("_d", "_dd")) or name.startswith("lam")}
        if moving or not rates or (self.setting.order.gravity or "") in used:
            return None
        loops = [x for x in self.targets.single.values() if x.family == "Phi"]
        signs = [(x, sign) for x in dict.fromkeys(loops) for sign in (1, -1)]
        target, sign = min(signs, key=lambda row: len(value * row[1] - row[0].polynomial()))
        if sign < 0:
            node = Negative(node, span=node.span)
        return self._claim(f"The loop equation {self.source[node.span]}", target, node)

    def _difference(self, line: Line) -> tuple[Expression, Trig]:
        """Left less right; where one is 0 the other, with its own sign."""
        left, right = map(self.parse, line)
        values = self.value(left), self.value(right)
        node: Expression = Sum((left, Negative(right, span=right.span)), span=around(left, right))
        for side, value in ((right, values[0]), (left, values[1])):
            if value.is_zero:
                node = side
        return node, self.value(node)

    def _identities(self, line: Line) -> list[Claim]:
        """An equation between quantities of bodies, f01 - f12 + m1 g = m1 v̇c1, entry by entry."""
        left, right = self.parse(line[0]), self.parse(line[1])
        if isinstance(left, Matrix) != isinstance(right, Matrix):
            table, k = (left, 1) if isinstance(left, Matrix) else (right, 0)
            assert isinstance(table, Matrix)
            fitting = self.parse(line[k], (len(table.rows), len(table.rows[0])))
            left, right = (left, fitting) if k else (fitting, right)
        span = (line[0][0].start, line[-1][-1].end)
        if len(line) != 2 or self.source[left.span] == self.source[right.span]:
            self.source.fail("this must be an equation between two different sides", span)
        pairs = zip(_entries_of(left), _entries_of(right), strict=False)
        if len(_entries_of(left)) != len(_entries_of(right)):
            self.source.fail("the sides have different numbers of entries", span)
        label = self.source[span]
        label = label if len(label) <= _LONGEST_LABEL else f"{label[:_LONGEST_LABEL]}…"
        return [self._identity(label, x, y) for x, y in pairs]

    def _identity(self, label: str, left: Expression, right: Expression) -> Claim:
        """One entry: the side that says more is compared with the other."""
        if isinstance(right, Number):
            left, right = right, left
        value = self.quotient(left)
        target = AskedQuantity("identity", (), lambda: value)
        used = uses(left, self.targets.single, self.vocabulary)
        known = any(isinstance(x, Named) for side in (left, right) for x in nodes(side))
        if not known and not list(used):
            self.source.fail("this says nothing about the robot", right.span)
        whole = Sum((left, Negative(right, span=right.span)), span=around(left, right))
        return Claim(label, target, right, self.quotient(right), self.source, whole=whole)

    def _unpowered(self, line: Line, before: Sequence[Claim]) -> Claim:
        """An equation without torque: that of a joint which nothing drives."""
        node, value = self._difference(line)
        taken = [
            claim.target.index
            for claim in before
            if claim.target.family == "0" or claim.target.idle
        ]
        target = undriven_joints.equation(self.targets, value, taken)
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


def _entries_of(node: Expression) -> list[Expression]:
    return [x for row in node.rows for x in row] if isinstance(node, Matrix) else [node]


_NO_QUOTIENTS = ("K", "gamma")
"""Letters of quantities that are no quotients, which name ratios in other lines."""
_OF_BODIES = {"g": "gravity", "J": "JP"}
"""What names stand for in equations of bodies."""
_BODY_FAMILIES = frozenset(("of body", "tip", "tip_d", "tip_dd", "T", "V", "L", "Ti", "Vi", "J_d"))
