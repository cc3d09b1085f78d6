"""Whether a claim is right, and what is said of it."""
