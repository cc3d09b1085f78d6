"""Closed forms: a model's equations as exact polynomials."""
