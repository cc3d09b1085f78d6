"""Two threads on one batch beside two independent processes, each with one thread and a batch of
its own."""

import multiprocessing
import time
from multiprocessing.connection import Connection

import numpy as np

import freebody as fb

TASKS = ("inverse_dynamics", "forward_dynamics")
SECONDS = 0.4  # that one figure is measured for


def call(path: str, tip: str, task: str, batch: int, threads: int):
    """A function that puts one batch through the kernel."""
    model = fb.load(path, mimic="free", tip=tip).without("friction")
    kernel = fb.kernel(model, task)
    state = fb.random_state(model, 0, batch)
    out = np.empty((batch, model.nv))
    return lambda: kernel(*state, out=out, threads=threads)


def rate(run, batch: int) -> float:
    """Million samples a second, over a while."""
    run()
    start, calls = time.perf_counter(), 0
    while (passed := time.perf_counter() - start) < SECONDS:
        run()
        calls += 1
    return calls * batch / passed / 1e6


def alone(path: str, tip: str, batch: int, orders: Connection) -> None:
    """A process of its own: measure whenever told the name of a task."""
    runs = {task: call(path, tip, task, batch, 1) for task in TASKS}
    orders.send("ready")
    while (task := orders.recv()) is not None:
        orders.send(rate(runs[task], batch))


def print_sharing(path: str, tip: str, batch: int, repeats: int) -> None:
    """The rates of one thread, two threads and two processes, taken in turn, and the median of
    their ratios."""
    context = multiprocessing.get_context("spawn")
    pipes, processes = [], []
    for _ in range(2):
        here, there = context.Pipe()
        processes.append(context.Process(target=alone, args=(path, tip, batch, there), daemon=True))
        processes[-1].start()
        pipes.append(here)
    for pipe in pipes:
        pipe.recv()
    print(f"\nbatches of {batch}, million samples a second, median of {repeats} rounds in turn:")
    for task in TASKS:
        one, two = (call(path, tip, task, batch, threads) for threads in (1, 2))
        rows = []
        for _ in range(repeats):
            for pipe in pipes:
                pipe.send(task)
            both = sum(pipe.recv() for pipe in pipes)
            rows.append((rate(one, batch), rate(two, batch), both))
        single, shared, apart = np.array(rows).T
        print(
            f"  {task:<20} one thread {np.median(single):6.1f}, two threads "
            f"{np.median(shared):6.1f}, "
            f"two processes {np.median(apart):6.1f}; threads / processes "
            f"{np.median(shared / apart):.2f} "
            f"({(shared / apart).min():.2f} .. {(shared / apart).max():.2f})"
        )
    for pipe, process in zip(pipes, processes, strict=True):
        pipe.send(None)
        process.join()
