"""Exact polynomials in a model's symbols, and ways to the form in which a book prints them."""
