"""Numbers in answers: their units, and the states they refer to."""
