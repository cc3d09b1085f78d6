"""The tables of the language of formulas as plain literals: characters, commands, and spellings
that mean the same."""
