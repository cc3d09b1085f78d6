# ruff: noqa: E501 - a result is easier to compare with its book in one line
"""Results from problem sets and books, each written down with its robot before it was tried.

A result is a title, a robot, the answer as one types it, and the same in short Python text, which a
derivation of its own (`check_lines`) proves right in numbers.
"""

import math
from dataclasses import dataclass, field
from typing import Any

import sympy as sp

from check_lines.mechanisms import Body, Mechanism, S
from check_lines.robots import G, arm_of, mechanism

sin, cos = sp.sin, sp.cos


@dataclass(frozen=True)
class Result:
    """One result: closed tells whether its robot is a closed chain."""

    title: str
    robot: str
    answer: str
    formula: str
    options: dict[str, Any] = field(default_factory=dict)


def link(name: str, mass: str = "", com: str = "", inertia: str = "") -> str:
    lines = ["[[link]]", f'name = "{name}"']
    lines += [f'mass = "{mass}"'] if mass else []
    lines += [f'com = ["{com}", 0]'] if com else []
    lines += [f'inertia = "{inertia}"'] if inertia else []
    return "\n".join(lines) + "\n"


def joint(name: str, kind: str, parent: str, child: str, more: str = "") -> str:
    return f'[[joint]]\nname = "{name}"\nkind = "{kind}"\nparent = "{parent}"\nchild = "{child}"\n{more}\n'


def frame(name: str, parent: str, origin: str) -> str:
    return f'[[frame]]\nname = "{name}"\nparent = "{parent}"\norigin = {origin}\n'


def loop(first: str, second: str) -> str:
    return f'[[loop]]\nname = "pin"\nkind = "revolute"\nframes = ["{first}", "{second}"]\n'


def head(name: str, tip: str) -> str:
    return f'name = "{name}"\ndim = 2\ntip = "{tip}"\n' + link("ground")


def numbers(values: dict[str, float], home: dict[str, str]) -> str:
    told = "[parameters]\n" + "".join(f"{x} = {y}\n" for x, y in values.items())
    return told + "[home]\n" + "".join(f"{x} = {y}\n" for x, y in home.items())


PASSIVE = "passive = true"
OFFSET = {"l1": 0.2, "lc1": 0.1, "m1": 1.0, "I1": 0.004, "l2": 0.6, "lc2": 0.3, "m2": 1.5,
          "I2": 0.045, "m3": 2.0, "e": 0.05}  # fmt: skip
WHIT = {"d": 0.5, "r": 0.2, "m1": 1.0, "I1": 0.01, "lc2": 0.3, "m2": 2.0, "I2": 0.1, "m3": 0.5}
YOKE = {"r": 0.15, "lc1": 0.05, "m1": 1.0, "I1": 0.01, "m2": 3.0}
TRAMMEL = {"l": 0.8, "lc2": 0.4, "m1": 0.5, "m2": 2.0, "I2": 0.1, "m3": 0.7}
PARALLEL = {"a": 0.4, "d": 1.0, "lc1": 0.2, "m1": 1.0, "I1": 0.02, "lc2": 0.5, "m2": 2.0, "I2": 0.2,
            "lc3": 0.25, "m3": 1.2, "I3": 0.03}  # fmt: skip
FLIP = '"180 deg"'

TOML = {
    "offset slider-crank": head("offset", "slider")
    + link("crank", "m1", "lc1", "I1") + link("rod", "m2", "lc2", "I2") + link("slider", "m3")
    + joint("crank", "revolute", "ground", "crank")
    + joint("rod", "revolute", "crank", "rod", f'origin = ["l1", 0]\n{PASSIVE}')
    + joint("guide", "prismatic", "ground", "slider", f'origin = [0, "e"]\naxis = "x"\n{PASSIVE}')
    + frame("end", "rod", '["l2", 0]') + loop("slider", "end")
    + numbers({"g": 9.81, **OFFSET}, {"crank": '"50 deg"', "rod": '"-65 deg"', "guide": "0.7"}),
    "quick-return": head("quick_return", "block")
    + link("crank", "m1", "", "I1") + link("rocker", "m2", "lc2", "I2") + link("block", "m3")
    + joint("crank", "revolute", "ground", "crank", 'origin = ["d", 0]')
    + joint("rocker", "revolute", "ground", "rocker", PASSIVE)
    + joint("slide", "prismatic", "rocker", "block", f'axis = "x"\n{PASSIVE}')
    + frame("end", "crank", '["r", 0]') + loop("block", "end")
    + numbers({"g": 9.81, **WHIT}, {"crank": '"60 deg"', "rocker": '"16 deg"', "slide": "0.62"}),
    "scotch yoke": head("yoke", "yoke")
    + link("crank", "m1", "lc1", "I1") + link("yoke", "m2") + link("block")
    + joint("crank", "revolute", "ground", "crank")
    + joint("guide", "prismatic", "ground", "yoke", f'axis = "x"\n{PASSIVE}')
    + joint("slot", "prismatic", "yoke", "block", f'axis = "y"\n{PASSIVE}')
    + frame("end", "crank", '["r", 0]') + loop("block", "end")
    + numbers({"g": 9.81, **YOKE}, {"crank": '"50 deg"', "guide": "0.1", "slot": "0.11"}),
    "trammel": head("trammel", "end")
    + link("shoe1", "m1") + link("bar", "m2", "lc2", "I2") + link("shoe3", "m3")
    + joint("along", "prismatic", "ground", "shoe1", 'axis = "x"')
    + joint("bar", "revolute", "shoe1", "bar", PASSIVE)
    + joint("up", "prismatic", "ground", "shoe3", f'axis = "y"\n{PASSIVE}')
    + frame("end", "bar", '["l", 0]') + loop("shoe3", "end")
    + numbers({"g": 9.81, **TRAMMEL}, {"along": "0.5", "bar": '"128 deg"', "up": "0.62"}),
    "parallelogram": head("parallelogram", "P")
    + link("crank", "m1", "lc1", "I1") + link("coupler", "m2", "lc2", "I2")
    + link("rocker", "m3", "lc3", "I3")
    + joint("crank", "revolute", "ground", "crank")
    + joint("coupler", "revolute", "crank", "coupler", f'origin = ["a", 0]\n{PASSIVE}')
    + joint("rocker", "revolute", "ground", "rocker", f'origin = ["d", 0]\n{PASSIVE}')
    + frame("P", "coupler", '["d", 0]') + frame("end", "rocker", '["a", 0]') + loop("end", "P")
    + numbers({"g": 9.81, **PARALLEL},
               {"crank": '"60 deg"', "coupler": '"-60 deg"', "rocker": '"60 deg"'}),
}  # fmt: skip
WORDS = {"PR": "PR", "RRP": "RRP", "RPR": "RPR", "PRR": "PRR", "my 2R": "RR", "my 3R": "RRR"}


def bar(foot: tuple[Any, Any], i: int, phi: Any) -> Body:
    centre = S(f"lc{i}")
    at = (foot[0] + centre * cos(phi), foot[1] + centre * sin(phi))
    return Body(S(f"m{i}"), S(f"I{i}"), at, phi)


ZERO = sp.Integer(0)


def own_mechanism(robot: str) -> Mechanism:
    """The robot, derived anew."""
    if robot in WORDS:
        return arm_of(robot, WORDS[robot])
    a, b = S("th1"), S("th2")
    if robot == "offset slider-crank":
        pin = (S("l1") * cos(a), S("l1") * sin(a))
        d = S("d3")
        bodies = (bar((ZERO, ZERO), 1, a), bar(pin, 2, a + b), Body(S("m3"), 0, (d, S("e"))))
        loops = (pin[0] + S("l2") * cos(a + b) - d, pin[1] + S("l2") * sin(a + b) - S("e"))
        home = {"th1": math.radians(50), "th2": math.radians(-65), "d3": 0.7}
        return closed_chain(robot, ("th1", "th2", "d3"), bodies, OFFSET, ("th2", "d3"), loops, home)
    if robot == "quick-return":
        d = S("d3")
        pin = (S("d") + S("r") * cos(a), S("r") * sin(a))
        bodies = (
            Body(S("m1"), S("I1"), (S("d"), ZERO), a),
            bar((ZERO, ZERO), 2, b),
            Body(S("m3"), 0, (d * cos(b), d * sin(b)), b),
        )
        loops = (pin[0] - d * cos(b), pin[1] - d * sin(b))
        home = {"th1": math.radians(60), "th2": math.radians(16), "d3": 0.62}
        return closed_chain(robot, ("th1", "th2", "d3"), bodies, WHIT, ("th2", "d3"), loops, home)
    if robot == "scotch yoke":
        x, y = S("d2"), S("d3")
        bodies = (bar((ZERO, ZERO), 1, a), Body(S("m2"), 0, (x, ZERO)), Body(0, 0, (x, y)))
        loops = (S("r") * cos(a) - x, S("r") * sin(a) - y)
        home = {"th1": math.radians(50), "d2": 0.1, "d3": 0.11}
        return closed_chain(robot, ("th1", "d2", "d3"), bodies, YOKE, ("d2", "d3"), loops, home)
    if robot == "trammel":
        x, y = S("d1"), S("d3")
        bodies = (Body(S("m1"), 0, (x, ZERO)), bar((x, ZERO), 2, b), Body(S("m3"), 0, (ZERO, y)))
        loops = (x + S("l") * cos(b), S("l") * sin(b) - y)
        home = {"d1": 0.5, "th2": math.radians(128), "d3": 0.62}
        return closed_chain(robot, ("d1", "th2", "d3"), bodies, TRAMMEL, ("th2", "d3"), loops, home)
    if robot == "parallelogram":
        c = S("th3")
        pin = (S("a") * cos(a), S("a") * sin(a))
        bodies = (bar((ZERO, ZERO), 1, a), bar(pin, 2, a + b), bar((S("d"), ZERO), 3, c))
        loops = (
            pin[0] + S("d") * cos(a + b) - S("d") - S("a") * cos(c),
            pin[1] + S("d") * sin(a + b) - S("a") * sin(c),
        )
        home = {x: math.radians(y) for x, y in (("th1", 60), ("th2", -60), ("th3", 60))}
        coordinates = ("th1", "th2", "th3")
        return closed_chain(robot, coordinates, bodies, PARALLEL, ("th2", "th3"), loops, home)
    return mechanism(robot)


def closed_chain(
    robot: str, coordinates: Any, bodies: Any, values: Any, passive: Any, loops: Any, home: Any
) -> Mechanism:
    return Mechanism(robot, coordinates, bodies, G | values, passive, loops, (), home, serial=False)


R = Result
RESULTS = (
    # slider-crank
    R("piston position", "slider_crank",
      r"d_3 = l_1\cos\theta_1 + \sqrt{l_2^2 - l_1^2\sin^2\theta_1}",
      "d3 = l1*cos(th1) + sqrt(l2**2 - l1**2*sin(th1)**2)"),
    R("piston velocity", "slider_crank",
      r"\dot d_3 = -l_1\dot\theta_1\left(\sin\theta_1 + \frac{l_1\sin 2\theta_1}{2\sqrt{l_2^2 - l_1^2\sin^2\theta_1}}\right)",
      "d3_d = -l1*th1_d*(sin(th1) + l1*sin(2*th1)/(2*sqrt(l2**2 - l1**2*sin(th1)**2)))"),
    R("rod's angular velocity", "slider_crank",
      "omega_2 = -l1*cos(theta1)*dtheta1/(l2*cos(theta1 + theta2))",
      "omega2 = -l1*cos(th1)*th1_d/(l2*cos(th1 + th2))"),
    R("rod's angle", "slider_crank", "theta2 = -theta1 - asin(l1*sin(theta1)/l2)",
      "th2 = -th1 - asin(l1*sin(th1)/l2)"),
    R("law of cosines", "slider_crank", "l2^2 = l1^2 + d3^2 - 2*l1*d3*cos(theta1)",
      "l2**2 = l1**2 + d3**2 - 2*l1*d3*cos(th1)"),
    R("piston's acceleration from the loop", "slider_crank",
      r"\ddot d_3 = -l_1\ddot\theta_1 s_1 - l_1\dot\theta_1^2 c_1 - l_2(\ddot\theta_1+\ddot\theta_2)s_{12} - l_2(\dot\theta_1+\dot\theta_2)^2 c_{12}",
      "d3_dd = -l1*th1_dd*sin(th1) - l1*th1_d**2*cos(th1) - l2*(th1_dd + th2_dd)*sin(th1 + th2)"
      " - l2*(th1_d + th2_d)**2*cos(th1 + th2)"),
    R("power theorem of the engine", "slider_crank",
      r"\tau_1\dot\theta_1 = \frac{dT}{dt} + \frac{dV}{dt}", "tau1*th1_d = T_d + V_d"),
    R("offset piston", "offset slider-crank",
      "d3 = l1*cos(theta1) + sqrt(l2^2 - (e - l1*sin(theta1))^2)",
      "d3 = l1*cos(th1) + sqrt(l2**2 - (e - l1*sin(th1))**2)"),
    R("offset rod", "offset slider-crank", "sin(theta1 + theta2) = (e - l1*sin(theta1))/l2",
      "sin(th1 + th2) = (e - l1*sin(th1))/l2"),
    R("offset piston's velocity", "offset slider-crank",
      r"\dot d_3 = l_1\dot\theta_1\frac{\sin\theta_2}{\cos(\theta_1+\theta_2)}",
      "d3_d = l1*th1_d*sin(th2)/cos(th1 + th2)"),
    R("kinetic energy of the piston", "offset slider-crank", "T_3 = 1/2*m3*d3_d^2",
      "T3 = 1/2*m3*d3_d**2"),
    # quick-return: the inverted slider-crank
    R("rocker's angle", "quick-return", r"\tan\theta_2 = \frac{r\sin\theta_1}{d + r\cos\theta_1}",
      "tan(th2) = r*sin(th1)/(d + r*cos(th1))"),
    R("block on the rocker", "quick-return", "d3 = sqrt(d^2 + r^2 + 2*d*r*cos(theta1))",
      "d3 = sqrt(d**2 + r**2 + 2*d*r*cos(th1))"),
    R("rocker's rate", "quick-return",
      r"\dot\theta_2 = \frac{r (r + d\cos\theta_1)}{r^2 + d^2 + 2 r d\cos\theta_1}\dot\theta_1",
      "th2_d = r*(r + d*cos(th1))/(r**2 + d**2 + 2*r*d*cos(th1))*th1_d"),
    R("sliding speed", "quick-return", "dd3 = -r*dtheta1*sin(theta1 - theta2)",
      "d3_d = -r*th1_d*sin(th1 - th2)", {"names": {"dd3": "d3_d"}}),
    R("perpendicular to the rocker", "quick-return", "d3*dtheta2 = r*dtheta1*cos(theta1 - theta2)",
      "d3*th2_d = r*th1_d*cos(th1 - th2)"),
    # scotch yoke
    R("harmonic motion", "scotch yoke", r"d_2 = r\cos\theta_1", "d2 = r*cos(th1)"),
    R("yoke's acceleration", "scotch yoke",
      r"\ddot d_2 = -r\ddot\theta_1\sin\theta_1 - r\dot\theta_1^2\cos\theta_1",
      "d2_dd = -r*th1_dd*sin(th1) - r*th1_d**2*cos(th1)"),
    R("driving torque", "scotch yoke",
      "tau1 = (I1 + m1*lc1^2 + m2*r^2*sin(theta1)^2)*ddtheta1"
      " + m2*r^2*sin(theta1)*cos(theta1)*dtheta1^2 + m1*g*lc1*cos(theta1)",
      "tau1 = (I1 + m1*lc1**2 + m2*r**2*sin(th1)**2)*th1_dd"
      " + m2*r**2*sin(th1)*cos(th1)*th1_d**2 + m1*g*lc1*cos(th1)"),
    R("energy in one coordinate", "scotch yoke",
      "T = 1/2*(I1 + m1*lc1^2 + m2*r^2*sin(theta1)^2)*dtheta1^2",
      "T = 1/2*(I1 + m1*lc1**2 + m2*r**2*sin(th1)**2)*th1_d**2"),
    # trammel
    R("ends of the ladder", "trammel", "d1^2 + d3^2 = l^2", "d1**2 + d3**2 = l**2"),
    R("rates of the ends", "trammel", r"d_1\dot d_1 + d_3\dot d_3 = 0", "d1*d1_d + d3*d3_d = 0"),
    R("ladder's rate", "trammel", "omega_2 = d1_d/d3", "omega2 = d1_d/d3"),
    R("ladder's potential energy", "trammel", "V = m2*g*lc2*sin(theta2) + m3*g*d3",
      "V = m2*g*lc2*sin(th2) + m3*g*d3"),
    # parallelogram
    R("coupler translates", "parallelogram", r"\omega_2 = 0", "omega2 = 0"),
    R("rocker follows the crank", "parallelogram", r"\theta_3 = \theta_1", "th3 = th1"),
    R("torque of a parallelogram", "parallelogram",
      r"\tau_1 = (I_1 + m_1 l_{c1}^2 + I_3 + m_3 l_{c3}^2 + m_2 a^2)\ddot\theta_1 + (m_1 l_{c1} + m_3 l_{c3} + m_2 a) g\cos\theta_1",
      "tau1 = (I1 + m1*lc1**2 + I3 + m3*lc3**2 + m2*a**2)*th1_dd"
      " + (m1*lc1 + m3*lc3 + m2*a)*g*cos(th1)"),
    # four-bar
    R("Freudenstein's equation", "four_bar",
      "d/l1*cos(theta3) - d/l3*cos(theta1) + (l1^2 - l2^2 + l3^2 + d^2)/(2*l1*l3) = cos(theta1 - theta3)",
      "d/l1*cos(th3) - d/l3*cos(th1) + (l1**2 - l2**2 + l3**2 + d**2)/(2*l1*l3) = cos(th1 - th3)"),
    R("transmission angle", "four_bar",
      r"\cos(\theta_1+\theta_2-\theta_3) = \frac{l_2^2 + l_3^2 - d^2 - l_1^2 + 2 d l_1\cos\theta_1}{2 l_2 l_3}",
      "cos(th1 + th2 - th3) = (l2**2 + l3**2 - d**2 - l1**2 + 2*d*l1*cos(th1))/(2*l2*l3)"),
    R("rocker's rate of a four-bar", "four_bar",
      r"\dot\theta_3 = \frac{l_1\sin\theta_2}{l_3\sin(\theta_1+\theta_2-\theta_3)}\dot\theta_1",
      "th3_d = l1*sin(th2)/(l3*sin(th1 + th2 - th3))*th1_d"),
    R("power of a four-bar", "four_bar", "tau1*omega_1 = dT/dt + dV/dt", "tau1*omega1 = T_d + V_d"),
    # five-bar, double four-bar
    R("first distal link", "five_bar",
      r"(x + b - l_1\cos\theta_1)^2 + (y - l_1\sin\theta_1)^2 = l_3^2",
      "(x + b - l1*cos(th1))**2 + (y - l1*sin(th1))**2 = l3**2"),
    R("velocity along the distal link", "five_bar",
      r"\dot x\cos(\theta_1+\theta_3) + \dot y\sin(\theta_1+\theta_3) = l_1\dot\theta_1\sin\theta_3",
      "x_d*cos(th1 + th3) + y_d*sin(th1 + th3) = l1*th1_d*sin(th3)"),
    R("elbow by the law of cosines", "five_bar",
      "cos(theta3) = ((x + b)^2 + y^2 - l1^2 - l3^2)/(2*l1*l3)",
      "cos(th3) = ((x + b)**2 + y**2 - l1**2 - l3**2)/(2*l1*l3)"),
    R("power of two drives", "five_bar_rods",
      r"\tau_1\dot\theta_1 + \tau_2\dot\theta_2 = \dot T + \dot V",
      "tau1*th1_d + tau2*th2_d = T_d + V_d"),
    R("cranks in parallel", "double_four_bar", "dtheta5 = dtheta1", "th5_d = th1_d"),
    # open chains
    R("Craig (6.58)", "2R",
      r"\tau_2 = m_2 l_1 l_{c2} c_2\ddot\theta_1 + m_2 l_1 l_{c2} s_2\dot\theta_1^2 + m_2 l_{c2} g c_{12} + (m_2 l_{c2}^2 + I_2)(\ddot\theta_1+\ddot\theta_2)",
      "tau2 = m2*l1*lc2*cos(th2)*th1_dd + m2*l1*lc2*sin(th2)*th1_d**2 + m2*lc2*g*cos(th1 + th2)"
      " + (m2*lc2**2 + I2)*(th1_dd + th2_dd)"),
    R("Spong's h", "2R",
      "h = -m2*l1*lc2*sin(q2)\nC = [h*q2_d, h*q2_d + h*q1_d; -h*q1_d, 0]",
      "c1 = -m2*l1*lc2*sin(th2)*(2*th1_d*th2_d + th2_d**2)"),
    R("Siciliano's arm", "2R", r"b_{22} = I_{l_2} + m_{l_2}\ell_2^2", "H22 = I2 + m2*lc2**2",
      {"notation": "siciliano"}),
    R("skew symmetry", "2R", r"\dot M_{11} = -2 m_2 l_1 l_{c2}\sin\theta_2\,\dot\theta_2",
      "H11_d = -2*m2*l1*lc2*sin(th2)*th2_d"),
    R("determinant of the mass matrix", "2R",
      r"\det M = (m_1 l_{c1}^2 + I_1)(m_2 l_{c2}^2 + I_2) + m_2 l_1^2 (m_2 l_{c2}^2\sin^2\theta_2 + I_2)",
      "H11*H22 - H12**2 = (m1*lc1**2 + I1)*(m2*lc2**2 + I2)"
      " + m2*l1**2*(m2*lc2**2*sin(th2)**2 + I2)"),
    R("manipulability", "2R", r"\det J = l_1 l_2\sin\theta_2", "detJ = l1*l2*sin(th2)"),
    R("elbow angle", "2R", "theta2 = acos((x^2 + y^2 - l1^2 - l2^2)/(2*l1*l2))",
      "th2 = acos((x**2 + y**2 - l1**2 - l2**2)/(2*l1*l2))"),
    R("shoulder angle", "2R", "theta1 = atan2(y, x) - atan2(l2*sin(theta2), l1 + l2*cos(theta2))",
      "th1 = atan2(y, x) - atan2(l2*sin(th2), l1 + l2*cos(th2))"),
    R("half-angle of the elbow", "2R",
      r"\theta_2 = 2\arctan\sqrt{\frac{(l_1+l_2)^2 - (x^2+y^2)}{(x^2+y^2) - (l_1-l_2)^2}}",
      "th2 = 2*atan(sqrt(((l1 + l2)**2 - (x**2 + y**2))/((x**2 + y**2) - (l1 - l2)**2)))"),
    R("force at the elbow", "2R", "f_12y = m2*(a_c2y + g)", "f12y = m2*(ac2y + g)"),
    R("power of an arm", "2R", "tau1*dtheta1 + tau2*dtheta2 = dT/dt + dV/dt",
      "tau1*th1_d + tau2*th2_d = T_d + V_d"),
    R("Euler's equation about the joint", "pendulum", "tau1 = (I1 + m1*lc1^2)*alpha_1 + m1*g*lc1*cos(theta1)",
      "tau1 = (I1 + m1*lc1**2)*omega1_d + m1*g*lc1*cos(th1)"),
    R("reaction of a pendulum", "pendulum",
      r"f_{01,y} = m_1 g + m_1 l_{c1}(\ddot\theta_1\cos\theta_1 - \dot\theta_1^2\sin\theta_1)",
      "f01y = m1*g + m1*lc1*(th1_dd*cos(th1) - th1_d**2*sin(th1))"),
    R("radial force of RP", "RP", r"\tau_2 = m_2\ddot d_2 - m_2(d_2+l_{c2})\dot\theta_1^2 + m_2 g\sin\theta_1",
      "tau2 = m2*d2_dd - m2*(d2 + lc2)*th1_d**2 + m2*g*sin(th1)"),
    R("Coriolis force of RP", "RP", "c1 = 2*m2*(d2 + lc2)*theta1_d*d2_d",
      "c1 = 2*m2*(d2 + lc2)*th1_d*d2_d"),
    R("angular momentum of RP", "RP", r"\frac{\partial L}{\partial\dot\theta_1} = (I_1 + I_2 + m_1 l_{c1}^2 + m_2 (d_2 + l_{c2})^2)\dot\theta_1",
      "p1 = (I1 + I2 + m1*lc1**2 + m2*(d2 + lc2)**2)*th1_d"),
    R("Tedrake's cart-pole", "cart_pole",
      r"\ddot x = \frac{1}{m_1 + m_2\sin^2\theta_2}\left[\tau_1 + m_2\sin\theta_2(l_2\dot\theta_2^2 + g\cos\theta_2)\right]",
      "x_dd = (tau1 + m2*sin(th2)*(l2*th2_d**2 + g*cos(th2)))/(m1 + m2*sin(th2)**2)"),
    R("swing of the pole", "cart_pole", "l2*ddtheta2 + g*sin(theta2) = -xdd*cos(theta2)",
      "l2*th2_dd + g*sin(th2) = -x_dd*cos(th2)", {"names": {"xdd": "x_dd"}}),
    R("cart's momentum", "cart_pole", r"\frac{\partial T}{\partial\dot x} = (m_1+m_2)\dot x + m_2 l_2\dot\theta_2\cos\theta_2",
      "p1 = (m1 + m2)*x_d + m2*l2*th2_d*cos(th2)"),
    R("reaction wheel", "reaction_wheel", r"\tau_2 = I_2(\ddot\theta_1+\ddot\theta_2)",
      "tau2 = I2*(th1_dd + th2_dd)"),
    R("ball on a beam held still", "ball_and_beam",
      "(m2 + J2)*d2_dd - m2*r*ddtheta1 - m2*d2*dtheta1^2 + m2*g*sin(theta1) = 0",
      "(m2 + J2)*d2_dd - m2*r*th1_dd - m2*d2*th1_d**2 + m2*g*sin(th1) = 0"),
    R("Furuta's pendulum", "furuta",
      r"(I_2 + m_2 l_{c2}^2)\ddot\theta_2 = m_2 l_1 l_{c2}\cos\theta_2\,\ddot\theta_1 + (I_2 + m_2 l_{c2}^2)\sin\theta_2\cos\theta_2\,\dot\theta_1^2 + m_2 g l_{c2}\sin\theta_2",
      "(I2 + m2*lc2**2)*th2_dd = m2*l1*lc2*cos(th2)*th1_dd"
      " + (I2 + m2*lc2**2)*sin(th2)*cos(th2)*th1_d**2 + m2*g*lc2*sin(th2)"),
    R("elbow arm's hand", "elbow_arm", "z = l1 + l2*sin(theta2) + l3*sin(theta2 + theta3)",
      "z = l1 + l2*sin(th2) + l3*sin(th2 + th3)"),
    R("elbow arm's inertia about the column", "elbow_arm",
      "H11 = I1 + (I2 + m2*lc2^2)*cos(theta2)^2 + I3*cos(theta2 + theta3)^2"
      " + m3*(l2*cos(theta2) + lc3*cos(theta2 + theta3))^2",
      "H11 = I1 + (I2 + m2*lc2**2)*cos(th2)**2 + I3*cos(th2 + th3)**2"
      " + m3*(l2*cos(th2) + lc3*cos(th2 + th3))**2"),
    R("polar arm outwards", "polar_arm",
      r"\tau_3 = m_3\ddot d_3 - m_3(d_3 - l_{c3})(\dot\theta_2^2 + \dot\theta_1^2\cos^2\theta_2) + m_3 g\sin\theta_2",
      "tau3 = m3*d3_dd - m3*(d3 - lc3)*(th2_d**2 + th1_d**2*cos(th2)**2) + m3*g*sin(th2)"),
    R("crane's load", "gantry_crane",
      r"\ddot y\cos\theta_3 + l\cos\theta_4\,\ddot\theta_3 - 2 l\sin\theta_4\,\dot\theta_3\dot\theta_4 + g\sin\theta_3 = 0",
      "y_dd*cos(th3) + l*cos(th4)*th3_dd - 2*l*sin(th4)*th3_d*th4_d + g*sin(th3) = 0"),
    R("own PR: cart with a link", "PR",
      "tau1 = (m1 + m2)*d1_dd - m2*lc2*(theta2_dd*sin(theta2) + theta2_d^2*cos(theta2))",
      "tau1 = (m1 + m2)*d1_dd - m2*lc2*(th2_dd*sin(th2) + th2_d**2*cos(th2))"),
    R("own RPR: tip", "RPR", "x = (l1 + d2)*cos(theta1) + l3*cos(theta1 + theta3)",
      "x = (l1 + d2)*cos(th1) + l3*cos(th1 + th3)"),
    R("own PRR: gravity", "PRR", r"G_3 = m_3 g l_{c3}\cos(\theta_2+\theta_3)",
      "G3 = m3*g*lc3*cos(th2 + th3)"),
    R("own 3R: forces at the wrist", "my 3R",
      r"f_{23,x} = m_3 a_{c3,x}", "f23x = m3*ac3x"),
)  # fmt: skip
