"""The font in which pages set formulas, src/freebody/outputs/fonts/formulas.woff2: of TeX Gyre
Pagella Math what freebody prints, with its table of constants and constructions.

    python tools/math_font.py texgyrepagella-math.otf

Needs fonttools and brotli. The font is part of TeX distributions; its licence stands beside
formulas.woff2. Make it anew when a page has a letter that it lacks
(tests/textbook/pages/test_page_sizes.py).
"""

import sys
from pathlib import Path

TO = Path(__file__).parents[1] / "src/freebody/outputs/fonts/formulas.woff2"

LETTERS = {chr(c) for c in (*range(0x20, 0x7F), *range(0x391, 0x3AA), *range(0x3B1, 0x3CA))}
ITALIC = {chr(c) for c in (*range(0x1D434, 0x1D468), *range(0x1D6E2, 0x1D71C))} | set("ℎℓ")
BOLD = {chr(c) for c in range(0x1D400, 0x1D434)} | set("𝚽𝜶𝜽𝝀𝝆𝝉𝝎")
ACCENTS = set("\u0302\u0303\u0304\u0307\u0308\u20d7˙¨′″‴")
SIGNS = set("−×·⋅±∓∂∑∏√∫→←↦≤≥≠≈≡∝∞‖∥⊥∠°…⋯⋮⋱⟨⟩⊤∇∈ϕϑϵ")
UNASSIGNED = {"\u03a2", "\U0001d455"}
USED = (LETTERS | ITALIC | BOLD | ACCENTS | SIGNS) - UNASSIGNED


def main(source: str) -> None:
    """Write the part of the font that is used."""
    from fontTools import subset

    options = subset.Options(
        flavor="woff2",
        hinting=False,
        layout_features=["dtls"],
        name_IDs=[0, 1, 2],
        notdef_outline=True,
    )
    font = subset.load_font(source, options)
    if lacking := USED - set(map(chr, font.getBestCmap())):
        raise SystemExit(f"{source} lacks {sorted(lacking)}")
    subsetter = subset.Subsetter(options)
    subsetter.populate(unicodes=map(ord, USED))
    subsetter.subset(font)
    for name in font["name"].names:
        if name.nameID == 1:
            name.string = "Freebody Formulas"
    subset.save_font(font, str(TO), options)
    print(f"{TO}: {TO.stat().st_size} bytes")


if __name__ == "__main__":
    main(sys.argv[1])
