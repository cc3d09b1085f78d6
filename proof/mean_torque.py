"""The printed example of a gear's mean torque: 150, 82, 130 and 0 N m during 0.2, 3, 0.3 and 0.2 s
at 10, 20, 10 and 0 rpm give 89 N m."""

import freebody as fb

mean = fb.mean_load([150, 82, 130, 0], [10, 20, 10, 0], [0.2, 3, 0.3, 0.2], exponent=3)
print(f"{mean:.2f} N m")
assert round(float(mean)) == 89
