# ruff: noqa: E501 - a document is a line
"""Words around an equation, as homework and lecture notes have them; {} is its place."""

PROSE_MARKDOWN = (
    "# Problem 3\n\nWe take the robot of the figure; gravity acts along $-y$.\n\n$$ {} $$\n\nThis is what was asked for.\n",
    "The x-axis points to the right, where $l_1$ is the length of the first link.\n\n$${}$$\n",
    "**Solution.** With $\\theta_1$ measured from the horizontal ($x$-axis), we find\n\n$$\n{}\n$$\n\nas claimed.\n",
    "Inserting this gives ${}$, which is the result. Positive angles are counterclockwise ($+z$).\n",
    "- Given: the masses $m_i$ and the lengths $l_i$.\n- Result: ${}$.\n",
    "We choose $q$ as coordinates and let $g = 9.81\\,\\mathrm{{m/s^2}}$ act downwards ($-y$). Then\n\n$$ {} \\qquad (1) $$\n",
)
PROSE_LATEX = (
    "\\documentclass{{article}}\n\\begin{{document}}\n\\section{{Dynamics}}\nGravity acts along $-y$; the $x$-axis is horizontal.\n\\begin{{equation}}\n{}\n\\label{{eq:a}}\n\\end{{equation}}\nwhere $l_1$ is the length of the first link.\n\\end{{document}}\n",
    "Let $\\theta_i$ be the joint angles. From the figure we read\n\\[\n{}.\n\\]\nHence the claim follows by (\\ref{{eq:a}}).\n",
    "\\begin{{align*}}\n{}\n\\end{{align*}}\nin which all angles are in radians.\n",
    "Therefore, ${}$, where $g$ is the acceleration of gravity along the negative $y$ axis.\n",
)
PROSE_TEXT = (
    "Problem 2. The robot is in a vertical plane, gravity along -y.\n\n{}\n\nwhere l1 is the length of link 1.\n",
    "We get\n    {}\nas in the book.\n",
    "Result:\n{}   # checked by hand\n",
)
