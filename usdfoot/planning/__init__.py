"""Planning: where footsteps come from. Everything here gives `FootstepPlan`s and sees arrays only."""
