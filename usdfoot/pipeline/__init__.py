"""Whole jobs, one file a verb: animate, analyze, validate, inspect, plan, lint, import, retarget."""
