"""Kinds of quantities with their letters, units and words, and the symbols of links."""
