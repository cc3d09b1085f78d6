"""What an answer claims: its equations, with names and definitions of its own."""
