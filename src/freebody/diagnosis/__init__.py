"""Faults of robot files, each with its place and remedy, and where two robots differ."""
