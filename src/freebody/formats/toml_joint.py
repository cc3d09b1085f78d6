"""Joints in TOML: kind, axis, limits, drive, mimic."""

from __future__ import annotations

from freebody.formats.toml_placement import PLACE, direction, placement
from freebody.formats.toml_table import TomlTable
from freebody.model.description import INFINITE, Drive, Joint, Limits, Mimic
from freebody.model.joints import KINDS

DRIVE = ("friction", "rotor", "spring")
_OWN = tuple(number.name for kind in KINDS.values() for number in kind.numbers)


def joint(table: TomlTable, dim: int) -> Joint:
    """[[joint]]"""
    table = table.called(f"joint {table.text('name')!r}")
    table.only(
        *("name", "kind", "parent", "child", *PLACE, "axis", *_OWN),
        *("limits", *DRIVE, "mimic", "passive"),
    )
    kind = table.choice("kind", KINDS)
    one = KINDS[kind].nv == 1
    own = [number.name for number in KINDS[kind].numbers]
    taken = {
        "axis": KINDS[kind].needs_axis,
        "limits": one,
        **dict.fromkeys(DRIVE, one),
        **{name: name in own for name in _OWN},
        "mimic": one,
    }
    if unused := [key for key, has_it in taken.items() if key in table and not has_it]:
        table.refuse(f"a {kind} joint has no {unused[0]}; remove it.", unused[0])
    if table.flag("passive") and (KINDS[kind].nv == 0 or "mimic" in table):
        reason = (
            "has nothing to drive"
            if KINDS[kind].nv == 0
            else "follows another, which may be passive"
        )
        table.refuse(f"passive: the joint {reason}; remove it.", "passive")
    return Joint(
        table.text("name"),
        kind,
        table.text("parent"),
        table.text("child"),
        placement(table, dim),
        _axis(table, kind, dim) if KINDS[kind].needs_axis else (),
        limits(table, angles=not KINDS[kind].slides),
        drive(table),
        _mimic(table),
        table.line,
        table.flag("passive"),
        tuple(map(table.quantity, own)),
    )


def _axis(table: TomlTable, kind: str, dim: int) -> tuple[float, ...]:
    """A vector, or "x", "-z"; in the plane a revolute joint's is 1 (counterclockwise) or -1."""
    if KINDS[kind].axis_size(dim) == 1:
        return (table.number("axis", default=1.0),)
    return direction(table, dim)


def limits(table: TomlTable, angles: bool) -> Limits:
    """limits = { lower, upper, velocity, effort }; angles: of an angle, not a length."""
    inner = table.table("limits")
    return limits_of(inner.called(f"{table.where}, limits"), angles) if inner else Limits()


def limits_of(table: TomlTable, angles: bool) -> Limits:
    """The same from its own table."""
    table.only("lower", "upper", "velocity", "effort")
    angle, rate = ("angle", "rate") if angles else ("number", "number")
    return Limits(
        table.number("lower", angle, -INFINITE, infinite=True),
        table.number("upper", angle, INFINITE, infinite=True),
        table.number("velocity", rate, INFINITE, infinite=True),
        table.number("effort", "number", INFINITE, infinite=True),
    )


def drive(table: TomlTable) -> Drive:
    """friction, rotor and spring."""

    def part(key: str, *known: str) -> TomlTable | None:
        inner = table.table(key)
        return inner.called(f"{table.where}, {key}").only(*known) if inner else None

    friction, rotor = part("friction", "viscous", "coulomb"), part("rotor", "inertia", "gear")
    spring = part("spring", "stiffness", "rest")
    return Drive(
        viscous=friction.quantity("viscous", default=0.0) if friction else 0.0,
        coulomb=friction.quantity("coulomb", default=0.0) if friction else 0.0,
        rotor=rotor.quantity("inertia") if rotor else 0.0,
        gear=rotor.quantity("gear", default=1.0) if rotor else 1.0,
        stiffness=spring.quantity("stiffness") if spring else 0.0,
        rest=spring.quantity("rest", "angle", 0.0) if spring else 0.0,
    )


def _mimic(table: TomlTable) -> Mimic | None:
    inner = table.table("mimic")
    if inner is None:
        return None
    inner = inner.called(f"{table.where}, mimic").only("joint", "ratio", "offset")
    return Mimic(
        inner.text("joint"),
        inner.number("ratio", default=1.0),
        inner.number("offset", "angle", 0.0),
    )
