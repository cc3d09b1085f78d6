"""Sweeps: one function over the grid of many parameters and states, reduced on the way."""
