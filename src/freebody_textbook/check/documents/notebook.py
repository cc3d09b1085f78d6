"""Reading Jupyter notebooks: Markdown cells, and code cells whose assignments are equations."""

from __future__ import annotations

import json
from typing import Any

from freebody.expressions.grammar.source import Span
from freebody_textbook.check.documents import markdown, python_code
from freebody_textbook.check.documents.answer_document import (
    AnswerDocument,
    Blanks,
    DocumentForm,
    FormulaPiece,
    plain_characters,
)
from freebody_textbook.check.spelling.answer_text import AnswerError


def read(text: str) -> AnswerDocument:
    """Document of a notebook: its cells in order, without outputs."""
    written, formulas, said = "", "", ""
    pieces: list[FormulaPiece] = []
    prose: list[Span] = []
    parts: list[tuple[str, int]] = []
    for number, (kind, source) in enumerate(_cells(text), 1):
        own, at = plain_characters(source), len(written)
        parts.append((f"cell {number}", at))
        found: list[FormulaPiece] = []
        if kind == "markdown":
            whole, heard, found, lines = markdown.parted(own)
            prose += ((at + start, at + end) for start, end in lines)
        else:
            whole, heard = Blanks(own), Blanks(own)
            if kind == "code":
                found = python_code.clean(whole, heard, (0, len(own)))
            else:
                whole.put(0, len(own))
                heard.put(0, len(own))
        pieces += (FormulaPiece(at + x.start, at + x.end, x.lenient) for x in found)
        written += own + "\n"
        formulas += str(whole) + "\n"
        said += str(heard) + "\n"
    return AnswerDocument(
        plain_characters(written),
        formulas,
        tuple(pieces),
        tuple(prose),
        tuple(parts),
        said,
        told=True,
    )


def _cells(text: str) -> list[tuple[str, str]]:
    """Kind and text of each cell."""
    try:
        notebook: Any = json.loads(text)
        cells = notebook["cells"] if isinstance(notebook, dict) else None
        found = [(cell["cell_type"], _joined(cell["source"])) for cell in cells or ()]
    except (ValueError, TypeError, KeyError, RecursionError):
        found = []
    if not found:
        raise AnswerError(
            "this is not a Jupyter notebook with cells (JSON, as .ipynb files are)",
            "Save it again, or give its text.",
        )
    return found


def _joined(source: Any) -> str:
    """Text of a notebook cell whose source is a string or a list of lines."""
    if isinstance(source, list):
        return "".join(line for line in source if isinstance(line, str))
    if isinstance(source, str):
        return source
    raise TypeError(type(source).__name__)


FORM = DocumentForm("notebook", "a Jupyter notebook", (".ipynb",), read)
