"""Renderers of expressions: one walk, `typesetter`, and a small file for each notation."""
