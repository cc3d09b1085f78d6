"""What can be asked: each file one group of quantities with their names and right values."""
