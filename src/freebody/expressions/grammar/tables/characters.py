"""Letters, marks, figures, commands and signs of formulas in plain text and LaTeX.

The tables are plain literals: whoever reads formulas in another language reads the same tables.
"""

from freebody.expressions.printed_names import GREEK

DOT, PRIME = "˙", "'"

LETTERS = {letter: name for name, letter in GREEK.items()} | {
    "ϑ": "theta",
    "ϕ": "phi",
    "λ": "lam",
    "ɡ": "g",
    "Θ": "Theta",
    "Φ": "Phi",
}
"""Letters that have a name."""

LETTER_COMMANDS = {name: name for name in GREEK} | {
    "lambda": "lam",
    "vartheta": "theta",
    "varphi": "phi",
    "Theta": "Theta",
    "Phi": "Phi",
    "ell": "l",
}
"""Commands of LaTeX for letters."""

FONTS = (
    "mathrm", "mathit", "mathbf", "mathsf", "mathcal", "boldsymbol", "bm", "text", "operatorname",
    "textrm", "rm", "vec",
)  # fmt: skip
"""Commands around letters that say nothing."""

ACCENTS = {
    "dot": DOT, "ddot": DOT * 2, "bar": "\u0304", "overline": "\u0304", "hat": "\u0302",
    "widehat": "\u0302", "tilde": "\u0303", "widetilde": "\u0303", "underline": "\u0332",
    "check": "\u030c", "breve": "\u0306", "mathring": "\u030a",
}  # fmt: skip
"""Commands for a mark on a letter."""

DECORATIONS = ("\u0304", "\u0302", "\u0303", "\u0332", "\u030c", "\u0306", "\u030a", "*")
"""Marks with which a letter is another quantity: θ̄, θ̂, θ*."""

MARKS = {
    "\u0307": DOT, "\u0308": DOT * 2, "˙": DOT, "¨": DOT * 2, "\u20d7": "", "\u0305": "\u0304",
    "\u0304": "\u0304", "\u0302": "\u0302", "\u0303": "\u0303", "\u0332": "\u0332",
    "\u030c": "\u030c", "\u0306": "\u0306", "\u030a": "\u030a",
}  # fmt: skip
"""Characters behind a letter that are a mark on it; an arrow only says that it is a vector."""

PRIMES = {"'": 1, "’": 1, "′": 1, "″": 2}
STARS = ("*", "∗", "⋆", "\\ast", "\\star")
"""Signs that are a mark where they stand as a power."""

LOW = {c: str(k) for k, c in enumerate("₀₁₂₃₄₅₆₇₈₉")} | {
    "ₐ": "a", "ₑ": "e", "ₒ": "o", "ₓ": "x", "ᵢ": "i", "ⱼ": "j", "ₘ": "m", "ₙ": "n", "ₚ": "p",
    "ₜ": "t",
}  # fmt: skip
HIGH = {c: str(k) for k, c in enumerate("⁰¹²³⁴⁵⁶⁷⁸⁹")} | {"⁻": "-", "⁺": ""}

OPERATORS = {
    "+": "+", "^": "^", "**": "^", "*": "*", "@": "*", "·": "*", "⋅": "*", "×": "*", "∗": "*",
    "∙": "*", "•": "*", "\\cdot": "*", "\\times": "*", "\\ast": "*", "-": "-", "−": "-", "–": "-",
    "—": "-", "‐": "-", "/": "/", "÷": "/", "∕": "/", "⁄": "/",
}  # fmt: skip
BRACKETS = {"(": ")", "[": "]", "{": "}", "\\{": "\\}"}
VULGAR_FRACTIONS = {
    "½": (1, 2), "⅓": (1, 3), "⅔": (2, 3), "¼": (1, 4), "¾": (3, 4), "⅕": (1, 5), "⅙": (1, 6),
    "⅛": (1, 8), "⅜": (3, 8),
}  # fmt: skip
FRACTIONS = ("\\frac", "\\tfrac", "\\dfrac")
RECIPROCALS = {"cot": "tan", "sec": "cos", "csc": "sin"}
"""Functions that are 1 over another."""
FUNCTION_COMMANDS = (
    "sin", "cos", "tan", "cot", "sec", "csc", "sqrt", "exp", "log", "ln", "arctan", "arccos",
    "arcsin", "sgn",
)  # fmt: skip
MATRICES = ("matrix", "pmatrix", "bmatrix", "Bmatrix", "vmatrix", "smallmatrix", "array")
"""LaTeX environments that hold a matrix; other environments are passed over."""

SILENT_COMMANDS = (
    "big", "bigl", "bigr", "bigm", "Big", "Bigl", "Bigr", "Bigm", "bigg", "biggl", "biggr", "biggm",
    "Bigg", "Biggl", "Biggr", "Biggm", "left", "right", "displaystyle", "textstyle", "quad",
    "qquad", "nonumber", ",", ";", ":", "!", "(", ")", "[", "]", " ", "\n",
)  # fmt: skip
"""Commands that say nothing about the matter."""
SILENT = "$~\u200b\u2061\u2062"
"""Characters that say nothing about the matter."""
FILL = "\x1f"
"""A blank that is shown with what stands before it, where a text was made shorter."""
SIGNS = ("**", "==", "<=", ">=", "!=", ":=")
"""The signs of two characters."""
TOTAL = "\ue01b"
"""The d of a derivative by a coordinate, as spellings have it."""
KINDS_OF_SIGNS = {
    "∂": "partial", TOTAL: "partial", "\\partial": "partial", "ᵀ": "transpose",
    "'": "transpose", "=": "equals", "==": "equals", ",": "comma", "&": "amp", "°": "degree",
    ";": "line", "\n": "line",
}  # fmt: skip
"""The kinds of tokens that further signs are."""
ANY_MARK = "\u0300-\u036f\u20d7˙¨"
"""Characters that belong to the letter before them, as in a class of a regular expression."""
