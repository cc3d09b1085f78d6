"""The abilities of an arm from place to place: maps over many postures."""
