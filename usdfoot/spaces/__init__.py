"""Parametric spaces: examples, their points and ways to weight them."""
