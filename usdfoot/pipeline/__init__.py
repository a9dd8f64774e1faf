"""Whole jobs: animate, analyze, validate."""
