"""Models inside a model of an SDF file, and those that it includes, written as one model: names get
`INNER::` in front, what is relative to an inner model says so, and its frame is a frame `INNER`.

Only files below the including file's package, below packages that are around it and below those
that the user gives are read.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

from freebody.errors import FileError, IncludedLine, shown
from freebody.formats import read_file
from freebody.formats.packages import Packages
from freebody.formats.urdf_elements import Elements, XmlElement, parse

TEXT = 400
"""Characters of an element's text that are read: a pose of seven numbers."""
MODEL, WORLD = "__model__", "world"
_VERSION = re.compile(r"([0-9]{1,3})\.([0-9]{1,3})(?:\.[0-9]{1,3})?")
_DEEPEST = 20  # models inside each other
_ELEMENTS = 200_000  # that nested and included models have together
AXES_IN_JOINTS = (1, 5)
"""The first version in which an axis is in its joint's frame."""
_OWN = f"::{MODEL}"


@dataclass(frozen=True)
class ModelScope:
    """The names of a model: what stands before those inside it, its own frame, the version of its
    file, and its depth."""

    prefix: str
    frame: str
    version: tuple[int, int]
    depth: int = 0
    has_world: bool = False
    """Whether it has a link called world, which its joints then mean."""

    def named(self, name: str) -> str:
        """The name of the whole model that a name in this one means."""
        name = name.strip()
        if name in ("", MODEL):
            return self.frame
        if name == WORLD and not self.has_world:
            return WORLD
        return self.prefix + name.removesuffix(_OWN)


class NestedModels:
    """The models inside those of one file, made part of them. reader: of the file, which tells what
    is wrong."""

    def __init__(self, reader: Elements, packages: Packages):
        self.reader, self.packages = reader, packages
        self.roots = [*packages.readable]
        self.left = _ELEMENTS
        self.known: dict[Path, XmlElement] = {}

    def flattened(self, model: XmlElement, version: tuple[int, int]) -> XmlElement:
        """The model with those inside it as links, joints and frames of its own."""
        if not (model.all("model") or model.all("include")):
            return model
        scope = ModelScope("", MODEL, version, 0, _has_world(model))
        inside, canonical = self.contents(model, scope)
        inside += [child for child in model.children if child.tag == "pose"]
        attributes = {**model.attributes, "canonical_link": canonical}
        if "placement_frame" in attributes:
            attributes["placement_frame"] = scope.named(attributes["placement_frame"])
        return replace(model, children=inside, attributes=attributes)

    def contents(self, model: XmlElement, scope: ModelScope) -> tuple[list[XmlElement], str]:
        """The elements of a model, by names of the whole one, and its canonical link."""
        found: list[XmlElement] = []
        inner = ""
        self.reader.one(model, "pose", f"model {model.name()!r}")
        for child in model.children:
            self.left -= 1
            if self.left < 0:
                self.reader.refuse(child, f"nested models have more than {_ELEMENTS} elements.")
            if child.tag in ("model", "include"):
                elements, canonical = self.nested(child, scope)
                found += elements
                inner = inner or canonical
            elif child.tag in _WRITTEN:
                found.append(_WRITTEN[child.tag](child, scope))
            elif child.tag != "pose":
                found.append(child)
        links = [scope.prefix + link.name() for link in model.all("link")]
        given = model.attributes.get("canonical_link", "")
        return found, scope.named(given) if given.strip() else next(iter(links), inner)

    def nested(self, element: XmlElement, outer: ModelScope) -> tuple[list[XmlElement], str]:
        """A model inside another one: the frame that it is, and all that is in it."""
        merged = element.attributes.get("merge", "").strip() in ("true", "1")
        version, model = outer.version, element
        if element.tag == "include":
            model, version = self.included(element)
        name = self.reader.text(model, "name", "a model inside a model")
        if (version < AXES_IN_JOINTS) != (outer.version < AXES_IN_JOINTS):
            self.reader.refuse(
                element,
                f"model {name!r} is of another version than the file around it, and up to 1.4 axes "
                f"are given otherwise; bring both to one.",
            )
        if outer.depth >= _DEEPEST:
            self.reader.refuse(element, f"models are nested more than {_DEEPEST} deep.")
        if any(x.content in ("1", "true") for x in model.all("static")):
            self.reader.refuse(
                element, f"model {name!r} inside a model is static; fix it by a joint to the world."
            )
        frame = outer.prefix + (f"_merged__{name}{MODEL}" if merged else name)
        prefix = outer.prefix if merged else f"{frame}::"
        scope = ModelScope(prefix, frame, version, outer.depth + 1, _has_world(model))
        inside, canonical = self.contents(model, scope)
        if not canonical:
            self.reader.refuse(element, f"model {name!r} inside a model has no links.")
        attributes = {"name": frame, "attached_to": canonical}
        if "placement_frame" in model.attributes:
            attributes["placement_frame"] = scope.named(model.attributes["placement_frame"])
        pose = next(iter(model.all("pose")), XmlElement("pose", {}, model.line))
        return [
            replace(model, tag="frame", attributes=attributes, children=[_placed(pose, outer)]),
            *inside,
        ], canonical

    # ------------------------------------------------------------ included files
    def included(self, element: XmlElement) -> tuple[XmlElement, tuple[int, int]]:
        """The model of an included file, with the name and pose that it is included with, and the
        version of that file."""
        uri = self.reader.one(element, "uri", "<include>")
        if uri is None or not uri.content:
            self.reader.refuse(element, "<include> has no <uri>; name a file or folder in it.")
        path = self.located(uri)
        if path not in self.known:
            try:
                root = parse(os.fspath(path), read_file.read(path), TEXT)
            except FileError as problem:
                line = IncludedLine(problem.path, problem.line) if problem.line else element.line
                raise FileError(self.reader.file, line, problem.problem) from None
            self.known[path] = _lined(root)
        root = self.known[path]
        models = root.all("model")
        if root.tag != "sdf" or len(models) != 1:
            told = f"{shown(uri.content)} is included, and no <sdf> with one <model>."
            self.reader.refuse(element, told)
        (model,) = models
        attributes, children = dict(model.attributes), list(model.children)
        for tag in ("name", "placement_frame"):
            given = self.reader.one(element, tag, "<include>")
            if given is not None:
                attributes[tag] = given.content
        for tag in ("pose", "static"):
            given = self.reader.one(element, tag, "<include>")
            if given is not None:
                children = [child for child in children if child.tag != tag] + [given]
        version = read_version(self.reader, root)
        return replace(model, attributes=attributes, children=children), version

    def included_in_world(self, element: XmlElement) -> tuple[XmlElement, tuple[int, int]] | None:
        """The model that a world includes, and the version of its file; None, with a notice, of
        scenery that is not there."""
        uri = next(iter(element.all("uri")), element)
        scheme, _, rest = uri.content.partition("://")
        name = rest.partition("/")[0]
        if scheme in ("model", "package") and self.packages.find(name) is None:
            told = (
                f"warning: {shown(uri.content)}, which the world includes, was not found: left out."
            )
            self.reader.notice("ignored", element, told)
            return None
        return self.included(element)

    def located(self, uri: XmlElement) -> Path:
        """The file that an include names, below the packages."""
        scheme, colon, rest = uri.content.partition("://")
        folder = Path(os.path.dirname(uri.file or self.reader.file))
        if colon and scheme in ("model", "package"):
            name, _, inside = rest.partition("/")
            found = self.packages.find(name)
            if found is None:
                self.reader.refuse(uri, f"package {shown(name)} was not found; {_NAME_IT}")
            self.roots.append(found)
            path = found / inside
        elif colon and scheme != "file":
            self.reader.refuse(uri, f"{shown(uri.content)} is not read: get it, and name its file.")
        else:
            path = folder / (rest if colon else uri.content)
        real = Path(os.path.realpath(path))
        if not any(real.is_relative_to(os.path.realpath(root)) for root in self.roots):
            told = f"{shown(uri.content)} lies outside the file's package and is not read; "
            self.reader.refuse(uri, told + _NAME_IT)
        return next(_files_of(real), real / "model.sdf") if real.is_dir() else real


_NAME_IT = "name its folder with package_path= (--package-path, or FREEBODY_PACKAGE_PATH)."


def read_version(reader: Elements, root: XmlElement) -> tuple[int, int]:
    """The version of an SDF file, 1.6 where it gives none."""
    given = root.attributes.get("version", "1.6").strip()
    found = _VERSION.fullmatch(given)
    if found is None:
        reader.refuse(root, f"the version is {shown(given)}, expected one such as 1.7.")
    return int(found[1]), int(found[2])


def _files_of(folder: Path) -> Iterator[Path]:
    """The SDF files of a model's folder: those that its model.config names, the last first, then
    the usual one."""
    try:
        config = parse("", read_file.read(folder / "model.config"), TEXT)
    except FileError:
        config = XmlElement("model", {}, 0)
    for named in reversed(config.all("sdf")):
        if Path(named.content).name == named.content and (folder / named.content).is_file():
            yield folder / named.content


def _lined(element: XmlElement) -> XmlElement:
    """An element of another file, whose lines say so."""
    line = (
        element.line
        if isinstance(element.line, IncludedLine)
        else (IncludedLine(element.file, element.line))
    )
    return replace(element, line=line, children=[_lined(child) for child in element.children])


def _has_world(model: XmlElement) -> bool:
    return any(link.name() == WORLD for link in model.all("link"))


# ---------------------------------------------------------------- elements by names of the whole
def _placed(pose: XmlElement, scope: ModelScope) -> XmlElement:
    """A pose that is relative to the model where it does not say to what."""
    base = pose.attributes.get("relative_to", "")
    return replace(pose, attributes={**pose.attributes, "relative_to": scope.named(base)})


def _posed(child: XmlElement, scope: ModelScope) -> XmlElement:
    """A pose inside that is relative to something else by itself, or to what it says."""
    if child.tag == "pose" and child.attributes.get("relative_to", "").strip():
        return _placed(child, scope)
    return child


def _link(element: XmlElement, scope: ModelScope) -> XmlElement:
    poses = element.all("pose") or [XmlElement("pose", {}, element.line)]
    others = [_shaped(child, scope) for child in element.children if child.tag != "pose"]
    placed = [_placed(pose, scope) for pose in poses]
    return _called(element, scope, [*placed, *others])


def _shaped(child: XmlElement, scope: ModelScope) -> XmlElement:
    """An element of a link, a shape's pose by names of the whole model."""
    if child.tag not in ("visual", "collision"):
        return child
    return replace(child, children=[_posed(inner, scope) for inner in child.children])


def _frame(element: XmlElement, scope: ModelScope) -> XmlElement:
    found = _called(element, scope, [_posed(child, scope) for child in element.children])
    found.attributes["attached_to"] = scope.named(element.attributes.get("attached_to", ""))
    return found


def _joint(element: XmlElement, scope: ModelScope) -> XmlElement:
    children = []
    for child in element.children:
        if child.tag in ("parent", "child", "gearbox_reference_body"):
            content = scope.named(child.content) if child.content else ""
            child = replace(child, content=content)
        elif child.tag in ("axis", "axis2"):
            child = replace(child, children=[_of_axis(x, child, scope) for x in child.children])
        children.append(_posed(child, scope))
    return _called(element, scope, children)


def _of_axis(child: XmlElement, axis: XmlElement, scope: ModelScope) -> XmlElement:
    """An element inside a joint's <axis>, with the names in it as the whole model has them."""
    attributes = dict(child.attributes)
    if child.tag == "xyz":
        given = attributes.get("expressed_in", "").strip()
        flag = any(x.content in ("1", "true") for x in axis.all("use_parent_model_frame"))
        if given or flag or scope.version < AXES_IN_JOINTS:
            attributes["expressed_in"] = scope.named(given)
    elif child.tag == "mimic" and attributes.get("joint", "").strip():
        attributes["joint"] = scope.named(attributes["joint"])
    return replace(child, attributes=attributes)


def _called(element: XmlElement, scope: ModelScope, children: list[XmlElement]) -> XmlElement:
    name = element.name()
    attributes = {**element.attributes, "name": scope.prefix + name if name else ""}
    return replace(element, attributes=attributes, children=children)


_WRITTEN = {"link": _link, "frame": _frame, "joint": _joint}
"""Functions that write an element by names of the whole model, by tag."""
