"""Motions over time: planned, read from files, and simulated."""
