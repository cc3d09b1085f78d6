"""Drawing data of an interactive page's bodies: joints and ends, named forces, vectors in world
axes; and what the moving drawing takes over from the figure."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from freebody.algorithms.kinematics import frame_pose
from freebody.expressions import expression as ex
from freebody.expressions.expression import Expression
from freebody.expressions.naming import Naming
from freebody.model.tree import TreeBody
from freebody.spatial import add, product, times
from freebody_textbook.living.body_quantities import vector
from freebody_textbook.living.closed_chain import ClosedChain
from freebody_textbook.living.kernel import PageProgram
from freebody_textbook.methods.setting import LOADS, Setting

FEW = 4
"""Bodies up to which all are drawn alone."""


class DrawnBodies:
    """A robot's bodies as drawing data, from their quantities; closed: the loops; labels: of the
    figure."""

    def __init__(
        self,
        kernel: PageProgram,
        values: Mapping[str, Any],
        naming: Naming,
        setting: Setting,
        closed: ClosedChain | None,
        labels: Labels,
    ):
        self.kernel, self.values, self.naming, self.s = kernel, values, naming, setting
        self.tree, self.closed, self.labels = setting.tree, closed, labels

    def all(self) -> list[dict[str, Any]]:
        """Drawing data of all bodies."""
        return [self._body(n) for n in range(1, len(self.naming.model.bodies) + 1)]

    def _body(self, n: int) -> dict[str, Any]:
        naming, places = self.naming, self.kernel.places
        stands, link, kind = self._stands_alone(n), self._is_link(n), naming.body(n).kind
        drawn = {
            "joint": places(self.values[f"r{n}"]), "from": places(self._start(n)),
            "centre": places(self.values[f"rc{n}"]), "ends": list(map(places, self._ends(n))),
            "parent": naming.parent(n) - 1, "slides": kind.slides, "mark": kind.mark,
            "heavy": bool(self._own(n).masses), "alone": stands, "link": link,
            "held": not self._is_link(naming.parent(n)), "holds": kind.holds,
            "pins": self._pins(n),
            "forces": self._forces(n) if stands else [],
            "moments": self._moments(n) if stands else [],
            "names": {
                what: self.labels.number(formula)
                for what, formula in self.labels.figure.bodies[n - 1].items()
                if formula and not link
            },
        }  # fmt: skip
        if kind.needs_axis and not link and len(self._own(n).axis) == naming.model.dim:
            drawn["axis"] = places(self._axis(n))
        if naming.planar and kind.turns:
            drawn |= {"zero": places(self._zero(n)), "along": places(self._along(n))}
        return drawn | ({"solids": self._solids(n)} if naming.model.dim == 3 and not link else {})

    def _start(self, n: int) -> Any:
        """The point where the slide of joint n begins."""
        own = self._first(n)
        return self._placed(own.parent, own.p)

    def _placed(self, body: int, p: Any) -> Any:
        """World position of a point of a tree body (-1: the base)."""
        if body < 0:
            return vector(self.s, p)
        R, origin = self.s.world[body]
        return vector(self.s, add(origin, times(R, p)))

    def _carrier(self, n: int) -> Any:
        """The axes of joint n on the preceding body, in world axes."""
        own = self._first(n)
        return own.R if own.parent < 0 else product(self.s.world[own.parent][0], own.R)

    def _zero(self, n: int) -> Any:
        """The direction in which the angle of joint n is 0: along the preceding body, or as defined
        by the notation."""
        notation, above, first = self.naming.letters.notation, self.naming.parent(n), n
        while above:
            first = above if self.naming.body(above).kind.turns else first
            above = self.naming.parent(above)
        (x, _), (y, _) = self._carrier(first if notation.absolute else n)
        for _ in range(notation.quarter_turns % 4 if notation.absolute or first == n else 0):
            x, y = y * -1, x
        return vector(self.s, (x, y))

    def _along(self, n: int) -> Any:
        """Direction of the x axis of body n."""
        return vector(self.s, [row[0] for row in self.s.world[self.tree.body_of[n - 1]][0]])

    def _solids(self, n: int) -> list[dict[str, Any]]:
        """Solids that form a joint's symbol in space."""
        kind, turned = self.naming.body(n).kind, self.s.world[self.tree.body_of[n - 1]][0]
        made = []
        for part in kind.solids:
            axes = turned if part.moves else self._carrier(n)
            way = [row["xyz".find(part.along)] for row in axes]
            way = self._axis(n) if part.along == "axis" else vector(self.s, way)
            place = self.values[f"r{n}"] if part.moves else self._start(n)
            made.append(
                {"at": self.kernel.places(place), "axis": self.kernel.places(way),
                 "size": [part.radius, part.half, part.sides]}
            )  # fmt: skip
        return made

    def _is_link(self, n: int) -> bool:
        """Whether body n is only a massless connection between consecutive joints."""
        return bool(self.closed and n and self.tree.body_of[n - 1] in self.closed.s.links)

    def _stands_alone(self, n: int) -> bool:
        """Whether body n gets a free-body drawing; in robots with many bodies only those with mass
        do."""
        few = len(self.naming.model.bodies) <= FEW
        return not self._is_link(n) and (few or bool(self._own(n).masses))

    def _ends(self, n: int) -> list[Any]:
        """The points to which body n extends: further joints and frames."""
        return [
            self._start(end) if isinstance(end, int) else self._frame(end)
            for end in self.labels.figure.ends[n - 1]
        ]

    def _frame(self, name: str) -> Any:
        return vector(self.s, frame_pose(self.tree, self.s.world, name)[1])

    def _pins(self, n: int) -> list[list[int]]:
        """The points of body n where loops end."""
        return [
            self.kernel.places(end.place) for end in (self.closed.ends(n) if self.closed else ())
        ]

    def tip(self) -> list[int]:
        """Output places of the tip's coordinates; empty if there is no tip."""
        return self.kernel.places(self.values["r"]) if "r" in self.values else []

    def points(self) -> list[dict[str, Any]]:
        """Drawing data of further point frames, with names."""
        return [
            {"at": self.kernel.places(self._frame(frame)), "name": self.labels.number(name)}
            for frame, name in self.labels.figure.points.items()
        ]

    @property
    def _tip(self) -> int:
        model = self.naming.model
        return model.frame().body + 1 if model.tip is not None else 0

    # ------------------------------------------------------------ what acts
    def _forces(self, n: int) -> list[dict[str, Any]]:
        naming, values = self.naming, self.values
        made = [self._reaction(n, 1), *(self._reaction(k, -1) for k in naming.children(n))]
        for end in self.closed.ends(n) if self.closed else ():
            made.append(
                self._acting(
                    "reaction",
                    end.place,
                    end.force,
                    end.sign,
                    self.labels.of(end.names[0], end.sign),
                )
            )
        weight = tuple(values[f"m{n}"] * g for g in values["gravity"])
        made.append(self._acting("weight", values[f"rc{n}"], weight, 1, self._weight(n)))
        if n == self._tip and "fx" in values:
            load = tuple(values[name] for name in LOADS[naming.model.dim])
            made.append(self._acting("external", values["r"], load, 1, self.labels.number("*f*")))
        return made

    def _weight(self, n: int) -> int:
        return self.labels.number(f"{self.labels.figure.formula(self.naming.mass(n))} *g*")

    def _reaction(self, n: int, sign: int) -> dict[str, Any]:
        name = self.naming.force(self.naming.parent(n), n)
        force = self._in_world(n, self.values[name.name])
        return self._acting(
            "reaction", self.values[f"r{n}"], force, sign, self.labels.of(name, sign)
        )

    def _moments(self, n: int) -> list[dict[str, Any]]:
        made = [self._moment(n, 1), *(self._moment(k, -1) for k in self.naming.children(n))]
        for end in self.closed.ends(n) if self.closed else ():
            if end.moment is not None:
                made.append(
                    self._acting(
                        "moment",
                        end.place,
                        end.moment,
                        end.sign,
                        self.labels.of(end.names[1], end.sign),
                    )
                )
        return made

    def _moment(self, n: int, sign: int) -> dict[str, Any]:
        """Drawing data of the moment at joint n; for a pin without motor, the moment that the state
        would require. It is not called τ if τ is the moment on a body."""
        naming = self.naming
        name = naming.joint_moment(n)
        if name == ex.ZERO or self.s.symbols.turned:
            name = naming.moment(naming.parent(n), n)
        moment = self.values[f"M{n}" if naming.planar else f"n{n}"]
        place = self.values[f"r{n}"]
        return self._acting(
            "moment", place, self._in_world(n, moment), sign, self.labels.of(name, sign)
        )

    def _acting(self, kind: str, place: Any, vector: Any, sign: int, name: int) -> dict[str, Any]:
        return {
            "kind": kind, "at": self.kernel.places(place), "is": self.kernel.places(vector),
            "sign": sign, "name": name,
        }  # fmt: skip

    # ------------------------------------------------------------ axes
    def _in_world(self, n: int, vector: Any) -> Any:
        return vector if self.naming.planar else times(self.values[f"R{n}"], vector)

    def _axis(self, n: int) -> Any:
        """Direction of the axis of joint n."""
        return vector(self.s, times(self.s.world[self.tree.body_of[n - 1]][0], self._own(n).axis))

    def _own(self, n: int) -> TreeBody:
        return self.tree.bodies[self.tree.body_of[n - 1]]

    def _first(self, n: int) -> TreeBody:
        """The first tree body of a joint that consists of several single joints."""
        before = (k for k in self.tree.body_of if k < self.tree.body_of[n - 1])
        return self.tree.bodies[1 + max(before, default=-1)]


@dataclass(frozen=True)
class PageFigure:
    """A derivation's first figure as data for its page."""

    bodies: Sequence[Mapping[str, str]]
    """The formulas of each body by what they name, such as C its centre of mass."""
    ends: Sequence[Sequence[int | str]]
    """The ends of each body: numbers of bodies that hang on it, and names of frames."""
    tip: str
    """The name of the tip."""
    points: Mapping[str, str]
    """Names of further frames that are points."""
    rods: Sequence[str]
    """The length of each loop's rod, or ""."""
    start: Mapping[str, float]
    """Values of the symbols at the start."""
    view: tuple[float, float]
    """Azimuth and elevation of the viewer of a robot in space, degrees."""
    rule: Mapping[str, Any]
    """The rule by which labels find their places."""
    formula: Callable[[Expression], str]
    """A name as a formula."""
    typeset: Callable[[str], str]
    """A formula as pieces of an SVG text."""


@dataclass(frozen=True)
class Labels:
    """The formulas used as labels on a page, each stored once and numbered."""

    figure: PageFigure
    numbers: dict[str, int] = field(default_factory=dict)

    def number(self, formula: str) -> int:
        """The number of a label formula; -1 for an empty one."""
        return self.numbers.setdefault(formula, len(self.numbers)) if formula else -1

    def of(self, name: Expression, sign: int = 1) -> int:
        """The number of a name's label, with a sign."""
        return self.number("−" * (sign < 0) + self.figure.formula(name))

    def template(self) -> str:
        """All label formulas as HTML, to be copied by the page."""
        texts = (f"<text>{self.figure.typeset(formula)}</text>" for formula in self.numbers)
        return f'<template id="names"><svg>{"".join(texts)}</svg></template>'
