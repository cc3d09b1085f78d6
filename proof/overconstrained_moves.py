"""Bricard's loop of six joints moves with one degree of freedom where the count of Grübler gives
none, and the Stewart platform has six."""

import freebody as fb

found = {}
for name in ("bricard", "stewart"):
    robot = fb.load(name)
    found[name] = fb.mobility(robot, fb.assemble(robot))
moves = {name: (mobility.generic, mobility.gruebler) for name, mobility in found.items()}
print("; ".join(f"{name} {k}, Grübler {by}" for name, (k, by) in moves.items()))
assert moves["bricard"] == (1, 0)
assert moves["stewart"][0] == 6
