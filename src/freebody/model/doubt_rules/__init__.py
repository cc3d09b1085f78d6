"""Rules by which the numbers of a model are doubted, a file for each kind of numbers."""
