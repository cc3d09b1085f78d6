"""Vectors and matrices in a formula such as M q̈ + C q̇ + g, multiplied out entry by entry: each
entry is an expression whose nodes keep their places in the text."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction

from freebody.expressions.evaluate import NoValue
from freebody.expressions.nodes import (
    Cross,
    Dot,
    Expression,
    Matrix,
    Negative,
    Number,
    Power,
    Product,
    Quotient,
    Span,
    Sum,
    Transposed,
    nodes,
)
from freebody_textbook.check.algebra.quotients import Named

MOST_INVERTED = 3
"""Rows of matrices whose inverses are written out."""
MOST_PIECES = 20_000
"""The most pieces of all entries together."""


TableShape = tuple[int, int]
"""The numbers of rows and columns."""


def worked_out(
    node: Expression, others: Mapping[Expression, Matrix], shape: TableShape | None = None
) -> Expression:
    """An expression with its vectors and matrices multiplied out, so that at most the whole is one.
    others: vectors or matrices that names may also stand for, used where nothing else fits. shape:
    of the required vector. Raises NoValue."""
    tables = _Tables(others)
    found = node
    if any(isinstance(x, Matrix | Transposed | Cross | Dot) for x in nodes(node)):
        found = tables.at(node)
    if shape is None or isinstance(found, Matrix):
        return found
    return tables.as_table(found, shape) or found


class _Tables:
    def __init__(self, others: Mapping[Expression, Matrix]):
        self.others = others
        self.made = 0

    def at(self, node: Expression) -> Expression:
        """The value of a node: a scalar expression, or a matrix of them; vectors are columns."""
        match node:
            case Matrix():
                return _each(node, self._scalar)
            case Sum():
                return self._sum(node)
            case Negative():
                return self._each(self.at(node.operand), lambda x: Negative(x, span=node.span))
            case Product():
                return self._product(node)
            case Quotient():
                below = self._scalar(node.below)
                return self._each(
                    self.at(node.above), lambda x: Quotient(x, self._new(below), span=node.span)
                )
            case Power():
                return self._power(node)
            case Transposed():
                return _transposed(self._table(node.operand))
            case Cross():
                return self._cross(node)
            case Dot():
                a, b = (_components(self._table(x)) for x in (node.left, node.right))
                if len(a) != len(b):
                    raise NoValue("vectors of different lengths have no product", node)
                return self._inner(a, b, node.span)
        return node.mapped(self._scalar)

    def _scalar(self, node: Expression) -> Expression:
        found = self.at(node)
        if isinstance(found, Matrix):
            raise NoValue("a vector or matrix stands where one expression is expected", node)
        return found

    def _table(self, node: Expression) -> Expression:
        """A node's value as a vector or matrix if it is or may be one, otherwise as a scalar
        expression."""
        found = self.at(node)
        return found if isinstance(found, Matrix) else self.as_table(found) or found

    def as_table(self, node: Expression, shape: TableShape | None = None) -> Matrix | None:
        """A scalar expression as a vector or matrix, if one of its factors may be one; a 0 becomes
        a vector of zeros."""
        match node:
            case Matrix():
                return node
            case Negative():
                inner = self.as_table(node.operand, shape)
                return inner and _each(inner, lambda x: Negative(x, span=node.span))
            case Quotient():
                inner = self.as_table(node.above, shape)
                return inner and _each(
                    inner, lambda x: Quotient(x, self._new(node.below), span=node.span)
                )
            case Sum():
                parts = [self.as_table(term, shape) for term in node.terms]
                tables = [part for part in parts if part is not None]
                if len(tables) < len(parts) or len({_shape(x) for x in tables}) != 1:
                    return None
                return self._added(tables, node)
            case Product():
                return self._scaled(node, shape)
            case Number() if node.value == 0 and shape:
                zero = tuple(replace(node) for _ in range(shape[1]))
                return Matrix(tuple(tuple(map(replace, zero)) for _ in range(shape[0])))
        return self.others.get(node)

    def _scaled(self, node: Product, shape: TableShape | None) -> Matrix | None:
        """A product of scalars and one vector, as a vector; None for other products."""
        inner = [self.as_table(factor, shape) for factor in node.factors]
        found = [k for k, table in enumerate(inner) if table is not None]
        if len(found) != 1:
            return None
        table = inner[found[0]]
        rest = [factor for k, factor in enumerate(node.factors) if k != found[0]]
        return table and _each(table, lambda x: Product((*map(self._new, rest), x), span=node.span))

    def _each(self, x: Expression, change: Callable[[Expression], Expression]) -> Expression:
        return _each(x, change) if isinstance(x, Matrix) else change(x)

    def _new(self, node: Expression) -> Expression:
        """A copy of a node: a node may occur only once in a tree."""
        self.made += 1
        if self.made > MOST_PIECES:
            raise NoValue("multiplied out, these vectors and matrices have too many entries", node)
        return replace(node.mapped(self._new))

    # ------------------------------------------------------------ sums
    def _sum(self, node: Sum) -> Expression:
        terms = [self.at(term) for term in node.terms]
        tables = [term for term in terms if isinstance(term, Matrix)]
        if not tables:
            return replace(node, terms=tuple(terms))
        shape = _shape(tables[0])
        same = [self._of_shape(term, shape, node) for term in terms]
        return self._added(same, node)

    def _added(self, tables: Sequence[Matrix], node: Expression) -> Matrix:
        rows = [
            tuple(Sum(entries, span=node.span) for entries in zip(*own, strict=True))
            for own in zip(*(x.rows for x in tables), strict=True)
        ]
        return Matrix(tuple(rows), span=node.span)

    def _of_shape(self, term: Expression, shape: TableShape, node: Expression) -> Matrix:
        """A term of a sum of vectors, as a vector of the sum's shape."""
        table = term if isinstance(term, Matrix) else self.as_table(term, shape)
        if table is None and shape == (1, 1):
            table = Matrix(((term,),), span=term.span)
        if table is not None and _shape(table) != shape == _shape(table)[::-1]:
            table = _flipped(table) if 1 in shape else table
        if table is None or _shape(table) != shape:
            raise NoValue(f"{_named(table or term)} is added to {_size(shape)}", node)
        return table

    # ------------------------------------------------------------ products
    def _product(self, node: Product) -> Expression:
        factors = [self.at(factor) for factor in node.factors]
        if not any(isinstance(factor, Matrix) for factor in factors):
            return replace(node, factors=tuple(factors))
        factors = [self._between(factors, k) for k in range(len(factors))]
        found = factors[0]
        for factor in factors[1:]:
            found = self._times(found, factor, node)
        return found

    def _between(self, factors: Sequence[Expression], k: int) -> Expression:
        """Factor k of a product; a name that may also be a square matrix is one between two
        matrices that fit, as I in Jᵀ I J."""
        table = self.others.get(factors[k])
        around = [*factors[max(k - 1, 0) : k], *factors[k + 1 : k + 2]]
        if table is None or len(around) < 2 or len(set(_shape(table))) > 1:
            return factors[k]
        left, right = around
        if not isinstance(left, Matrix) or not isinstance(right, Matrix):
            return factors[k]
        fits = _shape(left)[1] == _shape(right)[0] == len(table.rows) > 1
        return table if fits else factors[k]

    def _times(self, a: Expression, b: Expression, node: Expression) -> Expression:
        if not isinstance(a, Matrix) or not isinstance(b, Matrix):
            a, b = self._fitting(a, b)
        if not isinstance(a, Matrix) and not isinstance(b, Matrix):
            return Product((a, b), span=node.span)
        if not isinstance(a, Matrix) or not isinstance(b, Matrix):
            table, factor = (a, b) if isinstance(a, Matrix) else (b, a)
            assert isinstance(table, Matrix)
            return _each(table, lambda x: Product((self._new(factor), x), span=x.span))
        (n, m), (k, p) = _shape(a), _shape(b)
        if m != k and (k, m) == (1, p):  # a vector written as a row
            b, k, p = _flipped(b), p, 1
        if m != k and m == p == 1 and n == k:  # two vectors side by side: a · b
            a, n, m = _flipped(a), 1, n
        if m != k:
            raise NoValue(f"{_size((n, m))} is multiplied with {_size((k, p))}", node)
        rows = tuple(
            tuple(self._inner(row, column, node.span) for column in zip(*b.rows, strict=True))
            for row in a.rows
        )
        return rows[0][0] if (n, p) == (1, 1) else Matrix(rows, span=node.span)

    def _fitting(self, a: Expression, b: Expression) -> tuple[Expression, Expression]:
        """Two neighbouring factors with ambiguous names resolved: a name in front of a vector is a
        matrix if it may be; one behind a matrix is a vector if its size fits."""
        if isinstance(b, Matrix) and a in self.others and _shape(self.others[a])[1] != 1:
            return self.others[a], b
        if isinstance(a, Matrix) and b in self.others:
            table = self.others[b]
            if _shape(a)[1] == len(table.rows) > 1 == _shape(table)[1]:
                return a, table
        return a, b

    def _inner(self, a: Sequence[Expression], b: Sequence[Expression], span: Span) -> Expression:
        terms = [
            Product((self._new(x), self._new(y)), span=span) for x, y in zip(a, b, strict=True)
        ]
        return terms[0] if len(terms) == 1 else Sum(tuple(terms), span=span)

    def _power(self, node: Power) -> Expression:
        base = self.at(node.base)
        if not isinstance(base, Matrix):
            return replace(node, base=base)
        if node.exponent == 2 and 1 in _shape(base):
            flat = [x for row in base.rows for x in row]
            return self._inner(flat, flat, node.span)
        rows, columns = _shape(base)
        if node.exponent == -1 and rows == columns <= MOST_INVERTED:
            return self._inverse(base, node.span)
        raise NoValue(f"{_size(_shape(base))} has no power {node.exponent} here", node)

    def _inverse(self, base: Matrix, span: Span) -> Matrix:
        """Inverse of a matrix, by cofactors."""
        below, n = self._determinant(base.rows, span), range(len(base.rows))

        def entry(i: int, j: int) -> Expression:
            minor = [[base.rows[r][c] for c in n if c != i] for r in n if r != j]
            above = self._determinant(minor, span) if minor else Number(Fraction(1), span=span)
            above = Negative(above, span=span) if (i + j) % 2 else above
            return Quotient(above, self._new(below), span=span)

        return Matrix(tuple(tuple(entry(i, j) for j in n) for i in n), span=span)

    def _determinant(self, rows: Sequence[Sequence[Expression]], span: Span) -> Expression:
        """The determinant, expanded along the first row."""
        if len(rows) == 1:
            return self._new(rows[0][0])
        terms: list[Expression] = []
        for k, x in enumerate(rows[0]):
            minor = [[y for j, y in enumerate(row) if j != k] for row in rows[1:]]
            term = Product((self._new(x), self._determinant(minor, span)), span=span)
            terms.append(Negative(term, span=span) if k % 2 else term)
        return Sum(tuple(terms), span=span)

    def _cross(self, node: Cross) -> Expression:
        """The cross product a × b; in the plane ω × b of a rate ω, and a scalar for two vectors."""
        left, right = self._table(node.left), self._table(node.right)
        a, b = _components(left), _components(right)

        def minus(*factors: Expression) -> Expression:
            return Negative(times(*factors), span=node.span)

        def times(*factors: Expression) -> Expression:
            return Product(tuple(map(self._new, factors)), span=node.span)

        if len(a) == len(b) == 3:
            turns = ((1, 2), (2, 0), (0, 1))
            column = [Sum((times(a[i], b[j]), minus(a[j], b[i])), span=node.span) for i, j in turns]
        elif len(a) == len(b) == 2:
            return Sum((times(a[0], b[1]), minus(a[1], b[0])), span=node.span)
        elif (len(a), len(b)) == (1, 2):
            column = [minus(a[0], b[1]), times(a[0], b[0])]
        elif (len(a), len(b)) == (3, 2):  # ω z × r in the plane
            column = [minus(a[2], b[1]), times(a[2], b[0])]
        elif len(a) == len(b) == 1:
            return times(a[0], b[0])
        else:
            raise NoValue(f"{_named(left)} and {_named(right)} have no cross product", node)
        return Matrix(tuple((x,) for x in column), span=node.span)


def _components(x: Expression) -> list[Expression]:
    return [entry for row in x.rows for entry in row] if isinstance(x, Matrix) else [x]


def _each(x: Matrix, change: Callable[[Expression], Expression]) -> Matrix:
    return replace(x, rows=tuple(tuple(map(change, row)) for row in x.rows))


def _transposed(x: Expression) -> Expression:
    return _flipped(x) if isinstance(x, Matrix) else x


def _flipped(x: Matrix) -> Matrix:
    _shape(x)
    return replace(x, rows=tuple(zip(*x.rows, strict=True)))


def _shape(x: Matrix) -> TableShape:
    if len({len(row) for row in x.rows}) > 1:
        raise NoValue("the rows of this matrix have different lengths", x)
    return len(x.rows), len(x.rows[0])


def _named(x: Expression) -> str:
    if isinstance(x, Matrix):
        return _size(_shape(x))
    return x.name if isinstance(x, Named) else "a number"


def _size(shape: TableShape) -> str:
    if 1 in shape:
        return f"a vector of {max(shape)}"
    return f"a matrix of {shape[0]} × {shape[1]}"
