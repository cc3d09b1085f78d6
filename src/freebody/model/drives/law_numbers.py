"""The attributes of `Drive` for type checkers and editors: at run time they come from the laws, and
a test compares the two."""

from __future__ import annotations

from freebody.model.parameters import Quantity


class LawNumbers:
    """One attribute for each number of a drive law; each may also be the name of a symbol."""

    viscous: Quantity = 0.0
    coulomb: Quantity = 0.0
    rotor: Quantity = 0.0
    gear: Quantity = 1.0
    stiffness: Quantity = 0.0
    rest: Quantity = 0.0
    stribeck: Quantity = 0.0
    stribeck_speed: Quantity = 0.0
    offset: Quantity = 0.0
    asymmetric: Quantity = 0.0
    quadratic: Quantity = 0.0
    cube_root: Quantity = 0.0
    saturating: Quantity = 0.0
    saturating_speed: Quantity = 0.0
    hardening: Quantity = 0.0
    hardening_rest: Quantity = 0.0
    cogging: Quantity = 0.0
    cogging_count: Quantity = 0.0
    cogging_phase: Quantity = 0.0
    load_friction: Quantity = 0.0
    efficiency: Quantity = 0.0
    back_efficiency: Quantity = 0.0

    def __init__(
        self,
        viscous: Quantity | str = 0.0,
        coulomb: Quantity | str = 0.0,
        rotor: Quantity | str = 0.0,
        gear: Quantity | str = 1.0,
        stiffness: Quantity | str = 0.0,
        rest: Quantity | str = 0.0,
        stribeck: Quantity | str = 0.0,
        stribeck_speed: Quantity | str = 0.0,
        offset: Quantity | str = 0.0,
        asymmetric: Quantity | str = 0.0,
        quadratic: Quantity | str = 0.0,
        cube_root: Quantity | str = 0.0,
        saturating: Quantity | str = 0.0,
        saturating_speed: Quantity | str = 0.0,
        hardening: Quantity | str = 0.0,
        hardening_rest: Quantity | str = 0.0,
        cogging: Quantity | str = 0.0,
        cogging_count: Quantity | str = 0.0,
        cogging_phase: Quantity | str = 0.0,
        load_friction: Quantity | str = 0.0,
        efficiency: Quantity | str = 0.0,
        back_efficiency: Quantity | str = 0.0,
    ) -> None: ...
