"""Closed chains: closing them, their mobility, accelerations under forces, torques of their drives."""
