"""Written by tools/stub.py from the table in __init__.py: what type checkers read of it."""

from . import math as math
from freebody.any_chain.dynamics import forward_dynamics as forward_dynamics
from freebody.any_chain.dynamics import inverse_dynamics as inverse_dynamics
from freebody.any_chain.dynamics import joint_wrenches as joint_wrenches
from freebody.any_chain.dynamics import static_torque as static_torque
from freebody.any_chain.reactions import reactions as reactions
from freebody.errors import FreebodyError as FreebodyError
from freebody.errors import FreebodyWarning as FreebodyWarning
from freebody.errors import LoopError as LoopError
from freebody.errors import MassWarning as MassWarning
from freebody.errors import PassiveJointError as PassiveJointError
from freebody.errors import PhysicalWarning as PhysicalWarning
from freebody.figures.ellipsoid_diagram import ellipsoid_diagram as ellipsoid_diagram
from freebody.figures.free_body import free_body_diagram as free_body_diagram
from freebody.figures.kinematic import kinematic_diagram as kinematic_diagram
from freebody.figures.loci import singularity_diagram as singularity_diagram
from freebody.figures.map_diagram import map_diagram as map_diagram
from freebody.formats.loading import load as load
from freebody.formats.saving import save as save
from freebody.inverse.kinematics import inverse_kinematics as inverse_kinematics
from freebody.inverse.rates import inverse_acceleration as inverse_acceleration
from freebody.inverse.rates import inverse_velocity as inverse_velocity
from freebody.inverse.singularities import singularities as singularities
from freebody.kernels.own_functions import compile as compile
from freebody.loops.assembly import assemble as assemble
from freebody.loops.assembly import assembly_modes as assembly_modes
from freebody.loops.input_output import input_output as input_output
from freebody.loops.mobility import mobility as mobility
from freebody.loops.rates import loop_acceleration as loop_acceleration
from freebody.loops.rates import loop_velocity as loop_velocity
from freebody.loops.singularity_loci import singularity_loci as singularity_loci
from freebody.model.description import Drive as Drive
from freebody.model.description import Limits as Limits
from freebody.model.dh import dh as dh
from freebody.model.inertia import Inertia as Inertia
from freebody.model.integrated_inertia import inertia_from as inertia_from
from freebody.model.integrated_inertia import integrated_inertia as integrated_inertia
from freebody.model.model import Model as Model
from freebody.model.named_numbers import parameters as parameters
from freebody.model.parameters import Parameter as Parameter
from freebody.model.planar_arms import planar as planar
from freebody.motion.default_motion import default_motion as default_motion
from freebody.motion.files.csv_files import read_motion as read_motion
from freebody.motion.files.csv_files import read_waypoints as read_waypoints
from freebody.motion.files.csv_files import write_motion as write_motion
from freebody.motion.files.measured_motions import smoothed as smoothed
from freebody.motion.motion import Motion as Motion
from freebody.motion.optimal.time_optimal import time_optimal as time_optimal
from freebody.motion.planning.planning_limits import exceeded_limits as exceeded_limits
from freebody.motion.planning.point_to_point import dwell as dwell
from freebody.motion.planning.point_to_point import quintic as quintic
from freebody.motion.planning.point_to_point import s_curve as s_curve
from freebody.motion.planning.point_to_point import trapezoid as trapezoid
from freebody.motion.planning.splines import spline as spline
from freebody.motion.planning.tip_motions import arc as arc
from freebody.motion.planning.tip_motions import blend as blend
from freebody.motion.planning.tip_motions import line as line
from freebody.motion.simulation.simulate import simulate as simulate
from freebody.reach.dexterity import dexterity as dexterity
from freebody.reach.ellipsoids import ellipsoids as ellipsoids
from freebody.reach.payload_map import payload_map as payload_map
from freebody.reach.workspace import workspace as workspace
from freebody.report.study import Study as Study
from freebody.report.study import study as study
from freebody.robots import models as models
from freebody.sweeps.samples import samples as samples
from freebody.sweeps.sweep import sweep as sweep
from freebody.trees.base_parameters import base_parameters as base_parameters
from freebody.trees.controllers import admittance as admittance
from freebody.trees.controllers import computed_torque as computed_torque
from freebody.trees.controllers import impedance as impedance
from freebody.trees.controllers import momentum_observer as momentum_observer
from freebody.trees.controllers import operational_space_control as operational_space_control
from freebody.trees.controllers import pd_gravity as pd_gravity
from freebody.trees.dynamics import bias as bias
from freebody.trees.dynamics import coriolis_matrix as coriolis_matrix
from freebody.trees.dynamics import forward_dynamics_derivatives as forward_dynamics_derivatives
from freebody.trees.dynamics import gravity_torque as gravity_torque
from freebody.trees.dynamics import inverse_dynamics_derivatives as inverse_dynamics_derivatives
from freebody.trees.dynamics import (
    inverse_dynamics_second_derivatives as inverse_dynamics_second_derivatives,
)
from freebody.trees.dynamics import kinetic_energy as kinetic_energy
from freebody.trees.dynamics import mass_matrix as mass_matrix
from freebody.trees.dynamics import momentum as momentum
from freebody.trees.dynamics import potential_energy as potential_energy
from freebody.trees.dynamics import tip_wrench as tip_wrench
from freebody.trees.kinematics import acceleration as acceleration
from freebody.trees.kinematics import center_of_mass as center_of_mass
from freebody.trees.kinematics import forward_kinematics as forward_kinematics
from freebody.trees.kinematics import jacobian as jacobian
from freebody.trees.kinematics import jacobian_derivatives as jacobian_derivatives
from freebody.trees.kinematics import jacobian_dot as jacobian_dot
from freebody.trees.kinematics import velocity as velocity
from freebody.trees.linearization import discrete_lqr as discrete_lqr
from freebody.trees.linearization import linearize as linearize
from freebody.trees.operational_space import (
    centroidal_momentum_matrix as centroidal_momentum_matrix,
)
from freebody.trees.operational_space import energy_regressor as energy_regressor
from freebody.trees.operational_space import (
    forward_dynamics_parameter_derivatives as forward_dynamics_parameter_derivatives,
)
from freebody.trees.operational_space import inertial_parameters as inertial_parameters
from freebody.trees.operational_space import mass_matrix_inverse as mass_matrix_inverse
from freebody.trees.operational_space import operational_space_bias as operational_space_bias
from freebody.trees.operational_space import operational_space_inertia as operational_space_inertia
from freebody.trees.operational_space import regressor as regressor
from freebody.trees.states import difference as difference
from freebody.trees.states import integrate as integrate
from freebody.trees.states import neutral as neutral
from freebody.trees.states import quat_wxyz as quat_wxyz
from freebody.trees.states import random_state as random_state
from freebody.trees.states import rotation as rotation
from freebody.ways_out.exports import export as export
from freebody.ways_out.exports import source as source
from freebody.ways_out.in_jax import to_jax as to_jax
from freebody.ways_out.in_torch import to_torch as to_torch
from freebody.ways_out.kernel import formula as formula
from freebody.ways_out.kernel import kernel as kernel
from freebody_notes.figures.catalogue import notes_figure as notes_figure
from freebody_textbook.check.check import check as check
from freebody_textbook.closed_chains.loops import loop_equations as loop_equations
from freebody_textbook.drawings.illustrate import derive as derive
from freebody_textbook.equations.equations import equations as equations
from freebody_textbook.relations.functions import sampled_trajectory as sampled_trajectory
from freebody_textbook.relations.functions import trajectory as trajectory
from freebody_textbook.relations.functions import vector_function as vector_function
from freebody_textbook.relations.quantities import quantities as quantities
from freebody_textbook.relations.relation import relation as relation

__version__: str
