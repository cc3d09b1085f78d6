"""Loads that a robot carries: the largest payload along motions and over postures; load
diagrams."""
