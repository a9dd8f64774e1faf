"""Where footsteps come from."""
