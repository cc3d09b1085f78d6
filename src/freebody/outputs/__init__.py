"""The room of all that leaves freebody: files that are whole or not there, and texts in which a
name is only a name."""
