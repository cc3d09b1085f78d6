"""Ways to solutions of inverse kinematics: each takes a problem and returns what was found."""
