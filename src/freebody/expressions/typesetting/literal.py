"""Names from outside in sentences and formulas: set as they are, whatever characters they have.

A sentence of a derivation has symbols in it, such as s_1, and names of links and files, such as
`left_arm` or `a#1`, that are none. `literal` puts a name between two marks that cannot be seen;
each renderer sets what is between them letter by letter, escaped for its medium by one of the
functions here.
"""

from __future__ import annotations

import html
import re
from collections.abc import Callable

from freebody.expressions.printed_names import GREEK

MARK = "\u2060"
"""A word joiner: it has no width and no place in a name."""

_PLAIN = re.compile(r"[A-Za-z0-9]*")

GREEK_COMMANDS = {
    letter: "\\lambda" if name == "lam" else f"\\{name}" for name, letter in GREEK.items()
}
"""LaTeX's commands for Greek letters."""

TEX = {
    "\\": r"\textbackslash{}",
    "~": r"\textasciitilde{}",
    "^": r"\textasciicircum{}",
    "<": r"\textless{}",
    ">": r"\textgreater{}",
    "|": r"\textbar{}",
    '"': r"\textquotedbl{}",
    **{c: "\\" + c for c in "&%$#_{}"},
    **{letter: f"${command}$" for letter, command in GREEK_COMMANDS.items()},
    **{chr(0x2080 + k): f"$_{{{k}}}$" for k in range(10)},
    "−": "$-$",
    "–": "--",
    "—": "---",
}
"""Characters that LaTeX would read as something else, Greek letters, subscripts and dashes, in
text."""
_LETTERS = re.compile(rf"[A-Za-z{''.join(GREEK_COMMANDS)}][\u0307\u0308]|.", re.DOTALL)
_DOTS = {"\u0307": r"\dot", "\u0308": r"\ddot"}
_KNOWN = "\u017f"  # the last letter that pdfTeX has in T1 fonts


def literal(name: str) -> str:
    """A name for a sentence: on one line, and marked where it is more than letters and digits."""
    line = " ".join(name.replace(MARK, "").split())
    return line if _PLAIN.fullmatch(line) else f"{MARK}{line}{MARK}"


def in_parts(sentence: str, words: Callable[[str], str], name: Callable[[str], str]) -> str:
    """A sentence with its plain words mapped by `words` and the names marked in it by `name`."""
    parts = sentence.split(MARK)
    return "".join(name(part) if k % 2 else words(part) for k, part in enumerate(parts))


def tex(name: str) -> str:
    """A text escaped for LaTeX's text mode."""
    return "".join(map(_tex_letter, _LETTERS.findall(printable(name))))


def _tex_letter(letter: str) -> str:
    if len(letter) == 1:
        return TEX.get(letter, letter)
    return f"${_DOTS[letter[1]]}{{{GREEK_COMMANDS.get(letter[0], letter[0])}}}$"


def tex_math(name: str) -> str:
    r"""A text for LaTeX's math mode: as it is where that is safe, else as \text."""
    return name if _PLAIN.fullmatch(name) else f"\\text{{{tex(name)}}}"


def markdown(name: str) -> str:
    """A text escaped for Markdown, in a sentence or a table."""
    return re.sub(r"([\\`*_{}\[\]()<>#+\-.!|$~&])", r"\\\1", printable(name))


def web(name: str) -> str:
    """A text escaped for HTML."""
    return html.escape(printable(name))


def printable(name: str) -> str:
    """A text for a terminal: characters that would steer it, or turn the line around, are shown as
    �."""
    return "".join(c if c.isprintable() else "\ufffd" for c in name)


def declared(document: str) -> list[str]:
    r"""Lines of a LaTeX preamble that let pdfTeX print letters without a font as [U+5173]."""
    foreign = sorted(
        {c for c in document if c > _KNOWN and not "\u2000" <= c <= "\u206f" and c not in TEX}
    )
    if not foreign:
        return []
    names = [
        rf"\DeclareUnicodeCharacter{{{ord(c):04X}}}{{\ensuremath{{\text{{[U+{ord(c):04X}]}}}}}}"
        for c in foreign
    ]
    return [r"\ifdefined\XeTeXversion\else\ifdefined\directlua\else", *names, r"\fi\fi"]
