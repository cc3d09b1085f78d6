"""How fast a tip can move in each direction, and how hard it can push: both from the Jacobian."""

import freebody as fb

arm = fb.planar("RR", l=[0.4, 0.3], lc=[0.2, 0.15], m=[2.0, 1.0], I=[0.03, 0.01])
fb.ellipsoid_diagram(arm, [0.4, 0.9]).save("ellipsoids.svg")
