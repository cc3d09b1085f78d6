"""What PyTorch adds to a kernel: one call, a batch of 4096, and the gradient beside the kernels
that it is made by.

Microseconds, one thread, least of rounds that take turns, so that what else the machine does counts
little. The gradient is that by q, qd and qdd (tau) at once; `derivatives` is the kernel of all
three matrices, for comparison.
"""

import numpy as np
import torch

import freebody as fb
from common import quickest
from freebody.program.derivative import gradient
from freebody.targets import compile_program

BATCH, ROUNDS = 4096, 60


def line(model: fb.Model, quantity: str) -> dict:
    """Microseconds of the runs of one robot and quantity."""
    f, k = fb.to_torch(model, quantity), fb.kernel(model, quantity)
    slopes = fb.kernel(model, f"{quantity}_derivatives")
    rng = np.random.default_rng(0)
    arrays = list(rng.normal(size=(3, BATCH, model.nv)))
    tensors = [torch.from_numpy(x) for x in arrays]
    free = [x.clone().requires_grad_() for x in tensors]
    ones = [x[0] for x in tensors]
    single = [x[0].clone().requires_grad_() for x in tensors]
    first = [x[0].copy() for x in arrays]
    made = f(*free)
    weight = torch.ones_like(made)
    own = compile_program(gradient(f.program, (0, 1, 2), (0,)))
    one = f(*single)
    calls = {
        "kernel, one call": lambda: k(*first),
        "torch, one call": lambda: f(*ones),
        "torch, one call that is recorded": lambda: f(*single),
        "its gradient": lambda: torch.autograd.grad(one, single, weight[0], retain_graph=True),
    }
    batches = {
        "kernel, 4096": lambda: k(*arrays, threads=1),
        "torch, 4096": lambda: f(*tensors),
        "kernel of the gradient, 4096": lambda: own(*arrays, weight.numpy(), threads=1),
        "gradient, 4096": lambda: torch.autograd.grad(made, free, weight, retain_graph=True),
        "kernel of derivatives, 4096": lambda: slopes(*arrays, threads=1),
    }
    found = quickest(calls, ROUNDS, 100) | quickest(batches, ROUNDS)
    return {name: 1e6 * time for name, time in found.items()}


def main() -> None:
    """A column for each robot and quantity."""
    torch.set_num_threads(1)
    cases = [
        (name, q) for name in ("ur5e", "panda") for q in ("inverse_dynamics", "forward_dynamics")
    ]
    columns = [line(fb.load(name), quantity) for name, quantity in cases]
    print(f"{'':36}", *(f"{name + ' ' + quantity.split('_')[0]:>16}" for name, quantity in cases))
    for key in columns[0]:
        print(f"{key:36}", *(f"{column[key]:16.2f}" for column in columns))


if __name__ == "__main__":
    main()
