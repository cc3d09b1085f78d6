"""Closed forms: a model's equations as exact polynomials."""

import freebody.derivations.render.styles  # noqa: F401  (an expression can be printed wherever it comes from)
