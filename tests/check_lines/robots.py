"""The bundled robots as mechanisms, from their files' dimensions."""

import functools
import math
from collections.abc import Sequence

import sympy as sp

from .mechanisms import Body, Mechanism, S

sin, cos = sp.sin, sp.cos


def _bars(word: str) -> tuple[tuple[str, ...], list[Body], tuple[sp.Expr, sp.Expr]]:
    """A serial arm of bars in the plane."""
    x = y = phi = sp.Integer(0)
    names, bodies = [], []
    for i, letter in enumerate(word, 1):
        if letter == "R":
            names.append(f"th{i}")
            phi = phi + S(f"th{i}")
            at = sp.Integer(0)
        else:
            names.append(f"d{i}")
            at = S(f"d{i}")
        centre = at + S(f"lc{i}")
        bodies.append(
            Body(S(f"m{i}"), S(f"I{i}"), (x + centre * cos(phi), y + centre * sin(phi)), phi)
        )
        end = at + S(f"l{i}")
        x, y = x + end * cos(phi), y + end * sin(phi)
    return tuple(names), bodies, (x, y)


BARS = {"l1": 1.0, "lc1": 0.5, "m1": 6.0, "I1": 0.5, "l2": 0.8, "lc2": 0.4, "m2": 3.0, "I2": 0.16}
BARS3 = {**BARS, "l3": 0.4, "lc3": 0.2, "m3": 1.5, "I3": 0.02}
ACROBOT = {
    "l1": 1.0,
    "lc1": 0.5,
    "m1": 1.0,
    "I1": 1 / 12,
    "l2": 1.2,
    "lc2": 0.6,
    "m2": 1.0,
    "I2": 0.12,
}
PENDUBOT = {
    "l1": 0.2,
    "lc1": 0.1,
    "m1": 0.8,
    "I1": 0.008 / 3,
    "l2": 0.3,
    "lc2": 0.15,
    "m2": 0.3,
    "I2": 0.00225,
}
G = {"g": 9.81}


def _arm(name: str, word: str, values: dict[str, float], passive: Sequence[str] = ()) -> Mechanism:
    names, bodies, tip = _bars(word)
    return Mechanism(name, names, tuple(bodies), G | values, tuple(passive), tip=tip)


def arm_of(name: str, word: str) -> Mechanism:
    """A planar arm of this word, as `fb.planar` describes it: the link of a slide has no length."""
    names, bodies, tip = _bars(word)
    zero = {S(f"l{i}"): 0 for i, letter in enumerate(word, 1) if letter == "P"}
    placed = tuple(
        Body(b.mass, b.inertia, tuple(sp.sympify(x).subs(zero) for x in b.centre), b.turn)
        for b in bodies
    )
    kept = {x: y for x, y in BARS3.items() if int(x[-1]) <= len(word) and S(x) not in zero}
    return Mechanism(name, names, placed, G | kept, tip=tuple(x.subs(zero) for x in tip))


def _rp() -> Mechanism:
    names, bodies, tip = _bars("RP")
    values = {"l1": 0.0, "lc1": 0.25, "m1": 6.0, "I1": 0.125}
    values |= {"l2": 0.4, "lc2": 0.2, "m2": 3.0, "I2": 0.04}
    zero = {S("l1"): 0}
    bodies = [
        Body(b.mass, b.inertia, tuple(sp.sympify(x).subs(zero) for x in b.centre), b.turn)
        for b in bodies
    ]
    values.pop("l1")
    return Mechanism("RP", names, tuple(bodies), G | values, tip=tuple(x.subs(zero) for x in tip))


def _cart_pole() -> Mechanism:
    x, th = S("x"), S("th2")
    bob = (x + S("l2") * sin(th), -S("l2") * cos(th))
    bodies = (Body(S("m1"), 0, (x, sp.Integer(0))), Body(S("m2"), 0, bob, th))
    values = G | {"m1": 2.0, "m2": 0.5, "l2": 0.6}
    return Mechanism("cart_pole", ("x", "th2"), bodies, values, ("th2",))


def _reaction_wheel() -> Mechanism:
    phi = S("th1")
    at = (-S("lc1") * sin(phi), S("lc1") * cos(phi))
    wheel = (-S("l1") * sin(phi), S("l1") * cos(phi))
    bodies = (Body(S("m1"), S("I1"), at, phi), Body(S("m2"), S("I2"), wheel, phi + S("th2")))
    values = G | {"l1": 0.125, "lc1": 0.063, "m1": 0.02, "I1": 0.000047, "m2": 0.3, "I2": 0.00032}
    return Mechanism("reaction_wheel", ("th1", "th2"), bodies, values, ("th1",), tip=wheel)


def _ball_and_beam() -> Mechanism:
    th, d, r = S("th1"), S("d2"), S("r")
    ball = (d * cos(th) - r * sin(th), d * sin(th) + r * cos(th))
    bodies = (
        Body(S("m1"), S("I1"), (sp.Integer(0), sp.Integer(0)), th),
        Body(S("m2"), 0, ball, th),
    )
    values = G | {"m1": 0.6, "I1": 0.05, "m2": 0.11, "J2": 0.044, "r": 0.015}
    rotor = S("J2") * S("d2_d") ** 2 / 2
    return Mechanism(
        "ball_and_beam", ("th1", "d2"), bodies, values, ("d2",), tip=ball, kinetic=rotor
    )


def _turn(axis: str, by: sp.Expr) -> sp.Matrix:
    c, s = cos(by), sin(by)
    return {
        "z": sp.Matrix([[c, -s, 0], [s, c, 0], [0, 0, 1]]),
        "y": sp.Matrix([[c, 0, s], [0, 1, 0], [-s, 0, c]]),
        "x": sp.Matrix([[1, 0, 0], [0, c, -s], [0, s, c]]),
    }[axis]


def _cylindrical() -> Mechanism:
    th, d2, d3 = S("th1"), S("d2"), S("d3")
    turn = _turn("z", th)
    at = d3 - S("lc3")
    bodies = (
        Body(S("m1"), (S("I1"),) * 3, (sp.Integer(0),) * 3, turn),
        Body(S("m2"), (0, 0, 0), (sp.Integer(0), sp.Integer(0), d2), turn),
        Body(S("m3"), (0, S("I3"), S("I3")), (at * cos(th), at * sin(th), d2), turn),
    )
    values = G | {"m1": 8.0, "I1": 0.06, "m2": 5.0, "m3": 4.0, "lc3": 0.3, "I3": 0.12}
    tip = (d3 * cos(th), d3 * sin(th), d2)
    return Mechanism("cylindrical_arm", ("th1", "d2", "d3"), bodies, values, tip=tip)


def _polar() -> Mechanism:
    th, tilt, d3 = S("th1"), S("th2"), S("d3")
    turn = _turn("z", th) * _turn("y", -tilt)
    out = turn * sp.Matrix([1, 0, 0])
    at = d3 - S("lc3")
    base = sp.Matrix([0, 0, S("l1")])
    bodies = (
        Body(S("m1"), (S("I1"),) * 3, (sp.Integer(0),) * 3, _turn("z", th)),
        Body(S("m2"), (0, S("I2"), S("I2")), tuple(base), turn),
        Body(S("m3"), (0, S("I3"), S("I3")), tuple(base + at * out), turn),
    )
    values = G | {"l1": 0.6, "m1": 8.0, "I1": 0.06, "m2": 5.0, "I2": 0.08, "m3": 4.0}
    values |= {"lc3": 0.3, "I3": 0.12}
    tip = tuple(base + d3 * out)
    return Mechanism("polar_arm", ("th1", "th2", "d3"), bodies, values, tip=tip)


def _elbow() -> Mechanism:
    a, b, c = S("th1"), S("th2"), S("th3")
    turn2 = _turn("z", a) * _turn("y", -b)
    turn3 = _turn("z", a) * _turn("y", -b - c)
    base = sp.Matrix([0, 0, S("l1")])
    x = sp.Matrix([1, 0, 0])
    elbow = base + S("l2") * turn2 * x
    bodies = (
        Body(S("m1"), (S("I1"),) * 3, (sp.Integer(0),) * 3, _turn("z", a)),
        Body(S("m2"), (0, S("I2"), S("I2")), tuple(base + S("lc2") * turn2 * x), turn2),
        Body(S("m3"), (0, S("I3"), S("I3")), tuple(elbow + S("lc3") * turn3 * x), turn3),
    )
    values = G | {"l1": 0.5, "m1": 8.0, "I1": 0.05, "l2": 0.6, "lc2": 0.3, "m2": 6.0, "I2": 0.18}
    values |= {"l3": 0.5, "lc3": 0.25, "m3": 4.0, "I3": 1 / 12}
    tip = tuple(elbow + S("l3") * turn3 * x)
    return Mechanism("elbow_arm", ("th1", "th2", "th3"), bodies, values, tip=tip)


def _furuta() -> Mechanism:
    a, b = S("th1"), S("th2")
    turn2 = _turn("z", a) * _turn("x", b)
    out = _turn("z", a) * sp.Matrix([1, 0, 0])
    up = turn2 * sp.Matrix([0, 0, 1])
    bodies = (
        Body(S("m1"), (0, S("I1"), S("I1")), tuple(S("lc1") * out), _turn("z", a)),
        Body(S("m2"), (S("I2"), S("I2"), 0), tuple(S("l1") * out + S("lc2") * up), turn2),
    )
    values = G | {"l1": 0.2, "lc1": 0.1, "m1": 0.3, "I1": 0.001, "lc2": 0.15, "m2": 0.1}
    values |= {"I2": 0.00075}
    return Mechanism("furuta", ("th1", "th2"), bodies, values, ("th2",))


def _gantry() -> Mechanism:
    x, y, a, b = S("x"), S("y"), S("th3"), S("th4")
    turn = _turn("x", sp.pi) * _turn("x", a) * _turn("y", b)
    load = sp.Matrix([x, y, 0]) + S("l") * turn * sp.Matrix([0, 0, 1])
    bodies = (
        Body(S("m1"), (0, 0, 0), (x, sp.Integer(0), sp.Integer(0))),
        Body(S("m2"), (0, 0, 0), (x, y, sp.Integer(0))),
        Body(0, (0, 0, 0), (x, y, sp.Integer(0))),  # between the two turns of the hook
        Body(S("m"), (0, 0, 0), tuple(load), turn),
    )
    values = G | {"m1": 120.0, "m2": 40.0, "m": 60.0, "l": 1.5}
    return Mechanism("gantry_crane", ("x", "y", "th3", "th4"), bodies, values, ("th3", "th4"))


def _scara() -> Mechanism:
    a, b, d, e = S("th1"), S("th2"), S("d3"), S("th4")
    R = sp.Rational
    l1, l2 = R("0.425"), R("0.375")
    phi = a + b
    arm = (l1 / 2 * cos(a), l1 / 2 * sin(a))
    elbow = (l1 * cos(a), l1 * sin(a))
    fore = (elbow[0] + l2 / 2 * cos(phi), elbow[1] + l2 / 2 * sin(phi))
    wrist = (elbow[0] + l2 * cos(phi), elbow[1] + l2 * sin(phi))
    down = _turn("z", phi) * _turn("x", sp.pi)
    hand = down * _turn("z", e)
    top = R("0.877")
    bodies = (
        Body(12, (R("0.045"), R("0.2"), R("0.2")), (*arm, top), _turn("z", a)),
        Body(8, (R("0.03"), R("0.1"), R("0.1")), (*fore, top), down),
        Body(2, (R("0.016"), R("0.016"), R("0.0004")), (*wrist, top - d + R("0.15")), down),
        Body(
            R("0.5"),
            (R("0.0005"), R("0.0005"), R("0.0003")),
            (*wrist, top - d - R("0.15")),
            hand,
        ),
    )
    tip = (*wrist, top - d - R("0.2"))
    return Mechanism("scara", ("th1", "th2", "d3", "th4"), bodies, dict(G), tip=tip)


def _gyro() -> Mechanism:
    turn = _turn("z", S("th1")) * _turn("x", S("th2"))
    zero = (sp.Integer(0),) * 3
    bodies = (Body(0, (0, 0, 0), zero, _turn("z", S("th1"))), Body(1, (10, 5, 5), zero, turn))
    return Mechanism("gyro", ("th1", "th2"), bodies, dict(G))


def _four_bar() -> Mechanism:
    a, b, c = S("th1"), S("th2"), S("th3")
    l1, l2, l3, d = S("l1"), S("l2"), S("l3"), S("d")
    pin = (l1 * cos(a), l1 * sin(a))
    end = (pin[0] + l2 * cos(a + b), pin[1] + l2 * sin(a + b))
    bodies = (
        Body(S("m1"), S("I1"), (S("lc1") * cos(a), S("lc1") * sin(a)), a),
        Body(
            S("m2"),
            S("I2"),
            (pin[0] + S("lc2") * cos(a + b), pin[1] + S("lc2") * sin(a + b)),
            a + b,
        ),
        Body(S("m3"), S("I3"), (d + S("lc3") * cos(c), S("lc3") * sin(c)), c),
    )
    loops = (end[0] - d - l3 * cos(c), end[1] - l3 * sin(c))
    values = G | {"d": 1.0, "l1": 0.3, "lc1": 0.15, "m1": 0.6, "I1": 0.0045, "l2": 0.9}
    values |= {"lc2": 0.45, "m2": 1.8, "I2": 0.1215, "l3": 0.7, "lc3": 0.35, "m3": 1.4}
    values |= {"I3": 0.0572}
    home = {"th1": math.radians(60), "th2": math.radians(-40), "th3": math.radians(90)}
    return Mechanism(
        "four_bar",
        ("th1", "th2", "th3"),
        bodies,
        values,
        ("th2", "th3"),
        loops,
        end,
        home,
        serial=False,
    )


def _slider_crank() -> Mechanism:
    a, b, d = S("th1"), S("th2"), S("d3")
    l1, l2 = S("l1"), S("l2")
    pin = (l1 * cos(a), l1 * sin(a))
    bodies = (
        Body(S("m1"), S("I1"), (S("lc1") * cos(a), S("lc1") * sin(a)), a),
        Body(
            S("m2"),
            S("I2"),
            (pin[0] + S("lc2") * cos(a + b), pin[1] + S("lc2") * sin(a + b)),
            a + b,
        ),
        Body(S("m3"), 0, (d, sp.Integer(0))),
    )
    loops = (pin[0] + l2 * cos(a + b) - d, pin[1] + l2 * sin(a + b))
    values = G | {"l1": 0.2, "lc1": 0.1, "m1": 1.0, "I1": 0.00333, "l2": 0.6, "lc2": 0.3}
    values |= {"m2": 1.5, "I2": 0.045, "m3": 2.0}
    home = {"th1": math.radians(50), "th2": math.radians(-65), "d3": 0.7}
    return Mechanism(
        "slider_crank",
        ("th1", "th2", "d3"),
        bodies,
        values,
        ("th2", "d3"),
        loops,
        (),
        home,
        serial=False,
    )


def _five_bar() -> Mechanism:
    t = [S(f"th{i}") for i in range(1, 5)]
    b = S("b")
    ends = []
    bodies: dict[int, Body] = {}
    for crank, (foot, i, k) in enumerate(((-b, 1, 3), (b, 2, 4))):
        a, e = t[crank], t[crank] + t[crank + 2]
        pin = (foot + S(f"l{i}") * cos(a), S(f"l{i}") * sin(a))
        bodies[i] = Body(
            S(f"m{i}"), S(f"I{i}"), (foot + S(f"lc{i}") * cos(a), S(f"lc{i}") * sin(a)), a
        )
        centre = (pin[0] + S(f"lc{k}") * cos(e), pin[1] + S(f"lc{k}") * sin(e))
        bodies[k] = Body(S(f"m{k}"), S(f"I{k}"), centre, e)
        ends.append((pin[0] + S(f"l{k}") * cos(e), pin[1] + S(f"l{k}") * sin(e)))
    loops = tuple(y - x for x, y in zip(*ends, strict=True))
    values = G | {"b": 0.25}
    for i, l, m, inertia in (
        (1, 0.4, 0.8, 0.01067),
        (2, 0.4, 0.8, 0.01067),
        (3, 0.6, 0.6, 0.018),
        (4, 0.6, 0.6, 0.018),
    ):
        values |= {f"l{i}": l, f"lc{i}": l / 2, f"m{i}": m, f"I{i}": inertia}
    home = dict(
        zip(("th1", "th2", "th3", "th4"), map(math.radians, (120, 60, -65, 65)), strict=True)
    )
    return Mechanism(
        "five_bar",
        ("th1", "th2", "th3", "th4"),
        tuple(bodies[i] for i in range(1, 5)),
        values,
        ("th3", "th4"),
        loops,
        ends[0],
        home,
        serial=False,
    )


def _five_bar_rods() -> Mechanism:
    b, x, y = S("b"), S("x"), S("y")
    bodies = []
    loops = []
    for i, foot in ((1, -b), (2, b)):
        a = S(f"th{i}")
        bodies.append(
            Body(S(f"m{i}"), S(f"I{i}"), (foot + S(f"lc{i}") * cos(a), S(f"lc{i}") * sin(a)), a)
        )
        loops.append(
            (x - foot - S(f"l{i}") * cos(a)) ** 2
            + (y - S(f"l{i}") * sin(a)) ** 2
            - S(f"l{i + 2}") ** 2
        )
    bodies.append(Body(0, 0, (x, sp.Integer(0))))
    bodies.append(Body(S("m3"), 0, (x, y)))
    values = G | {"b": 0.25, "l1": 0.4, "lc1": 0.2, "m1": 0.8, "I1": 0.01067, "l2": 0.4}
    values |= {"lc2": 0.2, "m2": 0.8, "I2": 0.01067, "m3": 1.0, "l3": 0.6, "l4": 0.6}
    home = {"th1": math.radians(120), "th2": math.radians(60), "x": 0.0, "y": 0.75}
    return Mechanism(
        "five_bar_rods",
        ("th1", "th2", "x", "y"),
        tuple(bodies),
        values,
        ("x", "y"),
        tuple(loops),
        (),
        home,
        serial=False,
    )


def _double_four_bar() -> Mechanism:
    t = [S(f"th{i}") for i in range(1, 6)]
    half = sp.Rational(1, 2)
    inertia = sp.Rational(1, 12)

    def bar(foot: tuple[sp.Expr, sp.Expr], turn: sp.Expr) -> Body:
        return Body(1, inertia, (foot[0] + half * cos(turn), foot[1] + half * sin(turn)), turn)

    zero = sp.Integer(0)
    tips = [(cos(t[0]), sin(t[0])), (1 + cos(t[2]), sin(t[2])), (2 + cos(t[4]), sin(t[4]))]
    bodies = (
        bar((zero, zero), t[0]),
        bar(tips[0], t[0] + t[1]),
        bar((sp.Integer(1), zero), t[2]),
        bar(tips[1], t[2] + t[3]),
        bar((sp.Integer(2), zero), t[4]),
    )
    loops = (
        tips[0][0] + cos(t[0] + t[1]) - tips[1][0],
        tips[0][1] + sin(t[0] + t[1]) - tips[1][1],
        tips[1][0] + cos(t[2] + t[3]) - tips[2][0],
        tips[1][1] + sin(t[2] + t[3]) - tips[2][1],
    )
    home = dict(
        zip((f"th{i}" for i in range(1, 6)), map(math.radians, (60, -60, 60, -60, 60)), strict=True)
    )
    return Mechanism(
        "double_four_bar",
        tuple(f"th{i}" for i in range(1, 6)),
        bodies,
        dict(G),
        (),
        loops,
        tips[0],
        home,
        serial=False,
    )


def _platform() -> Mechanism:
    x, y, t3 = S("x"), S("y"), S("th3")
    R = sp.Rational
    bodies = [
        Body(0, 0, (x, sp.Integer(0))),
        Body(0, 0, (x, y)),
        Body(R("1.5"), R("0.02"), (x, y), t3),
    ]
    loops = []
    feet = (
        (R("-0.433012701892"), R("-0.25")),
        (R("0.433012701892"), R("-0.25")),
        (sp.Integer(0), R("0.5")),
    )
    corners = (
        (R("-0.129903810568"), R("-0.075")),
        (R("0.129903810568"), R("-0.075")),
        (sp.Integer(0), R("0.15")),
    )
    for leg, (foot, corner) in enumerate(zip(feet, corners, strict=True)):
        a, e = S(f"th{4 + 2 * leg}"), S(f"th{4 + 2 * leg}") + S(f"th{5 + 2 * leg}")
        pin = (foot[0] + R("0.3") * cos(a), foot[1] + R("0.3") * sin(a))
        for mass, length, base, turn in (
            (R("0.6"), R("0.3"), foot, a),
            (R("0.5"), R("0.35"), pin, e),
        ):
            centre = (base[0] + length / 2 * cos(turn), base[1] + length / 2 * sin(turn))
            bodies.append(Body(mass, mass * length**2 / 12, centre, turn))
        end = (pin[0] + R("0.35") * cos(e), pin[1] + R("0.35") * sin(e))
        at = (
            x + corner[0] * cos(t3) - corner[1] * sin(t3),
            y + corner[0] * sin(t3) + corner[1] * cos(t3),
        )
        loops += [end[0] - at[0], end[1] - at[1]]
    names = ("x", "y", "th3", *(f"th{i}" for i in range(4, 10)))
    home = {"x": 0.0, "y": 0.0, "th3": 0.0}
    home |= {
        f"th{i}": math.radians(v)
        for i, v in zip(range(4, 10), (75, -60, 195, -60, 315, -60), strict=True)
    }
    return Mechanism(
        "3RRR",
        names,
        tuple(bodies),
        dict(G),
        (),
        tuple(loops),
        (),
        home,
        serial=False,
        tidied=False,
    )


ROBOTS = {
    "pendulum": lambda: _arm("pendulum", "R", {"l1": 1.0, "lc1": 0.5, "m1": 3.0, "I1": 0.25}),
    "2R": lambda: _arm("2R", "RR", BARS),
    "acrobot": lambda: _arm("acrobot", "RR", ACROBOT, ["th1"]),
    "pendubot": lambda: _arm("pendubot", "RR", PENDUBOT, ["th2"]),
    "3R": lambda: _arm("3R", "RRR", BARS3),
    "RP": _rp,
    "cart_pole": _cart_pole,
    "reaction_wheel": _reaction_wheel,
    "ball_and_beam": _ball_and_beam,
    "cylindrical_arm": _cylindrical,
    "polar_arm": _polar,
    "elbow_arm": _elbow,
    "furuta": _furuta,
    "gantry_crane": _gantry,
    "scara": _scara,
    "gyro": _gyro,
    "four_bar": _four_bar,
    "slider_crank": _slider_crank,
    "five_bar": _five_bar,
    "five_bar_rods": _five_bar_rods,
    "double_four_bar": _double_four_bar,
    "3RRR": _platform,
}


@functools.cache
def mechanism(name: str) -> Mechanism:
    """The robot of this name."""
    return ROBOTS[name]()
