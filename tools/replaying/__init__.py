"""Real clips replayed from their own footsteps."""
