"""Meaning of the names, lines and formulas in an answer."""
