"""Whether a claim is correct, and the sentences about it."""
