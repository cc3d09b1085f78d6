"""What an arm can do where: maps over many postures."""
