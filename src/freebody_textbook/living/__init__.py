"""Pages of derivations that can be tried: the robot's own kernel travels in them as JavaScript."""
