"""Motions worth logging: those that tell the most of a robot within its limits."""
