"""The largest load over its distance from the flange, as makers print it, a curve for each joint
that limits it."""

import freebody as fb

arm = fb.load("ur5e")
fb.load_diagram(arm, [0.0, -1.0, 1.0, 0.0, 1.57, 0.0]).save("load_diagram.svg")
