"""Reading claims from an answer's lines: the quantity that each is about, and the expression given
for it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import Literal

from freebody.expressions.grammar.atoms import atom
from freebody.expressions.grammar.lexer import Token
from freebody.expressions.nodes import Expression, Matrix, Number, nodes
from freebody.expressions.quantities import kinds
from freebody.scalars.generators import generators_in
from freebody_textbook.check.algebra.quotients import Named, Value, difference, generator, pair
from freebody_textbook.check.algebra.tables_in_formulas import TableShape
from freebody_textbook.check.asked.quantity import INVERSE, AskedQuantity
from freebody_textbook.check.claims.formula_reader import all_right, entry_label
from freebody_textbook.check.claims.own_definitions import OwnDefinitions
from freebody_textbook.check.claims.unnamed_equations import UnnamedEquations
from freebody_textbook.check.numbers.units_of_symbols import unit_of_quantity
from freebody_textbook.check.reading.answer_lines import AnswerLine
from freebody_textbook.check.reading.claim import Claim, uses
from freebody_textbook.check.reading.reading import power_behind, turn_behind
from freebody_textbook.check.states.state_values import functions_of
from freebody_textbook.check.verdicts.rounded_numbers import half_a_unit

_EXACT = 1e-12
"""The share by which floating point may be off."""
_LOADED = "Write tau1 = …, with F_x and F_y at the tip, or F along the one slide."
_ACROSS = "a component that a plane does not have"


class ClaimReader(OwnDefinitions, UnnamedEquations):
    """Reads claims from an answer's lines."""

    def claims(self, line: AnswerLine, before: Sequence[Claim]) -> list[Claim]:
        """The claims of one equation; before: the claims of earlier lines."""
        found = self._claims(line, before)
        by_loops = self.is_loaded and self.setting.system is not None
        if by_loops and not all(claim.target.acting for claim in found):
            self.source.fail(
                "of closed chains only torques are read under a force", line.span, _LOADED
            )
        return found

    def _claims(self, line: AnswerLine, before: Sequence[Claim]) -> list[Claim]:
        """The claims of one equation, without regard to a load on the robot."""
        self.of_bodies = self.is_about_bodies(line)
        self.begin(line)
        self._refuse_motion(line)
        if self._restates_a_parameter(line):
            return []
        if self.is_of_angles(line):
            return [self.of_angles(line)]
        if self.is_solved(line):
            return [self.solved_for(line)]
        subjects = [self._subject(side) for side in line]
        named = [subject for subject in subjects if subject is not None]
        if not named or len(line) < 2:
            return self.unnamed(line, before)
        if not self.setting.is_free_body and any(map(self._is_of_joints, named)):
            self.of_bodies = False
        named, other = self._parted(line, subjects, named)
        found = []
        for side in other:
            if self._closes(named[0], side, len(other)):
                continue
            stated = partial(self._stated, named, side, any(map(self.is_matrix, other)))
            whole = [*(x for x in named if isinstance(x, Token)), *side]
            found += self.in_some_axes(whole, stated)
        return found

    def _parted(
        self,
        line: AnswerLine,
        subjects: Sequence[Token | Named | Matrix | None],
        named: list[Token | Named | Matrix],
    ) -> tuple[list[Token | Named | Matrix], list[Sequence[Token]]]:
        """The quantities that a line is about, and the sides that give their values."""
        other: list[Sequence[Token]] = [
            side for side, subject in zip(line, subjects, strict=True) if subject is None
        ]
        given = {x.text for side in other for x in side if x.kind == "name"}
        for subject in named[1:]:  # F1 = τ1 + m1 g·v = τ1: given by τ1, not about it
            if isinstance(subject, Token) and (
                subject.text in given or self._has_own_axes(subject.text)
            ):
                named.remove(subject)
                other.append((subject,))
        if not other:
            named, other = named[:1], list(line[1:])
        return named, other

    def _refuse_motion(self, line: AnswerLine) -> None:
        """Raise an error if a line mixes motion with virtual displacements: these are read as
        rates, so that terms without work along the motion would vanish."""
        variations = self.vocabulary.variations
        if variations.isdisjoint(token.start for token in line.names):
            return
        for token in line.names:
            if token.start not in variations and self._is_moving(token):
                self.source.fail(
                    "beside virtual displacements stands what has rates in it, which is not read",
                    token.span,
                    "Write the equation of motion, or the power with rates, tau1*dtheta1 = dE/dt.",
                )

    def _is_moving(self, token: Token) -> bool:
        """Whether the value of a name contains rates or accelerations."""
        node = self.parse((token,))
        return any(_rates(x.value) != "none" for x in nodes(node) if isinstance(x, Named))

    def _restates_a_parameter(self, line: AnswerLine) -> bool:
        """Whether a line only repeats a parameter's value, such as let g = 9.81 m/s²; nothing is
        checked then."""
        name = generator(self.vocabulary.symbols.get(line.subject, self.setting.zero))
        value = self.setting.symbols.model.parameters.get(name or "")
        if len(line) != 2 or value is None or line.written_with:
            return False
        node = self.parse(line[1])
        written = self.numbers.of(node.span)
        if not isinstance(node, Number):
            return False
        factor = written.unit.factor if written is not None and written.unit else 1.0
        half = half_a_unit(self.source.plain(node.span), node.value)
        if abs(float(node.value) * factor - value) > float(half) * factor + _EXACT * abs(value):
            return False
        self.told.append(node.span)
        return True

    def _stated(
        self, named: Sequence[Token | Named | Matrix], side: Sequence[Token], as_vector: bool
    ) -> list[Claim]:
        """The claims that each quantity named equals a side; as_vector: another side is a vector
        with its entries."""
        node = self.parse(side, self._shape_of(named[0], as_vector))
        return [claim for subject in named for claim in self._pairs(subject, node)]

    def _has_own_axes(self, name: str) -> bool:
        """Whether a name is a vector in its own body's axes: in ω3 = ω2 = [...] the entries are
        those of ω3."""
        table = self.targets.tables.get(name)
        return table is not None and table[0][0].in_world is not None

    def _closes(self, subject: Token | Named | Matrix, side: Sequence[Token], count: int) -> bool:
        """Whether a side is the 0 of Φ1 = … = 0, which states that the loop is closed, or of det J
        = … = 0, a condition for singular poses."""
        if not isinstance(subject, Token):
            return False
        asked = self.asked(subject.text)
        own = asked is not None and asked.kind.may_be_zero
        return own and count > 1 and len(side) == 1 and side[0].text == "0"

    def _is_of_joints(self, subject: Token | Named | Matrix) -> bool:
        """Whether a subject is a whole vector or matrix of the equations of motion, in which g is
        the gravity vector; elsewhere g is the gravitational acceleration."""
        own = isinstance(subject, Token) and subject.text in self.vocabulary.told
        if not isinstance(subject, Token) or subject.text in self.targets.single or own:
            return False
        kind = self.targets.tables[subject.text][0][0].kind
        return kind.of == "joints" and kind.tells != "weight"

    def _shape_of(self, subject: Token | Named | Matrix, as_vector: bool) -> TableShape | None:
        """The shape of a subject that must be a vector or matrix; None if it may be a scalar."""
        if isinstance(subject, Matrix):
            return len(subject.rows), len(subject.rows[0])
        if isinstance(subject, Named) or (subject.text in self.targets.single and not as_vector):
            return None
        table = self.targets.tables.get(subject.text)
        if (own := self.vocabulary.matrices.get(subject.text)) is not None:
            return len(own.rows), len(own.rows[0])
        return None if table is None else (len(table), len(table[0]))

    def _subject(self, side: Sequence[Token]) -> Token | Named | Matrix | None:
        """The quantity, its derivative, or the vector or matrix of quantities that makes up a whole
        side; None if the side is anything else."""
        if len(side) == 1 and side[0].text in self.vocabulary.told:
            return side[0]
        if len(side) == 1 and side[0].kind == "name" and side[0].text in self.targets.names:
            return None if self.is_own(side[0].text) else side[0]
        first = side[0]
        name = first.text + INVERSE
        if name in self.targets.tables and power_behind(side[1:], -1) == len(side) - 1 > 0:
            return replace(first, text=name, end=side[-1].end)
        turn, behind = turn_behind(first.text, side[1:])
        if turn in self.targets.tables and behind == len(side) - 1:
            return replace(first, text=turn, end=side[-1].end)
        if first.kind != "partial" and not self.is_matrix(side):
            return None
        node = self.parse(side)
        if isinstance(node, Matrix):
            return node if all(self._is_quantity(x) for row in node.rows for x in row) else None
        return node if isinstance(node, Named) and self._is_quantity(node) else None

    def _is_quantity(self, node: Expression) -> bool:
        """Whether a node is a named quantity or a derivative."""
        if not isinstance(node, Named):
            return False
        return node.is_derivative or (
            node.name in self.targets.single and node.name not in self.vocabulary.symbols
        )

    def _pairs(self, name: Token | Named | Matrix, node: Expression) -> list[Claim]:
        """The claims of an equation name = node, entry by entry for vectors and matrices."""
        label = self.source[name.span]
        if isinstance(name, Matrix):
            return self._entry_by_entry(name, node)
        if isinstance(name, Named):
            derivative = AskedQuantity(kinds.DERIVATIVE, (), lambda: name.value)
            asked = derivative if name.is_derivative else self.targets.single[name.name]
            return [self.claim(label, asked, node)]
        if name.text in self.vocabulary.told:
            return self._of_own_name(name, label, node)
        single, table = self.targets.single.get(name.text), self.targets.tables.get(name.text)
        single = self._meant(name.text, single, node)
        node = self._zeros(name.text, table, node)
        if table and [len(row) for row in table] == [1] and single is None:
            node = node if isinstance(node, Matrix) else Matrix(((node,),), span=node.span)
        if not isinstance(node, Matrix):
            if single is None:
                self.source.fail(
                    f"{label} is a vector or matrix: write it as [[…, …], […, …]]", name.span
                )
            return [self.claim(label, single, node)]
        if table is None and single is not None:
            table = [[single]]
        if (of_bodies := self._table_of_bodies(name.text, node)) is not None:
            table = of_bodies
        return self._entries(label, node, table or [])

    def _zeros(
        self, name: str, table: Sequence[Sequence[AskedQuantity]] | None, node: Expression
    ) -> Expression:
        """A vector of zeros if the node is a plain 0 and a vector is required; otherwise the
        node."""
        if not (isinstance(node, Number) and table and self.may_be_vector(name, node)):
            return node
        return node if node.value else Matrix(((node,),) * len(table), span=node.span)

    def _of_own_name(self, name: Token, label: str, node: Expression) -> list[Claim]:
        """The claims about a user's own name that stands for an expression of quantities, given by
        several expressions."""
        matrix = self.vocabulary.matrices.get(name.text)
        if matrix is None:
            value = self.vocabulary.symbols[name.text]
            found = [self.claim(label, _own(lambda: value), node)]
        else:
            node = node if isinstance(node, Matrix) else Matrix(((node,),), span=node.span)
            rows = [list(map(self.quotient, row)) for row in matrix.rows]
            table = [
                [_own(lambda x=x: x, *(i, j)[: 1 + (len(row) > 1)]) for j, x in enumerate(row, 1)]
                for i, row in enumerate(rows, 1)
            ]
            found = self._entries(label, node, table)
        used = {use.target for use in uses(node, self.targets.single, self.vocabulary)}
        if used.issuperset(self.vocabulary.uses[name.text]) and all_right(found):
            self.source.fail(f"this says only what {label} stands for", node.span)
        return found

    def _meant(
        self, name: str, single: AskedQuantity | None, node: Expression
    ) -> AskedQuantity | None:
        """The quantity meant by a name that two share, such as the potential energy and the power
        P: the one whose unit, value or rates fit the answer."""
        other = self.targets.namesakes.get(name)
        if other is None or isinstance(node, Matrix) or functions_of(node):
            return single
        value, written = self.quotient(node), self.numbers.of(node.span)
        if written is not None and written.unit is not None:
            needed = unit_of_quantity(self.setting, other, value)
            return other if written.unit.dimension == needed else single
        if single is not None and difference(value, single.compute()).is_zero:
            return single
        return other if _rates(value) in other.kind.rates else single

    def _table_of_bodies(self, name: str, node: Matrix) -> list[list[AskedQuantity]] | None:
        """The vector that a name stands for in equations of bodies if the given side shows it: g =
        [0; -g] is the gravitational acceleration, not the torques of gravity."""
        table = self.targets.tables.get(self.targets.of_bodies.get(name, ""), [])
        right = [x for row in table for x in row]
        given = [x for row in node.rows for x in row]
        if not right or len(given) != len(right):
            return None
        pairs = zip(given, right, strict=True)
        same = all(difference(self.quotient(x), y.compute()).is_zero for x, y in pairs)
        return table if same else None

    def _entry_by_entry(self, named: Matrix, node: Expression) -> list[Claim]:
        """The claims of an equation such as [τ1; τ2] = node, one for each entry."""
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

    def _in_space(self, table: list[list[AskedQuantity]]) -> list[list[AskedQuantity]]:
        """A planar vector or Jacobian extended by its rows of zeros in space."""
        none = AskedQuantity(kinds.OF_BODY, (), lambda: self.setting.zero, words=_ACROSS)
        across = [none] * len(table[0])
        rows = [*table, across] if len(table) == 2 else [across, across, *table]
        if len(across) == 1:
            return [[replace(x, axis=k)] for k, (x,) in zip("xyz", rows, strict=True)]
        return [
            [replace(x, index=(i, j)) for j, x in enumerate(row, 1)]
            for i, row in enumerate(rows, 1)
        ]

    def _entries(self, label: str, node: Matrix, table: list[list[AskedQuantity]]) -> list[Claim]:
        rows = [list(row) for row in node.rows]
        if len(rows) == 1 and table and len(table[0]) == 1:
            rows = [[entry] for entry in rows[0]]  # a vector written as a row
        if self.setting.is_planar and len(rows) == 3 and _is_of_body(table):
            table = self._in_space(table)
        if table and table[0][0].kind.has_rows_of_tip and len(rows) < len(table):
            table = table[: len(rows)]
        if [len(row) for row in table] == [1] and len(rows) * len(rows[0]) > 1:
            self.source.fail(f"{label} is one number, not a vector or matrix", node.span)
        if [len(r) for r in rows] != [len(r) for r in table]:
            size = f"{len(table)} × {len(table[0])}"
            self.source.fail(f"{label} has {size} entries here", node.span)
        return [
            self.claim(entry_label(label, target), self.in_axes(target), entry)
            for row, targets in zip(rows, table, strict=True)
            for entry, target in zip(row, targets, strict=True)
        ]


def _own(value: Callable[[], Value], *index: int) -> AskedQuantity:
    """A quantity made of a user's own name, or of an entry of it."""
    return AskedQuantity(kinds.OWN, index, value, words="as the name is explained")


def _rates(value: Value) -> Literal["one", "some", "none"]:
    """Number of rates in each term of a value: one in every term, some, or none."""
    above, below = pair(value)
    terms = [[(atom(x).dots, k) for x, k in p.items() if atom(x).dots] for p, _ in above.terms()]
    if below.is_constant and terms and all(row == [(1, 1)] for row in terms):
        return "one"
    return "some" if any(atom(x).dots for x in generators_in(above, below)) else "none"


def _is_of_body(table: list[list[AskedQuantity]]) -> bool:
    """Whether a table of quantities is a planar vector, a Jacobian of one, or an angular one, which
    has a single row."""
    return len(table) < 3 and all(x.kind.of == "bodies" for row in table for x in row)
