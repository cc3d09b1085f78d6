"""Which points of a table an arm reaches with its gripper downwards, in how many ways, and how much
it carries there at most."""

import numpy as np

import freebody as fb

arm = fb.load("ur5e")
x, y = np.meshgrid(np.linspace(-1.0, 1.0, 41), np.linspace(-1.0, 1.0, 41), indexing="ij")
table = np.stack([x, y, np.full_like(x, 0.1)], axis=-1)
ways = fb.workspace(arm, table, orientation=np.diag([1.0, -1.0, -1.0])).ways
fb.map_diagram(arm, table, ways, title="ways to a point of the table").save("reach.svg")
