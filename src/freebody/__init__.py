"""freebody: the dynamics of robotic manipulators, from a robot description to equations, numbers
and pictures.

This module is a table of contents: each name is imported from its place when it is first used.
"""

from __future__ import annotations

import sys
from types import ModuleType
from typing import Any

from freebody.locks import imported

__version__ = "0.2.0"

_PLACES = {
    "freebody.errors": (
        "FileError",
        "FreebodyError",
        "FreebodyWarning",
        "KindError",
        "LoopError",
        "MassWarning",
        "MissingArgumentError",
        "MissingPackageError",
        "MissingValueError",
        "ModelError",
        "NotFiniteError",
        "OutOfMemoryError",
        "OutputError",
        "PassiveJointError",
        "PhysicalWarning",
        "ShapeError",
        "SingularError",
        "UnknownNameError",
    ),
    "freebody.model.inertia": ("Inertia",),
    "freebody.model.integrated_inertia": ("inertia_from", "integrated_inertia"),
    "freebody.model.parameters": ("Parameter",),
    "freebody.model.named_numbers": ("parameters",),
    "freebody.model.description": ("Drive", "Limits"),
    "freebody.model.model": ("Model",),
    "freebody.model.planar_arms": ("planar",),
    "freebody.model.dh": ("dh",),
    "freebody.formats.loading": ("load",),
    "freebody.formats.saving": ("losses", "save"),
    "freebody.formats.templates": ("template",),
    "freebody.robots": ("models",),
    "freebody.diagnosis.doctor": ("doctor",),
    "freebody.diagnosis.same_robot": ("same_robot",),
    "freebody.trees.kinematics": (
        "forward_kinematics",
        "velocity",
        "acceleration",
        "jacobian",
        "jacobian_dot",
        "jacobian_derivatives",
        "center_of_mass",
    ),
    "freebody.trees.dynamics": (
        "inverse_dynamics_derivatives",
        "inverse_dynamics_second_derivatives",
        "forward_dynamics_derivatives",
        "mass_matrix",
        "mass_matrix_inverse",
        "coriolis_matrix",
        "bias",
        "gravity_torque",
        "tip_wrench",
        "kinetic_energy",
        "potential_energy",
        "strut_states",
        "momentum",
        "centroidal_momentum_matrix",
    ),
    "freebody.any_chain.dynamics": (
        "inverse_dynamics",
        "forward_dynamics",
        "static_torque",
        "joint_wrenches",
    ),
    "freebody.any_chain.reactions": ("reactions",),
    "freebody.trees.operational_space": (
        "operational_space_inertia",
        "operational_space_bias",
    ),
    "freebody.trees.regressors": (
        "regressor",
        "energy_regressor",
        "inertial_parameters",
        "forward_dynamics_parameter_derivatives",
    ),
    "freebody.trees.controllers": (
        "pd_gravity",
        "computed_torque",
        "operational_space_control",
        "impedance",
        "admittance",
        "momentum_observer",
    ),
    "freebody.trees.linearization_and_lqr": ("linearize", "discrete_lqr"),
    "freebody.trees.base_parameters": ("base_parameters",),
    "freebody.trees.positions": (
        "neutral",
        "random_state",
        "integrate",
        "difference",
        "quat_wxyz",
        "rotation",
    ),
    "freebody.loops.assembly": ("assemble", "assembly_modes"),
    "freebody.loops.rates": ("loop_velocity", "loop_acceleration"),
    "freebody.loops.mobility": ("mobility",),
    "freebody.loops.input_output": ("input_output",),
    "freebody.loops.singularity_loci": ("singularity_loci",),
    "freebody.inverse.inverse_kinematics": ("inverse_kinematics",),
    "freebody.inverse.inverse_rates": ("inverse_velocity", "inverse_acceleration"),
    "freebody.inverse.singularities": ("singularities",),
    "freebody.reach.dexterity": ("dexterity",),
    "freebody.reach.ellipsoids": ("ellipsoids",),
    "freebody.reach.payload_map": ("payload_map",),
    "freebody.reach.deflection": ("deflection",),
    "freebody.reach.natural_frequencies": ("natural_frequencies",),
    "freebody.reach.workspace": ("workspace",),
    "freebody.ways_out.kernel": ("kernel", "formula"),
    "freebody.ways_out.exports": ("export", "source"),
    "freebody.ways_out.fmus": ("export_fmu",),
    "freebody.ways_out.in_jax": ("to_jax",),
    "freebody.ways_out.in_torch": ("to_torch",),
    "freebody.kernels.own_functions": ("compile",),
    "freebody_textbook.equations.equations": ("equations",),
    "freebody_textbook.closed_chains.loop_equations": ("loop_equations",),
    "freebody_textbook.derive": ("derive",),
    "freebody_textbook.check.check": ("check",),
    "freebody_textbook.check.spelling.answer_text": ("AnswerError",),
    "freebody_textbook.relations.quantities": ("quantities",),
    "freebody_textbook.relations.relation": ("relation",),
    "freebody_textbook.relations.functions": (
        "sampled_trajectory",
        "trajectory",
        "vector_function",
    ),
    "freebody.motion.motion": ("Motion",),
    "freebody.motion.files.measured_motions": ("smoothed",),
    "freebody.motion.default_motion": ("default_motion",),
    "freebody.motion.files.csv_files": ("read_motion", "read_waypoints", "write_motion"),
    "freebody.motion.planning.point_to_point": ("quintic", "trapezoid", "s_curve", "dwell"),
    "freebody.motion.planning.splines": ("spline",),
    "freebody.motion.planning.tip_motions": ("line", "arc", "blend"),
    "freebody.motion.planning.planning_limits": ("exceeded_limits",),
    "freebody.motion.simulation.simulate": ("simulate",),
    "freebody.motion.optimal.time_optimal": ("time_optimal",),
    "freebody.identification.logs.read_log": ("read_log",),
    "freebody.identification.logs.log": ("Log",),
    "freebody.identification.identify": ("identify",),
    "freebody.identification.identification": ("Identification",),
    "freebody.identification.identify_payload": ("identify_payload",),
    "freebody.identification.identified_payload": ("IdentifiedPayload",),
    "freebody.identification.collisions": ("DetectedCollisions", "detect_collisions"),
    "freebody.identification.calibration.calibrate": ("calibrate",),
    "freebody.identification.calibration.calibration": ("Calibration",),
    "freebody.identification.calibration.poses": ("Poses",),
    "freebody.identification.calibration.read_poses": ("read_poses",),
    "freebody.identification.excitation.excitation": ("Excitation", "excitation"),
    "freebody.design.data_sheets": ("mean_load",),
    "freebody.design.parts": ("Motor", "Gear", "Bearing"),
    "freebody.design.catalogue": ("PartCatalogue", "catalogue"),
    "freebody.design.duty_cycle": ("DutyCycle", "Segment"),
    "freebody.design.drive_loads": ("drive_loads",),
    "freebody.design.size": ("size",),
    "freebody.design.bearings": ("bearing_loads",),
    "freebody.design.load_tables": ("floor_loads", "load_table"),
    "freebody.design.stops": ("emergency_stops",),
    "freebody.sweeps.samples": ("samples",),
    "freebody.sweeps.sweep": ("sweep",),
    "freebody.figures.free_body": ("free_body_diagram",),
    "freebody.figures.loci": ("singularity_diagram",),
    "freebody.figures.kinematic": ("kinematic_diagram",),
    "freebody.figures.ellipsoid_diagram": ("ellipsoid_diagram",),
    "freebody.figures.map_diagram": ("map_diagram",),
    "freebody_notes.figures.catalogue": ("notes_figure",),
    "freebody.report.study": ("Study", "study"),
    "freebody.report.cycle_study": ("CycleStudy",),
    "freebody.report.comparison": ("StudyComparison", "compare"),
    "freebody.capacity.payload": ("payload",),
    "freebody.capacity.load_diagram": ("load_diagram",),
}
_QUICK = tuple(
    f"freebody.{name}"
    for name in (
        "trees.kinematics",
        "any_chain.dynamics",
        "trees.dynamics",
        "trees.operational_space",
        "trees.regressors",
        "trees.controllers",
        "trees.positions",
        "inverse.inverse_rates",
    )
)
"""Their functions look themselves whether they are given a model: a call through another would cost
too much, or warnings would point at it."""

_PLACE_OF = {name: place for place, names in _PLACES.items() for name in names}
__all__ = [*_PLACE_OF, "math", "__version__"]


class _Math(ModuleType):
    """The module `freebody.math`, filled from `scalar_math.py` when one of its names is first used.

    That file has another name because a math.py would hide the standard library's from a Python
    that is started in its folder.
    """

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__") and name != "__all__":  # what tools ask of every module
            raise AttributeError(f"module {self.__name__!r} has no attribute {name!r}")
        functions = imported("freebody.scalar_math")
        own = ("__name__", "__spec__", "__loader__", "__package__")
        vars(self).update({key: x for key, x in vars(functions).items() if key not in own})
        if name not in vars(self):
            raise AttributeError(f"module {self.__name__!r} has no attribute {name!r}")
        return vars(self)[name]

    def __dir__(self) -> list[str]:
        return sorted(imported("freebody.scalar_math").__all__)


math = sys.modules["freebody.math"] = _Math("freebody.math")
math.__spec__ = type(__spec__)("freebody.math", None)


def __getattr__(name: str) -> Any:
    if name not in _PLACE_OF:
        raise AttributeError(f"module 'freebody' has no attribute {name!r}")
    try:
        place = imported(_PLACE_OF[name])
    except ModuleNotFoundError as failure:
        raise _not_found(name, failure) from None
    value = getattr(place, name)
    code = getattr(value, "__code__", None)
    if code is not None and code.co_varnames[:1] == ("model",) and _PLACE_OF[name] not in _QUICK:
        value = imported("freebody.model.model_argument").takes_model(name, value)
    globals()[name] = value
    return value


def _not_found(name: str, failure: ModuleNotFoundError) -> ImportError:
    """The error to raise where a name's module cannot be imported."""
    package = _PLACE_OF[name].partition(".")[0]
    if failure.name != package:
        return failure
    return imported("freebody.errors").MissingPackageError(f"fb.{name}", package)


def __dir__() -> list[str]:
    return sorted(__all__)
