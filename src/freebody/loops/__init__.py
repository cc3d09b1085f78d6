"""Closed chains: closing their loops, mobility, accelerations under forces, and torques of
drives."""
