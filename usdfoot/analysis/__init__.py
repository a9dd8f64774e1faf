"""What clips contain: contacts, steps, root motion, mirror images."""
