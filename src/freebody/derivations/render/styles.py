"""What an expression's own text, LaTeX and MathML are."""

from freebody.derivations.expressions.nodes import STYLES
from freebody.derivations.render.latex import LATEX
from freebody.derivations.render.mathml import mathml
from freebody.derivations.render.text import TEXT

STYLES |= {"text": TEXT.line, "latex": LATEX.line, "mathml": mathml}
