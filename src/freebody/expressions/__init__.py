"""Formulas: trees of expressions that are read, named and printed, and exact polynomials in sines
and cosines in the form that a textbook prints."""

import freebody.expressions.typesetting  # noqa: F401  (an expression can be printed wherever it comes from)
