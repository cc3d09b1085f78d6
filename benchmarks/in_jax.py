"""What JAX adds to a kernel: inverse dynamics and its derivatives of 4096 samples, inside
`jax.jit`.

Nanoseconds a sample, one thread, least of rounds that take turns, so that what else the machine
does counts little; ratios of these; and seconds of CPU time from a new function to its first
result, with the disk cache off. Needs JAX.
"""

import os
import time

os.environ["FREEBODY_CACHE"] = "off"
os.environ.setdefault("XLA_FLAGS", "--xla_cpu_multi_thread_eigen=false")

import jax
import jax.numpy as jnp
import numpy as np

import freebody as fb
from common import quickest

BATCH, ROUNDS = 4096, 60


def first(made, *arrays) -> tuple:
    """A function that waits for its result, and the CPU time until its first one."""
    start = time.process_time()
    function = jax.jit(made())
    jax.block_until_ready(function(*arrays))
    return lambda: jax.block_until_ready(function(*arrays)), time.process_time() - start


def robot(name: str) -> list[tuple]:
    """Rows: what, nanoseconds, over the kernel's own, seconds to the first result."""
    model = fb.load(name)
    arrays = list(np.random.default_rng(0).normal(size=(3, BATCH, model.nv)))
    given = [jnp.asarray(x) for x in arrays]

    def function():
        return fb.to_jax(model, "inverse_dynamics")

    def loss():
        inverse = function()
        return jax.grad(lambda *x: jnp.sum(inverse(*x) ** 2), (0, 1, 2))

    ways = {
        "inverse dynamics": ("inverse_dynamics", (), lambda: jax.vmap(function())),
        "jacfwd by q": ("inverse_dynamics", "q", lambda: jax.vmap(jax.jacfwd(function()))),
        "jacrev by q": ("inverse_dynamics", "q", lambda: jax.vmap(jax.jacrev(function()))),
        "all three as a kernel": (
            "inverse_dynamics_derivatives",
            (),
            lambda: jax.vmap(fb.to_jax(model, "inverse_dynamics_derivatives")),
        ),
        "gradient of a loss": ("inverse_dynamics_derivatives", (), loss),
    }
    runs, seconds = {}, {}
    for way, (_, _, made) in ways.items():  # first those of JAX, so that nothing is compiled before
        runs[way], seconds[way] = first(made, *given)
    for way, (quantity, by, _) in ways.items():
        kernel = fb.kernel(model, quantity, by=by)
        runs[f"kernel: {way}"] = lambda kernel=kernel: kernel(*arrays, threads=1)
    best = quickest(runs, ROUNDS)
    return [
        (way, best[way] / BATCH * 1e9, best[way] / best[f"kernel: {way}"], seconds[way])
        for way in ways
    ]


def main() -> None:
    """A table for each robot."""
    jax.config.update("jax_enable_x64", True)
    for name in ("ur5e", "panda"):
        print(f"\n{name:28}{'ns':>8}{'/ kernel':>10}{'first, s':>10}")
        for way, time_, ratio, seconds in robot(name):
            print(f"{way:28}{time_:8.1f}{ratio:10.2f}{seconds:10.2f}")


if __name__ == "__main__":
    main()
