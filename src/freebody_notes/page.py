"""The notes as HTML pages, one with contents and errata and one per chapter: every item with its
verdict, drawn figures, a movable arm, folded solutions; nothing is fetched from the network."""

from __future__ import annotations

import html
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, partial
from pathlib import PurePath
from typing import Any
from urllib.parse import quote

import jinja2
from markupsafe import Markup

import freebody
from freebody.expressions.nodes import Equation, Words
from freebody.expressions.typesetting.mathml import lean, mathml
from freebody.figures import colours
from freebody.outputs.pages import SHEETS, math_style, policy
from freebody_notes.contents import Chapter, chapters
from freebody_notes.contents import item as found_item
from freebody_notes.derivation_places import Place, live_derivation, place_of
from freebody_notes.errata import entries
from freebody_notes.exercises import exercises, solution
from freebody_notes.figures.catalogue import notes_figure
from freebody_notes.item import SOURCE, VERDICTS, ExecutedItem, Item
from freebody_notes.text import shown
from freebody_textbook.derivation import Step
from freebody_textbook.render import documents
from freebody_textbook.render import equation_lines as formulas
from freebody_textbook.render.documents import LETTERS
from freebody_textbook.render.prose import web_prose
from freebody_textbook.render.styles import PANEL, SCROLLED, TOUCHED

WORDS = {
    "holds": "holds as printed", "misprint": "misprint", "inconsistent": "inconsistent",
    "incomplete": "incomplete",
}  # fmt: skip


COUNTED = {
    "holds": "hold as printed", "misprint": "misprints", "inconsistent": "inconsistent",
    "incomplete": "incomplete",
}  # fmt: skip

SHORT = 40_000
"""Bytes that a chapter's derivation may take once more, for phones."""


@dataclass(frozen=True)
class ItemCard:
    """An item as shown on a page of the notes."""

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
        """The item of the notes on this card."""
        return self.finding.item

    @property
    def verdict(self) -> str:
        """Text of the verdict on the item."""
        return WORDS[self.finding.verdict]


def pages(findings: Sequence[ExecutedItem], contents: str) -> Mapping[str, Callable[[], str]]:
    """Functions that make the HTML text of each page, by file name, the contents first; contents:
    file name of the contents page, from which the chapters' names are made."""
    names = [contents, *(_numbered(contents, number) for number in chapters())]
    told = [_chapter(number, chapter, findings) for number, chapter in chapters().items()]
    counts = {verdict: sum(f.verdict == verdict for f in findings) for verdict in VERDICTS}
    shared = {
        "files": list(map(quote, names)),
        "chapters": told,
        "version": freebody.__version__,
        "seconds": sum(f.seconds for f in findings),
        "colours": (colours.page_colours(dark=False), colours.page_colours(dark=True)),
        "small_style": Markup(SCROLLED + TOUCHED),
        "math_style": Markup(math_style() + SHEETS + formulas.STYLE),
        "figure_style": Markup(colours.style("@media screen and (prefers-color-scheme:dark)")),
    }
    front = partial(
        _page,
        "notes.html",
        shared,
        source=SOURCE,
        errata=entries(findings),
        badges=WORDS,
        counts=counts,
        words=COUNTED,
        total=len(findings),
        only_words=sum(f.item.is_text for f in findings),
    )
    return {contents: front} | {
        name: partial(_of_chapter, chapter, findings, shared)
        for name, chapter in zip(names[1:], told, strict=True)
    }


def _numbered(contents: str, number: int) -> str:
    path = PurePath(contents)
    return f"{path.stem}-{number}{path.suffix}"


def _page(
    template: str, shared: Mapping[str, Any], scripts: Sequence[str] = (), **more: Any
) -> str:
    """HTML of a page with its scripts; the first script decompresses and runs the others."""
    title = "Dynamics of robotic manipulators: the lecture notes, executed"
    given = {"title": title, "chapter": None, "live_style": ""} | dict(shared) | more
    head, script = Markup(policy(scripts)), Markup("".join(scripts[:1]))
    text = _templates().get_template(template).render(policy=head, script=script, **given)
    return lean(text)


def _of_chapter(
    chapter: Mapping[str, Any], findings: Sequence[ExecutedItem], shared: Mapping[str, Any]
) -> str:
    """HTML of a chapter's page, with a derivation whose numbers change with sliders."""
    number = chapter["number"]
    call, derivation = live_derivation(number)
    assert derivation.enliven is not None
    living = derivation.enliven(derivation)
    assert living is not None
    tried = documents.on_phones(documents.tried(living), derivation.steps, SHORT)
    body = tried.of(derivation)
    steps = "".join(
        body.step(step, f"{k} ").replace('<details open="">', "<details>")
        for k, step in enumerate(derivation.steps, 1)
    )
    return _page(
        "chapter.html",
        shared,
        (living.script, living.inflated),
        title=f"{number} {chapter['title']}",
        chapter=chapter,
        sections=_sections(number, findings),
        exercises=[(x, solution(x)) for x in exercises() if x.chapter == number],
        live={
            "call": call,
            "title": derivation.title,
            "panel": Markup(living.panel),
            "steps": Markup(steps),
        },
        live_style=Markup(PANEL),
    )


def _chapter(number: int, chapter: Chapter, findings: Sequence[ExecutedItem]) -> dict[str, Any]:
    own = [f for f in findings if f.item.chapter == number]
    return {
        "number": number,
        "title": chapter.title,
        "about": chapter.about,
        "used": chapter.used,
        "tasks": chapter.tasks,
        "count": len(own),
        "wrong": sum(f.verdict != "holds" for f in own),
    }


def _sections(
    number: int, findings: Sequence[ExecutedItem]
) -> list[tuple[str, str, list[ItemCard]]]:
    """Number, title and cards of each section of a chapter."""
    cards = _cards([f for f in findings if f.item.chapter == number])
    titles = chapters()[number].sections
    sections = dict.fromkeys(card.item.section for card in cards)
    return [(x, titles[x], [c for c in cards if c.item.section == x]) for x in sections]


def _cards(findings: Sequence[ExecutedItem]) -> list[ItemCard]:
    """Cards of items for a page; each derivation step is shown only once."""
    first: dict[Step, Item] = {}
    made = []
    for finding in findings:
        place = place_of(finding.item)
        if place is not None:
            first.setdefault(place.step, finding.item)
        made.append(_card(finding, place, first[place.step] if place is not None else None))
    return made


def _card(finding: ExecutedItem, place: Place | None, shown_at: Item | None) -> ItemCard:
    item = finding.item
    own = not item.same_as
    step = _equations(place.step.equations) if place and shown_at is item else ""
    return ItemCard(
        finding,
        tuple(map(found_item, item.same_as)),
        _form(item, item.printed) if own else Markup(),
        _form(item, item.corrected) if own and finding.corrected else Markup(),
        _drawn(item.figure) if item.is_figure else Markup(),
        item.check.call(item.printed or item.corrected),
        place,
        shown_at,
        Markup(step),
    )


def _drawn(number: str) -> Markup:
    """HTML of a figure's drawings, side by side where the page is wide enough."""
    return Markup("".join(picture.inline() for picture in notes_figure(number).pictures))


def _form(item: Item, form: str) -> Markup:
    """A formula as MathML, statements as text; relations between facts read from a drawing are not
    shown as formulas."""
    nodes = shown(item, form)
    if item.is_figure and not any(isinstance(node, Words) for node in nodes):
        return Markup()
    equations = [node for node in nodes if isinstance(node, Equation)]
    if nodes and len(equations) == len(nodes):
        return Markup(_equations(equations))
    rows = [_words(node.text) if isinstance(node, Words) else mathml(node) for node in nodes]
    return Markup("".join(rows))


def _equations(equations: Sequence[Equation]) -> str:
    """HTML of equations on long lines, and also on short lines if these are too long for a
    phone."""
    long, short = formulas.html([equations]), formulas.html([equations], LETTERS)
    return long if long == short else f'<div class="short">{short}</div><div>{long}</div>'


def _words(text: str) -> str:
    """HTML of words as a quotation; with an = they are a formula that cannot be parsed, set as
    code."""
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
