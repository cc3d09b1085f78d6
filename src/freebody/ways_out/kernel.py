"""Kernels by name, for users' own programs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import overload

from freebody.any_chain.kernel_options import chosen_option
from freebody.kernels.column_by_column import ColumnKernel, KernelList
from freebody.kernels.inputs import InputKernel
from freebody.kernels.lookup import fetch
from freebody.kernels.options import several
from freebody.model.model import Model
from freebody.model.named_numbers import Name
from freebody.targets import Kernel


@overload
def kernel(
    model: Model,
    names: str | Sequence[str],
    *,
    frame: str | None = None,
    reference: str = "world",
    wrench_frames: Sequence[str] = (),
    rows: Sequence[str] | None = None,
    target: str | None = None,
    width: int | None = None,
    dtype: str = "float64",
    inputs: Name | Sequence[Name],
    by: str | Sequence[str] = (),
) -> InputKernel: ...


@overload
def kernel(
    model: Model,
    names: str | Sequence[str],
    *,
    frame: str | None = None,
    reference: str = "world",
    wrench_frames: Sequence[str] = (),
    rows: Sequence[str] | None = None,
    target: str | None = None,
    width: int | None = None,
    dtype: str = "float64",
    by: str | Sequence[str] = (),
) -> Kernel | ColumnKernel | KernelList | InputKernel: ...


def kernel(
    model: Model,
    names: str | Sequence[str],
    *,
    frame: str | None = None,
    reference: str = "world",
    wrench_frames: Sequence[str] = (),
    rows: Sequence[str] | None = None,
    target: str | None = None,
    width: int | None = None,
    dtype: str = "float64",
    inputs: Name | Sequence[Name] = (),
    by: str | Sequence[str] = (),
) -> Kernel | ColumnKernel | KernelList | InputKernel:
    """The compiled function for one quantity, or for several that share their work.

    Kernels of a closed chain assume that its loops are closed; at singular positions the drives'
    torques are NaN, where the public functions of the same names still answer. One step of a
    simulation is a quantity too: "rk4_step", "semi_implicit_step", "implicit_step" and
    "implicit_feedback_step", with the step's length h after tau, return (q1, qd1); see
    docs/stepping.md; and so are control laws, docs/control.md.

    Parameters
    ----------
    model : Model
        With all values. Of a family all numbers with members are inputs; where its members differ
        in limits alone, the size of gravity.
    names : str or list of str
        Among "inverse_dynamics", "forward_dynamics", "mass_matrix", "jacobian", …
    frame : str, optional
        For kinematic quantities; default the tip.
    reference : str
        "world" or "body" axes (for joint wrenches "child").
    wrench_frames : names
        Frames that carry external wrenches; each becomes a further input (..., 6): wrench0,
        wrench1, … in their order.
    rows : names, optional
        Of operational space, among "vx", "vy", "vz", "wx", "wy", "wz" (plane "vx", "vy", "w";
        default all).
    target : str, optional
        Where it runs: "cpu" (machine code by LLVM for this CPU), "cpu:x86-64-v3" (for all that
        reach this level, to the same bytes), "numpy" (node by node, without a compiler) or "cuda"
        (NVIDIA's GPUs; it takes arrays in their memory); None: what FREEBODY_TARGET says, else the
        CPU.
    width : int, optional
        Samples in a CPU vector; None: as many as suit it.
    dtype : str
        "float64", or "float32", which computes with numbers of 32 bits, about twice as fast in
        batches, to about 6 digits of a sample's largest entry; arrays of other real types are
        rounded to it, and so are the robot's numbers.
    inputs : names
        Numbers of the model that are to be given, by names and patterns of `fb.parameters`
        ("link*.mass"; patterns leave out exact zeros and right angles of placements, names in full
        take them): they are gathered, in the order of `fb.parameters`, in one last argument p
        (..., k), or given as p={name: value}; without p they are the model's own. k.parameters are
        their names, k.values the model's own.
    by : names
        Inputs by which each output is differentiated as well (exactly, in forward mode), "p" among
        them: after the outputs come their derivatives, dtau_dp (*output, k) and so on, output by
        output; those by positions are on the tangent space (nv).

    Returns
    -------
    k(q, qd, …, out=None, threads=None)
        Broadcasts like a NumPy ufunc, lets NaN through and checks no names; its inputs are those of
        the quantities, in the order q, qd, qdd, tau, wrenches, and its outputs in the order of
        `names`.

    Raises
    ------
    UnknownNameError
    SingularError
        The drives of a closed chain do not force its motion.
    """
    listed, option = chosen_option(
        model, names, frame=frame, reference=reference, wrench_frames=wrench_frames, rows=rows
    )
    return fetch(
        model,
        listed,
        option,
        target,
        width,
        dtype,
        several("fb.kernel", "inputs=", inputs),
        several("fb.kernel", "by=", by),
    )
