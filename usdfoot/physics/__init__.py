"""Motion from footprints without clips: the centre of mass optimised over the support of the feet ([P])."""
