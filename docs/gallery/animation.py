"""A motion as one SVG image that moves without script, wherever an image can stand."""

import freebody as fb

fb.study(fb.load("five_bar")).figure("animation").save("animation.svg")
