"""The dynamics of trees, each algorithm once, over any scalar.

An algorithm takes a `Tree` and tuples of scalars and branches on structure only (joint kinds, who
hangs on whom), never on values; so the same text yields numbers, traced programs and closed forms.
Nothing here knows which scalar it runs on.
"""
