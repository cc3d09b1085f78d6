"""Ways to the equations of motion, one file each."""
