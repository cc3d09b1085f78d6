"""A table of formulas says what can be computed; this room holds the way from a name in it to its
kernel."""
