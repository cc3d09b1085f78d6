"""Abilities of an arm, and how it yields, place by place: maps over many postures."""
