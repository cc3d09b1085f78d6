"""Positions and rates that bring a frame where it shall be."""
