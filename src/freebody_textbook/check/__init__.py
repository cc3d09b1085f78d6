"""A user's own equations read, compared exactly with the right ones, and their mistakes named."""
