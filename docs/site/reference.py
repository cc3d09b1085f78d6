"""A Sphinx extension: a page for each public name, from its docstring, in the groups of
docs/functions.md; and a link to it wherever a page names it."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

from docutils import nodes
from docutils.parsers.rst.states import Inliner
from numpy.typing import ArrayLike
from sphinx import addnodes
from sphinx.application import Sphinx
from sphinx.ext.napoleon import Config, NumpyDocstring
from sphinx.util.typing import stringify_annotation

import freebody as fb
from freebody.arrays import Array

EXPERIMENTAL = "## Experimental names"
ROW = re.compile(r"^\| `fb\.(\w+)` \| (.*) \|$")
CODE = re.compile(r"(``[^`]+``|`[^`\n]+`)")
SECTIONS = Config(napoleon_use_param=False, napoleon_use_rtype=False)
PUBLIC = re.compile(r"fb\.(\w+)(\(\))?")
SHORT = {
    stringify_annotation(ArrayLike, "smart"): "~numpy.typing.ArrayLike",
    stringify_annotation(Array, "smart"): "~numpy.ndarray",
}
"""What signatures call the aliases that Python writes out, one of them in a line and a half."""


def write_pages(app: Sphinx) -> None:
    """One page for each public name and an index of them by group, below docs/reference."""
    folder = Path(app.srcdir, "docs", "reference")
    folder.mkdir(exist_ok=True)
    index = ["Reference", "=========", "", "Every public name, from its docstring.", ""]
    experimental = _experimental(Path(app.srcdir, "docs", "releases.md"))
    for heading, names in _groups(Path(app.srcdir, "docs", "functions.md")):
        index += [heading, "-" * len(heading), "", ".. toctree::", "   :maxdepth: 1", ""]
        index += [*(f"   {name}" for name in names), ""]
        for name in names:
            _write(folder / f"{name}.rst", _page(name, experimental.get(name, "")))
    _write(folder / "index.rst", "\n".join(index))


def _groups(page: Path) -> list[tuple[str, list[str]]]:
    groups: list[tuple[str, list[str]]] = []
    for line in page.read_text(encoding="utf-8").splitlines():
        if line.startswith("## "):
            groups.append((line.removeprefix("## "), []))
        elif (row := ROW.match(line)) and row[1] in fb.__all__:
            groups[-1][1].append(row[1])
    return [(heading, names) for heading, names in groups if names]


def _experimental(page: Path) -> dict[str, str]:
    """Of each name that the releases' page calls experimental, what may change."""
    rows = page.read_text(encoding="utf-8").partition(EXPERIMENTAL)[2].splitlines()
    return {row[1]: row[2] for line in rows if (row := ROW.match(line))}


def _page(name: str, may_change: str) -> str:
    """A page in reStructuredText; of an experimental name it begins with what may change."""
    title = f"fb.{name}"
    what = getattr(fb, name)
    if isinstance(what, type):
        kind = "autoexception" if issubclass(what, BaseException) else "autoclass"
    else:
        kind = "autofunction" if callable(what) else "automodule"
    note = f".. admonition:: Experimental\n\n   {may_change}\n\n" if may_change else ""
    members = "" if kind == "autofunction" else "   :members:\n"
    return f"{title}\n{'=' * len(title)}\n\n{note}.. {kind}:: freebody.{name}\n{members}"


def _write(path: Path, text: str) -> None:
    """Leave a page alone that has not changed, so that Sphinx need not read it again."""
    if not path.exists() or path.read_text(encoding="utf-8") != text:
        path.write_text(text, encoding="utf-8")


def as_markup(
    app: Sphinx, what: str, name: str, obj: object, options: object, lines: list[str]
) -> None:
    """Make reStructuredText of a docstring, in place: its sections become lists, and what would be
    read as markup outside of code (products, norms, trailing underscores) is escaped."""
    for k, line in enumerate(lines):
        parts = CODE.split(line)
        parts[::2] = (re.sub(r"([*|]|(?<=\w)_\b)", r"\\\1", part) for part in parts[::2])
        lines[k] = "".join(parts)
    if what not in ("attribute", "property"):  # of these napoleon takes "words:" for a type
        lines[:] = NumpyDocstring(lines, SECTIONS, app, what, name, obj, options).lines()


def short(
    app: Sphinx,
    what: str,
    name: str,
    obj: object,
    options: object,
    signature: str | None,
    returned: str | None,
) -> tuple[str | None, str | None]:
    """A signature and what it returns, with the aliases of types by their names."""
    for spelled_out, alias in SHORT.items():
        signature = signature and signature.replace(spelled_out, alias)
        returned = returned and returned.replace(spelled_out, alias)
    return signature, returned


def public_or_code(
    name: str,
    rawtext: str,
    text: str,
    lineno: int,
    inliner: Inliner,
    options: dict[str, Any] | None = None,
    content: list[str] | None = None,
) -> tuple[list[nodes.Node], list[nodes.system_message]]:
    """The role of single backquotes in docstrings: code, and a link if it is a public name."""
    public = text.removeprefix("fb.")
    code = nodes.literal(text, text)
    return [_link(code, public) if public in fb.__all__ else code], []


def link_names(app: Sphinx, doctree: nodes.document) -> None:
    """Make links of public names in running text."""
    for code in list(doctree.findall(nodes.literal)):
        named = PUBLIC.fullmatch(code.astext())
        if named and named[1] in fb.__all__ and not _within_link(code):
            code.replace_self(_link(code.deepcopy(), named[1]))


def _within_link(node: nodes.Node | None) -> bool:
    while node and not isinstance(node, (addnodes.pending_xref, nodes.reference)):
        node = node.parent
    return node is not None


def _link(code: nodes.Node, name: str) -> addnodes.pending_xref:
    link = addnodes.pending_xref(
        "", refdomain="py", reftype="obj", reftarget=f"freebody.{name}", refexplicit=False
    )
    link += code
    return link


def setup(app: Sphinx) -> dict[str, bool]:
    """Register with Sphinx, which calls this."""
    app.connect("builder-inited", write_pages)
    app.connect("autodoc-process-docstring", as_markup)
    app.connect("autodoc-process-signature", short)
    app.connect("doctree-read", link_names)
    app.add_role("public_or_code", public_or_code)
    app.config.default_role = "public_or_code"
    return {"parallel_read_safe": True, "parallel_write_safe": True}
