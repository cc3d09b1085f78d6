"""Simulated motions, which torques cause; the files are in the order in which a call goes through
them.

`simulate`: the public function, and the choice of a method.
`arguments`: what it is given, checked.
`run`: a simulation as data, which is what all that follows is about.

`one_by_one`: a few motions, one after another, by scipy's integrators.
`first_order_system`: their differential equations, and the integrator that suits them.

`side_by_side`: many motions by steps, all at once.
`step_sizes`: from time to time by equal steps, or by steps that each motion chooses.
`one_step`: one step of all, and what drives each motion over it.
`step_kernels`: the kernels of such steps.

`joint_contacts`: which joints friction and stops hold.
`contact_events`: when that changes within a step.
`stiffness`: steps that stability keeps short.
`unending`: runs to give up.
`results`: the states, runs that end early, and the quantities of the dataset.
"""
