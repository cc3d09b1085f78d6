"""Bricard's loop of six joints moves with one degree of freedom where the count of Grübler gives none,
and the Stewart platform has six."""

import freebody as fb

found = {}
for name in ("bricard", "stewart"):
    robot = fb.load(name)
    found[name] = fb.mobility(robot, fb.assemble(robot))
print(f"bricard {found['bricard'].generic} (Grübler {found['bricard'].gruebler}), stewart 6")
assert (found["bricard"].generic, found["bricard"].gruebler) == (1, 0)
assert found["stewart"].generic == 6
