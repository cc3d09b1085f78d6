"""Programs as source text of other languages."""

from __future__ import annotations

from freebody.targets.text.c import CPP, C
from freebody.targets.text.cuda import CUDA
from freebody.targets.text.javascript import MODULE, SCRIPT
from freebody.targets.text.julia import JULIA
from freebody.targets.text.language import Joints, Language, SelfTestSamples, SourceUnit
from freebody.targets.text.matlab import MATLAB
from freebody.targets.text.python import CASADI, JAX, NUMPY
from freebody.targets.text.rust import RUST

__all__ = ["LANGUAGES", "Joints", "Language", "SelfTestSamples", "SourceUnit"]

LANGUAGES: dict[str, Language] = {
    "c": C,
    "cpp": CPP,
    "javascript": MODULE,
    "javascript-script": SCRIPT,
    "rust": RUST,
    "julia": JULIA,
    "matlab": MATLAB,
    "numpy": NUMPY,
    "jax": JAX,
    "casadi": CASADI,
    "cuda": CUDA,
}
"""Languages by name. A further one is a file and a line here."""
