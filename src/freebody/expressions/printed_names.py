"""Printed forms of the names of code: theta1_d is θ̇₁, lc1 is l_c1, I1xx is I_1,xx, f01 is
f_0,1."""

from __future__ import annotations

import re

from freebody.expressions.nodes import Expression, Function, Symbol
from freebody.scalars.generators import SIGN, function_of, symbol_of

GREEK = {
    "alpha": "α",
    "beta": "β",
    "gamma": "γ",
    "delta": "δ",
    "epsilon": "ε",
    "zeta": "ζ",
    "eta": "η",
    "theta": "θ",
    "kappa": "κ",
    "lam": "λ",
    "mu": "μ",
    "nu": "ν",
    "xi": "ξ",
    "pi": "π",
    "rho": "ρ",
    "sigma": "σ",
    "tau": "τ",
    "phi": "φ",
    "chi": "χ",
    "psi": "ψ",
    "omega": "ω",
    "Lambda": "Λ",
    "Sigma": "Σ",
    "Phi": "Φ",
    "Psi": "Ψ",
    "Omega": "Ω",
    "Gamma": "Γ",
    "Delta": "Δ",
}
"""Names of letters, and the letters."""

COMPONENTS = ("fx", "fy", "fz")
"""Names of a load's components."""

DOTS = {"_d": 1, "_dd": 2}

_SHAPE = re.compile(r"([A-Za-z]+?)(c?)_?(\d+(?:_\d+)*)_?([A-Za-z]*)")


def sym(name: str, bold: bool = False) -> Expression:
    """The symbol of a name in code; of a name sgn_x the function sgn applied to the symbol of x."""
    if function_of(name) == SIGN:
        return Function(SIGN, sym(symbol_of(name), bold))
    stem, dots = _without_dots(name)
    letter, low = _parts(stem)
    return Symbol(name, letter, low, dots, bold)


def with_letter(name: str) -> str:
    """A name of code with its letter as it is written, τ12 of tau12."""
    stem = name.rstrip("0123456789")
    return GREEK.get(stem, stem) + name[len(stem) :]


def vec(name: str) -> Symbol:
    """The symbol of a vector's name, in bold."""
    symbol = sym(name, bold=True)
    assert isinstance(symbol, Symbol)
    return symbol


def entry(letter: str, *indices: int) -> Symbol:
    """An entry of an array, counted from 1: entry("H", 1, 2) is H₁₂, named H12; above 9 H_10_2."""
    small = len(indices) == 1 or all(i < 10 for i in indices)
    name = letter + ("" if small else "_") + ("" if small else "_").join(map(str, indices))
    low = ("".join(map(str, indices)),) if small else tuple(map(str, indices))
    return Symbol(name, GREEK.get(letter, letter), low)


def place(i: int, j: int) -> str:
    """The subscript for row i and column j of an entry: 12, or with a comma where a number is above
    9, 4,11."""
    return f"{i}{j}" if max(i, j) < 10 else f"{i},{j}"


def component(name: Symbol, label: str) -> Symbol:
    """The symbol of a component of a vector: its name and subscript are extended by a label, such
    as c2 to c2,x."""
    return Symbol(
        f"{name.name}_{label}",
        name.letter,
        (*name.low, *label.split(",")),
        name.dots,
        high=name.high,
    )


def _without_dots(name: str) -> tuple[str, int]:
    for ending, dots in reversed(DOTS.items()):
        if name.endswith(ending) and len(name) > len(ending):
            return name.removesuffix(ending), dots
    return name, 0


def _parts(stem: str) -> tuple[str, tuple[str, ...]]:
    """The letter and the subscripts of a name without dots."""
    match = _SHAPE.fullmatch(stem)
    if match is None:
        return _letter(stem)
    letters, centre, digits, axes = match.groups()
    if letters + centre in GREEK:
        letters, centre = letters + centre, ""
    letter, before = _letter(letters)
    parts = digits.split("_")
    if letters == "f" and len(digits) == 2:
        parts = list(digits)
    if len(axes) == 1 and len(parts) == 1:
        parts[-1] += axes
    elif axes:
        parts.append(axes)
    parts[0] = centre + parts[0]
    return letter, (*before, *parts)


def _letter(word: str) -> tuple[str, tuple[str, ...]]:
    """The letter and subscript of a word: a Greek letter by its name, a single letter as it is,
    otherwise the first letter with the rest as subscript."""
    if word in GREEK:
        return GREEK[word], ()
    if word in COMPONENTS:
        return word[0], (word[1],)
    head, _, tail = word.partition("_")
    if tail and head:
        return GREEK.get(head, head), (tail,)
    return word, ()
