"""A right answer is accepted in three ways of writing it, and a wrong sign in it is found and
named."""

import freebody as fb

arm = fb.load("2R")
right = [
    "H12 = m2*(lc2^2 + l1*lc2*cos(theta2)) + I2",
    r"H_{12} = I_2 + m_2 l_{c2}^2 + m_2 l_1 l_{c2}\cos\theta_2",
    "H12 = I2 + m2*lc2*(lc2 + l1*(2*cos(theta2/2)^2 - 1))",
]
assert all(fb.check(arm, answer) for answer in right)
wrong = fb.check(arm, "H12 = m2*(lc2^2 - l1*lc2*cos(theta2)) + I2")
assert not wrong
print(wrong.findings[0].message)
