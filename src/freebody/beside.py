"""Packages that build on freebody and come with it, and what each adds: the one place, beside the
table of public names, that knows their modules by name. freebody works without them."""

from __future__ import annotations

from types import ModuleType

from freebody.errors import MissingPackageError
from freebody.locks import imported

COMMANDS = {
    "derive": "freebody_textbook.commands.derive",
    "check": "freebody_textbook.commands.check",
    "notes": "freebody_notes.command",
}
"""Commands and their modules, which have the function of this name, an EXAMPLE and, where they
write their own help, a `Command`."""

EQUATIONS_OF_A_STUDY = "freebody_textbook.in_studies"
"""The module whose `shown(model)` gives the equations of motion for the page of a study."""


def found(module: str, what: str) -> ModuleType:
    """Import a module of a package that comes with freebody; raises MissingPackageError, which
    names what needs it, if the package is not installed."""
    package = module.partition(".")[0]
    try:
        return imported(module)
    except ModuleNotFoundError as failure:
        if failure.name != package:
            raise
        raise MissingPackageError(what, package) from None
