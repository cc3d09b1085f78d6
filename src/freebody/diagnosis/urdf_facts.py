"""Facts of a URDF, and of an expanded xacro file, from its elements."""

from __future__ import annotations

from freebody.diagnosis.facts import FRICTIONS, InertiaFacts, JointFacts, LinkFacts, Written
from freebody.errors import FreebodyError
from freebody.formats import read_file
from freebody.formats.urdf import TYPES, shapes_of
from freebody.formats.urdf_elements import XmlElement
from freebody.model.inertia import Inertia
from freebody.model.placement import Placement, rpy, shift

TENSOR = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
_LIMITS = ("lower", "upper", "velocity", "effort")
_SNAP = 3e-9


def links_and_joints(
    root: XmlElement,
) -> tuple[tuple[LinkFacts, ...], tuple[JointFacts, ...]]:
    """The links and joints of a <robot>."""
    return tuple(map(_link, root.all("link"))), tuple(map(_joint, root.all("joint")))


def written(element: XmlElement, attribute: str) -> Written:
    """The number in an attribute, None where it is none that can be used."""
    text = element.attributes.get(attribute, "").strip()
    value = read_file.number(text)
    usable = value is not None and not read_file.fault(value, infinite=True)
    return Written(value if usable else None, element, attribute, text)


def vector(element: XmlElement | None, attribute: str) -> tuple[float, float, float] | None:
    """Three numbers, zeros where the attribute is absent; None where they are not to be read."""
    words = (element.attributes if element else {}).get(attribute, "0 0 0").split()
    values = [x for x in map(read_file.number, words) if x is not None and not read_file.fault(x)]
    return (values[0], values[1], values[2]) if len(values) == len(words) == 3 else None


def first(element: XmlElement, tag: str) -> XmlElement | None:
    """The first element of the given tag inside an element; None where there is none."""
    return next(iter(element.all(tag)), None)


def _link(element: XmlElement) -> LinkFacts:
    inertial = first(element, "inertial")
    return LinkFacts(
        element.name(),
        element.line,
        None if inertial is None else _inertial(inertial),
        shapes_of(element),
        element,
    )


def _inertial(element: XmlElement) -> InertiaFacts:
    mass, tensor, placement = (
        first(element, "mass"),
        first(element, "inertia"),
        _placement(first(element, "origin")),
    )
    inertia = None
    if mass is not None and tensor is not None and placement is not None:
        kilograms = written(mass, "value").value
        entries = [written(tensor, key).value for key in TENSOR]
        known = [x for x in entries if x is not None]
        try:
            if kilograms is not None and len(known) == len(TENSOR):
                inertia = Inertia(kilograms, (0.0, 0.0, 0.0), tuple(known))
        except FreebodyError:  # beyond any robot's numbers
            inertia = None
    return InertiaFacts(inertia, placement or Placement(), element.line, element)


def _placement(origin: XmlElement | None) -> Placement | None:
    xyz, angles = vector(origin, "xyz"), vector(origin, "rpy")
    if xyz is None or angles is None:
        return None
    return shift(*xyz).then(rpy(*angles, snap=_SNAP))


def _joint(element: XmlElement) -> JointFacts:
    ends = [first(element, tag) for tag in ("parent", "child")]
    parent, child = (end.attributes.get("link", "").strip() if end else "" for end in ends)
    kind = element.attributes.get("type", "").strip()
    axis, limit, dynamics, mimic = (
        first(element, tag) for tag in ("axis", "limit", "dynamics", "mimic")
    )
    placement = _placement(first(element, "origin"))
    return JointFacts(
        element.name(),
        TYPES.get(kind, kind),
        parent,
        child,
        element.line,
        None if placement is None else placement.arrays(),
        None if axis is None else vector(axis, "xyz"),
        {key: written(limit, key) for key in _LIMITS if limit and key in limit.attributes},
        {
            key: written(dynamics, key)
            for key in FRICTIONS
            if dynamics and key in dynamics.attributes
        },
        mimic.attributes.get("joint", "").strip() if mimic else "",
        element,
        (limit or element).line,
    )
