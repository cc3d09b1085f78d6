"""Files to models and back: one module for each format; `loading` chooses by suffix."""
