"""A small software renderer of USD stages: skinned characters, terrain and footprints as shaded triangles."""
