"""Functions of `fb.to_jax` on arrays that lie on four devices, which JAX makes of one CPU where it
is told before it starts: so in a process of its own, `python -m support.sharded`."""

from __future__ import annotations

import os

os.environ["XLA_FLAGS"] = "--xla_force_host_platform_device_count=4"

import jax
import numpy as np
from jax.sharding import AxisType, NamedSharding, PartitionSpec

import freebody as fb

jax.config.update("jax_enable_x64", True)
model = fb.load("2R")
matrix = fb.to_jax(model, "mass_matrix")
bias = fb.to_jax(model, "bias", inputs=["m1"])
rng = np.random.default_rng(1)
AUTO = jax.make_mesh((4,), ("x",), axis_types=(AxisType.Auto,))
SQUARE = jax.make_mesh((2, 2), ("x", "y"), axis_types=(AxisType.Auto,) * 2)
EXPLICIT = jax.make_mesh((4,), ("x",), axis_types=(AxisType.Explicit,))


def lying(shape, mesh, *axes):
    """Random numbers on the devices of a mesh."""
    return jax.device_put(rng.normal(size=shape), NamedSharding(mesh, PartitionSpec(*axes)))


q = lying((8, 2), AUTO, "x")
CASES = {
    "plain": (matrix, [q], 0),
    "mapped": (jax.vmap(matrix), [q], 0),
    "two axes": (matrix, [lying((4, 8, 2), AUTO, "x")], 0),
    "jacobian": (jax.vmap(jax.jacfwd(matrix)), [q], 0),
    "gradient": (jax.grad(lambda q: matrix(q).sum()), [q], 0),
    "hessian": (jax.vmap(jax.hessian(lambda q: matrix(q).sum())), [q], 0),
    "shared numbers": (bias, [q, q, np.array([2.0])], 0),
    "numbers of each": (bias, [q, q, lying((8, 1), AUTO, "x")], 0),
    "vectors in pieces": (matrix, [lying((8, 2), SQUARE, "x", "y")], 1),
    "shard_map": (
        jax.shard_map(
            matrix, mesh=EXPLICIT, in_specs=PartitionSpec("x"), out_specs=PartitionSpec("x")
        ),
        [lying((8, 2), EXPLICIT, "x")],
        0,
    ),
}

for name, (function, arrays, gathers) in CASES.items():
    compiled = jax.jit(function).lower(*arrays).compile()
    found = compiled(*arrays)
    plain = function if name != "shard_map" else matrix
    exact = plain(*(np.asarray(x) for x in arrays))
    assert np.allclose(found, exact, rtol=1e-12, atol=1e-12), name
    assert found.sharding.spec[0] == "x", (name, found.sharding)
    assert compiled.as_text().count(" all-gather(") == gathers, name
assert matrix(q).sharding.spec[0] == "x"
try:
    matrix(lying((8, 2), EXPLICIT, "x"))
except TypeError as problem:
    print(problem)
