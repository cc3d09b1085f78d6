"""Robots that move in pages: the scene as data, placements as a kernel, and the one renderer."""
