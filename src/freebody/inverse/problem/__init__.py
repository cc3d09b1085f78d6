"""Problems of inverse kinematics as data: task, solver, closed form, and solutions found."""
