"""A docstring makes sense to whoever reads it alone, in an editor's window or a search: it begins
with what is returned or done."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator

import pytest

from support.sources import SOURCES, parsed, place

FRAGMENT = re.compile(
    r"(Without|From|Of|As|With|To|At|By|In|On|See|Into|Against|After|Before|Under|Like|Through|Over"
    r"|Between|Until|Up to|Above|Below|Beside"  # prepositions: the noun before them is missing
    r"|Those|That|These|It|They|And|Also|Else|Then"  # pointers to another text
    r"|What|Whoever|Whatever)\b"  # clauses in the place of the noun
    r"|The (others?|rest|\w+ (of|in|for|behind) (each|it|one|them|these|those))[.,:;]"
)


def docstrings(tree: ast.Module) -> Iterator[tuple[int, str]]:
    """Lines and first paragraphs of docstrings of modules, classes, functions and attributes."""
    for node in ast.walk(tree):
        body = getattr(node, "body", [])
        for k, entry in enumerate(body if isinstance(body, list) else []):
            match entry:
                case ast.Expr(ast.Constant(str(text))):
                    begins = k == 0 and not isinstance(node, (ast.If, ast.For, ast.With, ast.Try))
                    if begins or isinstance(body[k - 1], (ast.Assign, ast.AnnAssign)):
                        yield entry.lineno, " ".join(text.split("\n\n")[0].split())


@pytest.mark.parametrize(
    ("text", "is_fragment"),
    [
        ("From the pin to both ends.", True),
        ("What a file stands for.", True),
        ("The name of each.", True),
        ("Tokens that stand for a product.", False),
        ("Vectors from the pin to both ends of the chain.", False),
    ],
)
def test_what_is_a_fragment(text: str, is_fragment: bool):
    assert bool(FRAGMENT.match(text)) == is_fragment


def test_docstrings_make_sense_alone():
    read = [
        (f"{place(path)}:{line}", text)
        for path in SOURCES
        for line, text in docstrings(parsed(path))
    ]
    assert len(read) > 7000
    assert [(where, text) for where, text in read if FRAGMENT.match(text)] == []
