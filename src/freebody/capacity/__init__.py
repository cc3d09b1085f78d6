"""What a robot carries: the largest payload along motions and over postures, and load diagrams."""
