# ruff: noqa: E501 - a formula is a line
"""Results as books and students have them, robot by robot, in short Python text."""

TWO = """
H11 = m1*lc1**2 + m2*(l1**2 + lc2**2 + 2*l1*lc2*cos(th2)) + I1 + I2
H11 = I1 + I2 + m1*lc1**2 + m2*l1**2 + m2*lc2**2 + 2*m2*l1*lc2*cos(th2)
H12 = m2*(lc2**2 + l1*lc2*cos(th2)) + I2
H21 = I2 + m2*lc2*(lc2 + l1*cos(th2))
H22 = m2*lc2**2 + I2
[[H11, H12], [H21, H22]] = [[I1 + I2 + m1*lc1**2 + m2*(l1**2 + lc2**2 + 2*l1*lc2*cos(th2)), I2 + m2*(lc2**2 + l1*lc2*cos(th2))], [I2 + m2*(lc2**2 + l1*lc2*cos(th2)), I2 + m2*lc2**2]]
c1 = -m2*l1*lc2*sin(th2)*(2*th1_d*th2_d + th2_d**2)
c1 = -2*m2*l1*lc2*sin(th2)*th1_d*th2_d - m2*l1*lc2*sin(th2)*th2_d**2
c1 = -m2*l1*lc2*sin(th2)*th2_d*(2*th1_d + th2_d)
c2 = m2*l1*lc2*sin(th2)*th1_d**2
G1 = (m1*lc1 + m2*l1)*g*cos(th1) + m2*lc2*g*cos(th1 + th2)
G2 = m2*lc2*g*cos(th1 + th2)
T = 1/2*m1*lc1**2*th1_d**2 + 1/2*I1*th1_d**2 + 1/2*m2*(l1**2*th1_d**2 + lc2**2*(th1_d + th2_d)**2 + 2*l1*lc2*cos(th2)*th1_d*(th1_d + th2_d)) + 1/2*I2*(th1_d + th2_d)**2
T1 = 1/2*m1*lc1**2*th1_d**2 + 1/2*I1*th1_d**2
T1 = 1/2*(m1*lc1**2 + I1)*th1_d**2
V = m1*g*lc1*sin(th1) + m2*g*(l1*sin(th1) + lc2*sin(th1 + th2))
V2 = m2*g*(l1*sin(th1) + lc2*sin(th1 + th2))
x = l1*cos(th1) + l2*cos(th1 + th2)
y = l1*sin(th1) + l2*sin(th1 + th2)
x_d = -l1*sin(th1)*th1_d - l2*sin(th1 + th2)*(th1_d + th2_d)
y_d = l1*cos(th1)*th1_d + l2*cos(th1 + th2)*(th1_d + th2_d)
x_dd = -(l1*sin(th1) + l2*sin(th1 + th2))*th1_dd - l2*sin(th1 + th2)*th2_dd - l1*cos(th1)*th1_d**2 - l2*cos(th1 + th2)*(th1_d + th2_d)**2
[[J11, J12], [J21, J22]] = [[-l1*sin(th1) - l2*sin(th1 + th2), -l2*sin(th1 + th2)], [l1*cos(th1) + l2*cos(th1 + th2), l2*cos(th1 + th2)]]
detJ = l1*l2*sin(th2)
J11*J22 - J12*J21 = l1*l2*sin(th2)
x**2 + y**2 = l1**2 + l2**2 + 2*l1*l2*cos(th2)
cos(th2) = (x**2 + y**2 - l1**2 - l2**2)/(2*l1*l2)
th2 = acos((x**2 + y**2 - l1**2 - l2**2)/(2*l1*l2))
th1 = atan2(y, x) - atan2(l2*sin(th2), l1 + l2*cos(th2))
th1 = atan2((l1 + l2*cos(th2))*y - l2*sin(th2)*x, (l1 + l2*cos(th2))*x + l2*sin(th2)*y)
th2 = 2*atan(sqrt(((l1 + l2)**2 - (x**2 + y**2))/((x**2 + y**2) - (l1 - l2)**2)))
vc2x = -l1*th1_d*sin(th1) - lc2*(th1_d + th2_d)*sin(th1 + th2)
vc2x**2 + vc2y**2 = l1**2*th1_d**2 + lc2**2*(th1_d + th2_d)**2 + 2*l1*lc2*th1_d*(th1_d + th2_d)*cos(th2)
ac1x = -lc1*sin(th1)*th1_dd - lc1*cos(th1)*th1_d**2
ac2y = l1*cos(th1)*th1_dd - l1*sin(th1)*th1_d**2 + lc2*cos(th1 + th2)*(th1_dd + th2_dd) - lc2*sin(th1 + th2)*(th1_d + th2_d)**2
omega2 = th1_d + th2_d
p2 = m2*lc2**2*(th1_d + th2_d) + m2*l1*lc2*cos(th2)*th1_d + I2*(th1_d + th2_d)
H11*H22 - H12**2 = (m1*lc1**2 + I1)*(m2*lc2**2 + I2) + m2*l1**2*(m2*lc2**2*sin(th2)**2 + I2)
H11_d = -2*m2*l1*lc2*sin(th2)*th2_d
H12_d = -m2*l1*lc2*sin(th2)*th2_d
"""
TWO_DRIVEN = """
tau1 = m2*lc2**2*(th1_dd + th2_dd) + m2*l1*lc2*cos(th2)*(2*th1_dd + th2_dd) + (m1*lc1**2 + m2*l1**2)*th1_dd + I1*th1_dd + I2*(th1_dd + th2_dd) - m2*l1*lc2*sin(th2)*th2_d**2 - 2*m2*l1*lc2*sin(th2)*th1_d*th2_d + m2*lc2*g*cos(th1 + th2) + (m1*lc1 + m2*l1)*g*cos(th1)
tau2 = m2*l1*lc2*cos(th2)*th1_dd + m2*l1*lc2*sin(th2)*th1_d**2 + m2*lc2*g*cos(th1 + th2) + m2*lc2**2*(th1_dd + th2_dd) + I2*(th1_dd + th2_dd)
tau2 = (m2*lc2**2 + I2)*(th1_dd + th2_dd) + m2*lc2*(l1*cos(th2)*th1_dd + l1*sin(th2)*th1_d**2 + g*cos(th1 + th2))
th2_dd = (H11*(tau2 - c2 - G2) - H12*(tau1 - c1 - G1))/(H11*H22 - H12**2)
th1_dd = (H22*(tau1 - c1 - G1) - H12*(tau2 - c2 - G2))/(H11*H22 - H12**2)
tau1 - tau2 = I1*th1_dd + m1*lc1*(g*cos(th1) + lc1*th1_dd) + l1*(f12y*cos(th1) - f12x*sin(th1))
f12x = m2*ac2x
f12y = m2*(ac2y + g)
f01x = m1*ac1x + m2*ac2x
"""
PRINTED: dict[str, str] = {
    "pendulum": """
tau1 = (m1*lc1**2 + I1)*th1_dd + m1*g*lc1*cos(th1)
th1_dd = (tau1 - m1*g*lc1*cos(th1))/(I1 + m1*lc1**2)
T = 1/2*(I1 + m1*lc1**2)*th1_d**2
V = m1*g*lc1*sin(th1)
H11 = I1 + m1*lc1**2
E = 1/2*(I1 + m1*lc1**2)*th1_d**2 + m1*g*lc1*sin(th1)
f01x = -m1*lc1*(sin(th1)*th1_dd + cos(th1)*th1_d**2)
f01y = m1*g + m1*lc1*(cos(th1)*th1_dd - sin(th1)*th1_d**2)
tau1*th1_d = T_d + V_d
T_d = (I1 + m1*lc1**2)*th1_d*th1_dd
V_d = m1*g*lc1*cos(th1)*th1_d
x = l1*cos(th1)
y_d = l1*cos(th1)*th1_d
x_dd = -l1*sin(th1)*th1_dd - l1*cos(th1)*th1_d**2
th1 = atan2(y, x)
x**2 + y**2 = l1**2
""",
    "2R": TWO + TWO_DRIVEN,
    "acrobot": TWO
    + """
0 = (I1 + I2 + m1*lc1**2 + m2*(l1**2 + lc2**2 + 2*l1*lc2*cos(th2)))*th1_dd + (I2 + m2*(lc2**2 + l1*lc2*cos(th2)))*th2_dd - m2*l1*lc2*sin(th2)*(2*th1_d*th2_d + th2_d**2) + (m1*lc1 + m2*l1)*g*cos(th1) + m2*lc2*g*cos(th1 + th2)
th1_dd = -(H12*th2_dd + c1 + G1)/H11
tau2 = (H22 - H12**2/H11)*th2_dd + c2 + G2 - H12/H11*(c1 + G1)
E_d = tau2*th2_d
T_d + V_d = tau2*th2_d
th2_dd = (H11*(tau2 - c2 - G2) + H12*(c1 + G1))/(H11*H22 - H12**2)
""",
    "pendubot": TWO
    + """
th2_dd = -(H12*th1_dd + c2 + G2)/H22
tau1 = (H11 - H12**2/H22)*th1_dd + c1 + G1 - H12/H22*(c2 + G2)
E_d = tau1*th1_d
th1_dd = (H22*(tau1 - c1 - G1) + H12*(c2 + G2))/(H11*H22 - H12**2)
""",
    "3R": """
x = l1*cos(th1) + l2*cos(th1 + th2) + l3*cos(th1 + th2 + th3)
y = l1*sin(th1) + l2*sin(th1 + th2) + l3*sin(th1 + th2 + th3)
H33 = I3 + m3*lc3**2
H23 = I3 + m3*(lc3**2 + l2*lc3*cos(th3))
H13 = I3 + m3*(lc3**2 + l2*lc3*cos(th3) + l1*lc3*cos(th2 + th3))
H22 = I2 + I3 + m2*lc2**2 + m3*(l2**2 + lc3**2 + 2*l2*lc3*cos(th3))
G3 = m3*g*lc3*cos(th1 + th2 + th3)
G2 = (m2*lc2 + m3*l2)*g*cos(th1 + th2) + m3*g*lc3*cos(th1 + th2 + th3)
G1 = (m1*lc1 + m2*l1 + m3*l1)*g*cos(th1) + (m2*lc2 + m3*l2)*g*cos(th1 + th2) + m3*g*lc3*cos(th1 + th2 + th3)
omega3 = th1_d + th2_d + th3_d
omega3_d = th1_dd + th2_dd + th3_dd
J13 = -l3*sin(th1 + th2 + th3)
J11 = -l1*sin(th1) - l2*sin(th1 + th2) - l3*sin(th1 + th2 + th3)
c3 = m3*lc3*(l1*sin(th2 + th3)*th1_d**2 + l2*sin(th3)*(th1_d + th2_d)**2)
V = m1*g*lc1*sin(th1) + m2*g*(l1*sin(th1) + lc2*sin(th1 + th2)) + m3*g*(l1*sin(th1) + l2*sin(th1 + th2) + lc3*sin(th1 + th2 + th3))
f23x = m3*ac3x
f12x = m2*ac2x + m3*ac3x
f01y = m1*ac1y + m2*ac2y + m3*ac3y + (m1 + m2 + m3)*g
tau3 = I3*(th1_dd + th2_dd + th3_dd) + lc3*(f23y*cos(th1 + th2 + th3) - f23x*sin(th1 + th2 + th3))
""",
    "RP": """
x = (d2 + l2)*cos(th1)
y = (d2 + l2)*sin(th1)
H11 = m1*lc1**2 + I1 + I2 + m2*(d2 + lc2)**2
H22 = m2
tau1 = (m1*lc1**2 + I1 + I2 + m2*(d2 + lc2)**2)*th1_dd + 2*m2*(d2 + lc2)*th1_d*d2_d + (m1*lc1 + m2*(d2 + lc2))*g*cos(th1)
tau2 = m2*d2_dd - m2*(d2 + lc2)*th1_d**2 + m2*g*sin(th1)
T2 = 1/2*m2*(d2_d**2 + (d2 + lc2)**2*th1_d**2) + 1/2*I2*th1_d**2
V = m1*g*lc1*sin(th1) + m2*g*(d2 + lc2)*sin(th1)
detJ = -(d2 + l2)
d2_dd = tau2/m2 + (d2 + lc2)*th1_d**2 - g*sin(th1)
th1 = atan2(y, x)
d2 = sqrt(x**2 + y**2) - l2
x_d = cos(th1)*d2_d - (d2 + l2)*sin(th1)*th1_d
""",
    "cart_pole": """
tau1 = (m1 + m2)*x_dd + m2*l2*th2_dd*cos(th2) - m2*l2*th2_d**2*sin(th2)
0 = m2*l2*x_dd*cos(th2) + m2*l2**2*th2_dd + m2*g*l2*sin(th2)
x_dd*cos(th2) + l2*th2_dd + g*sin(th2) = 0
l2*th2_dd = -x_dd*cos(th2) - g*sin(th2)
x_dd = (tau1 + m2*sin(th2)*(l2*th2_d**2 + g*cos(th2)))/(m1 + m2*sin(th2)**2)
th2_dd = (-tau1*cos(th2) - m2*l2*th2_d**2*cos(th2)*sin(th2) - (m1 + m2)*g*sin(th2))/(l2*(m1 + m2*sin(th2)**2))
T = 1/2*(m1 + m2)*x_d**2 + m2*x_d*th2_d*l2*cos(th2) + 1/2*m2*l2**2*th2_d**2
V = -m2*g*l2*cos(th2)
E_d = tau1*x_d
H12 = m2*l2*cos(th2)
p1 = (m1 + m2)*x_d + m2*l2*cos(th2)*th2_d
vc2x**2 + vc2y**2 = x_d**2 + 2*l2*x_d*th2_d*cos(th2) + l2**2*th2_d**2
""",
    "reaction_wheel": """
0 = (m1*lc1**2 + m2*l1**2 + I1 + I2)*th1_dd + I2*th2_dd - (m1*lc1 + m2*l1)*g*sin(th1)
tau2 = I2*(th1_dd + th2_dd)
(m1*lc1**2 + m2*l1**2 + I1)*th1_dd = (m1*lc1 + m2*l1)*g*sin(th1) - tau2
th1_dd = ((m1*lc1 + m2*l1)*g*sin(th1) - tau2)/(m1*lc1**2 + m2*l1**2 + I1)
V = (m1*lc1 + m2*l1)*g*cos(th1)
T = 1/2*(m1*lc1**2 + m2*l1**2 + I1)*th1_d**2 + 1/2*I2*(th1_d + th2_d)**2
E_d = tau2*th2_d
p2 = I2*(th1_d + th2_d)
""",
    "ball_and_beam": """
0 = (m2 + J2)*d2_dd - m2*r*th1_dd - m2*d2*th1_d**2 + m2*g*sin(th1)
tau1 = (I1 + m2*(d2**2 + r**2))*th1_dd - m2*r*d2_dd + 2*m2*d2*d2_d*th1_d + m2*g*(d2*cos(th1) - r*sin(th1))
d2_dd = (m2*r*th1_dd + m2*d2*th1_d**2 - m2*g*sin(th1))/(m2 + J2)
V = m2*g*(d2*sin(th1) + r*cos(th1))
H11 = I1 + m2*d2**2 + m2*r**2
T2 = 1/2*m2*((d2_d - r*th1_d)**2 + d2**2*th1_d**2)
""",
    "cylindrical_arm": """
tau2 = (m2 + m3)*(d2_dd + g)
tau3 = m3*(d3_dd - (d3 - lc3)*th1_d**2)
tau1 = (I1 + I3 + m3*(d3 - lc3)**2)*th1_dd + 2*m3*(d3 - lc3)*th1_d*d3_d
x = d3*cos(th1)
z = d2
th1 = atan2(y, x)
d3 = sqrt(x**2 + y**2)
detJ = d3
T = 1/2*(I1 + I3 + m3*(d3 - lc3)**2)*th1_d**2 + 1/2*(m2 + m3)*d2_d**2 + 1/2*m3*d3_d**2
V = (m2 + m3)*g*d2
""",
    "polar_arm": """
H11 = I1 + (I2 + I3 + m3*(d3 - lc3)**2)*cos(th2)**2
H22 = I2 + I3 + m3*(d3 - lc3)**2
G2 = m3*g*(d3 - lc3)*cos(th2)
G3 = m3*g*sin(th2)
tau3 = m3*d3_dd - m3*(d3 - lc3)*(th2_d**2 + cos(th2)**2*th1_d**2) + m3*g*sin(th2)
x = d3*cos(th1)*cos(th2)
z = l1 + d3*sin(th2)
d3 = sqrt(x**2 + y**2 + (z - l1)**2)
th1 = atan2(y, x)
th2 = atan2(z - l1, sqrt(x**2 + y**2))
V3 = m3*g*(l1 + (d3 - lc3)*sin(th2))
""",
    "elbow_arm": """
x = cos(th1)*(l2*cos(th2) + l3*cos(th2 + th3))
y = sin(th1)*(l2*cos(th2) + l3*cos(th2 + th3))
z = l1 + l2*sin(th2) + l3*sin(th2 + th3)
th1 = atan2(y, x)
th3 = acos((x**2 + y**2 + (z - l1)**2 - l2**2 - l3**2)/(2*l2*l3))
G2 = (m2*lc2 + m3*l2)*g*cos(th2) + m3*lc3*g*cos(th2 + th3)
G3 = m3*g*lc3*cos(th2 + th3)
H33 = I3 + m3*lc3**2
H23 = I3 + m3*(lc3**2 + l2*lc3*cos(th3))
H11 = I1 + (I2 + m2*lc2**2)*cos(th2)**2 + I3*cos(th2 + th3)**2 + m3*(l2*cos(th2) + lc3*cos(th2 + th3))**2
detJ = -l2*l3*sin(th3)*(l2*cos(th2) + l3*cos(th2 + th3))
""",
    "furuta": """
tau1 = (I1 + m1*lc1**2 + m2*l1**2 + (I2 + m2*lc2**2)*sin(th2)**2)*th1_dd - m2*l1*lc2*cos(th2)*th2_dd + (I2 + m2*lc2**2)*sin(2*th2)*th1_d*th2_d + m2*l1*lc2*sin(th2)*th2_d**2
0 = -m2*l1*lc2*cos(th2)*th1_dd + (I2 + m2*lc2**2)*th2_dd - (I2 + m2*lc2**2)*sin(th2)*cos(th2)*th1_d**2 - m2*g*lc2*sin(th2)
V = m2*g*lc2*cos(th2)
H22 = I2 + m2*lc2**2
E_d = tau1*th1_d
""",
    "gantry_crane": """
tau1 = (m1 + m2 + m)*x_dd + m*l*cos(th4)*th4_dd - m*l*sin(th4)*th4_d**2
0 = x_dd*cos(th4) - y_dd*sin(th3)*sin(th4) + l*th4_dd + l*sin(th4)*cos(th4)*th3_d**2 + g*cos(th3)*sin(th4)
0 = y_dd*cos(th3) + l*cos(th4)*th3_dd - 2*l*sin(th4)*th3_d*th4_d + g*sin(th3)
V = -m*g*l*cos(th3)*cos(th4)
E_d = tau1*x_d + tau2*y_d
""",
    "scara": """
x = 0.425*cos(th1) + 0.375*cos(th1 + th2)
y = 0.425*sin(th1) + 0.375*sin(th1 + th2)
z = 0.677 - d3
G3 = -2.5*g
H33 = 2.5
tau3 = 2.5*(d3_dd - g)
x**2 + y**2 = 0.425**2 + 0.375**2 + 2*0.425*0.375*cos(th2)
th1 = atan2(y, x) - atan2(0.375*sin(th2), 0.425 + 0.375*cos(th2))
d3 = 0.677 - z
""",
    "gyro": """
tau1 = 5*th1_dd
tau2 = 10*th2_dd
H11 = 5
H22 = 10
T = 1/2*(5*th1_d**2 + 10*th2_d**2)
""",
    "slider_crank": """
d3 = l1*cos(th1) + sqrt(l2**2 - l1**2*sin(th1)**2)
d3 = l1*cos(th1) + l2*sqrt(1 - (l1/l2)**2*sin(th1)**2)
d3 = l1*cos(th1) + l2*cos(asin(l1/l2*sin(th1)))
th2 = -th1 - asin(l1*sin(th1)/l2)
sin(th1 + th2) = -l1/l2*sin(th1)
l1*sin(th1) + l2*sin(th1 + th2) = 0
d3 = l1*cos(th1) + l2*cos(th1 + th2)
d3**2 - 2*l1*d3*cos(th1) + l1**2 - l2**2 = 0
l2**2 = d3**2 + l1**2 - 2*d3*l1*cos(th1)
d3_d = -l1*th1_d*(sin(th1) + l1*sin(2*th1)/(2*sqrt(l2**2 - l1**2*sin(th1)**2)))
d3_d = -l1*th1_d*(sin(th1) - cos(th1)*tan(th1 + th2))
d3_d = l1*th1_d*sin(th2)/cos(th1 + th2)
d3_d = -l1*th1_d*d3*sin(th1)/(d3 - l1*cos(th1))
omega2 = -l1*th1_d*cos(th1)/(l2*cos(th1 + th2))
th1_d + th2_d = -l1*cos(th1)*th1_d/sqrt(l2**2 - l1**2*sin(th1)**2)
d3_d = -l1*th1_d*sin(th1) - l2*omega2*sin(th1 + th2)
d3_dd = -l1*th1_dd*sin(th1) - l1*th1_d**2*cos(th1) - l2*omega2_d*sin(th1 + th2) - l2*omega2**2*cos(th1 + th2)
omega2_d = (l1*th1_d**2*sin(th1) - l1*th1_dd*cos(th1) + l2*omega2**2*sin(th1 + th2))/(l2*cos(th1 + th2))
T3 = 1/2*m3*d3_d**2
T1 = 1/2*(I1 + m1*lc1**2)*th1_d**2
T2 = 1/2*m2*(l1**2*th1_d**2 + lc2**2*omega2**2 + 2*l1*lc2*th1_d*omega2*cos(th2)) + 1/2*I2*omega2**2
V = m1*g*lc1*sin(th1) + m2*g*(l1 - lc2*l1/l2)*sin(th1)
V2 = m2*g*l1*(1 - lc2/l2)*sin(th1)
tau1*th1_d = T_d + V_d
yc2 = (1 - lc2/l2)*l1*sin(th1)
xc2 = l1*cos(th1) + lc2*sqrt(1 - l1**2*sin(th1)**2/l2**2)
m3*d3_dd = lam1
""",
    "four_bar": """
l1*cos(th1) + l2*cos(th1 + th2) = d + l3*cos(th3)
l1*sin(th1) + l2*sin(th1 + th2) = l3*sin(th3)
d/l1*cos(th3) - d/l3*cos(th1) + (l1**2 - l2**2 + l3**2 + d**2)/(2*l1*l3) = cos(th1 - th3)
l2**2 = (d + l3*cos(th3) - l1*cos(th1))**2 + (l3*sin(th3) - l1*sin(th1))**2
l1**2 + l3**2 + d**2 - l2**2 + 2*d*l3*cos(th3) - 2*d*l1*cos(th1) - 2*l1*l3*cos(th1 - th3) = 0
cos(th1 + th2 - th3) = -(d**2 + l1**2 - 2*d*l1*cos(th1) - l2**2 - l3**2)/(2*l2*l3)
th3_d = l1*th1_d*sin(th2)/(l3*sin(th1 + th2 - th3))
th3_d = l1*sin(th1 - (th1 + th2))/(l3*sin(th3 - (th1 + th2)))*th1_d
omega2 = l1*th1_d*sin(th3 - th1)/(l2*sin(th1 + th2 - th3))
omega3/omega2 = l2*sin(th2)/(l3*sin(th3 - th1))
th2_d = -th1_d + l1*th1_d*sin(th3 - th1)/(l2*sin(th1 + th2 - th3))
l1*th1_d*sin(th1) + l2*omega2*sin(th1 + th2) = l3*omega3*sin(th3)
-l1*th1_dd*sin(th1) - l1*th1_d**2*cos(th1) - l2*omega2_d*sin(th1 + th2) - l2*omega2**2*cos(th1 + th2) + l3*omega3_d*sin(th3) + l3*omega3**2*cos(th3) = 0
omega3_d = (l1*th1_dd*sin(th2) - l1*th1_d**2*cos(th2) - l2*omega2**2 + l3*omega3**2*cos(th1 + th2 - th3))/(l3*sin(th1 + th2 - th3))
T3 = 1/2*(I3 + m3*lc3**2)*th3_d**2
T1 + T3 = 1/2*(I1 + m1*lc1**2)*th1_d**2 + 1/2*(I3 + m3*lc3**2)*omega3**2
T2 = 1/2*m2*(l1**2*th1_d**2 + lc2**2*omega2**2 + 2*l1*lc2*th1_d*omega2*cos(th2)) + 1/2*I2*omega2**2
V = m1*g*lc1*sin(th1) + m2*g*(l1*sin(th1) + lc2*sin(th1 + th2)) + m3*g*lc3*sin(th3)
V = m1*g*lc1*sin(th1) + m2*g*(l1*sin(th1) + lc2/l2*(l3*sin(th3) - l1*sin(th1))) + m3*g*lc3*sin(th3)
tau1*th1_d = T_d + V_d
tau1*omega1 = T_d + V_d
x = l1*cos(th1) + l2*cos(th1 + th2)
x = d + l3*cos(th3)
y = l3*sin(th3)
x_d = -l3*sin(th3)*th3_d
y_d = l3*omega3*cos(th3)
th3 = atan2(l1*sin(th1) + l2*sin(th1 + th2), l1*cos(th1) + l2*cos(th1 + th2) - d)
""",
    "five_bar": """
x = -b + l1*cos(th1) + l3*cos(th1 + th3)
x = b + l2*cos(th2) + l4*cos(th2 + th4)
y = l2*sin(th2) + l4*sin(th2 + th4)
(x + b - l1*cos(th1))**2 + (y - l1*sin(th1))**2 = l3**2
(x - b - l2*cos(th2))**2 + (y - l2*sin(th2))**2 = l4**2
(x + b - l1*cos(th1))*x_d + (y - l1*sin(th1))*y_d = l1*th1_d*(y*cos(th1) - (x + b)*sin(th1))
th1_d + th3_d = (-l1*th1_d*sin(th2 + th4 - th1) + l2*th2_d*sin(th4))/(l3*sin(th2 + th4 - th1 - th3))
omega3 = (l1*th1_d*sin(th1 - th2 - th4) + l2*th2_d*sin(th4))/(l3*sin(th2 + th4 - th1 - th3))
l3*sin(th3)*th3_d = -((x + b)*x_d + y*y_d)/l1
(x + b)**2 + y**2 = l1**2 + l3**2 + 2*l1*l3*cos(th3)
tau1*th1_d + tau2*th2_d = T_d + V_d
cos(th3) = ((x + b)**2 + y**2 - l1**2 - l3**2)/(2*l1*l3)
x_d*cos(th1 + th3) + y_d*sin(th1 + th3) = l1*sin(th3)*th1_d
x_d*cos(th2 + th4) + y_d*sin(th2 + th4) = l2*sin(th4)*th2_d
T2 = 1/2*(I2 + m2*lc2**2)*th2_d**2
V2 = m2*g*lc2*sin(th2)
""",
    "five_bar_rods": """
(x + b - l1*cos(th1))**2 + (y - l1*sin(th1))**2 = l3**2
(x - b - l2*cos(th2))**2 + (y - l2*sin(th2))**2 - l4**2 = 0
(x + b - l1*cos(th1))*(x_d + l1*sin(th1)*th1_d) + (y - l1*sin(th1))*(y_d - l1*cos(th1)*th1_d) = 0
x**2 + y**2 + b**2 + l1**2 - l3**2 + 2*b*x - 2*l1*(x + b)*cos(th1) - 2*l1*y*sin(th1) = 0
tau1*th1_d + tau2*th2_d = T_d + V_d
T = 1/2*(I1 + m1*lc1**2)*th1_d**2 + 1/2*(I2 + m2*lc2**2)*th2_d**2 + 1/2*m3*(x_d**2 + y_d**2)
V = m1*g*lc1*sin(th1) + m2*g*lc2*sin(th2) + m3*g*y
m3*x_dd + 2*(x + b - l1*cos(th1))*lam1 + 2*(x - b - l2*cos(th2))*lam2 = 0
m3*(y_dd + g) + 2*(y - l1*sin(th1))*lam1 + 2*(y - l2*sin(th2))*lam2 = 0
""",
    "double_four_bar": """
cos(th1) + cos(th1 + th2) = 1 + cos(th3)
sin(th1) + sin(th1 + th2) = sin(th3)
th1_d*sin(th1) + (th1_d + th2_d)*sin(th1 + th2) = th3_d*sin(th3)
th3_d*cos(th3) + (th3_d + th4_d)*cos(th3 + th4) - th5_d*cos(th5) = 0
th1_d = th3_d
th3 = th1
th2 = -th1
omega2 = 0
omega5 = th1_d
V = 7/2*g*sin(th1)
""",
    "3RRR": """
0.15*sin(th3) - x + 0.3*cos(th8) + 0.35*cos(th8 + th9) = 0
y = 0.5 + 0.3*sin(th8) + 0.35*sin(th8 + th9) - 0.15*cos(th3)
(x - 0.15*sin(th3) - 0.3*cos(th8))**2 + (y + 0.15*cos(th3) - 0.5 - 0.3*sin(th8))**2 = 0.35**2
x_d = 0.15*cos(th3)*th3_d - 0.3*th8_d*sin(th8) - 0.35*(th8_d + th9_d)*sin(th8 + th9)
y_d + 0.15*th3_d*(-sin(th3)) = 0.3*th8_d*cos(th8) + 0.35*(th8_d + th9_d)*cos(th8 + th9)
omega9 = th8_d + th9_d
""",
}


def printed(robot: str) -> list[str]:
    """The robot's results, one text each."""
    return [x for x in PRINTED.get(robot, "").splitlines() if x]
