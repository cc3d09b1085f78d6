"""Motions that torques cause."""
