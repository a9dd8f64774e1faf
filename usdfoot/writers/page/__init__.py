"""A crowd as one self-contained web page: arrays in, text out."""
