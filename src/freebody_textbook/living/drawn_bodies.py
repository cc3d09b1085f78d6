"""Drawing data of an interactive page's bodies: joints and ends, named forces, vectors in world
axes; and what the moving drawing takes over from the figure."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from freebody.expressions import expression as ex
from freebody.expressions.expression import Expression
from freebody.expressions.naming import Naming
from freebody.figures.skeleton import BodyPlace, Skeleton, extent
from freebody.figures.view import View
from freebody.model.tree import TreeBody
from freebody.moving.fitted_solids import Anchors, FittedSolids
from freebody.moving.scene import LabelTexts, Scene, axis_names, box_of, grounds
from freebody.spatial import times
from freebody_textbook.living.closed_chain import ClosedChain
from freebody_textbook.living.page_frames import PageFrames
from freebody_textbook.living.page_program import PageProgram
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
        self.frames = PageFrames(kernel, setting, naming.model, setting.tree.body_of)

    def all(self) -> list[dict[str, Any]]:
        """Drawing data of all bodies."""
        return [self._body(place) for place in self.labels.figure.pose.bodies]

    def _body(self, place: BodyPlace) -> dict[str, Any]:
        n, at = place.number, self.frames
        stands, link, kind = self._stands_alone(n), self._is_link(n), place.kind
        joint = at.origin(place)
        drawn = {
            "joint": joint.place().data, "from": at.carrier(place).place().data,
            "centre": at.end(place, None).place().data,
            "ends": [at.end(place, end).place().data for end in place.ends],
            "parent": self.naming.parent(n) - 1, "slides": kind.slides,
            "heavy": bool(self._own(n).masses), "alone": stands, "link": link,
            "forces": self._forces(n) if stands else [],
            "moments": self._moments(n) if stands else [],
            "names": {
                what: self.labels.number(formula)
                for what, formula in self.labels.figure.bodies[n - 1].items()
                if formula and not link
            },
        }  # fmt: skip
        if place.axis is not None and not link:
            drawn["axis"] = joint.way(place.axis).data
        if self.naming.planar and kind.turns:
            drawn |= {"zero": self._zero(place), "along": [joint.frame, 1.0, 0.0, 0.0]}
        return drawn

    def _zero(self, place: BodyPlace) -> list[float]:
        """The direction in which the angle of a joint is 0: along the preceding body, or as defined
        by the notation."""
        bodies, notation = self.labels.figure.pose.bodies, self.naming.letters.notation
        above, first = place.parent, place
        while above >= 0:
            first = bodies[above] if bodies[above].kind.turns else first
            above = bodies[above].parent
        carrier = self.frames.carrier(first if notation.absolute else place)
        turns = notation.quarter_turns if notation.absolute or first is place else 0
        return [carrier.frame, *((1, 0), (0, 1), (-1, 0), (0, -1))[turns % 4], 0]

    def _is_link(self, n: int) -> bool:
        """Whether body n is only a massless connection between consecutive joints."""
        return bool(self.closed and n and self.tree.body_of[n - 1] in self.closed.s.links)

    def _stands_alone(self, n: int) -> bool:
        """Whether body n gets a free-body drawing; in robots with many bodies only those with mass
        do."""
        few = len(self.naming.model.bodies) <= FEW
        return not self._is_link(n) and (few or bool(self._own(n).masses))

    def tip(self) -> list[float]:
        """The place of the tip; empty if there is none."""
        return self.frames.point(self.values["r"]) if "r" in self.values else []

    def points(self) -> list[dict[str, Any]]:
        """Drawing data of further point frames, with names."""
        return [
            {"at": self.frames.named(frame).place().data, "name": self.labels.number(name)}
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
            "kind": kind, "at": self.frames.point(place), "is": self.kernel.places(vector),
            "sign": sign, "name": name,
        }  # fmt: skip

    # ------------------------------------------------------------ axes
    def _in_world(self, n: int, vector: Any) -> Any:
        return vector if self.naming.planar else times(self.values[f"R{n}"], vector)

    def _own(self, n: int) -> TreeBody:
        return self.tree.bodies[self.tree.body_of[n - 1]]


@dataclass(frozen=True)
class PageFigure:
    """A derivation's first figure as data for its page."""

    bodies: Sequence[Mapping[str, str]]
    """The formulas of each body by what they name, such as C its centre of mass."""
    tip: str
    """The name of the tip."""
    points: Mapping[str, str]
    """Names of further frames that are points."""
    rods: Sequence[str]
    """The length of each loop's rod, or ""."""
    start: Mapping[str, float]
    """Values of the symbols at the start."""
    view: View
    pose: Skeleton
    """The places of its bodies at the start."""
    links: Collection[int]
    """Indices of bodies that stand for nothing real, which are not drawn."""
    formula: Callable[[Expression], str]
    """A name as a formula."""

    @property
    def size(self) -> float:
        """Diagonal of the box around the robot, m."""
        return extent([self.pose])

    def scene(self, anchors: Anchors, texts: LabelTexts) -> Scene:
        """The scene in which the figure moves: without a floor."""
        size, pose = self.size, self.pose
        return Scene(
            pose.dim,
            tuple(FittedSolids(pose, size, anchors, self.links).all()),
            box_of([pose], 0.0),
            size,
            self.view,
            texts,
            tuple(grounds(pose, anchors)),
            tuple(axis_names(pose.dim, size, anchors.base, texts)),
        )


@dataclass(frozen=True)
class Labels:
    """The formulas used as labels on a page, each stored once and numbered."""

    figure: PageFigure
    texts: LabelTexts = field(default_factory=LabelTexts)

    def number(self, formula: str) -> int:
        """The number of a label formula; -1 for an empty one."""
        return self.texts.number(formula)

    def of(self, name: Expression, sign: int = 1) -> int:
        """The number of a name's label, with a sign."""
        return self.number("−" * (sign < 0) + self.figure.formula(name))
