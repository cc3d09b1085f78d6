"""The traced computations as source text, and as packages with a self-test."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from freebody import __version__
from freebody.errors import FreebodyError, KindError, UnknownNameError
from freebody.identifiers import is_identifier
from freebody.kernels.formulas import Option
from freebody.kernels.inputs import InputKernel, KernelInputs
from freebody.model.doubts import Doubt, attribute
from freebody.model.families import FamilyError
from freebody.model.model import Model
from freebody.outputs.folder import write_folder
from freebody.program.passes import share_reciprocals
from freebody.targets import Kernel
from freebody.targets.text import LANGUAGES, SourceUnit
from freebody.ways_out.kernel import QuantityRequest, requested
from freebody.ways_out.program_description import ProgramDescription, of_program
from freebody.ways_out.self_test_samples import vectors


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
    """The text to be written as a unit, the names behind its words, the numbers that are inputs,
    the option of a model, and the doubts about it."""
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
    """The text that says what lies in the folder and how to try it; it serves the functions that
    were written there before, too."""
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
