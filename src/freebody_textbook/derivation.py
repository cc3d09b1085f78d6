"""A derivation as data: an ordered list of steps with equations, what was done and why; and the
record of a derivation method, read by the command line, errors, pages and documents."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

from freebody.errors import listed
from freebody.expressions.expression import Equation, Expression
from freebody.expressions.notations.lettering import PLAIN, Lettering, lettered_for
from freebody.outputs.display import InWords, Titled, counted
from freebody.scalars.trig import Trig
from freebody_textbook.equations.equations import Equations
from freebody_textbook.render import documents

if TYPE_CHECKING:
    from freebody_textbook.closed_chains.first_kind import FirstKind
    from freebody_textbook.closed_chains.statics import LoopStatics
    from freebody_textbook.render.documents import LivingParts


@dataclass(frozen=True, repr=False)
class Step(InWords):
    """One step of a derivation.

    operation: what is done, as a heading. reason: why, in a sentence. notes: numbers of the
    equations of the lecture notes that the step's equations are. figure: the drawing that belongs
    to it: "vectors", "centres", "velocities", "accelerations", "tip", "tip velocity", "tip
    acceleration", "free-body N" of body N from 1, "carried N" of it with all that hangs on it,
    "partial N" of the velocities when joint N alone moves, or "free N" of body N that nothing
    holds. result: whether this is what was sought. terms: what terms of the
    equations are, a row each.
    """

    operation: str
    reason: str
    equations: tuple[Equation, ...] = ()
    notes: tuple[str, ...] = ()
    figure: str | None = None
    result: bool = False
    terms: tuple[Meaning, ...] = ()

    def _title(self) -> str:
        return f"Step: {self.operation}; {counted(len(self.equations), 'equation')}"

    def text(self, width: int = 100) -> str:
        """The step for a terminal: what is done, why, and its equations."""
        return documents.step_text(self, width)

    def __str__(self) -> str:
        return self.text()

    def _repr_html_(self) -> str:
        return f"<style>{documents.NOTEBOOK_STYLE}</style>{documents.body.step(self)}"


@dataclass(frozen=True)
class Meaning:
    """The meaning of symbols in words, and their unit ("" if none)."""

    symbols: tuple[Expression, ...]
    words: str
    unit: str


@dataclass(frozen=True)
class Drawings:
    """Drawings of a derivation: SVG text by figure name, with "overview" for the robot, and their
    CSS style."""

    svg: Mapping[str, str]
    style: str


@dataclass(frozen=True, repr=False)
class Derivation(Titled):
    """A derivation of a model's equations by one method, with the torques that it obtains."""

    method: str
    title: str
    equations: Equations
    """Closed forms from the composite-body mass matrix and its Christoffel symbols, to hold the
    result against."""
    steps: tuple[Step, ...]
    tau: tuple[Trig, ...]
    """Joint torques as this method finds them, exact polynomials."""
    given: str = ""
    """The text on what is given and what is sought."""
    glossary: tuple[Meaning, ...] = ()
    """Symbols that occur, with their meanings."""
    system: FirstKind | LoopStatics | None = None
    """The equations of a closed chain as polynomials: of the first kind M, Φ_q, c and the
    reduction; of statics multipliers and torques."""
    reference: str = ""
    """The source of the method, if it is not the lecture notes."""
    draw: Callable[[Derivation, str], Drawings] | None = field(
        default=None, compare=False, repr=False
    )
    """A function that draws its figures, with labels as in `html`; figures are made above
    derivations, so that it comes from there."""

    enliven: Callable[[Derivation], LivingParts | None] | None = field(
        default=None, compare=False, repr=False
    )
    """A function that makes the parts of its page that can be tried; from above, as `draw` is."""

    lettering: Lettering = PLAIN
    """The letters that it is written in."""
    plain: Derivation | None = field(default=None, compare=False, repr=False)
    """The derivation in the notes' letters, where its own are others."""

    def _title(self) -> str:
        return (
            f"Derivation for {self.equations.symbols.model.name!r}: {self.title}; "
            f"{counted(len(self.steps), 'step')}"
        )

    @property
    def result(self) -> Equations:
        """The equations of motion (for statics: the equations of the model)."""
        return self.equations

    def text(self, width: int = 100) -> str:
        """The derivation for a terminal."""
        return documents.text(self, width)

    def markdown(self, images: Mapping[str, str] | None = None) -> str:
        """The derivation as Markdown, formulas between dollar signs; images: paths of drawings by
        figure."""
        return documents.markdown(self, images)

    def latex(self) -> str:
        """The derivation as a LaTeX document."""
        return documents.latex(self)

    def html(self, labels: str = "names") -> str:
        """A self-contained HTML page with MathML; labels of its drawings: "names", "values" or
        "both".

        The page of an arm, and of most closed chains, can be tried: with sliders that
        numbers and a drawing follow, and lines that are hidden until they are predicted.

        Raises UnknownNameError, and MissingValueError for values that the model does not have.
        """
        made = self._drawings(labels)
        living = self.enliven(self) if self.enliven else None
        return documents.html(self, made.svg, made.style, living)

    def _drawings(self, labels: str = "names") -> Drawings:
        return self.draw(self, labels) if self.draw else Drawings({}, "")

    def __str__(self) -> str:
        return self.text()

    def _repr_html_(self) -> str:
        made = self._drawings()
        style = f"<style>{made.style}{documents.NOTEBOOK_STYLE}</style>"
        return style + documents.body(self, made.svg)


@dataclass(frozen=True)
class Worked:
    """The result of applying a derivation method: its steps and quantities.

    steps: in order. tau: the motors' torques as this method finds them, in the order of the joints;
    none where it finds none. symbols: the meanings of what it introduces. title: where options
    change the method's. sought: a sentence that says what is sought, where it is not the motors'
    torques for a given motion. system: of a closed chain, as polynomials. robot, table: sentences
    about the robot and its axes, and the whole table of symbols, where these are not the usual ones
    of joints and bodies.
    """

    steps: tuple[Step, ...]
    tau: tuple[Trig, ...]
    symbols: Iterable[Meaning]
    title: str = ""
    sought: str = ""
    system: FirstKind | LoopStatics | None = None
    robot: tuple[str, ...] = ()
    table: tuple[Meaning, ...] = ()


@dataclass(frozen=True)
class MethodOption:
    """An option of a derivation method: its name, its choices with the default first, and what it
    selects, in words."""

    name: str
    choices: tuple[str, ...]
    words: str


@dataclass(frozen=True)
class Method:
    """A method of deriving a robot's equations.

    name: what users write, as they may each of the aliases. title: heading of a derivation. words:
    what is done, for lists of the methods. source: where the method is described. work_out: from a
    setting and the options to the steps. reference: the source in full, for the foot of a
    derivation, where it is not the lecture notes. spaces, closed: the numbers of dimensions in
    which it serves open and closed chains; closed_first: whether closed chains are derived by it
    where no method is asked for; elsewhere: the functions that give numbers for closed
    chains which it does not serve. at_rest: whether the robot stands still, and a force acts on the
    tip unless it is left out. absolute: whether it can be told in angles of the links themselves.
    finds_torques: whether it ends in the torques of the motors; forces
    do not occur in one that does not.
    """

    name: str
    title: str
    words: str
    source: str
    work_out: Callable[..., Worked]
    reference: str = ""
    aliases: tuple[str, ...] = ()
    options: tuple[MethodOption, ...] = ()
    spaces: tuple[int, ...] = (2, 3)
    closed: tuple[int, ...] = ()
    closed_first: bool = False
    elsewhere: str = ""
    at_rest: bool = False
    finds_torques: bool = True
    absolute: bool = False


def written_in(lettering: Lettering, made: Derivation) -> Derivation:
    """A derivation written in the letters of a book's notation."""
    if lettering is PLAIN:
        return made
    lines = [line for step in made.steps for line in step.equations]
    rows = [*made.glossary, *(row for step in made.steps for row in step.terms)]
    own = lettered_for(lettering, [*lines, *(x for row in rows for x in row.symbols)])
    steps = tuple(
        replace(
            step,
            operation=own.sentence(step.operation),
            reason=own.sentence(step.reason),
            equations=tuple(map(own.line, step.equations)),
            terms=_lettered(own, step.terms),
        )
        for step in made.steps
    )
    table = _lettered(own, made.glossary)
    given = own.sentence(made.given)
    if own.taken:
        given += (
            f" The robot's own names stay, as {listed(own.taken)} would be one of the notation's."
        )
    new = {"steps": steps, "glossary": table, "given": given}
    return replace(made, **new, lettering=own, plain=made)


def _lettered(own: Lettering, table: Iterable[Meaning]) -> tuple[Meaning, ...]:
    return tuple(
        Meaning(tuple(map(own, row.symbols)), own.sentence(row.words), row.unit) for row in table
    )


@dataclass(frozen=True)
class Comparison:
    """Two derivations of the same model, their torques subtracted term by term."""

    first: Derivation
    second: Derivation

    @property
    def differences(self) -> tuple[Trig, ...]:
        """First minus second, per joint, in normal form."""
        return tuple(a - b for a, b in zip(self.first.tau, self.second.tau, strict=True))

    @property
    def equal(self) -> bool:
        """Whether every difference is the zero polynomial."""
        return all(d.is_zero for d in self.differences)

    def __bool__(self) -> bool:
        return self.equal

    def __str__(self) -> str:
        lines = [f"{self.first.title} and {self.second.title}:"]
        for i, (a, d) in enumerate(zip(self.first.tau, self.differences, strict=True), 1):
            verdict = (
                "identical"
                if d.is_zero
                else f"they differ by {self.first.equations.layout.form(d)}"
            )
            lines.append(f"  tau{i}: {len(a)} terms, {verdict}")
        return "\n".join(lines)
