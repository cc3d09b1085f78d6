"""freebody's own format in TOML: a robot as a person would write it down, with the values and
formulas of its parameters. docs/formats.md is its reference."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Literal

from freebody.errors import ModelError
from freebody.formats import read_file
from freebody.formats import toml_parts as parts
from freebody.formats.toml_table import TomlTable, table_of
from freebody.formats.toml_values import Beneath, with_values
from freebody.model import dh, planar_arms
from freebody.model.build import build_model
from freebody.model.description import Joint, Link, Mount, RobotDescription
from freebody.model.doubts import DOUBT_KINDS, Doubt, tied
from freebody.model.joints import KINDS
from freebody.model.parameters import Parameter, each_parameter, with_parameters

_TOLD_KINDS = [kind for kind in DOUBT_KINDS.values() if kind.key]
_GENERAL = (
    "name",
    "dim",
    "source",
    "about",
    "gravity",
    "tip",
    "base",
    "parameters",
    "frame",
    "payload",
    "loop",
    "loop_tolerance",
    "strut",
    "home",
    *(kind.key for kind in _TOLD_KINDS),
)
_TREE = ("link", "joint")
_ALONE = ("template", "planar", "dh")
_BASES: tuple[Literal["fixed", "free"], ...] = ("fixed", "free")

_DH_NUMBERS = {
    "theta": "angle",
    "d": "number",
    "a": "number",
    "alpha": "angle",
    "rotor": "number",
    "gear": "number",
    "m": "number",
}
_DH_ROW = ("joint", "name", "joint_name", *_DH_NUMBERS, "com", "I", "friction", "limits", "passive")


def describe(file: str, text: str, *, name: str) -> RobotDescription:
    """The description in a TOML text. `name` stands in where the file gives none. Raises FileError
    with the line."""
    top = table_of(file, text)
    form = _form(top)
    if form == "template":
        described, beneath = _template(top)
    else:
        described, beneath = _formed(top, form), Beneath()
    return with_values(top, _with_the_rest(top, described, name), beneath)


def _form(top: TomlTable) -> str:
    """The form in which a file gives links and joints."""
    top.only(*_GENERAL, *_TREE, *_ALONE)
    forms = [key for key in _ALONE if key in top]
    if len(forms) > 1 or (forms and any(key in top for key in _TREE)):
        whole = "robot" if forms[0] == "template" else "arm"
        top.refuse(
            f"[{forms[0]}] describes the whole {whole}; remove the other links and joints.",
            forms[0],
        )
    return forms[0] if forms else "tree"


def _formed(top: TomlTable, form: str) -> RobotDescription:
    """The description of the links and joints that a file gives itself."""
    try:
        return _FORMS[form](top)
    except ModelError as error:
        top.refuse(str(error), *([form] if form in top else []))


def _with_the_rest(top: TomlTable, described: RobotDescription, name: str) -> RobotDescription:
    """The description with all that stands beside links and joints, in addition to what it has."""
    mounts = _mounts(top, described)
    names = [part.name for part in (*described.links, *mounts)]
    told = [kind for kind in _TOLD_KINDS if kind.key in top]
    home = {**dict(described.home), **dict(parts.home(top, described.joints))}
    return replace(
        described,
        name=top.text("name", name),
        mounts=mounts,
        loops=(*described.loops, *(parts.loop(t, described.dim) for t in top.tables("loop"))),
        struts=(*described.struts, *map(parts.strut, top.tables("strut"))),
        payloads=(
            *described.payloads,
            *(parts.payload(t, described.dim, names) for t in top.tables("payload")),
        ),
        base=top.choice("base", _BASES, described.base),
        loop_tolerance=parts.loop_tolerance(top) or described.loop_tolerance,
        home=tuple(home.items()),
        tip=top.choice("tip", names, described.tip) if "tip" in top else described.tip,
        source=top.text("source", described.source),
        about=top.text("about", described.about),
        notices=(
            *(
                x
                for x in described.notices
                if not any(isinstance(x, Doubt) and x.kind == kind.name for kind in told)
            ),
            *(Doubt(kind.name, text, top.file) for kind in told for text in _texts(top, kind.key)),
        ),
        file=top.file,
    )


def _mounts(top: TomlTable, described: RobotDescription) -> tuple[Mount, ...]:
    """The frames that a description already has, then those of the file's [[frame]] tables."""
    found = list(described.mounts)
    # a dict for its order: an error lists the names in the order of the file
    names = dict.fromkeys(part.name for part in (*described.links, *found))
    for table in top.tables("frame"):
        found.append(parts.mount(table, described.dim, names))
        if found[-1].name in names:
            table.refuse(f"frame {found[-1].name!r}: the name is taken; rename it.", "name")
        names[found[-1].name] = None
    return tuple(found)


def _tree(top: TomlTable) -> RobotDescription:
    """Description of a robot whose file lists links and joints."""
    dim = int(given) if (given := top.number("dim", default=3.0)) in (2.0, 3.0) else 0
    if not dim:
        top.refuse(f"dim is {top.data['dim']}, expected 2 (the plane) or 3 (space).", "dim")
    links = tuple(parts.link(t, dim) for t in top.tables("link"))
    if not links:
        top.refuse("there are no links; write a [[link]] for each body, the base included.")
    tables = top.tables("joint")
    whole = [parts.flexible(table, parts.joint(table, dim)) for table in tables]
    joints = tuple(joint for found, _ in whole for joint in found)
    flexible = [found[0].name for found, _ in whole if len(found) > 1]
    for table, joint in zip(tables, (found[0] for found, _ in whole), strict=True):
        if joint.mimic is not None and joint.mimic.joint in flexible:
            problem = f"joint {joint.mimic.joint!r} is flexible, and its rotor would be followed"
            table.refuse(f"joint {joint.name!r}: {problem}; leave one of the two out.", "mimic")
    links = (*links, *(link for _, found in whole for link in found))
    return RobotDescription("", dim, links, joints, parts.gravity(top, dim))


def _planar(top: TomlTable) -> RobotDescription:
    """The description of a planar arm that is given as a word over R and P."""
    if "dim" in top and top.data["dim"] != 2:
        top.refuse("a [planar] arm has dim = 2; remove dim.", "dim")
    inner = top.inner(top.data["planar"], "planar").called("[planar]")
    inner.only("word", "l", "lc", "m", "I", "angles", "limits", "drives", "passive")
    word = inner.text("word")
    given: dict[str, Any] = {
        key: inner.quantities(key, len(word), default=None) for key in ("l", "lc", "m", "I")
    }
    limits = [
        parts.limits_of(t, angles=word[i : i + 1] == "R")
        for i, t in enumerate(inner.tables("limits"))
    ]
    drives = [
        parts.drive(t.only(*parts.DRIVE), angles=word[i : i + 1] == "R")
        for i, t in enumerate(inner.tables("drives"))
    ]
    described = planar_arms.describe(
        word,
        **given,
        angles=inner.vector("angles", len(word), "angle", None),
        limits=limits or None,
        drives=drives or None,
        passive=_texts(inner, "passive"),
    )
    links = tuple(_on_line(link, inner.line) for link in described.links)
    return replace(described, links=links, gravity=parts.gravity(top, 2))


def _texts(table: TomlTable, key: str) -> list[str]:
    """A list of names in a table; empty where the key is absent."""
    names = table.data.get(key, [])
    if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
        table.refuse(f'{key} is {names!r}, expected a list of names such as ["joint2"].', key)
    return names


def _dh(top: TomlTable) -> RobotDescription:
    """A serial arm from a Denavit-Hartenberg table."""
    if "dim" in top and top.data["dim"] != 3:
        top.refuse("a [dh] arm has dim = 3; remove dim.", "dim")
    inner = top.inner(top.data["dh"], "dh").called("[dh]").only("convention", "rows")
    convention: Any = inner.choice("convention", ("standard", "modified"))
    tables = inner.tables("rows")
    rows = [_dh_row(t.called(f"dh row {i + 1}")) for i, t in enumerate(tables)]
    described = dh.describe(
        [{key: value for key, value in row.items() if key != "joint_name"} for row in rows],
        convention=convention,
        file=top.file,
        lines=[t.line or 0 for t in tables],
        joint_names=[row.get("joint_name") for row in rows],
    )
    return replace(described, gravity=parts.gravity(top, 3))


def _dh_row(table: TomlTable) -> dict[str, Any]:
    """One row of a DH table, as `fb.dh` takes it, and joint_name."""
    table.only(*_DH_ROW)
    row: dict[str, Any] = {
        key: table.quantity(key, kind) for key, kind in _DH_NUMBERS.items() if key in table
    }
    row["joint"] = table.choice("joint", "RP", "R")
    for key in ("name", "joint_name"):
        if key in table:
            row[key] = table.text(key)
    if "com" in table:
        row["com"] = table.quantities("com", 3)
    if "I" in table:
        full = isinstance(table.data["I"], list) and len(table.data["I"]) == 3
        row["I"] = table.matrix("I", 3) if full else table.quantities("I", 6)
    if "friction" in table:
        inner = table.inner(table.data["friction"], "friction")
        row["friction"] = parts.drive_numbers(inner, "friction", angles=row["joint"] == "R")
    if "limits" in table:
        row["limits"] = parts.limits(table, angles=row["joint"] == "R")
    row["passive"] = table.flag("passive")
    return row


_FORMS = {"tree": _tree, "planar": _planar, "dh": _dh}


def _template(top: TomlTable) -> tuple[RobotDescription, Beneath]:
    """A template's robot with numbers in the place of some of its names, and the values that the
    others have in the template."""
    inner = top.inner(top.data["template"], "template").called("[template]")
    inner.only("name", "numbers", "joints")
    name, names = inner.text("name"), read_file.template_names()
    if name not in names:
        inner.unknown("template", name, names, "name")
    text = table_of(top.file, read_file.template_text(name))
    # whatever is wrong with its robot, the file's own numbers are: errors are told at its table
    own = TomlTable(top.file, {(): top.lines["template",]}, (), text.data)
    described = _with_the_rest(own, _formed(own, _form(own)), name)
    if described.notices:  # a robot with other numbers in the place of all of them is free of them
        defaults = build_model(with_values(own, described, Beneath()), physical="ignore")
        described = replace(described, notices=tied(described.notices, defaults))
    if "dim" in top and top.data["dim"] != described.dim:
        top.refuse(f"the template {name!r} has dim = {described.dim}; remove dim.", "dim")
    if "gravity" in top:
        described = replace(described, gravity=parts.gravity(top, described.dim))
    described = replace(described, joints=_changed(inner, described.joints))
    numbers, texts = parts.parameter_table(own)
    numbers |= {x.name: x.value for x in each_parameter(described) if isinstance(x.value, float)}
    bound = _bound(top, inner, [*numbers, *texts])
    nameless = with_parameters(described, lambda x: Parameter(x.name))
    return nameless, Beneath(numbers | bound, texts, tuple(bound))


def _bound(top: TomlTable, template: TomlTable, known: Sequence[str]) -> dict[str, float]:
    """The numbers by the names of a template's parameters in whose place they stand."""
    given = template.table("numbers")
    if given is None:
        return {}
    given = given.called("[template.numbers]")
    named = top.table("parameters")
    for name in given.data:
        if name not in known:
            given.unknown("parameter", name, known, name)
        if named is not None and name in named:
            given.refuse(f"{name} has another value below [parameters]; keep one.", name)
    return {name: given.number(name, "angle") for name in given.data}


def _changed(template: TomlTable, joints: tuple[Joint, ...]) -> tuple[Joint, ...]:
    """The joints of a template, some with limits and drives of a file's own."""
    given = template.table("joints")
    if given is None:
        return joints
    names = [joint.name for joint in joints if KINDS[joint.kind].nv == 1]
    for name in given.data:
        if name not in names:
            given.called("[template.joints]").unknown("joint", name, names, name)
    return tuple(
        _with_drive(given.inner(given.data[joint.name], joint.name), joint)
        if joint.name in given
        else joint
        for joint in joints
    )


def _with_drive(table: TomlTable, joint: Joint) -> Joint:
    """A joint with the limits and the drive of a table, where it gives them."""
    table = table.called(f"[template.joints], {joint.name!r}").only("limits", *parts.DRIVE)
    angles = not KINDS[joint.kind].slides
    found = replace(joint, line=table.line)
    if "limits" in table:
        found = replace(found, limits=parts.limits(table, angles))
    if any(key in table for key in parts.DRIVE):
        found = replace(found, drive=parts.drive(table, angles))
    return found


def _on_line(link: Link, line: int | None) -> Link:
    return replace(link, line=line)
