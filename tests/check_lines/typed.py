# ruff: noqa: E501 - an answer is a line
"""Lines as they stand in books and in files of tools, whole vectors and matrices among them.

Each is typed as it is written there, and once more in short Python text, which is proven: several
formulas for the entries of a matrix.
"""

from dataclasses import dataclass, field
from typing import Any


@dataclass(frozen=True)
class Typed:
    """An answer about a robot, and what it says."""

    family: str
    answer: str
    formulas: tuple[str, ...]
    options: dict[str, Any] = field(default_factory=dict)


H11 = "H11 = m1*lc1**2 + I1 + I2 + m2*(l1**2 + lc2**2 + 2*l1*lc2*cos(th2))"
H12 = "H12 = m2*(lc2**2 + l1*lc2*cos(th2)) + I2"
H22 = "H22 = m2*lc2**2 + I2"
G1 = "G1 = (m1*lc1 + m2*l1)*g*cos(th1) + m2*lc2*g*cos(th1 + th2)"
G2 = "G2 = m2*lc2*g*cos(th1 + th2)"
C1 = "c1 = -m2*l1*lc2*sin(th2)*(2*th1_d*th2_d + th2_d**2)"
C2 = "c2 = m2*l1*lc2*sin(th2)*th1_d**2"
TAU = ("tau1 = H11*th1_dd + H12*th2_dd + c1 + G1", "tau2 = H12*th1_dd + H22*th2_dd + c2 + G2")
KINETIC = "T = 1/2*H11*th1_d**2 + H12*th1_d*th2_d + 1/2*H22*th2_d**2"
VX = "x_d = -l1*sin(th1)*th1_d - l2*sin(th1 + th2)*(th1_d + th2_d)"
VY = "y_d = l1*cos(th1)*th1_d + l2*cos(th1 + th2)*(th1_d + th2_d)"

TWO = (
    Typed(
        "whole matrix",
        "M = [m1*lc1^2 + I1 + I2 + m2*(l1^2 + lc2^2 + 2*l1*lc2*cos(theta2)), m2*(lc2^2 + l1*lc2*cos(theta2)) + I2; m2*(lc2^2 + l1*lc2*cos(theta2)) + I2, m2*lc2^2 + I2]",
        (H11, H12, H22),
    ),
    Typed(
        "whole matrix",
        r"M(q) = \begin{bmatrix} I_1 + I_2 + m_1 l_{c1}^2 + m_2(l_1^2 + l_{c2}^2 + 2 l_1 l_{c2} c_2) & I_2 + m_2(l_{c2}^2 + l_1 l_{c2} c_2) \\ I_2 + m_2(l_{c2}^2 + l_1 l_{c2} c_2) & I_2 + m_2 l_{c2}^2 \end{bmatrix}",
        (H11, H12, H22),
    ),
    Typed(
        "whole matrix",
        "M = Matrix([[I1 + I2 + l1**2*m2 + 2*l1*lc2*m2*cos(theta2) + lc1**2*m1 + lc2**2*m2, I2 + l1*lc2*m2*cos(theta2) + lc2**2*m2], [I2 + l1*lc2*m2*cos(theta2) + lc2**2*m2, I2 + lc2**2*m2]])",
        (H11, H12, H22),
    ),
    Typed(
        "whole matrix",
        r"J = \begin{pmatrix} -l_1 s_1 - l_2 s_{12} & -l_2 s_{12} \\ l_1 c_1 + l_2 c_{12} & l_2 c_{12} \end{pmatrix}",
        (VX, VY),
    ),
    Typed(
        "whole matrix",
        r"J^{-1} = \frac{1}{l_1 l_2 s_2}\begin{bmatrix} l_2 c_{12} & l_2 s_{12} \\ -l_1 c_1 - l_2 c_{12} & -l_1 s_1 - l_2 s_{12} \end{bmatrix}",
        (
            "th1_d = (l2*cos(th1 + th2)*x_d + l2*sin(th1 + th2)*y_d)/(l1*l2*sin(th2))",
            "th2_d = ((-l1*cos(th1) - l2*cos(th1 + th2))*x_d + (-l1*sin(th1) - l2*sin(th1 + th2))*y_d)/(l1*l2*sin(th2))",
        ),
    ),
    Typed(
        "whole matrix",
        r"C(q,\dot q) = \begin{bmatrix} h\dot\theta_2 & h(\dot\theta_1+\dot\theta_2) \\ -h\dot\theta_1 & 0 \end{bmatrix},\quad h = -m_2 l_1 l_{c2}\sin\theta_2",
        (C1, C2),
    ),
    Typed(
        "whole matrix",
        "C = [-m2*l1*lc2*sin(theta2)*dtheta2, -m2*l1*lc2*sin(theta2)*(dtheta1 + dtheta2); m2*l1*lc2*sin(theta2)*dtheta1, 0]",
        (C1, C2),
    ),
    Typed(
        "whole vector",
        "G = [(m1*lc1 + m2*l1)*g*cos(theta1) + m2*lc2*g*cos(theta1 + theta2); m2*lc2*g*cos(theta1 + theta2)]",
        (G1, G2),
    ),
    Typed(
        "whole vector",
        r"g(q) = \begin{bmatrix} (m_1 l_{c1} + m_2 l_1) g\cos\theta_1 + m_2 l_{c2} g\cos(\theta_1+\theta_2) \\ m_2 l_{c2} g\cos(\theta_1+\theta_2) \end{bmatrix}",
        (G1, G2),
    ),
    Typed(
        "whole vector",
        "c = [-m2*l1*lc2*sin(theta2)*(2*dtheta1*dtheta2 + dtheta2^2); m2*l1*lc2*sin(theta2)*dtheta1^2]",
        (C1, C2),
    ),
    Typed("vector equation", r"\tau = M(q)\ddot q + C(q,\dot q)\dot q + g(q)", TAU),
    Typed("vector equation", "tau = M*qdd + c + g", TAU),
    Typed("vector equation", r"\tau = D(q)\ddot q + C(q,\dot q)\dot q + g(q)", TAU),
    Typed("vector equation", r"T = \frac{1}{2}\dot q^T M(q)\dot q", (KINETIC,)),
    Typed("vector equation", "T = 1/2*dq'*M*dq", (KINETIC,)),
    Typed("vector equation", "T = 0.5*qd.T @ M @ qd", (KINETIC,)),
    Typed("vector equation", r"\dot x = J\dot q", (VX, VY)),
    Typed("vector equation", r"\begin{bmatrix}\dot x\\ \dot y\end{bmatrix} = J(q)\dot q", (VX, VY)),
    Typed("vector equation", r"\ddot q = M^{-1}(\tau - C\dot q - g)", TAU),
    Typed("vector equation", "f_12 = m2*(a_c2 - g)", ("f12x = m2*ac2x", "f12y = m2*(ac2y + g)")),
    Typed(
        "vector equation",
        r"f_{01} - f_{12} + m_1 g = m_1 a_{c1}",
        ("f01x - f12x = m1*ac1x", "f01y - f12y - m1*g = m1*ac1y"),
    ),
    Typed(
        "vector equation",
        r"v_{c2} = v_{2} + \omega_2\times s_{c2}",
        ("vc2x = -l1*sin(th1)*th1_d - lc2*sin(th1 + th2)*omega2",),
    ),
    Typed(
        "vector equation",
        r"L = \frac12\dot q^T M\dot q - V",
        ("L = 1/2*H11*th1_d**2 + H12*th1_d*th2_d + 1/2*H22*th2_d**2 - V",),
    ),
    Typed("determinant", r"\det J = l_1 l_2\sin\theta_2", ("detJ = l1*l2*sin(th2)",)),
    Typed(
        "determinant",
        "det(M) = (m1*lc1^2 + I1)*(m2*lc2^2 + I2) + m2*l1^2*(m2*lc2^2*sin(theta2)^2 + I2)",
        (
            "H11*H22 - H12**2 = (m1*lc1**2 + I1)*(m2*lc2**2 + I2) + m2*l1**2*(m2*lc2**2*sin(th2)**2 + I2)",
        ),
    ),
    Typed("statics", "In equilibrium: tau2 = m2*g*lc2*cos(theta1 + theta2)", (G2,)),
    Typed(
        "absolute angles",
        "H12 = m2*l1*lc2*cos(theta2 - theta1)",
        ("H12 - H22 = m2*l1*lc2*cos(th2)",),
        {"absolute": True},
    ),
    Typed(
        "absolute angles",
        "M11 = I1 + m1*lc1^2 + m2*l1^2",
        ("H11 - 2*H12 + H22 = I1 + m1*lc1**2 + m2*l1**2",),
        {"absolute": True},
    ),
    Typed(
        "absolute angles",
        "G1 = (m1*lc1 + m2*l1)*g*cos(theta1)",
        ("G1 - G2 = (m1*lc1 + m2*l1)*g*cos(th1)",),
        {"absolute": True},
    ),
    Typed(
        "absolute angles",
        "T = 1/2*(I1 + m1*lc1^2 + m2*l1^2)*dtheta1^2 + 1/2*(I2 + m2*lc2^2)*dtheta2^2 + m2*l1*lc2*dtheta1*dtheta2*cos(theta1 - theta2)",
        (
            "T = 1/2*(I1 + m1*lc1**2 + m2*l1**2)*th1_d**2 + 1/2*(I2 + m2*lc2**2)*(th1_d + th2_d)**2 + m2*l1*lc2*th1_d*(th1_d + th2_d)*cos(th2)",
        ),
        {"absolute": True},
    ),
    Typed(
        "absolute angles",
        "x = l1*cos(theta1) + l2*cos(theta2)",
        ("x = l1*cos(th1) + l2*cos(th1 + th2)",),
        {"absolute": True},
    ),
    Typed("rods", "H22 = 1/3*m2*l2^2", (), {"parameters": {"lc": "l/2", "I": "m*l^2/12"}}),
    Typed(
        "rods",
        r"G_2 = \frac{1}{2} m_2 g l_2\cos(\theta_1+\theta_2)",
        (),
        {"parameters": {"lc": "l/2", "I": "m*l^2/12"}},
    ),
    Typed(
        "rods",
        "H12 = m2*l2^2/3 + m2*l1*l2*cos(theta2)/2",
        (),
        {"parameters": {"lc": "l/2", "I": "m*l^2/12"}},
    ),
    Typed("rods", "H22 = m2*l2^2", (), {"parameters": {"lc": "l", "I": 0}}),
    Typed(
        "rods",
        "H11 = (m1 + m2)*l1^2 + m2*l2^2 + 2*m2*l1*l2*cos(theta2)",
        (),
        {"parameters": {"lc": "l", "I": 0}},
    ),
    Typed(
        "notation of a book",
        r"V_1 = -m_2 l_1 l_{c2} s_2\dot\theta_2^2 - 2 m_2 l_1 l_{c2} s_2\dot\theta_1\dot\theta_2",
        (C1,),
        {"notation": "craig"},
    ),
    Typed("notation of a book", r"d_{22} = m_2\ell_{c2}^2 + I_2", (H22,), {"notation": "spong"}),
    Typed(
        "notation of a book",
        r"d_{12} = m_2(\ell_{c2}^2 + \ell_1\ell_{c2}\cos q_2) + I_2",
        (H12,),
        {"notation": "spong"},
    ),
    Typed(
        "notation of a book", r"c_{121} = -m_2\ell_1\ell_{c2}\sin q_2", (), {"notation": "spong"}
    ),
    Typed(
        "notation of a book",
        "h = -m_2 l_1 l_{c2} \\sin q_2\nC = \\begin{bmatrix} h\\dot q_2 & h\\dot q_2 + h\\dot q_1 \\\\ -h\\dot q_1 & 0\\end{bmatrix}",
        (C1, C2),
        {"notation": "spong"},
    ),
    Typed(
        "notation of a book", r"\phi_2 = m_2\ell_{c2} g\cos(q_1+q_2)", (G2,), {"notation": "spong"}
    ),
    Typed("derivatives by calls", "G2 = diff(V, theta2)", (G2,)),
    Typed("derivatives by calls", "H11 = diff(T, dtheta1, dtheta1)", (H11,)),
    Typed(
        "derivatives by calls",
        "tau1 = diff(diff(L, dtheta1), t) - diff(L, theta1)",
        ("tau1 = p1_d - dLdq1",),
    ),
    Typed(
        "derivatives by calls",
        "tau1 = Derivative(Derivative(L, Derivative(theta1(t), t)), t) - Derivative(L, theta1(t))",
        ("tau1 = p1_d - dLdq1",),
    ),
    Typed("sum over bodies", r"V = \sum_{i=1}^{2} m_i g y_{ci}", ("V = m1*g*yc1 + m2*g*yc2",)),
    Typed(
        "sum over bodies",
        r"T = \sum_{i=1}^2 \left(\frac12 m_i v_{ci}^2 + \frac12 I_i\omega_i^2\right)",
        (
            "T = 1/2*m1*(vc1x**2 + vc1y**2) + 1/2*I1*omega1**2 + 1/2*m2*(vc2x**2 + vc2y**2) + 1/2*I2*omega2**2",
        ),
    ),
)
CRANK = (
    Typed("position at a state", "d3 = 0.739 m at theta1 = 40°", ()),
    Typed(
        "loop equation",
        "l1*cos(theta1) + l2*cos(theta1 + theta2) - d3 = 0\nl1*sin(theta1) + l2*sin(theta1 + theta2) = 0",
        ("Phi1 = 0", "Phi2 = 0"),
    ),
    Typed(
        "rates by the loops",
        "-l1*dtheta1*sin(theta1) - l2*(dtheta1 + dtheta2)*sin(theta1 + theta2) - dd3 = 0",
        ("Phi1_d = 0",),
        {"names": {"dd3": "d3_d"}},
    ),
    Typed(
        "energy in one coordinate",
        "T_3 = 1/2*m3*l1^2*dtheta1^2*sin(theta2)^2/cos(theta1 + theta2)^2",
        ("T3 = 1/2*m3*l1**2*th1_d**2*sin(th2)**2/cos(th1 + th2)**2",),
    ),
    Typed(
        "definition",
        "lambda = l1/l2\nsin(theta1 + theta2) = -lambda*sin(theta1)",
        ("sin(th1 + th2) = -l1/l2*sin(th1)",),
    ),
    Typed(
        "definition",
        "phi = theta1 + theta2\nd3 = l1*cos(theta1) + l2*cos(phi)",
        ("d3 = l1*cos(th1) + l2*cos(th1 + th2)",),
    ),
    Typed(
        "definition",
        "beta = asin(l1*sin(theta1)/l2)\nd3 = l1*cos(theta1) + l2*cos(beta)",
        ("d3 = l1*cos(th1) + l2*cos(asin(l1*sin(th1)/l2))",),
    ),
)
FOUR = (
    Typed(
        "definition",
        "K1 = d/l1\nK2 = d/l3\nK3 = (l1^2 - l2^2 + l3^2 + d^2)/(2*l1*l3)\nK1*cos(theta3) - K2*cos(theta1) + K3 = cos(theta1 - theta3)",
        (
            "d/l1*cos(th3) - d/l3*cos(th1) + (l1**2 - l2**2 + l3**2 + d**2)/(2*l1*l3) = cos(th1 - th3)",
        ),
    ),
    Typed(
        "definition",
        "phi = theta1 + theta2\nomega_3 = l1*sin(theta1 - phi)/(l3*sin(theta3 - phi))*dtheta1",
        ("omega3 = l1*sin(-th2)/(l3*sin(th3 - th1 - th2))*th1_d",),
    ),
    Typed(
        "definition",
        "f = sqrt(d^2 + l1^2 - 2*d*l1*cos(theta1))\ncos(theta1 + theta2 - theta3) = (l2^2 + l3^2 - f^2)/(2*l2*l3)",
        ("cos(th1 + th2 - th3) = (l2**2 + l3**2 - d**2 - l1**2 + 2*d*l1*cos(th1))/(2*l2*l3)",),
    ),
    Typed(
        "position",
        r"\theta_3 = \arctan2(l_1 s_1 + l_2 s_{12},\; l_1 c_1 + l_2 c_{12} - d)",
        ("th3 = atan2(l1*sin(th1) + l2*sin(th1 + th2), l1*cos(th1) + l2*cos(th1 + th2) - d)",),
    ),
)
BRICARD = (
    Typed("relation", "cos(theta1) + cos(theta2) + cos(theta1)*cos(theta2) = 0", ()),
    Typed("relation", "theta3 = theta1", ()),
    Typed("relation", "theta4 = theta2", ()),
    Typed("relation", "dtheta5 = dtheta1", ()),
    Typed("relation", r"\dot\theta_4 = \dot\theta_2", ()),
    Typed(
        "relation",
        r"\sin\theta_1 (1 + \cos\theta_2)\dot\theta_1 = -\sin\theta_2 (1 + \cos\theta_1)\dot\theta_2",
        (),
    ),
)
QUADROTOR = tuple(
    Typed("free body", x, ())
    for x in (
        r"I_x \dot p = (I_y - I_z) q r + l (f_2 - f_4)",
        r"I_y \dot q = (I_z - I_x) r p + l (f_3 - f_1)",
        r"I_z \dot r = (I_x - I_y) p q",
        r"m\ddot z = -m g + (f_1 + f_2 + f_3 + f_4)\cos\phi\cos\theta",
        r"m\ddot x = (f_1 + f_2 + f_3 + f_4)(\cos\psi\sin\theta\cos\phi + \sin\psi\sin\phi)",
        r"\dot\phi = p + q\sin\phi\tan\theta + r\cos\phi\tan\theta",
        r"\dot\theta = q\cos\phi - r\sin\phi",
        r"\dot\psi = \frac{q\sin\phi + r\cos\phi}{\cos\theta}",
        r"5 \dot p = -5 q r + 0.5 (f_2 - f_4)",
        r"m(\dot u + q w - r v) = m g\sin\theta",
        r"\dot w = q u - p v + g\cos\theta\cos\phi\cdot(-1) + (f_1 + f_2 + f_3 + f_4)/m",
        "I_x*dp = (I_y - I_z)*q*r + l*(f_2 - f_4)",
        r"n = I\dot\omega + \omega\times(I\omega)",
        r"T = \frac12 m (u^2 + v^2 + w^2) + \frac12 (I_x p^2 + I_y q^2 + I_z r^2)",
        "V = m*g*z",
    )
)
ABSOLUTE = {"absolute": True}
BOOK_FOUR = {
    "names": {
        "a": "l1",
        "b": "l2",
        "c": "l3",
        "alpha": "theta1",
        "beta": "theta2",
        "gamma": "theta3",
    },
    "absolute": True,
}
FREUDENSTEIN = (
    "d/l1*cos(th3) - d/l3*cos(th1) + (l1**2 - l2**2 + l3**2 + d**2)/(2*l1*l3) = cos(th1 - th3)"
)
RATE3 = "th3_d = l1*sin(-th2)/(l3*sin(th3 - th1 - th2))*th1_d"
FOUR += (
    Typed(
        "absolute angles",
        "l1*cos(theta1) + l2*cos(theta2) - l3*cos(theta3) - d = 0",
        ("Phi1 = 0",),
        ABSOLUTE,
    ),
    Typed(
        "absolute angles",
        r"l_1\sin\theta_1 + l_2\sin\theta_2 = l_3\sin\theta_3",
        ("Phi2 = 0",),
        ABSOLUTE,
    ),
    Typed(
        "absolute angles",
        r"\dot\theta_3 = \frac{l_1\sin(\theta_1-\theta_2)}{l_3\sin(\theta_3-\theta_2)}\dot\theta_1",
        (RATE3,),
        ABSOLUTE,
    ),
    Typed(
        "absolute angles",
        r"\dot\theta_2 = \frac{l_1\sin(\theta_3-\theta_1)}{l_2\sin(\theta_2-\theta_3)}\dot\theta_1",
        ("omega2 = l1*sin(th3 - th1)/(l2*sin(th1 + th2 - th3))*th1_d",),
        ABSOLUTE,
    ),
    Typed(
        "book's letters", "a*cos(alpha) + b*cos(beta) = d + c*cos(gamma)", ("Phi1 = 0",), BOOK_FOUR
    ),
    Typed(
        "book's letters",
        "d/a*cos(gamma) - d/c*cos(alpha) + (a^2 - b^2 + c^2 + d^2)/(2*a*c) = cos(alpha - gamma)",
        (FREUDENSTEIN,),
        BOOK_FOUR,
    ),
    Typed(
        "book's letters",
        "c*sin(gamma)*dgamma = a*sin(alpha)*dalpha + b*sin(beta)*dbeta",
        ("l3*sin(th3)*th3_d = l1*sin(th1)*th1_d + l2*sin(th1 + th2)*(th1_d + th2_d)",),
        BOOK_FOUR,
    ),
    Typed(
        "rocker's angle",
        "theta3 = 2*atan((l1*sin(theta1) + l2*sin(theta1 + theta2))/(l3 + l1*cos(theta1) + l2*cos(theta1 + theta2) - d))",
        (
            "th3 = 2*atan((l1*sin(th1) + l2*sin(th1 + th2))/(l3 + l1*cos(th1) + l2*cos(th1 + th2) - d))",
        ),
    ),
    Typed("power", r"P = \tau_1\dot\theta_1", ("P = tau1*th1_d",)),
)
CRANK += (
    Typed(
        "absolute angles",
        "d3 = l1*cos(theta1) + l2*cos(theta2)",
        ("d3 = l1*cos(th1) + l2*cos(th1 + th2)",),
        ABSOLUTE,
    ),
    Typed(
        "absolute angles",
        r"\sin\theta_2 = -\frac{l_1}{l_2}\sin\theta_1",
        ("sin(th1 + th2) = -l1/l2*sin(th1)",),
        ABSOLUTE,
    ),
    Typed(
        "absolute angles",
        r"\dot\theta_2 = -\frac{l_1\cos\theta_1}{l_2\cos\theta_2}\dot\theta_1",
        ("omega2 = -l1*cos(th1)/(l2*cos(th1 + th2))*th1_d",),
        ABSOLUTE,
    ),
    Typed(
        "absolute angles",
        r"\dot d_3 = -l_1\dot\theta_1\frac{\sin(\theta_1-\theta_2)}{\cos\theta_2}",
        ("d3_d = -l1*th1_d*sin(-th2)/cos(th1 + th2)",),
        ABSOLUTE,
    ),
    Typed(
        "book's letters",
        "s = r*cos(phi) + sqrt(l^2 - r^2*sin(phi)^2)",
        ("d3 = l1*cos(th1) + sqrt(l2**2 - l1**2*sin(th1)**2)",),
        {"names": {"s": "d3", "r": "l1", "l": "l2", "phi": "theta1"}},
    ),
    Typed(
        "book's letters",
        r"x = r\cos\theta + l\cos\phi, \quad r\sin\theta = l\sin\phi",
        ("d3 = l1*cos(th1) + l2*cos(-th1 - th2)", "l1*sin(th1) = l2*sin(-th1 - th2)"),
        {"names": {"x": "d3", "r": "l1", "l": "l2", "theta": "theta1", "phi": "-theta1-theta2"}},
    ),
    Typed(
        "statics",
        "In equilibrium: tau1 = (m1*lc1 + m2*l1*(1 - lc2/l2))*g*cos(theta1)",
        (
            "G1 + G2*(-1 - l1*cos(th1)/(l2*cos(th1 + th2))) = (m1*lc1 + m2*l1*(1 - lc2/l2))*g*cos(th1)",
        ),
    ),
)
CART = {"names": {"M": "m1", "m": "m2", "l": "l2", "theta": "theta2", "F": "tau1"}}
CART_POLE = (
    Typed(
        "book's letters",
        "(M + m)*x_dd + m*l*theta_dd*cos(theta) - m*l*theta_d^2*sin(theta) = F",
        ("(m1 + m2)*x_dd + m2*l2*th2_dd*cos(th2) - m2*l2*th2_d**2*sin(th2) = tau1",),
        CART,
    ),
    Typed(
        "book's letters",
        r"(M + m)\ddot x + m l\ddot\theta\cos\theta - m l\dot\theta^2\sin\theta = F",
        ("(m1 + m2)*x_dd + m2*l2*th2_dd*cos(th2) - m2*l2*th2_d**2*sin(th2) = tau1",),
        CART,
    ),
    Typed(
        "book's letters",
        r"l\ddot\theta + \ddot x\cos\theta + g\sin\theta = 0",
        ("l2*th2_dd + x_dd*cos(th2) + g*sin(th2) = 0",),
        CART,
    ),
)
PENDULUM = (
    Typed(
        "book's letters",
        "m*l^2*theta_dd + m*g*l*cos(theta) = tau",
        (),
        {
            "names": {"m": "m1", "l": "lc1", "theta": "theta1", "tau": "tau1"},
            "parameters": {"I1": 0},
        },
    ),
    Typed(
        "book's letters",
        r"J\ddot\theta + m g a\cos\theta = \tau",
        (),
        {
            "names": {
                "m": "m1",
                "a": "lc1",
                "theta": "theta1",
                "tau": "tau1",
                "J": "(I1 + m1*lc1^2)",
            }
        },
    ),
)
POLAR = (
    Typed(
        "book's letters",
        r"m_2\ddot r - m_2 (r + l_{c2})\dot\theta^2 + m_2 g\sin\theta = F",
        ("m2*d2_dd - m2*(d2 + lc2)*th1_d**2 + m2*g*sin(th1) = tau2",),
        {"names": {"r": "d2", "theta": "theta1", "F": "tau2"}},
    ),
)
TWO += (
    Typed(
        "a name for an expression",
        "tau_g1 = -(m1*lc1 + m2*l1)*g*cos(theta1) - m2*lc2*g*cos(theta1 + theta2)",
        (G1,),
        {"names": {"tau_g": "-G"}},
    ),
    Typed("statics", "tau2 = -l2*sin(theta1 + theta2)*F_x + l2*cos(theta1 + theta2)*F_y", ()),
    Typed("statics", r"\tau = J^T F", ()),
    Typed(
        "sum over bodies",
        r"M = \sum_{i=1}^{2}\left(m_i J_{v_{ci}}^T J_{v_{ci}} + I_i J_{\omega_i}^T J_{\omega_i}\right)",
        (),
    ),
    Typed(
        "matrix equation",
        r"\dot M - 2C = \begin{bmatrix} 0 & -n \\ n & 0\end{bmatrix},\quad n = 2 h\dot\theta_1 + h\dot\theta_2,\quad h = -m_2 l_1 l_{c2}\sin\theta_2",
        (),
    ),
)
TYPED = {
    "cart_pole": CART_POLE,
    "pendulum": PENDULUM,
    "RP": POLAR,
    "bricard": BRICARD,
    "quadrotor": QUADROTOR,
    "2R": TWO,
    "slider_crank": CRANK,
    "four_bar": FOUR,
}


def typed(robot: str) -> tuple[Typed, ...]:
    """The robot's lines of this kind."""
    return TYPED.get(robot, ())
