"""A Sphinx extension, and a program: Jupyter notebooks of those pages whose examples are Python.

    python docs/site/notebooks.py FOLDER

A page's text becomes cells of text, and each example a cell of code with what it shows at its end.
"""

from __future__ import annotations

import ast
import json
import re
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from sphinx.application import Sphinx

ROOT = Path(__file__).parents[2]
PAGES = {
    "equations": "start/equations.md",
    "in-a-program": "start/in-a-program.md",
    "a-study": "study.md",
    "answers-checked": "derivations.md",
}
"""Notebook -> the page of docs that it is made of."""
FENCE = re.compile(r"^```(\w+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
LINK = re.compile(r"!?\[([^]]*)\]\([^)]*\)")
EXAMPLE = re.compile(r"^>>> ", re.MULTILINE)
FIRST = """\
import sys

if sys.platform == "emscripten":  # JupyterLite, which runs Python in the browser
    import piplite

    await piplite.install(["freebody", "sympy"])"""


def notebook(page: str) -> dict[str, Any]:
    """The notebook of a page in Markdown."""
    title, _, text = page.partition("\n\n")
    cells = [_cell("markdown", title), _cell("code", FIRST)]
    past = 0
    for fence in FENCE.finditer(text):
        if fence[1] in ("python", "pycon"):
            cells.append(_cell("markdown", LINK.sub(r"\1", text[past : fence.start()])))
            cells += [_cell("code", code) for code in _examples(fence[1], fence[2])]
            past = fence.end()
    cells.append(_cell("markdown", LINK.sub(r"\1", text[past:])))
    kept = [cell for cell in cells if "".join(cell["source"]).strip()]
    kernel = {"display_name": "Python 3", "language": "python", "name": "python3"}
    for number, cell in enumerate(kept):
        cell["id"] = f"cell-{number}"
    return {
        "cells": kept,
        "metadata": {"kernelspec": kernel, "language_info": {"name": "python"}},
        "nbformat": 4,
        "nbformat_minor": 5,
    }


def _examples(kind: str, text: str) -> list[str]:
    """The code of a fenced block, split behind each statement that shows a value."""
    if kind == "python":
        return [text.strip()]
    found: list[list[str]] = [[]]
    for example in EXAMPLE.split(text)[1:]:
        first, *rest = example.splitlines()
        code = "\n".join([first, *(x[4:] for x in rest if x.startswith("... "))])
        found[-1].append(code)
        if isinstance(ast.parse(code).body[0], ast.Expr):
            found.append([])
    return ["\n".join(code) for code in found if code]


def _cell(kind: str, text: str) -> dict[str, Any]:
    code = {"execution_count": None, "outputs": []} if kind == "code" else {}
    lines = text.strip().splitlines(keepends=True)
    return {"cell_type": kind, "metadata": {}, "source": lines, **code}


def write(folder: Path) -> None:
    """Write all notebooks into a folder."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, page in PAGES.items():
        made = notebook((ROOT / "docs" / page).read_text(encoding="utf-8"))
        text = json.dumps(made, ensure_ascii=False, indent=1)
        (folder / f"{name}.ipynb").write_text(text + "\n", encoding="utf-8")


def write_pages(app: Sphinx) -> None:
    """The notebooks for the site, and a page that lists them."""
    folder = Path(app.srcdir, "docs", "notebooks")
    write(folder / "made" / "notebooks")
    lines = [
        "# Notebooks",
        "",
        "The pages of this site whose examples are Python, as Jupyter notebooks: `pip install`",
        "freebody beside `notebook` or `jupyterlab`, and open one. They are run whenever freebody",
        "is tested. What is known of freebody in a browser: [platforms](../platforms.md).",
        "",
    ]
    for name, page in PAGES.items():
        link = f'<a href="../../notebooks/{name}.ipynb" download>{name}.ipynb</a>'
        lines.append(f"- {link}, of [this page](../{page})")
    (folder / "index.md").write_text("\n".join([*lines, ""]), encoding="utf-8")


def setup(app: Sphinx) -> dict[str, bool]:
    """Register with Sphinx, which calls this."""
    Path(app.confdir, "notebooks", "made").mkdir(parents=True, exist_ok=True)
    app.connect("builder-inited", write_pages)
    return {"parallel_read_safe": True, "parallel_write_safe": True}


if __name__ == "__main__":
    write(Path(sys.argv[1]))
