"""A figure of the lecture notes, drawn from a model: a two-link arm, its velocities,
its free bodies."""

import freebody as fb

fb.notes_figure("3.2").save("lecture_figure.svg")
