"""What a page draws of each body: where its joint and its ends are, what acts on it and what that
is called; vectors in axes of the world."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from freebody.derivations.expressions import expression as ex
from freebody.derivations.living.body_quantities import vector
from freebody.derivations.living.closed_chain import ClosedChain
from freebody.derivations.living.kernel import PageProgram
from freebody.derivations.methods.method import LOADS
from freebody.derivations.methods.setting import Setting
from freebody.derivations.naming import Naming
from freebody.model.tree import TreeBody
from freebody.spatial import add, times

FEW = 4
"""Bodies up to which all are drawn alone."""


class DrawnBodies:
    """The bodies of a robot by their quantities; closed: what loops add."""

    def __init__(
        self,
        kernel: PageProgram,
        values: Mapping[str, Any],
        naming: Naming,
        setting: Setting,
        closed: ClosedChain | None,
    ):
        self.kernel, self.values, self.naming, self.s = kernel, values, naming, setting
        self.tree, self.closed = setting.tree, closed

    def all(self) -> list[dict[str, Any]]:
        """One after the other, as the script takes them."""
        return [self._body(n) for n in range(1, len(self.naming.model.bodies) + 1)]

    def _body(self, n: int) -> dict[str, Any]:
        naming, places = self.naming, self.kernel.places
        drawn = {
            "joint": places(self.values[f"r{n}"]), "centre": places(self.values[f"rc{n}"]),
            "ends": list(map(places, self._ends(n))), "parent": naming.parent(n) - 1,
            "slides": naming.body(n).kind.slides,
            "pins": self._pins(n), "alone": self._stands_alone(n), "link": self._is_link(n),
            "held": not self._is_link(naming.parent(n)),
            "forces": self._forces(n) if self._stands_alone(n) else [],
            "moments": self._moments(n) if self._stands_alone(n) else [],
        }  # fmt: skip
        drawn |= {"axis": places(self._axis(n))} if naming.model.dim == 3 else {}
        return drawn | ({"from": places(self._start(n))} if drawn["slides"] else {})

    def _start(self, n: int) -> Any:
        """Where the slide of joint n begins."""
        own = self._own(n)
        if own.parent < 0:
            return own.p
        R, p = self.s.world[own.parent]
        return vector(self.s, add(p, times(R, own.p)))

    def _is_link(self, n: int) -> bool:
        """Whether it stands for nothing, between joints in a row that hold nothing."""
        return bool(self.closed and n and self.tree.body_of[n - 1] in self.closed.s.links)

    def _stands_alone(self, n: int) -> bool:
        """Whether it is drawn with its forces; of robots of many bodies only those with mass."""
        few = len(self.naming.model.bodies) <= FEW
        return not self._is_link(n) and (few or bool(self._own(n).masses))

    def _ends(self, n: int) -> list[Any]:
        """Where it reaches to: further joints, loops, the tip; else its centre of mass."""
        ends = [self.values[f"r{k}"] for k in self.naming.children(n)]
        ends += [end.place for end in self.closed.ends(n)] if self.closed else []
        if not ends and n == self._tip and "r" in self.values:
            ends.append(self.values["r"])
        return ends or [self.values[f"rc{n}"]]

    def _pins(self, n: int) -> list[list[int]]:
        """Where loops end on it."""
        return [
            self.kernel.places(end.place) for end in (self.closed.ends(n) if self.closed else ())
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
            made.append(self._acting("reaction", end.place, end.force, end.sign, end.names[0]))
        weight = tuple(values[f"m{n}"] * g for g in values["gravity"])
        made.append(self._acting("weight", values[f"rc{n}"], weight, 1, f"{naming.mass(n)} g"))
        if n == self._tip and "fx" in values:
            load = tuple(values[name] for name in LOADS[naming.model.dim])
            made.append(self._acting("external", values["r"], load, 1, "f"))
        return made

    def _reaction(self, n: int, sign: int) -> dict[str, Any]:
        name = self.naming.force(self.naming.parent(n), n)
        force = self._in_world(n, self.values[name.name])
        return self._acting("reaction", self.values[f"r{n}"], force, sign, str(name))

    def _moments(self, n: int) -> list[dict[str, Any]]:
        made = [self._moment(n, 1), *(self._moment(k, -1) for k in self.naming.children(n))]
        for end in self.closed.ends(n) if self.closed else ():
            if end.moment is not None:
                made.append(self._acting("moment", end.place, end.moment, end.sign, end.names[1]))
        return made

    def _moment(self, n: int, sign: int) -> dict[str, Any]:
        """At a pin without motor the one that the state would need there; never called τ where that
        is what turns a body."""
        naming = self.naming
        name = naming.joint_moment(n)
        if name == ex.ZERO or self.s.symbols.turned:
            name = naming.moment(naming.parent(n), n)
        moment = self.values[f"M{n}" if naming.planar else f"n{n}"]
        place = self.values[f"r{n}"]
        return self._acting("moment", place, self._in_world(n, moment), sign, str(name))

    def _acting(self, kind: str, place: Any, vector: Any, sign: int, name: str) -> dict[str, Any]:
        return {
            "kind": kind, "at": self.kernel.places(place), "is": self.kernel.places(vector),
            "sign": sign, "name": "\u2212" * (sign < 0) + name,
        }  # fmt: skip

    # ------------------------------------------------------------ axes
    def _in_world(self, n: int, vector: Any) -> Any:
        return vector if self.naming.planar else times(self.values[f"R{n}"], vector)

    def _axis(self, n: int) -> Any:
        """The axis of joint n."""
        return self._in_world(n, self._own(n).axis)

    def _own(self, n: int) -> TreeBody:
        return self.tree.bodies[self.tree.body_of[n - 1]]
