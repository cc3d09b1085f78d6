"""Parts of every HTML page, of studies, derivations and the course: in its head a policy that makes
"needs no network" the browser's rule; scripts, files of JavaScript joined without comments and most
blanks; and data that browsers inflate."""

from __future__ import annotations

import hashlib
import re
import zlib
from base64 import b64encode
from collections.abc import Iterable, Sequence
from functools import cache
from importlib import resources
from typing import Any

import numpy as np
from numpy.typing import NDArray


def policy(scripts: Sequence[str] = ()) -> str:
    """A `<meta>` element, to stand before anything that it governs: the page fetches nothing and
    runs only `scripts`.

    scripts: the exact text of each inline script of the page.
    """
    digests = (b64encode(hashlib.sha256(text.encode()).digest()).decode() for text in scripts)
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
    data = b64encode(font).decode()
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


_SHADE = "linear-gradient({},#5a7fb8b0,#5a7fb800) {} 1px top 1px/.9rem calc(100% - 2px)"
_COVER = "linear-gradient({},var(--paper) 40%,#0000) {} -1px top 0/2.6rem 100% local"
_EDGES = (("90deg", "left"), ("270deg", "right"))
_LAYERS = ",".join(form.format(*edge) for form in (_COVER, _SHADE) for edge in _EDGES)


def edged(selectors: str) -> str:
    """The style of elements that can be wider than the window: a shaded edge as long as something
    is hidden behind it. The shades stand still, the covers above them, of the colour of the page,
    scroll with the content. A shade begins a pixel inside: where a pixel of the screen lies half in
    the element, its cover hides it by half."""
    layers = f"background:{_LAYERS} var(--paper);background-repeat:no-repeat"
    return f"@media screen{{{selectors}{{{layers}}}}}\n"


def packed(data: str | bytes) -> str:
    """Deflate-compressed text or bytes in base64, which browsers can decompress."""
    raw = data.encode() if isinstance(data, str) else data
    return b64encode(zlib.compress(raw, 9)).decode()


def packed_numbers(x: NDArray[Any], stride: int = 1) -> str:
    """Numbers as a page inflates them, without loss: bits as integers, each less the one `stride`
    before, twice, which leaves little of smooth curves; bytes of equal weight stand together."""
    little = np.ascontiguousarray(x, dtype=x.dtype.newbyteorder("<"))
    bits = little.view(f"<u{x.dtype.itemsize}").ravel()
    for _ in range(2):
        before = np.zeros_like(bits)
        before[stride:] = bits[:-stride]
        bits = bits - before  # modulo the integers' size
    return packed(bits.view(np.uint8).reshape(-1, x.dtype.itemsize).T.tobytes())


def joined(package: str, names: Iterable[str]) -> str:
    """The script files of a package joined, without comments."""
    folder = resources.files(package)
    text = "\n".join(folder.joinpath(name).read_text(encoding="utf-8") for name in names)
    lines = filter(None, (line.partition("  // ")[0].strip() for line in text.splitlines()))
    return "\n".join(_dense(line) for line in lines if not line.startswith("//"))


_QUOTED = re.compile(r"""("(?:\\.|[^"\\])*"|`[^`]*`)""")
_BLANKS = re.compile(
    r" (?=[=<>?:,;{}()\[\]&|*])|(?<=[=<>?:,;{}()\[\]&|*!]) (?![-+])"
    r"|(?<=[\w)\]]) (?=[-+] [\w(\[])|(?<=[\w)\]] [-+]) (?=[\w(\[])"
)
"""Around signs, but where two would be another."""


def _dense(line: str) -> str:
    """A script line without most blanks; a line that may contain a regular expression is
    unchanged."""
    parts = _QUOTED.split(line)
    if any("/" in code for code in parts[::2]):
        return line
    return "".join(x if k % 2 else _BLANKS.sub("", x) for k, x in enumerate(parts))
