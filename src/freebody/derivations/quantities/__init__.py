"""The quantities of a robot, tables of rows: kinds with letters, units and words, and those of
bodies with their values."""
