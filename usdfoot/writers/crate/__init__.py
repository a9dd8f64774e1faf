"""Layers in USD's binary format as bytes, where USD's Python takes values one by one, or reads all to write them."""
