"""The nouns: frozen dataclasses of arrays in canonical space (metres, seconds, radians, +Y up, xyzw)."""
