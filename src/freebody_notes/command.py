"""The command `freebody notes`."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from freebody.cli import terminal
from freebody.errors import FreebodyError, UnknownNameError, listed
from freebody.outputs.files import write

if TYPE_CHECKING:
    from freebody_notes.item import ExecutedItem, Item

EXAMPLE = "Example: freebody notes eq-3.22"

COLOURS = {"holds": "green", "misprint": "red", "inconsistent": "magenta", "incomplete": "yellow"}


def notes(
    item: Annotated[
        str | None,
        typer.Argument(
            help="One item: eq-3.22, fig-2.3, ex-1.1a, or an equation's number; or words, such as "
            "Jacobian, for the items about them.",
            show_default=False,
        ),
    ] = None,
    chapter: Annotated[int | None, typer.Option(min=1, max=6, help="Only this chapter.")] = None,
    verdict: Annotated[
        Literal["holds", "misprint", "inconsistent", "incomplete"] | None,
        typer.Option(help="Only items with this verdict."),
    ] = None,
    errata: Annotated[
        bool, typer.Option("--errata", help="Print the list of errata, as Markdown.")
    ] = False,
    html: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE",
            help="Write all items as web pages that need no network: the contents to FILE, "
            "each chapter beside it.",
        ),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Write the item's figure (.svg) or the errata to it."),
    ] = None,
) -> None:
    """Check the lecture notes: every equation, worked example and figure is executed, with its
    verdict and correction."""
    given: dict[str, object] = {"an item": item, "--html": html, "--errata": errata, "--out": out}
    given |= {"--chapter": chapter, "--verdict": verdict}
    _require_used([name for name, value in given.items() if value not in (None, False)])
    if item is not None:
        _one(item, out)
    elif html is not None:
        _page(html)
    elif errata:
        _errata(out)
    else:
        _table(chapter, verdict)


_WITH = {
    "an item": ("--out",),
    "--html": (),
    "--errata": ("--out",),
    "": ("--chapter", "--verdict"),
}
"""Options that may be given beside an item, --html or --errata, the first of which counts; "":
without any of the three."""


def _require_used(given: Sequence[str]) -> None:
    """Raise an error if options are given that would have no effect."""
    chosen = next((name for name in _WITH if name in given), "")
    unused = [name for name in given if name != chosen and name not in _WITH[chosen]]
    if not unused:
        return
    if unused == ["--out"] and not chosen:
        raise FreebodyError(
            "notes: --out needs something to write: an item with a figure, or --errata. The table "
            "is printed in the terminal; --html FILE writes everything as a page."
        )
    allowed = " and ".join(_WITH[chosen]) or "no other option"
    verb, them = ("is", "it") if len(unused) == 1 else ("are", "them")
    raise FreebodyError(
        f"notes: {listed(unused)} {verb} not used with {chosen or 'the table'}, which takes "
        f"{allowed}; leave {them} out."
    )


def _run(items: Sequence[Item]) -> list[ExecutedItem]:
    from freebody_notes.item import run_all

    with terminal.progress("executing the notes") as told:
        return run_all(items, told)


def _one(name: str, out: Path | None) -> None:
    from freebody_notes.contents import about
    from freebody_notes.contents import item as found_item
    from freebody_notes.text import item_text

    try:
        item = found_item(name)
    except UnknownNameError:
        items = about(name) if out is None else ()
        if not items:
            raise
        _list(_run(items))
        return
    (finding,) = _run([item])
    console = terminal.out()
    console.print(item_text(finding, min(console.width, 100)), markup=False, soft_wrap=True)
    console.print(f"\n{finding.verdict}", style=f"bold {COLOURS[finding.verdict]}")
    if out is not None:
        _figure(item, out)
    elif item.figure:
        console.print(
            f"Figure {item.figure}: freebody notes {item.id} --out figure.svg", markup=False
        )


def _figure(item: Item, out: Path) -> None:
    from freebody_notes.figures.catalogue import notes_figure

    if not item.figure:
        raise FreebodyError(f"{item.id} has no figure; leave out --out.")
    terminal.out().print(f"written: {notes_figure(item.figure).save(out)}", markup=False)


def _page(path: Path) -> None:
    from freebody_notes.contents import items
    from freebody_notes.page import pages

    made = {name: page() for name, page in pages(_run(items()), path.name).items()}
    written = [write(path.with_name(name), text) for name, text in made.items()]
    told = f"written: {written[0]}, with {written[1].name} to {written[-1].name} beside it"
    terminal.out().print(told, markup=False)


def _errata(out: Path | None) -> None:
    from freebody_notes.contents import items
    from freebody_notes.errata import errata

    text = errata(_run(items()))
    if out is None:
        terminal.out().print(text, markup=False, soft_wrap=True, end="")
        return
    terminal.out().print(f"written: {write(out, text)}", markup=False)


def _table(chapter: int | None, verdict: str | None) -> None:
    from freebody_notes.contents import items

    found = _run([x for x in items() if chapter is None or x.chapter == chapter])
    shown = [f for f in found if verdict is None or f.verdict == verdict]
    _list(shown)
    _summary(found)


def _list(shown: Sequence[ExecutedItem]) -> None:
    for number in dict.fromkeys(f.item.chapter for f in shown):
        _chapter(number, [f for f in shown if f.item.chapter == number])


def _chapter(number: int, found: Sequence[ExecutedItem]) -> None:
    from rich.table import Table
    from rich.text import Text

    table = Table(
        "item",
        "verdict",
        "what it says",
        box=None,
        pad_edge=False,
        header_style="bold",
        title_justify="left",
    )
    table.title = f"Chapter {number}"
    for f in found:
        said = f.item.title if f.verdict == "holds" else f"{f.item.title}: {f.item.why}"
        table.add_row(f.item.id, Text(f.verdict, COLOURS[f.verdict]), Text(said))
    terminal.out().print(table)
    terminal.out().print()


def _summary(found: Sequence[ExecutedItem]) -> None:
    from rich.text import Text

    from freebody_notes.item import VERDICTS

    line = Text(f"{len(found)} items executed: ")
    counts = [(verdict, sum(f.verdict == verdict for f in found)) for verdict in VERDICTS]
    words = {
        "holds": "hold",
        "misprint": "misprints",
        "inconsistent": "inconsistent",
        "incomplete": "incomplete",
    }
    for k, (verdict, count) in enumerate(counts):
        line.append(", " * bool(k))
        line.append(f"{count} {words[verdict]}", COLOURS[verdict])
    only = sum(f.item.is_text for f in found)
    line.append(f". {only} of them are text without an equation." if only else ".")
    terminal.out().print(line)
