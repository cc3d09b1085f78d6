"""The same right answer about an arm of two links as plain text, Markdown, LaTeX, a notebook and
code."""

from __future__ import annotations

import json

MARKDOWN = r"""# Homework 3: the $2R$ arm, where x = y

We use $\theta_1$ and $\theta_2$; for $\theta_2 = 0$ the arm is stretched, and $g = 9.81$.

The mass matrix is
$$
M(q) = \begin{bmatrix} m_1 l_{c1}^2 + I_1 + m_2 (l_1^2 + l_{c2}^2 + 2 l_1 l_{c2} c_2) + I_2
 & m_2 (l_{c2}^2 + l_1 l_{c2} c_2) + I_2 \\
 m_2 (l_{c2}^2 + l_1 l_{c2} c_2) + I_2 & m_2 l_{c2}^2 + I_2 \end{bmatrix} \tag{1}
$$
and the gravity of joint two is \(G_2 = m_2 g l_{c2} \cos(\theta_1 + \theta_2)\), where:

- so h = m2 l1 lc2 sin(theta2), and c2 = h dtheta1^2.

$$\begin{aligned}
\frac{\partial L}{\partial \dot\theta_2} &= H_{12} \dot{\theta}_1 + H_{22} \dot{\theta}_2 \\
\tau_2 &= H_{12} \frac{d^2\theta_1}{dt^2} + H_{22} \ddot\theta_2 \\
&+ h \left(\frac{d\theta_1}{dt}\right)^2 + G_2
\end{aligned}$$

```python
import sympy as sp
theta1, theta2 = sp.symbols('theta1 theta2')
G1 = sp.simplify(m1*g*lc1*sp.cos(theta1) + m2*g*(l1*sp.cos(theta1)
     + lc2*sp.cos(theta1 + theta2)))   # = the weight
```
"""

LATEX = r"""\documentclass{article}
\newcommand{\x}{y = 3}
\begin{document}
\section{Answer} % H22 = 0
For $T_1 = \tfrac12 (m_1 l_{c1}^2 + I_1)\dot\theta_1^2$ see \eqref{eq:a}.
\begin{align}
  H_{22} &= m_2 l_{c2}^2 + I_2, \label{eq:a} \\
  H_{12} &= m_2\left(l_{c2}^2 + l_1 l_{c2}\cos\theta_2\right) \nonumber \\
         &\quad + I_2 \tag{2}
\end{align}
\[ \left\{ \begin{array}{l} G_1 = (m_1 l_{c1} + m_2 l_1) g\, c_1 + m_2 g l_{c2} c_{12} \\
 G_2 = m_2 g\, l_{c2} c_{12} \end{array} \right. \]
\begin{equation*}
\begin{cases} \dot{x} = -l_1 s_1 \dot\theta_1 - l_2 s_{12}(\dot\theta_1+\dot\theta_2) \\
 \boxed{\dot{y} = l_1 c_1 \dot\theta_1 + l_2 c_{12} (\dot\theta_1+\dot\theta_2)} \end{cases}
\end{equation*}
so $\mathbf{\tau_2} = \underbrace{H_{12}\ddot\theta_1}_{\text{inertia}} + H_{22}\ddot\theta_2
 + h\dot\theta_1^2 + G_2 \text{ with } h = m_2 l_1 l_{c2} \sin\theta_2$.
\end{document}
"""

TEXT = """Homework 3, by me

The mass matrix is as follows:
H22 = m2 lc2^2 + I2
So we get H12 = m2*(lc2^2 + l1*lc2*cos(theta2)) + I2, and therefore
for joint 2 the gravity term is G2 = m2 g lc2 c12. That was easy.
where h = m2 l1 lc2 s2
tau2 = H12 θ̈1 + H22 θ̈2
   + h (dθ1/dt)² + G2
When θ2 = 0 the arm is stretched.
"""

CODE = """import sympy as sp
m1, m2 = sp.symbols('m1 m2')
H22 = m2*lc2**2 + I2
H12 = sp.simplify(m2*(lc2**2 + l1*lc2*sp.cos(theta2)) + I2)
H12 = H12.expand()
tau2 = (H12*theta1.diff(t, 2) + H22*theta2.diff(t, 2)  # inertia
        + m2*l1*lc2*sin(theta2)*theta1.diff(t)**2 + G2)
T1 = sp.Rational(1, 2)*(m1*lc1**2 + I1)*sp.diff(theta1, t)**2
print(tau2 == 0)
"""

NOTEBOOK = json.dumps(
    {
        "cells": [
            {"cell_type": "markdown", "source": ["# A\n", "The term $G_2 = m_2 g l_{c2} c_{12}$."]},
            {"cell_type": "code", "source": CODE, "outputs": []},
            {"cell_type": "raw", "source": "H22 = 3"},
        ]
    }
)
