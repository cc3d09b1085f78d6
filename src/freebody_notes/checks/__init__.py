"""Ways to check an item of the notes: as an answer about a model, as a relation, against printed
digits, by a function, or by drawing its figure; statements that cannot be executed are read."""

from collections.abc import Mapping
from typing import Any

from freebody_notes.checks.calls import ARM
from freebody_notes.checks.evidence import number
from freebody_notes.checks.kinds import Answer, ByFunction, ByReading, Digits
from freebody_notes.checks.relation import Related

__all__ = ["ARM", "SHARED", "Answer", "ByFunction", "ByReading", "Digits", "Related", "number"]

SHARED: Mapping[str, Any] = {
    "arm": Related(),
    "answer": Answer(),
    "reading": ByReading(),
}
"""Checks that items of all chapters name; `right` and `reason` of a reading stand with the item."""
