"""`fb.template`, beside `load` since it reads files too: robots by their kind, with names for their
numbers."""

from __future__ import annotations

from typing import Any

from freebody.errors import KindError, UnknownNameError
from freebody.formats import read_file
from freebody.formats.loading import TEMPLATE, load
from freebody.model.model import Model


def template(name: str, /, **numbers: Any) -> Model:
    """A robot of a given kind with numbers of one's own: "delta", "five_bar", "gantry",
    "palletiser", "scara", "six_axis".

    Parameters
    ----------
    name
        The kind.
    **numbers
        Values of the template's parameters, m, kg, kg m², or formulas, as `Model.bind` takes them;
        those that are not given have the template's own values, which `model.parameters` lists.

    Returns
    -------
    Model
        The robot. Where a closed chain starts from is the template's; `fb.assemble` closes it.

    Raises
    ------
    UnknownNameError
        A template or a parameter that does not exist.
    ModelError
        Numbers that no rigid body has.

    Notes
    -----
    On the command line a template is `template:NAME`, its numbers `--parameter NAME=VALUE`.
    """
    if not isinstance(name, str):
        raise KindError("fb.template", "name", name, "the name of a template")
    names = read_file.template_names()
    if name not in names:
        raise UnknownNameError("template", name, "fb.template", names)
    model = load(f"{TEMPLATE}{name}", physical="ignore")
    # a number of one's own takes the place of the template's formula for it
    followed = {formula.name for formula in model.formulas} & numbers.keys()
    model = model.bind({key: key for key in followed}) if followed else model
    return model.bind(**numbers) if numbers else model
