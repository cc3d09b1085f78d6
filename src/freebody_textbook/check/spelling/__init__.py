"""Spellings of formulas in answers, converted to one plain spelling."""
