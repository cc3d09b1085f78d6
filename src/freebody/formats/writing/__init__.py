"""Models as text of each format that is written, a file each."""
