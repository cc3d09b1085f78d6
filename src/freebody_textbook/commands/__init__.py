"""Commands of the program `freebody` about equations."""
