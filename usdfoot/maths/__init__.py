"""Rotations, planar transforms and smooth functions on numpy arrays; knows nothing of characters."""
