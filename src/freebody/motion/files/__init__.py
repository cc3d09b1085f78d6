"""Motions in files and tables, and what measured ones need."""
