"""The inverse dynamics of a UR5e as exported C, compiled by the C compiler at hand, passes the
self-test that Python wrote."""

import shutil
import subprocess

import freebody as fb

fb.export(fb.load("ur5e"), "inverse_dynamics", language="c", out="controller")
compiler = shutil.which("cc") or shutil.which("gcc") or shutil.which("clang")
if compiler is None:
    raise SystemExit("no C compiler here")
files = ["controller/inverse_dynamics.c", "controller/inverse_dynamics_test.c"]
subprocess.run([compiler, "-O2", "-o", "selftest", *files, "-lm"], check=True)
print(subprocess.run(["./selftest"], check=True, capture_output=True, text=True).stdout.strip())
