"""The equations of motion in closed form: M(q) q̈ + c(q, q̇) + g(q) + friction and springs =
tau."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from os import PathLike
from typing import Any

from freebody.errors import FreebodyError, UnknownNameError, require_kind
from freebody.expressions import expression as ex
from freebody.expressions.expression import Equation, operations
from freebody.expressions.notations.lettering import lettered_for, lettering_of
from freebody.expressions.notations.notation import PRESETS, BookNotation, notation_of, preset
from freebody.expressions.polynomials.symbols import symbols
from freebody.expressions.typesetting.mathml import MATHML, NAMESPACE
from freebody.model.model import Model
from freebody.model.parameters import finite, with_parameters
from freebody.outputs.display import Titled
from freebody.scalars.trig import Trig
from freebody_textbook.equations import source_code
from freebody_textbook.equations.base_parameters import base_view
from freebody_textbook.equations.closed_form import (
    STANDARD,
    ClosedForm,
    Letters,
    expanded,
    in_terms,
    named,
)
from freebody_textbook.equations.intermediates import intermediates
from freebody_textbook.equations.source_code import to_sympy
from freebody_textbook.render import equation_lines

NotationName = str | PathLike[str] | BookNotation
"""A notation, or "standard"."""
NAMINGS = ("notes", "standard", *PRESETS[1:])
VIEWS = ("auto", "named", "expanded", "intermediates", "base")


@dataclass(frozen=True, eq=False, repr=False)
class Equations(Titled, ClosedForm):
    """A model's closed-form equations as exact polynomials in normal form (equal means identical),
    with their views and texts."""

    def _title(self) -> str:
        s = self.symbols
        return f"Equations of motion of {s.model.name!r} in closed form: {', '.join(s.coordinates)}"

    # ------------------------------------------------------------ for the reader
    @property
    def parameters(self) -> dict[str, float | None]:
        """Names of the parameters in the equations, with values where known."""
        used = set(self.symbols.ring.names)
        return {
            name: value for name, value in self.symbols.model.parameters.items() if name in used
        }

    def intermediates(self) -> list[Equation]:
        """Inverse dynamics in named intermediate results, each line using those before: see
        `intermediates`."""
        self.symbols.require_plain("intermediates")
        return intermediates(self.symbols)

    def groups(self, view: str = "named", names: NotationName = "notes") -> list[list[Equation]]:
        """The equations of a view: "named", "expanded", "intermediates" or "base"."""
        standard = names == "standard"
        notation = preset("notes") if standard else _letters_of(names)
        groups = self._view(view, STANDARD if standard else in_terms(notation.terms))
        if standard or notation is preset("notes"):
            return groups
        lines = [line for group in groups for line in group]
        lettering = lettering_of(notation, self.symbols.model, self.symbols.coordinates)
        lettering = lettered_for(lettering, lines)
        return [[lettering.line(line) for line in group] for group in groups]

    def _view(self, view: str, letters: Letters) -> list[list[Equation]]:
        """The equations of a view, in the given letters."""
        if view == "intermediates":
            return [self.intermediates()]
        if view == "expanded":
            return expanded(self, self.layout)
        if view == "base":
            return base_view(self, letters)
        if view in ("named", "auto"):
            return named(self, self.layout, letters)
        raise UnknownNameError("view", view, "Equations", VIEWS)

    def operations(self, view: str = "named") -> dict[str, int]:
        """Numbers of additions, multiplications and functions that a view needs, counted line by
        line as printed."""
        total: Counter[str] = Counter(additions=0, multiplications=0, functions=0)
        for line in (line for group in self.groups(view) for line in group):
            total.update(operations(line))
        return dict(total)

    def text(self, view: str = "auto", names: NotationName = "notes", width: int = 100) -> str:
        """The equations for a terminal.

        view: "named" (τ by H, h, G and what these are), "expanded" (τ written out), "intermediates"
        (the recursion line by line), "base" (named, by the fewest combinations of masses and
        inertias), "auto" (named where that is short, else how long it is).
        names: "notes" (H_ij, h, G_i), "standard" (M_ij, c_i, g_i), or another notation, as for
        `check`.
        """
        if view == "auto" and not self.is_short:
            return "\n".join(map(str, self._lines_on_length()))
        return equation_lines.text(self.groups(view, names), width)

    def latex(
        self, view: str = "auto", names: NotationName = "notes", environment: str = "aligned"
    ) -> str:
        """The equations as an amsmath environment, without dollar signs; "align*" in a document
        breaks across pages."""
        if view == "auto" and not self.is_short:
            lines = " \\\\ ".join(line.latex() for line in self._lines_on_length())
            return f"\\begin{{gathered}} {lines} \\end{{gathered}}"
        return equation_lines.latex(self.groups(view, names), environment)

    def mathml(self, view: str = "auto", names: NotationName = "notes") -> str:
        """The equations as one `<math>` element."""
        if view == "auto" and not self.is_short:
            rows = (
                f"<mtr><mtd>{MATHML.line(line)}</mtd></mtr>" for line in self._lines_on_length()
            )
            return f'<math {NAMESPACE} display="block"><mtable>{"".join(rows)}</mtable></math>'
        return equation_lines.html(self.groups(view, names), alone=True)

    def _lines_on_length(self) -> list[ex.Expression]:
        """Two lines in place of equations that are too long to read, with their length."""
        return [
            ex.words(f"{self.symbols.model.name}: {self.length}: too long to read."),
            ex.words(
                f"view='intermediates': the recursion, in {len(self.intermediates())} lines; "
                "view='named' or 'expanded': all terms."
            ),
        ]

    def __str__(self) -> str:
        return self.text()

    def _repr_latex_(self) -> str:
        return f"$\\displaystyle {self.latex()}$"

    # ------------------------------------------------------------ for other programs
    def to_sympy(self) -> dict[str, Any]:
        """SymPy matrices M, C, c, g, drives, tau and expressions T, V; symbols are named as in code
        and real.

        SymPy is an extra: `pip install 'freebody[sympy]'`. Raises MissingPackageError.
        """
        names = ("M", "C", "c", "g", "drives", "tau", "T", "V")
        return {name: to_sympy(self._expression(getattr(self, name))) for name in names}

    def _expression(self, x: Any) -> ex.Expression:
        """A polynomial, vector or matrix as one expression."""
        if isinstance(x, Trig):
            return self.form(x)
        if isinstance(x[0], Trig):
            return ex.vector(*map(self.form, x))
        return ex.matrix([map(self.form, row) for row in x])

    def python(self) -> str:
        """Source of a Python function dynamics(q, qd, qdd, parameters…) that returns M, c, G,
        tau."""
        return source_code.python(self)

    def c_source(self) -> str:
        """Source of a C function of the same, the closed form term by term; long arms are shorter
        with `fb.source`."""
        return source_code.c(self)

    def substitute(self, **numbers: float) -> Equations:
        """The equations with numbers in place of some parameters."""
        self.symbols.require_plain("substitute")
        known = self.parameters
        for name in numbers:
            if name not in known:
                raise UnknownNameError("parameter", name, "the equations", known)
        model = with_parameters(
            self.symbols.model,
            lambda p: finite(numbers[p.name], p.name) if p.name in numbers else p,
        )
        return equations(model, self.symbols.reader.numbers)


def _letters_of(names: NotationName) -> BookNotation:
    """The book notation by name, if it consists of letters alone; raises an error otherwise."""
    if isinstance(names, str) and not (names.endswith(".toml") or names in NAMINGS):
        raise UnknownNameError("naming", names, "Equations", NAMINGS)
    notation = notation_of(names)
    if notation.parameters or notation.absolute or notation.quarter_turns:
        raise FreebodyError(
            f"Equations: the notation {notation.name!r} has angles or parameters of its own; "
            "fb.derive(model, notation=...) writes equations with them."
        )
    return notation


def equations(model: Model, numbers: bool = False) -> Equations:
    """The closed-form equations of a model; numbers: with the parameters' values in place of their
    symbols.

    Raises FreebodyError for spherical and free joints, and for joints that follow another by a
    ratio that is not whole.
    """
    require_kind("equations", "numbers", numbers, bool, "True or False")
    model.require_tree("equations")
    if numbers:
        model.require_values("equations in numbers")
    return Equations(symbols(model, numbers))
