"""`fb.calibrate`: a robot's geometry from measured poses of its tip."""
