"""Drawings of derivations, and of the pages on which they can be tried."""
