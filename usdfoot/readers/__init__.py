"""Stage in, arrays out: scenes, clips, bipeds, plans and terrain in canonical space."""
