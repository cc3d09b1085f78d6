"""The items, by section; each file exports ITEMS."""
