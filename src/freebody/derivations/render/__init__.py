"""Renderers of expressions: one small file each, a table from node to template."""
