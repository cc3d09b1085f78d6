"""How formulas are spelled in answers, brought to one spelling."""
