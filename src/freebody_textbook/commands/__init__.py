"""Commands of the program `freebody` that are about equations."""
