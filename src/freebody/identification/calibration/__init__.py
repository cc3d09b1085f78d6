"""From measured poses of a robot's tip to its geometry: `fb.calibrate`."""
