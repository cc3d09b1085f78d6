"""The grammar of formulas that people write: text to tokens to trees; languages are options."""
