"""Expressions written as text, LaTeX and MathML: one typesetter, and a notation for each."""

from freebody.expressions.nodes import STYLES
from freebody.expressions.typesetting.latex import LATEX
from freebody.expressions.typesetting.mathml import mathml
from freebody.expressions.typesetting.text import TEXT

STYLES |= {"text": TEXT.line, "latex": LATEX.line, "mathml": mathml}
