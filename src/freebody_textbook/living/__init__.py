"""Interactive pages of derivations: the robot's kernel is included as JavaScript."""
