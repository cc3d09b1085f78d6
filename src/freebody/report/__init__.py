"""The study of a robot as data, as files and as a page."""
