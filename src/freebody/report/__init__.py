"""The study of a robot: as data, as files, as a page."""
