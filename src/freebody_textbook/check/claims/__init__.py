"""The claims of an answer: its equations, with names and definitions of its own."""
