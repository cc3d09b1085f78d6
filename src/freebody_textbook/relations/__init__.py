"""Users' formulas of named quantities: parsing, evaluation, comparison."""
