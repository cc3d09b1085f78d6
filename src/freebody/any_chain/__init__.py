"""Dynamics of any chain: the one place that chooses between open chains (`trees`) and closed ones
(`loops`)."""
