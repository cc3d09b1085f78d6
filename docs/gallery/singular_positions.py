"""Where a five-bar is singular: curves of the first type, where it loses a motion, and of the
second, where its motors lose their hold."""

import freebody as fb

fb.singularity_diagram(fb.load("five_bar")).save("singular_positions.svg")
