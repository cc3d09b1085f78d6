"""The command `freebody derive`."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from inspect import Parameter, Signature
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from freebody.cli import commands, options, terminal
from freebody.errors import FreebodyError
from freebody.outputs.files import write

if TYPE_CHECKING:
    from freebody_textbook.derivation import Derivation, Method, MethodOption

EXAMPLE = "Example: freebody derive 2R --method lagrange"
_CHOSEN = "freebody.derive"
"""The key under which the parser's context keeps the methods' options that were given."""


_Form = Literal["text", "markdown", "latex", "html"]
_ENDINGS: dict[str, _Form] = {
    ".md": "markdown", ".tex": "latex", ".html": "html", ".htm": "html",
}  # fmt: skip
"""The form that the ending of a file's name asks for; of other names it is text."""


class Command(commands.OnceCommand):
    """The command `derive`, with the options of all derivation methods and a list of them; both are
    read only when it runs."""

    def get_params(self, ctx: typer.Context) -> list[Any]:
        """The parameters of the command's function, then the methods' options, then --help."""
        from freebody_textbook.methods import METHODS

        *params, last = super().get_params(ctx)
        return [*params, *_options_of(METHODS.values()), last]

    def format_help(self, ctx: typer.Context, formatter: Any) -> None:
        """Print the help, with the methods listed below its first paragraph."""
        from freebody_textbook.methods import METHODS

        lines = [f"{method.name}: {method.words} ({method.source})." for method in METHODS.values()]
        self.help = "\n\n".join([terminal.paragraphs(derive.__doc__), *lines])
        super().format_help(ctx, formatter)


def _options_of(methods: Iterable[Method]) -> list[Any]:
    """Command line parameters made from the methods' options; `derive` reads their values from the
    context."""

    def command(**_options: str | None) -> None:
        """Carry the options' signature; this function is never called."""

    owned = [(method, option) for method in methods for option in method.options]
    command.__signature__ = Signature([_parameter(*pair) for pair in owned])
    parser = typer.Typer(add_completion=False)
    parser.command()(command)
    made = [param for param in typer.main.get_command(parser).params if param.name != "help"]
    for param in made:
        param.expose_value = False
    return made


def _parameter(method: Method, option: MethodOption) -> Parameter:
    """A signature parameter for an option of a method."""

    def keep(context: typer.Context, value: str | None) -> None:
        if value is not None:
            context.meta.setdefault(_CHOSEN, {})[option.name] = value

    said = typer.Option(
        f"--{option.flag or option.name}",
        metavar="|".join(option.choices),
        help=f"{option.words[0].upper()}{option.words[1:]} ({method.name}).",
        callback=keep,
    )
    own = f"{method.name}_{option.name}".replace("-", "_")  # apart from the names of others
    return Parameter(
        own, Parameter.KEYWORD_ONLY, default=None, annotation=Annotated[str | None, said]
    )


@options.collected(
    wrench="a force on the tip stands there in letters; --load includes it.",
    speed="equations hold for motions of any speed.",
)
def derive(
    context: typer.Context,
    robot: options.GivenRobot,
    method: Annotated[
        str | None,
        typer.Option(
            metavar="METHOD",
            help="The method: a name from the list above. Default: the first that applies to the "
            "robot.",
        ),
    ] = None,
    compare: Annotated[
        str | None,
        typer.Option(
            metavar="METHOD", help="Derive by this method too, and prove that both agree."
        ),
    ] = None,
    form: Annotated[
        _Form | None,
        typer.Option(
            help="Text for a terminal, or a document. Default: by the suffix of FILE, else text."
        ),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Write to this file instead of the terminal."),
    ] = None,
    load: Annotated[
        bool | None,
        typer.Option(
            "--load/--no-load",
            help="Include a force on the tip. Default: only in statics, for robots at rest.",
        ),
    ] = None,
    labels: Annotated[
        options.LabelsOption | None,
        typer.Option(help="Labels in the drawings of a page. Default: names."),
    ] = None,
    notation: options.NotationOption = None,
) -> None:
    """Derive a robot's equations of motion step by step. Exit status 1 if two methods disagree."""
    from freebody_textbook.derive import compare as compared
    from freebody_textbook.derive import default_method, method_named
    from freebody_textbook.derive import derive as derivation_of
    from freebody_textbook.methods.recursive import GRAVITIES

    if robot.how["gravity"] in GRAVITIES:
        _read_old_spelling(context, robot.how["gravity"])
        robot = replace(robot, how={**robot.how, "gravity": None})
    model, given = robot.in_symbols()
    record = method_named(method) if method else default_method(model)
    with terminal.progress(f"deriving by {record.name}"):
        how = {"load": load, "notation": notation, "parameters": given}
        first = derivation_of(model, record.name, **how, **context.meta.get(_CHOSEN, {}))
        other = derivation_of(model, compare, **how) if compare is not None else None
        comparison = compared(first, other) if other is not None else None
        form = form or _ENDINGS.get(out.suffix.lower() if out else "", "text")
        text = _text(first, form, out, labels)
    if out is None:
        terminal.out().print(text, soft_wrap=True)
    else:
        terminal.out().print(f"written: {write(out, text)}")
    if comparison is not None:
        terminal.out().print(f"\n{comparison}")
        if not comparison:
            raise typer.Exit(1)


def _read_old_spelling(context: typer.Context, weights: str) -> None:
    """Read --gravity base|explicit as --weights, and say so; elsewhere --gravity is the field."""
    terminal.warn(f"--gravity {weights} is now written --weights {weights}; it is read as that.")
    context.meta.setdefault(_CHOSEN, {}).setdefault("gravity", weights)


def _text(
    derivation: Derivation, form: _Form, out: Path | None, labels: options.LabelsOption | None
) -> str:
    """The derivation as text in one form; Markdown refers to drawings in files beside it."""
    from freebody_textbook.drawings.illustrate import write_drawings

    shown = labels or "names"
    if form == "html":
        return derivation.html(shown)
    if form == "markdown" and out:
        return derivation.markdown(write_drawings(derivation, out, shown))
    if labels is not None:
        raise FreebodyError(
            "--labels applies to drawings, and this format has none: write a page, for example "
            "--out arm.html."
        )
    return getattr(derivation, form)()
