"""File formats of answers, one file each, and the table of their records."""

from __future__ import annotations

from freebody_textbook.check.documents import latex, markdown, notebook, plain, python_code
from freebody_textbook.check.documents.answer_document import AnswerDocument, DocumentForm

FORMS: dict[str, DocumentForm] = {
    form.name: form
    for form in (plain.FORM, markdown.FORM, latex.FORM, notebook.FORM, python_code.FORM)
}
"""Forms of documents by their names."""


def form_of(file_name: str) -> DocumentForm:
    """The format of a file, by its suffix; plain text if the suffix is unknown."""
    for form in FORMS.values():
        if file_name.lower().endswith(form.suffixes):
            return form
    return plain.FORM


__all__ = ["FORMS", "AnswerDocument", "DocumentForm", "form_of"]
