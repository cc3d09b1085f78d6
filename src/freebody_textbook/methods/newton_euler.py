"""Newton and Euler body by body: free-body diagrams, unknown reactions, elimination, closed form
(3.5-3.15).

n_{i,k} is the moment of body i on body k at joint k. A revolute joint's motor is the moment about
its axis (in the plane the whole moment), a prismatic one's the force along its axis; the other
components are bearing reactions.
"""

from __future__ import annotations

from collections.abc import Iterator

from freebody_textbook.derivation import Meaning
from freebody_textbook.methods import free_bodies, glossary, loop_free_bodies, recursive
from freebody_textbook.methods.body_by_body import FreeBodies
from freebody_textbook.methods.body_motion import motion
from freebody_textbook.methods.body_quantities import meanings
from freebody_textbook.methods.coupled_joints import shared_motors
from freebody_textbook.methods.cross_products import angles_between_arms
from freebody_textbook.methods.ending import ending
from freebody_textbook.methods.geometry import geometry
from freebody_textbook.methods.method import Method, MethodOption, Worked
from freebody_textbook.methods.moments_about_pivots import about_pivots, arms_of_pivots
from freebody_textbook.methods.reactions import SolvedReactions
from freebody_textbook.methods.setting import Setting


def work_out(setting: Setting, route: str) -> Worked:
    """The steps; route: moments of each body about its centre of mass, or of what hangs on a joint
    about its pivot. Of bodies that nothing holds: see `free_bodies`; of closed chains: see
    `loop_free_bodies`."""
    if free_bodies.are_free(setting.symbols.given or setting.symbols.model):
        return free_bodies.work_out(setting, route)
    if setting.tree.loops:
        return loop_free_bodies.work_out(setting, route)
    inward = tuple(reversed(setting.order))
    reactions = SolvedReactions(setting)
    tau = {i: reactions.motor(i) for i in setting.leaders}
    work = FreeBodies(setting, reactions, tau)
    about = about_pivots(setting, reactions.drives) if route == "pivot" else work.about_centres()
    torques = tuple(tau.values())
    symbols = list(_symbols(setting, route))
    if not recursive.is_readable(setting, torques):
        steps = [*about, *recursive.modular_steps(setting, "explicit")]
        more = [*recursive.symbols(setting), *meanings(setting, *["gravity{n}"] * setting.weighs)]
        symbols = list(dict.fromkeys([*symbols, *more]))
    else:
        moving = motion(setting)
        # about a fixed pivot only the turning counts
        steps = [
            *about,
            geometry(setting),
            *(moving[:1] if route == "pivot" and setting.cited == "R" else moving),
        ]
        if route == "centre":
            steps += angles_between_arms(setting)
        told = inward if route == "centre" else filter(setting.is_alone, inward)
        steps += [work.substituted(i, route == "centre") for i in told]
        steps += shared_motors(setting, reactions.drives, tau)
        steps += ending(setting)
    title = f"{METHOD.title}, moments about the pivots" if route == "pivot" else ""
    return Worked(tuple(steps), torques, symbols, title)


def _symbols(s: Setting, route: str) -> Iterator[Meaning]:
    yield from glossary.vectors(s)
    yield from meanings(s, "omega{n}", "vc{n}")
    if route == "pivot":
        yield from arms_of_pivots(s)
    else:
        yield from meanings(s, "f{h}{n}")
        yield from glossary.joint_moments(s)


METHOD = Method(
    "newton-euler",
    "Newton and Euler, body by body",
    "forces and moments on each body, the reactions eliminated",
    "lecture notes, chapter 3 and section 6.1",
    work_out,
    options=(
        MethodOption("route", ("centre", "pivot"), "moments about centres of mass or pivots"),
    ),
    closed=(2,),
    elsewhere="fb.inverse_dynamics and fb.reactions",
)
