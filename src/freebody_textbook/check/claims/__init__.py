"""The claims of an answer: its equations, with the names it defines."""
