"""Of 254 equations, formulas, examples and figures of the lecture notes 196 hold as printed; of
each of the others the command tells what is wrong and the corrected form."""

import subprocess
import sys

run = [sys.executable, "-m", "freebody", "notes"]
last = subprocess.run(run, capture_output=True, text=True, check=True).stdout.splitlines()[-1]
print(last)
assert last.startswith("254 items executed: 196 hold")
