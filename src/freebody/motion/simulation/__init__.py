"""Motions that torques cause; the files in the order in which a call goes through them.

`simulate`: the public function, and the choice of a method.
`arguments`: its arguments as data, checked, and its progress.
`torques`: torques, forces and wrenches as they are given.

`one_by_one`: a few motions, one after another, by scipy's integrators.
`schedules`: when the torque of such a motion jumps or bends.
`first_order_system`: its differential equations, and the integrator that suits them.

`side_by_side`: many motions by steps, all at once.
`step_sizes`: from time to time by equal steps, or by steps that each motion chooses.
`one_step`: one step of all, by a kernel or by a torque's Python function.
`step_kernels`: the kernels of such steps.
`lanes`: the motions side by side, and what drives each over a step.

`joint_contacts`: which joints friction and stops hold.
`contact_events`: when that changes within a step.
`unending`: runs to give up.
`results`: the states, runs that end early, and the quantities of the dataset.
"""
