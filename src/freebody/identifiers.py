"""Names turned into identifiers that may stand in generated code.

A name from a file is data: nothing that is compiled, executed or parsed as code ever holds one.
Where generated text needs a word for a named thing, it comes from here.
"""

from __future__ import annotations

import keyword
import re
import unicodedata
from collections import Counter
from collections.abc import Collection, Iterable


def word_set(text: str) -> frozenset[str]:
    """Set of the words of a text."""
    return frozenset(text.split())


C_KEYWORDS = word_set(
    """alignas alignof and and_eq asm auto bitand bitor bool break case catch char char16_t char32_t
    class compl const constexpr const_cast continue decltype default delete do double dynamic_cast
    else enum explicit export extern false float for friend goto if inline int long mutable
    namespace new noexcept not not_eq nullptr operator or or_eq private protected public register
    reinterpret_cast restrict return short signed sizeof static static_assert static_cast struct
    switch template this thread_local throw true try typedef typeid typename union unsigned using
    virtual void volatile wchar_t while xor xor_eq NAN INFINITY HUGE_VAL"""
)
"""Words of C and C++, and macros of <math.h>."""

LONGEST = 63
"""Characters that a word may have (what C99 tells apart); a longer name is cut."""

# what begins with __ or _A is the language's own
_WORD = re.compile(r"(?!__|_[A-Z])[A-Za-z_][A-Za-z0-9_]*", re.ASCII)


def is_identifier(name: object) -> bool:
    """Whether a name may stand in generated code as it is: ASCII letters, digits and _, no word of
    Python's."""
    return isinstance(name, str) and bool(_WORD.fullmatch(name)) and not keyword.iskeyword(name)


def identifiers(names: Iterable[str], reserved: Collection[str] = ()) -> dict[str, str]:
    """A word for each name, all different and none of them reserved; a name that is such a word
    stays.

    theta1 for θ₁, left_joint1 for left/joint1, lambda_ for lambda; equal words get a number.
    """
    listed = list(dict.fromkeys(names))
    words = {x: x for x in listed if is_identifier(x) and len(x) <= LONGEST and x not in reserved}
    used, counts = {*words, *reserved}, Counter[str]()
    for name in listed:
        if name in words:
            continue
        base = word = _respelt(name, reserved)
        while word in used:
            counts[base] += 1
            word = f"{base}_{counts[base] + 1}"
        words[name] = word
        used.add(word)
    return {name: words[name] for name in listed}


def in_words(text: str) -> str:
    """Outside text as ASCII words, for a comment of generated code."""
    return " ".join(_respelt(part, ()) for part in text[:LONGEST].split()) or "unnamed"


def _respelt(name: str, reserved: Collection[str]) -> str:
    """An identifier of ASCII letters, digits and _ that resembles a name; it may still equal that
    of another name."""
    letters = "".join(map(_letter, unicodedata.normalize("NFKD", name[:LONGEST])))
    word = re.sub(r"[^A-Za-z0-9_]+", "_", letters).lstrip("_")
    word = word if word[:1].isalpha() else f"x{word}"
    return f"{word}_" if keyword.iskeyword(word) or word in reserved else word


def _letter(letter: str) -> str:
    """The English name of a Greek letter, nothing for an accent, any other character as it is."""
    if unicodedata.combining(letter):
        return ""
    kind, _, name = unicodedata.name(letter, "").partition(" LETTER ")
    if kind not in ("GREEK SMALL", "GREEK CAPITAL") or " " in name:
        return letter
    return name.lower() if kind.endswith("SMALL") else name.capitalize()
