"""Real time: footsteps or velocities as they come, poses of many agents by the frame ([B] 6)."""
