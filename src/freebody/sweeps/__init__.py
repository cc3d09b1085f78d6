"""Sweeps: one function over the grid of many parameters and states, with results reduced on the
way."""
