"""Free-body diagrams of a two-link arm: every force and moment to scale, in the symbols of the
derivation."""

import freebody as fb

arm = fb.load("2R")
fb.free_body_diagram(arm, [0.5, 1.0], qd=[1.0, 0.5]).save("free_bodies.svg")
