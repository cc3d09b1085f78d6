"""Notations of courses and books (letters, angles, parameters given by formulas), each in a file of
its own."""
