"""Motions planned through waypoints and along paths of the tip, within limits."""
