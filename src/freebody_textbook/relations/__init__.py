"""Formulas of a user between quantities that have names: read, valued, compared."""
