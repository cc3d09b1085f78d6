"""The traced computations as source text, as packages with a self-test, and as functions of other array libraries."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from freebody import __version__
from freebody.errors import FreebodyError, KindError, UnknownNameError
from freebody.identifiers import is_identifier
from freebody.kernels.describe import Description, of_program
from freebody.kernels.formulas import Option
from freebody.kernels.inputs import InputKernel, Inputs, inputs_of
from freebody.kernels.options import chosen_option, several
from freebody.kernels.tracing import program
from freebody.kernels.vectors import vectors
from freebody.model.members import FamilyError
from freebody.model.model import Model
from freebody.model.required import require_model
from freebody.outputs.folder import write_folder
from freebody.program import Argument, Program
from freebody.program.passes import share_reciprocals
from freebody.targets import Kernel
from freebody.targets.interpret import array_function
from freebody.targets.text import LANGUAGES, Unit


def source(
    what: Model | Kernel | InputKernel,
    names: str | Sequence[str] | None = None,
    language: str = "numpy",
    *,
    name: str | None = None,
    dtype: str = "float64",
    **options: Any,
) -> str:
    """Text of a function that computes one quantity, or several that share their work, in another language.

    what: a model and `names` of quantities, or a kernel of fb.compile. names, options: as for `fb.kernel` (frame,
    reference, wrench_frames, rows, by, and inputs: numbers of the model that are given as p at each call). language:
    "c", "cpp", "javascript" (a module), "javascript-script", "rust", "julia", "matlab" (Octave too), "numpy", "jax",
    "casadi", "cuda" (PTX). name: of the function, by default the quantities'. dtype: "float64", or "float32" (c, rust,
    julia, cuda).
    Arguments are those of the kernel, in its order, in SI units; the text's head says all that is needed to call it.
    It is ASCII, names in it are words, and the same robot gives the same text. Raises UnknownNameError, FreebodyError.
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
    """Write `fb.source`'s text into the folder `out` as a package that tests itself; the paths of its files.

    Arguments as for `fb.source`. Beside the text: a self-test with test vectors, README.txt with the command that runs
    it, names.json with names as they were where the text has words, and manifest.json. Nothing but freebody's own files
    is replaced. Raises FileError, OutputError too.
    """
    if not isinstance(out, str | os.PathLike):
        raise KindError("fb.export", "out", out, "the name of a folder")
    unit, described, given = _unit("fb.export", what, names, language, name, dtype, options)
    known = LANGUAGES[language]
    model = what if isinstance(what, Model) else None
    files = known.package(unit, vectors(unit.program, dtype, model, given.values if given else None))
    word = next(iter(files)).partition(".")[0]
    files["README.txt"] = _readme(unit, known.test.format(name=word), known.note, list(files))
    files["names.json"] = json.dumps(described, indent=1) + "\n"
    about = {"freebody": __version__, "function": word, "language": language, "dtype": dtype}
    return write_folder(out, {key: (lambda text=text: text) for key, text in files.items()}, about)


def to_jax(
    what: Model | Kernel | InputKernel, names: str | Sequence[str] | None = None, **options: Any
) -> Callable[..., Any]:
    """The same as a pure JAX function, which may be jitted, differentiated and mapped. Needs JAX.

    Arguments as for `fb.source`. 64-bit floats are the caller's choice: jax.config.update("jax_enable_x64", True).
    """
    try:
        import jax.numpy
    except ImportError:
        raise FreebodyError("to_jax: JAX is not installed; pip install 'freebody[jax]'.") from None
    return array_function(_traced("fb.to_jax", what, names, options)[0], jax.numpy)


_OPTIONS = ("frame", "reference", "wrench_frames", "rows")


def _traced(
    function: str,
    what: Model | Kernel | InputKernel,
    names: str | Sequence[str] | None,
    options: dict[str, Any],
) -> tuple[Program, tuple[tuple[str, ...], Option, Inputs | None] | None]:
    """The program that is meant; of a model the quantities, the structure and the numbers that are inputs too."""
    if isinstance(what, Kernel | InputKernel):
        if names is not None or options:
            raise FreebodyError(
                f"{function}: a kernel has its quantities already; give no names and no options."
            )
        return what.program, None
    require_model(function.removeprefix("fb."), what)
    if names is None:
        raise FreebodyError(f"{function}: give the quantities, such as 'inverse_dynamics'.")
    wanted, by = (several(function, f"{key}=", options.get(key, ())) for key in ("inputs", "by"))
    rest = {key: value for key, value in options.items() if key not in ("inputs", "by")}
    for key in rest:
        if key not in _OPTIONS:
            raise UnknownNameError("option", key, function, (*_OPTIONS, "inputs", "by"))
    listed, option = chosen_option(what, names, **rest, function=function)
    given = inputs_of(function, what, wanted) if wanted else None
    p = Argument("p", (len(given.names),)) if given else None
    traced = program(what, listed, option, p, given.tree if given else None, by)
    return traced, (listed, option, given)


def _unit(
    function: str,
    what: Model | Kernel | InputKernel,
    names: str | Sequence[str] | None,
    language: str,
    name: str | None,
    dtype: str,
    options: dict[str, Any],
) -> tuple[Unit, dict[str, Any], Inputs | None]:
    """What is written, the names behind its words, and the numbers that are inputs."""
    if not isinstance(language, str) or language not in LANGUAGES:
        raise UnknownNameError("language", language, function, LANGUAGES)
    dtypes = LANGUAGES[language].dtypes
    if dtype not in dtypes:
        raise FreebodyError(f"{function}: dtype={dtype!r} in {language}; it can be {' or '.join(dtypes)}.")
    if name is not None and not is_identifier(name):
        raise FreebodyError(
            f"{function}: name={name!r} is no word of letters a-z, digits and _ that could be a function's name."
        )
    model = what.model if isinstance(what, InputKernel) else what
    if isinstance(model, Model) and model.family:
        raise FamilyError(function, model.name, model.family)
    traced, chosen = _traced(function, what, names, options)
    traced = share_reciprocals(traced)
    if chosen is None or not isinstance(what, Model):
        given = Inputs(what.parameters, what.values, what.model) if isinstance(what, InputKernel) else None
        comment, words = of_program(traced, given)
        return Unit(traced, name or traced.name, comment, None, dtype), words, given
    listed, option, given = chosen
    about = Description(what, listed, option, given, traced)
    unit = Unit(traced, name or traced.name, about.comment, about.joints, dtype, about.marks)
    return unit, about.names, given


def _readme(unit: Unit, command: str, note: str, files: list[str]) -> str:
    """What lies in the folder and how it is tried."""
    return "\n".join(
        [
            *unit.comment,
            "",
            f"Files: {', '.join(files)};",
            "names.json has the names as they were where the text has words, manifest.json checksums.",
            "",
            "The self-test compares with results in more digits, and ends with status 0 if they agree:",
            f"    {command}",
            *(["", note] if note else []),
            "",
        ]
    )
