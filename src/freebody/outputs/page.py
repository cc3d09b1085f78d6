"""The head of every HTML page, of studies, derivations and the course: a policy that makes "needs
no network" the browser's rule."""

from __future__ import annotations

import base64
import hashlib
from collections.abc import Sequence
from functools import cache
from importlib import resources


def policy(scripts: Sequence[str] = ()) -> str:
    """A `<meta>` element, to stand before anything that it governs: the page fetches nothing and
    runs only `scripts`.

    scripts: the exact text of each inline script of the page.
    """
    digests = (
        base64.b64encode(hashlib.sha256(text.encode()).digest()).decode() for text in scripts
    )
    allowed = " ".join(f"'sha256-{digest}'" for digest in digests) or "'none'"
    rules = (
        f"default-src 'none'; script-src {allowed}; style-src 'unsafe-inline'; img-src data: "
        f"blob:; font-src data:; base-uri 'none'; form-action 'none'"
    )
    return f'<meta http-equiv="Content-Security-Policy" content="{rules}">'


@cache
def math_style() -> str:
    """A style rule that contains a font for formulas, for pages with formulas: browsers without a
    mathematical font set brackets and accents badly."""
    font = resources.files("freebody.outputs").joinpath("fonts/formulas.woff2").read_bytes()
    data = base64.b64encode(font).decode()
    return (
        '@font-face{font-family:"Freebody Formulas";'
        f'src:url(data:font/woff2;base64,{data})format("woff2")}}'
        'math{font-family:"Freebody Formulas",math}'
    )


SHEETS = (
    "@media print{@page{margin:14mm 14mm 17mm;"
    "@bottom-center{content:counter(page);font:9pt system-ui,sans-serif;color:#5a6675}}"
    "summary{list-style:none}summary::-webkit-details-marker{display:none}}"
)
"""Rules of all pages for paper, A4 or Letter: margins, numbers of sheets, no marks of folding."""
