"""Closed chains in closed form: loop equations, how tip and drives move together, the equations of
the first kind."""
