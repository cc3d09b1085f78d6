"""Expressions: the nodes of a tree, what builds them, what they are worth, how names print."""
