"""What a name, a line and a formula of an answer mean."""
