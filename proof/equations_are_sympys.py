"""The closed-form equations of the two-link arm are those that SymPy's Lagrange method finds from
the energies, as expressions, not only at some numbers."""

import sympy as sp
from sympy.physics.mechanics import LagrangesMethod, dynamicsymbols

import freebody as fb

t = sp.Symbol("t")
a, b = dynamicsymbols("a b")
l1, lc1, lc2, m1, m2, I1, I2, g = sp.symbols("l1 lc1 lc2 m1 m2 I1 I2 g")
x1, y1 = lc1 * sp.cos(a), lc1 * sp.sin(a)
x2, y2 = l1 * sp.cos(a) + lc2 * sp.cos(a + b), l1 * sp.sin(a) + lc2 * sp.sin(a + b)
speed1, speed2 = x1.diff(t) ** 2 + y1.diff(t) ** 2, x2.diff(t) ** 2 + y2.diff(t) ** 2
T = m1 * speed1 / 2 + m2 * speed2 / 2 + I1 * a.diff(t) ** 2 / 2 + I2 * (a + b).diff(t) ** 2 / 2
theirs = LagrangesMethod(T - m1 * g * y1 - m2 * g * y2, [a, b]).form_lagranges_equations()

mine = fb.equations(fb.planar("RR")).to_sympy()["tau"]
by_name = {"theta1": a, "theta2": b, "theta1_d": a.diff(t), "theta2_d": b.diff(t)}
by_name |= {"theta1_dd": a.diff(t, 2), "theta2_dd": b.diff(t, 2)}
for one, other in zip(mine, theirs, strict=True):
    one = one.subs({s: by_name[s.name] for s in one.free_symbols if s.name in by_name})
    one = one.subs({s: sp.Symbol(s.name) for s in one.free_symbols})
    assert sp.simplify(sp.expand_trig(one - other)) == 0, sp.simplify(one - other)
print("two equations, differences simplified to 0")
