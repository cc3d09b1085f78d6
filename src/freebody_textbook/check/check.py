"""Comparison of a user's own equations with those of a model."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from os import PathLike
from pathlib import Path
from typing import Any

from freebody.errors import FreebodyError, UnknownNameError
from freebody.expressions.grammar.source import Span
from freebody.expressions.notations.notation import BookNotation, notation_of
from freebody.formats import read_file
from freebody.model.model import Model
from freebody.scalars.trig import Trig
from freebody_textbook.check.asked.asked_quantities import Targets
from freebody_textbook.check.asked.letters_for_numbers import as_written
from freebody_textbook.check.asked.loads import named_in
from freebody_textbook.check.asked.right_equations import RightEquations, equations_of, in_notation
from freebody_textbook.check.claims import own_names
from freebody_textbook.check.claims.claims import statements
from freebody_textbook.check.documents import FORMS, AnswerDocument, form_of
from freebody_textbook.check.reading.claim import Claim
from freebody_textbook.check.spelling.answer_text import AnswerError, AnswerText
from freebody_textbook.check.verdict import EquationVerdict, UnreadEquation, Verdict
from freebody_textbook.check.verdicts import senses
from freebody_textbook.check.verdicts.equation_verdict import Judge
from freebody_textbook.check.verdicts.number_verdict import NumberJudge
from freebody_textbook.check.verdicts.verdict_at_states import ONE_ASSEMBLY
from freebody_textbook.given_parameters import prepared

_ABSOLUTE = (
    "This would be right if all angles were measured from the x axis; here each is measured from "
    "the previous link. An answer with the first is read with absolute=True, --absolute."
)
MOST_EXPLAINED = 12
"""Wrong equations of one answer that are looked into."""
LARGEST_FILE = 4_000_000
"""Bytes of a file; notebooks hold pictures."""


def check(
    model: Model,
    answer: Any,
    names: Mapping[str, str] | None = None,
    *,
    absolute: bool = False,
    form: str | None = None,
    notation: str | PathLike[str] | BookNotation | None = None,
    at: Mapping[str, float | str] | str | None = None,
    tolerance: float | None = None,
    parameters: Mapping[str, str | float] | None = None,
) -> Verdict:
    """Whether an answer is equal to the model's own equations, and if not, where and why.

    answer: equations as text or LaTeX, one per line, such as "H12 = m2*(lc2^2 +
    l1*lc2*cos(theta2)) + I2"; a SymPy equation, sympy.Eq(sympy.Symbol("H22"), I2 + m2*lc2**2); a
    dict of SymPy expressions or matrices, {"H22": I2 + m2*lc2**2, "tau": sympy.Matrix([...])}; or a
    list of such. On the left may stand τ_i, H_ij (M_ij), c_i, G_i (g_i), J_ij, det J, J⁻¹, T, V,
    the tip's x and y; of body i ω_i, r_ci, v_ci, v̇_ci and f_hi (the force of the body before);
    whole vectors and matrices, M(q) = [...; ...]; coordinates given by inverse functions,
    accelerations solved for, torques that hold a force F at the tip, and a free body's equations in
    its axes. Symbols are the notes': theta1, θ₁, q1; θ̇₁, theta1_d, dtheta1; l1, lc1, m1, I1, g; on
    the right c12 is cos(θ1+θ2). names: what the user's own names stand for, {"L1": "l1"}, {"q":
    "theta"} for all that are numbered, {"C": "cos", "S": "sin"} where C12 is a cosine.

    A path is that of a file: plain text, Markdown (.md), LaTeX (.tex), a notebook of Jupyter
    (.ipynb) or Python with SymPy (.py, never run), from which the equations are taken; words
    between them are passed over. form: "text", "markdown", "latex", "notebook" or "python" of a
    text that is such a document.

    absolute: in the answer the angles of a planar robot are those of the links themselves, all
    measured from one direction, not each from the previous link; M, C, c, G, J and τ_i are then
    those of these angles (τ_i the torque on link i of drives that stand on the ground).

    notation: "notes", "craig", "spong", "siciliano", "murray-li-sastry", "lynch-park" or
    "featherstone", which say what letters stand for, or a TOML file of one's own: [names] as in
    names=, [letters] of quantities (mass = "B"), angles = "absolute", zero = "down" (angles from
    the vertical), [parameters] by formulas (lc = "l/2", I1 = "m1*l1^2/12").
    parameters: the same without a file, {"lc": "l/2", "I": 0}; formulas may have letters of your
    own, {"I1": "m1*r^2/2"}.

    Where joints are passive, "0 = …" is the equation of one of them (up to a factor that does not
    move) and "u = …" the only drive. C may be any matrix with C q̇ = c, given by whole rows. Where
    the model has values, a term may be in numbers: each is read to half a unit of its last digit.

    at: the state of results that are numbers, in SI units or with others: {"theta1": 0.5,
    "theta2_d": "30 deg/s"}, or as text, "θ₁ = 30°, θ̇₂ = 2 rad/s"; also parameters to which the
    model gives no value. The answer may contain it instead, "tau1 = 12.3 N m at θ₁ = 30°, …". A
    number must be right to half a unit of its last digit, to the tolerance given with it (12.3 ±
    0.2 N m), or to the share `tolerance` of the right one; without a unit it is in SI units.

    The text is parsed, never run; raises AnswerError, which points at the place, for what cannot be
    read, and for a quantity that is defined by itself. The comparison is exact: forms that are
    equal are found equal. The verdict is true when all equations are, and none about the robot's
    quantities was left unread; `.text` says it in words, `.findings` lists the mistakes.
    """
    if tolerance is not None and not (isinstance(tolerance, int | float) and 0 <= tolerance < 1):
        raise AnswerError(f"tolerance is a share from 0 to 1, such as 0.01, not {tolerance!r}")
    style = notation_of(notation, parameters)
    document, own = document_of(answer, form), own_names.as_texts(names or {})
    formulas = document.lexemes
    written = as_written(prepared(model, style.parameters), formulas, own)
    equations = equations_of(written, named_in(written, formulas))
    where = in_notation(equations, style, absolute)
    asked = _WholeAnswer(document, own, style, at, tolerance)
    first = found = asked.judged(where)
    for opposed in senses.others(where, first.wrong, document.formulas):
        turned = asked.judged(replace(where, opposed=opposed))
        if turned.right > found.right and senses.are_meant(
            asked.needed(turned), turned.where.loads, turned.righted(first)
        ):
            found = turned.instead_of(first)
    if found.is_unexplained and where.system is not None and not absolute:
        with suppress(FreebodyError):  # no angles in a plane
            from_x = replace(in_notation(equations, style, True), opposed=found.where.opposed)
            found = found.explained_by(asked.judged(from_x), _ABSOLUTE)
    return found.verdict


@dataclass(frozen=True)
class _WholeAnswer:
    """An answer with its notation, state, tolerance and user-defined names."""

    document: AnswerDocument
    names: Mapping[str, str]
    style: BookNotation
    at: Mapping[str, float | str] | str | None
    tolerance: float | None

    def judged(self, where: RightEquations) -> _Judged:
        """The verdict on the answer under some correct equations."""
        document = self.document
        said = statements(where, document, self.names, self.style, self.at)
        velocity = any(claim.target.kind.is_coefficient for claim in said.claims)
        targets = Targets(where, velocity, self.style.all_letters)
        numbers = NumberJudge(where, targets, said.numbers, self.tolerance)
        judge = Judge(where, targets, said.claims, numbers)
        judged, unread = list[tuple[Claim, EquationVerdict]](), list(said.unread)
        for claim in said.claims:
            explain = sum(not x.equal for _, x in judged) < MOST_EXPLAINED
            with _leaving_out(document, claim.source, claim.node.span, unread):
                verdict = judge.verdict(claim, explain)
                judged.append((claim, self._placed(claim, verdict)))
        for span in numbers.unused(said.claims, said.told):
            source = said.claims[0].source
            with _leaving_out(document, source, span, unread):
                source.fail("a unit, a tolerance or a state follows what is not a result", span)
        if self.at and not any(
            isinstance(x.value, Trig) and x.value.is_constant for x in said.claims
        ):
            raise AnswerError("at: a state is given, but none of the results is a number")
        verdict = Verdict(
            tuple(x for _, x in judged),
            where.symbols.model.name,
            said.unused,
            tuple(sorted(unread, key=lambda row: row.at)),
            document.written,
        )
        return _Judged(where, verdict, [claim for claim, _ in judged])

    def _placed(self, claim: Claim, verdict: EquationVerdict) -> EquationVerdict:
        """The verdict on a claim with its place in the answer."""
        at = claim.node.span[0]
        where = claim.source.where(at) if self.document.tells_lines else ""
        return replace(verdict, where=where, line=claim.source.shown.count("\n", 0, at) + 1)

    def needed(self, found: _Judged) -> frozenset[str]:
        """The reversed sign conventions that are needed: without them fewer equations would be
        correct, or correct in fewer assemblies."""
        opposed = found.where.opposed
        without = {x: replace(found.where, opposed=opposed - {x}) for x in opposed}
        return frozenset(
            x for x, where in without.items() if self.judged(where).extent < found.extent
        )


@dataclass(frozen=True)
class _Judged:
    """A verdict with the correct equations used for it, and the claim of each equation."""

    where: RightEquations
    verdict: Verdict
    claims: Sequence[Claim]

    @property
    def wrong(self) -> list[Claim]:
        """The claims that are wrong."""
        rows = zip(self.claims, self.verdict.equations, strict=True)
        return [claim for claim, x in rows if not x.equal]

    @property
    def right(self) -> int:
        """The number of equations that are right."""
        return len(self.claims) - len(self.wrong)

    @property
    def extent(self) -> tuple[int, int]:
        """(number of correct equations, number of those correct in every assembly)."""
        right = [x for x in self.verdict.equations if x.equal]
        return len(right), sum(ONE_ASSEMBLY not in x.note for x in right)

    def righted(self, before: _Judged) -> list[Claim]:
        """The claims that are correct in this verdict and wrong in an earlier one."""
        rows = zip(self.claims, self.verdict.equations, before.verdict.equations, strict=False)
        return [claim for claim, own, other in rows if own.equal and not other.equal]

    @property
    def is_unexplained(self) -> bool:
        """Whether some wrong equation has no explanation."""
        return any(map(_says_nothing, self.verdict.equations))

    def explained_by(self, other: _Judged, cause: str) -> _Judged:
        """A copy of the verdict with `cause` noted at each equation that is wrong and unexplained
        here but correct in `other`."""
        rows = self.verdict.equations, other.verdict.equations
        if len(rows[0]) != len(rows[1]):
            return self
        equations = (
            replace(own, causes=(cause,)) if _says_nothing(own) and there.equal else own
            for own, there in zip(*rows, strict=True)
        )
        return replace(self, verdict=replace(self.verdict, equations=tuple(equations)))

    def instead_of(self, before: _Judged) -> _Judged:
        """A copy of the verdict with a note at each equation that is correct only under its
        reversed sign conventions."""
        rows = before.verdict.equations, self.verdict.equations
        equations = senses.noted(self.where, *rows) if len(rows[0]) == len(rows[1]) else rows[1]
        return replace(self, verdict=replace(self.verdict, equations=tuple(equations)))


def _says_nothing(x: EquationVerdict) -> bool:
    return not (x.equal or x.findings or x.causes)


@contextmanager
def _leaving_out(
    document: AnswerDocument, source: AnswerText, span: Span, unread: list[UnreadEquation]
) -> Iterator[None]:
    """Context that records an equation of a document which cannot be judged, and continues."""
    try:
        yield
    except AnswerError as problem:
        if document.strict:
            raise
        unread.append(
            UnreadEquation(span[0], source.where(span[0]), source[span], problem.bare, True)
        )


def document_of(answer: Any, form: str | None) -> AnswerDocument:
    """An answer as a document: a path is read as a file, whose suffix determines its format."""
    if form is not None and form not in FORMS:
        raise UnknownNameError("form", form, "check", FORMS)
    if isinstance(answer, PathLike):
        path = Path(answer)
        record = FORMS[form] if form else form_of(path.name)
        text = read_file.decoded(str(path), read_file.read(path, LARGEST_FILE, "an answer"))
        return replace(record.read(text), told=True)
    return FORMS[form or "text"].read(text_of(answer))


def text_of(answer: Any) -> str:
    """An answer as text: strings unchanged, SymPy objects as SymPy prints them, one equation per
    line."""
    if isinstance(answer, str):
        return answer
    if isinstance(answer, Mapping):
        return "\n".join(f"{name} = {_expression(value)}" for name, value in answer.items())
    if hasattr(answer, "lhs") and hasattr(answer, "rhs"):
        return f"{_expression(answer.lhs)} = {_expression(answer.rhs)}"
    if isinstance(answer, Iterable) and not hasattr(answer, "free_symbols"):
        return "\n".join(map(text_of, answer))
    raise AnswerError(
        f"an answer is text, a SymPy equation or a dict of them, not {type(answer).__name__}",
        "Write, for example, check(model, {'tau1': expression}).",
    )


def _expression(x: Any) -> str:
    """One side of a SymPy equation as text on one line."""
    return " ".join(str(x).split())
