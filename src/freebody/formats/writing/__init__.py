"""Writers of models as text, a file for each format."""
