"""What can be computed, as a table of formulas, and the way from a name in it to its kernel."""
