"""How courses and books write: letters, angles, parameters given by formulas. A file each."""
