"""Quantities that answers are about: each file one group with their names and right values."""
