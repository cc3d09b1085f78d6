"""Closed chains: closing them, their mobility, dynamics and reactions."""
