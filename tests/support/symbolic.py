"""Arms with symbols for some of their numbers."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np

import freebody as fb
from support.robots import loaded


def spatial_arm(seed: int, n: int) -> fb.Model:
    """A random arm by its DH table, some of its entries symbols."""
    rng = np.random.default_rng(seed)
    rows = [
        {
            "joint": str(rng.choice(["R", "R", "P"])),
            "a": f"a{i}",
            "d": 0.0 if rng.random() < 0.5 else float(rng.integers(1, 5)) / 10,
            "alpha": float(rng.choice([0.0, np.pi / 2, -np.pi / 2, 0.3])),
            "m": f"m{i}",
            "com": (f"c{i}x", float(rng.integers(-5, 5)) / 10, 0.0),
            "I": [f"I{i}xx", 0.0, 0.0, f"I{i}yy", 0.0, f"I{i}zz"],
        }
        for i in range(1, n + 1)
    ]
    return fb.dh(rows, convention=str(rng.choice(["standard", "modified"])), name=f"arm{seed}")


def coupled(model: fb.Model, **followers: tuple[str, float, float]) -> fb.Model:
    """The arm with some joints following others, each by (joint, ratio, offset)."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "arm.toml"
        fb.save(model, path)
        text = path.read_text(encoding="utf-8")
    for name, (leader, ratio, offset) in followers.items():
        head = f'[[joint]]\nname = "{name}"\n'
        assert head in text
        mimic = f'mimic = {{ joint = "{leader}", ratio = {ratio!r}, offset = {offset!r} }}\n'
        text = text.replace(head, head + mimic)
    return loaded(text)


def with_values(model: fb.Model) -> fb.Model:
    """Numbers for all parameters that have none; inertias between a half and one are physical."""
    rng = np.random.default_rng(3)
    return model.bind(**{name: rng.uniform(0.5, 1.0) for name in model.missing})
