"""Closed chains in closed form: loop equations, velocity relations between tip and drives,
Lagrange's equations of the first kind."""
