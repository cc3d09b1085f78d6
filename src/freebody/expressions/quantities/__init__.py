"""Kinds of quantities with their letters, units and words."""
