"""Motions over time: made, read from files, and simulated."""
