"""What the language of formulas consists of, as plain literals: characters, commands, and the
spellings that mean the same."""
