"""Closed forms as exact polynomials, and their views: motion, kinematics, singularities."""
