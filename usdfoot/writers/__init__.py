"""USD out: one layer per concern, written atomically."""
