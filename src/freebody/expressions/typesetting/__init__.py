"""Expressions as text, LaTeX and MathML."""
