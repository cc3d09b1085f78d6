"""The languages of source text, and what runs each."""

import sys

TOOL = {
    "c": "cc", "cpp": "c++", "javascript": "node", "javascript-script": "node", "rust": "rustc",
    "julia": "julia",
    "matlab": "octave", "cuda": "nvidia-smi", "numpy": sys.executable, "jax": sys.executable,
    "casadi": sys.executable,
}  # fmt: skip
