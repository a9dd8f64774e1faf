"""Batch: a crowd in chunks, by any number of workers, done again only where something changed."""
