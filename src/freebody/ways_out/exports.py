"""Traced computations as source text, and as packages with a self-test whose samples are more
accurate than the text's results."""

from __future__ import annotations

import contextlib
import json
import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from freebody import __version__
from freebody.arrays import Array
from freebody.errors import FreebodyError, KindError, LoopError, UnknownNameError
from freebody.identifiers import is_identifier
from freebody.kernels.formulas import FORMULAS, INPUTS, POSITIONS, Option
from freebody.kernels.formulas.inverse import known_branches
from freebody.kernels.parameter_inputs import InputKernel, KernelInputs
from freebody.model.doubts import Doubt, attribute
from freebody.model.families import FamilyError
from freebody.model.model import Model
from freebody.outputs.folder import write_folder
from freebody.program import Program
from freebody.program.passes import share_reciprocals, with_epsilon
from freebody.targets import Kernel
from freebody.targets.interpreter import Interpreter
from freebody.targets.text import LANGUAGES, SelfTestSamples, SourceUnit
from freebody.ways_out.kernel import QuantityRequest, requested
from freebody.ways_out.program_description import ProgramDescription, of_program


def source(
    what: Model | Kernel | InputKernel,
    names: str | Sequence[str] | None = None,
    language: str = "numpy",
    *,
    name: str | None = None,
    dtype: str = "float64",
    **options: Any,
) -> str:
    """Text of a function that computes one quantity, or several that share their work, in another
    language.

    Parameters
    ----------
    what
        A model, or a kernel of `fb.kernel` or `fb.compile`.
    names
        Quantities of the model, as for `fb.kernel`; none for a kernel.
    language
        "c", "cpp", "javascript" (a module), "javascript-script", "rust", "julia", "matlab" (Octave
        too), "numpy", "jax", "casadi" or "cuda" (PTX).
    name
        The name of the function, by default the quantities'.
    dtype
        "float64", or "float32" (c, rust, julia, cuda).
    **options
        As for `fb.kernel`: frame, reference, wrench_frames, rows, by, and inputs, numbers of the
        model that are given as p at each call.

    Returns
    -------
    str
        A function whose arguments are those of the kernel, in its order, in SI units; the text's
        head says all that is needed to call it. It is ASCII, names in it are words, and the same
        robot gives the same text.

    Raises
    ------
    UnknownNameError
        A language, quantity or option that does not exist.
    FreebodyError
        A dtype that the language lacks, or a name that is no word.
    """
    unit, *_ = _unit("fb.source", what, names, language, name, dtype, options)
    return LANGUAGES[language].emit(unit)


def export(
    what: Model | Kernel | InputKernel,
    names: str | Sequence[str] | None = None,
    out: str | os.PathLike[str] = ".",
    language: str = "c",
    *,
    name: str | None = None,
    dtype: str = "float64",
    **options: Any,
) -> list[Path]:
    """Write `fb.source`'s text into a folder as a package that tests itself.

    Beside the text: a self-test with test vectors, README.txt with the command that runs it,
    names.json with names as they were where the text has words, and manifest.json. Nothing but
    freebody's own files is replaced.

    Parameters
    ----------
    out
        The folder.
    what, names, language, name, dtype, **options
        As for `fb.source`.

    Returns
    -------
    list of Path
        The files that were written.

    Raises
    ------
    UnknownNameError, FreebodyError
        As `fb.source`.
    FileError, OutputError
        A folder that cannot be written to, or files there that are not freebody's.
    """
    if not isinstance(out, str | os.PathLike):
        raise KindError("fb.export", "out", out, "the name of a folder")
    unit, described, given, option, doubts = _unit(
        "fb.export", what, names, language, name, dtype, options
    )
    known = LANGUAGES[language]
    model = what if isinstance(what, Model) else None
    files = known.package(
        unit, vectors(unit.program, dtype, model, given.values if given else None, option)
    )
    word = next(iter(files)).partition(".")[0]
    files["README.txt"] = _readme(word, known.test.format(name=word), known.note, list(files))
    files["names.json"] = json.dumps(described, indent=1) + "\n"
    about = {"freebody": __version__, "function": word, "language": language, "dtype": dtype}
    about |= attribute(doubts)
    return write_folder(out, {key: (lambda text=text: text) for key, text in files.items()}, about)


def _unit(
    function: str,
    what: Model | Kernel | InputKernel,
    names: str | Sequence[str] | None,
    language: str,
    name: str | None,
    dtype: str,
    options: dict[str, Any],
) -> tuple[SourceUnit, dict[str, Any], KernelInputs | None, Option | None, tuple[Doubt, ...]]:
    """(the source unit, robot names by the identifiers that stand for them, numbers that are
    inputs, option of the model, doubts about the model) for `fb.source` and `fb.export`."""
    if not isinstance(language, str) or language not in LANGUAGES:
        raise UnknownNameError("language", language, function, LANGUAGES)
    dtypes = LANGUAGES[language].dtypes
    if dtype not in dtypes:
        raise FreebodyError(
            f"{function}: language {language!r} has no dtype {dtype!r}; it has "
            f"{' and '.join(dtypes)}."
        )
    if name is not None and not is_identifier(name):
        raise FreebodyError(
            f"{function}: name={name!r} is not a valid function name: a word of letters a-z, "
            f"digits and _."
        )
    model = what.model if isinstance(what, InputKernel) else what
    if isinstance(model, Model) and model.family:
        raise FamilyError(function, model.name, model.family)
    chosen = requested(function, what, names, options)
    if not isinstance(chosen, QuantityRequest):
        traced = share_reciprocals(chosen.program)
        given = chosen.named if isinstance(chosen, InputKernel) else None
        comment, words = of_program(traced, given)
        return SourceUnit(traced, name or traced.name, comment, None, dtype), words, given, None, ()
    traced = share_reciprocals(chosen.program())
    about = ProgramDescription(chosen.model, chosen.names, chosen.option, chosen.given, traced)
    unit = SourceUnit(traced, name or traced.name, about.comment, about.joints, dtype, about.marks)
    return unit, about.names, chosen.given, chosen.option, about.doubts


def _readme(word: str, command: str, note: str, files: list[str]) -> str:
    """README text of an exported package: its files and how to run the self-test; also for
    functions exported there earlier."""
    return "\n".join(
        [
            f"Functions written by freebody {__version__}. The comment at the top of each file "
            f"says how to call them.",
            f"Files of {word}: {', '.join(files)}.",
            "names.json: the names in the robot's file, where the code had to change them. "
            "manifest.json: checksums.",
            "",
            f"Each function has a self-test: it compares results with more accurate ones and ends "
            f"with status 0 if they agree. To run that of {word}:",
            f"    {command}",
            *(["", note] if note else []),
            "",
        ]
    )


COUNT = 5
"""Number of samples of a self-test."""
_TRIES = 40
_OFF = 0.3
"""How far from the closed position towards a random one."""
_FLOOR = {"float64": 1e-13, "float32": 1e-5}
_MARGIN = 16.0
"""Another order of operations, or another sine, may cost more than was seen."""


def vectors(
    program: Program,
    dtype: str,
    model: Model | None = None,
    numbers: Array | None = None,
    option: Option | None = None,
) -> SelfTestSamples:
    """Self-test samples: inputs at which all outputs are finite, the outputs in extended precision,
    and the tolerance: sixteen times the error of NumPy in `dtype` on them, at least 1e-13 (float32:
    1e-5).

    numbers: (k,) the model's own values of p, which is tried within a tenth of them. option: what
    was chosen of the model, such as the frame that is to reach its target.
    Raises FreebodyError where none are found.
    """
    rng = np.random.default_rng(0)
    given = [
        _near(numbers, rng)
        if numbers is not None and a.name == "p"
        else _samples(a.name, a.shape, model, rng)
        for a in program.inputs
    ]
    if model is not None and model.loops:
        given = _closed(model, [a.name for a in program.inputs], given)
    if model is not None and option is not None and program.inputs[0].name == "target":
        given = _reached(model, option, given, rng)
    given = [x.astype(dtype).astype(np.float64) for x in given]
    epsilon = float(np.finfo(dtype).eps)  # the same samples are valid, but for rounding
    exact = _run(with_epsilon(program, epsilon), given, np.longdouble)
    fine = np.logical_and.reduce([np.isfinite(x).all(axis=1) for x in exact])
    if not fine.any():
        raise FreebodyError(
            f"{program.name}: outputs are infinite or NaN at all of {_TRIES} random inputs; there "
            f"is nothing to test "
            "an export with. Is the robot singular everywhere (a joint that moves no mass)?"
        )
    chosen = np.flatnonzero(fine)[:COUNT]
    rounded = _run(program, given, np.dtype(dtype).type)
    tolerances = []
    for values, with_rounding in zip(exact, rounded, strict=True):
        largest = float(np.abs(values[chosen]).max(initial=0.0)) or 1.0
        off = float(np.abs(with_rounding[chosen] - values[chosen]).max(initial=0.0)) / largest
        tolerances.append(max(_FLOOR[dtype], _MARGIN * off))
    return SelfTestSamples(
        tuple(x[chosen] for x in given),
        tuple(x[chosen].astype(np.float64) for x in exact),
        tuple(float(f"{tolerance:.1e}") for tolerance in tolerances),
    )


def _samples(
    name: str, shape: tuple[int, ...], model: Model | None, rng: np.random.Generator
) -> Array:
    """Random values (tries, size) of an input: positions near the home position, inputs that must
    be positive up to their usual size, others between -1 and 1."""
    size = int(np.prod(shape))
    values = rng.uniform(-1.0, 1.0, size=(_TRIES, size))
    size = INPUTS[name].positive if model is not None and name in INPUTS else None
    if size is not None:
        return np.abs(values) * size
    if model is None or name not in POSITIONS:
        return values
    home = dict(model.home)
    for k, position in enumerate(model.position_names):
        if model.loops:  # a state that is nearly closed
            values[:, k] *= 0.1
        values[:, k] += home.get(position, 0.0)
    return _unit_quaternions(model, values)


def _reached(
    model: Model, option: Option, given: list[Array], rng: np.random.Generator
) -> list[Array]:
    """Target poses (tries, pose) that random positions reach, and the value of a locked joint at
    those positions."""
    q = np.pi * _samples("q", (model.nq,), None, rng)
    (T,) = FORMULAS["forward_kinematics"].evaluate(
        model.tree, option, q=tuple(_unit_quaternions(model, q).T)
    )
    poses = np.stack([np.broadcast_to(x, (_TRIES,)) for row in T for x in row], axis=-1)
    held = known_branches(model.tree, option).held
    return [poses, *([] if held is None else [q[:, [held]]]), *given[1 if held is None else 2 :]]


def _unit_quaternions(model: Model, positions: Array) -> Array:
    """Positions (tries, nq) with quaternions normalised to unit length."""
    for body, at in zip(model.bodies, model.coordinates, strict=True):
        start = body.kind.quaternion
        if start is not None:
            quaternion = positions[:, at.q[start:]]
            positions[:, at.q[start:]] = quaternion / np.linalg.norm(
                quaternion, axis=1, keepdims=True
            )
    return positions


def _near(own: Array, rng: np.random.Generator) -> Array:
    """Values (tries, k) within a tenth of the given numbers; unknown numbers are replaced by values
    near 1, zeros by values near 0."""
    known = np.where(np.isnan(own), 1.0, own)
    return known + rng.uniform(-0.1, 0.1, size=(_TRIES, own.size)) * np.where(
        known == 0.0, 0.1, known
    )


def _closed(model: Model, names: list[str], given: list[Array]) -> list[Array]:
    """Inputs with positions that close the loops, and rates that keep them closed; unchanged if no
    closed position is near.

    Every second is a little off: where all loops are closed their equations are rounding, and say
    nothing.
    """
    from freebody.loops.rates import loop_velocity

    found = dict(zip(names, given, strict=True))
    with contextlib.suppress(LoopError):
        closed_at = {x: _assembled(model, found[x]) for x in POSITIONS if x in found}
        if "q" in closed_at and "qd" in found:
            found["qd"] = loop_velocity(model, closed_at["q"], found["qd"])
        for name, positions in closed_at.items():
            positions[1::2] += _OFF * (found[name] - positions)[1::2]
            found[name] = _unit_quaternions(model, positions)
    return list(found.values())


def _assembled(model: Model, near: Array) -> Array:
    """Closed positions near the given ones (tries, nq); where the search from one fails, another is
    used. Raises LoopError if none can be closed."""
    from freebody.loops.assembly import assemble

    try:
        return assemble(model, near)
    except LoopError as none:
        closed = []
        for position in near:
            with contextlib.suppress(LoopError):
                closed.append(assemble(model, position))
        if not closed:
            raise none
        return np.resize(closed, near.shape)


def _run(program: Program, given: list[Array], kind: type) -> list[np.ndarray]:
    """Outputs (tries, size) of a program, computed in the floating-point type `kind`."""
    rows = [column for x in given for column in x.astype(kind).T]
    with np.errstate(all="ignore"):
        scalars = Interpreter.of(program)(rows)
    done = [np.broadcast_to(np.asarray(x, kind), (_TRIES,)) for x in scalars]
    results, start = [], 0
    for argument in program.outputs:
        part = done[start : start + argument.size]
        start += argument.size
        results.append(np.stack(part, axis=1) if part else np.zeros((_TRIES, 0), kind))
    return results
