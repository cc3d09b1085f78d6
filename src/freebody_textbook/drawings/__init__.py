"""Drawings of derivations, and of their interactive pages."""
