"""Numbers of answers: their units, and the states that they hold at."""
