"""Everything that leaves freebody: files that are either complete or absent, and texts in which a
name is only a name."""
