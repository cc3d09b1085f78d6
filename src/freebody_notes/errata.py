"""The list of errata as Markdown, to be sent to the author of the notes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from freebody.expressions.nodes import Words
from freebody_notes.item import SOURCE, ExecutedItem
from freebody_notes.text import shown
from freebody_textbook.render.prose import markdown_prose

_WORDS = {
    "misprint": "A misprint",
    "inconsistent": "It contradicts other equations of the notes",
    "incomplete": "It needs an addition",
}


@dataclass(frozen=True)
class Erratum:
    """An item that needs a correction, with the other items that state the same."""

    finding: ExecutedItem
    also: tuple[ExecutedItem, ...]


def entries(findings: Sequence[ExecutedItem]) -> list[Erratum]:
    """Errata in the order of the notes; items that repeat a wrong equation, such as an example with
    its results, are listed with the first one."""
    wrong = {f.item.id: f for f in findings if f.verdict != "holds"}
    joined: dict[str, list[ExecutedItem]] = {name: [] for name in wrong}
    for name, finding in wrong.items():
        first = next((other for other in finding.item.same_as if other in wrong), "")
        if first:
            del joined[name]
            joined[first].append(finding)
    return [Erratum(wrong[name], tuple(also)) for name, also in joined.items()]


def errata(findings: Sequence[ExecutedItem]) -> str:
    """The list of errata as Markdown: place, printed formula, the error and how it was found, the
    correction."""
    wrong = [finding for finding in findings if finding.verdict != "holds"]
    listed = entries(findings)
    counts = {verdict: sum(f.verdict == verdict for f in wrong) for verdict in _WORDS}
    lines = [
        "# Errata",
        "",
        f"to: {SOURCE}.",
        "",
        "With thanks for the notes, which were a pleasure to work through.",
        "",
        "Every numbered equation, formula, worked example and figure of chapters 1 to 6 was "
        f"checked by computation with freebody: {len(findings)} items, of which "
        f"{len(findings) - len(wrong)} hold as printed. The other {len(wrong)} are listed here in "
        f"the order of the notes, in {len(listed)} entries, since an example stands with the "
        f"equation that is its result: {counts['misprint']} misprints, {counts['inconsistent']} "
        f"places where the notes contradict themselves, and {counts['incomplete']} places that "
        "need an addition, exercises included. `freebody notes ID` repeats the check of an item.",
    ]
    chapter = 0
    for number, entry in enumerate(listed, 1):
        if entry.finding.item.chapter != chapter:
            chapter = entry.finding.item.chapter
            lines += ["", f"## Chapter {chapter}"]
        lines += ["", *_entry(number, entry.finding), *map(_repeated, entry.also)]
    return "\n".join(lines) + "\n"


def _entry(number: int, finding: ExecutedItem) -> list[str]:
    item = finding.item
    place = item.number[0].upper() + item.number[1:]
    kind = (
        "Left to the reader"
        if not item.printed and item.id.startswith("ex-")
        else _WORDS[finding.verdict]
    )
    rows = [
        f"### {number}. {place}: {item.title}",
        "",
        f"`{item.id}`, section {item.section}. {kind}.",
        "",
    ]
    rows.append(f"- Printed: {_form(finding, item.printed) or 'nothing'}")
    rows.append(f"- {markdown_prose(item.why)}")
    evidence = " ".join(finding.printed.lines[:3])
    if item.printed and not item.is_text:
        rows.append(f"- Evidence: {evidence}")
    if finding.printed.example:
        rows.append(f"- Counterexample: {finding.printed.example}")
    rows.append(
        f"- {'Should be' if item.printed else 'Could be added'}: "
        f"{_form(finding, item.corrected) or 'deleted.'}"
    )
    return rows


def _repeated(finding: ExecutedItem) -> str:
    item = finding.item
    place = f"section {item.section}, {item.label or item.title} (`{item.id}`)"
    return f"- The same in {place}. {markdown_prose(item.why)}"


def _form(finding: ExecutedItem, form: str) -> str:
    """A formula between dollar signs; statements in words unchanged."""
    nodes = shown(finding.item, form)
    return "; ".join(
        node.text if isinstance(node, Words) else f"${node.latex()}$" for node in nodes
    )
