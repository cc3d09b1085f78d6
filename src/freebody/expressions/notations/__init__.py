"""Notations of courses and books: letters, angles, parameters given by formulas. A file each."""
