# ruff: noqa: E501 - a result is easier to compare with its book in one line
"""Further results from problem sets and books, of other kinds than those of `book_results`: whole
documents, kinematic coefficients, equivalent inertias, mechanisms of one's own.

Each was written down with its robot before it was tried, and each formula of it is proved right in
numbers; several formulas stand with semicolons between.
"""

import math

import sympy as sp

import book_results
from book_results import (
    PASSIVE,
    ZERO,
    Result,
    bar,
    closed_chain,
    frame,
    head,
    joint,
    link,
    loop,
    numbers,
)
from check_lines.mechanisms import Body, Mechanism, S
from check_lines.robots import BARS, G, arm_of, mechanism

sin, cos = sp.sin, sp.cos

BOOM = {"a": 0.6, "h": 0.8, "lc1": 0.9, "m1": 30.0, "I1": 8.0}
LEVER = {"e": 0.4, "lc1": 0.1, "m1": 1.0, "I1": 0.02, "m2": 1.5}
TWIN = {"l1": 0.1, "lc1": 0.02, "m1": 2.0, "I1": 0.01, "l2": 0.35, "lc2": 0.1, "m2": 0.4,
        "I2": 0.004, "m3": 0.6, "l4": 0.35, "lc4": 0.1, "m4": 0.4, "I4": 0.004,
        "m5": 0.6}  # fmt: skip
CURVE = {"d": 0.4, "l1": 0.2, "lc1": 0.1, "m1": 0.4, "I1": 0.002, "l2": 0.5, "lc2": 0.25,
         "m2": 1.0, "I2": 0.02, "l3": 0.5, "lc3": 0.25, "m3": 1.0, "I3": 0.02, "p": 0.6,
         "h": 0.15}  # fmt: skip
RAISED = 'origin = [0, "h"]\n' + PASSIVE

TOML = {
    "boom": head("boom", "boom")
    + link("boom", "m1", "lc1", "I1") + link("cylinder") + link("ram")
    + joint("boom", "revolute", "ground", "boom", RAISED)
    + joint("cylinder", "revolute", "ground", "cylinder", PASSIVE)
    + joint("ram", "prismatic", "cylinder", "ram", 'axis = "x"')
    + frame("lug", "boom", '["a", 0]') + loop("ram", "lug")
    + numbers({"g": 9.81, **BOOM}, {"boom": '"30 deg"', "cylinder": '"64 deg"', "ram": "1.22"}),
    "lever": head("lever", "rod")
    + link("lever", "m1", "lc1", "I1") + link("rod", "m2") + link("block")
    + joint("lever", "revolute", "ground", "lever")
    + joint("rod", "prismatic", "ground", "rod", f'origin = ["e", 0]\naxis = "y"\n{PASSIVE}')
    + joint("slot", "prismatic", "lever", "block", f'axis = "x"\n{PASSIVE}')
    + loop("block", "rod")
    + numbers({"g": 9.81, **LEVER}, {"lever": '"30 deg"', "rod": "0.23", "slot": "0.46"}),
    "V-twin": head("twin", "piston1")
    + link("crank", "m1", "lc1", "I1") + link("rod1", "m2", "lc2", "I2") + link("piston1", "m3")
    + link("rod2", "m4", "lc4", "I4") + link("piston2", "m5")
    + joint("crank", "revolute", "ground", "crank")
    + joint("rod1", "revolute", "crank", "rod1", f'origin = ["l1", 0]\n{PASSIVE}')
    + joint("guide1", "prismatic", "ground", "piston1", f'axis = "x"\n{PASSIVE}')
    + joint("rod2", "revolute", "crank", "rod2", f'origin = ["l1", 0]\n{PASSIVE}')
    + joint("guide2", "prismatic", "ground", "piston2", f'axis = "y"\n{PASSIVE}')
    + frame("end1", "rod1", '["l2", 0]') + loop("piston1", "end1")
    + frame("end2", "rod2", '["l4", 0]') + loop("piston2", "end2").replace('"pin"', '"pin2"')
    + numbers({"g": 9.81, **TWIN},
              {"crank": '"50 deg"', "rod1": '"-62.6 deg"', "guide1": "0.4",
               "rod2": '"50.6 deg"', "guide2": "0.42"}),
    "coupler curve": head("curve", "P")
    + link("crank", "m1", "lc1", "I1") + link("coupler", "m2", "lc2", "I2")
    + link("rocker", "m3", "lc3", "I3")
    + joint("crank", "revolute", "ground", "crank")
    + joint("coupler", "revolute", "crank", "coupler", f'origin = ["l1", 0]\n{PASSIVE}')
    + joint("rocker", "revolute", "ground", "rocker", f'origin = ["d", 0]\n{PASSIVE}')
    + frame("P", "coupler", '["p", "h"]') + frame("pin", "coupler", '["l2", 0]')
    + frame("end", "rocker", '["l3", 0]') + loop("end", "pin")
    + numbers({"g": 9.81, **CURVE},
              {"crank": '"60 deg"', "coupler": '"-10 deg"', "rocker": '"80 deg"'}),
    "portal": head("portal", "tool")
    + link("bridge", "m1") + link("tool", "m2")
    + joint("bridge", "prismatic", "ground", "bridge", 'axis = "x"')
    + joint("tool", "prismatic", "bridge", "tool", 'axis = "y"')
    + numbers({"g": 9.81, "m1": 8.0, "m2": 3.0}, {}).removesuffix("[home]\n"),
}  # fmt: skip
LOADED = {"Craig's RP": "RP"}
WORDS = {"point masses": "RR", "my 4R": "RRRR", "my RPR": "RPR"}


def own_mechanism(robot: str) -> Mechanism:
    """The robot, derived anew."""
    a, b = S("th1"), S("th2")
    if robot == "boom":
        d = S("d3")
        bodies = (bar((ZERO, S("h")), 1, a), Body(0, 0, (ZERO, ZERO), b),
                  Body(0, 0, (d * cos(b), d * sin(b)), b))  # fmt: skip
        loops = (S("a") * cos(a) - d * cos(b), S("a") * sin(a) + S("h") - d * sin(b))
        home = {"th1": math.radians(30), "th2": math.radians(64), "d3": 1.22}
        return closed_chain(robot, ("th1", "th2", "d3"), bodies, BOOM, ("th1", "th2"), loops, home)
    if robot == "lever":
        y, s = S("d2"), S("d3")
        bodies = (bar((ZERO, ZERO), 1, a), Body(S("m2"), 0, (S("e"), y)),
                  Body(0, 0, (s * cos(a), s * sin(a)), a))  # fmt: skip
        loops = (s * cos(a) - S("e"), s * sin(a) - y)
        home = {"th1": math.radians(30), "d2": 0.23, "d3": 0.46}
        return closed_chain(robot, ("th1", "d2", "d3"), bodies, LEVER, ("d2", "d3"), loops, home)
    if robot == "V-twin":
        c, x, y = S("th4"), S("d3"), S("d5")
        pin = (S("l1") * cos(a), S("l1") * sin(a))
        bodies = (bar((ZERO, ZERO), 1, a), bar(pin, 2, a + b), Body(S("m3"), 0, (x, ZERO)),
                  bar(pin, 4, a + c), Body(S("m5"), 0, (ZERO, y)))  # fmt: skip
        loops = (
            pin[0] + S("l2") * cos(a + b) - x,
            pin[1] + S("l2") * sin(a + b),
            pin[0] + S("l4") * cos(a + c),
            pin[1] + S("l4") * sin(a + c) - y,
        )
        home = {"th1": math.radians(50), "th2": math.radians(-62.6), "d3": 0.4}
        home |= {"th4": math.radians(50.6), "d5": 0.42}
        names = ("th1", "th2", "d3", "th4", "d5")
        return closed_chain(robot, names, bodies, TWIN, names[1:], loops, home)
    if robot == "coupler curve":
        c = S("th3")
        pin = (S("l1") * cos(a), S("l1") * sin(a))
        bodies = (bar((ZERO, ZERO), 1, a), bar(pin, 2, a + b), bar((S("d"), ZERO), 3, c))
        loops = (
            pin[0] + S("l2") * cos(a + b) - S("d") - S("l3") * cos(c),
            pin[1] + S("l2") * sin(a + b) - S("l3") * sin(c),
        )
        tip = (
            pin[0] + S("p") * cos(a + b) - S("h") * sin(a + b),
            pin[1] + S("p") * sin(a + b) + S("h") * cos(a + b),
        )
        home = {x: math.radians(y) for x, y in (("th1", 60), ("th2", -10), ("th3", 80))}
        names, passive = ("th1", "th2", "th3"), ("th2", "th3")
        return Mechanism(robot, names, bodies, G | CURVE, passive, loops, tip, home, serial=False)
    if robot == "portal":
        x, y = S("d1"), S("d2")
        bodies = (Body(S("m1"), 0, (x, ZERO)), Body(S("m2"), 0, (x, y)))
        return Mechanism(robot, ("d1", "d2"), bodies, G | {"m1": 8.0, "m2": 3.0}, tip=(x, y))
    if robot == "my 4R":
        return _four_links(robot)
    if robot == "point masses":
        kept = {S("lc1"): S("l1"), S("lc2"): S("l2"), S("I1"): 0, S("I2"): 0}
        return _with(arm_of(robot, "RR"), kept)
    if robot == "Craig's RP":
        return _with(mechanism("RP"), {S("lc2"): 0})
    if robot == "my RPR":
        return arm_of(robot, "RPR")
    return book_results.own_mechanism(robot)


def _with(arm: Mechanism, given: dict[sp.Symbol, sp.Expr | int]) -> Mechanism:
    """The arm with parameters that others give."""
    bodies = tuple(
        Body(
            x.mass,
            sp.sympify(x.inertia).subs(given),
            tuple(sp.sympify(y).subs(given) for y in x.centre),
            x.turn,
        )
        for x in arm.bodies
    )
    values = {x: y for x, y in arm.values.items() if S(x) not in given}
    return Mechanism(arm.name, arm.coordinates, bodies, values, tip=arm.tip)


def _four_links(robot: str) -> Mechanism:
    values = G | BARS | {"l3": 0.4, "lc3": 0.2, "m3": 1.5, "I3": 0.02}
    values |= {"l4": 0.3, "lc4": 0.1, "m4": 1.0, "I4": 0.01}
    x = y = phi = ZERO
    bodies = []
    for i in range(1, 5):
        phi = phi + S(f"th{i}")
        bodies.append(bar((x, y), i, phi))
        x, y = x + S(f"l{i}") * cos(phi), y + S(f"l{i}") * sin(phi)
    names = tuple(f"th{i}" for i in range(1, 5))
    return Mechanism(robot, names, tuple(bodies), values, tip=(x, y), tidied=False)


R = Result
POINTS = {"parameters": {"lc": "l", "I": 0}}
RESULTS = (
    # ------------------------------------------------------------ slider-crank
    R("ratio of speeds", "slider_crank",
      r"\frac{\dot d_3}{\dot\theta_1} = \frac{l_1\sin\theta_2}{\cos(\theta_1+\theta_2)}",
      "d3_d/th1_d = l1*sin(th2)/cos(th1 + th2)"),
    R("Uicker's first-order kinematic coefficients", "slider_crank",
      "k2 = -l1*cos(theta1)/(l2*cos(theta1 + theta2))\nk3 = l1*sin(theta2)/cos(theta1 + theta2)\n"
      "omega_2 = k2*dtheta1\nd3_d = k3*dtheta1",
      "omega2 = -l1*cos(th1)/(l2*cos(th1 + th2))*th1_d; d3_d = l1*sin(th2)/cos(th1 + th2)*th1_d"),
    R("virtual displacement of the piston", "slider_crank",
      r"\delta d_3 = \frac{l_1\sin\theta_2}{\cos(\theta_1+\theta_2)}\,\delta\theta_1",
      "d3_d = l1*sin(th2)/cos(th1 + th2)*th1_d"),
    R("multiplier of the piston pin", "slider_crank", r"\lambda_1 = m_3\ddot d_3",
      "lam1 = m3*d3_dd"),
    R("force on the piston", "slider_crank", "f_23x = m3*d3_dd", "lam1 = m3*d3_dd"),
    R("torque by the power of the engine", "slider_crank",
      r"\tau_1 = \frac{\dot T + \dot V}{\dot\theta_1}", "tau1 = (T_d + V_d)/th1_d"),
    R("equivalent inertia of an engine", "slider_crank",
      "n = l1*cos(theta1)/(l2*cos(theta1 + theta2))\n"
      "J = I1 + m1*lc1^2 + I2*n^2 + m2*((-l1*sin(theta1) + lc2*n*sin(theta1 + theta2))^2"
      " + (l1*cos(theta1) - lc2*n*cos(theta1 + theta2))^2)"
      " + m3*(l1*sin(theta2)/cos(theta1 + theta2))^2\nT = 1/2*J*dtheta1^2",
      "T = 1/2*(I1 + m1*lc1**2 + I2*(l1*cos(th1)/(l2*cos(th1 + th2)))**2"
      " + m2*((-l1*sin(th1) + lc2*l1*cos(th1)/(l2*cos(th1 + th2))*sin(th1 + th2))**2"
      " + (l1*cos(th1) - lc2*l1*cos(th1)/l2)**2) + m3*(l1*sin(th2)/cos(th1 + th2))**2)*th1_d**2"),
    R("a report on the engine", "slider_crank",
      "The loop closes vertically, $l_1 \\sin\\theta_1 + l_2 \\sin(\\theta_1+\\theta_2) = 0$, and along the\n"
      "cylinder's axis\n\n$$d_3 = l_1 \\cos\\theta_1 + l_2 \\cos(\\theta_1+\\theta_2).$$\n\n"
      "Differentiating gives the piston's speed\n\n$$\\dot{d}_3 = -l_1 \\omega_1 \\sin\\theta_1 - l_2 \\omega_2 \\sin(\\theta_1+\\theta_2),$$\n\n"
      "with $\\omega_1 = \\dot\\theta_1$ and $\\omega_2 = \\dot\\theta_1 + \\dot\\theta_2$.\n",
      "l1*sin(th1) + l2*sin(th1 + th2) = 0; d3 = l1*cos(th1) + l2*cos(th1 + th2);"
      " d3_d = -l1*omega1*sin(th1) - l2*omega2*sin(th1 + th2)", {"form": "markdown"}),
    R("acceleration analysis with an offset", "offset slider-crank",
      r"l_2\alpha_2\cos(\theta_1+\theta_2) = l_1\dot\theta_1^2\sin\theta_1 - l_1\ddot\theta_1\cos\theta_1 + l_2\omega_2^2\sin(\theta_1+\theta_2)",
      "l2*omega2_d*cos(th1 + th2) = l1*th1_d**2*sin(th1) - l1*th1_dd*cos(th1)"
      " + l2*omega2**2*sin(th1 + th2)"),
    R("crank's angle from the slider", "offset slider-crank",
      r"\theta_1 = \operatorname{atan2}(e, d_3) + \arccos\frac{d_3^2 + e^2 + l_1^2 - l_2^2}{2 l_1\sqrt{d_3^2 + e^2}}",
      "th1 = atan2(e, d3) + acos((d3**2 + e**2 + l1**2 - l2**2)/(2*l1*sqrt(d3**2 + e**2)))"),
    R("second piston of a V-twin", "V-twin",
      "d5 = l1*sin(theta1) + sqrt(l4^2 - l1^2*cos(theta1)^2)",
      "d5 = l1*sin(th1) + sqrt(l4**2 - l1**2*cos(th1)**2)"),
    R("speeds of a V-twin", "V-twin",
      r"\dot d_5 = l_1\dot\theta_1\left(\cos\theta_1 + \frac{l_1\sin\theta_1\cos\theta_1}{\sqrt{l_4^2 - l_1^2\cos^2\theta_1}}\right)",
      "d5_d = l1*th1_d*(cos(th1) + l1*sin(th1)*cos(th1)/sqrt(l4**2 - l1**2*cos(th1)**2))"),
    # ------------------------------------------------------------ inverted sliders
    R("Coriolis in the quick-return", "quick-return",
      r"d_3\ddot\theta_2 + 2\dot d_3\dot\theta_2 = r\ddot\theta_1\cos(\theta_1-\theta_2) - r\dot\theta_1^2\sin(\theta_1-\theta_2)",
      "d3*th2_dd + 2*d3_d*th2_d = r*th1_dd*cos(th1 - th2) - r*th1_d**2*sin(th1 - th2)"),
    R("acceleration along the slot", "quick-return",
      "d3_dd - d3*theta2_d^2 = -r*theta1_dd*sin(theta1 - theta2) - r*theta1_d^2*cos(theta1 - theta2)",
      "d3_dd - d3*th2_d**2 = -r*th1_dd*sin(th1 - th2) - r*th1_d**2*cos(th1 - th2)"),
    R("MATLAB script of the quick-return", "quick-return",
      "% positions\ntheta2 = atan2(r*sin(theta1), d + r*cos(theta1));\n"
      "d3 = sqrt(d^2 + r^2 + 2*d*r*cos(theta1));\n% rates\n"
      "theta2_dot = r*theta1_dot*cos(theta1 - theta2)/d3;\n",
      "th2 = atan2(r*sin(th1), d + r*cos(th1)); d3 = sqrt(d**2 + r**2 + 2*d*r*cos(th1));"
      " th2_d = r*th1_d*cos(th1 - th2)/d3"),
    R("inertia reduced to the crank", "quick-return",
      r"T = \frac12\left[I_1 + m_3 r^2 + (I_2 + m_2 l_{c2}^2)\left(\frac{\dot\theta_2}{\dot\theta_1}\right)^2\right]\dot\theta_1^2",
      "T = 1/2*(I1 + m3*r**2 + (I2 + m2*lc2**2)*(th2_d/th1_d)**2)*th1_d**2"),
    R("power into the quick-return", "quick-return",
      r"\tau_1\dot\theta_1 = (I_1 + m_3 r^2)\dot\theta_1\ddot\theta_1 + (I_2 + m_2 l_{c2}^2)\dot\theta_2\ddot\theta_2 + m_2 g l_{c2}\cos\theta_2\,\dot\theta_2 + m_3 g r\cos\theta_1\,\dot\theta_1",
      "tau1*th1_d = (I1 + m3*r**2)*th1_d*th1_dd + (I2 + m2*lc2**2)*th2_d*th2_dd"
      " + m2*g*lc2*cos(th2)*th2_d + m3*g*r*cos(th1)*th1_d"),
    R("length of a hydraulic cylinder", "boom", r"d_3^2 = a^2 + h^2 + 2ah\sin\theta_1",
      "d3**2 = a**2 + h**2 + 2*a*h*sin(th1)"),
    R("rate of a hydraulic cylinder", "boom", r"\dot d_3 = \frac{a h\cos\theta_1}{d_3}\dot\theta_1",
      "d3_d = a*h*cos(th1)/d3*th1_d"),
    R("boom's angle from the cylinder", "boom",
      r"\theta_1 = \sin^{-1}\left(\frac{d_3^2 - a^2 - h^2}{2 a h}\right)",
      "sin(th1) = (d3**2 - a**2 - h**2)/(2*a*h)"),
    R("angle of the cylinder", "boom", "theta2 = atan2(h + a*sin(theta1), a*cos(theta1))",
      "th2 = atan2(h + a*sin(th1), a*cos(th1))"),
    R("force of the cylinder", "boom",
      r"\tau_3\,a\sin(\theta_2-\theta_1) = (I_1 + m_1 l_{c1}^2)\ddot\theta_1 + m_1 g l_{c1}\cos\theta_1",
      "tau3*a*sin(th2 - th1) = (I1 + m1*lc1**2)*th1_dd + m1*g*lc1*cos(th1)"),
    # ------------------------------------------------------------ yokes, levers, ladders
    R("influence coefficient of the yoke", "scotch yoke",
      r"\frac{\mathrm{d} d_2}{\mathrm{d}\theta_1} = -r\sin\theta_1", "d2_d/th1_d = -r*sin(th1)"),
    R("Eksergian's equation of the yoke", "scotch yoke",
      "J = I_1 + m_1 l_{c1}^2 + m_2 r^2 \\sin^2\\theta_1\n"
      r"\tau_1 = J\ddot\theta_1 + \frac{1}{2}\frac{dJ}{d\theta_1}\dot\theta_1^2 + m_1 g l_{c1}\cos\theta_1",
      "tau1 = (I1 + m1*lc1**2 + m2*r**2*sin(th1)**2)*th1_dd"
      " + m2*r**2*sin(th1)*cos(th1)*th1_d**2 + m1*g*lc1*cos(th1)"),
    R("d'Alembert on the yoke", "scotch yoke",
      "tau1 = (I1 + m1*lc1^2)*ddtheta1 + m1*g*lc1*cos(theta1) - m2*r*sin(theta1)*ddd2",
      "tau1 = (I1 + m1*lc1**2)*th1_dd + m1*g*lc1*cos(th1) - m2*r*sin(th1)*d2_dd"),
    R("rod on a slotted lever", "lever", r"\ddot d_2 = e\sec^2\theta_1\,(\ddot\theta_1 + 2\dot\theta_1^2\tan\theta_1)",
      "d2_dd = e/cos(th1)**2*(th1_dd + 2*th1_d**2*tan(th1))"),
    R("energy of a slotted lever", "lever",
      "T = 1/2*(I1 + m1*lc1^2 + m2*e^2/cos(theta1)^4)*dtheta1^2",
      "T = 1/2*(I1 + m1*lc1**2 + m2*e**2/cos(th1)**4)*th1_d**2"),
    R("ellipse of the trammel", "trammel",
      r"\frac{x_{c2}^2}{(l - l_{c2})^2} + \frac{y_{c2}^2}{l_{c2}^2} = 1",
      "xc2**2/(l - lc2)**2 + yc2**2/lc2**2 = 1"),
    R("acceleration of the ladder's end", "trammel",
      r"\ddot d_3 = -\frac{d_1\ddot d_1 + \dot d_1^2 + \dot d_3^2}{d_3}",
      "d3_dd = -(d1*d1_dd + d1_d**2 + d3_d**2)/d3"),
    R("ends of the ladder by its angle", "trammel", r"\dot d_3 = \dot d_1\cot\theta_2",
      "d3_d = d1_d*cot(th2)"),
    R("curvilinear translation", "parallelogram",
      r"a_{c2,x} = -a\ddot\theta_1\sin\theta_1 - a\dot\theta_1^2\cos\theta_1",
      "ac2x = -a*th1_dd*sin(th1) - a*th1_d**2*cos(th1)"),
    R("energies of a parallelogram", "parallelogram",
      "T = 1/2*(I1 + m1*lc1^2 + I3 + m3*lc3^2 + m2*a^2)*dtheta1^2\n"
      "V = (m1*lc1 + m3*lc3 + m2*a)*g*sin(theta1)",
      "T = 1/2*(I1 + m1*lc1**2 + I3 + m3*lc3**2 + m2*a**2)*th1_d**2;"
      " V = (m1*lc1 + m3*lc3 + m2*a)*g*sin(th1)"),
    # ------------------------------------------------------------ four-bars
    R("Norton's half-angle of the rocker", "four_bar",
      "K_1 = d/l_1\nK_2 = d/l_3\nK_3 = \\frac{l_1^2 - l_2^2 + l_3^2 + d^2}{2 l_1 l_3}\n"
      "A = \\cos\\theta_1 - K_1 - K_2\\cos\\theta_1 + K_3\nB = -2\\sin\\theta_1\n"
      "C = K_1 - (K_2 + 1)\\cos\\theta_1 + K_3\n"
      r"\theta_3 = 2\arctan\left(\frac{-B - \sqrt{B^2 - 4AC}}{2A}\right)",
      "th3 = 2*atan((2*sin(th1) - sqrt(4*sin(th1)**2"
      " - 4*(cos(th1) - d/l1 - d/l3*cos(th1) + (l1**2 - l2**2 + l3**2 + d**2)/(2*l1*l3))"
      "*(d/l1 - (d/l3 + 1)*cos(th1) + (l1**2 - l2**2 + l3**2 + d**2)/(2*l1*l3))))"
      "/(2*(cos(th1) - d/l1 - d/l3*cos(th1) + (l1**2 - l2**2 + l3**2 + d**2)/(2*l1*l3))))"),
    R("Norton's rate of the coupler", "four_bar",
      r"\omega_2 = \frac{l_1\omega_1}{l_2}\,\frac{\sin(\theta_3-\theta_1)}{\sin(\theta_1+\theta_2-\theta_3)}",
      "omega2 = l1*omega1/l2*sin(th3 - th1)/sin(th1 + th2 - th3)"),
    R("mechanical advantage", "four_bar",
      "mu = theta1 + theta2 - theta3\nnu = theta2\nomega_1/omega_3 = l3*sin(mu)/(l1*sin(nu))",
      "omega1/omega3 = l3*sin(th1 + th2 - th3)/(l1*sin(th2))"),
    R("rocker by the diagonal", "four_bar",
      "f = sqrt(d^2 + l1^2 - 2*d*l1*cos(theta1))\nbeta = atan2(l1*sin(theta1), d - l1*cos(theta1))\n"
      "delta = acos((f^2 + l3^2 - l2^2)/(2*f*l3))\ntheta3 = pi - beta - delta",
      "th3 = 3.141592653589793 - atan2(l1*sin(th1), d - l1*cos(th1))"
      " - acos((d**2 + l1**2 - 2*d*l1*cos(th1) + l3**2 - l2**2)"
      "/(2*sqrt(d**2 + l1**2 - 2*d*l1*cos(th1))*l3))"),
    R("accelerations along the coupler", "four_bar",
      r"l_1\ddot\theta_1\sin\theta_2 - l_1\dot\theta_1^2\cos\theta_2 - l_2\omega_2^2 = l_3\ddot\theta_3\sin(\theta_1+\theta_2-\theta_3) - l_3\dot\theta_3^2\cos(\theta_1+\theta_2-\theta_3)",
      "l1*th1_dd*sin(th2) - l1*th1_d**2*cos(th2) - l2*omega2**2"
      " = l3*th3_dd*sin(th1 + th2 - th3) - l3*th3_d**2*cos(th1 + th2 - th3)"),
    R("Norton's virtual work", "four_bar",
      r"\tau_1\omega_1 = \sum_{i=1}^{3}\left(m_i\,\mathbf{a}_{ci}\cdot\mathbf{v}_{ci} + I_i\alpha_i\omega_i + m_i g\,\dot y_{ci}\right)",
      "tau1*omega1 = m1*(ac1x*vc1x + ac1y*vc1y) + I1*omega1_d*omega1 + m1*g*vc1y"
      " + m2*(ac2x*vc2x + ac2y*vc2y) + I2*omega2_d*omega2 + m2*g*vc2y"
      " + m3*(ac3x*vc3x + ac3y*vc3y) + I3*omega3_d*omega3 + m3*g*vc3y"),
    R("loop in the complex plane", "four_bar",
      r"l_1 e^{i\theta_1} + l_2 e^{i(\theta_1+\theta_2)} - d - l_3 e^{i\theta_3} = 0",
      "l1*cos(th1) + l2*cos(th1 + th2) - d - l3*cos(th3) = 0;"
      " l1*sin(th1) + l2*sin(th1 + th2) - l3*sin(th3) = 0"),
    R("speed of the rocker's pin", "four_bar", "xdot^2 + ydot^2 = l3^2*theta3dot^2",
      "x_d**2 + y_d**2 = l3**2*th3_d**2"),
    R("point of a coupler curve", "coupler curve",
      r"x = l_1\cos\theta_1 + p\cos(\theta_1+\theta_2) - h\sin(\theta_1+\theta_2)",
      "x = l1*cos(th1) + p*cos(th1 + th2) - h*sin(th1 + th2)"),
    R("distance of the coupler's point", "coupler curve",
      "(x - l1*cos(theta1))^2 + (y - l1*sin(theta1))^2 = p^2 + h^2",
      "(x - l1*cos(th1))**2 + (y - l1*sin(th1))**2 = p**2 + h**2"),
    R("speed of the coupler's point", "coupler curve",
      r"\dot y = \omega_1 l_1\cos\theta_1 + \omega_2\,(x - l_1\cos\theta_1)",
      "y_d = omega1*l1*cos(th1) + omega2*(x - l1*cos(th1))"),
    # ------------------------------------------------------------ five-bars, 3-RRR
    R("inverse position of a leg", "five_bar",
      r"\theta_1 = \operatorname{atan2}(y, x+b) + \arccos\left(\frac{l_1^2 + (x+b)^2 + y^2 - l_3^2}{2 l_1\sqrt{(x+b)^2 + y^2}}\right)",
      "cos(th1 - atan2(y, x + b)) = (l1**2 + (x + b)**2 + y**2 - l3**2)/(2*l1*sqrt((x + b)**2 + y**2))"),
    R("line through the two points of intersection", "five_bar",
      "xB = -b + l1*cos(theta1)\nyB = l1*sin(theta1)\nxD = b + l2*cos(theta2)\nyD = l2*sin(theta2)\n"
      "2*(xD - xB)*x + 2*(yD - yB)*y = l3^2 - l4^2 + xD^2 + yD^2 - xB^2 - yB^2",
      "2*(2*b + l2*cos(th2) - l1*cos(th1))*x + 2*(l2*sin(th2) - l1*sin(th1))*y = l3**2 - l4**2"
      " + (b + l2*cos(th2))**2 + (l2*sin(th2))**2 - (l1*cos(th1) - b)**2 - (l1*sin(th1))**2"),
    R("moment of a rod on its crank", "five_bar_rods",
      r"\tau_1 = (I_1 + m_1 l_{c1}^2)\ddot\theta_1 + m_1 g l_{c1}\cos\theta_1 + 2\lambda_1 l_1\left[(x+b)\sin\theta_1 - y\cos\theta_1\right]",
      "tau1 = (I1 + m1*lc1**2)*th1_dd + m1*g*lc1*cos(th1)"
      " + 2*lam1*l1*((x + b)*sin(th1) - y*cos(th1))"),
    R("forces on the point of a five-bar", "five_bar_rods",
      "m3*xdd + 2*lambda1*(x + b - l1*cos(theta1)) + 2*lambda2*(x - b - l2*cos(theta2)) = 0",
      "m3*x_dd + 2*lam1*(x + b - l1*cos(th1)) + 2*lam2*(x - b - l2*cos(th2)) = 0",
      {"names": {"xdd": "x_dd"}}),
    R("distal link of a 3-RRR", "3RRR",
      "(x - 0.129903810568*cos(theta3) + 0.075*sin(theta3) + 0.433012701892 - 0.3*cos(theta4))^2"
      " + (y - 0.129903810568*sin(theta3) - 0.075*cos(theta3) + 0.25 - 0.3*sin(theta4))^2 = 0.35^2",
      "(x - 0.129903810568*cos(th3) + 0.075*sin(th3) + 0.433012701892 - 0.3*cos(th4))**2"
      " + (y - 0.129903810568*sin(th3) - 0.075*cos(th3) + 0.25 - 0.3*sin(th4))**2 = 0.1225"),
    # ------------------------------------------------------------ planar arms
    R("double pendulum of the link's own angles", "2R",
      "L = 1/2*(I1 + m1*lc1^2 + m2*l1^2)*dtheta1^2 + 1/2*(I2 + m2*lc2^2)*dtheta2^2"
      " + m2*l1*lc2*dtheta1*dtheta2*cos(theta2 - theta1) - m1*g*lc1*sin(theta1)"
      " - m2*g*(l1*sin(theta1) + lc2*sin(theta2))",
      "L = 1/2*(I1 + m1*lc1**2 + m2*l1**2)*omega1**2 + 1/2*(I2 + m2*lc2**2)*omega2**2"
      " + m2*l1*lc2*omega1*omega2*cos(phi2 - phi1) - m1*g*lc1*sin(phi1)"
      " - m2*g*(l1*sin(phi1) + lc2*sin(phi2))", {"absolute": True}),
    R("Murray, Li and Sastry (4.11)", "2R",
      "\\alpha = I_{z1} + I_{z2} + m_1 r_1^2 + m_2(l_1^2 + r_2^2)\n\\beta = m_2 l_1 r_2\n"
      "\\delta = I_{z2} + m_2 r_2^2\n"
      r"M(\theta) = \begin{bmatrix}\alpha + 2\beta c_2 & \delta + \beta c_2\\ \delta + \beta c_2 & \delta\end{bmatrix}"
      "\n"
      r"C(\theta,\dot\theta) = \begin{bmatrix}-\beta s_2\dot\theta_2 & -\beta s_2(\dot\theta_1+\dot\theta_2)\\ \beta s_2\dot\theta_1 & 0\end{bmatrix}",
      "H11 = I1 + I2 + m1*lc1**2 + m2*(l1**2 + lc2**2) + 2*m2*l1*lc2*cos(th2);"
      " H12 = I2 + m2*lc2**2 + m2*l1*lc2*cos(th2); C11 = -m2*l1*lc2*sin(th2)*th2_d",
      {"notation": "murray-li-sastry"}),
    R("Lynch and Park (8.9)", "point masses",
      r"M(\theta) = \begin{bmatrix} m_1 L_1^2 + m_2(L_1^2 + 2L_1L_2\cos\theta_2 + L_2^2) & m_2(L_1L_2\cos\theta_2 + L_2^2)\\ m_2(L_1L_2\cos\theta_2 + L_2^2) & m_2L_2^2\end{bmatrix}",
      "H11 = m1*l1**2 + m2*(l1**2 + 2*l1*l2*cos(th2) + l2**2); H12 = m2*(l1*l2*cos(th2) + l2**2)",
      {"notation": "lynch-park", **POINTS}),
    R("Lynch and Park's velocity terms", "point masses",
      r"c(\theta,\dot\theta) = \begin{bmatrix} -m_2L_1L_2\sin\theta_2(2\dot\theta_1\dot\theta_2 + \dot\theta_2^2)\\ m_2L_1L_2\dot\theta_1^2\sin\theta_2\end{bmatrix}",
      "c1 = -m2*l1*l2*sin(th2)*(2*th1_d*th2_d + th2_d**2); c2 = m2*l1*l2*th1_d**2*sin(th2)",
      {"notation": "lynch-park", **POINTS}),
    R("acceleration of the tip", "2R",
      r"\begin{bmatrix}\ddot x\\ \ddot y\end{bmatrix} = J\begin{bmatrix}\ddot\theta_1\\ \ddot\theta_2\end{bmatrix} + \dot J\begin{bmatrix}\dot\theta_1\\ \dot\theta_2\end{bmatrix}",
      "x_dd = J11*th1_dd + J12*th2_dd - (l1*cos(th1) + l2*cos(th1 + th2))*th1_d**2"
      " - 2*l2*cos(th1 + th2)*th1_d*th2_d - l2*cos(th1 + th2)*th2_d**2"),
    R("Yoshikawa's measure", "2R", r"\sqrt{\det(J J^T)} = l_1 l_2 |\sin\theta_2|",
      "sqrt((J11**2 + J12**2)*(J21**2 + J22**2) - (J11*J21 + J12*J22)**2) = l1*l2*abs(sin(th2))"),
    R("Spong's Christoffel symbols", "2R",
      "h = -m_2 l_1 l_{c2} \\sin q_2\nc_{121} = h\nc_{221} = h\nc_{112} = -h",
      "C12 = -m2*l1*lc2*sin(th2)*(th1_d + th2_d)", {"notation": "spong"}),
    R("passivity", "2R", r"\dot q^T(\dot M - 2C)\dot q = 0",
      "th1_d*(H11_d - 2*C11)*th1_d + th1_d*(H12_d - 2*C12)*th2_d + th2_d*(H21_d - 2*C21)*th1_d"
      " + th2_d*(H22_d - 2*C22)*th2_d = 0"),
    R("both elbows", "2R",
      "D = (x^2 + y^2 - l1^2 - l2^2)/(2*l1*l2)\ntheta2 = atan2(±sqrt(1 - D^2), D)",
      "cos(th2) = (x**2 + y**2 - l1**2 - l2**2)/(2*l1*l2)"),
    R("Asada's balance of moments", "2R",
      r"N_{1,2} - r_{1,c2}\times f_{1,2} - I_2\dot\omega_2 = 0",
      "tau2 - lc2*(cos(phi2)*f12y - sin(phi2)*f12x) - I2*omega2_d = 0"),
    R("Featherstone's bias force", "2R",
      r"C_2 = m_2 l_1 l_{c2}\sin q_2\,\dot q_1^2 + m_2 g l_{c2}\cos(q_1+q_2)",
      "c2 + G2 = m2*l1*lc2*sin(th2)*th1_d**2 + m2*g*lc2*cos(th1 + th2)",
      {"notation": "featherstone"}),
    R("elimination of the second joint", "2R",
      "ddtheta1 = (tau1 - c1 - G1 - H12/H22*(tau2 - c2 - G2))/(H11 - H12^2/H22)",
      "th1_dd = (tau1 - c1 - G1 - H12/H22*(tau2 - c2 - G2))/(H11 - H12**2/H22)"),
    R("angular momentum about the base", "2R",
      r"H_O = I_1\omega_1 + I_2\omega_2 + m_1(x_{c1}\dot y_{c1} - y_{c1}\dot x_{c1}) + m_2(x_{c2}\dot y_{c2} - y_{c2}\dot x_{c2})",
      "p1 = I1*omega1 + I2*omega2 + m1*(xc1*vc1y - yc1*vc1x) + m2*(xc2*vc2y - yc2*vc2x)"),
    R("Siciliano's two-link arm", "2R",
      "$$h = -m_{\\ell_2} a_1 \\ell_2 s_2$$\n\n"
      "$$b_{11} = I_{\\ell_1} + m_{\\ell_1}\\ell_1^2 + I_{\\ell_2} + m_{\\ell_2}(a_1^2 + \\ell_2^2 + 2a_1\\ell_2c_2)$$\n\n"
      "$$C(q,\\dot q) = \\begin{bmatrix} h\\dot\\vartheta_2 & h(\\dot\\vartheta_1+\\dot\\vartheta_2)\\\\ -h\\dot\\vartheta_1 & 0\\end{bmatrix}$$\n",
      "H11 = I1 + m1*lc1**2 + I2 + m2*(l1**2 + lc2**2 + 2*l1*lc2*cos(th2));"
      " C12 = -m2*l1*lc2*sin(th2)*(th1_d + th2_d)", {"notation": "siciliano", "form": "markdown"}),
    R("SymPy script of a 2R", "2R",
      "from sympy import *\nq1, q2, l1, l2, lc2, m2, I2, g = symbols('q1 q2 l1 l2 lc2 m2 I2 g')\n"
      "x = l1*cos(q1) + l2*cos(q1 + q2)\ny = l1*sin(q1) + l2*sin(q1 + q2)\n"
      "J = Matrix([x, y]).jacobian([q1, q2])\nG2 = diff(m2*g*(l1*sin(q1) + lc2*sin(q1 + q2)), q2)\n",
      "x = l1*cos(th1) + l2*cos(th1 + th2); J11 = -l1*sin(th1) - l2*sin(th1 + th2);"
      " G2 = m2*g*lc2*cos(th1 + th2)", {"form": "python"}),
    R("Jacobian of three links", "3R",
      r"J = \begin{bmatrix} -l_1s_1 - l_2s_{12} - l_3s_{123} & -l_2s_{12} - l_3s_{123} & -l_3s_{123}\\ l_1c_1 + l_2c_{12} + l_3c_{123} & l_2c_{12} + l_3c_{123} & l_3c_{123}\end{bmatrix}",
      "J11 = -l1*sin(th1) - l2*sin(th1 + th2) - l3*sin(th1 + th2 + th3);"
      " J23 = l3*cos(th1 + th2 + th3)"),
    R("wrist of three links", "3R",
      "phi = theta1 + theta2 + theta3\nxw = x - l3*cos(phi)\nyw = y - l3*sin(phi)\n"
      "theta2 = acos((xw^2 + yw^2 - l1^2 - l2^2)/(2*l1*l2))\n"
      "theta1 = atan2(yw, xw) - atan2(l2*sin(theta2), l1 + l2*cos(theta2))",
      "th1 = atan2(y - l3*sin(phi3), x - l3*cos(phi3)) - atan2(l2*sin(th2), l1 + l2*cos(th2));"
      " th2 = acos(((x - l3*cos(phi3))**2 + (y - l3*sin(phi3))**2 - l1**2 - l2**2)/(2*l1*l2))"),
    R("height of a chain", "my 4R", r"y = \sum_{i=1}^{4} l_i\sin\left(\sum_{j=1}^{i}\theta_j\right)",
      "y = l1*sin(th1) + l2*sin(th1 + th2) + l3*sin(th1 + th2 + th3) + l4*sin(th1 + th2 + th3 + th4)"),
    R("Craig's example 6.5", "Craig's RP",
      r"\tau_1 = (m_1 l_1^2 + I_{zz1} + I_{zz2} + m_2 d_2^2)\ddot\theta_1 + 2m_2 d_2\dot\theta_1\dot d_2 + (m_1 l_1 + m_2 d_2) g\cos(\theta_1)",
      "tau1 = (m1*lc1**2 + I1 + I2 + m2*d2**2)*th1_dd + 2*m2*d2*th1_d*d2_d + (m1*lc1 + m2*d2)*g*cos(th1)",
      {"notation": "craig", "parameters": {"lc2": 0}, "names": {"l1": "lc1"}}),
    R("Craig's V of the RP arm", "Craig's RP",
      r"V(\Theta,\dot\Theta) = \begin{bmatrix} 2m_2d_2\dot\theta_1\dot d_2\\ -m_2d_2\dot\theta_1^2\end{bmatrix}",
      "c1 = 2*m2*d2*th1_d*d2_d; c2 = -m2*d2*th1_d**2",
      {"notation": "craig", "parameters": {"lc2": 0}}),
    R("radial acceleration of the tip", "RP",
      r"\ddot x\cos\theta_1 + \ddot y\sin\theta_1 = \ddot d_2 - (d_2+l_2)\dot\theta_1^2",
      "x_dd*cos(th1) + y_dd*sin(th1) = d2_dd - (d2 + l2)*th1_d**2"),
    R("Cartesian arm of Siciliano", "portal",
      "B = [m1 + m2, 0; 0, m2]\ntau1 = (m1 + m2)*ddd1\ntau2 = m2*ddd2 + m2*g",
      "H11 = m1 + m2; tau1 = (m1 + m2)*d1_dd; tau2 = m2*d2_dd + m2*g"),
    R("slide between two turns", "my RPR",
      r"\tau_3 = (I_3 + m_3 l_{c3}^2)(\ddot\theta_1+\ddot\theta_3) + m_3 l_{c3}\left[(l_1+d_2)(\ddot\theta_1\cos\theta_3 + \dot\theta_1^2\sin\theta_3) - \ddot d_2\sin\theta_3 + 2\dot\theta_1\dot d_2\cos\theta_3 + g\cos(\theta_1+\theta_3)\right]",
      "tau3 = (I3 + m3*lc3**2)*(th1_dd + th3_dd) + m3*lc3*((l1 + d2)*(th1_dd*cos(th3)"
      " + th1_d**2*sin(th3)) - d2_dd*sin(th3) + 2*th1_d*d2_d*cos(th3) + g*cos(th1 + th3))"),
    # ------------------------------------------------------------ underactuated
    R("Tedrake's pole", "cart_pole",
      r"\ddot\theta_2 = \frac{-u\cos\theta_2 - m_2l_2\dot\theta_2^2\cos\theta_2\sin\theta_2 - (m_1+m_2)g\sin\theta_2}{l_2(m_1 + m_2\sin^2\theta_2)}",
      "th2_dd = (-tau1*cos(th2) - m2*l2*th2_d**2*cos(th2)*sin(th2) - (m1 + m2)*g*sin(th2))"
      "/(l2*(m1 + m2*sin(th2)**2))"),
    R("a page on the cart-pole", "cart_pole",
      "The kinetic energy is $T = \\tfrac12 (m_1+m_2)\\dot x^2 + m_2\\dot x\\dot\\theta_2 l_2\\cos\\theta_2 + \\tfrac12 m_2 l_2^2\\dot\\theta_2^2$\n"
      "and the potential energy $V = -m_2 g l_2\\cos\\theta_2$. Only the cart is driven, so the energy\n"
      "changes as $\\dot E = u\\,\\dot x$, where $E = T + V$.\n",
      "T = 1/2*(m1 + m2)*x_d**2 + m2*x_d*th2_d*l2*cos(th2) + 1/2*m2*l2**2*th2_d**2;"
      " V = -m2*g*l2*cos(th2); E_d = tau1*x_d", {"form": "markdown"}),
    R("Spong's wheel", "reaction_wheel",
      r"(I_1 + m_1 l_{c1}^2 + m_2 l_1^2)\ddot\theta_1 - (m_1 l_{c1} + m_2 l_1) g\sin\theta_1 = -\tau_2",
      "(I1 + m1*lc1**2 + m2*l1**2)*th1_dd - (m1*lc1 + m2*l1)*g*sin(th1) = -tau2"),
    R("Tedrake's acrobot", "acrobot",
      "(H22 - H12^2/H11)*ddq2 = tau2 - c2 - G2 + H12/H11*(c1 + G1)",
      "(H22 - H12**2/H11)*th2_dd = tau2 - c2 - G2 + H12/H11*(c1 + G1)"),
    R("Furuta's constant", "furuta",
      r"\frac{\partial L}{\partial\dot\theta_1} = \left[I_1 + m_1 l_{c1}^2 + m_2 l_1^2 + (I_2 + m_2 l_{c2}^2)\sin^2\theta_2\right]\dot\theta_1 - m_2 l_1 l_{c2}\cos\theta_2\,\dot\theta_2",
      "p1 = (I1 + m1*lc1**2 + m2*l1**2 + (I2 + m2*lc2**2)*sin(th2)**2)*th1_d"
      " - m2*l1*lc2*cos(th2)*th2_d"),
    # ------------------------------------------------------------ arms in space
    R("reach of a SCARA", "scara",
      "theta2 = acos((x^2 + y^2 - 0.425^2 - 0.375^2)/(2*0.425*0.375))",
      "th2 = acos((x**2 + y**2 - 0.180625 - 0.140625)/(2*0.425*0.375))"),
    R("height of a SCARA", "scara", "z = 0.677 - d3", "z = 0.677 - d3"),
    R("column of a cylindrical arm", "cylindrical_arm",
      r"\tau_1 = \left[I_1 + I_3 + m_3(d_3-l_{c3})^2\right]\ddot\theta_1 + 2m_3(d_3-l_{c3})\dot\theta_1\dot d_3",
      "tau1 = (I1 + I3 + m3*(d3 - lc3)**2)*th1_dd + 2*m3*(d3 - lc3)*th1_d*d3_d"),
    R("inverse of a cylindrical arm", "cylindrical_arm",
      "theta1 = atan2(y, x)\nd2 = z\nd3 = sqrt(x^2 + y^2)",
      "th1 = atan2(y, x); d3 = sqrt(x**2 + y**2)"),
    R("inverse of a polar arm", "polar_arm",
      r"d_3 = \sqrt{x^2 + y^2 + (z - l_1)^2}, \qquad \theta_2 = \arctan\frac{z - l_1}{\sqrt{x^2+y^2}}",
      "d3 = sqrt(x**2 + y**2 + (z - l1)**2); th2 = atan((z - l1)/sqrt(x**2 + y**2))"),
    R("determinant of an elbow arm", "elbow_arm",
      r"\det J = -l_2 l_3\sin\theta_3\,(l_2\cos\theta_2 + l_3\cos(\theta_2+\theta_3))",
      "detJ = -l2*l3*sin(th3)*(l2*cos(th2) + l3*cos(th2 + th3))"),
    R("shoulder of an elbow arm", "elbow_arm",
      "theta2 = atan2(z - l1, sqrt(x^2 + y^2)) - atan2(l3*sin(theta3), l2 + l3*cos(theta3))",
      "th2 = atan2(z - l1, sqrt(x**2 + y**2)) - atan2(l3*sin(th3), l2 + l3*cos(th3))"),
    R("swinging load", "gantry_crane", r"V = -m g l\cos\theta_3\cos\theta_4",
      "V = -m*g*l*cos(th3)*cos(th4)"),
    R("momentum of a crane", "gantry_crane",
      r"\frac{\partial T}{\partial\dot x} = (m_1+m_2+m)\dot x + m l\cos\theta_4\,\dot\theta_4",
      "p1 = (m1 + m2 + m)*x_d + m*l*cos(th4)*th4_d"),
)  # fmt: skip
