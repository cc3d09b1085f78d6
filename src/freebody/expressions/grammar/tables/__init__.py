"""The language of formulas as plain literals: characters, commands, and the spellings that mean the
same."""
