"""Closed-form equations as exact polynomials, and their views: motion, kinematics,
singularities."""
