"""Drawings of a robot with symbols instead of numbers, as a textbook has them, in layers that are
put together."""
