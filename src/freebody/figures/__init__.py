"""Drawings: what to draw is data in world metres (`Drawing`), which a small writer turns into SVG
text."""
