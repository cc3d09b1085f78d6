"""The figures of the lecture notes, each drawn from a model and its state: `notes_figure("3.2")` in
`catalogue`.

Source: S. Bai, Dynamics of robotic manipulators, lecture notes, Aalborg University, 2019.
"""
