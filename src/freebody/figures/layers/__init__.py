"""Drawings of a robot, plane or space, in layers that are put together."""
