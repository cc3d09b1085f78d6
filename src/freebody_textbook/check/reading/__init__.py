"""The meaning of names, lines and formulas of an answer."""
