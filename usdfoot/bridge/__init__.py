"""The edge between USD and arrays: names, units, axes, schemas."""
