"""From footsteps and weights to motion."""
