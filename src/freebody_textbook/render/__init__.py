"""Renderers of expressions: one tree walk, `typesetter`, and a small file for each notation."""
