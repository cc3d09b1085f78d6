"""Closed chains: closing them, their mobility, accelerations under forces, drives' torques."""
