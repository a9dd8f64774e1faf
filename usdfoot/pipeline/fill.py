"""Fill: synthetic clips for the landings that the clips of one skeleton do not show."""

from __future__ import annotations

from pathlib import PurePosixPath

from usdfoot.engine.animate import prepare_library
from usdfoot.errors import ClipError
from usdfoot.model.clip import ClipLibrary
from usdfoot.physics.fill import FilledLibrary, fill_library
from usdfoot.physics.motion_options import MotionOptions
from usdfoot.planning.reach import reach_of_biped
from usdfoot.spaces.holes import HoleOptions

__all__ = ["fill_holes"]


def fill_holes(library: ClipLibrary, holes: HoleOptions, *, first: int = 0) -> FilledLibrary:
    """A library with steps of physics where its legs reach and no clip steps; none if there is no usable step.

    Args:
        library: Of one skeleton.
        holes: What a hole is.
        first: Number of the first synthetic clip, which is named beside the first of the library.
    """
    options = MotionOptions()
    try:
        prepared = prepare_library(library, options)
    except ClipError:
        return FilledLibrary(source=library, holes=(), clips=(), problems=())
    outline = reach_of_biped(library.biped).outline
    name = str(PurePosixPath(library.clips[0].name).with_name("synthetic_"))
    return fill_library(prepared, outline, name=name, first=first, holes=holes, options=options)
