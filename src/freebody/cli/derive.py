"""`freebody derive`."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from freebody.cli import options, terminal
from freebody.outputs.files import write

if TYPE_CHECKING:
    from freebody.derivations.derivation import Derivation

EXAMPLE = "Example: freebody derive 2R --method lagrange"


class MethodChoice(StrEnum):
    """Ways to the equations."""

    newton_euler = "newton-euler"
    recursive = "recursive"
    lagrange = "lagrange"
    lagrange_first_kind = "lagrange-first-kind"
    statics = "statics"
    kinematics = "kinematics"


class FormChoice(StrEnum):
    """How a derivation is written."""

    text = "text"
    markdown = "markdown"
    latex = "latex"
    html = "html"


class RouteChoice(StrEnum):
    """Points that newton-euler takes moments about."""

    centre = "centre"
    pivot = "pivot"


class GravityChoice(StrEnum):
    """How the recursion counts gravity."""

    base = "base"
    explicit = "explicit"


Method = Annotated[
    MethodChoice | None,
    typer.Option(
        help="How the equations are derived. Default: newton-euler, of closed chains lagrange-first-kind."
    ),
]


def derive(
    robot: options.Robot,
    method: Method = None,
    compare: Annotated[
        MethodChoice | None, typer.Option(help="Derive by this method too, and prove that both agree.")
    ] = None,
    form: Annotated[FormChoice, typer.Option(help="Text for a terminal, or a document.")] = FormChoice.text,
    out: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Write there instead of the terminal.")
    ] = None,
    route: Annotated[
        RouteChoice | None, typer.Option(help="Moments about centres of mass or pivots (newton-euler).")
    ] = None,
    gravity: Annotated[
        GravityChoice | None, typer.Option(help="As acceleration of the base, or as weights (recursive).")
    ] = None,
    load: Annotated[
        bool | None, typer.Option("--load/--no-load", help="A force on the tip (default: in statics).")
    ] = None,
    convention: options.Convention = None,
) -> None:
    """Derive a robot's equations of motion step by step. Exit code 1 if two methods were to disagree."""
    from freebody.derivations.derive import compare as compared
    from freebody.derivations.derive import default_method
    from freebody.figures.illustrate import derive as derivation_of

    model = options.load(robot, convention=convention)
    method = method or MethodChoice(default_method(model))
    chosen = _options(method, route, gravity)
    with terminal.progress(f"deriving by {method.value}"):
        first = derivation_of(model, method.value, load=load, **chosen)
        other = derivation_of(model, compare.value, load=load) if compare is not None else None
        comparison = compared(first, other) if other is not None else None
        text = _markdown(first, out) if form is FormChoice.markdown and out else getattr(first, form.value)()
    if out is None:
        terminal.out().print(text, markup=False, soft_wrap=True)
    else:
        terminal.out().print(f"written: {write(out, text)}", markup=False)
    if comparison is not None:
        terminal.out().print(f"\n{comparison}", markup=False)
        if not comparison:
            raise typer.Exit(1)


def _options(
    method: MethodChoice, route: RouteChoice | None, gravity: GravityChoice | None
) -> dict[str, str]:
    """Options of the method, as far as they are given; an error for those of another."""
    given = {"route": (route, MethodChoice.newton_euler), "gravity": (gravity, MethodChoice.recursive)}
    for name, (value, owner) in given.items():
        if value is not None and method is not owner:
            raise typer.BadParameter(f"--{name} belongs to --method {owner.value}, not to {method.value}.")
    return {name: value.value for name, (value, _) in given.items() if value is not None}


def _markdown(derivation: Derivation, out: Path) -> str:
    """Markdown that refers to drawings in files beside it."""
    from freebody.figures.illustrate import write_drawings

    return derivation.markdown(write_drawings(derivation, out))
