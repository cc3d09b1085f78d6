"""Closed chains in numbers: assembling, mobility, motion and reactions, parallel robots (notes, 2.3, 5.4)."""
