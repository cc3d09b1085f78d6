"""A table of formulas that can be computed, and the way from a formula to its kernel."""
