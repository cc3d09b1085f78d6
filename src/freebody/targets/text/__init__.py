"""Programs as source text of other languages."""
