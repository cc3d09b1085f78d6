"""What is common to quantities: their kinds with letters, units and words, and the symbols of links."""
