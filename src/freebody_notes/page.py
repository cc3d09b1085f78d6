"""The notes as one HTML page: every item with its verdict, figures drawn, solutions folded; nothing
is fetched."""

from __future__ import annotations

import html
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import jinja2
from markupsafe import Markup

import freebody
from freebody.derivations.derivation import Step
from freebody.derivations.expressions.nodes import Equation, Words
from freebody.derivations.render import page as formulas
from freebody.derivations.render.mathml import mathml
from freebody.derivations.render.prose import web_prose
from freebody.figures import colours
from freebody.outputs.page import math_style, policy
from freebody_notes.contents import Chapter, chapters
from freebody_notes.contents import item as found_item
from freebody_notes.errata import entries
from freebody_notes.exercises import exercises, solution
from freebody_notes.figures.catalogue import notes_figure
from freebody_notes.item import SOURCE, VERDICTS, ExecutedItem, Item
from freebody_notes.steps import Place, place_of
from freebody_notes.text import shown

WORDS = {
    "holds": "holds as printed", "misprint": "misprint", "inconsistent": "inconsistent",
    "incomplete": "incomplete",
}  # fmt: skip


COUNTED = {
    "holds": "hold as printed", "misprint": "misprints", "inconsistent": "inconsistent",
    "incomplete": "incomplete",
}  # fmt: skip


@dataclass(frozen=True)
class Card:
    """An item as the page shows it."""

    finding: ExecutedItem
    same_as: tuple[Item, ...]
    """The items that state the same: their formulas are not shown again."""
    printed: Markup
    corrected: Markup
    figure: Markup
    call: str
    place: Place | None
    """The step of a derivation in which it occurs."""
    shown_at: Item | None
    """The first item in that step, whose card shows its equations."""
    step: Markup

    @property
    def item(self) -> Item:
        """The item."""
        return self.finding.item

    @property
    def verdict(self) -> str:
        """In words."""
        return WORDS[self.finding.verdict]


def page(findings: Sequence[ExecutedItem]) -> str:
    """The whole page."""
    cards = _cards(findings)
    counts = {verdict: sum(f.verdict == verdict for f in findings) for verdict in VERDICTS}
    return (
        _templates()
        .get_template("notes.html")
        .render(
            policy=Markup(policy()),
            source=SOURCE,
            version=freebody.__version__,
            chapters=[_chapter(number, chapter, cards) for number, chapter in chapters().items()],
            errata=entries(findings),
            badges=WORDS,
            counts=counts,
            words=COUNTED,
            total=len(findings),
            only_words=sum(f.item.is_text for f in findings),
            seconds=sum(f.seconds for f in findings),
            exercises=[(exercise, solution(exercise)) for exercise in exercises()],
            colours=(colours.page_colours(dark=False), colours.page_colours(dark=True)),
            math_style=Markup(math_style() + formulas.STYLE),
            figure_style=Markup(colours.style("@media screen and (prefers-color-scheme:dark)")),
        )
    )


def _chapter(number: int, chapter: Chapter, cards: Sequence[Card]) -> dict:
    own = [c for c in cards if c.item.chapter == number]
    sections = dict.fromkeys(c.item.section for c in own)
    return {
        "number": number,
        "title": chapter.title,
        "about": chapter.about,
        "used": chapter.used,
        "tasks": chapter.tasks,
        "count": len(own),
        "wrong": sum(c.finding.verdict != "holds" for c in own),
        "sections": [
            (section, chapter.sections[section], [c for c in own if c.item.section == section])
            for section in sections
        ],
    }


def _cards(findings: Sequence[ExecutedItem]) -> list[Card]:
    """The items ready for the page, on which each step of a derivation stands once."""
    first: dict[Step, Item] = {}
    made = []
    for finding in findings:
        place = place_of(finding.item)
        if place is not None:
            first.setdefault(place.step, finding.item)
        made.append(_card(finding, place, first[place.step] if place is not None else None))
    return made


def _card(finding: ExecutedItem, place: Place | None, shown_at: Item | None) -> Card:
    item = finding.item
    own = not item.same_as
    step = formulas.html([place.step.equations]) if place and shown_at is item else ""
    return Card(
        finding,
        tuple(map(found_item, item.same_as)),
        _form(item, item.printed) if own else Markup(),
        _form(item, item.corrected) if own and finding.corrected else Markup(),
        Markup(notes_figure(item.figure).picture.inline()) if item.is_figure else Markup(),
        item.check.call(item.printed or item.corrected),
        place,
        shown_at,
        Markup(step),
    )


def _form(item: Item, form: str) -> Markup:
    """A form as MathML, words as they are; the facts read off a drawing are no formula of the
    notes."""
    nodes = shown(item, form)
    if item.is_figure and not any(isinstance(node, Words) for node in nodes):
        return Markup()
    equations = [node for node in nodes if isinstance(node, Equation)]
    if nodes and len(equations) == len(nodes):
        return Markup(formulas.html([equations]))
    rows = [_words(node.text) if isinstance(node, Words) else mathml(node) for node in nodes]
    return Markup("".join(rows))


def _words(text: str) -> str:
    """Words in italics; a formula that cannot be read as it was typed."""
    inside = html.escape(text)
    return f'<p class="quote">{f"<code>{inside}</code>" if "=" in text else inside}</p>'


@cache
def _templates() -> jinja2.Environment:
    environment = jinja2.Environment(
        loader=jinja2.ChoiceLoader(
            [jinja2.PackageLoader("freebody_notes"), jinja2.PackageLoader("freebody.report")]
        ),
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
        undefined=jinja2.StrictUndefined,
    )
    environment.filters["prose"] = lambda words: Markup(web_prose(words))
    return environment
