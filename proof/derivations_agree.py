"""Lagrange's equations, Newton and Euler body by body, the recursive method and Kane's give the
same torques of a three-link arm, as exact polynomials, term by term."""

import freebody as fb

arm = fb.planar("RRP")
found = {m: fb.derive(arm, m).tau for m in ("lagrange", "newton-euler", "recursive", "kane")}
first = found["lagrange"]
for method, tau in found.items():
    assert tau == first, method
print(f"{len(found)} methods, three torques of each, identical")
