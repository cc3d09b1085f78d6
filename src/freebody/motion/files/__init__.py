"""Motions in files and tables, and the treatment of measured motions."""
