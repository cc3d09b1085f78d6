"""Motions that torques cause.

The front: `simulate` (the public function, the choice of a method), `simulation` (its arguments as
data, checked), `torques` (torques, forces and wrenches that were given).

The middle, from one time to the next. Of one motion: `one_by_one` (scipy's integrators),
`schedules` (where its torque jumps), `first_order_system` (the equations). Of many: `stepped` (all
at once), `steps` (from time to time), `steppers` (one step), `lanes` (what a step takes). Events:
`joint_contacts` (what friction and stops hold), `contact_events` (when that changes), `unending`
(runs to give up).

The back: `results` (states, early ends, and the quantities of the dataset).
"""
