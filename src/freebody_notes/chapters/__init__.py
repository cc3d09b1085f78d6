"""The items of the lecture notes, by section; each file exports ITEMS."""
