"""Quantities that an answer may be about: each file has one group, with names and correct
values."""
