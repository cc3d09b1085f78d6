"""Abilities of an arm, place by place: maps over many postures."""
