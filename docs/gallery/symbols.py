"""A robot with the symbols of its equations: joint axes, common normals, lengths."""

import freebody as fb

fb.kinematic_diagram(fb.load("ur5e"), [0.4, -1.2, 1.4, -1.7, -1.4, 0.3]).save("symbols.svg")
