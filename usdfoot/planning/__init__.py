"""Where footsteps come from: stepping stones, wandering, crowds."""
