"""The studio: a page in which one robot is moved by hand, and what it needs is seen at once."""
