"""What an expression's own text, LaTeX and MathML are."""

from freebody.derivations.expressions.nodes import STYLES
from freebody.derivations.render.latex import latex
from freebody.derivations.render.mathml import mathml
from freebody.derivations.render.text import text

STYLES |= {"text": text, "latex": latex, "mathml": mathml}
